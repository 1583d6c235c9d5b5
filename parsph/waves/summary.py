"""What theory says of one wave, as rows of a table."""

import math

from ..errors import SceneError
from .limits import breaking_height, regime, second_harmonic, ursell
from .linear import _positive, dispersion
from .paddles import MADSEN, free_second_harmonic, madsen_limit, second_order, second_order_full, transfer
from .solitary import SOLITARY_THEORIES, Solitary, solitary_on_wall

FREE = 0.05  # of the wave's amplitude: a free second harmonic that shows as a change of the height along the tank


def describe(depth, gravity, height=None, period=None, frequency=None, wavelength=None):
    """Return what theory says of a regular wave.

    Lengths, speeds and paddles after linear theory; the second harmonics after `second_order_full` and, for a piston, Madsen
    (1971).

    Parameters
    ----------
    depth, gravity : float
        [m], [m/s^2]
    height : float, optional
        [m]; without one nothing that depends on it.
    period, frequency, wavelength : float
        Exactly one of T [s], 1/T [Hz], L [m].

    Returns
    -------
    list of tuple
        (quantity, value, unit): str, float or str, str. Rows named "note" say which limits the wave is beyond.

    Raises
    ------
    SceneError
        For bad input.
    """
    wave = dispersion(depth, gravity, period, frequency, wavelength)
    piston, flap = transfer(wave.kd), transfer(wave.kd, 0.0)
    highest = breaking_height(depth, wave.wavelength)
    rows = [
        ("period", wave.period, "s"),
        ("frequency", 1 / wave.period, "Hz"),
        ("wavelength", wave.wavelength, "m"),
        ("kd", wave.kd, "-"),
        ("phase speed", wave.phase_speed, "m/s"),
        ("group speed", wave.group_speed, "m/s"),
        ("breaking height", highest, "m"),
        ("height over stroke, piston", piston, "-"),
        ("height over stroke, flap hinged at the bed", flap, "-"),
    ]
    if height is None:
        return rows
    _positive(height=height)
    rows += [
        ("wave height", height, "m"),
        ("Ursell number", ursell(height, wave.wavelength, depth), "-"),
        ("regime", regime(height, wave.wavelength, depth), ""),
        ("bound second harmonic over the first", second_harmonic(height, wave.wavelength, depth), "-"),
        ("stroke, piston", height / piston, "m"),
        ("stroke, flap hinged at the bed", height / flap, "m"),
        ("second harmonic of a piston, Madsen", second_order(height, wave.kd, depth), "m"),
    ]
    for name, hinge in (("piston", None), ("flap hinged at the bed", 0.0)):
        needed = second_order_full(height, wave.kd, depth, hinge)
        rows += [
            (f"second harmonic of a {name}", abs(needed), "m"),
            (f"its phase, {name}", math.degrees(math.atan2(needed.imag, needed.real)), "deg"),
            (f"free second harmonic without it, {name}", free_second_harmonic(height, wave.kd, depth, hinge), "m"),
        ]
    return rows + [("note", text, "") for text in _beyond(height, depth, wave, highest, rows)]


def _beyond(height, depth, wave, highest, rows):
    """Return the limits that a wave is beyond, as texts."""
    texts = []
    if height > highest:
        texts.append(f"it breaks: {height:.4g} m is more than {highest:.4g} m")
    if not madsen_limit(height, wave.wavelength, depth):
        number = ursell(height, wave.wavelength, depth)
        texts.append(
            f"H L^2/d^3 = {number:.3g} is not below {MADSEN:.3g}: too long for second-order paddles, use cnoidal waves"
        )
    free = {name: value for name, value, _ in rows}["free second harmonic without it, piston"] / (0.5 * height)
    if free > FREE:
        texts.append(f"a piston with a sine alone sends out a free second harmonic of {100 * free:.2g} % of the amplitude")
    return texts


def describe_solitary(depth, gravity, height):
    """Return what theory says of a solitary wave, as `describe`.

    For each theory that has the wave: speed, width where it has 5 % of its height, stroke and duration of Goring's piston. Then
    run-up, largest force and pressure on a vertical wall, where they are tabulated.

    Parameters
    ----------
    depth, gravity, height : float
        [m], [m/s^2], [m]

    Returns
    -------
    list of tuple
        (quantity, value, unit)

    Raises
    ------
    SceneError
        For bad input, and waves higher than the highest.
    """
    _positive(depth=depth, gravity=gravity, height=height)
    rows = [("wave height over depth", height / depth, "-"), ("breaking height", breaking_height(depth), "m")]
    simple = Solitary(height, depth, gravity, "boussinesq")  # its errors are those of all theories
    texts = []
    for theory in SOLITARY_THEORIES:
        try:
            wave = simple if theory == simple.theory else Solitary(height, depth, gravity, theory)
        except SceneError as error:
            texts.append(f"theory {theory}: {error.why}")
            continue
        rows += [
            (f"celerity, {theory}", wave.celerity, "m/s"),
            (f"effective length, {theory}", wave.length, "m"),
            (f"stroke of a piston, {theory}", wave.stroke, "m"),
            (f"duration of the stroke, {theory}", wave.duration, "s"),
        ]
    try:
        wall = solitary_on_wall(height / depth)
    except SceneError as error:
        texts.append(f"vertical wall: {error.why}")
    else:
        rows += [
            ("run-up on a vertical wall", wall.runup * depth, "m"),
            ("largest force on the wall over rho g d^2", wall.force, "-"),
            ("largest pressure at its foot over rho g d", wall.pressure, "-"),
        ]
    return rows + [("note", text, "") for text in texts]
