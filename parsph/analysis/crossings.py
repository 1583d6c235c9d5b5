"""The waves of a record one by one: between zero up-crossings, or period by period."""

import itertools
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .records import fit, last_periods, record_of, time_mean, whole_periods


@dataclass(frozen=True)
class WaveSummary:
    """The waves of one record.

    Attributes
    ----------
    mean : float
        Mean level [m].
    height : float
        Mean crest-to-trough height [m].
    period : float
        Mean period [s].
    phase : float
        Phase of the first harmonic [rad] at t = 0: ``cos(w t + phase)``.
    waves : int
        Number of whole waves that height and period are means of.
    """

    mean: float
    height: float
    period: float
    phase: float
    waves: int


def mean_height(t, level, period, periods=None):
    """Return the mean of crest minus trough [m] over the whole periods in a record.

    Parameters
    ----------
    t, level : ndarray, shape (samples,)
        Times [s] and levels [m].
    period : float
        [s]; a record shorter than that counts as one.
    periods : int, optional
        So many at the end count at most; default: all, from the beginning on.
    """
    begin = t[0] if periods is None else max(t[0], t[-1] - periods * period)
    number = np.floor((t - begin) / period + 1e-9).astype(int)
    whole = int((t[-1] - begin) / period + 1e-6)
    return float(np.mean([np.ptp(level[number == k]) for k in range(max(whole, 1))]))


def waves_of(t, level):
    """Find the whole waves between zero-up-crossings of a record about its mean.

    Crossings are interpolated between samples, crests and troughs are samples. A first sample at the mean is no crossing.

    Parameters
    ----------
    t, level : array_like, shape (samples,)
        Times [s] and levels [m].

    Returns
    -------
    heights, periods : ndarray, shape (waves,)
        Crest minus trough [m] and duration [s] of each wave; empty where there is no whole wave.

    Raises
    ------
    SceneError
        When times and levels do not make a record.
    """
    t, level = record_of(t, level)
    deviation = level - time_mean(t, level)
    before = np.flatnonzero((deviation[:-1] < 0) & (deviation[1:] >= 0))
    below, above = deviation[before], deviation[before + 1]
    crossings = t[before] - below * (t[before + 1] - t[before]) / (above - below)
    heights = [np.ptp(level[start:end]) for start, end in itertools.pairwise(before + 1)]
    return np.array(heights, dtype=float), np.diff(crossings)


def wave_summary(t, level, period=None):
    """Sum up the waves of a record.

    Mean level and phase are those of `harmonics` fitted to the last whole periods.

    Parameters
    ----------
    t, level : array_like, shape (samples,)
        Times [s] and levels [m].
    period : float, optional
        [s]; waves are then the whole periods as in `mean_height`, which noise near the mean level cannot cut in two. Without
        it they are those of `waves_of`, and the error of their mean period, times t, enters the phase.

    Returns
    -------
    WaveSummary

    Raises
    ------
    SceneError
        When no whole wave is in the record.
    """
    t, level = record_of(t, level)
    if period is None:
        heights, periods = waves_of(t, level)
        if not heights.size:
            raise SceneError(
                "no whole wave is in it",
                where="record",
                why=f"the level crosses its mean upwards fewer than twice in {np.ptp(t):g} s",
                cure="take a longer record",
            )
        height, period, number = heights.mean(), periods.mean(), heights.size
    else:
        number = whole_periods(t, period)
        height = mean_height(t, level, period)
    late = last_periods(t, period)
    mean, first, _ = fit(t[late], level[late], period, 2)
    return WaveSummary(float(mean.real), float(height), float(period), float(np.angle(first)), int(number))
