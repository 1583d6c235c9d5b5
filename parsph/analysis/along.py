"""Regular waves along the tank: their harmonics, bound and free second harmonics, and their decay by viscosity.

Sources: Madsen (1971), On the generation of long waves, J. Geophysical Research 76, 8672-8683, for the free second harmonic
that a sinusoidal wavemaker sends along; Lamb (1932), Hydrodynamics, 6th ed., sections 348 and 349, for the decay.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..waves import decay_in_space
from .records import check_positive, fit, gauges_of, last_periods, linear_wavenumber
from .separation import LEAST_OF_MANY, LEAST_OF_TWO


@dataclass(frozen=True)
class SecondHarmonic:
    """The parts of the second harmonic; complex amplitudes are those at x = 0.

    Attributes
    ----------
    bound : complex
        Of the part that the first harmonic carries along [m].
    free : complex
        Of the free wave that runs with it [m].
    reflected : complex
        Of the free wave that comes back [m]; 0 where it was not asked for.
    residual : float
        Root mean square misfit of the gauges' complex amplitudes [m].
    beat_length : float
        ``2 pi / (K - 2k)`` [m], over which bound and free part meet again.
    """

    bound: complex
    free: complex
    reflected: complex
    residual: float
    beat_length: float


@dataclass(frozen=True)
class Decay:
    """Amplitudes that fall along the tank, ``a(x) = a_0 exp(-b x)``.

    Attributes
    ----------
    amplitude : float
        a_0, at x = 0, in the unit of the amplitudes.
    rate : float
        b [1/m]; negative where they grow.
    error : float
        Standard error of b [1/m], by what the amplitudes scatter about the fit.
    """

    amplitude: float
    rate: float
    error: float

    def at(self, x):
        """Return a(x) at `x` [m], of its shape."""
        return self.amplitude * np.exp(-self.rate * np.asarray(x, float))


def harmonics_along(t, levels, x, period, count=3, periods=None):
    """Fit the harmonics of regular waves at each gauge (see `harmonics`), over the last whole periods of the record.

    Parameters
    ----------
    t : array_like, shape (samples,)
        Times [s].
    levels : array_like, shape (gauges, samples)
        [m]
    x : array_like, shape (gauges,)
        Positions of the gauges [m].
    period : float
        Of the first harmonic [s].
    count : int
        Number of harmonics.
    periods : int, optional
        So many at the end of the record count at most; default: all whole ones.

    Returns
    -------
    ndarray of complex, shape (gauges, count)
        a_1 to a_count [m] of each gauge, their absolute values the amplitudes.

    Raises
    ------
    SceneError
        When the record is shorter than a period, has too few samples, or does not match the gauges.
    """
    t, levels, _ = gauges_of(t, levels, x)
    late = last_periods(t, period, periods)
    return np.array([fit(t[late], level, period, count)[1:] for level in levels[:, late]])


def second_harmonic(x, amplitudes, k_bound, k_free, reflected=False):
    """Separate the second harmonic into bound and free waves by least squares.

    ``a_2(x) = b exp(-i 2k x) + f exp(-i K x) [+ r exp(i K x)]``: the bound wave runs with the first harmonic, the free ones as
    waves of half the period do, ``(2w)^2 = g K tanh(K d)``. An exact wavemaker makes no free wave (Madsen 1971).

    Parameters
    ----------
    x : array_like, shape (gauges,)
        Positions [m].
    amplitudes : array_like of complex, shape (gauges,)
        a_2 of each gauge [m], as `harmonics_along` has them.
    k_bound, k_free : float
        2k and K [1/m].
    reflected : bool
        Whether a free wave comes back too, which takes one gauge more.

    Returns
    -------
    SecondHarmonic

    Raises
    ------
    SceneError
        When gauges and amplitudes do not match, there are too few, or the gauges do not tell the waves apart: they all stand
        (nearly) multiples of a beat length ``2 pi / (K - 2k)`` apart, or on a small part of it.
    """
    x, amplitudes = np.asarray(x, dtype=float), np.asarray(amplitudes, dtype=complex)
    numbers = np.array([k_bound, k_free, -k_free][: 3 if reflected else 2])
    if x.ndim != 1 or x.shape != amplitudes.shape or x.size < numbers.size:
        raise SceneError(
            f"positions have shape {x.shape}, amplitudes {amplitudes.shape}",
            where="gauges",
            why=f"{numbers.size} waves need {numbers.size} gauges at least, and each gauge one amplitude",
            cure="give as many positions as amplitudes",
        )
    for name, value in (("bound wavenumber", k_bound), ("free wavenumber", k_free)):
        check_positive(name, value)
    beat = 2 * math.pi / abs(k_free - k_bound) if k_free != k_bound else math.inf
    waves = np.exp(-1j * np.outer(x, numbers))
    if not _told_apart(waves):
        back = f", and of half the free wavelength, {math.pi / k_free:.3g} m," if reflected else ""
        raise SceneError(
            f"the {x.size} gauges, over {np.ptp(x):g} m, do not tell bound from free waves",
            where="gauges",
            why=f"they see the same of both (nearly) multiples of the beat length{back} apart, {beat:.3g} m",
            cure=f"spread them over half a beat length, {0.5 * beat:.3g} m, at unequal distances",
        )
    parts = np.linalg.lstsq(waves, amplitudes, rcond=None)[0]
    residual = math.sqrt(np.mean(np.abs(amplitudes - waves @ parts) ** 2))
    bound, free, back = (complex(part) for part in [*parts, 0.0][:3])
    return SecondHarmonic(bound, free, back, residual, beat)


def _told_apart(waves):
    """Return whether gauges tell waves apart, their values (gauges, waves) given; the bound is that of `separate`.

    The variance of a fitted amplitude is that of a gauge times ``(A* A)^-1``. For two waves its diagonal is 1/(n D), D the
    determinant that `separate` looks at, so that for three 1/(n diagonal) stands in its place.
    """
    gauges = len(waves)
    normal = waves.conj().T @ waves / gauges
    if np.linalg.eigvalsh(normal)[0] < 1e-12:
        return False
    least = LEAST_OF_TWO if gauges == 2 else LEAST_OF_MANY
    return bool(1 / np.linalg.inv(normal).diagonal().real.max() >= least)


def decay_along(x, amplitudes):
    """Fit amplitudes that fall exponentially, ``ln a = ln a_0 - b x``, by least squares.

    The logarithm weights each gauge alike, as scatter goes with the amplitude: that of reflection, say, which is periodic in
    half a wavelength and averages out over gauges spread evenly on some of them.

    Parameters
    ----------
    x : array_like, shape (gauges,)
        Positions [m].
    amplitudes : array_like, shape (gauges,)
        Positive, of any unit; of complex ones the absolute value.

    Returns
    -------
    Decay

    Raises
    ------
    SceneError
        When there are fewer than three gauges or places, or an amplitude is zero.
    """
    x, amplitudes = np.asarray(x, dtype=float), np.abs(amplitudes)
    if x.ndim != 1 or x.shape != amplitudes.shape or np.unique(x).size < 3:
        raise SceneError(
            f"positions have shape {x.shape}, amplitudes {amplitudes.shape}",
            where="gauges",
            why="two unknowns and their error need three places at least, and each gauge one amplitude",
            cure="take more gauges, at different places",
        )
    if not np.all(amplitudes > 0):
        raise SceneError("an amplitude is zero", where="gauges", why="it has no logarithm", cure="take a later part of the run")
    offset, logarithm = x - x.mean(), np.log(amplitudes)
    slope = offset @ logarithm / (offset @ offset)
    left = logarithm - logarithm.mean() - slope * offset
    error = math.sqrt(left @ left / (x.size - 2) / (offset @ offset))
    return Decay(float(np.exp(logarithm.mean() - slope * x.mean())), float(-slope), error)


def expected_decay(period, depth, gravity, nu):
    """Return b [1/m] of ``a(x) = a_0 exp(-b x)`` that viscosity takes of linear waves between free-slip walls.

    ``b = 2 nu k^2 / c_g``. Lamb's (1932) dissipation of the irrotational wave, ``dE/dt = -4 nu k^2 E``, holds for any depth
    where the bed is free of stress: ``integral of 2 mu e_ij e_ij = mu integral of d|u|^2/dn`` over the surfaces, zero at the
    bed and ``2 mu g (k a)^2`` at the mean level, with ``E = rho g a^2 / 2``. It travels with the group.

    Parameters
    ----------
    period, depth, gravity : float
        [s], [m], [m/s^2].
    nu : float
        Kinematic viscosity [m^2/s], 0 for none.

    Raises
    ------
    SceneError
        When period, depth or gravity is not positive.
    """
    return decay_in_space(nu, linear_wavenumber(period, depth, gravity), depth, gravity)
