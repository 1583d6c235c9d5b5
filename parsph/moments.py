"""Moments of the kernel and of its gradient: how far sums over neighbours reproduce linear fields, and what mends them.

Of a fluid particle a, with V_b = m_b/rho_b of all particles b in reach, itself, images and ghosts included:

- Szmidt eq. (23): ``M0 = sum V_b W_ab``, 1 where constants are reproduced, and ``M1 = sum V_b (x_b - x_a) W_ab``, then 0;
- eq. (24): ``G0 = sum V_b grad_a W_ab``, then 0, and ``G1_ij = sum V_b (x_b - x_a)_i dW_ab/d(x_a)_j``, then the unit matrix: as
  grad_a W_ab points from a to b, the diagonal is positive as it stands;
- eq. (28): the matrix A of the second moments, whose inverse corrects the kernel (`parsph.terms.correction`).

One loop serves both. A particle's sum has an order fixed by (cell, tag): no dependence on the number of ranks.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from .columns import FAR, cells_per_column, choose_candidates, fluid_box, most_candidates
from .jit import VECTOR, jit
from .kernels import kernel_slope, kernel_value
from .particles import FIRST_GHOST, Field
from .terms.correction import invert_moments

PADDING = VECTOR // 8

MOMENTS = (
    Field("kernel_moment0", 0, "", "M0 = sum V W of the plain kernel, 1 where reproduced", "derived", snapshot=True),
    Field("kernel_moment1", 1, "m", "M1 = sum V (x_b - x_a) W, 0 where reproduced", "derived", snapshot=True),
    Field("gradient_moment0", 1, "1/m", "G0 = sum V grad_a W, 0 where reproduced", "derived", snapshot=True),
    Field(
        "gradient_moment1", 2, "", "G1 = sum V (x_b - x_a) grad_a W, the unit matrix where reproduced", "derived", snapshot=True
    ),
)


def triangle(dim):
    """Return (rows, columns) of the upper triangle of a symmetric matrix of dim + 1, in the order of the tables."""
    return np.triu_indices(dim + 1)


@lru_cache
def compiled_moments(dim, kernel, gradients):
    """Return the pass that sums moments, for these codes; numbers are run-time arguments.

    Parameters
    ----------
    dim, kernel : int
    gradients : bool
        Whether second moments are those of the gradient, G1, and G0 follows; else they are those of A.

    Returns
    -------
    callable
        Its last argument is the table that it writes: M0, M1, the upper triangle of the second moments, G0.
    """
    strips = 3 ** (dim - 1)
    second = dim + 1  # where the second moments begin
    last = second + dim * (dim + 1) // 2

    def set_moments(rows, tags, starts, first_cell, last_cell, grid, numbers, table):
        cell_size, shape = grid
        h, norm = numbers
        stride = cells_per_column(shape)
        most = most_candidates(starts, first_cell, last_cell, 1, strips, stride, shape)
        scratch = np.empty((4, (most // PADDING + 1) * PADDING))
        chosen = np.empty(scratch.shape[1], np.int64)
        xs, ys, zs, Vs = scratch[0], scratch[1], scratch[2], scratch[3]
        inverse_h, value_norm, slope_norm = 1.0 / h, norm / h**dim, norm / h ** (dim + 2)
        for cell in range(first_cell, last_cell):
            begin, end = starts[cell], starts[cell + 1]
            middle, extent = fluid_box(rows, tags, begin, end, dim)
            if extent[0] < 0.0:
                continue
            reach2 = cell_size * cell_size
            count, own = choose_candidates(rows, starts, cell, strips, stride, shape, middle, extent, reach2, chosen, begin)
            for o in range(count):
                j = chosen[o]
                xs[o] = rows[j, 0] - middle[0]
                if dim > 1:
                    ys[o] = rows[j, 1] - middle[1]
                if dim > 2:
                    zs[o] = rows[j, 2] - middle[2]
                Vs[o] = rows[j, 2 * dim + 2] / rows[j, 2 * dim]
            padded = (count + PADDING - 1) // PADDING * PADDING
            for o in range(count, padded):
                xs[o] = FAR * cell_size
                ys[o] = 0.0
                zs[o] = 0.0
                Vs[o] = 0.0
            for i in range(begin, end):
                if tags[i] >= FIRST_GHOST:
                    break
                o = own + i - begin
                x, y, z = xs[o], ys[o], zs[o]
                whole, mx, my, mz = 0.0, 0.0, 0.0, 0.0
                xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                gx, gy, gz = 0.0, 0.0, 0.0
                for j in range(padded):
                    dx = xs[j] - x
                    r2 = dx * dx
                    if dim > 1:
                        dy = ys[j] - y
                        r2 += dy * dy
                    if dim > 2:
                        dz = zs[j] - z
                        r2 += dz * dz
                    q = np.sqrt(r2) * inverse_h
                    VW = Vs[j] * value_norm * kernel_value(kernel, q)
                    # minus F: grad_a W = F (x_a - x_b)
                    second_weight = -Vs[j] * slope_norm * kernel_slope(kernel, q) if gradients else VW
                    whole += VW
                    mx += VW * dx
                    wx = second_weight * dx
                    xx += wx * dx
                    gx += wx
                    if dim > 1:
                        my += VW * dy
                        wy = second_weight * dy
                        xy += wx * dy
                        yy += wy * dy
                        gy += wy
                    if dim > 2:
                        mz += VW * dz
                        wz = second_weight * dz
                        xz += wx * dz
                        yz += wy * dz
                        zz += wz * dz
                        gz += wz
                table[i, 0] = whole
                table[i, 1] = mx
                table[i, second] = xx
                if dim > 1:
                    table[i, 2] = my
                    table[i, second + 1] = xy
                    table[i, second + dim] = yy
                if dim > 2:
                    table[i, 3] = mz
                    table[i, second + 2] = xz
                    table[i, second + 4] = yz
                    table[i, second + 5] = zz
                if gradients:
                    table[i, last] = gx
                    if dim > 1:
                        table[i, last + 1] = gy
                    if dim > 2:
                        table[i, last + 2] = gz

    return jit(set_moments)


@jit
def set_coefficients(table, tags, first, last, size, length):
    """Turn the moments of the fluid among the rows ``first:last`` into coefficients, see `Correction`.

    Parameters
    ----------
    table : ndarray, shape (>= last, width)
        The upper triangles of A, replaced by those of C, and the flag of the plain kernel.
    size : int
        dim + 1, of A.
    length : float
        What lengths in A are divided by for its inversion [m].

    Returns
    -------
    int
        How many keep the plain kernel.
    """
    count = 0
    moments = np.empty((size, size))
    per = np.full(size, 1.0 / length)  # of the basis 1, x, y, z
    per[0] = 1.0
    for i in range(first, last):
        if tags[i] >= FIRST_GHOST:
            continue
        place = 0
        for a in range(size):
            for b in range(a, size):
                moments[a, b] = table[i, place] * per[a] * per[b]
                moments[b, a] = moments[a, b]
                place += 1
        good = invert_moments(moments)
        table[i, place] = not good
        count += not good
        place = 0
        for a in range(size):
            for b in range(a, size):
                plain = 1.0 if b == 0 else 0.0
                table[i, place] = moments[a, b] * per[a] * per[b] if good else plain
                place += 1
    return count


@dataclass
class Correction:
    """The pass before the sweep of a scene with a corrected kernel.

    It fills `Particles.correction`: the upper triangle of C, row by row [1, 1/m, 1/m^2], and 1 for particles that keep the
    plain kernel (C is then 1 and zeros), else 0.

    Attributes
    ----------
    sweep : Sweep
        Whose kernel it shares.
    plain : int
        How often a particle of this rank kept the plain kernel, over all evaluations.
    """

    sweep: object
    plain: int = field(default=0, init=False)

    def __post_init__(self):
        self._length = self.sweep.h * self.sweep.kernel.spread(self.sweep.dim)

    @staticmethod
    def width(dim):
        """Return the number of coefficients of a particle."""
        return len(triangle(dim)[0]) + 1

    def __call__(self, particles, starts, slab):
        """Set the coefficients of the fluid of `slab`; the halos must be there."""
        sweep, p = self.sweep, particles
        compiled = compiled_moments(sweep.dim, sweep.kernel.code, False)
        sweep.over_slab(compiled, p, starts, slab, p.correction)
        self.plain += set_coefficients(p.correction, p.tags, p.first, p.last, sweep.dim + 1, self._length)


@dataclass(frozen=True)
class Moments:
    """The moments of the plain kernel, eqs. (23), (24).

    Attributes
    ----------
    sweep : Sweep
        Whose kernel it shares.
    """

    sweep: object

    def __call__(self, particles, starts, slab):
        """Return {name: values} of `MOMENTS` for the fluid of `slab`, in its order; the halos must be there."""
        sweep, dim = self.sweep, self.sweep.dim
        rows, columns = triangle(dim)
        table = np.zeros((particles.last, len(rows) + dim))
        compiled = compiled_moments(dim, sweep.kernel.code, True)
        sweep.over_slab(compiled, particles, starts, slab, table)
        table = table[particles.fluid]
        matrix = np.empty((len(table), dim + 1, dim + 1))
        matrix[:, rows, columns] = matrix[:, columns, rows] = table[:, : len(rows)]
        values = matrix[:, 0, 0], matrix[:, 0, 1:], table[:, len(rows) :], matrix[:, 1:, 1:]
        return {moment.name: each for moment, each in zip(MOMENTS, values, strict=True)}
