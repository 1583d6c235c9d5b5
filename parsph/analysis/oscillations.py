"""Oscillations that die away."""

import math
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .records import record_of, whole_periods


@dataclass(frozen=True)
class Oscillation:
    """An oscillation that dies away, ``a exp(-b t) cos(w t + p)``.

    Attributes
    ----------
    amplitude : float
        a, in the unit of the record.
    rate : float
        b [1/s].
    frequency : float
        w [1/s].
    phase : float
        p [rad].
    """

    amplitude: float
    rate: float
    frequency: float
    phase: float

    @property
    def loss(self):
        """What a period takes of the amplitude [-]."""
        return 1.0 - math.exp(-self.rate * 2 * math.pi / self.frequency)


def oscillation(t, values, frequency):
    """Return the `Oscillation` that fits a record best, in the sense of least squares.

    Parameters
    ----------
    t, values : array_like, shape (samples,)
        Times [s], and a record of any unit that begins near its largest.
    frequency : float
        About what it is expected to be [1/s].

    Raises
    ------
    SceneError
        When the record is shorter than a period, or is no such oscillation.
    """
    from scipy.optimize import curve_fit  # slow to import, and few need it

    t, values = record_of(t, values)
    whole_periods(t, 2 * math.pi / frequency)

    def wave(t, amplitude, rate, frequency, phase):
        return amplitude * np.exp(-rate * t) * np.cos(frequency * t + phase)

    try:
        fit, _ = curve_fit(wave, t, values, p0=(values[0], 3e-3 * frequency, frequency, 0.0))
    except RuntimeError:
        why, cure = "the least-squares fit does not converge", "a record of clear oscillations"
        raise SceneError("is no oscillation that dies away", where="record", why=why, cure=cure) from None
    return Oscillation(*map(float, fit))
