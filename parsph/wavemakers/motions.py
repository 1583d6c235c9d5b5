"""How walls move: rigid bodies in the plane that slide and turn, walls that bulge."""

import math
from dataclasses import dataclass

import numpy as np

from .signals import Held, oscillation


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

    def turn(self, vectors, points=None):
        """Return `vectors`, shape (n, 2), turned with the body; the same at all `points` of it."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        return np.stack([c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]], axis=1)

    def place(self, points):
        """Return where `points` of the body at rest, shape (n, 2), are now [m]."""
        return self.turn(points - self.center) + self.center + self.offset

    def motion(self, points):
        """Return the center that the body turns about now [m], its velocity [m/s] and the rate [1/s], shape (n, 5)."""
        return np.tile([*(self.center + self.offset), *self.offset_rate, self.rate], (len(points), 1))

    def stretch(self, points):
        """Return how much longer the body is at its `points` at rest, shape (n, 2): rigid bodies keep their length, 1."""
        return 1.0

    def velocity(self, points):
        """Return the velocity [m/s] of the body at the present `points`, shape (n, 2) [m]."""
        arm = points - self.center - self.offset
        return self.offset_rate + self.rate * np.stack([-arm[:, 1], arm[:, 0]], axis=1)

    def acceleration(self, points):
        """Return the acceleration [m/s^2] of the body at the present `points`, shape (n, 2) [m]."""
        arm = points - self.center - self.offset
        return self.offset_acceleration + self.spin * np.stack([-arm[:, 1], arm[:, 0]], axis=1) - self.rate**2 * arm


@dataclass(frozen=True)
class Slide:
    """A rigid body that moves along a line: a piston, or a wall that the fluid pushes.

    Attributes
    ----------
    signal : object
        ``signal.at(time)`` gives its way [m], speed [m/s] and acceleration [m/s^2], ``signal.extent`` the least and the
        largest way [m].
    direction : tuple of float
        Unit vector of the way.
    """

    signal: object
    direction: tuple = (1.0, 0.0)

    def at(self, time):
        """Return the `Placement` at `time` [s]."""
        direction = np.array(self.direction)
        way, speed, acceleration = self.signal.at(time)
        return Placement(np.zeros(2), way * direction, speed * direction, acceleration * direction)

    def extremes(self):
        """Return the `Placement`s at the ends of its way."""
        return [Slide(Held(way), self.direction).at(0.0) for way in self.signal.extent]

    def reach(self, height):
        """Return the least and the largest way [m] along x, at any `height`."""
        return tuple(sorted(self.direction[0] * way for way in self.signal.extent))


@dataclass(frozen=True)
class Flap:
    """A plate that turns about a hinge; positive signals lean it towards +x.

    Attributes
    ----------
    hinge : tuple of float
        [m]
    signal : object
        ``signal.at(time)`` gives the way of the plate [m] at the height `arm` above the hinge along x, and its two rates;
        without an arm the angle [rad] and its two rates.
    arm : float or None
        [m]
    """

    hinge: tuple
    signal: object
    arm: float | None = None

    def at(self, time):
        """Return the `Placement` at `time` [s]; leaning towards +x is a clockwise rotation."""
        angle, rate, spin = self.signal.at(time)
        if self.arm is not None:  # angle = atan(way / arm)
            slope, slope_rate, slope_spin = angle / self.arm, rate / self.arm, spin / self.arm
            square = 1.0 + slope * slope
            angle, rate = math.atan(slope), slope_rate / square
            spin = slope_spin / square - 2.0 * slope * rate * rate
        still = np.zeros(2)
        return Placement(np.array(self.hinge, float), still, still, still, -angle, -rate, -spin)

    def extremes(self):
        """Return the `Placement`s at the ends of its way."""
        return [Flap(self.hinge, Held(way), self.arm).at(0.0) for way in self.signal.extent]

    def reach(self, height):
        """Return the least and the largest way [m] along x of the plate at `height` [m]."""
        slopes = [way / self.arm if self.arm is not None else math.tan(way) for way in self.signal.extent]
        return tuple(slope * max(height - self.hinge[1], 0.0) for slope in slopes)


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

    def extremes(self):
        """Return the `Placement`s at the ends of its swing."""
        return [self.at(time) for time in _quarters(self)]


@dataclass(frozen=True)
class Bulged:
    """Where a bulging wall stands and how it moves at a time: a `Bulge` with its present amplitude.

    Attributes
    ----------
    bulge : Bulge
    amplitude, rate, acceleration_of_middle : float
        Of the middle, along the normal [m], [m/s], [m/s^2].
    """

    bulge: object
    amplitude: float
    rate: float
    acceleration_of_middle: float

    def _at(self, points):
        """Return along and normal, unit vectors; depth [m], shape and slope [1/m] of points, at rest or on the wall."""
        bulge = self.bulge
        start, along = np.array(bulge.start), np.subtract(bulge.end, bulge.start)
        length = math.hypot(*along)
        along = along / length
        normal = np.array([-along[1], along[0]])
        apart = points - start
        place, depth = apart @ along / length, apart @ normal
        inside = (place > 0) & (place < 1)
        wave = np.where(inside, math.pi * place, 0.0)
        return along, normal, depth, np.sin(wave) ** 2, np.pi / length * np.sin(2 * wave)

    def _rest(self, points):
        """Return as `_at`, nothing of points that are no part of the wall: further from it than its thickness."""
        along, normal, depth, shape, slope = self._at(points)
        part = np.abs(depth) <= self.bulge.thickness
        return along, normal, np.where(part, depth, 0.0), shape * part, slope * part

    def place(self, points):
        """Return where `points` that belong to the wall at rest, shape (n, 2), are now [m]: behind it along its normal."""
        along, normal, depth, shape, slope = self._rest(points)
        turned = _leaning(along, normal, self.amplitude * slope)
        return points + (self.amplitude * shape)[:, None] * normal + depth[:, None] * (turned - normal)

    def turn(self, vectors, points):
        """Return `vectors`, shape (n, 2), turned with the wall at its `points` at rest."""
        along, normal, _, _, slope = self._rest(points)
        turned = _leaning(along, normal, self.amplitude * slope)
        c, s = turned @ normal, -(turned @ along)
        return np.stack([c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]], axis=1)

    def motion(self, points):
        """Return present `points` of the wall [m], the velocity there [m/s] and a rate of rotation of 0, shape (n, 5)."""
        return np.column_stack([points, self.velocity(points), np.zeros(len(points))])

    def stretch(self, points):
        """Return how much longer the wall is at its `points` at rest, shape (n,)."""
        return np.sqrt(1.0 + (self.amplitude * self._rest(points)[4]) ** 2)

    def velocity(self, points):
        """Return the velocity [m/s] of the wall at its present `points`, shape (n, 2) [m]."""
        _, normal, _, shape, _ = self._at(points)
        return self.rate * shape[:, None] * normal

    def acceleration(self, points):
        """Return the acceleration [m/s^2] of the wall at its present `points`, shape (n, 2) [m]."""
        _, normal, _, shape, _ = self._at(points)
        return self.acceleration_of_middle * shape[:, None] * normal


def _leaning(along, normal, slope):
    """Return the normals, shape (n, 2), of a line that leans by the `slope`, shape (n,)."""
    return (normal - slope[:, None] * along) / np.sqrt(1.0 + slope**2)[:, None]


@dataclass(frozen=True)
class Bulge:
    """A straight wall that bulges into the fluid and out of it: its points move along its normal by
    ``A ramp(t) sin(2 pi t / P) sin^2(pi s / L)``, s from start to end.

    Attributes
    ----------
    start, end : tuple of float
        Of the wall at rest, the fluid at the left [m].
    amplitude : float
        A [m], first into the fluid.
    period, ramp : float
        P [s]; duration of the smooth start [s].
    thickness : float
        Points as far behind and in front of the wall belong to it [m].
    """

    start: tuple
    end: tuple
    amplitude: float
    period: float
    ramp: float
    thickness: float

    def at(self, time):
        """Return the `Bulged` at `time` [s]."""
        return Bulged(self, *(self.amplitude * value for value in oscillation(time, self.period, self.ramp)))

    def extremes(self):
        """Return the `Bulged`s at the ends of its swing."""
        return [self.at(time) for time in _quarters(self)]


def _quarters(motion):
    """Return the times [s] of the largest excursions of an oscillation, once its ramp is over."""
    return [motion.period * (math.ceil(motion.ramp / motion.period) + quarter) for quarter in (0.25, 0.75)]
