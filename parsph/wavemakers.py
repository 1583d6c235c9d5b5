"""Wavemakers: walls that move by a prescribed law."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """Where a rotating wall stands: angle [rad], its rate [1/s] and its acceleration [1/s^2]."""

    angle: float
    rate: float
    acceleration: float


def oscillation(time, period, ramp):
    """Return s, ds/dt [1/s], d2s/dt2 [1/s^2] of ``s(t) = ramp(t) sin(2 pi t / P)``, at rest before t = 0.

    The ramp is ``(1 - cos(pi t / T))/2`` up to T = `ramp` [s], so that all three start from zero; 1 after it.
    """
    if time <= 0:
        return 0.0, 0.0, 0.0
    w = 2 * math.pi / period
    s, c = math.sin(w * time), math.cos(w * time)
    r, dr, ddr = 1.0, 0.0, 0.0
    if time < ramp:
        a = math.pi / ramp
        r = 0.5 * (1 - math.cos(a * time))
        dr = 0.5 * a * math.sin(a * time)
        ddr = 0.5 * a * a * math.cos(a * time)
    return r * s, dr * s + r * w * c, ddr * s + 2 * dr * w * c - r * w * w * s


@dataclass(frozen=True)
class Placement:
    """Where a rigid body in the plane stands and how it moves at a time.

    Attributes
    ----------
    center : ndarray, shape (2,)
        The point that it turns about, at rest [m].
    offset, offset_rate, offset_acceleration : ndarray, shape (2,)
        Way [m], velocity [m/s] and acceleration [m/s^2] of that point.
    angle, rate, spin : float
        Counter-clockwise angle [rad], angular velocity [1/s] and acceleration [1/s^2].
    """

    center: np.ndarray
    offset: np.ndarray
    offset_rate: np.ndarray
    offset_acceleration: np.ndarray
    angle: float = 0.0
    rate: float = 0.0
    spin: float = 0.0

    def turn(self, vectors):
        """Return `vectors`, shape (n, 2), turned with the body."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        return np.stack([c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]], axis=1)

    def place(self, points):
        """Return where `points` of the body at rest, shape (n, 2), are now [m]."""
        return self.turn(points - self.center) + self.center + self.offset

    def velocity(self, points):
        """Return the velocity [m/s] of the body at the present `points`, shape (n, 2) [m]."""
        arm = points - self.center - self.offset
        return self.offset_rate + self.rate * np.stack([-arm[:, 1], arm[:, 0]], axis=1)

    def acceleration(self, points):
        """Return the acceleration [m/s^2] of the body at the present `points`, shape (n, 2) [m]."""
        arm = points - self.center - self.offset
        return self.offset_acceleration + self.spin * np.stack([-arm[:, 1], arm[:, 0]], axis=1) - self.rate**2 * arm


@dataclass(frozen=True)
class Swing:
    """A rigid body that swings to and fro, along a line and about a point, ``ramp(t) sin(2 pi t / P)`` times its amplitudes.

    Attributes
    ----------
    way : tuple of float
        Amplitude of the way [m].
    angle : float
        Amplitude of the angle, counter-clockwise [rad].
    center : tuple of float
        What it turns about, at rest [m].
    period, ramp : float
        P [s]; duration of the smooth start [s].
    """

    way: tuple
    angle: float
    center: tuple
    period: float
    ramp: float = 0.0

    def at(self, time):
        """Return the `Placement` at `time` [s]."""
        s, ds, dds = oscillation(time, self.period, self.ramp)
        way, angle = np.array(self.way, float), self.angle
        return Placement(np.array(self.center, float), s * way, ds * way, dds * way, s * angle, ds * angle, dds * angle)


@dataclass(frozen=True)
class Palette:
    """A flap hinged at the bed, ``theta(t) = theta0 ramp(t) sin(2 pi t / P)``; positive leans towards +x.

    A single oscillation ends after one period, at rest in the upright position.

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
        if self.single and time >= self.period:
            return Motion(0.0, 0.0, 0.0)
        return Motion(*(self.amplitude * value for value in oscillation(time, self.period, self.ramp)))

    def reach(self, height):
        """Return the largest excursion [m] of the plate at `height` [m] above the hinge."""
        return height * math.tan(self.amplitude)
