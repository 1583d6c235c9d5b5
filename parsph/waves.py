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


def phase_speed(period, depth, gravity):
    """Return c = omega/k [m/s] of linear waves of `period` [s] on `depth` [m], gravity [m/s^2]."""
    frequency = 2 * math.pi / period
    return frequency / wavenumber(frequency, depth, gravity)


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

    def share(self, position, velocity):
        """Return how much of the mode particles move with, 1 at t = 0: ``sum(v . phi) / sum(phi . phi)``, phi of eq. (43).

        Parameters
        ----------
        position, velocity : ndarray, shape (n, 2)
            [m] from the basin's lower left corner, [m/s].
        """
        mode = self.velocity(position)
        return float((velocity * mode).sum() / (mode**2).sum())


def pulse(x, depth, amplitude, center, width, gravity):
    """Return the depth and velocity of a hump that travels to the right on shallow water.

    ``H = H0 + a exp(-(x - x0)^2 / A^2)``, ``v = (H - H0) sqrt(g / H0)``: Molteni et al. eqs. (2.5), (2.6), the latter as a
    wave to the right has it for any H0 (as printed it holds for H0 = 1 m alone).

    Parameters
    ----------
    x : ndarray, shape (n,)
        [m]
    depth, amplitude, center, width, gravity : float
        H0, a, x0, A [m]; g [m/s^2].

    Returns
    -------
    tuple of ndarray, shape (n,)
        H [m] and v [m/s].
    """
    hump = amplitude * np.exp(-(((np.asarray(x) - center) / width) ** 2))
    return depth + hump, hump * math.sqrt(gravity / depth)


@dataclass(frozen=True)
class DamBreak:
    """A dam at x = 0 that breaks at t = 0, in shallow water: Ritter (1892) over dry, Stoker (1957) over wet ground.

    Behind a bore of speed S over the depth h_r the water has the depth h_m and the speed u_m; mass and momentum of the bore,
    ``u_m = S - g h_r/(4S) (1 + sqrt(1 + 8 S^2/(g h_r)))``, ``h_m = h_r/2 (sqrt(1 + 8 S^2/(g h_r)) - 1)``, meet the rarefaction
    ``u_m + 2 sqrt(g h_m) = 2 sqrt(g h_l)``.

    Attributes
    ----------
    left, right : float
        Depths h_l > h_r >= 0 [m].
    gravity : float
        [m/s^2]
    """

    left: float
    right: float
    gravity: float

    def _behind(self, bore):
        ratio = math.sqrt(1 + 8 * bore**2 / (self.gravity * self.right))
        return 0.5 * self.right * (ratio - 1), bore - self.gravity * self.right / (4 * bore) * (1 + ratio)

    @property
    def bore(self):
        """Speed S of the bore, over dry ground of the front [m/s]."""
        from scipy.optimize import brentq

        fastest = 2 * math.sqrt(self.gravity * self.left)
        if self.right == 0:
            return fastest

        def gap(S):
            depth, speed = self._behind(S)
            return speed + 2 * math.sqrt(self.gravity * depth) - fastest

        return brentq(gap, 1.000001 * math.sqrt(self.gravity * self.right), fastest, xtol=1e-14)

    def depth(self, x, t):
        """Return the depth [m] at `x` [m], shape (n,), and `t` [s]."""
        x, c, g = np.asarray(x, float), math.sqrt(self.gravity * self.left), self.gravity
        fan = (2 * c - x / t).clip(0, 3 * c) ** 2 / (9 * g)
        if self.right == 0:
            return fan
        bore = self.bore
        middle, _ = self._behind(bore)
        return np.where(x > bore * t, self.right, np.maximum(fan, middle))


def layer_reflection(sigma0, length, speed, profile="hyperbolic", exponent=1, softening=0.0):
    """Return the reflection that theory gives a layer which damps depth and velocity alike, before a reflecting end.

    Such a layer is matched: what comes back has crossed it twice, ``R = exp(-(2/c) integral of sigma)``. The integral over the
    layer is ``sigma0 ((L + s) ln((L + s)/s) - L)`` for the hyperbolic profile with softening s, ``sigma0 L / (m + 1)`` for the
    power profile.

    Parameters
    ----------
    sigma0, length, speed : float
        Strength [1/s], L [m], speed c of long waves [m/s].
    profile : str
        "hyperbolic" or "power".
    exponent : int
        m of the power profile.
    softening : float
        s = 0.5 h of the hyperbolic profile [m].
    """
    if length == 0:
        return 1.0
    if profile == "hyperbolic":
        integral = sigma0 * ((length + softening) * math.log((length + softening) / softening) - length)
    else:
        integral = sigma0 * length / (exponent + 1)
    return math.exp(-2.0 * integral / speed)
