"""What walls cost, and what they let through."""

from ...residuals import WallPieces
from .base import metric

BESIDE_THE_STEP = ("gauges", "snapshots", "output", "log")
AT_WALLS = ("ghosts", "barrier", "markers")  # phases of a step
ROUNDING = 1e-6  # spacings: a particle that was stopped at a wall is not behind it


@metric("wall-cost", "-")
def wall_cost(results, references):
    """Share of a step spent on ghosts, barrier and markers; 0 for mirror walls: their images are made in "arrange"."""
    phases = results.summary["phases [s]"]
    return sum(_mean_time(phases, name) for name in AT_WALLS) / _step_time(results.summary)


@metric("step-cost", "µs")
def step_cost(results, references):
    """CPU time per particle and step, without gauges and output."""
    summary = results.summary
    return 1e6 * work(results, references) / (summary["particles"] * max(summary["steps"], 1))


@metric("work", "CPU s")
def work(results, references):
    """CPU time of all steps, without gauges and output."""
    summary = results.summary
    return summary["cpu [s]"] * _step_time(summary) / summary["wall [s]"]


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


@metric("leaks", "")
def leaks(results, references):
    """How many particles are behind a wall at the end."""
    return float(behind(results))


def behind(results, numbers=(-1,)):
    """Return the largest number of particles behind a wall in any of these snapshots."""
    pieces, dim = WallPieces(results.scene), len(results.scene["domain"]["size"])
    limit, found = -ROUNDING * results.scene["numerics"]["dx"], 0
    for number in numbers:
        shot = results.snapshot(number)
        pieces.move(shot["time"])
        found = max(found, int((pieces.distances(shot["position"][:, :dim]) < limit).sum()))
    return found
