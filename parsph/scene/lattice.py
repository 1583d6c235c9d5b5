"""Square lattices of particles in a block."""

from dataclasses import dataclass

import numpy as np


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
    def per_line(self):
        """Number of particles that share an x."""
        return self.count // self.shape[0] if self.shape[0] else 0

    def x(self):
        """Return the x of each line [m], shape (shape[0],)."""
        return self.low[0] + self.step[0] * (np.arange(self.shape[0]) + 0.5)

    def lines(self, chosen):
        """Return (numbers, positions [m]) of the particles of the lines where `chosen` is true."""
        axes = [self.x()[chosen]]
        for low, step, n in zip(self.low[1:], self.step[1:], self.shape[1:], strict=True):
            axes.append(low + step * (np.arange(n) + 0.5))
        position = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
        first = np.flatnonzero(chosen) * self.per_line
        return (first[:, None] + np.arange(self.per_line)).ravel(), position
