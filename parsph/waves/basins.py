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


@dataclass(frozen=True)
class Sloshing:
    """Linear waves in a rectangular tank that is shaken along its bed.

    The modes cos(k_n x), k_n = n pi / L with n odd, follow ``b_n'' + w_n^2 b_n = 4/(n pi) tanh(k_n d) X''``, with x from the
    left wall and X the way of the tank: Faltinsen & Timokha (2009), section 5.3.

    Attributes
    ----------
    length, depth : float
        Of the water [m].
    gravity : float
        [m/s^2]
    modes : int
        How many count.
    """

    length: float
    depth: float
    gravity: float
    modes: int = 5

    @property
    def wavenumbers(self):
        """k_n [1/m], shape (modes,)."""
        return np.arange(1, 2 * self.modes, 2) * math.pi / self.length

    def momentum(self, times, motion):
        """Return the momentum of the water along the bed over its mass [m/s] at `times` [s], from rest at the first.

        ``X' - sum over n of 2 b_n'/(L d k_n^2)``.

        Parameters
        ----------
        times : array_like, shape (n,)
            [s]
        motion : callable
            Takes a time and gives velocity [m/s] and acceleration [m/s^2] of the tank.
        """
        from scipy.integrate import solve_ivp  # slow to import, and few need it

        k = self.wavenumbers
        squares = self.gravity * k * np.tanh(k * self.depth)
        forcing = 4 / (k * self.length) * np.tanh(k * self.depth)

        def rates(time, state):
            return np.concatenate([state[self.modes :], forcing * motion(time)[1] - squares * state[: self.modes]])

        span, start = (times[0], times[-1]), np.zeros(2 * self.modes)
        speeds = solve_ivp(rates, span, start, t_eval=times, rtol=1e-8, atol=1e-10).y[self.modes :]
        return np.array([motion(time)[0] for time in times]) - 2 / (self.length * self.depth) * (speeds.T / k**2).sum(axis=1)
