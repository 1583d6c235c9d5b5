"""Passes over neighbours beside the sweep: renormalised density gradients, and densities summed anew.

Gradients are needed by delta-SPH before the sweep, of all neighbours; so they are a pass of their own, and their edge columns
travel to the neighbour ranks before the sweep reads them. Same order of sums as there: no dependence on the number of ranks.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .columns import (
    BLOCKS,
    FAR,
    cells_of_block,
    cells_per_column,
    choose_candidates,
    ends_of_layers,
    fluid_box,
    most_candidates,
    order_by_layer,
    within_reach,
)
from .jit import VECTOR, jit
from .kernels import kernel_slope, kernel_value
from .linear import cofactors
from .particles import FIRST_GHOST
from .sweep import over_slab
from .terms.density import LEAST_DETERMINANT
from .terms.diffusion import diffusing_density
from .terms.filter import filtered_density


@jit
def renormalised(xx, xy, xz, yy, yz, zz, x, y, z, dim):
    """Return the x that solves ``M x = b`` for the symmetric M of a particle; zero where M is near singular."""
    a, b, c, d, e, f, determinant = cofactors(xx, xy, xz, yy, yz, zz, dim)
    if determinant < LEAST_DETERMINANT:
        return 0.0, 0.0, 0.0
    return (a * x + b * y + c * z) / determinant, (b * x + d * y + e * z) / determinant, (c * x + e * y + f * z) / determinant


@lru_cache
def compiled_gradients(dim, kernel, diffusion):
    """Return the pass that sets the renormalised gradient of the diffusing density, for these codes; numbers at run time."""
    real, padding = np.float32, VECTOR // 4  # they steer a diffusion: seven digits do, and pairs take two thirds of the time
    strips, block = 3 ** (dim - 1), BLOCKS[dim - 1]

    def set_gradients(rows, tags, starts, first_cell, last_cell, grid, numbers, gravity, gradients):
        cell_size, shape = grid
        h, norm, rho0, inverse_c2, gamma = numbers
        stride = cells_per_column(shape)
        room = most_candidates(starts, first_cell, last_cell, block, strips, stride, shape) + padding
        scratch = np.empty((5, room), real)
        chosen, places = np.empty(room, np.uint32), np.empty(room, np.uint32)
        ends = ends_of_layers(block)
        xs, ys, zs, ss, Vols = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4]
        inverse_h, slope_norm = real(1.0 / h), norm / h ** (dim + 2)
        for cell in range(first_cell, last_cell):
            cells = cells_of_block(cell, block, shape)
            begin, end = starts[cell], starts[cell + cells]
            middle, extent = fluid_box(rows, tags, begin, end, dim)
            if extent[0] < 0.0:
                continue
            lowest = middle[dim - 1] - extent[dim - 1] - cell_size
            count, own = order_by_layer(
                rows, starts, cell, cells, strips, stride, shape, lowest, cell_size, chosen, places, ends
            )
            for k in range(count):
                j, o = chosen[k], places[k]
                xs[o] = rows[j, 0] - middle[0]
                hydrostatic = gravity[0] * (rows[j, 0] - middle[0])
                if dim > 1:
                    ys[o] = rows[j, 1] - middle[1]
                    hydrostatic += gravity[1] * (rows[j, 1] - middle[1])
                if dim > 2:
                    zs[o] = rows[j, 2] - middle[2]
                    hydrostatic += gravity[2] * (rows[j, 2] - middle[2])
                density = rows[j, 2 * dim]
                ss[o] = diffusing_density(diffusion, density - rho0, rho0, gamma, rho0 * inverse_c2 * hydrostatic)
                Vols[o] = rows[j, 2 * dim + 2] / density
            for row in range(len(scratch)):
                for o in range(count, count + padding):
                    scratch[row, o] = 0.0
            for o in range(count, count + padding):
                xs[o] = FAR * cell_size
            for i in range(begin, end):
                if tags[i] >= FIRST_GHOST:
                    continue
                o = places[own + i - begin]
                first, last = within_reach(rows[i, dim - 1], lowest, cell_size, ends)
                padded = (last - first + padding - 1) // padding * padding
                x, y, z, s = xs[o], ys[o], zs[o], ss[o]
                xx, xy, xz, yy = real(0.0), real(0.0), real(0.0), real(0.0)
                yz, zz = real(0.0), real(0.0)
                sx, sy, sz = real(0.0), real(0.0), real(0.0)
                for k in range(padded):
                    j = np.uint64(first + k)
                    dx = xs[j] - x
                    r2 = dx * dx
                    if dim > 1:
                        dy = ys[j] - y
                        r2 += dy * dy
                    if dim > 2:
                        dz = zs[j] - z
                        r2 += dz * dz
                    w = Vols[j] * kernel_slope(kernel, np.sqrt(r2) * inverse_h)
                    ds = ss[j] - s
                    wx = w * dx
                    xx -= wx * dx
                    sx -= wx * ds
                    if dim > 1:
                        wy = w * dy
                        xy -= wx * dy
                        yy -= wy * dy
                        sy -= wy * ds
                    if dim > 2:
                        wz = w * dz
                        xz -= wx * dz
                        yz -= wy * dz
                        zz -= wz * dz
                        sz -= wz * ds
                n = slope_norm
                solved = renormalised(n * xx, n * xy, n * xz, n * yy, n * yz, n * zz, n * sx, n * sy, n * sz, dim)
                for d in range(dim):
                    gradients[i, d] = solved[d]

    return jit(set_gradients)


@dataclass(frozen=True)
class Gradients:
    """The gradient pass of a sweep with renormalised diffusion.

    Attributes
    ----------
    sweep : Sweep
        Whose kernel and numbers it shares.
    """

    sweep: object

    def __call__(self, particles, starts, slab):
        """Set the gradients of the fluid of `slab`; those of images and ghosts are zero."""
        sweep = self.sweep
        particles.gradient[: starts[-1]] = 0.0
        compiled = compiled_gradients(sweep.dim, sweep.kernel.code, sweep.terms.diffusion.code)
        numbers = sweep.h, sweep.kernel.norms[sweep.dim - 1], sweep.rho0, sweep.c0**-2, sweep.gamma
        over_slab(compiled, particles, starts, slab, numbers, sweep.gravity, particles.gradient)


@lru_cache
def compiled_filter(dim, kernel, law):
    """Return the pass that sums densities anew, for these codes; numbers are run-time arguments."""
    strips = 3 ** (dim - 1)
    size = dim + 1

    def sum_densities(rows, tags, starts, first_cell, last_cell, grid, numbers, densities):
        cell_size, shape = grid
        h, norm = numbers
        stride = cells_per_column(shape)
        most = most_candidates(starts, first_cell, last_cell, 1, strips, stride, shape)
        chosen = np.empty(most + 1, np.int64)
        apart, moments, masses = np.empty(size), np.empty((size, size)), np.empty(size)
        for cell in range(first_cell, last_cell):
            begin, end = starts[cell], starts[cell + 1]
            middle, extent = fluid_box(rows, tags, begin, end, dim)
            if extent[0] < 0.0:
                continue
            reach2 = cell_size * cell_size
            count, _ = choose_candidates(rows, starts, cell, strips, stride, shape, middle, extent, reach2, chosen, begin)
            for i in range(begin, end):
                if tags[i] >= FIRST_GHOST:
                    break
                moments[:] = 0.0
                masses[:] = 0.0
                for k in range(count):
                    j = chosen[k]
                    r2 = 0.0
                    apart[0] = 1.0
                    for d in range(dim):
                        apart[1 + d] = (rows[j, d] - rows[i, d]) / h
                        r2 += apart[1 + d] * apart[1 + d]
                    mass = rows[j, 2 * dim + 2]
                    mW = mass * norm / h**dim * kernel_value(kernel, np.sqrt(r2))
                    VW = mW / rows[j, 2 * dim]
                    for a in range(size):
                        masses[a] += mW * apart[a]
                        for b in range(size):
                            moments[a, b] += VW * apart[a] * apart[b]
                densities[i] = filtered_density(law, masses, moments)

    return jit(sum_densities)


@dataclass(frozen=True)
class DensityFilter:
    """Densities summed over neighbours anew, every so many steps.

    Attributes
    ----------
    sweep : Sweep
        Whose kernel it shares.
    law : Formula
    every : int
        Steps between two.
    """

    sweep: object
    law: object
    every: int

    def __call__(self, particles, starts, slab):
        """Replace the densities of the fluid of `slab`; pressures and halos are then out of date."""
        sweep, p = self.sweep, particles
        compiled = compiled_filter(sweep.dim, sweep.kernel.code, self.law.code)
        over_slab(compiled, p, starts, slab, (sweep.h, sweep.kernel.norms[sweep.dim - 1]), p.density_rate)
        rows = p.fluid
        p.shared[rows, p.layout.columns("density")[1]] = p.density_rate[rows, None]
