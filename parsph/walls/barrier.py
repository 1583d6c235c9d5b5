"""What no particle goes through: the lines of polygon walls.

Ghosts hold the fluid back by pressure. A lone particle that hits a wall hard, or that is wedged into a corner, can slip
between them, since the force of a pair vanishes where two particles meet. So a particle nearer to a wall than a quarter of
the spacing keeps no velocity into it, ``v -> v - min((v - v_w) . n, 0) n``, and one behind it is put back on its line. In calm
water, half a spacing away, nothing happens; it takes energy and never gives any (of a wall at rest).
"""

import itertools
from dataclasses import dataclass

import numpy as np

from ..jit import jit
from ..particles import FIRST_GHOST

NEAR, DEEPEST = 0.25, 2.0  # spacings: in front of a wall, and behind it


@dataclass(frozen=True)
class Lines:
    """Wetted edges that move together.

    Attributes
    ----------
    edges : ndarray, shape (n, 2, 2)
        [m]
    normals : ndarray, shape (n, 2)
        Into the fluid.
    ends : ndarray of bool, shape (n, 2)
        Which ends of the edges lie in a corner of the fluid, where the line goes on inside the solid.
    motion : Swing, Bulge or None
    """

    edges: np.ndarray
    normals: np.ndarray
    ends: np.ndarray
    motion: object = None


@jit
def from_edge(rows, i, edge, normal):
    """Return how far row `i` is in front of an edge [m], how far along it its foot is [m], and how long the edge is [m]."""
    x, y = rows[i, 0] - edge[0, 0], rows[i, 1] - edge[0, 1]
    ax, ay = edge[1, 0] - edge[0, 0], edge[1, 1] - edge[0, 1]
    length = np.sqrt(ax * ax + ay * ay)
    return x * normal[0] + y * normal[1], (x * ax + y * ay) / length, length


@jit
def nearest_behind(rows, i, first, last, edge_of, edges, normals, beyond):
    """Return the edge that row `i` is the least behind, the one it came through; -1 when it is behind none."""
    nearest, least = -1, -np.inf
    for m in range(first, last):
        e = edge_of[m]
        distance, along, length = from_edge(rows, i, edges[e], normals[e])
        if least < distance < 0.0 and -beyond[e, 0] <= along <= length + beyond[e, 1]:
            nearest, least = e, distance
    return nearest


@jit
def stop_at_edges(rows, tags, starts, cells, first_edge, edge_of, edges, normals, beyond, motion, near, deepest):
    """Take the velocity into a wall from the fluid near it; return how many particles that were.

    Parameters
    ----------
    rows, tags, starts : ndarray
        Particles, and the local cell starts.
    cells, first_edge, edge_of : ndarray of int
        Local cells with walls near them, and for each, from ``first_edge[k]`` to ``first_edge[k + 1]``, the edges.
    edges, normals, beyond, motion : ndarray, shapes (n, 2, 2), (n, 2), (n, 2), (n, 5)
        `beyond`: how far the line goes on at the ends [m]; `motion`: center [m], its velocity [m/s], rate of rotation [1/s].
    near, deepest : float
        From how far in front of an edge to how far behind it [m].
    """
    count = 0
    for k in range(len(cells)):
        for i in range(starts[cells[k]], starts[cells[k] + 1]):
            if tags[i] >= FIRST_GHOST:
                break
            touched, through = False, nearest_behind(rows, i, first_edge[k], first_edge[k + 1], edge_of, edges, normals, beyond)
            for m in range(first_edge[k], first_edge[k + 1]):
                e = edge_of[m]
                distance, along, length = from_edge(rows, i, edges[e], normals[e])
                if not -deepest < distance < near or not -beyond[e, 0] < along < length + beyond[e, 1]:
                    continue
                in_corner = along < beyond[e, 0] or along > length - beyond[e, 1]
                if distance < 0.0 and e != through and not in_corner:  # behind two lines only in a corner of the fluid
                    continue
                u = motion[e, 2] - motion[e, 4] * (rows[i, 1] - motion[e, 1])
                v = motion[e, 3] + motion[e, 4] * (rows[i, 0] - motion[e, 0])
                into = (rows[i, 2] - u) * normals[e, 0] + (rows[i, 3] - v) * normals[e, 1]
                if into < 0.0:
                    rows[i, 2] -= into * normals[e, 0]
                    rows[i, 3] -= into * normals[e, 1]
                    touched = True
                if distance < 0.0:
                    rows[i, 0] -= distance * normals[e, 0]
                    rows[i, 1] -= distance * normals[e, 1]
            count += touched
    return count


class Barrier:
    """The lines of all polygon walls of a scene, and where in a slab they are.

    Parameters
    ----------
    groups : list of Lines
    dx : float
        Particle spacing [m].
    """

    def __init__(self, groups, dx):
        self.groups, self.dx = groups, dx
        self.edges = np.concatenate([group.edges for group in groups])
        self.normals = np.concatenate([group.normals for group in groups])
        self.beyond = np.where(np.concatenate([group.ends for group in groups]), DEEPEST * dx, 0.0)
        self.motion = np.zeros((len(self.edges), 5))
        ends = np.cumsum([0, *(len(group.edges) for group in groups)])
        self._spans = [slice(a, b) for a, b in itertools.pairwise(ends)]
        self._moving = [n for n, group in enumerate(groups) if group.motion is not None]
        self._fixed = [e for n, span in enumerate(self._spans) if n not in self._moving for e in range(span.start, span.stop)]
        self.stopped = 0

    def distribute(self, grid, slab):
        """Find the cells of `slab` that the edges which stand still run through or near."""
        self._grid, self._slab = grid, slab
        self._still = self._cells_of(self._fixed)
        self._table = self._as_table(self._still)
        self._tabled = np.full_like(self.edges, np.inf if self._moving else 0.0)

    def _cells_of(self, edges):
        """Return pairs (local cell, edge) of cells within reach of `edges`, shape (n, 2)."""
        grid, slab, pairs = self._grid, self._slab, []
        for e in edges:
            low, high = self.edges[e].min(axis=0) - self.dx, self.edges[e].max(axis=0) + self.dx
            first = np.floor((low - np.array(grid.low)) / grid.cell).astype(int)
            last = np.floor((high - np.array(grid.low)) / grid.cell).astype(int)
            first = np.maximum(first, [slab.first, 0])
            last = np.minimum(last, [slab.last - 1, grid.shape[1] - 1])
            columns, heights = (np.arange(a, b + 1) for a, b in zip(first, last, strict=True))
            x, y = (axis.ravel() for axis in np.meshgrid(columns, heights, indexing="ij"))
            middle = np.stack([x + 0.5, y + 0.5], axis=1) * grid.cell + np.array(grid.low)
            off = np.abs((middle - self.edges[e, 0]) @ self.normals[e]) < 0.7072 * grid.cell + self.dx
            cells = (x - slab.first + 1) * grid.stride + y
            pairs.append(np.stack([cells[off], np.full(off.sum(), e)], axis=1))
        return np.concatenate(pairs) if pairs else np.zeros((0, 2), np.int64)

    @staticmethod
    def _as_table(pairs):
        """Return (cells, where the edges of each begin, edges), cells in rising order."""
        order = np.lexsort((pairs[:, 1], pairs[:, 0]))
        cells, first = np.unique(pairs[order, 0], return_index=True)
        return cells, np.append(first, len(pairs)), np.ascontiguousarray(pairs[order, 1])

    def move(self, time):
        """Put the edges where they are at `time` [s]."""
        for n in self._moving:
            group, span = self.groups[n], self._spans[n]
            now = group.motion.at(time)
            self.edges[span] = now.place(group.edges.reshape(-1, 2)).reshape(-1, 2, 2)
            self.normals[span] = now.turn(group.normals, group.edges.mean(axis=1))
            self.motion[span] = now.motion(self.edges[span].mean(axis=1))
        if self._moving and np.abs(self.edges - self._tabled).max() > 0.5 * self.dx:  # cells are found with a margin of dx
            self._tabled = self.edges.copy()
            moved = [e for n in self._moving for e in range(self._spans[n].start, self._spans[n].stop)]
            self._table = self._as_table(np.concatenate([self._still, self._cells_of(moved)]))

    def hold(self, particles, starts, time):
        """Stop the fluid of the slab at the walls as they stand at `time` [s]."""
        self.move(time)
        p, dx = particles, self.dx
        numbers = self.edges, self.normals, self.beyond, self.motion, NEAR * dx, DEEPEST * dx
        self.stopped += stop_at_edges(p.shared, p.tags, starts, *self._table, *numbers)
