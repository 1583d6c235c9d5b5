"""Nonlinear regular waves on a flat bed, as sums of harmonics that a compiled loop can evaluate.

    ``eta = sum_j a_j cos j(kx - omega t)``,
    ``u = sum_j U_j cosh(jkz)/cosh(jkd) cos j(kx - omega t)``,
    ``w = sum_j U_j sinh(jkz)/cosh(jkd) sin j(kx - omega t)``,

z from the bed. There is no uniform part: below the troughs the mean velocity at a fixed place is zero (Stokes' first definition
of the celerity), so that the mean transport is the Stokes drift.

Theories, evaluated by raschii: Airy; Fenton (1985), A fifth-order Stokes theory for steady waves, J. Waterway Port Coastal
Ocean Eng. 111, 216-234; Rienecker & Fenton (1981), A Fourier approximation method for steady water waves, J. Fluid Mech. 104,
119-137.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..errors import SceneError, did_you_mean
from .limits import highest_wave, ursell
from .linear import _one_of, _positive, dispersion

SHORTEST = {"stokes": 0.05, "others": 0.01}  # of the depth
MOST_SOLUTIONS = 25  # of steady waves on the way to that of a period, which takes about ten
STOKES = 40.0  # of H L^2/d^3: Hedges (1995), Regions of validity of analytical wave theories, Proc. ICE 112, 111-114


@dataclass(frozen=True, eq=False)
class RegularWave:
    """A regular wave to the right with a crest at x = 0 at t = 0.

    Attributes
    ----------
    height, depth, gravity : float
        H [m], d [m], g [m/s^2].
    wavelength, period : float
        L [m], T [s].
    elevations : ndarray, shape (n,)
        a_j [m], j = 1 ... n.
    velocities : ndarray, shape (n,)
        U_j [m/s].
    """

    height: float
    depth: float
    gravity: float
    wavelength: float
    period: float
    elevations: np.ndarray
    velocities: np.ndarray

    @property
    def wavenumber(self):
        """Wavenumber 2 pi / L [1/m]."""
        return 2 * math.pi / self.wavelength

    @property
    def frequency(self):
        """Angular frequency [1/s]."""
        return 2 * math.pi / self.period

    @property
    def celerity(self):
        """Speed of the crests, L/T [m/s]."""
        return self.wavelength / self.period

    def _turns(self, x, t):
        turn = self.wavenumber * np.asarray(x, float) - self.frequency * np.asarray(t, float)
        return turn[..., None]

    def elevation(self, x, t):
        """Return eta [m] at `x` [m] and `t` [s], which broadcast to shape (...)."""
        j = np.arange(1, len(self.elevations) + 1)
        return (self.elevations * np.cos(j * self._turns(x, t))).sum(-1)

    def velocity(self, x, z, t):
        """Return u and w [m/s] at `x` [m], `z` [m] above the bed and `t` [s], which broadcast to (...): shape (..., 2)."""
        x, z, t = np.broadcast_arrays(*(np.asarray(value, float) for value in (x, z, t)))
        j = np.arange(1, len(self.velocities) + 1)
        jk, turn = j * self.wavenumber, j * self._turns(x, t)
        fall = np.exp(-2 * jk * z[..., None])  # cosh jkz / cosh jkd without overflow
        scale = self.velocities * np.exp(jk * (z[..., None] - self.depth)) / (1 + np.exp(-2 * jk * self.depth))
        along, up = (scale * (1 + fall) * np.cos(turn)).sum(-1), (scale * (1 - fall) * np.sin(turn)).sum(-1)
        return np.stack([along, up], axis=-1)


def _airy(wave):
    """Airy: one harmonic."""
    kd = wave.k * wave.depth
    return [0.5 * wave.height], [0.5 * wave.height * wave.omega / math.tanh(kd)]


def _stokes(wave):
    """Fenton (1985): ``A_ij``, ``B_ij`` in powers of ``kH/2``."""
    slope, data = 0.5 * wave.k * wave.height, wave.data
    scale = data["C0"] * math.sqrt(wave.g / wave.k)
    levels, speeds = [], []
    first = -(data["B53"] + data["B55"])
    powers = [
        {1: 1.0, 3: data["B31"], 5: first},
        {2: data["B22"], 4: data["B42"]},
        {3: -data["B31"], 5: data["B53"]},
        {4: data["B44"]},
        {5: data["B55"]},
    ]
    for j, terms in enumerate(powers, 1):
        levels.append(sum(slope**i * factor for i, factor in terms.items()) / wave.k)
        inside = sum(slope**i * data[f"A{i}{j}"] for i in range(j, 6, 2))
        speeds.append(scale * j * inside * math.cosh(j * wave.k * wave.depth))
    return levels, speeds


def _fenton(wave):
    """Rienecker & Fenton (1981): the stream function's B_j and the cosine transform of the surface's nodes."""
    count = len(wave.eta) - 1
    levels = 2 / count * np.array(wave.E[1:])
    levels[-1] *= 0.5
    return levels, wave.k * np.arange(1, count + 1) * wave.data["B"][1:]


REGULAR_THEORIES = {"airy": _airy, "stokes": _stokes, "fenton": _fenton}


@lru_cache  # a scene asks for its wave several times
def regular_wave(height, depth, gravity, period=None, frequency=None, wavelength=None, theory="fenton", order=None):
    """Return a nonlinear regular wave.

    Parameters
    ----------
    height, depth, gravity : float
        Crest to trough [m], still-water depth [m], gravity [m/s^2].
    period, frequency, wavelength : float
        Exactly one of T [s], 1/T [Hz], L [m].
    theory : str
        One of `REGULAR_THEORIES`.
    order : int, optional
        Of the theory; default: 5 for "stokes", and for "fenton" 10 or, for long waves, up to 30.

    Returns
    -------
    RegularWave

    Raises
    ------
    SceneError
        For bad input, a wave higher than the highest, or when the theory's equations have no solution.
    """
    if theory not in REGULAR_THEORIES:
        cure = f"{did_you_mean(theory, REGULAR_THEORIES)}one of: {', '.join(REGULAR_THEORIES)}"
        raise SceneError(f"there is no theory {theory!r} of regular waves", "theory", cure=cure)
    _positive(height=height, depth=depth, gravity=gravity)
    _one_of(period, frequency, wavelength)
    _positive(period=period, frequency=frequency, wavelength=wavelength)
    asked = 1 / frequency if frequency is not None else period

    @lru_cache  # a search comes back to the ends of its bracket
    def wave_of(length):
        return _raschii(theory, height, depth, length, gravity, order)

    if wavelength is None:
        wavelength = dispersion(depth, gravity, period=asked).wavelength
    shortest = SHORTEST["stokes" if theory == "stokes" else "others"] * depth
    if wavelength < shortest:
        why = "its hyperbolic functions of the depth overflow, and it feels no bed"
        cure = f"at least {shortest:.3g} m, or shallower water"
        raise SceneError(f"is {wavelength:.3g} m on {depth:g} m of water", "wavelength", why, cure)
    if theory != "airy":
        _steady(theory, height, depth, 1.3 * wavelength if asked else wavelength)  # waves of a period are longer, if nonlinear
        if asked:
            wavelength = _length_of(wave_of, asked, wavelength)
        _steady(theory, height, depth, wavelength)
    wave = wave_of(wavelength)
    levels, speeds = (np.array(values, float) for values in REGULAR_THEORIES[theory](wave))
    return RegularWave(height, depth, gravity, wavelength, float(wavelength / wave.c), levels, speeds)


def _steady(theory, height, depth, length):
    """Raise an error for a wave that `theory` does not have."""
    highest = highest_wave(length, depth)
    if height > highest:
        why = f"steady waves {length:.4g} m long have at most {highest:.3g} m"
        raise SceneError(f"is {height:g} m", "height", why, "a lower or longer wave, or deeper water")
    number = ursell(height, length, depth)
    if theory == "stokes" and number > STOKES:
        why = f"H L^2/d^3 is {number:.3g}, and the series needs less than {STOKES:g}"
        raise SceneError("'stokes' is no theory of waves so long", "theory", why, "'fenton'")


def _raschii(theory, height, depth, length, gravity, order):
    import raschii

    if theory == "airy":
        return raschii.AiryWave(height, depth, length, g=gravity)
    if theory == "stokes":
        return raschii.StokesWave(height, depth, length, N=order or 5, g=gravity)
    order = order or min(30, max(10, round(1.2 * length / depth)))
    for relax in (1.0, 0.5):  # Newton's steps, and halves of them for what these do not find
        try:
            with np.errstate(all="ignore"):  # Newton's steps may go astray and come back
                wave = raschii.FentonWave(height, depth, length, N=order, g=gravity, relax=relax)
            if math.isfinite(wave.c):
                return wave
            last = ArithmeticError("a speed that is not finite")
        except (raschii.RaschiiError, np.linalg.LinAlgError, ArithmeticError) as error:
            last = error
    why = f"the stream function's equations have no solution that could be found ({' '.join(str(last).split())})"
    cure = "a lower wave or another order"
    raise SceneError(f"is {height:g} m for a wavelength of {length:g} m", "height", why, cure) from last


def _length_of(wave_of, period, linear):
    """Return the wavelength at which a wave has the `period`, starting from linear theory's."""
    from scipy.optimize import brentq

    tried = set()

    def late(length):
        tried.add(length)
        if len(tried) > MOST_SOLUTIONS:
            why = "near the highest wave, and in very long ones, the equations have several solutions, which take turns"
            raise SceneError(f"no wave of {period:g} s could be found", "height", why, "a lower or shorter wave")
        return length / wave_of(length).c - period

    low, high = 0.999 * linear, 1.05 * linear
    while late(high) < 0:
        low, high = high, 1.1 * high
    while late(low) > 0:
        low *= 0.9
    return brentq(late, low, high, xtol=1e-10 * linear, rtol=1e-10)
