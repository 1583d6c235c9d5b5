"""Waves that are made as they were asked for, a solitary wave on a wall that stands and on one that moves."""

import math

import numpy as np

from ..analysis import Spectrum, decay_along, harmonics_along, mean_height, second_harmonic
from ..waves import Solitary, dispersion, solitary_on_wall
from .registry import case
from .runs import levels_of, run_scene

DEPTH = 0.5  # m, of the scene regular-waves
FAR = 3.0  # depths from the paddle, where its near field has died away
PERIODS = 4  # at the end of a run that count


def tank(kd, span, per_depth, periods, **settings):
    """Return overrides that make a tank of regular-waves for kd: `span` [m] behind `FAR` depths, then a layer of a wavelength.

    Parameters
    ----------
    kd, span : float
        Wavenumber times depth; length [m] in which waves are looked at.
    per_depth : int
        Particles per depth.
    periods : float
        Length of the run.
    settings
        Of the wavemaker's wave, as ``order=1``.
    """
    wave = dispersion(DEPTH, 9.81, wavelength=2 * math.pi * DEPTH / kd)
    layer = max(wave.wavelength, 2 * DEPTH)
    length = FAR * DEPTH + span + layer
    damping = {"side": "right", "length": layer, "v_ref": 1.5 * wave.phase_speed, "density": "matched"}
    return wave, {
        "domain.size": [length, 1.6 * DEPTH],
        "fluid.blocks": [{"low": [0.0, 0.0], "high": [length, DEPTH]}],
        "wavemaker.wave.wavelength": wave.wavelength,
        **{f"wavemaker.wave.{key}": value for key, value in settings.items()},
        "damping": [damping],
        "numerics.dx": DEPTH / per_depth,
        "time.end": periods * wave.period,
    }


def _gauges(places):
    return [{"kind": "level", "x": float(x), "every": 0.02} for x in places]


@case
def wavemaker(quick):
    """Regular waves, H/d = 0.1, of piston and flap (hinged at the bed, and at 0.4 d) 3 depths from the paddle, kd = 0.5, 1, 3
    (quick: 1); decay along 5 wavelengths at kd = 1 beyond the expected; the free second harmonic of paddles of first and second
    order at kd = 0.7; irregular waves (JONSWAP): Hs and Tp at gauges over one repeat time.

    20 particles per depth, h/dx = 2.5, no viscosity: then the expected decay is 0.
    """
    per_depth = 20
    for kd in (1.0,) if quick else (0.5, 1.0, 3.0):
        for kind, hinge in (("piston", None), ("flap", None), ("flap", 0.4 * DEPTH)):
            wave, keys = tank(kd, math.pi * DEPTH / kd, per_depth, 8 if kd < 1 else 12, height=0.1 * DEPTH)
            keys |= {"wavemaker.kind": kind, "gauges": _gauges([FAR * DEPTH])}
            keys |= {} if hinge is None else {"wavemaker.hinge": hinge}
            _, simulation = run_scene("regular-waves", keys)
            t, levels, _ = levels_of(simulation)
            height = mean_height(t, levels[0], wave.period, PERIODS)
            name = kind + (f" hinged at {hinge / DEPTH:g} d" if hinge else "")
            yield f"height off the request at 3 d, {name}, kd = {kd:g}", 100 * (height / (0.1 * DEPTH) - 1), "%", 3.0
    if quick:
        return
    yield from _decay(per_depth)
    yield from _second_harmonic(per_depth)
    yield from _irregular(per_depth)


def _decay(per_depth):
    """Decay of the first harmonic along 5 wavelengths."""
    wave, keys = tank(1.0, 5 * 2 * math.pi * DEPTH, per_depth, 15, height=0.1 * DEPTH)
    places = FAR * DEPTH + np.linspace(0.0, 5 * wave.wavelength, 26)
    _, simulation = run_scene("regular-waves", keys | {"gauges": _gauges(places)})
    t, levels, x = levels_of(simulation)
    amplitudes = np.abs(harmonics_along(t, levels, x, wave.period, 3, PERIODS)[:, 0])
    found = decay_along(x, amplitudes)
    lost = 1 - math.exp(-5 * wave.wavelength * found.rate)
    yield "decay along 5 wavelengths beyond the expected, kd = 1", 100 * lost, "%", 3.0
    yield "its standard error", 100 * 5 * wave.wavelength * found.error, "%", None


def _second_harmonic(per_depth, kd=0.7):
    """The free second harmonic of paddles of first and second order."""
    free = {}
    for order in (1, 2):
        wave, keys = tank(kd, 2.0 * math.pi * DEPTH / kd, per_depth, 10, height=0.1 * DEPTH, order=order)
        places = FAR * DEPTH + np.linspace(0.0, 2.0 * math.pi * DEPTH / kd, 25)
        _, simulation = run_scene("regular-waves", keys | {"gauges": _gauges(places)})
        t, levels, x = levels_of(simulation)
        amplitudes = harmonics_along(t, levels, x, wave.period, 3, PERIODS)[:, 1]
        half = dispersion(DEPTH, 9.81, period=0.5 * wave.period).wavenumber
        found = second_harmonic(x, amplitudes, 2 * wave.wavenumber, half, reflected=True)
        free[order] = abs(found.free)
        yield (
            f"free second harmonic over the wave's amplitude, order {order}",
            100 * abs(found.free) / (0.05 * DEPTH),
            "%",
            None,
        )
    yield "free second harmonic, second over first order", free[2] / free[1], "", 0.2


def _irregular(per_depth):
    """Irregular waves at gauges, over one repeat time of 20 peak periods, whose components are lines of the spectrum."""
    repeat = 32.0
    keys = {"wavemaker.wave.duration": repeat, "time.end": repeat + 9.0, "numerics.dx": DEPTH / per_depth}
    scene, simulation = run_scene("irregular-waves", keys | {"gauges": _gauges([1.5, 3.1])})
    t, levels, places = levels_of(simulation)
    late = t > t[-1] - repeat + 0.01
    wave = scene.wavemaker.wave
    for x, level in zip(places, levels[:, late], strict=True):
        frequency = np.fft.rfftfreq(level.size, repeat / level.size)
        band = (frequency > 0.3 / wave.period) & (frequency < 3.5 / wave.period)
        density = 2 * repeat * np.abs(np.fft.rfft(level) / level.size) ** 2
        found = Spectrum(frequency[band], density[band])
        yield f"irregular: Hs off the request, x = {x / DEPTH:g} d", 100 * (found.height / wave.height - 1), "%", 5.0
        yield f"irregular: Tp off the request, x = {x / DEPTH:g} d", 100 * (found.peak_period / wave.period - 1), "%", 5.0


@case
def solitary_wall(quick):
    """Solitary waves on a vertical wall, a/d = 0.1, 0.2, 0.3 (quick: 0.2, half the resolution), 40 particles per depth.

    Against numerically exact potential flow (`parsph.waves`): celerity between 5 and 10 depths from the plate's place at rest,
    height after 10, then what the wave does at the wall 22 depths from there.
    """
    scenes = {0.1: "solitary-wall-low", 0.2: "solitary-wall", 0.3: "solitary-wall-high"}
    for ratio in (0.2,) if quick else scenes:
        scene, simulation = run_scene(scenes[ratio], {"numerics.dx": 0.0125} if quick else {})
        depth, gravity = scene.depth, scene.domain.gravity
        records = {gauge.name: gauge.record() for gauge in simulation.observers}
        (early, _), (late, height) = (_crest(records[name], depth) for name in ("5d", "10d"))
        wave, wall = Solitary(ratio * depth, depth, gravity), solitary_on_wall(ratio)
        weight = scene.fluid.rho0 * gravity
        speed = 5 * depth / (late - early)
        runup = records["run-up"][:, 1].max() / depth - 1
        force = next(gauge for gauge in simulation.observers if "moment [N]" in gauge.columns).record()[:, 1].max()
        pressure = records["P0"][:, 1].max()
        name = f"a/d = {ratio:g}"
        yield f"celerity, {name}", 100 * (speed / wave.celerity - 1), "%", 1.0
        yield f"height after 10 depths, {name}", 100 * (height / wave.height - 1), "%", 3.0
        yield f"run-up, {name}", 100 * (runup / wall.runup - 1), "%", 2.0
        yield f"largest force, {name}", 100 * (force / (weight * depth**2) / wall.force - 1), "%", 3.0
        yield f"bed pressure at the wall, {name}", 100 * (pressure / (weight * depth) / wall.pressure - 1), "%", 3.0


def _crest(record, depth):
    """Return when the first crest passes a gauge [s] and how high it is [m], by a parabola through its upper tenth."""
    t, height = record[:, 0], record[:, 1] - depth
    begin = np.argmax(height > 0.9 * height.max())
    near = slice(begin, begin + np.argmax(height[begin:] < 0.9 * height.max()))
    curve = np.polynomial.Polynomial.fit(t[near], height[near], 2)
    when = float(curve.deriv().roots()[0])
    return when, float(curve(when))


@case
def movable_seawall(quick):
    """A seawall that stands until the force exceeds 1.1 times that of still water, Huang et al. section 4.4.

    Still water for 10 s (quick: 2 s): it may not move at all. Solitary wave: from the sample at which the force is above the
    threshold to the first one at which the wall has moved; work of the force in excess of the support's against the energy of
    wall and spring, largest difference over the largest energy.
    """
    still = {"wavemaker": None, "time.end": 2.0 if quick else 10.0}
    _, simulation = run_scene("movable-seawall", still)
    record = simulation.observers[0].record()
    yield "still water: largest displacement", np.abs(record[:, 2]).max(), "m", 0.0
    force = record[1:, 1]
    scene, simulation = run_scene("movable-seawall", {"time.end": 4.0} if quick else {})
    body, keys = simulation.movers[0], scene.bodies[0]
    yield "still water: force off that of theory, largest", 100 * np.abs(force / body.preload - 1).max(), "%", None
    t, push, way, speed, _, work = simulation.observers[0].record().T
    onset, crossing = t[np.argmax(way != 0)], t[np.argmax(push > keys.threshold * body.preload)]
    yield "onset after the threshold", (onset - crossing) / scene.gauges[0].every, "samples", 1.0
    energy = 0.5 * keys.mass * speed**2 + 0.5 * keys.stiffness * way**2
    off = np.abs(work - body.preload * way - energy).max() / energy.max()
    yield "energy of the wall off the work of the force", 100 * off, "%", 1.0
    yield "largest force over that of still water", push.max() / body.preload, "", None
    yield "largest displacement", way.max() / scene.depth, "d", None
