"""What a column of cells costs in a step, counted and not timed: cuts are then the same in every run of a scene.

The unit is a pair of a fluid particle and a candidate around its cell. Beside pairs there are passes over all rows (images and
ghosts included), and the interpolation at mirror points of fixed ghosts. Their weights were measured on a dam break and on a
tank between mirrors; they differ between scenes by a third, which moves a cut by less than a column.
"""

import numpy as np
from scipy.ndimage import convolve1d

ROW = 20.0  # pairs that the passes over a row cost: sort, images, pressures, integrator
MIRROR_POINT = 0.5  # pairs that a candidate of a mirror point costs


def column_costs(fluid, rows, mirror_cells=()):
    """Return the cost of each column of a slab [pairs].

    Parameters
    ----------
    fluid, rows : ndarray of int, shape (columns + 2, ...)
        Fluid particles and all rows in each cell, a column of halo on both sides.
    mirror_cells : ndarray of int
        The cell, in the order of the ravelled `rows`, of each mirror point that is interpolated.

    Returns
    -------
    ndarray, shape (columns,)
    """
    candidates = rows
    for axis in range(rows.ndim):
        candidates = convolve1d(candidates, (1, 1, 1), axis=axis, mode="constant")
    cost = fluid * candidates + ROW * rows
    points = np.bincount(mirror_cells, minlength=rows.size) if len(mirror_cells) else np.zeros(rows.size)
    cost += MIRROR_POINT * points.reshape(rows.shape) * candidates
    return cost.reshape(len(rows), -1).sum(axis=1)[1:-1]
