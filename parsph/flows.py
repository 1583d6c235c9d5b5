"""Exact flows without walls and weight: a rotating patch, a stretching drop, vortices.

Each knows velocity and pressure of an incompressible fluid at the beginning; those that have a later time know that too.
"""

import math
from dataclasses import dataclass

import numpy as np

TERMS = 40  # of a series whose terms fall as 1/m^3, and faster inside


@dataclass(frozen=True)
class Patch:
    """A piece of fluid with a free surface all around it.

    Attributes
    ----------
    low, high : tuple of float
        Corners of the box around it at t = 0 [m].
    rate : float
        How fast it begins to turn or to stretch [1/s].
    rho0 : float
        Density [kg/m^3].
    """

    low: tuple
    high: tuple
    rate: float
    rho0: float

    key = "rate"  # of a scene's block

    @property
    def middle(self):
        """Of the box [m], shape (2,)."""
        return np.add(self.low, self.high) / 2

    @property
    def extents(self):
        """Of the box [m], shape (2,)."""
        return np.subtract(self.high, self.low)


class RotatingPatch(Patch):
    """A rectangle that begins to turn as a solid, counter-clockwise, with the angular velocity `rate`.

    Its corners are thrown out, and the pressure inside is below zero: a fluid that does not bear that tears.
    """

    @property
    def fastest(self):
        """Largest speed at t = 0 [m/s]."""
        return abs(self.rate) * math.hypot(*self.extents) / 2

    def velocity(self, position):
        """Return the velocity [m/s] at t = 0 at positions [m], both of shape (n, 2)."""
        x, y = (np.asarray(position) - self.middle).T
        return self.rate * np.stack([-y, x], axis=1)

    def pressure(self, position):
        """Return the pressure [Pa] at t = 0, shape (n,): ``laplace p = 2 rho omega^2``, zero at the surface.

        ``p = rho omega^2 (x (x - a) + sum over odd m of 8 a^2/k^3 sin(k x/a) cosh(k (y - b/2)/a)/cosh(k b/(2 a)))``, k = m pi,
        from the lower left corner of a rectangle a x b: one of the two sums of Colagrossi (2005) carried out.
        """
        x, y = (np.asarray(position) - self.low).T
        a, b = self.extents
        wave = np.pi * np.arange(1, 2 * TERMS, 2)[:, None]
        from_edge = np.minimum(y, b - y)  # cosh(u)/cosh(v) by decaying exponentials: both overflow
        decay = np.exp(-wave * from_edge / a) * (1 + np.exp(-wave * (b - 2 * from_edge) / a)) / (1 + np.exp(-wave * b / a))
        series = (8 * a**2 / wave**3 * np.sin(wave * x / a) * decay).sum(axis=0)
        return self.rho0 * self.rate**2 * (x * (x - a) + series)


class StretchingDrop(Patch):
    """An ellipse that stretches, u = -A x, v = A y from its middle, with A the `rate` at t = 0: Monaghan (1994).

    It stays an ellipse, of the same area and with a pressure that falls from its middle to zero at its surface.
    """

    @property
    def fastest(self):
        """Largest speed at t = 0 [m/s]."""
        return abs(self.rate) * max(self.extents) / 2

    def velocity(self, position):
        """Return the velocity [m/s] at t = 0 at positions [m], both of shape (n, 2)."""
        x, y = (np.asarray(position) - self.middle).T
        return self.rate * np.stack([-x, y], axis=1)

    def pressure(self, position):
        """Return the pressure [Pa] at t = 0, shape (n,): ``rho A^2 a^2 b^2/(a^2 + b^2) (1 - x^2/a^2 - y^2/b^2)``."""
        axes = self.extents / 2
        x, y = ((np.asarray(position) - self.middle) / axes).T
        return self.rho0 * self.rate**2 / (axes**-2.0).sum() * (1 - x**2 - y**2)

    def half_axes(self, position):
        """Return the half axes [m], shape (2,), of the upright ellipse with the second moments of particles at positions [m].

        They are twice the RMS of what the particles, shape (n, 2), are off the middle.
        """
        return 2 * np.sqrt(((np.asarray(position) - self.middle) ** 2).mean(axis=0))

    def at(self, time):
        """Return rate A [1/s] and half axes a, b [m] at `time` [s].

        ``dA/dt = A^2 (a^2 - b^2)/(a^2 + b^2)``, ``da/dt = -A a``, ``db/dt = A b``.
        """
        from scipy.integrate import solve_ivp  # slow to import, and few need it

        def rates(_, state):
            rate, a, b = state
            return rate**2 * (a**2 - b**2) / (a**2 + b**2), -rate * a, rate * b

        start = [self.rate, *self.extents / 2]
        return solve_ivp(rates, (0.0, time), start, rtol=1e-10, atol=1e-12 * start[1]).y[:, -1]


@dataclass(frozen=True)
class TaylorGreen:
    """Four vortices in a square that repeats in both directions, and decays by viscosity: Taylor & Green (1937).

    Attributes
    ----------
    low : tuple of float
        Lower corner of the square [m].
    length : float
        Its edge L [m].
    speed : float
        Largest velocity U [m/s].
    nu : float
        Kinematic viscosity [m^2/s].
    rho0 : float
        Density [kg/m^3].
    """

    low: tuple
    length: float
    speed: float
    nu: float
    rho0: float

    key = "speed"  # of a scene's block

    @property
    def fastest(self):
        """Largest speed at t = 0 [m/s]."""
        return self.speed

    @property
    def decay(self):
        """Rate at which velocities decay, ``8 pi^2 nu/L^2`` [1/s]."""
        return 8 * math.pi**2 * self.nu / self.length**2

    def _phases(self, position):
        return 2 * np.pi / self.length * (np.asarray(position) - self.low).T

    def velocity(self, position, time=0.0):
        """Return the velocity [m/s] at `time` [s] at positions [m], both of shape (n, 2).

        ``u = -U exp(-decay t) cos X sin Y, v = U exp(-decay t) sin X cos Y`` with X, Y = 2 pi (x, y)/L.
        """
        x, y = self._phases(position)
        return self.speed * math.exp(-self.decay * time) * np.stack([-np.cos(x) * np.sin(y), np.sin(x) * np.cos(y)], axis=1)

    def pressure(self, position, time=0.0):
        """Return the pressure [Pa] at `time` [s], shape (n,): ``-rho U^2/4 exp(-2 decay t) (cos 2X + cos 2Y)``."""
        x, y = self._phases(position)
        return -0.25 * self.rho0 * self.speed**2 * math.exp(-2 * self.decay * time) * (np.cos(2 * x) + np.cos(2 * y))


FLOWS = {"rotation": RotatingPatch, "stretching": StretchingDrop, "vortices": TaylorGreen}
