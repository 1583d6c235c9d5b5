"""Linear progressive waves: dispersion, speeds, and what viscosity takes from them."""

import math
from dataclasses import dataclass

from ..errors import SceneError


def angular_frequency(wavenumber, depth, gravity):
    """Return omega [1/s] = sqrt(g k tanh(k d)), Szmidt eq. (41), for k [1/m], d [m], g [m/s^2]."""
    return math.sqrt(gravity * wavenumber * math.tanh(wavenumber * depth))


def wavenumber(frequency, depth, gravity):
    """Return the k [1/m] that solves omega^2 = g k tanh(k d).

    Parameters
    ----------
    frequency : float
        Angular frequency omega [1/s], > 0.
    depth, gravity : float
        Still-water depth [m] and gravity [m/s^2].
    """
    from scipy.optimize import brentq  # slow to import, and few runs need it

    deep, shallow = frequency**2 / gravity, frequency / math.sqrt(gravity * depth)
    return brentq(lambda k: gravity * k * math.tanh(k * depth) - frequency**2, 0.999 * deep, deep + shallow, xtol=1e-14)


def phase_speed(period, depth, gravity):
    """Return c = omega/k [m/s] of linear waves of `period` [s] on `depth` [m], gravity [m/s^2]."""
    frequency = 2 * math.pi / period
    return frequency / wavenumber(frequency, depth, gravity)


def group_speed(wavenumber, depth, gravity):
    """Return ``c_g = d omega/dk = (c/2) (1 + 2kd / sinh 2kd)`` [m/s] for k [1/m], d [m], g [m/s^2]."""
    kd = wavenumber * depth
    # 2kd/sinh 2kd without overflow; deep water leaves nothing of it
    share = 4 * kd * math.exp(-2 * kd) / -math.expm1(-4 * kd)
    return 0.5 * angular_frequency(wavenumber, depth, gravity) / wavenumber * (1 + share)


@dataclass(frozen=True)
class Dispersion:
    """A linear wave of given depth and gravity.

    Attributes
    ----------
    period : float
        T [s]
    frequency : float
        Angular frequency omega [1/s].
    wavelength : float
        L [m]
    wavenumber : float
        k [1/m]
    phase_speed, group_speed : float
        c, c_g [m/s].
    kd : float
        Wavenumber times depth: below pi/10 the water is shallow, above pi deep.
    """

    period: float
    frequency: float
    wavelength: float
    wavenumber: float
    phase_speed: float
    group_speed: float
    kd: float


def dispersion(depth, gravity, period=None, frequency=None, wavelength=None):
    """Return the linear wave that one of its period, frequency and wavelength determines.

    ``omega^2 = g k tanh(k d)``, Airy (1845); Szmidt eq. (41).

    Parameters
    ----------
    depth, gravity : float
        Still-water depth [m], gravity [m/s^2].
    period, frequency, wavelength : float
        Exactly one of T [s], 1/T [Hz], L [m].

    Returns
    -------
    Dispersion

    Raises
    ------
    SceneError
        When not exactly one is given, or a value is not above 0.
    """
    _positive(depth=depth, gravity=gravity)
    _one_of(period, frequency, wavelength)
    _positive(period=period, frequency=frequency, wavelength=wavelength)
    if wavelength is not None:
        k = 2 * math.pi / wavelength
        omega = angular_frequency(k, depth, gravity)
    else:
        omega = 2 * math.pi * frequency if period is None else 2 * math.pi / period
        k = wavenumber(omega, depth, gravity)
    speed = group_speed(k, depth, gravity)
    return Dispersion(2 * math.pi / omega, omega, 2 * math.pi / k, k, omega / k, speed, k * depth)


def _one_of(period, frequency, wavelength):
    given = {"period": period, "frequency": frequency, "wavelength": wavelength}
    named = [name for name, value in given.items() if value is not None]
    if len(named) != 1:
        what = f"needs exactly one of period, frequency and wavelength, but got {' and '.join(named) or 'none'}"
        raise SceneError(what, "wave", "depth and gravity fix the other two", "give one of them")


def _positive(**values):
    for name, value in values.items():
        if value is not None and not 0 < value < math.inf:
            raise SceneError(f"is {value:g}", name, cure="a number above 0")


def viscosity_of_alpha(alpha, h, c0, dim):
    """Return the kinematic viscosity [m^2/s] that artificial viscosity `alpha` stands for: alpha h c0 / (4 (dim + 2)).

    Half of Monaghan's (2005) alpha h c0 / (2 (dim + 2)), which holds where all pairs of particles feel it: of a strain rate in
    regular order approaching pairs, which alone do, dissipate one half.
    """
    return alpha * h * c0 / (4 * (dim + 2))


def decay_in_time(viscosity, wavenumber):
    """Return the rate ``2 nu k^2`` [1/s] at which viscosity takes from the amplitude of any linear wave.

    Over a bed with free slip, on any depth: the rate of strain of the potential flow dissipates ``4 nu k^2`` of its energy
    (Lamb, Hydrodynamics, section 348). Standing waves fall as ``exp(-2 nu k^2 t)``.

    Parameters
    ----------
    viscosity, wavenumber : float
        nu [m^2/s], see `viscosity_of_alpha`; k [1/m].
    """
    return 2 * viscosity * wavenumber**2


def decay_in_space(viscosity, wavenumber, depth, gravity):
    """Return the rate ``2 nu k^2 / c_g`` [1/m] at which the amplitude of a progressive wave falls along the tank.

    Energy travels with the group speed c_g while it decays in time, see `decay_in_time`.

    Parameters
    ----------
    viscosity, wavenumber : float
        nu [m^2/s], k [1/m].
    depth, gravity : float
        [m], [m/s^2]
    """
    return decay_in_time(viscosity, wavenumber) / group_speed(wavenumber, depth, gravity)
