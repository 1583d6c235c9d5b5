"""Periodic borders: what leaves the domain at one end of an axis comes in at the other.

The particles near either end have images beyond the other one: copies, moved by the period along the axis, with all that a
row holds. They are made after the images of mirror walls and of those too, axis by axis, so that corners come of themselves.
Both ends of a particle's column are in the same slab where the axis is not x: no message is needed. The ends of x belong to the
first and the last rank, which send each other the copies; a particle that comes in there goes to its rank with the next
migration.
"""

from dataclasses import dataclass

import numpy as np

from ..columns import cell_of
from ..jit import jit
from ..particles import FIRST_GHOST


@jit
def translated_images(rows, tags, cells, close, close_count, first_ghost, end, axis, low, high, bits, grid, reach):
    """Append copies of all particles within `reach` of the ends of an axis, moved by a period.

    Parameters
    ----------
    rows, tags, cells : ndarray
        Particle arrays; images are written from row `end` on.
    close, close_count : ndarray of int32, int
        The fluid rows that may be near an end.
    first_ghost, end : int
        The images that walls made are the rows ``first_ghost:end``.
    axis : int
    low, high : float
        Ends of the axis [m].
    bits : tuple of int
        Bits in the image number of copies beyond the upper end and below the lower one.
    grid : tuple
        (low, 1/cell, shape, first cell of the slab).
    reach : float
        [m]

    Returns
    -------
    int
        End of the images.
    """
    grid_low, inverse, shape, first_cell = grid
    originals = end
    for k in range(close_count + originals - first_ghost):
        i = close[k] if k < close_count else first_ghost + k - close_count
        if cells[i] < 0:
            continue
        x = rows[i, axis]
        for upper in range(2):
            if (high - x if upper else x - low) >= reach:
                continue
            for column in range(rows.shape[1]):
                rows[end, column] = rows[i, column]
            rows[end, axis] = x + low - high if upper else x + high - low
            tags[end] = tags[i] + bits[upper] * FIRST_GHOST
            cells[end] = cell_of(rows, end, grid_low, inverse, shape) - first_cell
            end += 1
    return end


@jit
def come_in(rows, tags, first, last, axis, low, high):
    """Move the fluid of the rows ``first:last`` that left at one end of an axis by a period."""
    for i in range(first, last):
        x = rows[i, axis]
        if tags[i] >= FIRST_GHOST or low <= x < high:
            continue
        if x < low:
            x += high - low
        if x >= high:  # also what was below the lower end by less than a rounding
            x -= high - low
        rows[i, axis] = x


@dataclass(frozen=True)
class PeriodicBorder:
    """Both ends of an axis along which everything repeats.

    Attributes
    ----------
    axis : int
    low, high : float
        Its ends [m].
    bits : tuple of int
        Bits in the image number of copies beyond the upper end and below the lower one, powers of two.
    """

    axis: int
    low: float
    high: float
    bits: tuple

    @property
    def period(self):
        """[m]"""
        return self.high - self.low

    def come_in(self, particles):
        """Bring the fluid that left at one end in at the other.

        Positions at the beginning of a step stay: what an integrator that goes on from there puts beyond an end again comes in
        when the step is over.
        """
        p = particles
        come_in(p.shared, p.tags, p.first, p.last, self.axis, self.low, self.high)

    def copies_of(self, position, reach):
        """Return the copies of what is within `reach` [m] of the ends.

        Parameters
        ----------
        position : ndarray, shape (n, dim)
            [m]
        reach : float

        Returns
        -------
        tuple of ndarray
            Number of the original, shape (m,), position [m], shape (m, dim), and bit, shape (m,), of each copy.
        """
        x = position[:, self.axis]
        near = np.flatnonzero(x - self.low < reach), np.flatnonzero(self.high - x < reach)
        originals, counts = np.concatenate(near), [len(rows) for rows in near]
        copies = position[originals]
        copies[:, self.axis] += np.repeat([self.period, -self.period], counts)
        return originals, copies, np.repeat(self.bits, counts)

    def bands(self, reach, dim):
        """Return the boxes, (low, high) tuples, in which particles have images, one at each end [m]."""
        boxes = []
        for end in (self.low, self.high):
            low, high = np.full(dim, -np.inf), np.full(dim, np.inf)
            low[self.axis], high[self.axis] = end - reach, end + reach
            boxes.append((tuple(low), tuple(high)))
        return boxes
