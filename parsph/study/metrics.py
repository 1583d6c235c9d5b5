"""Metrics: one number of a finished row, from its files and those of the rows that it is compared with."""

import math
from dataclasses import dataclass

import numpy as np

from .. import analysis
from ..errors import SceneError

PERIODS = 4  # so many at the end of a record count
FAR = 2  # depths from the wavemaker, where its near field has died away
START_UP = 4  # periods before waves are compared: front, layer and back again
EARLY, SETTLED = 1.0, 5.0  # [s]: the start of still water ends, and its echoes have died away
ARRIVED = 0.2  # of rho0 g H: the front of a dam break is there; Buchner's record has noise of 0.16 before it
PLATEAU = 0.2, 0.7  # [s] after its arrival, up to where the water falls back
GAUGES = {"levels": "level", "energy": "energy", "pressures": "pressure"}
BESIDE_THE_STEP = ("gauges", "snapshots", "output", "log")


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
        What the scene must have: "", "waves" (a wavemaker and three level gauges), "levels", "energy", "pressures", "profile"
        (1D shallow water with snapshots).
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
    energy = _energy_record(results)["kinetic energy [J]"]
    return float(energy[-1] / energy.max())


def _energy_record(results):
    """Return the table of the first energy gauge."""
    return results.table(next(iter(results.gauges("energy"))))


@metric("reflection-ratio", "-", roles=("infinite", "reflecting"), needs="profile")
def reflection_ratio(results, references):
    """Reflection ratio of shallow water, Molteni et al. eqs. (2.7), (2.8), at the end, over the reflecting run's basin."""
    window = 0.0, references["reflecting"].scene["domain"]["size"][0]
    runs = [run.profile() for run in (results, references["reflecting"], references["infinite"])]
    return analysis.reflection_ratio(*runs, results.scene["domain"]["gravity"], window)


@metric("probe-error", "%", needs="pressures")
def probe_error(results, references):
    """Still water: RMS error of all pressure gauges in it, over rho0 g H, after 5 s (half of a run under 10 s)."""
    return rms(_joined(probe_errors(results)))


@metric("probe-error-early", "%", needs="pressures")
def probe_error_early(results, references):
    """Still water: RMS error of all pressure gauges in it, over rho0 g H, in the first second."""
    return rms(_joined(probe_errors(results, early=True)))


@metric("probe-error-largest", "%", needs="pressures")
def probe_error_largest(results, references):
    """Still water: largest error of any pressure gauge in it, over rho0 g H, at the times of probe-error."""
    return largest(_joined(probe_errors(results)))


def probes(results):
    """Return the records of the pressure gauges that stand in the water at the beginning.

    Returns
    -------
    dict of str to tuple
        Gauge to (t [s], p, p of water at rest), pressures over rho0 g H: arrays of shape (samples,), and a float.
    """
    found, blocks = {}, results.scene["fluid"]["blocks"]
    for name, gauge in results.gauges("pressure").items():
        point = gauge["point"]
        corners = (zip(block["low"], point, block["high"], strict=True) for block in blocks)
        if any(all(low <= x <= high for low, x, high in corner) for corner in corners):
            found[name] = *_pressure_record(results, name), (results.level - point[-1]) / results.depth
    return found


def _pressure_record(results, name):
    """Return (t [s], p over rho0 g H) of a pressure gauge."""
    scene, table = results.scene, results.table(name)
    scale = scene["fluid"]["rho0"] * scene["domain"]["gravity"] * results.depth
    return table["time [s]"], table["pressure [Pa]"] / scale


def probe_errors(results, early=False):
    """Return {gauge: errors [% of rho0 g H]} of `probes`: once the water has settled, or in the first second."""
    settled = min(SETTLED, 0.5 * results.scene["time"]["end"])
    begin, end = (0.0, EARLY) if early else (settled, math.inf)
    return {name: 100.0 * (p - exact)[(t >= begin) & (t <= end)] for name, (t, p, exact) in probes(results).items()}


def _joined(errors):
    return np.concatenate([np.zeros(0), *errors.values()])


def rms(values):
    """Return the root mean square, NaN of no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else math.nan


def largest(values):
    """Return the largest magnitude, NaN of no values."""
    return float(np.abs(values).max()) if len(values) else math.nan


@metric("rest-energy", "-", needs="energy")
def rest_energy(results, references):
    """Kinetic over potential energy (from height 0) at the end."""
    record = _energy_record(results)
    return float(record["kinetic energy [J]"][-1] / record["potential energy [J]"][-1])


@metric("energy-growth", "-", needs="energy")
def energy_growth(results, references):
    """Largest rise of kinetic, potential and compressible energy together, over the potential energy at the beginning."""
    record = _energy_record(results)
    total = sum(record[f"{kind} energy [J]"] for kind in ("kinetic", "potential", "compressible"))
    return float((total - np.minimum.accumulate(total)).max() / record["potential energy [J]"][0])


@metric("plateau", "-", needs="pressures")
def plateau(results, references):
    """Dam break: mean of p/(rho0 g H) at the gauge P1, which begins dry, from 0.2 to 0.7 s after its arrival there."""
    record = impact(results)
    return math.nan if record is None else plateau_of(*record, arrival(*record))


def impact(results):
    """Return (t [s], p over rho0 g H) of the gauge P1, None where there is none or it begins in the water."""
    if "P1" not in results.gauges("pressure") or "P1" in probes(results):
        return None
    return _pressure_record(results, "P1")


def arrival(t, pressure):
    """Return when a front arrives [s]: when pressure/(rho0 g H) first exceeds 0.2; NaN where it never does."""
    there = pressure > ARRIVED
    return float(t[there][0]) if there.any() else math.nan


def plateau_of(t, pressure, arrived):
    """Return the mean of a pressure over time from 0.2 to 0.7 s after `arrived`, or to its end; NaN where there is none."""
    inside = (t >= arrived + PLATEAU[0]) & (t <= arrived + PLATEAU[1])
    return float(np.average(pressure[inside], weights=np.gradient(t)[inside])) if inside.any() else math.nan


@metric("wall-cost", "-")
def wall_cost(results, references):
    """Share of a step spent on polygon walls, ghosts and barrier; 0 for mirror walls: their images are made in "arrange"."""
    phases = results.summary["phases [s]"]
    return sum(_mean_time(phases, name) for name in ("ghosts", "barrier")) / _step_time(results.summary)


@metric("step-cost", "µs")
def step_cost(results, references):
    """CPU time per particle and step, without gauges and output."""
    summary = results.summary
    share = _step_time(summary) / summary["wall [s]"]
    return 1e6 * summary["cpu [s]"] * share / (summary["particles"] * max(summary["steps"], 1))


def _step_time(summary):
    """Return the time of all steps [s] in the mean over ranks: all of the run but what happens beside them."""
    return summary["wall [s]"] - sum(_mean_time(summary["phases [s]"], name) for name in BESIDE_THE_STEP)


def _mean_time(phases, name):
    return phases.get(name, (0.0, 0.0, 0.0))[1]


@metric("stopped", "-")
def stopped(results, references):
    """How many times a particle was stopped at the line of a polygon wall, in all of the run."""
    return float(_polygon_walls(results).get("stopped", 0))


@metric("fallbacks", "-")
def fallbacks(results, references):
    """Share of the mirror points in the water whose values came of another interpolation than that asked for."""
    methods = _polygon_walls(results).get("methods per evaluation", {})
    wet = sum(count for name, count in methods.items() if name != "dry")
    return 1.0 - methods.get(results.scene["walls"]["interpolation"], 0.0) / wet if wet else 0.0


def _polygon_walls(results):
    """Return what the summary says of polygon walls, nothing where there are none."""
    return results.summary.get("walls", {})
