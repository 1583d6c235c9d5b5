"""What a metric is, and what metrics share."""

import math
from dataclasses import dataclass

import numpy as np

from ... import analysis
from ...errors import SceneError

PERIODS = 4  # so many at the end of a record count
FAR = 2  # depths from the wavemaker, where its near field has died away
GAUGES = {"levels": "level", "energy": "energy", "pressures": "pressure", "runup": "runup"}


@dataclass(frozen=True)
class Metric:
    """A number of a row.

    Attributes
    ----------
    name, unit, description : str
    measure : callable
        ``measure(results, {role: results})`` returns the number.
    roles : tuple of str
        What it compares with; rows without such references have no value.
    needs : str
        What the scene must have: "", "waves" (a wavemaker and three level gauges), "levels", "energy", "pressures", "runup",
        "profile" (1D shallow water with snapshots).
    """

    name: str
    unit: str
    description: str
    measure: object
    roles: tuple = ()
    needs: str = ""

    def check(self, scene):
        """Raise SceneError when a scene lacks what this metric needs."""
        kinds = [gauge.kind for gauge in scene.gauges]
        where = f"metric {self.name}"
        if self.needs == "waves" and scene.wave_period is None:
            raise SceneError("needs a wavemaker", where=where, why="its period is that of the waves", cure="another scene")
        if self.needs == "waves":
            places = [gauge.x for gauge in scene.gauges if gauge.kind == "level" and gauge.x >= FAR * scene.depth]
            period = scene.wave_period
            analysis.check_gauges(places, period, scene.depth, scene.domain.gravity)
            if scene.time.end < PERIODS * period:
                cure = f"time.end of at least {PERIODS * period:.3g} s"
                raise SceneError(f"needs {PERIODS} periods", where=where, why="the run is shorter", cure=cure)
        if self.needs in GAUGES and GAUGES[self.needs] not in kinds:
            raise SceneError(f"needs a gauge of {GAUGES[self.needs]}", where=where, cure="name one in the scene's gauges")
        if self.needs == "profile" and not scene.shallow:
            raise SceneError("is for shallow water", where=where, cure="a scene as swe-pulse")


METRICS = {}

# What every row says of its cost: column, key of the summary (None: a phase of it) and unit.
COSTS = {
    "particles": ("particles", ""),
    "steps": ("steps", ""),
    "evaluations": ("evaluations", ""),
    "cpu": ("cpu [s]", "s"),
    "wall": ("wall [s]", "s"),
    "damping": (None, "s"),
    "ranks": ("ranks", ""),
}


def metric(name, unit, roles=(), needs=""):
    """Register a function of (results, references) as the metric `name`; its docstring describes it."""

    def register(function):
        METRICS[name] = Metric(name, unit, function.__doc__.strip().split("\n")[0], function, roles, needs)
        return function

    return register


def energy_record(results):
    """Return the table of the first energy gauge."""
    return results.table(next(iter(results.gauges("energy"))))


def total_energy(results):
    """Return kinetic, potential and compressible energy together [J], shape (samples,), of the first energy gauge."""
    record = energy_record(results)
    return sum(record[f"{kind} energy [J]"] for kind in ("kinetic", "potential", "compressible"))


def rms(values):
    """Return the root mean square, NaN of no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else math.nan


def largest(values):
    """Return the largest magnitude, NaN of no values."""
    return float(np.abs(values).max()) if len(values) else math.nan
