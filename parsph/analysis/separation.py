"""Incident and reflected waves from gauges along the tank.

Sources: Goda & Suzuki (1976), Estimation of incident and reflected waves in random wave experiments, Proc. 15th Int. Conf.
Coastal Engineering, 828-845; Mansard & Funke (1980), The measurement of incident and reflected spectra using a least squares
method, Proc. 17th Int. Conf. Coastal Engineering, 154-172.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .records import check_positive, fit, gauges_of, last_periods, linear_wavenumber, uniform_step

# How well gauges tell the two waves apart is the determinant of the normal equations over n^2: 1 - |mean exp(2ikx)|^2.
# For two gauges it is sin^2(k dx), and Goda & Suzuki's range 0.05 < dx/wavelength < 0.45 is where it exceeds sin^2(pi/10).
# For more gauges the noise in the amplitudes grows with its inverse root: tenfold at 0.01, against the best layout.
LEAST_OF_TWO, LEAST_OF_MANY = math.sin(math.pi / 10) ** 2, 0.01
STILL = 1e-9  # of the depth: an incident wave below this is rounding


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
    check_positive("wavenumber", wavenumber)
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
    t, levels, x = gauges_of(t, levels, x)
    suits = {"goda-suzuki": x.size == 2, "mansard-funke": x.size >= 3}
    if not suits.get(method, False):
        raise SceneError(
            f'method "{method}" does not suit {x.size} gauge(s)',
            where="gauges",
            cure='take method "goda-suzuki" for two gauges, "mansard-funke" for three or more',
        )
    wavenumber = linear_wavenumber(period, depth, gravity)
    late = last_periods(t, period, periods)
    amplitudes = np.array([fit(t[late], level, period, 2)[1] for level in levels[:, late]])
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
    t, levels, x = gauges_of(t, levels, x)
    step, uniform = uniform_step(t)
    if not uniform:
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
    wavenumbers = np.array([linear_wavenumber(1 / f, depth, gravity) for f in frequency])
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
    wavenumber = linear_wavenumber(period, depth, gravity)
    if not _usable(x, wavenumber):
        raise _degenerate(x, 2 * math.pi / wavenumber)


def _check_moving(incident, depth):
    if incident < STILL * depth:
        raise SceneError(
            "no incident wave is in the record",
            where="gauges",
            why="the reflection coefficient is relative to it",
            cure="take a later part of the run",
        )


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
