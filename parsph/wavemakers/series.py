"""Measured motions of a plate, from text files."""

import math

import numpy as np

from ..errors import SceneError, shown
from ..files import read_text
from .signals import Sampled

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048, "rad": 1.0, "deg": math.pi / 180}
ANGLES = ("rad", "deg")
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
LARGEST_GAP = 5.0  # of the median step: what lies between is not known, and a curve through it would be made up
LEAST_SAMPLES = 8
LARGEST_FILE = 8e6  # bytes: half a million samples
LARGEST_NUMBER = 1e12
MOST_STARTING = 10_000  # samples of a start from rest
LONGEST_START = 1e9  # over the median step: beyond it times can no longer be told apart


def measured_motion(path, unit, time_unit, largest_acceleration, start=None):
    """Return the motion that a file holds as a `Sampled` signal, from rest at 0.

    The file has two columns, time and way, separated by white space or a comma; ``#`` begins a comment, and one line of
    headings may come first. Times need not be uniform. The motion is counted from the first sample; a start from rest and
    an end at rest are added, with as much time as the speeds there need at half of the largest acceleration.

    Parameters
    ----------
    path : path
    unit, time_unit : str
        Of `LENGTHS` and `TIMES`.
    largest_acceleration : float
        What the plate can do at the most [m/s^2] or [rad/s^2].
    start : float, optional
        Duration of the start from rest [s].

    Raises
    ------
    SceneError
        When the file cannot be read, or holds too few samples, numbers that are none, times that do not increase, gaps, or
        jumps.
    """
    times, values = _read(path)
    where = str(path)
    if len(times) < LEAST_SAMPLES:
        raise SceneError(f"holds {len(times)} samples", where=where, cure=f"at least {LEAST_SAMPLES}")
    times, values = times * TIMES[time_unit], values * LENGTHS[unit]
    steps = np.diff(times)
    if steps.min() <= 0:
        number = int(np.argmin(steps)) + 1
        why = f"sample {number + 1} is at {times[number]:g} s, the one before at {times[number - 1]:g} s"
        raise SceneError("times do not increase", where=where, why=why, cure="a record in the order of time, each time once")
    median = float(np.median(steps))
    if steps.max() > LARGEST_GAP * median:
        number = int(np.argmax(steps))
        why = f"nothing is known from {times[number]:g} to {times[number + 1]:g} s, where samples are {median:g} s apart"
        raise SceneError("has a gap", where=where, why=why, cure=f"steps of at most {LARGEST_GAP * median:g} s")
    with np.errstate(all="ignore"):  # whatever is not finite jumps
        speeds = np.diff(values) / steps
        pulls = np.abs(np.diff(speeds)) / (0.5 * (steps[1:] + steps[:-1]))
    if not pulls.max() <= largest_acceleration:
        number, what = int(np.argmax(pulls)) + 1, "rad" if unit in ANGLES else "m"
        why = f"at {times[number]:g} s the plate would be accelerated with {pulls.max():.3g} {what}/s^2"
        cure = (
            f"at most {largest_acceleration:.3g} {what}/s^2: another unit than {unit!r} and {time_unit!r}, or a smoother record"
        )
        raise SceneError("jumps", where=where, why=why, cure=cure)
    times, values = times - times[0], values - values[0]
    first = abs(speeds[0]) / (0.5 * largest_acceleration) if start is None else start
    last = abs(speeds[-1]) / (0.5 * largest_acceleration)
    if max(first, last) > LONGEST_START * median:
        why = f"samples are {median:g} s apart, a start or an end at rest takes {max(first, last):g} s"
        raise SceneError(
            "begins or ends too slowly", where, why, f"at most {LONGEST_START * median:g} s; a start as wave.start"
        )
    lead_times, lead_values = _from_rest(speeds[0], first, median)
    tail_times, tail_values = _from_rest(speeds[-1], last, median)
    times = np.concatenate([lead_times, first + times, first + times[-1] + last - tail_times[::-1]])
    middle = 0.5 * speeds[0] * first + values
    tail = middle[-1] + 0.5 * speeds[-1] * last - tail_values[::-1]
    return Sampled(times, np.concatenate([lead_values, middle, tail]))


def _from_rest(speed, duration, step):
    """Return times and ways of a plate that gets from rest to a speed in so long a time, the last moment left out."""
    times = np.zeros(0)
    if duration > 0:
        times = np.linspace(0.0, duration, min(max(3, math.ceil(duration / step)), MOST_STARTING), endpoint=False)
    return times, 0.5 * speed * times**2 / max(duration, 1e-300)


def _read(path):
    """Return times and values of a file as they stand in it."""
    text = read_text(path, LARGEST_FILE, "a text file of two columns, time and way")
    lines = [line.split("#")[0].replace(",", " ").split() for line in text.splitlines()]
    rows = []
    for number, line in enumerate(lines, 1):
        if not line:
            continue
        try:
            row = [float(word) for word in line]
        except ValueError:
            if not rows and len(line) >= 2:  # headings
                rows.append(None)
                continue
            row = []
        if len(row) != 2 or not all(abs(number) <= LARGEST_NUMBER for number in row):
            cure = "two finite numbers, time and way"
            why = f"it reads {shown(' '.join(line))}"
            raise SceneError(f"line {number} is no sample", where=str(path), why=why, cure=cure)
        rows.append(row)
    rows = [row for row in rows if row is not None]
    return np.array(rows, float).reshape(-1, 2).T
