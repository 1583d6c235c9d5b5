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

from functools import lru_cache

import numpy as np

from ..columns import FAR, candidates, cells_per_column, strip_offset
from ..formula import Formula
from ..jit import jit
from ..kernels import kernel_value
from ..linear import solve_symmetric
from ..particles import FIRST_GHOST

NORMALISED, HYDROSTATIC, SHEPARD, SFDI, MLS1, MLS2 = range(1, 7)
DRY = 0
HALF_COVERED = 0.5  # sum of V W at the free surface; inside the fluid it is 1

PADDING = 8  # of the candidates
NEAREST = 1e-3  # of R: nearer particles weigh no more in 1/r^2
WELL_CONDITIONED_SFDI, WELL_CONDITIONED_MLS1, WELL_CONDITIONED_MLS2 = 1e-2, 1e-2, 1e-4  # see `solve_symmetric`


INTERPOLATORS = {
    each.name: each
    for each in (
        Formula(
            "hydrostatic",
            HYDROSTATIC,
            "sum V W (p_b + rho0 g . (x - x_b)) / sum V W",
            "normalised, the hydrostatic difference compensated",
        ),
        Formula("mls1", MLS1, "linear moving least squares, weight V W", "Huang et al. (2019) section 3.1"),
        Formula("mls2", MLS2, "quadratic moving least squares, weight V W", "Huang et al. (2019) section 3.1"),
        Formula("sfdi", SFDI, "f_J + grad f . (x - x_J), weight W/r^2", "Ma (2008), CMES 23, 75; Huang et al. section 3.2"),
        Formula("shepard", SHEPARD, "sum w f / sum w, w = (1 - r/R)^4 / r^2", "Huang et al. (2019) section 3.4"),
        Formula("normalised", NORMALISED, "sum V W f / sum V W", "Huang et al. (2019) section 3.3"),
    )
}


@jit
def convex_weight(method, VW, r2):
    """The weight of a neighbour for the methods of degree 0; `r2` is (r/R)^2."""
    if method == SHEPARD:
        t = max(1.0 - np.sqrt(r2), 0.0)
        return t * t * t * t / max(r2, NEAREST * NEAREST)
    return VW


@jit
def fill_basis(apart, count, degree, basis):
    """Write 1, x, y, ... and for degree 2 the products x x, x y, y y, ... of `apart` to `basis`; return how many."""
    basis[0, :count] = 1.0
    size = 1
    for d in range(len(apart)):
        for j in range(count):
            basis[size, j] = apart[d, j]
        size += 1
    if degree > 1:
        for d in range(len(apart)):
            for e in range(d, len(apart)):
                for j in range(count):
                    basis[size, j] = apart[d, j] * apart[e, j]
                size += 1
    return size


@jit
def polynomial_shapes(apart, weights, count, degree, least, work, shapes):
    """Set `shapes` to those of a least-squares polynomial at apart = 0; return False where it is not determined."""
    matrix, vector, basis = work
    size = fill_basis(apart, count, degree, basis)
    if count < size:
        return False
    for a in range(size):
        vector[a] = 0.0
        for j in range(count):
            shapes[j] = weights[j] * basis[a, j]
        for b in range(a, size):
            total = 0.0
            for j in range(count):
                total += shapes[j] * basis[b, j]
            matrix[a, b] = total
            matrix[b, a] = total
    vector[0] = 1.0
    if not solve_symmetric(matrix, vector, size, least):
        return False
    shapes[:count] = 0.0
    for a in range(size):
        factor = vector[a]
        for j in range(count):
            shapes[j] += factor * basis[a, j]
    for j in range(count):
        shapes[j] *= weights[j]
    return True


@jit
def difference_shapes(kernel, apart, count, reach_over_h, work, shapes):
    """Set `shapes` to those of SFDI; return False where the differences do not determine a gradient."""
    matrix, vector, basis = work
    dim = len(apart)
    if count < dim + 1:
        return False
    nearest, least = 0, np.inf
    for j in range(count):
        r2 = 0.0
        for d in range(dim):
            r2 += apart[d, j] * apart[d, j]
        if r2 < least:
            nearest, least = j, r2
    for j in range(count):
        r2 = 0.0
        for d in range(dim):
            basis[d, j] = apart[d, j] - apart[d, nearest]
            r2 += basis[d, j] * basis[d, j]
        shapes[j] = kernel_value(kernel, np.sqrt(r2) * reach_over_h) / max(r2, NEAREST * NEAREST)
    for a in range(dim):
        for b in range(dim):
            total = 0.0
            for j in range(count):
                total += shapes[j] * basis[a, j] * basis[b, j]
            matrix[a, b] = total
        vector[a] = -apart[a, nearest]
    if not solve_symmetric(matrix, vector, dim, WELL_CONDITIONED_SFDI):
        return False
    rest = 1.0
    for j in range(count):
        slope = 0.0
        for d in range(dim):
            slope += vector[d] * basis[d, j]
        shapes[j] *= slope
        rest -= shapes[j]
    shapes[nearest] += rest
    return True


@jit
def shape_functions(method, kernel, apart, kernels, count, reach_over_h, work, shapes):
    """Set the shape functions of neighbours at a point.

    Parameters
    ----------
    method, kernel : int
        Codes.
    apart : ndarray, shape (dim, >= count)
        Neighbours less the point, over R.
    kernels : ndarray, shape (>= count,)
        V W of the neighbours, in any unit.
    count : int
        Number of neighbours, all nearer than R.
    reach_over_h : float
    work : tuple of ndarray
        Room for a matrix, a vector, and a basis of all neighbours: see `room_for`.
    shapes : ndarray, shape (>= count,)
        Written.

    Returns
    -------
    int
        The method that it came to, DRY where there is no fluid.
    """
    if method == MLS2:
        if polynomial_shapes(apart, kernels, count, 2, WELL_CONDITIONED_MLS2, work, shapes):
            return MLS2
        method = MLS1
    if method == MLS1:
        if polynomial_shapes(apart, kernels, count, 1, WELL_CONDITIONED_MLS1, work, shapes):
            return MLS1
        method = NORMALISED
    if method == SFDI:
        if difference_shapes(kernel, apart, count, reach_over_h, work, shapes):
            return SFDI
        method = NORMALISED
    total = 0.0
    for j in range(count):
        r2 = 0.0
        for d in range(len(apart)):
            r2 += apart[d, j] * apart[d, j]
        shapes[j] = convex_weight(method, kernels[j], r2)
        total += shapes[j]
    if not total > 0.0:
        return DRY
    for j in range(count):
        shapes[j] /= total
    return method


@jit
def room_for(dim, neighbours):
    """Return the `work` of `shape_functions` for so many neighbours."""
    size = (dim + 1) * (dim + 2) // 2
    return np.empty((size, size)), np.empty(size), np.empty((size, neighbours))


@lru_cache
def compiled_shapes(kernel):
    """Return `shape_functions` of the kernel of a code, without that argument, to be called where nothing is compiled."""

    def shapes_of(method, apart, kernels, count, reach_over_h, work, shapes):
        return shape_functions(method, kernel, apart, kernels, count, reach_over_h, work, shapes)

    return jit(shapes_of)


@lru_cache
def compiled_interpolation(dim, kernel, method):
    """Return the pass that interpolates pressure and velocity at points, for these codes; numbers at run time."""
    strips = 3 ** (dim - 1)
    convex = method in (NORMALISED, HYDROSTATIC, SHEPARD)
    # rows of the scratch: velocity, pressure, pressure head, volume, V W, weight; after the position
    first_pressure, first_head, first_volume, VW, first_weight = 2 * dim, 2 * dim + 1, 2 * dim + 2, 2 * dim + 3, 2 * dim + 4

    def interpolate(rows, tags, starts, points, cells, grid, numbers, gravity, values, used):
        """Write (velocity, pressure) at `points` in the local `cells` (equal ones follow each other) to `values`, and the
        methods that they came to to `used`.

        Least squares extrapolate nothing beyond the range of the neighbours' velocities, and of their pressures on the level
        of the point; and where less than half of the kernel lies in the fluid, the pressure is not negative.
        """
        cell_size, shape = grid
        h, norm, rho0 = numbers
        stride = cells_per_column(shape)
        most = 0
        for k in range(len(points)):
            most = max(most, candidates(starts, cells[k], 1, strips, stride, shape))
        around = np.zeros((first_weight + 1, (most // PADDING + 1) * PADDING))
        pressures, heads, volumes = around[first_pressure], around[first_head], around[first_volume]
        kernels, weights = around[VW], around[first_weight]
        near, apart, shapes = np.empty(most + 1, np.int64), np.empty((dim, most + 1)), np.empty(most + 1)
        nearby, levels = np.empty((dim + 1, most + 1)), np.empty(most + 1)
        place, work = np.empty(dim), room_for(dim, most + 1)
        reach_over_h, gathered, count, padded = cell_size / h, -1, 0, 0
        for k in range(len(points)):
            if cells[k] != gathered:  # points of one cell share their candidates
                gathered, count = cells[k], 0
                for strip in range(strips):
                    middle = gathered + strip_offset(strip, strips, stride, shape)
                    for j in range(starts[middle - 1], starts[middle + 2]):
                        if tags[j] >= FIRST_GHOST:
                            continue
                        head = 0.0
                        for d in range(dim):
                            around[d, count] = rows[j, d] / cell_size
                            around[dim + d, count] = rows[j, dim + d]
                            head += rho0 * gravity[d] * rows[j, d]
                        pressures[count] = rows[j, 2 * dim + 1]
                        heads[count] = head
                        volumes[count] = rows[j, 2 * dim + 2] / rows[j, 2 * dim]
                        count += 1
                padded = (count + PADDING - 1) // PADDING * PADDING
                for c in range(count, padded):
                    around[:, c] = 0.0
                    around[0, c] = FAR
            for d in range(dim + 1):
                values[k, d] = 0.0
            used[k] = DRY
            if count == 0:
                continue
            head, covered, total, pressure = 0.0, 0.0, 0.0, 0.0
            u, v, w = 0.0, 0.0, 0.0
            for d in range(dim):
                head += rho0 * gravity[d] * points[k, d]
                place[d] = points[k, d] / cell_size
            for c in range(padded):
                r2 = 0.0
                for d in range(dim):
                    away = around[d, c] - place[d]
                    r2 += away * away
                part = volumes[c] * kernel_value(kernel, np.sqrt(r2) * reach_over_h)
                covered += part
                if convex:
                    weight = convex_weight(method, part, r2)
                    total += weight
                    u += weight * around[dim, c]
                    if dim > 1:
                        v += weight * around[dim + 1, c]
                    if dim > 2:
                        w += weight * around[dim + 2, c]
                    pressure += weight * (pressures[c] - heads[c] + head if method == HYDROSTATIC else pressures[c])
                else:
                    kernels[c] = part
            if not covered > 0.0:
                continue
            if convex:
                used[k] = method
                velocity = u, v, w
                for d in range(dim):
                    values[k, d] = velocity[d] / total
                values[k, dim] = pressure / total
            else:
                neighbours = 0
                for c in range(count):
                    near[neighbours] = c
                    neighbours += kernels[c] > 0.0
                for n in range(neighbours):
                    c = near[n]
                    for d in range(dim):
                        apart[d, n] = around[d, c] - place[d]
                        nearby[d, n] = around[dim + d, c]
                    nearby[dim, n] = pressures[c]
                    levels[n] = pressures[c] - heads[c] + head
                    weights[n] = kernels[c]
                used[k] = shape_functions(method, kernel, apart, weights, neighbours, reach_over_h, work, shapes)
                for d in range(dim + 1):
                    value, lowest, highest = 0.0, np.inf, -np.inf
                    for n in range(neighbours):
                        value += shapes[n] * nearby[d, n]
                        limit = levels[n] if d == dim else nearby[d, n]
                        lowest, highest = min(lowest, limit), max(highest, limit)
                    values[k, d] = min(max(value, lowest), highest)
            if norm * covered < HALF_COVERED:
                values[k, dim] = max(values[k, dim], 0.0)

    return jit(interpolate)
