"""Walls as lines of markers: points that push the fluid and take no part in its sums.

A marker has a place, a normal into the fluid, a size (the length of wall that it stands for, in 3D the area, in 1D one), and
the velocity and acceleration of the wall there. Markers may move independently of each other: walls may deform. Two things
act on the fluid within reach: the correction of the boundary deficiency (`deficiency`), in two passes, strengths from the
accelerations of the sweep and then what follows from them; and repulsion (`repulsion`). Every rank knows all markers; it works
out the strengths of those in its own columns and hands them to the ranks whose fluid they reach.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..columns import cells_per_column, strip_offset
from ..jit import jit
from ..kernels import kernel_value
from ..particles import FIRST_GHOST
from .deficiency import (
    JONES2010,
    LEAST_FILLED,
    MOMENTS,
    NEAREST,
    RELAXATION,
    jones_weight,
    outer_integral,
    outer_integrals,
    sample_weight,
)
from .repulsion import repulsion
from .shares import Part, Share

SAMPLE = 1.5  # particle spacings: how far around a marker particles count for its strength


@jit
def from_marker(rows, i, position, normal, j, away):
    """Write the way from marker `j` to row `i` to `away`, shape (dim,) [m]; return its square and its part along the normal."""
    r2, along = 0.0, 0.0
    for d in range(len(away)):
        away[d] = rows[i, d] - position[j, d]
        r2 += away[d] * away[d]
        along += away[d] * normal[j, d]
    return r2, along


@lru_cache
def compiled_sums(dim, kernel, weights):
    """Return the pass that sums over markers what strengths are measured by; numbers at run time."""

    def sum_markers(rows, tags, starts, table, markers, numbers, sums):
        """Write S_i and gamma_i, or the divisor of eq. (8), to `sums`, for the fluid in those cells."""
        cells, first, marker_of = table
        position, normal, size = markers
        h, norm, reach, tails = numbers
        away = np.empty(dim)
        for k in range(len(cells)):
            for i in range(starts[cells[k]], starts[cells[k] + 1]):
                if tags[i] >= FIRST_GHOST:
                    break
                sums[i, :] = 0.0
                nearest, least = -1, np.inf
                if weights == JONES2010:
                    for m in range(first[k], first[k + 1]):
                        r2, _ = from_marker(rows, i, position, normal, marker_of[m], away)
                        if r2 < least:
                            nearest, least = marker_of[m], r2
                for m in range(first[k], first[k + 1]):
                    j, alike = marker_of[m], 0.0
                    r2, along = from_marker(rows, i, position, normal, j, away)
                    if r2 >= reach * reach:
                        continue
                    if weights == JONES2010:
                        r = max(np.sqrt(r2), NEAREST * size[j])
                        for d in range(dim):
                            alike += normal[nearest, d] * normal[j, d]
                        sums[i, 0] += jones_weight(r, along / r, size[j], reach) * alike
                    else:
                        W = norm * kernel_value(kernel, np.sqrt(r2) / h)
                        for d in range(dim):
                            sums[i, d] += W * size[j] * normal[j, d]
                        r = max(np.sqrt(r2), NEAREST * size[j])
                        sums[i, dim] += norm * size[j] * along * outer_integral(tails, r / h) * (h / r) ** dim
                if weights != JONES2010:
                    sums[i, dim] = max(1.0 - sums[i, dim], LEAST_FILLED)

    return jit(sum_markers)


@lru_cache
def compiled_strengths(dim, kernel, weights):
    """Return the pass that sets the strengths of markers; numbers at run time."""
    strips = 3 ** (dim - 1)

    def set_strengths(rows, tags, starts, shape, chosen, cells, markers, wall, numbers, gravity, acceleration, sums, strength):
        """Write C_j of the markers `chosen`, in the local `cells`, from the accelerations of the fluid around them."""
        position, normal, _ = markers
        h, norm, sample2, relaxation = numbers
        stride = cells_per_column(shape)
        for k in range(len(chosen)):
            j = chosen[k]
            over, under = 0.0, 0.0
            for strip in range(strips):
                middle = cells[k] + strip_offset(strip, strips, stride, shape)
                for i in range(starts[middle - 1], starts[middle + 2]):
                    if tags[i] >= FIRST_GHOST:
                        continue
                    r2 = 0.0
                    for d in range(dim):
                        r2 += (rows[i, d] - position[j, d]) ** 2
                    counts = sample_weight(r2, sample2)
                    if counts == 0.0:
                        continue
                    if weights == JONES2010:
                        into = 0.0
                        for d in range(dim):
                            into += (acceleration[i, d] - wall[j, dim + d]) * normal[j, d]
                        over += counts * into / (norm * kernel_value(kernel, np.sqrt(r2) / h))
                        under += counts
                    else:
                        for d in range(dim):
                            lacking = sums[i, d] / sums[i, dim]
                            a = gravity[d] + (acceleration[i, d] - gravity[d]) / sums[i, dim] - wall[j, dim + d]
                            over += counts * (a + relaxation * (rows[i, dim + d] - wall[j, d])) * lacking
                            under += counts * lacking * lacking
            strength[j, 0] = min(over / under, 0.0) if under > 0.0 else 0.0

    return jit(set_strengths)


@lru_cache
def compiled_push(dim, kernel, weights, law):
    """Return the pass that adds what markers do to the accelerations of the fluid; numbers at run time."""

    def push(rows, tags, starts, table, markers, wall, numbers, gravity, sums, strength, acceleration, density_rate, summed):
        """Add correction (`weights` not 0) and repulsion (`law` not 0) for the fluid in the cells of `table`.

        Where densities are `summed`, `density_rate` holds them, and lacks no more than its share of the kernel.
        """
        cells, first, marker_of = table
        position, normal, size = markers
        h, norm, reach, strength_of_repulsion, reach_of_repulsion, spacing = numbers
        away = np.empty(dim)
        for k in range(len(cells)):
            for i in range(starts[cells[k]], starts[cells[k] + 1]):
                if tags[i] >= FIRST_GHOST:
                    break
                if weights == MOMENTS:
                    density_rate[i] /= sums[i, dim]
                    for d in range(dim):
                        acceleration[i, d] = gravity[d] + (acceleration[i, d] - gravity[d]) / sums[i, dim]
                for m in range(first[k], first[k + 1]):
                    j = marker_of[m]
                    r2, along = from_marker(rows, i, position, normal, j, away)
                    if r2 >= reach * reach:
                        continue
                    r = max(np.sqrt(r2), NEAREST * spacing)
                    if weights != 0:
                        W = norm * kernel_value(kernel, r / h)
                        if weights == JONES2010:
                            share = jones_weight(r, along / r, size[j], reach) / sums[i, 0] if sums[i, 0] > 0.0 else 0.0
                        else:
                            share = size[j] / sums[i, dim]
                            into = 0.0
                            for d in range(dim):
                                into += normal[j, d] * (rows[i, dim + d] - wall[j, d])
                            if not summed:
                                density_rate[i] -= rows[i, 2 * dim] * W * share * into
                        for d in range(dim):
                            acceleration[i, d] -= strength[j, 0] * W * share * normal[j, d]
                    if law != 0:
                        force = strength_of_repulsion * repulsion(law, r, reach_of_repulsion, spacing)
                        for d in range(dim):
                            acceleration[i, d] += force * away[d] / r

    return jit(push)


@dataclass(frozen=True)
class Line:
    """Markers that move together.

    Attributes
    ----------
    position, normal : ndarray, shape (n, dim)
        At rest [m]; into the fluid.
    size : ndarray, shape (n,)
        Length (area) of the wall that each stands for.
    motion : Swing, Bulge or None
    """

    position: np.ndarray
    normal: np.ndarray
    size: np.ndarray
    motion: object = None


class Markers:
    """All markers of a scene, and how they act.

    Parameters
    ----------
    lines : list of Line
    weights : Formula or None
        Of the correction of the boundary deficiency; None: no correction.
    repulsion : Formula
    kernel : Kernel
    h, dx : float
        Smoothing length and particle spacing [m].
    spacing : float
        Of the markers [m].
    push, push_reach : float
        Strength of the repulsion over beta^(dim-1) [m^2/s^2], and how far it reaches [m].
    gravity : tuple of float
        [m/s^2]
    c0 : float
        Sound speed [m/s].
    """

    def __init__(self, lines, weights, repulsion, kernel, h, dx, spacing, push, push_reach, gravity, c0):
        self.lines, self.weights, self.repulsion, self.kernel = lines, weights, repulsion, kernel
        self.h, self.dx, self.spacing, self.push, self.push_reach = h, dx, spacing, push, push_reach
        self.gravity, self._relaxation = gravity, RELAXATION * c0 / h
        self.position, self.normal, self.size = (
            np.concatenate([getattr(line, name) for line in lines]) for name in ("position", "normal", "size")
        )
        self.dim = self.position.shape[1]
        self.wall = np.zeros((len(self.size), 2 * self.dim))
        self.strength = np.zeros((len(self.size), 1))
        self.sums = np.zeros((0, self.dim + 1))
        self._tails = outer_integrals(kernel, self.dim)
        self._known = None
        ends = np.cumsum([0, *(len(line.size) for line in lines)])
        self.parts = [Part(slice(int(a), int(b)), line.motion) for a, b, line in zip(ends[:-1], ends[1:], lines, strict=True)]

    @property
    def count(self):
        """Number of markers."""
        return len(self.size)

    @property
    def moving(self):
        """Whether any of them moves."""
        return any(part.motion is not None for part in self.parts)

    def move(self, time):
        """Put the markers where they are at `time` [s]."""
        for part, line in zip(self.parts, self.lines, strict=True):
            if part.motion is None:
                continue
            rows, now = part.rows, part.motion.at(time)
            self.position[rows] = now.place(line.position)
            self.normal[rows] = now.turn(line.normal, line.position)
            self.size[rows] = line.size * now.stretch(line.position)
            self.wall[rows, : self.dim] = now.velocity(self.position[rows])
            self.wall[rows, self.dim :] = now.acceleration(self.position[rows])

    def distribute(self, grid, cuts, rank):
        """Work out which strengths this rank sets, who needs them, and which markers its cells and halos are near."""
        index = np.floor((self.position - np.array(grid.low)) / grid.cell).astype(np.int64)
        if self._known == (cuts, rank) and np.array_equal(index, self._index):
            return  # nobody has come to another cell
        self._grid, self._index, self._known = grid, index, (cuts, rank)
        self.share = Share(self.position, self.position, grid, cuts, rank)
        self._table = self._near_cells(index, cuts[rank], cuts[rank + 1])

    def _near_cells(self, index, first, last):
        """Return (local cells, where the markers of each begin, markers) of the columns ``first:last``, in rising order."""
        grid = self._grid
        near = np.flatnonzero((index[:, 0] >= first - 1) & (index[:, 0] <= last))
        cells, markers = [], []
        for shift in np.ndindex((3,) * self.dim):
            place = index[near] + np.array(shift) - 1
            inside = ((place >= 0) & (place < np.array(grid.shape))).all(axis=1)
            inside &= (place[:, 0] >= first) & (place[:, 0] < last)
            cells.append(np.ravel_multi_index(tuple(place[inside].T), grid.shape) - (first - 1) * grid.stride)
            markers.append(near[inside])
        cells, markers = np.concatenate(cells), np.concatenate(markers)
        order = np.lexsort((markers, cells))
        cells, begin = np.unique(cells[order], return_index=True)
        return cells, np.append(begin, len(order)), np.ascontiguousarray(markers[order])

    @property
    def _numbers(self):
        reach = self.kernel.support * self.h
        return self.h, self.kernel.norms[self.dim - 1] / self.h**self.dim, reach

    @property
    def _places(self):
        return self.position, self.normal, self.size

    def survey(self, particles, starts):
        """Sum up what the fluid of this slab lacks at the walls; the halos must be there."""
        p, code = particles, self.weights.code
        if len(self.sums) < len(p.tags):
            self.sums = np.zeros((len(p.tags), self.dim + 1))
        compiled_sums(self.dim, self.kernel.code, code)(
            p.shared,
            p.tags,
            starts,
            self._table,
            self._places,
            (*self._numbers, self._tails),
            self.sums,
        )

    def measure(self, particles, starts):
        """Set the strengths of the markers in this slab; accelerations and sums must be there, halos included."""
        p, code = particles, self.weights.code
        h, norm, _ = self._numbers
        compiled_strengths(self.dim, self.kernel.code, code)(
            p.shared,
            p.tags,
            starts,
            self._grid.shape,
            self.share.mine,
            self.share.cells,
            self._places,
            self.wall,
            (h, norm, (SAMPLE * self.dx) ** 2, self._relaxation),
            self.gravity,
            p.acceleration,
            self.sums,
            self.strength,
        )

    def act(self, particles, starts):
        """Add correction and repulsion to the accelerations of the fluid of this slab; all strengths in reach must be there."""
        p, code = particles, self.weights.code if self.weights else 0
        compiled_push(self.dim, self.kernel.code, code, self.repulsion.code)(
            p.shared,
            p.tags,
            starts,
            self._table,
            self._places,
            self.wall,
            (*self._numbers, self.push, self.push_reach, self.spacing),
            self.gravity,
            self.sums,
            self.strength,
            p.acceleration,
            p.density_rate,
            p.summed,
        )
