"""Fixed ghost walls: particles that stand behind a wall and carry what a mirror point in the fluid says.

What a ghost at x_g with mirror point x_m carries (Marrone et al. 2011; Huang et al. 2019 section 2.2):

- ``p_g = p_m + rho_m (g - a_w) . (x_g - x_m)``, the density from the inverse state equation;
- free slip ``v_g = v_m - 2 [(v_m - v_w) . n] n``, through a corner point and for no slip ``v_g = 2 v_w - v_m``;
- its mass is its density times the volume it stands for;
- without fluid near its mirror point: p = 0, and the velocity of the wall.

v_w, a_w: velocity and acceleration of the wall where the ghost belongs. Every rank knows where all ghosts are; it
interpolates at the mirror points in its own columns and hands the values to the ranks in whose columns, halos included, the
ghosts stand.
"""

from dataclasses import dataclass

import numpy as np

from ..columns import cell_of
from ..jit import jit
from ..particles import FIRST_FIXED
from ..states import density_of
from .interpolation import DRY, INTERPOLATORS, compiled_interpolation
from .mirror import NO_SLIP


@jit
def stand(rows, tags, cells, end, chosen, position, grid):
    """Append the ghosts `chosen`, places alone, from row `end` on; return the new end.

    What rows carry from one evaluation to the next is zero in them, where a scene has any.
    """
    low, inverse, shape, first_cell = grid
    for g in chosen:
        for d in range(len(shape)):
            rows[end, d] = position[g, d]
        for column in range(2 * len(shape) + 3, rows.shape[1]):
            rows[end, column] = 0.0
        tags[end] = FIRST_FIXED + g
        cells[end] = cell_of(rows, end, low, inverse, shape) - first_cell
        end += 1
    return end


@jit
def mirror_laws(chosen, position, mirror, direction, turned, wall, found, used, gravity, state, values):
    """Set (velocity, density, pressure) of the ghosts `chosen` from (velocity, pressure) `found` at their mirror points.

    `wall` holds the wall's velocity and acceleration at each ghost's wall point; `turned`: all of the velocity is turned.
    """
    dim, rho0, inverse_c2 = position.shape[1], state[1], 1.0 / (state[2] * state[2])
    for k in range(len(chosen)):
        g = chosen[k]
        if used[k] == DRY:
            for d in range(dim):
                values[g, d] = wall[g, d]
            values[g, dim + 1] = 0.0
            values[g, dim] = rho0
            continue
        pressure, normal_speed = found[k, dim], 0.0
        density = rho0 + max(pressure, 0.0) * inverse_c2
        for d in range(dim):
            pressure += density * (gravity[d] - wall[g, dim + d]) * (position[g, d] - mirror[g, d])
            normal_speed += (found[k, d] - wall[g, d]) * direction[g, d]
        for d in range(dim):
            if turned[g]:
                values[g, d] = 2.0 * wall[g, d] - found[k, d]
            else:
                values[g, d] = found[k, d] - 2.0 * normal_speed * direction[g, d]
        values[g, dim] = density_of(pressure, state)
        values[g, dim + 1] = pressure


@jit
def give_values(rows, tags, first, last, values, volume):
    """Write velocity, density, pressure and mass to the ghost rows among ``first:last``."""
    dim = values.shape[1] - 2
    for i in range(first, last):
        if tags[i] >= FIRST_FIXED:
            g = tags[i] - FIRST_FIXED
            for d in range(dim + 2):
                rows[i, dim + d] = values[g, d]
            rows[i, 2 * dim + 2] = values[g, dim] * volume[g]


@dataclass(frozen=True)
class Part:
    """Ghosts that move together: their places in the tables, and what moves them.

    Attributes
    ----------
    rows : slice
    motion : Swing or None
    """

    rows: slice
    motion: object


class FixedGhosts:
    """All fixed ghosts of a scene, and how they get their values.

    Parameters
    ----------
    boundaries : list of (Ghosts, slips, motion)
        Ghosts of each boundary (`parsph.geometry`), the slip of each of them by its outline, what moves it or None.
    interpolator : str
    kernel : Kernel
    h, rho0 : float
        [m], [kg/m^3]
    gravity : tuple of float
        [m/s^2]
    state : State
    """

    def __init__(self, boundaries, interpolator, kernel, h, rho0, gravity, state):
        self.interpolator, self.kernel = INTERPOLATORS[interpolator], kernel
        self.h, self.rho0, self.gravity, self.state = h, rho0, gravity, state
        tables = [ghosts for ghosts, _, _ in boundaries]
        self._rest = {
            name: np.concatenate([getattr(ghosts, name) for ghosts in tables]) for name in ("position", "mirror", "direction")
        }
        self.position, self.mirror, self.direction = (self._rest[name].copy() for name in ("position", "mirror", "direction"))
        slips = np.concatenate([np.array(slips)[ghosts.part] for ghosts, slips, _ in boundaries])
        self.turned = np.concatenate([ghosts.through_point for ghosts in tables]) | (slips == NO_SLIP)
        self.volume = np.concatenate([ghosts.volume for ghosts in tables])
        count, dim = self.position.shape
        self.wall = np.zeros((count, 2 * dim))
        self.values = np.zeros((count, dim + 2))
        self.values[:, dim] = rho0
        ends = np.cumsum([0, *(len(ghosts.position) for ghosts in tables)])
        spans = zip(ends[:-1], ends[1:], boundaries, strict=True)
        self.parts = [Part(slice(int(a), int(b)), motion) for a, b, (_, _, motion) in spans]
        self.methods_used = np.zeros(len(INTERPOLATORS) + 1, np.int64)
        self.share = None

    @property
    def count(self):
        """Number of ghosts."""
        return len(self.position)

    @property
    def moving(self):
        """Whether any of them moves."""
        return any(part.motion is not None for part in self.parts)

    def move(self, time):
        """Put the ghosts where they are at `time` [s]."""
        for part in self.parts:
            if part.motion is None:
                continue
            rows = part.rows
            now = part.motion.at(time)
            self.position[rows] = now.place(self._rest["position"][rows])
            self.mirror[rows] = now.place(self._rest["mirror"][rows])
            self.direction[rows] = now.turn(self._rest["direction"][rows])
            middle = 0.5 * (self.position[rows] + self.mirror[rows])  # the wall point, or near it
            self.wall[rows, : middle.shape[1]] = now.velocity(middle)
            self.wall[rows, middle.shape[1] :] = now.acceleration(middle)

    def distribute(self, grid, cuts, rank):
        """Work out which ghosts stand in the columns of `rank`, which it interpolates, and who needs those values."""
        self.share = Share(self, grid, cuts, rank)

    def append(self, particles, grid, slab):
        """Append the ghosts of this slab to its particles, without values."""
        p = particles
        p.reserve(p.last + len(self.share.standing))
        place = grid.low, 1.0 / grid.cell, grid.shape, slab.first * grid.stride
        p.last = stand(p.shared, p.tags, p.cells, p.last, self.share.standing, self.position, place)

    def interpolate(self, particles, starts, grid):
        """Set the values of the ghosts whose mirror points lie in this slab; the halos must be there."""
        chosen = self.share.mine
        points, dim = self.share.points, self.mirror.shape[1]
        found, used = np.empty((len(chosen), dim + 1)), np.empty(len(chosen), np.int64)
        compiled_interpolation(dim, self.kernel.code, self.interpolator.code)(
            particles.shared,
            particles.tags,
            starts,
            points,
            self.share.cells,
            (grid.cell, grid.shape),
            (self.h, self.kernel.norms[dim - 1] / self.h**dim, self.rho0),
            self.gravity,
            found,
            used,
        )
        mirror_laws(
            chosen,
            self.position,
            self.mirror,
            self.direction,
            self.turned,
            self.wall,
            found,
            used,
            self.gravity,
            self.state.constants,
            self.values,
        )
        self.methods_used += np.bincount(used, minlength=len(self.methods_used))

    def give(self, particles, starts):
        """Write the values to the ghost rows of this slab and of its halos."""
        give_values(particles.shared, particles.tags, 0, int(starts[-1]), self.values, self.volume)


class Share:
    """What one rank has to do with the ghosts.

    Attributes
    ----------
    standing : ndarray of int
        Ghosts in its columns.
    mine : ndarray of int
        Ghosts whose mirror points are in its columns, in the order of their cells.
    points, cells : ndarray, shapes (n, dim) and (n,)
        Those mirror points [m], and their local cells.
    sent, received : dict of int to ndarray
        By rank: whose values go there, and come from there.
    """

    def __init__(self, ghosts, grid, cuts, rank):
        inside = _inside(ghosts.position, grid, 0) & _inside(ghosts.mirror, grid, 1)
        column, source = grid.column_of(ghosts.position[:, 0]), grid.column_of(ghosts.mirror[:, 0])
        cuts = np.asarray(cuts)
        owner = np.searchsorted(cuts, source, side="right") - 1

        def needed(other):
            return inside & (column >= cuts[other] - 1) & (column <= cuts[other + 1])

        first, last = cuts[rank], cuts[rank + 1]
        self.standing = np.flatnonzero(inside & (column >= first) & (column < last))
        is_mine = inside & (owner == rank)
        mine = np.flatnonzero(is_mine)
        index = np.floor((ghosts.mirror[mine] - np.array(grid.low)) / grid.cell).astype(np.int64)
        cells = np.ravel_multi_index(tuple(index.T), grid.shape) - (first - 1) * grid.stride
        order = np.argsort(cells, kind="stable")
        self.mine, self.cells = mine[order], cells[order]
        self.points = ghosts.mirror[self.mine]
        takers = np.unique(
            np.searchsorted(cuts, np.clip(column[is_mine][:, None] + [-1, 0, 1], 0, cuts[-1] - 1), side="right") - 1
        )
        sent = {int(other): np.flatnonzero(is_mine & needed(other)) for other in takers if other != rank}
        here = needed(rank)
        givers = np.unique(owner[here])
        self.sent = {other: rows for other, rows in sent.items() if len(rows)}
        self.received = {int(other): np.flatnonzero(here & (owner == other)) for other in givers if other != rank}


def _inside(points, grid, margin):
    """Whether points lie in the grid, so many cells away from its edge."""
    index = np.floor((points - np.array(grid.low)) / grid.cell)
    return ((index >= margin) & (index < np.array(grid.shape) - margin)).all(axis=1)
