"""Which rank works out what for the points of walls that all ranks know."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Part:
    """Ghosts or markers that move together: their places in the tables, and what moves them.

    Attributes
    ----------
    rows : slice
    motion : Swing, Bulge or None
    """

    rows: slice
    motion: object


class Share:
    """What one rank has to do with points whose values come from the fluid at other points, or at themselves.

    Parameters
    ----------
    position, source : ndarray, shape (n, dim)
        Where values are needed, and where they come from [m]: ghosts and their mirror points; markers are their own source.
    grid : Grid
    cuts : sequence of int
        Column cuts between the ranks.
    rank : int

    Attributes
    ----------
    standing : ndarray of int
        Points that stand in its columns.
    mine : ndarray of int
        Points whose sources are in its columns, in the order of their cells.
    points, cells : ndarray, shapes (n, dim) and (n,)
        Those sources [m], and their local cells.
    sent, received : dict of int to ndarray
        By rank: whose values go there, and come from there.
    """

    def __init__(self, position, source, grid, cuts, rank):
        inside = _inside(position, grid, 0) & _inside(source, grid, 1)
        column, source_column = grid.column_of(position[:, 0]), grid.column_of(source[:, 0])
        cuts = np.asarray(cuts)
        owner = np.searchsorted(cuts, source_column, side="right") - 1

        def needed(other):
            return inside & (column >= cuts[other] - 1) & (column <= cuts[other + 1])

        first, last = cuts[rank], cuts[rank + 1]
        self.standing = np.flatnonzero(inside & (column >= first) & (column < last))
        is_mine = inside & (owner == rank)
        self.mine, self.cells = in_cells(np.flatnonzero(is_mine), source, grid, first)
        self.points = source[self.mine]
        takers = np.unique(
            np.searchsorted(cuts, np.clip(column[is_mine][:, None] + [-1, 0, 1], 0, cuts[-1] - 1), side="right") - 1
        )
        sent = {int(other): np.flatnonzero(is_mine & needed(other)) for other in takers if other != rank}
        here = needed(rank)
        givers = np.unique(owner[here])
        self.sent = {other: rows for other, rows in sent.items() if len(rows)}
        self.received = {int(other): np.flatnonzero(here & (owner == other)) for other in givers if other != rank}


def in_cells(chosen, points, grid, first):
    """Return the numbers `chosen` of points [m] in the order of their cells, and their local cells in a slab that begins with
    the column `first`.
    """
    index = np.floor((points[chosen] - np.array(grid.low)) / grid.cell).astype(np.int64)
    cells = np.ravel_multi_index(tuple(index.T), grid.shape) - (first - 1) * grid.stride
    order = np.argsort(cells, kind="stable")
    return chosen[order], cells[order]


def _inside(points, grid, margin):
    """Whether points lie in the grid, so many cells away from its edge."""
    index = np.floor((points - np.array(grid.low)) / grid.cell)
    return ((index >= margin) & (index < np.array(grid.shape) - margin)).all(axis=1)
