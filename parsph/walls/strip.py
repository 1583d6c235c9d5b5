"""A single row of ghosts whose normal velocities are solved for, Szmidt (2013) eq. (32).

The ghosts stand half a spacing behind the wall and carry pressure and tangential velocity of their mirror points, as other
fixed ghosts do. Their velocities along the normals are the X_k for which the interpolated velocity of the fluid has no
component into the wall, relative to it, at each wall point r between a ghost and its mirror point::

    sum_b V_b (v_b - v_w,r) . n_r W_rb + sum_k V_k (t_k - v_w,r + X_k n_k) . n_r W_rk = 0

b: fluid, k: ghosts, t_k the tangential velocity of ghost k, v_w,r that of the wall. One row fills a part of the kernel only:
the fluid feels a deficit of pressure beyond it, which the paper's results show too. Every rank gets the sums of all wall
points and solves the whole system, a banded one once its unknowns are ordered along the wall (reverse Cuthill & McKee).
"""

from functools import lru_cache

import numpy as np
from scipy.linalg import solve_banded
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.spatial import cKDTree

from ..columns import cells_per_column, strip_offset
from ..jit import jit
from ..kernels import kernel_value
from ..particles import FIRST_GHOST
from .ghosts import FixedGhosts
from .shares import Share


@lru_cache
def compiled_point_sums(dim, kernel):
    """Return the pass that sums the fluid's velocity at points; numbers at run time."""
    strips = 3 ** (dim - 1)

    def sum_at_points(rows, tags, starts, shape, points, cells, numbers, sums):
        """Write sum of V W v and sum of V W at `points` in the local `cells` to `sums`, shape (n, dim + 1)."""
        h, norm = numbers
        stride = cells_per_column(shape)
        for k in range(len(points)):
            sums[k, :] = 0.0
            for strip in range(strips):
                middle = cells[k] + strip_offset(strip, strips, stride, shape)
                for j in range(starts[middle - 1], starts[middle + 2]):
                    if tags[j] >= FIRST_GHOST:
                        continue
                    r2 = 0.0
                    for d in range(dim):
                        r2 += (rows[j, d] - points[k, d]) ** 2
                    VW = rows[j, 2 * dim + 2] / rows[j, 2 * dim] * norm * kernel_value(kernel, np.sqrt(r2) / h)
                    for d in range(dim):
                        sums[k, d] += VW * rows[j, dim + d]
                    sums[k, dim] += VW

    return jit(sum_at_points)


class Strip(FixedGhosts):
    """One row of ghosts with solved normal velocities; made and used as `FixedGhosts`."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._bands = None

    def distribute(self, grid, cuts, rank):
        super().distribute(grid, cuts, rank)
        self._wall_points = 0.5 * (self.position + self.mirror)
        self._at_wall = Share(self._wall_points, self._wall_points, grid, cuts, rank)
        self._shape = grid.shape
        if self.moving or self._bands is None:
            self._bands = self._banded()

    def _banded(self):
        """Return (order of the unknowns, width of the band, matrix of the system in diagonal ordered form, W_rk n_r . n_k)."""
        reach, dim = self.kernel.support * self.h, self.position.shape[1]
        near = cKDTree(self._wall_points).query_ball_tree(cKDTree(self.position), reach)
        r = np.repeat(np.arange(self.count), [len(ghosts) for ghosts in near])
        k = np.concatenate([np.sort(ghosts) for ghosts in near]).astype(int)
        distance = np.linalg.norm(self._wall_points[r] - self.position[k], axis=1)
        weight = self.volume[k] * self.kernel.value(distance, self.h, dim)
        matrix = coo_array((weight * (self.direction[r] * self.direction[k]).sum(axis=1), (r, k)), (self.count,) * 2)
        pattern = coo_array((np.ones(len(r)), (r, k)), (self.count,) * 2).tocsr()
        order = reverse_cuthill_mckee(pattern + pattern.T, symmetric_mode=True)
        place = np.argsort(order)
        rows, columns = place[matrix.row], place[matrix.col]
        width = int(np.abs(rows - columns).max(initial=0))
        bands = np.zeros((2 * width + 1, self.count))
        bands[width + rows - columns, columns] = matrix.data
        self._weights = coo_array((weight, (r, k)), (self.count,) * 2).tocsr()
        return order, width, bands

    def complete(self, particles, starts, communicator):
        """Solve for the normal velocities of all ghosts; collective."""
        dim, wall = self.position.shape[1], self.wall[:, : self.position.shape[1]]
        at_wall = self._at_wall
        sums = np.zeros((len(at_wall.mine), dim + 1))
        numbers = self.h, self.kernel.norms[dim - 1] / self.h**dim
        compiled_point_sums(dim, self.kernel.code)(
            particles.shared, particles.tags, starts, self._shape, at_wall.points, at_wall.cells, numbers, sums
        )
        mine = self.share.mine
        fluid, values = np.zeros((self.count, dim + 1)), self.values.copy()
        for rows, found, ghosts, theirs in communicator.allgather((at_wall.mine, sums, mine, self.values[mine])):
            fluid[rows], values[ghosts] = found, theirs
        normal, velocity = self.direction, values[:, :dim]
        tangential = velocity - (velocity * normal).sum(axis=1)[:, None] * normal
        carried = self._weights @ tangential - (self._weights @ np.ones(self.count))[:, None] * wall
        into = ((fluid[:, :dim] - fluid[:, dim:] * wall + carried) * normal).sum(axis=1)
        order, width, bands = self._bands
        solved = np.empty(self.count)
        solved[order] = solve_banded((width, width), bands, -into[order])
        self.values[:] = values
        self.values[:, :dim] = tangential + solved[:, None] * normal
