"""From the wave that is asked for to the motion of the plate, and to the level that is then expected in front of it.

Linear theory (Biesel 1951; Dean & Dalrymple 1984, ch. 6): a plate with the way ``X = A sin(w t + p)`` at the still-water
level makes ``eta = a cos(k x - w t - p)`` far from it, a/A = H/S, and beside it a near field in phase with X.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..waves import dispersion, near_modes, regular_wave, second_order_full, transfer
from .signals import Harmonics, Sampled, ramp


@dataclass(frozen=True, eq=False)
class Elevation:
    """The level over still water that a plate makes by linear theory, ramped like its motion.

    Attributes
    ----------
    motion : Harmonics
        Of the plate at the still-water level.
    wavenumbers, far : ndarray, shape (n,)
        k [1/m] and a/A of each component.
    depth : float
        [m]
    hinge : float or None
        Of a flap, over the depth; None for a piston.
    """

    motion: Harmonics
    wavenumbers: np.ndarray
    far: np.ndarray
    depth: float
    hinge: float | None

    @cached_property
    def _modes(self):
        """Wavenumbers times depth and amplitudes of the near field's modes, both of shape (n, modes): absorption asks often."""
        return np.stack([near_modes(k * self.depth, self.hinge) for k in self.wavenumbers], axis=1)

    def at(self, time, x):
        """Return the level [m] at `time` [s] and the distance `x` [m] from the plate at rest."""
        m = self.motion
        if time <= 0:
            return 0.0
        k, share = self._modes
        near = (share * np.exp(-k * (x / self.depth))).sum(axis=1)
        angle = m.frequencies * time + m.phases
        level = m.amplitudes * (self.far * np.cos(self.wavenumbers * x - angle) + near * np.sin(angle))
        return ramp(time, m.ramp)[0] * float(level.sum())


@dataclass(frozen=True)
class SolitaryElevation:
    """The level over still water that a piston makes which follows a solitary wave.

    Attributes
    ----------
    wave : Solitary
    crest : float
        When the crest is at the plate's place at rest [s].
    """

    wave: object
    crest: float

    def at(self, time, x):
        """Return the level [m] at `time` [s] and the distance `x` [m] from the plate at rest."""
        return float(self.wave.elevation(x - self.wave.celerity * (time - self.crest)))


def linear(amplitudes, frequencies, phases, depth, gravity, hinge, duration_of_ramp, duration, repeats=math.inf):
    """Return the motion of the plate that makes ``sum a_j cos(w_j t + p_j)`` at its place, and the `Elevation`.

    Parameters
    ----------
    amplitudes, frequencies, phases : ndarray, shape (n,)
        a_j [m], w_j [1/s], p_j [rad].
    depth, gravity : float
        [m], [m/s^2]
    hinge : float or None
        Height of a flap's hinge over the depth; None for a piston.
    duration_of_ramp, duration, repeats : float
        [s], see `Harmonics`.
    """
    wavenumbers, far = _response(frequencies, depth, gravity, hinge)
    motion = Harmonics(amplitudes / far, frequencies, phases, duration_of_ramp, duration, repeats)
    return motion, Elevation(motion, wavenumbers, far, depth, hinge)


def expected(amplitudes, frequencies, phases, depth, gravity, hinge, duration_of_ramp, duration):
    """Return the `Elevation` that a plate of the way ``sum A_j sin(w_j t + p_j)`` makes; arguments are those of `linear`."""
    motion = Harmonics(amplitudes, frequencies, phases, duration_of_ramp, duration)
    return Elevation(motion, *_response(frequencies, depth, gravity, hinge), depth, hinge)


def _response(frequencies, depth, gravity, hinge):
    """Return k [1/m] and a/A of waves of the angular frequencies [1/s], both of shape (n,)."""
    wavenumbers = np.array([dispersion(depth, gravity, frequency=w / (2 * math.pi)).wavenumber for w in frequencies])
    return wavenumbers, np.array([transfer(k * depth, hinge) for k in wavenumbers])


def regular(height, wave, depth, gravity, hinge, order, duration_of_ramp, duration):
    """Return the motion of the plate for regular waves, of first or second order, and the linear `Elevation`.

    Parameters
    ----------
    height : float
        H [m].
    wave : Dispersion
    depth, gravity, hinge, duration_of_ramp, duration
        As `linear`.
    order : int
        1: Biesel's stroke for H. 2: for the first harmonic of the stream-function wave of that height, since higher ones have
        their share in it, with the second harmonic that cancels the free one (`parsph.waves.second_order_full`).
    """
    kd, w = wave.wavenumber * depth, 2 * math.pi / wave.period
    far = transfer(kd, hinge)
    amplitude = 0.5 * height
    if order == 2:
        amplitude = float(regular_wave(height, depth, gravity, wavelength=wave.wavelength).elevations[0])
    amplitudes, frequencies, phases = [amplitude / far], [w], [0.0]
    rest = duration_of_ramp, duration, wave.period
    first = Harmonics(np.array(amplitudes), np.array(frequencies), np.array(phases), *rest)
    elevation = Elevation(first, np.array([wave.wavenumber]), np.array([far]), depth, hinge)
    if order == 1:
        return first, elevation
    second = second_order_full(2 * amplitude, kd, depth, hinge)
    both = np.array([*amplitudes, abs(second)]), np.array([w, 2 * w]), np.array([0.0, np.angle(second)])
    return Harmonics(*both, *rest), elevation


def solitary(wave, start):
    """Return the motion of a piston that makes a solitary wave, setting out at `start` [s], and the `SolitaryElevation`.

    Parameters
    ----------
    wave : Solitary
    start : float
        [s]
    """
    t, way = wave.paddle()
    motion = Sampled(t + start, way)
    middle = float(np.interp(0.5 * way[-1], way, t))  # the crest is at the plate, X = 0, at half of the way
    return motion, SolitaryElevation(wave, start + middle - 0.5 * way[-1] / wave.celerity)
