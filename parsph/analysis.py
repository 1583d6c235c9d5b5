"""Analysis of gauge records and snapshots, after a run or without one: waves, reflection, differences between runs.

Amplitudes are complex: ``a`` stands for ``Re[a exp(i w t)]``, t as in the record. Incident waves run towards larger x.

Sources: Goda & Suzuki (1976), Estimation of incident and reflected waves in random wave experiments, Proc. 15th Int. Conf.
Coastal Engineering, 828-845; Mansard & Funke (1980), The measurement of incident and reflected spectra using a least squares
method, Proc. 17th Int. Conf. Coastal Engineering, 154-172; Molteni et al. for the reflection ratio of absorbing layers.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from . import waves
from .errors import SceneError

# How well gauges tell the two waves apart is the determinant of the normal equations over n^2: 1 - |mean exp(2ikx)|^2.
# For two gauges it is sin^2(k dx), and Goda & Suzuki's range 0.05 < dx/wavelength < 0.45 is where it exceeds sin^2(pi/10).
# For more gauges the noise in the amplitudes grows with its inverse root: tenfold at 0.01, against the best layout.
LEAST_OF_TWO, LEAST_OF_MANY = math.sin(math.pi / 10) ** 2, 0.01
STILL = 1e-9  # of the depth: an incident wave below this is rounding
UNIFORM = 0.01  # of a step: a sample so far off turns the phase of the highest frequency by 2 degrees


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


@dataclass(frozen=True)
class Separation:
    """Incident and reflected regular wave.

    Attributes
    ----------
    incident, reflected : float
        Amplitudes [m] of the first harmonic.
    coefficient : float
        R = reflected / incident.
    residual : float
        Root mean square misfit of the gauges' complex amplitudes, relative to `incident`; 0 for two gauges.
    wavenumber : float
        k [1/m], from linear theory.
    """

    incident: float
    reflected: float
    coefficient: float
    residual: float
    wavenumber: float


@dataclass(frozen=True)
class ReflectionSpectrum:
    """Incident and reflected irregular waves, at the frequencies where the gauges tell them apart.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        [Hz]
    incident, reflected : ndarray, shape (n,)
        Amplitudes [m].
    coefficient : float
        R = sqrt(sum reflected^2 / sum incident^2).
    """

    frequency: np.ndarray
    incident: np.ndarray
    reflected: np.ndarray
    coefficient: float


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
    t, level = _record(t, level)
    _whole_periods(t, period)
    return _fit(t, level, period, count)


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
    t, level = _record(t, level)
    deviation = level - _time_mean(t, level)
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
    t, level = _record(t, level)
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
        number = _whole_periods(t, period)
        height = mean_height(t, level, period)
    late = _last_periods(t, period)
    mean, first, _ = _fit(t[late], level[late], period, 2)
    return WaveSummary(float(mean.real), float(height), float(period), float(np.angle(first)), int(number))


def separate(x, amplitudes, wavenumber):
    """Separate the incident from the reflected wave.

    ``eta = Re[(a_i exp(-ikx) + a_r exp(ikx)) exp(i w t)]``: exactly for two gauges (Goda & Suzuki 1976), by least squares for
    more (Mansard & Funke 1980, whose closed form for three gauges this equals).

    Parameters
    ----------
    x : array_like, shape (gauges,)
        Positions [m].
    amplitudes : array_like of complex, shape (gauges,)
        Of the level at each gauge [m].
    wavenumber : float
        k [1/m].

    Returns
    -------
    incident, reflected : complex
        a_i and a_r [m], at x = 0.

    Raises
    ------
    SceneError
        When gauges and amplitudes do not match, or the gauges stand (nearly) a multiple of half a wavelength apart.
    """
    x, amplitudes = np.asarray(x, dtype=float), np.asarray(amplitudes, dtype=complex)
    if x.ndim != 1 or x.shape != amplitudes.shape or x.size < 2:
        raise SceneError(
            f"positions have shape {x.shape}, amplitudes {amplitudes.shape}",
            where="gauges",
            why="two waves need two gauges at least, and each gauge one amplitude",
            cure="give as many positions as amplitudes",
        )
    _check_positive("wavenumber", wavenumber)
    if not _usable(x, wavenumber):
        raise _degenerate(x, 2 * math.pi / wavenumber)
    incident, reflected = _solve(x, amplitudes, wavenumber)
    return complex(incident), complex(reflected)


def reflection(t, levels, x, period, depth, gravity, method="mansard-funke", periods=None):
    """Separate regular waves by the first harmonics of several gauges over the last whole periods of the record.

    Parameters
    ----------
    t : array_like, shape (samples,)
        Times [s].
    levels : array_like, shape (gauges, samples)
        [m]
    x : array_like, shape (gauges,)
        Positions of the gauges [m], over an even bed.
    period, depth, gravity : float
        [s], [m], [m/s^2]; the wavenumber is that of linear theory.
    method : str
        "mansard-funke" (three gauges or more) or "goda-suzuki" (exactly two).
    periods : int, optional
        So many at the end of the record count at most; default: all whole ones.

    Returns
    -------
    Separation

    Raises
    ------
    SceneError
        When the number of gauges does not suit the method, the record is shorter than a period, the gauges do not tell the
        waves apart (see `separate`) or there is no incident wave.
    """
    t, levels, x = _gauges(t, levels, x)
    suits = {"goda-suzuki": x.size == 2, "mansard-funke": x.size >= 3}
    if not suits.get(method, False):
        raise SceneError(
            f'method "{method}" does not suit {x.size} gauge(s)',
            where="gauges",
            cure='take method "goda-suzuki" for two gauges, "mansard-funke" for three or more',
        )
    wavenumber = _wavenumber(period, depth, gravity)
    late = _last_periods(t, period, periods)
    amplitudes = np.array([_fit(t[late], level, period, 2)[1] for level in levels[:, late]])
    incident, reflected = separate(x, amplitudes, wavenumber)
    _check_moving(abs(incident), depth)
    left = amplitudes - incident * np.exp(-1j * wavenumber * x) - reflected * np.exp(1j * wavenumber * x)
    residual = math.sqrt(np.mean(np.abs(left) ** 2)) / abs(incident)
    return Separation(abs(incident), abs(reflected), abs(reflected) / abs(incident), residual, wavenumber)


def reflection_spectrum(t, levels, x, depth, gravity, low, high):
    """Separate irregular waves, each frequency of the discrete Fourier transform by itself (see `separate`).

    The record is taken whole and without taper: best is one repeat time of the waves, where nothing leaks between frequencies.

    Parameters
    ----------
    t : array_like, shape (samples,)
        Times [s], uniform.
    levels : array_like, shape (gauges, samples)
        [m]
    x : array_like, shape (gauges,)
        Positions of the gauges [m], two or more, over an even bed.
    depth, gravity : float
        [m], [m/s^2]; wavenumbers are those of linear theory.
    low, high : float
        Frequencies to look at [Hz], both included. Those where the gauges do not tell the waves apart are left out.

    Returns
    -------
    ReflectionSpectrum

    Raises
    ------
    SceneError
        When times are not uniform, the range is not one, no frequency is left or there is no incident wave.
    """
    t, levels, x = _gauges(t, levels, x)
    step = np.ptp(t) / (t.size - 1)
    offset = np.abs(t - (t[0] + step * np.arange(t.size))).max()
    if offset > UNIFORM * step:
        raise SceneError(
            f"times are not uniform: steps from {np.diff(t).min():g} to {np.diff(t).max():g} s",
            where="record",
            why="the discrete Fourier transform needs uniform samples",
            cure="cut the record, or interpolate it to uniform times",
        )
    if not 0 < low < high < 0.5 / step:
        raise SceneError(
            f"low = {low:g} Hz and high = {high:g} Hz make no range",
            where="frequencies",
            cure=f"take 0 < low < high < {0.5 / step:g} Hz, half the sampling frequency",
        )
    frequency = np.fft.rfftfreq(t.size, step)
    inside = (frequency > low * (1 - 1e-9)) & (frequency < high * (1 + 1e-9))  # the ends in spite of rounding
    frequency, amplitudes = frequency[inside], 2 * np.fft.rfft(levels)[:, inside] / t.size
    wavenumbers = np.array([_wavenumber(1 / f, depth, gravity) for f in frequency])
    usable = _usable(x, wavenumbers)
    if not usable.any():
        raise SceneError(
            f"no usable frequency from {low:g} to {high:g} Hz",
            where="gauges",
            why=f"the record of {t.size * step:g} s has {frequency.size} there, and the gauges tell the waves apart at none",
            cure="take a longer record, a wider range, or other distances between the gauges",
        )
    incident, reflected = np.abs(_solve(x, amplitudes[:, usable], wavenumbers[usable]))
    total = np.linalg.norm(incident)
    _check_moving(total, depth)
    return ReflectionSpectrum(frequency[usable], incident, reflected, float(np.linalg.norm(reflected) / total))


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

    t, values = _record(t, values)
    _whole_periods(t, 2 * math.pi / frequency)

    def wave(t, amplitude, rate, frequency, phase):
        return amplitude * np.exp(-rate * t) * np.cos(frequency * t + phase)

    try:
        fit, _ = curve_fit(wave, t, values, p0=(values[0], 3e-3 * frequency, frequency, 0.0))
    except RuntimeError:
        why, cure = "the least-squares fit does not converge", "a record of clear oscillations"
        raise SceneError("is no oscillation that dies away", where="record", why=why, cure=cure) from None
    return Oscillation(*map(float, fit))


def energy_difference(depth, velocity, mass, depth_reference, velocity_reference, gravity):
    """Return the energy [m^4/s^2] of the difference of two shallow-water runs, per unit of width and density.

    ``E = sum V_i [g/2 (H - H_ref)^2 + H/2 (v - v_ref)^2]``, ``V_i = m_i / H_ref``: Molteni et al. eq. (2.8), the integrals as
    sums over the same particles.

    Parameters
    ----------
    depth, velocity, mass : ndarray, shape (n,)
        H [m], v [m/s] and m [m^2] (depth times length) of the particles.
    depth_reference, velocity_reference : ndarray, shape (n,)
        The same particles in the reference run.
    gravity : float
        [m/s^2]
    """
    potential = 0.5 * gravity * (depth - depth_reference) ** 2
    kinetic = 0.5 * depth * (velocity - velocity_reference) ** 2
    return float(np.sum(mass / depth_reference * (potential + kinetic)))


def reflection_ratio(layer, reflecting, infinite, gravity, window):
    """Return the reflection ratio of an absorbing layer, ``R = sqrt(E_layer / E_reflecting)``, Molteni et al. eq. (2.7).

    Both energies are differences from the infinite run (`energy_difference`) at the same time, over the particles that all
    three runs have and that lie in the window in the infinite one.

    Parameters
    ----------
    layer, reflecting, infinite : mapping of str to ndarray, shape (n,)
        "id", "position" [m], "density" (the depth H [m]), "velocity" [m/s] and "mass" [m^2] of one-dimensional runs with the
        layer, with a wall in its place, and with an end too far away to matter. In any order, with n of their own.
    gravity : float
        [m/s^2]
    window : tuple of (float, float)
        Lower and upper end [m], both included.

    Raises
    ------
    SceneError
        When an array is not of shape (n,), no particle is common, or the reflecting run equals the infinite one.
    """
    for name, run in (("layer", layer), ("reflecting", reflecting), ("infinite", infinite)):
        for key in ("position", "density", "velocity", "mass"):
            if run[key].shape != (run["id"].size,):
                raise SceneError(
                    f"{key} has shape {run[key].shape} for {run['id'].size} particles",
                    where=f"{name} run",
                    why="the ratio is one of one-dimensional shallow-water runs",
                    cure="give each array one number per particle",
                )
    low, high = window
    common = infinite["id"][(infinite["position"] >= low) & (infinite["position"] <= high)]
    common = np.intersect1d(np.intersect1d(common, layer["id"]), reflecting["id"])
    if not common.size:
        raise SceneError(
            f"no particle of all three runs lies from {low:g} to {high:g} m",
            where="reflection ratio",
            why="particles are compared one by one, by their id",
            cure="take runs of the same initial particles and a window that they are in",
        )

    def taken(run):
        order = np.argsort(run["id"])
        rows = order[np.searchsorted(run["id"], common, sorter=order)]
        return run["density"][rows], run["velocity"][rows], run["mass"][rows]

    depth, velocity, _ = taken(infinite)
    of_layer = energy_difference(*taken(layer), depth, velocity, gravity)
    of_reflecting = energy_difference(*taken(reflecting), depth, velocity, gravity)
    if of_reflecting == 0:
        raise SceneError(
            f"the reflecting run equals the infinite one from {low:g} to {high:g} m",
            where="reflection ratio",
            why="there is no reflection yet that the layer's could be compared with",
            cure="take a later time, when the reflected wave is back in the window",
        )
    return math.sqrt(of_layer / of_reflecting)


def kinetic_energy(position, velocity, mass, low, high):
    """Return the kinetic energy of the particles in a box, ``sum m v^2 / 2`` over ``low <= position < high``.

    Parameters
    ----------
    position, velocity : ndarray, shape (n, dim)
        [m], [m/s]
    mass : ndarray, shape (n,)
        [kg] in three dimensions, [kg/m] in two; the energy is in [J] or [J/m].
    low, high : array_like, shape (dim,)
        Corners of the box [m]; infinite ones are welcome.
    """
    inside = np.all((position >= low) & (position < high), axis=1)
    return float(0.5 * np.sum(mass[inside, None] * velocity[inside] ** 2))


def level_difference(t, levels, reference):
    """Return the relative L2 difference of gauge records, over all gauges and times.

    ``sqrt(mean (levels - reference)^2) / sqrt(mean (reference - its mean over time)^2)``, each sample weighted by the time it
    stands for.

    Parameters
    ----------
    t : array_like, shape (samples,)
        Times [s] of both.
    levels, reference : array_like, shape (gauges, samples)
        [m]

    Raises
    ------
    SceneError
        When shapes differ or the reference stands still.
    """
    if np.shape(levels) != np.shape(reference) or np.ndim(reference) != 2:
        raise SceneError(
            f"levels have shape {np.shape(levels)}, the reference {np.shape(reference)}",
            where="gauges",
            why="both must be (gauges, samples), with the same gauges and times",
            cure="cut or interpolate one to the other",
        )
    t, levels = _record(t, levels)
    t, reference = _record(t, reference)
    if not np.ptp(reference, axis=1).any():
        raise SceneError(
            "the reference stands still",
            where="gauges",
            why="a difference relative to its motion has no meaning",
            cure="take a reference run with waves, or a longer record",
        )
    motion = reference - _time_mean(t, reference)[:, None]
    return float(np.sqrt(_time_mean(t, (levels - reference) ** 2).mean() / _time_mean(t, motion**2).mean()))


def _record(t, levels):
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


def _gauges(t, levels, x):
    """Return times, levels (gauges, samples) and positions as arrays that belong together."""
    t, levels = _record(t, levels)
    x = np.asarray(x, dtype=float)
    if levels.ndim != 2 or x.shape != levels.shape[:1]:
        raise SceneError(
            f"positions have shape {x.shape}, levels {levels.shape}",
            where="gauges",
            cure="give one position per gauge, and levels as (gauges, samples)",
        )
    return t, levels, x


def _time_mean(t, levels):
    """Return the mean over time, each sample weighted by the time it stands for; the plain mean where t is uniform."""
    return np.average(levels, axis=-1, weights=np.gradient(t))


def _check_positive(name, value):
    if not value > 0:
        raise SceneError(f"{value:g} is not positive", where=name, cure="give a number above zero")


def _check_moving(incident, depth):
    if incident < STILL * depth:
        raise SceneError(
            "no incident wave is in the record",
            where="gauges",
            why="the reflection coefficient is relative to it",
            cure="take a later part of the run",
        )


def _wavenumber(period, depth, gravity):
    """Return k [1/m] of linear theory."""
    for name, value in (("period", period), ("depth", depth), ("gravity", gravity)):
        _check_positive(name, value)
    return waves.wavenumber(2 * math.pi / period, depth, gravity)


def _whole_periods(t, period):
    """Return the number of whole periods in the record, at least one."""
    _check_positive("period", period)
    whole = int(np.ptp(t) / period + 1e-6)
    if not whole:
        raise SceneError(
            f"{np.ptp(t):g} s are shorter than a period of {period:g} s",
            where="record",
            why="no whole wave is in it",
            cure="take a longer record",
        )
    return whole


def _last_periods(t, period, most=None):
    """Return the mask of the last whole periods, of `most` at most: half open, so that no phase is counted twice."""
    whole = _whole_periods(t, period)
    return t > t[-1] - (min(whole, most or whole) - 1e-6) * period


def _fit(t, level, period, count):
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


def check_gauges(x, period, depth, gravity):
    """Raise SceneError when gauges at `x` [m] cannot separate waves of `period` [s] by least squares.

    Parameters
    ----------
    x : sequence of float
        Positions of the gauges [m].
    period, depth, gravity : float
        [s], [m], [m/s^2].
    """
    x = np.asarray(x, float)
    if x.size < 3:
        raise SceneError(
            f"the separation needs three gauges, not {x.size}",
            where="gauges",
            why="least squares of two unknown waves, after Mansard & Funke",
            cure="more level gauges, a tenth and a quarter of a wavelength from the first, say",
        )
    wavenumber = _wavenumber(period, depth, gravity)
    if not _usable(x, wavenumber):
        raise _degenerate(x, 2 * math.pi / wavenumber)


def _usable(x, wavenumber):
    """Return whether gauges at x (gauges,) tell incident from reflected waves, for one or many k."""
    determinant = 1 - np.abs(np.mean(np.exp(2j * np.multiply.outer(x, wavenumber)), axis=0)) ** 2
    return determinant >= (LEAST_OF_TWO if x.size == 2 else LEAST_OF_MANY)


def _degenerate(x, wavelength):
    """Return the error for gauges that do not tell incident from reflected waves."""
    if x.size == 2:
        distance = abs(x[1] - x[0])
        return SceneError(
            f"a distance of {distance:g} m is {distance / wavelength:.3g} of the wavelength {wavelength:g} m",
            where="gauges",
            why="(nearly) a multiple of half a wavelength apart, two gauges see the same of both waves",
            cure=f"take 0.05 to 0.45 wavelengths (Goda & Suzuki), best {0.25 * wavelength:.3g} m",
        )
    return SceneError(
        f"all of the {x.size} gauges stand (nearly) multiples of half a wavelength apart, {0.5 * wavelength:g} m",
        where="gauges",
        why="they see the same of incident and reflected waves",
        cure=f"take distances of, say, {wavelength / 10:.3g} and {wavelength / 4:.3g} m from the first gauge",
    )


def _solve(x, amplitudes, wavenumber):
    """Return a_i and a_r of the normal equations, amplitudes (gauges,) with one k or (gauges, m) with m of them.

    ``n a_i + S a_r = sum A exp(ikx)``, ``S* a_i + n a_r = sum A exp(-ikx)``, ``S = sum exp(2ikx)``.
    """
    turn = np.exp(1j * np.multiply.outer(x, wavenumber))
    n, S = x.size, np.sum(turn**2, axis=0)
    forward, backward = np.sum(amplitudes * turn, axis=0), np.sum(amplitudes * turn.conj(), axis=0)
    determinant = n**2 - np.abs(S) ** 2
    return (n * forward - S * backward) / determinant, (n * backward - S.conj() * forward) / determinant
