"""Run-up: how far up a wall the water reaches.

Along the wall's line the volume fraction ``sum_b m_b/rho_b W(x - x_b)`` of the fluid alone is one half deep under water and
zero where it is dry. Where a flat surface meets the wall, water fills the angle theta between the two, so there the fraction
is ``theta / (2 pi)``, whatever the kernel: one quarter at a vertical wall, 1/20 on a slope of 1:3. A point of the wall is wet
where the fraction is at least that. One fixed fraction cannot serve all walls: by one quarter still water on a slope of 1:3
would end more than two spacings too early.

How far off readings are, in spacings of height: water that fills its tip, 0.1; still water of particles, which leave the tip
empty where it is thinner than they are, 0.1 to 0.35 too low on slopes, right on vertical walls. A sheet of one or two layers
that runs up a slope of 1:3 reads 0.3 too high; on a vertical wall 0.1 to 0.8 too low, and one layer alone is sure to
be wet there for h up to 2 dx.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...jit import jit
from ...kernels import kernel_value
from .base import Gauge, fluid_near, reach_of

FLATTEST, STEEPEST = 0.02, 0.35  # fractions, of slopes of 1:8 and of overhangs by 36 degrees: what noise would hide or make up
JOINED = 1.01  # of half the lengths of two neighbours: further apart they are, and something stands between them


@dataclass(frozen=True)
class Ascent:
    """A way up a wall, from its lowest point to its crest, with nothing of other walls in between.

    Attributes
    ----------
    points, normals : ndarray, shape (n, 2)
        [m]; normals into the fluid.
    mark : float
        Where among the points, from 0, still water meets the wall at rest; 0, its lowest point, where the wall stands dry.
    """

    points: np.ndarray
    normals: np.ndarray
    mark: float

    @property
    def x(self):
        """Where still water meets the wall [m]."""
        return float(_at(self.mark, self.points[:, 0]))


def ascents(points, normals, lengths, level):
    """Return the `Ascent` of each place where still water meets a wall, from left to right.

    A wall that stands wholly above the level has one from each end of its lowest part; one that has no rising part there, or
    lies under water, has none.

    Parameters
    ----------
    points, normals, lengths : ndarray, shapes (n, 2), (n, 2), (n,)
        The wall in short pieces along its line: midpoints [m], normals into the fluid, lengths [m].
    level : float
        Still-water level [m].
    """
    z, count, found = points[:, 1], len(points), []
    after = np.roll(np.arange(count), -1)
    apart = np.linalg.norm(points[after] - points, axis=1)
    joined = apart < JOINED * 0.5 * (lengths + lengths[after])
    tolerance = 1e-3 * lengths.mean()

    def walk(start, way):
        """Rows from `start` on, as far as they are joined."""
        rows = (start + way * np.arange(count)) % count
        links = joined[rows] if way > 0 else joined[(rows - 1) % count]
        return rows[: count if links.all() else np.argmin(links) + 1]

    def upwards(rows):
        return rows[: np.argmax(z[rows] >= z[rows].max() - tolerance) + 1]

    def downwards(rows):
        return rows[: np.argmax(z[rows] <= z[rows].min() + tolerance) + 1]

    dry = z >= level
    if dry.all():
        lowest = z <= z.min() + tolerance
        for way in (1, -1):
            for start in np.flatnonzero(lowest & ~np.roll(lowest, -way)):
                rows = upwards(walk(start, way))
                if len(rows) > 1:
                    found.append(Ascent(points[rows], normals[rows], 0.0))
    else:
        for row in np.flatnonzero(joined & (dry != dry[after])):
            way = 1 if dry[after[row]] else -1
            under, above = (row, after[row]) if way > 0 else (after[row], row)
            below = downwards(walk(under, -way))[::-1]
            rows = np.concatenate([below, upwards(walk(above, way))])
            mark = len(below) - 1 + (level - z[under]) / (z[above] - z[under])
            found.append(Ascent(points[rows], normals[rows], float(mark)))
    return sorted(found, key=lambda ascent: ascent.x)


class RunupGauge(Gauge):
    """The shoreline on a wall: where the water ends that covers the wall without a gap, from below.

    Drops and spray above a stretch of the wall longer than h that is dry do not count; where the water begins only that far
    above the lowest point, or is gone, it is the lowest point of the wall that is recorded. A side of the domain whose foot is
    hidden behind a polygon wall reads that for ever: the polygon should have the side's line among its own.

    The columns are the height of the highest wet point, which lies above the shoreline where water runs over a crest; where
    the shoreline is; and how far that is along the wall from the point where still water meets it at rest, up the wall
    positive.

    Parameters
    ----------
    ascent : Ascent
        The wall at rest.
    motion : object or None
        What moves it: ``at(time)`` has ``place(points)`` and ``turn(normals, points)``.
    """

    columns = ("run-up z [m]", "shoreline x [m]", "distance [m]")

    def __init__(self, name, every, ascent, motion=None, folder=None):
        super().__init__(name, every, folder)
        self.ascent, self.motion = ascent, motion

    def measure(self, simulation):
        points, normals = self.ascent.points, self.ascent.normals
        if self.motion is not None:
            now = self.motion.at(simulation.time)
            points, normals = now.place(points), now.turn(normals, points)
        fractions = fractions_at(simulation, points)
        if simulation.communicator.rank:
            return ()
        needed = np.clip(np.arccos(np.clip(normals[:, 1], -1.0, 1.0)) / (2 * np.pi), FLATTEST, STEEPEST)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        place = shoreline(fractions - needed, along, simulation.sweep.h)
        x, z, distance = (_at(place, values) for values in (*points.T, along))
        return max(z, points[: int(place) + 1, 1].max()), x, distance - _at(self.ascent.mark, along)


def fractions_at(simulation, points):
    """Return ``sum_b m_b/rho_b W(x - x_b)`` over the fluid at `points`, shape (n, 2) [m], on rank 0; collective."""
    position, mass, density, first, last = fluid_near(simulation, points)
    if simulation.communicator.rank:
        return np.zeros(0)
    sweep = simulation.sweep
    scale = sweep.kernel.norms[sweep.dim - 1] / sweep.h**sweep.dim
    compiled = _compiled_fractions(sweep.kernel.code)
    numbers = sweep.h, reach_of(simulation)
    return compiled(np.ascontiguousarray(points), first, last, position, mass / density * scale, *numbers)


@lru_cache
def _compiled_fractions(kernel):
    """Return what sums up fractions at points with a kernel."""

    def fractions(points, first, last, position, weights, h, reach):
        found = np.zeros(len(points))
        for k in range(len(points)):
            for j in range(first[k], last[k]):
                r2 = 0.0
                for d in range(points.shape[1]):
                    apart = points[k, d] - position[j, d]
                    r2 += apart * apart
                if r2 < reach * reach:
                    found[k] += weights[j] * kernel_value(kernel, np.sqrt(r2) / h)
        return found

    return jit(fractions)


def shoreline(excess, along, gap):
    """Return where the water ends that begins at the lowest point of a wall, as a place among its points, from 0.

    Parameters
    ----------
    excess : ndarray, shape (n,)
        How much more than needed for a wet point the volume fraction is.
    along : ndarray, shape (n,)
        Way along the wall [m].
    gap : float
        Longest dry stretch with water above it that still belongs to the water below [m].
    """
    wet = np.flatnonzero(excess >= 0.0)
    stretches = np.diff(along[wet], prepend=along[0])
    connected = wet[: np.argmax(stretches > gap)] if (stretches > gap).any() else wet
    if not len(connected):
        return 0.0
    end = connected[-1]
    if end == len(along) - 1:
        return float(end)
    return end + excess[end] / (excess[end] - excess[end + 1])


def _at(place, values):
    """Return what `values`, shape (n,), are at a place between them, from 0."""
    return np.interp(place, np.arange(len(values)), values)
