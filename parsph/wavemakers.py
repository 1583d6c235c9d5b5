"""Wavemakers: walls that move by a prescribed law."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Motion:
    """Where a rotating wall stands: angle [rad], its rate [1/s] and its acceleration [1/s^2]."""

    angle: float
    rate: float
    acceleration: float


@dataclass(frozen=True)
class Palette:
    """A flap hinged at the bed, ``theta(t) = ramp(t) theta0 sin(2 pi t / P)``; positive leans towards +x.

    The ramp is ``(1 - cos(pi t / T))/2`` up to T, so angle, rate and acceleration start from zero. A single oscillation
    ends after one period, at rest in the upright position.

    Attributes
    ----------
    hinge : tuple of float
        Position of the hinge [m].
    amplitude : float
        theta0 [rad].
    period : float
        P [s].
    ramp : float
        T [s], 0 for a sudden start.
    single : bool
        One oscillation only.
    """

    hinge: tuple
    amplitude: float
    period: float
    ramp: float = 0.0
    single: bool = False

    def at(self, time):
        """Return the `Motion` at `time` [s]."""
        if time <= 0 or (self.single and time >= self.period):
            return Motion(0.0, 0.0, 0.0)
        w = 2 * math.pi / self.period
        s, c = math.sin(w * time), math.cos(w * time)
        r, dr, ddr = 1.0, 0.0, 0.0
        if time < self.ramp:
            a = math.pi / self.ramp
            r = 0.5 * (1 - math.cos(a * time))
            dr = 0.5 * a * math.sin(a * time)
            ddr = 0.5 * a * a * math.cos(a * time)
        return Motion(
            self.amplitude * r * s,
            self.amplitude * (dr * s + r * w * c),
            self.amplitude * (ddr * s + 2 * dr * w * c - r * w * w * s),
        )

    def reach(self, height):
        """Return the largest excursion [m] of the plate at `height` [m] above the hinge."""
        return height * math.tan(self.amplitude)
