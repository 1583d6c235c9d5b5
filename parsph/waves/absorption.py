"""Active absorption by a paddle that follows the level in front of it: how to tune it, and what it sends back by linear theory.

A wave ``a exp(iwt)`` that comes to a paddle at rest goes back with the amplitude a. Let the paddle move with the speed
``U = -G H eta``, H = 1/(1 + i w tau) a lag, eta the level at the distance x in front of the paddle that its own waves do not
explain. It sends out ``b = a + F U`` with F = (H/S)/w, and beside it the near field ``E U/(iw)`` (`parsph.waves.paddles`), so

``eta = a exp(ikx) + b exp(-ikx) + E U/(iw)``,
``b/a = 1 - 2 F G H cos kx / (1 + G H (F exp(-ikx) - i E/w))``.

It is 0 where ``G H (F exp(ikx) + i E/w) = 1``: the gauge sees the wave before the paddle does, and the near field is an added
mass, so that a lag is what is needed. In long waves without near field that is G = sqrt(g/d) for a piston (Schaeffer & Klopman
2000, Review of multidirectional active wave absorption methods, J. Waterway Port Coastal Ocean Eng. 126, 88-97).
"""

import cmath
import math

from .linear import dispersion
from .paddles import near_field, transfer


def tuned_absorption(period, depth, gravity, hinge=None, distance=0.0):
    """Return gain G [1/s] and lag tau [s] with which a paddle sends back nothing of waves of a period.

    Parameters
    ----------
    period, depth, gravity : float
        [s], [m], [m/s^2]
    hinge : float, optional
        As in `transfer`.
    distance : float
        x of the gauge from the paddle [m], less than a quarter of the wavelength.
    """
    F, E, kx, w = _paddle(period, depth, gravity, hinge, distance)
    return 1.0 / (F * math.cos(kx)), (F * math.sin(kx) + E / w) / (F * math.cos(kx)) / w


def sent_back(period, depth, gravity, gain, lag, hinge=None, distance=0.0):
    """Return b/a, complex, of waves of a period, with gain G [1/s] and lag tau [s]; other arguments as `tuned_absorption`."""
    F, E, kx, w = _paddle(period, depth, gravity, hinge, distance)
    GH = gain / (1 + 1j * w * lag)
    return 1 - 2 * F * GH * math.cos(kx) / (1 + GH * (F * cmath.exp(-1j * kx) - 1j * E / w))


def _paddle(period, depth, gravity, hinge, distance):
    """Return F [s], E, kx and w [1/s]."""
    wave = dispersion(depth, gravity, period)
    far, near = transfer(wave.kd, hinge), near_field(wave.kd, hinge, distance / depth)
    return far / wave.frequency, near, wave.wavenumber * distance, wave.frequency
