"""Hard cases of water: a tank shaken at its resonance, a breaker that plunges, a drop that falls onto a pool."""

import numpy as np

from ..io.gauges import EnergyGauge, ForceGauge, RunupGauge
from ..scene.load import load_scene
from ..scene.solids import motions_of
from ..waves import Sloshing
from .hard import energy_rows, missing, record_of, survived
from .registry import case


@case
def sloshing(quick):
    """A tank shaken at its first mode for ten periods (quick: two, half the resolution): momentum of the water along the bed
    against linear theory in the first two periods, while waves are low; force on the tank against the change of momentum.
    """
    period = load_scene("sloshing-tank").walls.polygons[0].motion.period
    scene, simulation = survived("sloshing-tank", {"numerics.dx": 0.02, "time.end": 2 * period} if quick else {})
    tank, water = motions_of(scene)["tank"], scene.fluid.blocks[0]

    def motion(time):
        placement = tank.at(time)
        return placement.offset_rate[0], placement.offset_acceleration[0]

    energy, force = record_of(simulation, EnergyGauge), record_of(simulation, ForceGauge)
    t, momentum = energy[:, 0], energy[:, 5] / energy[:, 1]
    theory = Sloshing(water.high[0] - water.low[0], scene.depth, scene.domain.gravity)
    early = t <= 2 * period
    expected = theory.momentum(t[early], motion)
    off = np.sqrt(np.mean((momentum[early] - expected) ** 2)) / np.abs(expected).max()
    yield "momentum, two periods, RMS off linear theory", 100 * off, "% of the largest", 5.0
    change = np.gradient(energy[early, 5], t[early])
    felt = -np.interp(t[early], force[:, 0], force[:, 1])
    off = np.sqrt(np.mean((felt - change) ** 2)) / np.abs(change).max()
    yield "force on the tank, two periods, RMS off the change of momentum", 100 * off, "% of the largest", None
    yield from missing(simulation)
    yield from energy_rows(simulation)


@case
def breaker(quick):
    """A solitary wave of 0.45 d that plunges on a beach of 1:15 (quick: up to 1 s, half the resolution)."""
    scene, simulation = survived("plunging-breaker", {"numerics.dx": 0.02, "time.end": 1.0} if quick else {})
    yield from missing(simulation)
    yield (
        "height of the shoreline over still water, largest",
        np.nanmax(record_of(simulation, RunupGauge)[:, 1]) - scene.level,
        "m",
        None,
    )
    yield from energy_rows(simulation)


@case
def drop_pool(quick):
    """A drop that falls onto a still pool (quick: up to 0.3 s, half the resolution)."""
    _, simulation = survived("drop-on-pool", {"numerics.dx": 0.02, "time.end": 0.3} if quick else {})
    yield from missing(simulation)
    yield from energy_rows(simulation)
