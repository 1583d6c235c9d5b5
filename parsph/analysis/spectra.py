"""Irregular waves of one record: statistics of the single waves, and the spectrum with its moments.

Sources: Goda (2010), Random Seas and Design of Maritime Structures, 3rd ed., World Scientific, chs. 2 and 10, for the
statistics; IAHR (1989), List of sea-state parameters, J. Waterway, Port, Coastal and Ocean Engineering 115, 793-808, for the
names; Welch (1967), The use of fast Fourier transform for the estimation of power spectra, IEEE Trans. Audio and
Electroacoustics 15, 70-73; Young (1995), The determination of confidence limits associated with estimates of the spectral
peak frequency, Ocean Engineering 22, 669-686.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .crossings import waves_of
from .records import record_of, uniform_step

LEAST_WAVES = 3  # of which the highest third is one
LEAST_SAMPLES = 16  # of a segment, fewer resolve no wave
WAVES_A_SEGMENT = 10  # lines are then a tenth of the mean frequency apart, which resolves a JONSWAP peak
MOST_SEGMENTS = 8  # by itself: 15 half-overlapping ones, a standard error of a quarter in each line


@dataclass(frozen=True)
class Spectrum:
    """The variance density of a record, and what its moments say of the waves.

    ``m_n = integral f^n S df`` over the band; sea-state parameters as in IAHR (1989).

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Of the band, evenly spaced and without zero [Hz].
    density : ndarray, shape (n,)
        S, one-sided [m^2/Hz].
    """

    frequency: np.ndarray
    density: np.ndarray

    def moment(self, order):
        """Return m_n [m^2 Hz^n]; a sum over lines, whose m_0 is the variance."""
        return float(np.sum(self.frequency**order * self.density) * (self.frequency[1] - self.frequency[0]))

    @property
    def height(self):
        """``H_m0 = 4 sqrt(m_0)`` [m]."""
        return 4 * math.sqrt(self.moment(0))

    @property
    def peak_period(self):
        """``T_p = 1/f_p``, ``f_p = integral f S^4 df / integral S^4 df`` [s], Young (1995).

        Steadier than the highest line; a regular wave's is off by a fifth of what lines are apart at most.
        """
        weight = (self.density / self.density.max()) ** 4
        return float(np.sum(weight) / np.sum(self.frequency * weight))

    @property
    def energy_period(self):
        """``T_m-1,0 = m_-1 / m_0`` [s]."""
        return self.moment(-1) / self.moment(0)

    @property
    def first_moment_period(self):
        """``T_m01 = m_0 / m_1`` [s]."""
        return self.moment(0) / self.moment(1)

    @property
    def second_moment_period(self):
        """``T_m02 = sqrt(m_0 / m_2)`` [s], which noise of high frequencies shortens: limit the band."""
        return math.sqrt(self.moment(0) / self.moment(2))


@dataclass(frozen=True)
class WaveStatistics:
    """The waves of an irregular record, one by one (zero up-crossings) and by their spectrum.

    Attributes
    ----------
    waves : int
        Number of whole waves.
    mean_height, significant_height, largest_height : float
        H_mean, H_1/3 (the mean of the highest third), H_max [m].
    tenth_height : float or None
        H_1/10, the mean of the highest tenth [m]; None for fewer than ten waves.
    mean_period, significant_period : float
        T_z of all waves, T_1/3 of the highest third [s].
    spectral_height : float
        H_m0 [m].
    peak_period, energy_period, first_moment_period, second_moment_period : float
        T_p, T_m-1,0, T_m01, T_m02 [s], see `Spectrum`.
    """

    waves: int
    mean_height: float
    significant_height: float
    tenth_height: float | None
    largest_height: float
    mean_period: float
    significant_period: float
    spectral_height: float
    peak_period: float
    energy_period: float
    first_moment_period: float
    second_moment_period: float


def spectrum(t, level, low=None, high=None, segments=None):
    """Estimate the spectrum of a record, Welch (1967): Hann windows that overlap by half, of the record less its trend.

    Parameters
    ----------
    t, level : array_like, shape (samples,)
        Times [s] and levels [m]. Between times that are not uniform levels are interpolated linearly, to as many uniform ones.
    low, high : float, optional
        Ends of the band [Hz], both included; default: from the first line to half the sampling frequency.
    segments : int, optional
        How many lengths of a window make the record: n of them are 2n - 1 windows, and lines n/duration apart. Default: as
        many as leave each ten waves, eight at most.

    Returns
    -------
    Spectrum

    Raises
    ------
    SceneError
        When the band is none, the record is too short for it or for the segments, or the level does not move.
    """
    from scipy.signal import detrend, welch  # slow to import, and few need it

    t, level = record_of(t, level)
    step, uniform = uniform_step(t)
    if not uniform:
        even = t[0] + step * np.arange(t.size)
        t, level = even, np.interp(even, t, level)
    low, high = (0.0 if low is None else low), (0.5 / step if high is None else high)
    if not 0 <= low < high <= 0.5 / step * (1 + 1e-9):
        raise SceneError(
            f"low = {low:g} Hz and high = {high:g} Hz make no range",
            where="frequencies",
            cure=f"take 0 <= low < high <= {0.5 / step:g} Hz, half the sampling frequency",
        )
    if segments is None:
        segments = min(max(waves_of(t, level)[1].size // WAVES_A_SEGMENT, 1), MOST_SEGMENTS)
    samples = t.size // max(segments, 1)
    if segments < 1 or samples < LEAST_SAMPLES:
        raise SceneError(
            f"{t.size} samples do not make {segments} segments",
            where="record",
            why=f"a segment has {LEAST_SAMPLES} samples at least",
            cure=f"take {LEAST_SAMPLES * max(segments, 1)} samples or more, or fewer segments but one at least",
        )
    if np.ptp(level) <= 1e-12 * np.abs(level).max():
        raise SceneError("the level does not move", where="record", cure="take a later part of the run")
    frequency, density = welch(detrend(level), 1 / step, nperseg=samples, noverlap=samples // 2)
    inside = (frequency > 0) & (frequency > low * (1 - 1e-9)) & (frequency < high * (1 + 1e-9))  # the ends despite rounding
    if inside.sum() < 2:
        raise SceneError(
            f"fewer than two frequencies from {low:g} to {high:g} Hz",
            where="record",
            why=f"segments of {samples * step:g} s have one every {1 / (samples * step):g} Hz",
            cure=f"take segments of {2 / (high - low):.3g} s or more (fewer of them, a longer record), or a wider range",
        )
    return Spectrum(frequency[inside], density[inside])


def statistics(t, level, low=None, high=None, segments=None):
    """Sum up an irregular record: waves between zero up-crossings (see `waves_of`), and moments of the spectrum.

    Parameters
    ----------
    t, level : array_like, shape (samples,)
        Times [s] and levels [m].
    low, high, segments
        Of the `spectrum`.

    Returns
    -------
    WaveStatistics

    Raises
    ------
    SceneError
        When fewer than three whole waves are in the record, or there is no `spectrum`.
    """
    t, level = record_of(t, level)
    heights, periods = waves_of(t, level)
    if heights.size < LEAST_WAVES:
        raise SceneError(
            f"{heights.size} whole wave(s) in {np.ptp(t):g} s",
            where="record",
            why=f"the highest third of the waves needs {LEAST_WAVES} at least, and steady statistics a hundred",
            cure="take a longer record",
        )
    found = spectrum(t, level, low, high, segments)
    order = np.argsort(-heights, kind="stable")
    third, tenth = order[: round(heights.size / 3)], order[: round(heights.size / 10)]
    return WaveStatistics(
        waves=int(heights.size),
        mean_height=float(heights.mean()),
        significant_height=float(heights[third].mean()),
        tenth_height=float(heights[tenth].mean()) if heights.size >= 10 else None,
        largest_height=float(heights.max()),
        mean_period=float(periods.mean()),
        significant_period=float(periods[third].mean()),
        spectral_height=found.height,
        peak_period=found.peak_period,
        energy_period=found.energy_period,
        first_moment_period=found.first_moment_period,
        second_moment_period=found.second_moment_period,
    )
