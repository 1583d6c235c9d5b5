"""Metrics: one number of a finished row, from its files and those of the rows that it is compared with."""

from dataclasses import dataclass

import numpy as np

from .. import analysis
from ..errors import SceneError

PERIODS = 4  # so many at the end of a record count
FAR = 2  # depths from the wavemaker, where its near field has died away
START_UP = 4  # periods before waves are compared: front, layer and back again


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
        What the scene must have: "", "waves" (a wavemaker and three level gauges), "levels", "energy", "profile" (1D shallow
        water with snapshots).
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
        if self.needs == "waves" and scene.wavemaker is None:
            raise SceneError("needs a wavemaker", where=where, why="its period is that of the waves", cure="another scene")
        if self.needs == "waves":
            places = [gauge.x for gauge in scene.gauges if gauge.kind == "level" and gauge.x >= FAR * scene.depth]
            period = scene.wavemaker.period
            analysis.check_gauges(places, period, scene.depth, scene.domain.gravity)
            if scene.time.end < PERIODS * period:
                cure = f"time.end of at least {PERIODS * period:.3g} s"
                raise SceneError(f"needs {PERIODS} periods", where=where, why="the run is shorter", cure=cure)
        if self.needs in ("levels", "energy") and {"levels": "level", "energy": "energy"}[self.needs] not in kinds:
            raise SceneError(f"needs a gauge of {self.needs}", where=where, cure="name one in the scene's gauges")
        if self.needs == "profile" and not scene.shallow:
            raise SceneError("is for shallow water", where=where, cure="a scene as swe-pulse")


METRICS = {}


def metric(name, unit, roles=(), needs=""):
    """Register a function of (results, references) as the metric `name`; its docstring describes it."""

    def register(function):
        METRICS[name] = Metric(name, unit, function.__doc__.strip().split("\n")[0], function, roles, needs)
        return function

    return register


@metric("reflection", "-", needs="waves")
def reflection(results, references):
    """Reflected over incident amplitude, last four periods, gauges two depths from the wavemaker and more (Mansard & Funke)."""
    return separated(results).coefficient


@metric("incident", "m", needs="waves")
def incident(results, references):
    """Incident amplitude, last four periods, gauges two depths from the wavemaker and more."""
    return separated(results).incident


def separated(results):
    """Return the `Separation` of a run, over its last four periods, from the gauges that are far from the wavemaker."""
    t, levels, x, _ = results.levels()
    depth, gravity = results.depth, results.scene["domain"]["gravity"]
    period = results.scene["wavemaker"]["period"]
    far = x >= FAR * depth
    return analysis.reflection(t, levels[far], x[far], period, depth, gravity, periods=PERIODS)


@metric("level-difference", "-", roles=("infinite",), needs="levels")
def level_difference(results, references):
    """L2 difference of all levels from the infinite run, over the L2 norm of its waves."""
    t, mine, _, _ = results.levels()
    times, theirs, _, _ = references["infinite"].levels()
    _same_times(t, times)
    return analysis.level_difference(t, mine, theirs)


def _same_times(mine, theirs):
    if not np.array_equal(mine, theirs):
        raise SceneError("the two runs have different times", where="gauges", cure="the same `every` and time.end for both")


@metric("energy-difference", "-", roles=("infinite",), needs="energy")
def energy_difference(results, references):
    """RMS difference of the kinetic energy from the infinite run after start-up, over its mean there."""
    difference, scale = _energies(results, references["infinite"])
    return float(np.sqrt(np.mean(difference**2)) / scale)


@metric("energy-excess", "-", roles=("infinite",), needs="energy")
def energy_excess(results, references):
    """Largest difference of the kinetic energy from the infinite run after start-up, over its mean there."""
    difference, scale = _energies(results, references["infinite"])
    return float(np.abs(difference).max() / scale)


def _energies(results, reference):
    """Return (difference of kinetic energies after start-up [J], mean of the reference [J]); impulses: the whole run, peak."""
    name = next(iter(results.gauges("energy")))
    mine, theirs = results.table(name), reference.table(name)
    t, energy = theirs["time [s]"], theirs["kinetic energy [J]"]
    _same_times(mine["time [s]"], t)
    difference = mine["kinetic energy [J]"] - energy
    maker = results.scene["wavemaker"]
    if maker is None or maker["motion"] == "single":
        return difference, energy.max()
    late = t > START_UP * maker["period"]
    return difference[late], energy[late].mean()


@metric("residual-energy", "-", needs="energy")
def residual_energy(results, references):
    """Kinetic energy at the end over its largest: what a single wave leaves behind."""
    energy = results.table(next(iter(results.gauges("energy"))))["kinetic energy [J]"]
    return float(energy[-1] / energy.max())


@metric("reflection-ratio", "-", roles=("infinite", "reflecting"), needs="profile")
def reflection_ratio(results, references):
    """Reflection ratio of shallow water, Molteni et al. eqs. (2.7), (2.8), at the end, over the reflecting run's basin."""
    window = 0.0, references["reflecting"].scene["domain"]["size"][0]
    runs = [run.profile() for run in (results, references["reflecting"], references["infinite"])]
    return analysis.reflection_ratio(*runs, results.scene["domain"]["gravity"], window)
