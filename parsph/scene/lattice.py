"""Square lattices of particles in blocks of fluid."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..parallel import Communicator

PLACED = 1_000_000  # particles that are placed in order to count them
BLOCK = 1 << 15  # places that are looked at together


@dataclass(frozen=True)
class Lattice:
    """A lattice with half a spacing left to the faces of its block, numbered x slowest.

    Attributes
    ----------
    low : tuple of float
        Lower corner of the block [m].
    step : tuple of float
        Spacing in each direction [m]: dx, adjusted so that a whole number fits.
    shape : tuple of int
        Number of particles in each direction.
    """

    low: tuple
    step: tuple
    shape: tuple

    @classmethod
    def of(cls, block, dx):
        """Return the lattice of a scene's block at spacing `dx` [m]."""
        extents = [max(b - a, 0.0) for a, b in zip(block.low, block.high, strict=True)]
        shape = tuple(round(extent / dx) for extent in extents)
        step = tuple(extent / n if n else dx for extent, n in zip(extents, shape, strict=True))
        return cls(tuple(block.low), step, shape)

    @property
    def count(self):
        """Number of particles."""
        return int(np.prod([float(n) for n in self.shape]))

    @property
    def about(self):
        """Number of particles."""
        return self.count

    @property
    def first(self):
        """Where the first particle stands [m]."""
        return [low + 0.5 * step for low, step in zip(self.low, self.step, strict=True)]

    @property
    def volume(self):
        """What each particle fills [m^dim]."""
        return math.prod(self.step)

    @property
    def _per_line(self):
        return self.count // self.shape[0] if self.shape[0] else 0

    @property
    def axes(self):
        """Coordinates of the particles along each axis [m], a list of arrays."""
        return [low + step * (np.arange(n) + 0.5) for low, step, n in zip(self.low, self.step, self.shape, strict=True)]

    def column_counts(self, grid):
        """Return the number of particles in each column of a grid."""
        counts = np.zeros(grid.columns)
        np.add.at(counts, grid.column_of(self.axes[0]), self._per_line)
        return counts

    def between(self, grid, first, last):
        """Return (numbers, positions [m]) of the particles in the columns ``first:last`` of a grid."""
        columns = grid.column_of(self.axes[0])
        return self.lines((columns >= first) & (columns < last))

    def lines(self, chosen):
        """Return (numbers, positions [m]) of the particles of the lines where `chosen` is true."""
        x, *others = self.axes
        axes = [x[chosen], *others]
        position = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
        first = np.flatnonzero(chosen) * self._per_line
        return (first[:, None] + np.arange(self._per_line)).ravel(), position


class Survey(NamedTuple):
    """What stands on each line of a lattice: number of particles, and their smallest and largest x [m], shapes (lines,)."""

    counts: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True)
class Filling:
    """The part of a lattice that lies in a block of any shape, half a spacing away from walls.

    A particle that would stand nearer to a wall is moved away from it. Together they fill the area of the block.
    No rank ever holds more of them than a bounded number of lines, or its own columns.

    Attributes
    ----------
    lattice : Lattice
        That of the block's bounding box.
    area : shapely geometry
        The block without what is solid [m].
    boundaries : tuple of Boundary
        The walls (`parsph.geometry`).
    communicator : Communicator
        Ranks that share the counting: with more than one, all but `first` and `blocks` is collective.
    """

    lattice: Lattice
    area: object
    boundaries: tuple
    communicator: Communicator = field(default_factory=Communicator)

    def blocks(self, lines=None):
        """Yield (lines, particles on each, positions [m], shape (n, 2)) of some lines, by default all, a bounded number at a
        time.
        """
        from ..geometry import contains  # slow to import, and few scenes need it

        lines = np.arange(self.lattice.shape[0]) if lines is None else lines
        together = max(1, BLOCK // max(self.lattice.shape[1], 1))
        for begin in range(0, len(lines), together):
            some = lines[begin : begin + together]
            chosen = np.zeros(self.lattice.shape[0], bool)
            chosen[some] = True
            _, position = self.lattice.lines(chosen)
            inside = contains(self.area, position)
            position = position[inside]
            for boundary in self.boundaries:
                position = boundary.pushed_off(position, 0.5 * min(self.lattice.step))
            yield some, inside.reshape(len(some), -1).sum(axis=1), position

    def _share(self, lines):
        """Return this rank's part of some lines."""
        return np.array_split(lines, self.communicator.size)[self.communicator.rank]

    @cached_property
    def _survey(self):
        found = [[np.zeros(0, int)], [np.zeros(0)], [np.zeros(0)]]
        for lines, counts, position in self.blocks(self._share(np.arange(self.lattice.shape[0]))):
            x = self.lattice.axes[0][lines]
            low, high = x.copy(), x.copy()
            of_line = np.repeat(np.arange(len(lines)), counts)
            np.minimum.at(low, of_line, position[:, 0])
            np.maximum.at(high, of_line, position[:, 0])
            for values, part in zip((counts, low, high), found, strict=True):
                part.append(values)
        parts = self.communicator.allgather([np.concatenate(part) for part in found])
        return Survey(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    @property
    def count(self):
        """Number of particles."""
        return int(self._survey.counts.sum())

    @property
    def about(self):
        """Number of particles; by the area alone where there are so many that it would take long to place them."""
        return self.count if self.lattice.count <= PLACED else round(self.area.area / self.lattice.volume)

    @property
    def first(self):
        """Where the first particle stands [m]."""
        return next(position[0].tolist() for _, _, position in self.blocks() if len(position))

    @property
    def volume(self):
        """What each particle fills [m^2]."""
        return self.area.area / self.count

    def column_counts(self, grid):
        """Return the number of particles in each column of a grid."""
        survey = self._survey
        low, high = grid.column_of(survey.low), grid.column_of(survey.high)
        counts, within = np.zeros(grid.columns), low == high
        np.add.at(counts, low[within], survey.counts[within])
        across = np.zeros(grid.columns)  # of lines whose particles have been moved to both sides of a border
        for _, _, position in self.blocks(self._share(np.flatnonzero(~within))):
            across += np.bincount(grid.column_of(position[:, 0]), minlength=grid.columns)
        return counts + sum(self.communicator.allgather(across))

    def between(self, grid, first, last):
        """Return (numbers, positions [m]) of the particles in the columns ``first:last`` of a grid."""
        survey = self._survey
        before = np.cumsum(survey.counts) - survey.counts
        lines = np.flatnonzero((grid.column_of(survey.high) >= first) & (grid.column_of(survey.low) < last))
        numbers, places = [np.zeros(0, int)], [np.zeros((0, 2))]
        for some, counts, position in self.blocks(lines):
            columns = grid.column_of(position[:, 0])
            chosen = (columns >= first) & (columns < last)
            begins = np.cumsum(counts) - counts
            numbers.append((np.arange(len(position)) + np.repeat(before[some] - begins, counts))[chosen])
            places.append(position[chosen])
        return np.concatenate(numbers), np.concatenate(places)
