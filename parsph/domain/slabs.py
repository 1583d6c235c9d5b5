"""Who owns which columns."""

from dataclasses import dataclass

import numpy as np

from ..columns import Grid
from ..errors import SceneError


@dataclass(frozen=True)
class Slab:
    """The columns ``first:last`` of a grid.

    Local columns and cells begin one column before `first`, with the left halo; the last local column is the right halo.
    """

    grid: Grid
    first: int
    last: int

    @property
    def columns(self):
        """Number of owned columns."""
        return self.last - self.first

    @property
    def cells(self):
        """Number of owned cells."""
        return self.columns * self.grid.stride


def balanced_cuts(cost, ranks, left=1, right=1, old=None):
    """Return the cuts that share the columns among ranks at nearly equal cost.

    Parameters
    ----------
    cost : ndarray, shape (columns,)
        Cost of each column.
    ranks : int
    left, right : int
        Columns that the first and the last rank must hold: those of end walls or periodic ends, and of images there.
    old : sequence of int, optional
        Present cuts. A cut then moves at most to the next old one, so that particles only go to a neighbour.

    Returns
    -------
    tuple of int
        ``ranks + 1`` cuts; rank r owns the columns ``cuts[r]:cuts[r + 1]``.

    Raises
    ------
    SceneError
        When there are fewer columns than the ranks need.
    """
    columns = len(cost)
    most = most_ranks(columns, left, right)
    if ranks > most:
        raise SceneError(
            f"too many ranks: {ranks} for {columns} columns of cells",
            where="mpirun",
            why=f"each rank needs a column, the first {left} and the last {right} of them for the ends of the domain",
            cure=f"use at most {most} ranks, or a finer resolution",
        )
    total = np.concatenate([[0.0], np.cumsum(cost)])
    cuts = [0]
    for rank in range(1, ranks):
        target = total[-1] * rank / ranks
        cut = int(np.searchsorted(total, target))
        if cut > 0 and target - total[cut - 1] < total[cut] - target:
            cut -= 1
        low = max(cuts[-1] + 1, left + rank - 1)
        high = columns - right - (ranks - 1 - rank)
        if old is not None:
            low, high = max(low, old[rank - 1] + 1), min(high, old[rank + 1] - 1)
        cuts.append(min(max(cut, low), high))
    return (*cuts, columns)


def most_ranks(columns, left, right):
    """Return how many ranks so many columns are enough for, when `left` and `right` of them at the ends stay together."""
    return max(1, columns - left - right + 2)


def imbalance(cost, cuts):
    """Return the largest share of the `cost` of columns, shape (columns,), over the mean share of the ranks."""
    shares = np.add.reduceat(cost, cuts[:-1])
    return float(shares.max() / shares.mean()) if shares.any() else 1.0
