"""Paddles: the waves that pistons and flaps make, near and far, to first and second order.

A paddle at x = 0 is displaced by ``X(z, t) = f(z) xi(t)``, z from the bed, ``f(d) = 1``: ``f = 1`` for a piston,
``f = max(z - h, 0)/(d - h)`` for a flap with its hinge at the height h. Water is at x > 0.

For ``xi = (S/2) sin wt`` linear theory has the far wave ``eta = (H/2) cos(kx - wt)``, which at the paddle is in phase with its
velocity, and the near field ``eta = E(x) (S/2) sin wt``, in phase with its displacement (E > 0 at a piston).

Sources: Biesel (1951), Etude theorique d'un certain type d'appareil a houle, La Houille Blanche 6, 156-165; Dean & Dalrymple
(1991), Water wave mechanics for engineers and scientists, chapter 6; Madsen (1971), On the generation of long waves, J.
Geophys. Res. 76, 8672-8683; Schaeffer (1996), Second-order wavemaker theory for irregular waves, Ocean Eng. 23, 47-88.
"""

import math

import numpy as np

from ..errors import SceneError
from .linear import wavenumber

MADSEN = 8 * math.pi**2 / 3  # of H L^2/d^3: above it a second crest appears in the trough of the second-order wave


def transfer(kd, hinge=None):
    """Return H/S, the far wave's height over the paddle's full stroke at the still-water level.

    ``H/S = 4 sinh kd / (sinh 2kd + 2kd) k int_0^d f(z) cosh(kz) dz`` and, with the hinge at the height ``h = e d``,
    ``k int f cosh(kz) dz = sinh kd - (cosh kd - cosh(max(e, 0) kd)) / ((1 - e) kd)``: Biesel (1951), Dean & Dalrymple
    section 6.3 for piston and flap at the bed. The piston is the flap whose hinge lies infinitely deep.

    Parameters
    ----------
    kd : float
        Wavenumber times depth, > 0.
    hinge : float, optional
        Height of the flap's hinge above the bed over the depth, < 1: 0 at the bed, above 0 with a fixed wall below it, below 0
        under the bed. None: a piston.

    Raises
    ------
    SceneError
        When the hinge is not below the still-water level.
    """
    hinge = _checked(hinge)
    fall = -math.expm1(-2 * kd)
    whole = fall**2 / (0.5 * -math.expm1(-4 * kd) + 2 * kd * math.exp(-2 * kd))  # 4 sinh^2 kd / (sinh 2kd + 2kd)
    if hinge == -math.inf:
        return whole
    foot = max(hinge, 0.0)
    # (cosh kd - cosh e kd) / sinh kd as a product of sinh, exp(kd) cancelled
    lost = math.expm1(-(1 + foot) * kd) * math.expm1(-(1 - foot) * kd) / fall
    return whole * (1 - lost / ((1 - hinge) * kd))


def flap_transfer(kd):
    """Return H/S of a flap hinged at the bed, S the full stroke at the still-water level.

    ``H/S = (4 sinh kd / kd) (kd sinh kd - cosh kd + 1) / (sinh 2kd + 2kd)``, Biesel (1951), first order, far field.
    """
    return transfer(kd, 0.0)


def flap_height(amplitude, period, depth, gravity):
    """Return the far-field wave height [m] of a flap hinged at the bed, angle amplitude [rad], period [s]."""
    kd = wavenumber(2 * math.pi / period, depth, gravity) * depth
    return 2 * depth * math.tan(amplitude) * flap_transfer(kd)


def evanescent_wavenumbers(kd, modes):
    """Return ``k_n d`` of the evanescent modes, the roots of ``w^2 d/g = kd tanh kd = -k_n d tan(k_n d)``, n = 1, 2, ...

    Parameters
    ----------
    kd : float
        Of the propagating wave.
    modes : int
        How many.

    Returns
    -------
    ndarray, shape (modes,)
        Between (n - 1/2) pi and n pi.
    """
    head, ends = kd * math.tanh(kd), math.pi * np.arange(1, modes + 1)
    gap = np.zeros(modes)
    for _ in range(40):  # k_n d = n pi - gap; each round shrinks the error to less than 1/pi of itself
        gap = np.arctan(head / (ends - gap))
    return ends - gap


def near_field(kd, hinge=None, x_over_depth=0.0, modes=200):
    """Return the evanescent surface elevation over the paddle's amplitude S/2, in phase with the paddle's displacement.

    With ``xi = (S/2) sin wt`` the whole linear elevation is ``(H/2) cos(kx - wt) + E(x) (S/2) sin wt``,
    ``E = sum_n 4 sin(k_n d) k_n int_0^d f(z) cos(k_n z) dz / (2 k_n d + sin 2 k_n d) exp(-k_n x)``: Dean & Dalrymple
    section 6.3, with the condition ``u = dX/dt`` at x = 0.

    Parameters
    ----------
    kd, hinge
        As in `transfer`.
    x_over_depth : float or ndarray, shape (...)
        Distance from the paddle's mean place over the depth, >= 0.
    modes : int
        So many are summed; their amplitudes fall with the cube of their number (with the square for a hinge above the bed).

    Returns
    -------
    float or ndarray, shape (...)
    """
    k, share = near_modes(kd, hinge, modes)
    field = (share * np.exp(-k * np.asarray(x_over_depth, float)[..., None])).sum(-1)
    return float(field) if np.ndim(x_over_depth) == 0 else field


def near_modes(kd, hinge=None, modes=200):
    """Return ``k_n d`` and amplitudes at x = 0 of the modes that `near_field` sums, both of shape (modes,)."""
    k = evanescent_wavenumbers(kd, modes)
    return k, np.sin(k) * _velocities(k, _checked(hinge))


def velocity_profile(kd, hinge=None, z_over_depth=1.0, modes=200):
    """Return u at the paddle over ``w S/2 cos wt`` as the sum of the far wave and the evanescent modes: f(z), up to truncation.

    Parameters
    ----------
    kd, hinge, modes
        As in `near_field`.
    z_over_depth : float or ndarray, shape (...)
        Height above the bed over the depth.
    """
    hinge = _checked(hinge)
    k = np.concatenate([[1j * kd], evanescent_wavenumbers(kd, modes)])
    return (_velocities(k, hinge) * np.cos(k * np.asarray(z_over_depth, float)[..., None])).sum(-1).real


def second_order(height, kd, depth, hinge=None):
    """Return the amplitude e2 [m] of the second harmonic that a paddle needs so as not to send out a free one.

    ``xi = (S/2) sin wt + e2 sin 2wt``, ``e2 = H^2/(32 d) (3 cosh kd / sinh^3 kd - 2/m1)``, m1 = H/S of the paddle in use:
    Madsen (1971) for a piston and long waves, see `madsen_limit`; `second_order_full` has neither limit. With a flap's m1, as
    it is often used, the formula gives about half of what a flap hinged at the bed needs in long waves: it moves half of the
    water that a piston of the same stroke moves.

    Parameters
    ----------
    height : float
        H of the wave [m].
    kd : float
        Wavenumber times depth.
    depth : float
        d [m]
    hinge : float, optional
        As in `transfer`.
    """
    fall = -math.expm1(-2 * kd)
    bound = 4 * math.exp(-2 * kd) * (1 + math.exp(-2 * kd)) / fall**3  # cosh kd / sinh^3 kd
    return height**2 / (32 * depth) * (3 * bound - 2 / transfer(kd, hinge))


def madsen_limit(height, wavelength, depth):
    """Return whether Madsen's second harmonic applies, ``H L^2/d^3 < 8 pi^2/3``: Madsen (1971). All in [m]."""
    return height * wavelength**2 / depth**3 < MADSEN


def second_order_full(height, kd, depth, hinge=None, modes=100):
    """Return the complex amplitude of the second harmonic with which a paddle sends out no free one, on any depth.

    ``xi = (S/2) sin wt + Im[E2 exp(2iwt)]``, so that a real E2 is Madsen's e2. As in Schaeffer (1996) for one frequency, here
    by Green's identity with the free mode. With ``phi = Re sum_n b_n cos(k_n z)/cos(k_n d) exp(-k_n x + iwt)`` to first order,
    ``k_0 = ik``, the potential of second order has at the surface the forcing

    ``Q = -iw sum_nm b_n b_m (k_n k_m + (k_n^2 + k_m^2)/4 + 3/2 (w^2/g)^2) exp(-(k_n + k_m) x)``

    and at the paddle ``phi_x = dX2/dt + d/dz (X1 dphi1/dz)``. The free wave, ``4 w^2 = g K tanh Kd``, is absent when

    ``2iw X2 int f cosh(Kz)/cosh(Kd) dz + P = (1/g) sum_nm Q_nm s/(s^2 + K^2)``,  ``s = k_n + k_m``,

    P the paddle's term in the same projection. Valid where the first order is: far from breaking.

    Parameters
    ----------
    height, kd, depth, hinge
        As in `second_order`.
    modes : int
        Evanescent modes of the first order. The sums' error falls as 1/modes, because the water's acceleration is singular
        where paddle and surface meet; they are extrapolated from `modes` and twice as many.

    Returns
    -------
    complex
        E2 [m]
    """
    hinge = _checked(hinge)
    few, many = (_cancelling(kd, hinge, number) for number in (modes, 2 * modes))
    return (2 * many - few) * height**2 / depth


def _cancelling(kd, hinge, modes):
    """Return E2 of `second_order_full` for d = H = 1 from a finite number of modes."""
    foot, head = max(hinge, 0.0), kd * math.tanh(kd)  # w^2 d/g, and g = 1 from here on
    w, K = math.sqrt(head), wavenumber(2 * math.sqrt(head), 1.0, 1.0)
    half = 0.5 / transfer(kd, hinge)

    k = np.concatenate([[1j * kd], evanescent_wavenumbers(kd, modes)])
    inside = -w * half * _velocities(k, hinge) / k  # of cos(k_n z)
    b = inside * np.cos(k)

    a, c = k[:, None], k[None, :]
    forcing = -1j * w * b[:, None] * b * (a * c + 0.25 * (a**2 + c**2) + 1.5 * head**2)
    surface = (forcing * (a + c) / ((a + c) ** 2 + K**2)).sum()

    # int f sinh(Kz) sin(k_n z) dz and int f cosh(Kz) dz by parts, over cosh(Kd)
    top, bottom = _parts(K, k, 1.0), _parts(K, k, foot)
    rising, pushed = top[0], math.tanh(K) / K
    if hinge > -math.inf:
        rising = rising - (top[1] - bottom[1]) / (1 - hinge)
        pushed -= (1 - _over_cosh(math.cosh, K, foot)) / (K**2 * (1 - hinge))
    paddle = -0.5j * half * (head * b.sum() + K * (inside * k * rising).sum())
    return complex((surface - paddle) / (2 * w * pushed))


def _over_cosh(function, K, z):
    """Return sinh(Kz) or cosh(Kz) over cosh(K)."""
    return function(K * z) / math.cosh(K)


def _parts(K, k, z):
    """Return the first and second antiderivatives in z of ``sinh(Kz) sin(kz) / cosh(K)``, the first from z = 0."""
    sinh, cosh = _over_cosh(math.sinh, K, z), _over_cosh(math.cosh, K, z)
    sin, cos, square = np.sin(k * z), np.cos(k * z), K**2 + k**2
    first = (K * cosh * sin - k * sinh * cos) / square
    return first, ((K**2 - k**2) * sinh * sin - 2 * K * k * cosh * cos) / square**2


def free_second_harmonic(height, kd, depth, hinge=None):
    """Return the amplitude [m] of the free second harmonic that a paddle sends out which moves with ``(S/2) sin wt`` alone.

    It is what `second_order_full` cancels: ``|E2|`` times H/S at twice the frequency. It runs slower than the wave, so that
    heights vary along the tank with the beat of its wavenumber K and 2k.
    """
    double = wavenumber(2 * math.sqrt(kd * math.tanh(kd)), 1.0, 1.0)
    return abs(second_order_full(height, kd, depth, hinge)) * transfer(double, hinge)


def _checked(hinge):
    if hinge is None:
        return -math.inf
    if not hinge < 1:
        why = "a flap turns about a point below the still-water level"
        raise SceneError(f"is {hinge:g} of the depth above the bed", "hinge", why, "a number below 1, or none for a piston")
    return float(hinge)


def _velocities(k, hinge):
    """Return the share of each mode cos(k z) in f(z), d = 1: ``int f cos(kz) dz / int cos^2(kz) dz``."""
    moment = np.sin(k) / k
    if hinge > -math.inf:
        moment = moment + (np.cos(k) - np.cos(k * max(hinge, 0.0))) / (k**2 * (1 - hinge))
    return moment * 4 * k / (2 * k + np.sin(2 * k))
