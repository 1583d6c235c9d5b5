"""How high waves can be, and which theory describes them.

Sources: Miche (1944), Mouvements ondulatoires de la mer en profondeur constante ou decroissante, Ann. Ponts Chaussees 114;
McCowan (1894), On the highest wave of permanent type, Phil. Mag. 5(38), 351-358; Williams (1981), Limiting gravity waves in
water of finite depth, Phil. Trans. R. Soc. A 302, 139-188, as fitted by Fenton (1990), Nonlinear wave theories, The Sea 9;
Le Mehaute (1976), An introduction to hydrodynamics and water waves, Springer; Ursell (1953), The long-wave paradox in the
theory of gravity waves, Proc. Camb. Phil. Soc. 49, 685-694.
"""

import math

HIGHEST_SOLITARY = 0.8332  # of the depth: Williams (1981)
MCCOWAN = 0.78  # of the depth
LINEAR = 0.01  # second harmonic over the first: Le Mehaute's line between linear and second-order waves in deep water
CNOIDAL = 26.0  # Ursell number: 8 pi^2/3, from which on second-order Stokes waves have a second crest


def miche(wavelength, depth):
    """Return the height [m] at which regular waves break, ``0.142 L tanh kd``: Miche (1944). L, d [m]."""
    return 0.142 * wavelength * math.tanh(2 * math.pi * depth / wavelength)


def mccowan(depth):
    """Return the height [m] at which long waves break on a gently sloping bed, ``0.78 d``: McCowan (1894)."""
    return MCCOWAN * depth


def highest_wave(wavelength, depth):
    """Return the height [m] of the highest steady wave on a flat bed: Williams (1981) as fitted by Fenton (1990).

    ``H/d = (0.141063 r + 0.0095721 r^2 + 0.0077829 r^3) / (1 + 0.0788340 r + 0.0317567 r^2 + 0.0093407 r^3)``, r = L/d.

    Parameters
    ----------
    wavelength, depth : float
        [m]
    """
    r = wavelength / depth
    above = 0.141063 * r + 0.0095721 * r**2 + 0.0077829 * r**3
    return depth * above / (1 + 0.0788340 * r + 0.0317567 * r**2 + 0.0093407 * r**3)


def breaking_height(depth, wavelength=None):
    """Return the height [m] at which waves break on a flat bed: Miche's, and no more than the highest solitary wave's.

    Parameters
    ----------
    depth : float
        [m]
    wavelength : float, optional
        [m]; None: a solitary wave.
    """
    highest = HIGHEST_SOLITARY * depth
    return highest if wavelength is None else min(miche(wavelength, depth), highest)


def ursell(height, wavelength, depth):
    """Return ``H L^2 / d^3``: Ursell (1953). All in [m]."""
    return height * wavelength**2 / depth**3


def second_harmonic(height, wavelength, depth):
    """Return the amplitude of the second-order Stokes wave's second harmonic over that of its first.

    ``(kH/8) (3 coth^3 kd - coth kd)``: Stokes (1847), see Dean & Dalrymple (1991),
    Water wave mechanics for engineers and scientists, chapter 11.
    """
    k = 2 * math.pi / wavelength
    coth = 1 / math.tanh(k * depth)
    return k * height / 8 * (3 * coth**3 - coth)


def regime(height, wavelength, depth):
    """Return the theory that a regular wave asks for: "linear", "stokes", "cnoidal or stream function" or "breaking".

    Simple limits after Le Mehaute (1976): linear while the second harmonic has less than 1 % of the first, which in deep water
    is his ``H/(g T^2) = 0.001``; Stokes waves while ``H L^2/d^3 < 26``; beyond `breaking_height` the wave breaks.

    Parameters
    ----------
    height, wavelength, depth : float
        [m]
    """
    if height > breaking_height(depth, wavelength):
        return "breaking"
    if second_harmonic(height, wavelength, depth) < LINEAR:
        return "linear"
    return "stokes" if ursell(height, wavelength, depth) < CNOIDAL else "cnoidal or stream function"
