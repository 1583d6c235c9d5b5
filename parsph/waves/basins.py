"""Standing waves in basins."""

import math
from dataclasses import dataclass

import numpy as np

from .linear import angular_frequency


@dataclass(frozen=True)
class Seiche:
    """The first standing wave of a rectangular basin, still surface and largest velocity at t = 0.

    Attributes
    ----------
    length, depth : float
        Basin [m].
    amplitude : float
        Amplitude A of the surface [m].
    gravity : float
        [m/s^2]
    """

    length: float
    depth: float
    amplitude: float
    gravity: float

    @property
    def wavenumber(self):
        """Pi / L [1/m]."""
        return math.pi / self.length

    @property
    def frequency(self):
        """Angular frequency [1/s], Szmidt eq. (41)."""
        return angular_frequency(self.wavenumber, self.depth, self.gravity)

    def velocity(self, position):
        """Return the velocity [m/s] at t = 0, shape (n, 2), for positions [m] from the basin's lower left corner.

        Szmidt eq. (43).
        """
        k, kd = self.wavenumber, self.wavenumber * self.depth
        x, z = np.asarray(position).T
        scale = self.amplitude * self.gravity * k / self.frequency / math.cosh(kd)
        return scale * np.stack([-np.cosh(k * z) * np.sin(k * x), np.sinh(k * z) * np.cos(k * x)], axis=1)

    def share(self, position, velocity):
        """Return how much of the mode particles move with, 1 at t = 0: ``sum(v . phi) / sum(phi . phi)``, phi of eq. (43).

        Parameters
        ----------
        position, velocity : ndarray, shape (n, 2)
            [m] from the basin's lower left corner, [m/s].
        """
        mode = self.velocity(position)
        return float((velocity * mode).sum() / (mode**2).sum())
