"""Waves and still water between mirror walls, and the wave pool."""

import math

import numpy as np

from ..analysis import mean_height, oscillation, reflection
from ..parallel import Communicator
from ..scene.build import build
from ..scene.load import load_scene
from ..study.metrics import rms
from ..waves import Seiche, flap_height
from .registry import case
from .runs import run_scene


@case
def seiche(quick):
    """Standing wave of 0.2 m x 0.2 m, A = 5 mm, 5 periods (quick: 20 per depth alone), against linear theory, Szmidt eq. (41).

    The amplitude is the projection of the particles' velocities on the mode of eq. (43), fitted by A exp(-b t) cos(w t + p).
    """
    for per_depth, frequency_bar, loss_bar in ((20, 0.6, 1.5), (40, 0.2, 1.0)):
        scene = load_scene("seiche", {"numerics.dx": 0.2 / per_depth, "gauges": []})
        theory = Seiche(0.2, 0.2, scene.fluid.blocks[0].amplitude, scene.domain.gravity)
        period = 2 * math.pi / theory.frequency
        times, shares, outside = _shares(scene, theory, 5 * period)
        found = oscillation(times, shares, theory.frequency)
        size = f"{per_depth} per depth"
        yield f"frequency error, {size}", 100 * (found.frequency / theory.frequency - 1), "%", frequency_bar
        yield f"amplitude loss per period, {size}", 100 * found.loss, "%", loss_bar
        yield f"particles behind a wall, {size}", outside, "", 0.0
        if quick:
            return


def _shares(scene, theory, end):
    """Run a seiche up to `end` [s].

    Returns
    -------
    tuple of (ndarray, ndarray, int)
        Times [s], shares of the mode that is there at the beginning, largest number of particles seen behind a wall.
    """
    simulation = build(scene, Communicator())
    simulation.end = end
    simulation.prepare()
    times, shares, outside = [], [], 0
    while simulation.time < end:
        simulation.advance()
        if simulation.steps % 10 == 0:
            position = simulation.field("position")
            outside = max(outside, int(((position < 0) | (position > [theory.length, np.inf])).any(axis=1).sum()))
            times.append(simulation.time)
            shares.append(theory.share(position, simulation.field("velocity")))
    return np.array(times), np.array(shares), outside


@case
def still(quick):
    """Still water, 0.6 m x 0.3 m, 10 s (quick: 3 s): nothing may move, the bed must feel rho g H."""
    scene, simulation = run_scene("still", {"time.end": 3.0 if quick else 10.0})
    bed, energy = (gauge.record() for gauge in simulation.observers)
    weight = scene.fluid.rho0 * scene.domain.gravity * scene.depth
    late = bed[:, 0] > 2.0
    yield "bed pressure, RMS error after 2 s", 100 * rms(bed[late, 1] / weight - 1), "% of rho g H", 0.5
    lowest = simulation.field("position")[:, 1].min() / scene.numerics.dx
    yield "lowest row off dx/2", lowest - 0.5, "dx", 0.05
    yield "kinetic over potential energy at the end", energy[-1, 2] / energy[-1, 3], "", 1e-6


@case
def pool_height(quick):
    """The pool with its layer, 25 s (quick: 12 s): heights at x = 2 ... 4 m against Biesel's flap, 0.0956 m.

    Growth: the mean height of the last two periods over that of the first two after start-up, minus 1.
    """
    scene, simulation = run_scene("pool", {"time.end": 12.0 if quick else 25.0})
    period = scene.wave_period
    theory = flap_height(math.radians(scene.wavemaker.wave.angle), period, scene.depth, scene.domain.gravity)
    for gauge in simulation.observers:
        if gauge.columns == ("level [m]",) and 2 <= gauge.place[0] <= 4:
            t, level = gauge.record().T
            height = mean_height(t[t > 6.0], level[t > 6.0], period)
            x = f"x = {gauge.place[0]:g} m"
            yield f"wave height error, {x}", 100 * (height / theory - 1), "%", 5.0
            if not quick:
                early = (t > 6.0) & (t < 6.0 + 2.05 * period)  # two whole periods, samples to spare
                growth = mean_height(t, level, period, 2) / mean_height(t[early], level[early], period)
                yield f"growth of height, {x}", 100 * (growth - 1), "%", 5.0


@case
def pool_absorption(quick):
    """The pool with layers of half and of one wavelength (quick: 14 s, twice the spacing): what comes back, Mansard & Funke.

    Kinetic energy of the pool against the infinite one after start-up (4 periods), and its growth in the reflecting one.
    """
    places = (2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0)
    gauges = [{"kind": "level", "x": x} for x in places]
    gauges.append({"kind": "energy", "low": [-1.0, -1.0], "high": [6.061, 10.0], "every": 0.02})
    common = {"gauges": gauges, **({"numerics.dx": 0.1, "time.end": 14.0} if quick else {})}
    half = 6.061 + 3.0305
    shorter = {
        "domain.size": [half, 1.5],
        "fluid.blocks": [{"low": [0.0, 0.0], "high": [half, 1.0]}],
        "damping.0.length": 3.0305,
    }
    energies = {}
    for name, source, overrides, bar in (
        ("half a wavelength", "pool", shorter, 5.0),
        ("one wavelength", "pool", {}, 2.0),
        ("infinite", "pool-infinite", {}, None),
        ("reflecting", "pool-reflecting", {}, None),
    ):
        scene, simulation = run_scene(source, {**common, **overrides})
        *levels, energy = (gauge.record() for gauge in simulation.observers)
        period, t = scene.wave_period, levels[0][:, 0]
        energies[name] = energy[energy[:, 0] > 4 * period]
        records = np.array([level[:, 1] for level in levels])
        found = reflection(t, records, places, period, scene.depth, scene.domain.gravity, periods=4)
        yield f"reflection coefficient, {name}", 100 * found.coefficient, "%", bar
    far = energies["infinite"][:, 2]
    for name in ("half a wavelength", "one wavelength"):
        off = np.abs(energies[name][:, 2] - far).max() / far.mean()
        yield f"kinetic energy off the infinite pool, largest, {name}", 100 * off, "%", 3.0 if name.startswith("one") else None
    resonant, count = energies["reflecting"][:, 2], round(period / 0.02)
    yield "resonance: kinetic energy, first over last period", resonant[:count].mean() / resonant[-count:].mean(), "", 0.8
