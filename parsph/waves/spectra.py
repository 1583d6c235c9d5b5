"""Irregular waves: spectra, the components that stand for one, and focused groups.

Sources: Hasselmann et al. (1973), Measurements of wind-wave growth and swell decay during the Joint North Sea Wave Project,
Dt. Hydrogr. Z. Suppl. A8(12); Pierson & Moskowitz (1964), J. Geophys. Res. 69, 5181-5190; Goda (2010), Random seas and design
of maritime structures, 3rd ed., World Scientific; Tromans, Anaturk & Hagemeijer (1991), A new model for the
kinematics of large ocean waves, Proc. 1st ISOPE Conf. III, 64-71, for focused groups.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..errors import SceneError
from .linear import _positive, wavenumber

SIGMA_LOW, SIGMA_HIGH = 0.07, 0.09  # width of the JONSWAP peak below and above its frequency
LEAST_SHARE = 0.8  # of the energy that a band of frequencies must hold to stand for the spectrum


@dataclass(frozen=True)
class Jonswap:
    """``S(f) ~ f^-5 exp(-5/4 (fp/f)^4) gamma^exp(-(f/fp - 1)^2 / (2 sigma^2))``, Hasselmann et al. (1973).

    sigma = 0.07 up to the peak and 0.09 above. The factor is such that ``int S df = Hs^2/16``, by quadrature.

    Attributes
    ----------
    height : float
        Significant height Hs = 4 sqrt(m0) [m].
    period : float
        Peak period Tp [s].
    gamma : float
        Peak enhancement, >= 1.
    """

    height: float
    period: float
    gamma: float = 3.3

    def __post_init__(self):
        _positive(height=self.height, period=self.period)
        if not 1 <= self.gamma < math.inf:
            raise SceneError(f"is {self.gamma:g}", "gamma", "the peak is no lower than Pierson and Moskowitz's", "1 or more")

    @property
    def energy(self):
        """m0 = Hs^2/16 [m^2]."""
        return self.height**2 / 16

    def density(self, frequency):
        """Return S [m^2/Hz] at `frequency` [Hz], shape (...)."""
        return self.energy * self.period * self._shape(np.asarray(frequency, float) * self.period) / self._moment

    def _shape(self, ratio):
        ratio = np.maximum(ratio, 0.1)  # where nothing is left of the spectrum
        sigma = np.where(ratio <= 1, SIGMA_LOW, SIGMA_HIGH)
        peak = self.gamma ** np.exp(-((ratio - 1) ** 2) / (2 * sigma**2))
        return ratio**-5.0 * np.exp(-1.25 * ratio**-4.0) * peak

    @cached_property
    def _moment(self):
        ratio = np.linspace(0.1, 20, 40001)
        tail = 0.25 * ratio[-1] ** -4  # of f^-5
        return float(np.trapezoid(self._shape(ratio), ratio)) + tail


@dataclass(frozen=True)
class PiersonMoskowitz(Jonswap):
    """``S(f) ~ f^-5 exp(-5/4 (fp/f)^4)``, Pierson & Moskowitz (1964): the fully grown sea, JONSWAP's with gamma = 1.

    Attributes
    ----------
    height, period : float
        Hs [m], Tp [s].
    """

    gamma: float = field(default=1.0, init=False)


@dataclass(frozen=True, eq=False)
class Tabulated:
    """A spectrum from a table, linear between its rows and nothing outside.

    Attributes
    ----------
    frequencies : array_like, shape (n,)
        [Hz], increasing.
    densities : array_like, shape (n,)
        [m^2/Hz], >= 0.
    """

    frequencies: np.ndarray
    densities: np.ndarray

    def __post_init__(self):
        f, S = np.asarray(self.frequencies, float), np.asarray(self.densities, float)
        fits = f.ndim == 1 and f.shape == S.shape and len(f) > 1
        if not (fits and np.isfinite([f, S]).all() and f[0] >= 0 and (np.diff(f) > 0).all() and (S >= 0).all() and S.any()):
            why = "it needs two or more increasing frequencies and as many densities, none below 0 and not all 0"
            raise SceneError("is no table of a spectrum", "spectrum", why, "rows of frequency [Hz] and density [m^2/Hz]")
        object.__setattr__(self, "frequencies", f)
        object.__setattr__(self, "densities", S)

    @property
    def energy(self):
        """m0, the integral of the table [m^2]."""
        return float(np.trapezoid(self.densities, self.frequencies))

    @property
    def height(self):
        """Significant height Hs = 4 sqrt(m0) [m]."""
        return 4 * math.sqrt(self.energy)

    def density(self, frequency):
        """Return S [m^2/Hz] at `frequency` [Hz], shape (...)."""
        return np.interp(frequency, self.frequencies, self.densities, left=0.0, right=0.0)


SPECTRA = {"jonswap": Jonswap, "pierson-moskowitz": PiersonMoskowitz, "table": Tabulated}


@dataclass(frozen=True, eq=False)
class Components:
    """Linear waves whose sum is an irregular one, ``eta = sum_i a_i cos(k_i x - 2 pi f_i t + phase_i)``.

    Attributes
    ----------
    amplitude : ndarray, shape (n,)
        [m]
    frequency : ndarray, shape (n,)
        [Hz]
    phase : ndarray, shape (n,)
        [rad]
    """

    amplitude: np.ndarray
    frequency: np.ndarray
    phase: np.ndarray

    @property
    def height(self):
        """Significant height ``4 sqrt(sum a^2/2)`` [m]."""
        return 4 * math.sqrt(0.5 * float((self.amplitude**2).sum()))

    def wavenumbers(self, depth, gravity):
        """Return k [1/m], shape (n,), on `depth` [m] with `gravity` [m/s^2]."""
        return _wavenumbers(self.frequency, depth, gravity)

    def elevation(self, x, t, depth, gravity):
        """Return eta [m] at `x` [m] and `t` [s], which broadcast to shape (...)."""
        x, t = np.broadcast_arrays(np.asarray(x, float), np.asarray(t, float))
        turn = self.wavenumbers(depth, gravity) * x[..., None] - 2 * math.pi * self.frequency * t[..., None] + self.phase
        return (self.amplitude * np.cos(turn)).sum(-1)


def components(spectrum, low, high, count, seed=0, jitter=True):
    """Return linear waves with random phases that have a spectrum's energy.

    The band is cut into `count` equal steps df with one wave in each, ``a = sqrt(2 S df)``; the phases alone are random, and
    the amplitudes are scaled so that their energy is the spectrum's, Hs^2/16, exactly. Equal steps resolve the tails as well as
    the peak, where equal energies leave the low frequencies to a few waves whose beat shows (see Goda 2010). Waves in
    the middle of each step would repeat their record after 1/df; so each stands at a random place in its step, which never
    repeats. A record of the duration D still needs steps below 1/D, ``count > D (high - low)``, to have as many degrees of
    freedom as the sea.

    Parameters
    ----------
    spectrum
        One of `SPECTRA`, or anything with ``density(f)`` and ``energy``.
    low, high : float
        Band [Hz].
    count : int
        Number of waves.
    seed : int
        Of numpy's PCG64; the same seed gives the same waves.
    jitter : bool
        False: the middle of each step.

    Returns
    -------
    Components

    Raises
    ------
    SceneError
        When the band is empty or leaves out more than a fifth of the energy.
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    phase, place = rng.uniform(0, 2 * math.pi, count), rng.uniform(0, 1, count)
    frequency, density, step = _steps(spectrum, low, high, count, place if jitter else 0.5)
    amplitude = np.sqrt(2 * density * step)
    return Components(amplitude * math.sqrt(spectrum.energy / (0.5 * (amplitude**2).sum())), frequency, phase)


def focused(spectrum, crest, low, high, count, place, time, depth, gravity):
    """Return linear waves that meet crest on crest at one place and time.

    ``a_i = A S(f_i) df / sum_j S(f_j) df``: NewWave, the mean shape of a high crest in the spectrum's sea, Tromans et al.
    (1991).

    Parameters
    ----------
    spectrum
        As in `components`; only its shape counts.
    crest : float
        Linear elevation A of the crest [m].
    low, high, count
        Band [Hz] and number of waves. The group comes back after ``count/(high - low)`` seconds.
    place, time : float
        Where [m] and when [s].
    depth, gravity : float
        [m], [m/s^2]

    Returns
    -------
    Components

    Raises
    ------
    SceneError
        As `components`.
    """
    frequency, density, _ = _steps(spectrum, low, high, count, 0.5)
    turn = 2 * math.pi * frequency * time - _wavenumbers(frequency, depth, gravity) * place
    return Components(crest * density / density.sum(), frequency, turn % (2 * math.pi))


def _steps(spectrum, low, high, count, place):
    """Return one frequency in each step [Hz], the densities there [m^2/Hz], and the step [Hz]."""
    if not (0 < low < high < math.inf and count >= 1):
        what = f"holds no {count} waves between {low:g} and {high:g} Hz"
        raise SceneError(what, "band", cure="0 < low < high and one wave or more")
    step = (high - low) / count
    frequency = low + step * (np.arange(count) + place)
    fine = np.linspace(low, high, 4001)
    share = float(np.trapezoid(spectrum.density(fine), fine)) / spectrum.energy
    density = spectrum.density(frequency)
    if share < LEAST_SHARE or not density.any():
        why = f"between {low:g} and {high:g} Hz there is {100 * share:.3g} % of the energy"
        raise SceneError("leaves out too much of the spectrum", "band", why, "about 0.5 to 3 times the peak frequency")
    return frequency, density, step


def _wavenumbers(frequency, depth, gravity):
    return np.array([wavenumber(2 * math.pi * f, depth, gravity) for f in frequency])
