"""Shallow water: a travelling hump, the breaking dam, the reflection of an absorbing layer."""

import math
from dataclasses import dataclass

import numpy as np


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
