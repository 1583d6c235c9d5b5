"""How well what makes waves takes up those that come back to it."""

import numpy as np

from ..analysis import harmonics_along, mean_height, separate
from ..parallel import Communicator
from ..scene.build import build
from ..scene.load import load_scene
from ..waves import dispersion, sent_back
from .registry import case
from .runs import levels_of, run_scene

DEPTH, GRAVITY, HEIGHT = 1.0, 9.81, 0.1
PERIODS = 4  # at the end of a run over which waves are looked at
PLACES = (0.05, 0.15, 0.3, 0.45, 0.6)  # of the gauges off the absorber, over the wavelength


def re_reflection(quiet, reflecting, places, period, depth, gravity, periods=PERIODS, shift=0.0):
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
    shift : float
        How much nearer to the gauges the absorber stood on average in the second run [m]: a plate may drift, and what it makes
        comes from where it is.

    Returns
    -------
    complex

    Raises
    ------
    SceneError
        When the records are too short, or the gauges do not tell the waves apart.
    """
    wavenumber = dispersion(depth, gravity, period).wavenumber
    (made, _), (sent, came) = (_separated(*records, places, period, wavenumber, periods) for records in (quiet, reflecting))
    return (sent - made * np.exp(1j * wavenumber * shift)) / came


def _separated(t, levels, places, period, wavenumber, periods=PERIODS):
    """Return incident and reflected amplitude [m], complex, of the first harmonic over the last periods."""
    return separate(places, harmonics_along(t, levels, places, period, periods=periods)[:, 0], wavenumber)


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
        _, simulation = run_scene(keys)
        records.append(levels_of(simulation)[:2])
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


def _paddle(quick):
    """A piston and a flap with active absorption, kd = 1, and a piston at kd = 0.5 (quick: the first alone), H/d = 0.1.

    Re-reflection with a wall two wavelengths off, and what linear theory says of the same gain and lag. Without absorption all
    comes back again: there the height of the waves that run to the wall, over the request, in the last four periods.
    """
    dx, end = (0.1, 12) if quick else (0.05, 14)
    for kind, kd in (("piston", 1.0),) if quick else (("piston", 1.0), ("flap", 1.0), ("piston", 0.5)):
        wave = dispersion(DEPTH, GRAVITY, wavelength=2 * np.pi * DEPTH / kd)
        places = (np.array(PLACES) * 0.6 + 0.35) * wave.wavelength  # three depths and more from the plate at kd <= 1
        runs, ways = [], []
        for layer in (True, False):
            simulation = _with_paddle(kind, wave, places, dx, end, layer, {})
            ways.append(_mean_way(simulation, end * wave.period, wave.period))
            runs.append(levels_of(simulation)[:2])
        rho = re_reflection(*runs, places, wave.period, DEPTH, GRAVITY, shift=ways[1] - ways[0])
        absorber, name = simulation.movers[0], f"{kind}, kd = {kd:g}"
        hinge = None if kind == "piston" else 0.0
        theory = sent_back(wave.period, DEPTH, GRAVITY, absorber.gain, absorber.lag, hinge, absorber.distance)
        yield f"{name}: re-reflection", 100 * abs(rho), "%", 10.0
        yield f"{name}: re-reflection by linear theory", 100 * abs(theory), "%", None
        yield f"{name}: mean way of the plate, reflecting tank", 100 * ways[1] / DEPTH, "% of d", None
        if kd == 1.0 and kind == "piston":
            with_it, _ = _separated(*runs[1], places, wave.period, wave.wavenumber)
            simulation = _with_paddle(kind, wave, places, dx, end, False, None)
            simulation.run()
            without, _ = _separated(*levels_of(simulation)[:2], places, wave.period, wave.wavenumber)
            yield f"{name}: incident over the request in the reflecting tank", 2 * abs(with_it) / HEIGHT, "", None
            yield f"{name}: the same without absorption", 2 * abs(without) / HEIGHT, "", None


def _with_paddle(kind, wave, places, dx, end, layer, absorption):
    """Return a simulation of a tank two wavelengths long with a plate, or of 1.2 with a layer of one behind them."""
    length = (2.2 if layer else 2.0) * wave.wavelength
    maker = {"kind": kind, "wave": {"kind": "regular", "height": HEIGHT, "period": wave.period}, "absorption": absorption}
    zone = {"side": "right", "length": wave.wavelength, "v_ref": 1.5 * wave.phase_speed, "density": "matched"}
    keys = {
        "domain": {"size": [length, 1.6 * DEPTH], "gravity": GRAVITY},
        "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [length, DEPTH]}]},
        "walls": {"left": {}, "right": {}, "bottom": {}, "exchange": True},
        "wavemaker": maker,
        "damping": [zone] if layer else [],
        "gauges": [{"kind": "level", "x": x} for x in places],
        "numerics": {"dx": dx, "h_over_dx": 2.0, "c0_factor": 12.0, "diffusion": "fourtakas", "precision": "float32"},
        "time": {"end": end * wave.period},
    }
    return build(load_scene(keys), Communicator())


def _mean_way(simulation, end, period):
    """Run a simulation to its end; return the mean of what absorption adds to the plate's way in the last periods [m]."""
    ways, times = [], []
    simulation.prepare()
    while simulation.time < simulation.end:
        simulation.advance()
        times.append(simulation.time)
        ways.append(simulation.movers[0].signal.way)
    return float(np.array(ways)[np.array(times) > end - PERIODS * period].mean())


@case
def active_absorption(quick):
    """What paddles and relaxation zones send back of the waves that come to them; a bar of 10 % each."""
    yield from _paddle(quick)
    yield from _relaxation(quick)
