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

import numpy as np

from ..columns import cell_of
from ..jit import jit
from ..particles import FIRST_FIXED
from ..states import density_of
from .interpolation import DRY, INTERPOLATORS, compiled_interpolation
from .mirror import NO_SLIP
from .shares import Part, Share


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
            self.direction[rows] = now.turn(self._rest["direction"][rows], self._rest["position"][rows])
            middle = 0.5 * (self.position[rows] + self.mirror[rows])  # the wall point, or near it
            self.wall[rows, : middle.shape[1]] = now.velocity(middle)
            self.wall[rows, middle.shape[1] :] = now.acceleration(middle)

    def distribute(self, grid, cuts, rank):
        """Work out which ghosts stand in the columns of `rank`, which it interpolates, and who needs those values."""
        self.share = Share(self.position, self.mirror, grid, cuts, rank)

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

    def complete(self, particles, starts, communicator):
        """Finish what values of single ghosts do not tell, once all are set: nothing, unless ghosts depend on each other."""

    def give(self, particles, starts):
        """Write the values to the ghost rows of this slab and of its halos."""
        give_values(particles.shared, particles.tags, 0, int(starts[-1]), self.values, self.volume)
