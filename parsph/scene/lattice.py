"""Square lattices of particles in blocks of fluid."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

PLACED = 1_000_000  # particles that are placed in order to count them


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


@dataclass(frozen=True)
class Filling:
    """The part of a lattice that lies in a block of any shape, half a spacing away from walls.

    A particle that would stand nearer to a wall is moved away from it. Together they fill the area of the block.

    Attributes
    ----------
    lattice : Lattice
        That of the block's bounding box.
    area : shapely geometry
        The block without what is solid [m].
    boundaries : tuple of Boundary
        The walls (`parsph.geometry`).
    """

    lattice: Lattice
    area: object
    boundaries: tuple

    @cached_property
    def position(self):
        """Positions of all particles [m], shape (n, 2)."""
        from ..geometry import contains  # slow to import, and few scenes need it

        _, position = self.lattice.lines(np.ones(self.lattice.shape[0], bool))
        position = position[contains(self.area, position)]
        for boundary in self.boundaries:
            position = boundary.pushed_off(position, 0.5 * min(self.lattice.step))
        return position

    @property
    def count(self):
        """Number of particles."""
        return len(self.position)

    @property
    def about(self):
        """Number of particles; by the area alone where there are so many that it would take long to place them."""
        return self.count if self.lattice.count <= PLACED else round(self.area.area / self.lattice.volume)

    @property
    def first(self):
        """Where the first particle stands [m]."""
        return self.position[0].tolist()

    @property
    def volume(self):
        """What each particle fills [m^2]."""
        return self.area.area / self.count

    def column_counts(self, grid):
        """Return the number of particles in each column of a grid."""
        return np.bincount(grid.column_of(self.position[:, 0]), minlength=grid.columns).astype(float)

    def between(self, grid, first, last):
        """Return (numbers, positions [m]) of the particles in the columns ``first:last`` of a grid."""
        columns = grid.column_of(self.position[:, 0])
        chosen = np.flatnonzero((columns >= first) & (columns < last))
        return chosen, self.position[chosen]
