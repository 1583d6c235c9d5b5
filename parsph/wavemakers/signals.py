"""Signals: numbers that change with time by a law, with their first and second derivatives.

Each has ``at(time)``, which returns the value, its rate and its acceleration, and ``extent``, the least and the largest value.
Before t = 0 all are at rest.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

LOOKS = 20  # per shortest period, for extremes


def ramp(time, duration):
    """Return r, dr/dt [1/s], d2r/dt2 [1/s^2] of ``r(t) = (1 - cos(pi t / T))/2`` up to T = `duration` [s], and 1 after it."""
    if time >= duration:
        return 1.0, 0.0, 0.0
    a = math.pi / duration
    c, s = math.cos(a * time), math.sin(a * time)
    return 0.5 * (1 - c), 0.5 * a * s, 0.5 * a * a * c


def ramped(time, duration, value, rate, acceleration):
    """Return a value and its derivatives times a `ramp`."""
    r, dr, ddr = ramp(time, duration)
    return r * value, dr * value + r * rate, ddr * value + 2 * dr * rate + r * acceleration


def oscillation(time, period, duration):
    """Return s, ds/dt [1/s], d2s/dt2 [1/s^2] of ``s(t) = ramp(t) sin(2 pi t / P)``, at rest before t = 0.

    With a ramp all three start from zero.
    """
    if time <= 0:
        return 0.0, 0.0, 0.0
    w = 2 * math.pi / period
    s, c = math.sin(w * time), math.cos(w * time)
    return ramped(time, duration, s, w * c, -w * w * s)


@dataclass(frozen=True)
class Oscillation:
    """``A ramp(t) sin(2 pi t / P)``, without end or so many times; after them it is at rest.

    Attributes
    ----------
    amplitude : float
        A.
    period, ramp : float
        P [s]; duration of the smooth start [s], 0 for a sudden one.
    cycles : int or None
        Number of oscillations, None for no end.
    """

    amplitude: float
    period: float
    ramp: float = 0.0
    cycles: int | None = None

    def at(self, time):
        """Return the value at `time` [s] and its two derivatives."""
        if self.cycles is not None and time >= self.cycles * self.period:
            return 0.0, 0.0, 0.0
        return tuple(self.amplitude * value for value in oscillation(time, self.period, self.ramp))

    @property
    def extent(self):
        """The least and the largest value."""
        return -self.amplitude, self.amplitude


@dataclass(frozen=True, eq=False)
class Harmonics:
    """``ramp(t) sum_j A_j sin(w_j t + p_j)``.

    Attributes
    ----------
    amplitudes, frequencies, phases : ndarray, shape (n,)
        A_j; angular w_j [1/s]; p_j [rad].
    ramp : float
        Duration of the smooth start [s].
    duration : float
        Up to when it is asked for [s]: `extent` is that of this time.
    repeats : float
        Time [s] after which it repeats once the ramp is over; inf where it does not.
    """

    amplitudes: np.ndarray
    frequencies: np.ndarray
    phases: np.ndarray
    ramp: float
    duration: float
    repeats: float = math.inf

    def at(self, time):
        """Return the value at `time` [s] and its two derivatives."""
        if time <= 0:
            return 0.0, 0.0, 0.0
        A, w = self.amplitudes, self.frequencies
        angle = w * time + self.phases
        s, c = np.sin(angle), np.cos(angle)
        return ramped(time, self.ramp, float(A @ s), float((A * w) @ c), float(-(A * w * w) @ s))

    @cached_property
    def extent(self):
        """The least and the largest value, looked for at 20 times per shortest period up to `duration`, or until it repeats."""
        step, until = 2 * math.pi / self.frequencies.max() / LOOKS, min(self.duration, self.ramp + self.repeats)
        times = step * np.arange(int(max(0.0, until - self.repeats) / step), math.ceil(until / step + 1))
        parts = np.array_split(times, math.ceil(len(times) / 1000))
        values = [np.sin(part[:, None] * self.frequencies + self.phases) @ self.amplitudes for part in parts]
        values = np.concatenate(values) * [ramp(time, self.ramp)[0] for time in times]
        return float(values.min()), float(values.max())


@dataclass(frozen=True, eq=False)
class Sampled:
    """A smooth curve through samples, at rest before the first and after the last.

    The curve is the cubic spline that begins and ends at rest: its acceleration is continuous but for the two ends.

    Attributes
    ----------
    times, values : ndarray, shape (n,)
        Increasing times [s], the first not before 0, and values there.
    """

    times: np.ndarray
    values: np.ndarray

    @cached_property
    def _curve(self):
        from scipy.interpolate import CubicSpline  # slow to import, and few need it

        curve = CubicSpline(self.times, self.values, bc_type="clamped")
        return curve, curve.derivative(1), curve.derivative(2)

    def at(self, time):
        """Return the value at `time` [s] and its two derivatives."""
        if time <= self.times[0]:
            return float(self.values[0]), 0.0, 0.0
        if time >= self.times[-1]:
            return float(self.values[-1]), 0.0, 0.0
        return tuple(float(curve(time)) for curve in self._curve)

    @cached_property
    def extent(self):
        """The least and the largest value, which may lie between samples."""
        curve, slope, _ = self._curve
        turns = slope.roots(discontinuity=False, extrapolate=False)
        values = np.concatenate([self.values, curve(turns[np.isfinite(turns)])])
        return float(values.min()), float(values.max())


@dataclass(frozen=True, eq=False)
class Together:
    """The sum of signals: what a wavemaker shall do, and what its absorption adds."""

    signals: tuple

    def at(self, time):
        """Return the value at `time` [s] and its two derivatives."""
        return tuple(map(sum, zip(*(signal.at(time) for signal in self.signals), strict=True)))

    @property
    def extent(self):
        """The least and the largest value."""
        return tuple(map(sum, zip(*(signal.extent for signal in self.signals), strict=True)))


@dataclass(frozen=True)
class Held:
    """A value that stays."""

    value: float

    def at(self, time):
        """Return the value at any `time` [s] and its two derivatives, zeros."""
        return self.value, 0.0, 0.0


class Yielding:
    """A way that is decided on as the run goes on: from a time on with constant acceleration, until it is told anew.

    Attributes
    ----------
    extent : tuple of float
        The least and the largest value it may take.
    time, way, speed, acceleration : float
        Since when [s], and the value with its two derivatives there.
    """

    def __init__(self, extent):
        self.extent = extent
        self.time, self.way, self.speed, self.acceleration = 0.0, 0.0, 0.0, 0.0

    def at(self, time):
        """Return the value at `time` [s] and its two derivatives."""
        since = max(time - self.time, 0.0)
        speed = self.speed + since * self.acceleration
        return self.way + since * (self.speed + 0.5 * since * self.acceleration), speed, self.acceleration

    def go_on(self, time, way, speed, acceleration):
        """Have this value and these derivatives from `time` [s] on."""
        self.time, self.way, self.speed, self.acceleration = time, way, speed, acceleration

    @property
    def memory(self):
        """What it was last told: time [s], value and its two derivatives."""
        return [self.time, self.way, self.speed, self.acceleration]
