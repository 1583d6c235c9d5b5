"""Gauge records: what makes one, its mean, its harmonics.

Amplitudes are complex: ``a`` stands for ``Re[a exp(i w t)]``, t as in the record.
"""

import math

import numpy as np

from .. import waves
from ..errors import SceneError

UNIFORM = 0.01  # of a step: a sample so far off turns the phase of the highest frequency by 2 degrees


def harmonics(t, level, period, count=2):
    """Fit a periodic record by least squares.

    ``level ~ a_0 + Re sum_n a_n exp(i n w t)``, ``w = 2 pi / period``.

    Parameters
    ----------
    t, level : array_like, shape (samples,)
        Times [s], increasing but not necessarily uniform, and levels [m].
    period : float
        Of the first harmonic [s].
    count : int
        Number of harmonics.

    Returns
    -------
    ndarray of complex, shape (count + 1,)
        a_0 (real) to a_count [m].

    Raises
    ------
    SceneError
        When the record is shorter than a period or has too few samples.
    """
    t, level = record_of(t, level)
    whole_periods(t, period)
    return fit(t, level, period, count)


def record_of(t, levels):
    """Return times and levels (any number of gauges in front) as arrays that make a record."""
    t, levels = np.asarray(t, dtype=float), np.asarray(levels, dtype=float)
    if t.ndim != 1 or t.size < 2 or levels.shape[-1:] != t.shape:
        raise SceneError(
            f"times have shape {t.shape}, levels {levels.shape}",
            where="record",
            cure="give two samples at least, and as many levels as times",
        )
    if not np.all(np.diff(t) > 0):
        raise SceneError("times do not increase", where="record", cure="sort it, and drop what was recorded twice")
    if not np.isfinite(levels).all():
        raise SceneError("levels are not all finite", where="record", cure="cut out the times when a gauge is dry")
    return t, levels


def gauges_of(t, levels, x):
    """Return times, levels (gauges, samples) and positions as arrays that belong together."""
    t, levels = record_of(t, levels)
    x = np.asarray(x, dtype=float)
    if levels.ndim != 2 or x.shape != levels.shape[:1]:
        raise SceneError(
            f"positions have shape {x.shape}, levels {levels.shape}",
            where="gauges",
            cure="give one position per gauge, and levels as (gauges, samples)",
        )
    return t, levels, x


def uniform_step(t):
    """Return (time between samples [s], whether all are so far apart, to `UNIFORM` of it)."""
    step = np.ptp(t) / (t.size - 1)
    return step, np.abs(t - (t[0] + step * np.arange(t.size))).max() <= UNIFORM * step


def time_mean(t, levels):
    """Return the mean over time, each sample weighted by the time it stands for; the plain mean where t is uniform."""
    return np.average(levels, axis=-1, weights=np.gradient(t))


def check_positive(name, value):
    """Raise SceneError when a number is not above zero."""
    if not value > 0:
        raise SceneError(f"{value:g} is not positive", where=name, cure="give a number above zero")


def linear_wavenumber(period, depth, gravity):
    """Return k [1/m] of linear theory."""
    for name, value in (("period", period), ("depth", depth), ("gravity", gravity)):
        check_positive(name, value)
    return waves.wavenumber(2 * math.pi / period, depth, gravity)


def whole_periods(t, period):
    """Return the number of whole periods in the record, at least one."""
    check_positive("period", period)
    whole = int(np.ptp(t) / period + 1e-6)
    if not whole:
        raise SceneError(
            f"{np.ptp(t):g} s are shorter than a period of {period:g} s",
            where="record",
            why="no whole wave is in it",
            cure="take a longer record",
        )
    return whole


def last_periods(t, period, most=None):
    """Return the mask of the last whole periods, of `most` at most: half open, so that no phase is counted twice."""
    whole = whole_periods(t, period)
    return t > t[-1] - (min(whole, most or whole) - 1e-6) * period


def fit(t, level, period, count):
    """Return the amplitudes that `harmonics` describes."""
    turn = np.exp(2j * math.pi / period * np.outer(t, np.arange(count + 1)))
    parts = np.hstack([turn.real, -turn.imag[:, 1:]])
    solution, _, rank, _ = np.linalg.lstsq(parts, level, rcond=1e-9)
    if rank < 2 * count + 1:
        raise SceneError(
            f"too few samples: {t.size} in {np.ptp(t) / period:.3g} periods",
            where="record",
            why=f"{count} harmonics and a mean have {2 * count + 1} unknowns in each period",
            cure="sample more often",
        )
    return solution[: count + 1] + 1j * np.concatenate([[0.0], solution[count + 1 :]])
