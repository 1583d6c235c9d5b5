"""Values of the fluid at points: one family of interpolators, from fluid particles alone.

Every interpolator is a set of shape functions phi_b, ``f(x) = sum_b phi_b f_b``, with r the distance to the point and R the
support radius:

==============  ========================================================================================================
`normalised`    phi = V W / sum V W
`hydrostatic`   the same, of p + rho0 g . (x - x_b) in place of p: exact on hydrostatic pressure
`shepard`       phi = w / sum w, w = (1 - r/R)^4 / r^2 (improved Shepard of Huang et al. (2019) section 3.4, restored)
`sfdi`          f(x) = f_J + grad f . (x - x_J), J the particle nearest to x, the gradient by least squares of the
                differences to J with the weight W / r_bJ^2 (simplified finite difference interpolation, Ma 2008, restored)
`mls1`, `mls2`  moving least squares of a linear, quadratic polynomial with the weight V W
==============  ========================================================================================================

Where there are too few neighbours or their places do not determine the polynomial: mls2 -> mls1 -> normalised, sfdi ->
normalised. Where there is no neighbour: the free-surface value, p = 0.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..columns import strip_offset
from ..jit import jit
from ..kernels import kernel_value
from ..linear import solve_symmetric
from ..particles import FIRST_GHOST

NORMALISED, HYDROSTATIC, SHEPARD, SFDI, MLS1, MLS2 = range(1, 7)
DRY = 0
HALF_COVERED = 0.5  # sum of V W at the free surface; inside the fluid it is 1

SHEPARD_POWER = 4  # mu of Huang et al.
NEAREST = 1e-3  # of R: nearer particles weigh no more in 1/r^2
WELL_CONDITIONED = {SFDI: 1e-2, MLS1: 1e-2, MLS2: 1e-4}
_WELL_SFDI, _WELL_MLS1, _WELL_MLS2 = WELL_CONDITIONED.values()


@dataclass(frozen=True)
class Interpolator:
    """An interpolator.

    Attributes
    ----------
    name : str
    code : int
        What the compiled code knows it by.
    equation, source : str
        For `parsph plan`.
    """

    name: str
    code: int
    equation: str
    source: str


INTERPOLATORS = {
    each.name: each
    for each in (
        Interpolator(
            "hydrostatic",
            HYDROSTATIC,
            "sum V W (p_b + rho0 g . (x - x_b)) / sum V W",
            "normalised, the hydrostatic difference compensated",
        ),
        Interpolator("mls1", MLS1, "linear moving least squares, weight V W", "Huang et al. (2019) section 3.1"),
        Interpolator("mls2", MLS2, "quadratic moving least squares, weight V W", "Huang et al. (2019) section 3.1"),
        Interpolator(
            "sfdi", SFDI, "f_J + grad f . (x - x_J), weight W/r^2", "Ma (2008), CMES 23, 75; Huang et al. section 3.2"
        ),
        Interpolator("shepard", SHEPARD, "sum w f / sum w, w = (1 - r/R)^4 / r^2", "Huang et al. (2019) section 3.4"),
        Interpolator("normalised", NORMALISED, "sum V W f / sum V W", "Huang et al. (2019) section 3.3"),
    )
}


@jit
def fill_basis(apart, degree, basis):
    """Write 1, x, y, ... and for degree 2 the products x x, x y, y y, ... of `apart` to `basis`; return how many."""
    basis[0] = 1.0
    size = 1
    if degree > 0:
        for d in range(len(apart)):
            basis[size] = apart[d]
            size += 1
    if degree > 1:
        for d in range(len(apart)):
            for e in range(d, len(apart)):
                basis[size] = apart[d] * apart[e]
                size += 1
    return size


@jit
def polynomial_shapes(apart, weights, count, degree, least, work, shapes):
    """Set `shapes` to those of a least-squares polynomial at apart = 0; return False where it is not determined."""
    matrix, vector, basis = work
    size = fill_basis(apart[0], degree, basis)
    if count < size:
        return False
    matrix[:size, :size] = 0.0
    for j in range(count):
        fill_basis(apart[j], degree, basis)
        for a in range(size):
            for b in range(a, size):
                matrix[a, b] += weights[j] * basis[a] * basis[b]
    for a in range(size):
        vector[a] = 0.0
        for b in range(a):
            matrix[a, b] = matrix[b, a]
    vector[0] = 1.0
    if not solve_symmetric(matrix, vector, size, least):
        return False
    for j in range(count):
        fill_basis(apart[j], degree, basis)
        shape = 0.0
        for a in range(size):
            shape += vector[a] * basis[a]
        shapes[j] = weights[j] * shape
    return True


@jit
def difference_shapes(kernel, apart, count, reach_over_h, work, shapes):
    """Set `shapes` to those of SFDI; return False where the differences do not determine a gradient."""
    matrix, vector, _ = work
    dim = apart.shape[1]
    nearest, least = 0, 1e300
    for j in range(count):
        r2 = 0.0
        for d in range(dim):
            r2 += apart[j, d] * apart[j, d]
        if r2 < least:
            nearest, least = j, r2
    if count < dim + 1:
        return False
    matrix[:dim, :dim] = 0.0
    for j in range(count):
        r2 = 0.0
        for d in range(dim):
            r2 += (apart[j, d] - apart[nearest, d]) ** 2
        shapes[j] = kernel_value(kernel, np.sqrt(r2) * reach_over_h) / max(r2, NEAREST * NEAREST)
        for a in range(dim):
            for b in range(dim):
                matrix[a, b] += shapes[j] * (apart[j, a] - apart[nearest, a]) * (apart[j, b] - apart[nearest, b])
    for d in range(dim):
        vector[d] = -apart[nearest, d]
    if not solve_symmetric(matrix, vector, dim, _WELL_SFDI):
        return False
    rest = 1.0
    for j in range(count):
        shape = 0.0
        for d in range(dim):
            shape += vector[d] * (apart[j, d] - apart[nearest, d])
        shapes[j] *= shape
        rest -= shapes[j]
    shapes[nearest] += rest
    return True


@jit
def shape_functions(method, kernel, apart, kernels, count, reach_over_h, work, weights, shapes):
    """Set the shape functions of neighbours at a point.

    Parameters
    ----------
    method, kernel : int
        Codes.
    apart : ndarray, shape (>= count, dim)
        Neighbours less the point, over R.
    kernels : ndarray, shape (>= count,)
        V W of the neighbours, in any unit.
    count : int
        Number of neighbours, all nearer than R.
    reach_over_h : float
    work : tuple of ndarray
        Room for a matrix, a vector and a basis.
    weights, shapes : ndarray, shape (>= count,)
        Written.

    Returns
    -------
    int
        The method that it came to, DRY where there is no fluid.
    """
    total = 0.0
    for j in range(count):
        if method == SHEPARD:
            r2 = 0.0
            for d in range(apart.shape[1]):
                r2 += apart[j, d] * apart[j, d]
            weights[j] = max(1.0 - np.sqrt(r2), 0.0) ** SHEPARD_POWER / max(r2, NEAREST * NEAREST)
        else:
            weights[j] = kernels[j]
        total += weights[j]
    if not total > 0.0:
        return DRY
    if method == MLS2:
        if polynomial_shapes(apart, weights, count, 2, _WELL_MLS2, work, shapes):
            return MLS2
        method = MLS1
    if method == MLS1:
        if polynomial_shapes(apart, weights, count, 1, _WELL_MLS1, work, shapes):
            return MLS1
        method = NORMALISED
    if method == SFDI:
        if difference_shapes(kernel, apart, count, reach_over_h, work, shapes):
            return SFDI
        method = NORMALISED
    for j in range(count):
        shapes[j] = weights[j] / total
    return method


@lru_cache
def compiled_interpolation(dim, kernel, method):
    """Return the pass that interpolates pressure and velocity at points, for these codes; numbers at run time."""
    strips = 3 ** (dim - 1)
    size = (dim + 1) * (dim + 2) // 2

    def interpolate(rows, tags, starts, points, cells, grid, numbers, gravity, values, used):
        """Write (velocity, pressure) at `points` in the local `cells` (equal ones follow each other) to `values`, and the
        methods that they came to to `used`.

        Nothing is extrapolated beyond the range of the neighbours' velocities, and of their pressures on the level of the
        point; and where less than half of the kernel lies in the fluid, the pressure is not negative.
        """
        cell_size, shape = grid
        h, norm, rho0 = numbers
        stride = 1
        for d in range(1, dim):
            stride *= shape[d]
        reach2, reach_over_h = cell_size * cell_size, cell_size / h
        room = 64
        chosen, apart = np.empty(room, np.int64), np.empty((room, dim))
        kernels, weights, shapes = np.empty(room), np.empty(room), np.empty(room)
        lowest, highest = np.empty(dim + 1), np.empty(dim + 1)
        work = np.empty((size, size)), np.empty(size), np.empty(size)
        fluid, fluid_count, gathered = np.empty(room, np.int64), 0, -1
        for k in range(len(points)):
            if cells[k] != gathered:  # points of one cell share their candidates
                gathered, fluid_count, total = cells[k], 0, 0
                for strip in range(strips):
                    offset = strip_offset(strip, strips, stride, shape)
                    total += starts[gathered + offset + 2] - starts[gathered + offset - 1]
                if total > room:
                    room = 2 * total
                    chosen, apart = np.empty(room, np.int64), np.empty((room, dim))
                    kernels, weights, shapes = np.empty(room), np.empty(room), np.empty(room)
                    fluid = np.empty(room, np.int64)
                for strip in range(strips):
                    offset = strip_offset(strip, strips, stride, shape)
                    for j in range(starts[gathered + offset - 1], starts[gathered + offset + 2]):
                        fluid[fluid_count] = j
                        fluid_count += tags[j] < FIRST_GHOST
            count = 0
            for c in range(fluid_count):
                j = fluid[c]
                r2 = 0.0
                for d in range(dim):
                    r2 += (rows[j, d] - points[k, d]) ** 2
                chosen[count] = j
                count += r2 < reach2
            covered = 0.0
            for c in range(count):
                j = chosen[c]
                r2 = 0.0
                for d in range(dim):
                    apart[c, d] = (rows[j, d] - points[k, d]) / cell_size
                    r2 += apart[c, d] * apart[c, d]
                kernels[c] = rows[j, 2 * dim + 2] / rows[j, 2 * dim] * kernel_value(kernel, np.sqrt(r2) * reach_over_h)
                covered += norm * kernels[c]
            used[k] = shape_functions(method, kernel, apart, kernels, count, reach_over_h, work, weights, shapes)
            for d in range(dim + 1):
                values[k, d] = 0.0
            if used[k] == DRY:
                continue
            lowest[:] = np.inf
            highest[:] = -np.inf
            for c in range(count):
                j = chosen[c]
                pressure, head = rows[j, 2 * dim + 1], 0.0
                for d in range(dim):
                    velocity = rows[j, dim + d]
                    values[k, d] += shapes[c] * velocity
                    lowest[d], highest[d] = min(lowest[d], velocity), max(highest[d], velocity)
                    head += rho0 * gravity[d] * (points[k, d] - rows[j, d])
                values[k, dim] += shapes[c] * (pressure + head if method == HYDROSTATIC else pressure)
                lowest[dim], highest[dim] = min(lowest[dim], pressure + head), max(highest[dim], pressure + head)
            if covered < HALF_COVERED:
                lowest[dim] = max(lowest[dim], 0.0)
                highest[dim] = max(highest[dim], 0.0)
            for d in range(dim + 1):
                values[k, d] = min(max(values[k, d], lowest[d]), highest[d])

    return jit(interpolate)
