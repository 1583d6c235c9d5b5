"""How well what makes waves takes up those that come back to it."""

import numpy as np

from ..analysis import harmonics_along, mean_height, separate
from ..parallel import Communicator
from ..scene.build import build
from ..scene.load import load_scene
from ..waves import dispersion

DEPTH, GRAVITY, HEIGHT = 1.0, 9.81, 0.1
PERIODS = 4  # at the end of a run over which waves are looked at
PLACES = (0.05, 0.15, 0.3, 0.45, 0.6)  # of the gauges off the absorber, over the wavelength


def re_reflection(quiet, reflecting, places, period, depth, gravity, periods=PERIODS):
    """Return the share of what comes to an absorber that goes out from it again, ``rho = (a_i - a_i0) / a_r``.

    In a tank that takes up all at its far end (quiet) the absorber sends out a_i0, which is what it makes. In a tank with a
    wall there a_r comes back, and it sends out ``a_i = a_i0 + rho a_r``, when both are steady. First harmonics at the place of
    the absorber, from several gauges by `parsph.analysis.separate`.

    Parameters
    ----------
    quiet, reflecting : tuple of (ndarray, ndarray)
        Times [s], shape (samples,), and levels [m], shape (gauges, samples), of the two runs. Both begin at the same phase of
        what is made, and may have different lengths.
    places : array_like, shape (gauges,)
        Distances of the gauges from the absorber [m].
    period, depth, gravity : float
        [s], [m], [m/s^2]
    periods : int
        So many at the end of each record count.

    Returns
    -------
    complex

    Raises
    ------
    SceneError
        When the records are too short, or the gauges do not tell the waves apart.
    """
    wavenumber = dispersion(depth, gravity, period).wavenumber
    (made, _), (sent, came) = (
        separate(places, harmonics_along(t, levels, places, period, periods=periods)[:, 0], wavenumber)
        for t, levels in (quiet, reflecting)
    )
    return (sent - made) / came


def _tank(dx, zone, free, layer, end):
    """Return the keys of a tank with a relaxation zone at the left, lengths in wavelengths, the end in periods."""
    wave = dispersion(DEPTH, GRAVITY, wavelength=2 * np.pi * DEPTH)
    zone, free, layer = (dx * round(length * wave.wavelength / dx) for length in (zone, free, layer))
    length = round(zone + free + layer, 6)
    places = np.array(PLACES) * wave.wavelength
    speed = 1.5 * wave.phase_speed
    keys = {
        "domain": {"size": [length, 1.5 * DEPTH], "gravity": GRAVITY},
        "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [length, DEPTH]}]},
        "walls": {"left": {}, "right": {}, "bottom": {}, "exchange": True},
        "relaxation": [{"length": zone, "height": HEIGHT, "period": wave.period}],
        "damping": [{"side": "right", "length": layer, "v_ref": speed, "density": "matched"}] if layer else [],
        "gauges": [{"kind": "level", "x": zone + place} for place in places],
        "numerics": {"dx": dx, "h_over_dx": 2.0, "c0_factor": 12.0, "diffusion": "fourtakas", "precision": "float32"},
        "time": {"end": end * wave.period},
    }
    return keys, places, wave


def _relaxation(quick):
    """A relaxation zone of half a wavelength, kd = 1, H/d = 0.1: the waves it makes, and what it sends back.

    Heights before a matched layer; re-reflection with a wall two wavelengths off; in both how far the mean level is off still
    water after some ten periods. Still water without zones has a share in that, as particles leave their lattice.
    """
    dx, end = (0.1, 11) if quick else (0.05, 13)
    records = []
    for layer in (1.0, 0.0):
        keys, places, wave = _tank(dx, 0.5, 1.0 if layer else 2.0, layer, end)
        simulation = build(load_scene(keys), Communicator())
        simulation.run()
        tables = [gauge.record() for gauge in simulation.observers]
        records.append((tables[0][:, 0], np.array([table[:, 1] for table in tables])))
    t, levels = records[0]
    for number in (0, 2, 4):
        height = mean_height(t, levels[number], wave.period, PERIODS)
        where = f"{PLACES[number]:g} wavelengths off"
        yield f"relaxation zone: wave height error, {where}", 100 * (height / HEIGHT - 1), "%", 10.0 if quick else 5.0
    rho = re_reflection(*records, places, wave.period, DEPTH, GRAVITY)
    yield "relaxation zone: re-reflection", 100 * abs(rho), "%", 10.0
    for name, (t, levels) in zip(("layer", "wall"), records, strict=True):
        mean = levels[:, t > t[-1] - PERIODS * wave.period].mean()
        yield f"relaxation zone: mean level off still water, before a {name}", 100 * (mean - DEPTH) / HEIGHT, "% of H", None
