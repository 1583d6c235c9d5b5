"""Linear wave theory: dispersion, the seiche, the wavemaker's far field. No solver needed."""

import math
from dataclasses import dataclass

import numpy as np


def angular_frequency(wavenumber, depth, gravity):
    """Return omega [1/s] = sqrt(g k tanh(k d)), Szmidt eq. (41), for k [1/m], d [m], g [m/s^2]."""
    return math.sqrt(gravity * wavenumber * math.tanh(wavenumber * depth))


def wavenumber(frequency, depth, gravity):
    """Return the k [1/m] that solves omega^2 = g k tanh(k d).

    Parameters
    ----------
    frequency : float
        Angular frequency omega [1/s], > 0.
    depth, gravity : float
        Still-water depth [m] and gravity [m/s^2].
    """
    from scipy.optimize import brentq  # slow to import, and few runs need it

    deep, shallow = frequency**2 / gravity, frequency / math.sqrt(gravity * depth)
    return brentq(lambda k: gravity * k * math.tanh(k * depth) - frequency**2, 0.999 * deep, deep + shallow, xtol=1e-14)


def flap_transfer(kd):
    """Return H/S of a flap hinged at the bed, S the full stroke at the still-water level.

    ``H/S = (4 sinh kd / kd) (kd sinh kd - cosh kd + 1) / (sinh 2kd + 2kd)``, Biesel (1951), first order, far field.
    """
    sinh, cosh = math.sinh(kd), math.cosh(kd)
    return 4 * sinh / kd * (kd * sinh - cosh + 1) / (math.sinh(2 * kd) + 2 * kd)


def flap_height(amplitude, period, depth, gravity):
    """Return the far-field wave height [m] of a flap hinged at the bed, angle amplitude [rad], period [s]."""
    kd = wavenumber(2 * math.pi / period, depth, gravity) * depth
    return 2 * depth * math.tan(amplitude) * flap_transfer(kd)


def viscosity_of_alpha(alpha, h, c0, dim):
    """Return the kinematic viscosity [m^2/s] that artificial viscosity `alpha` stands for: alpha h c0 / (2 (dim + 2))."""
    return alpha * h * c0 / (2 * (dim + 2))


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
