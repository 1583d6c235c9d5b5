"""Hard cases by their length: a seiche of a hundred periods, still water for a hundred thousand steps."""

import math

import numpy as np

from ..analysis import oscillation
from ..io.gauges import EnergyGauge, Gauge
from ..scene.load import load_scene
from ..waves import Seiche
from .hard import energy_rows, missing, record_of, survived
from .registry import case


class ShareGauge(Gauge):
    """How much of the mode of `theory`, a `Seiche` whose basin begins at the origin, the particles move with."""

    columns = ("share",)

    def __init__(self, every, theory):
        super().__init__("share", every)
        self.theory = theory

    def measure(self, simulation):
        return [self.theory.share(simulation.field("position"), simulation.field("velocity"))]


@case
def long_seiche(quick):
    """A seiche of a hundred periods, 40 particles per depth (quick: ten periods): frequency, and energy books.

    The amplitude is the projection of the particles' velocities on the mode, as in `seiche`. What particles gain that change
    places with their images is not accounted for.
    """
    scene = load_scene("seiche-long")
    block = scene.fluid.blocks[0]
    theory = Seiche(*block.high, block.amplitude, scene.domain.gravity)
    periods, period = 10 if quick else 100, 2 * math.pi / theory.frequency
    _, simulation = survived("seiche-long", {"time.end": periods * period}, [ShareGauge(0.005, theory)])
    times, shares = record_of(simulation, ShareGauge).T
    parts = {"": (0, periods)}
    parts |= {f", periods {first} to {first + 25}": (first, first + 25) for first in range(0, periods - 24, 25)}
    for name, (first, last) in parts.items():
        part = (times >= first * period) & (times <= last * period)
        found = oscillation(times[part], shares[part], theory.frequency)
        bar = None if name else 0.3
        yield f"frequency error{name}", 100 * (found.frequency / theory.frequency - 1), "%", bar
        yield f"amplitude loss per period{name}", 100 * found.loss, "%", None
    yield from missing(simulation)
    yield "changes of places with images", sum(wall.exchanged for wall in simulation.domain.walls), "", None
    yield from energy_rows(simulation, record_of(simulation, EnergyGauge)[0, 2], 1.0)


@case
def long_still(quick):
    """Still water for 100,000 steps (quick: 10,000): nothing may move, grow or leave."""
    scene, simulation = survived("still-long", {"time.end": 2.33} if quick else {})
    bed, energy = (gauge.record() for gauge in simulation.observers)
    weight = scene.fluid.rho0 * scene.domain.gravity * scene.depth
    late = bed[:, 0] > 0.5 * scene.time.end
    yield "steps", simulation.steps, "", None
    yield from missing(simulation)
    yield "bed pressure, second half, RMS error", 100 * np.sqrt(np.mean((bed[late, 1] / weight - 1) ** 2)), "% of rho g H", 0.5
    late = energy[:, 0] > 0.5 * scene.time.end
    yield "kinetic over potential energy, second half, largest", (energy[late, 2] / energy[late, 3]).max(), "", 1e-8
    yield "potential energy, change", 100 * (energy[-1, 3] / energy[0, 3] - 1), "%", 0.5
