"""Channels, exchange with images and smoothed continuity on slabs: every rank runs the whole alone too, and compares."""

import numpy as np
import pytest
from helpers import tank
from test_slabs import assert_same_run, rebuilt

import parsph.simulation
from parsph.parallel import Communicator
from parsph.particles import identities
from parsph.scene.build import build, grid_of
from parsph.scene.load import load_scene

ENERGY = [{"kind": "energy", "every": 0.01}]
CHANNEL = {
    "domain": {"size": [1.0, 0.5], "gravity": 8.0, "periodic": ["up"]},
    "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [1.0, 0.5], "pressure": 1000.0}]},
    "walls": {"left": {"slip": "no"}, "right": {"slip": "no", "velocity": [0.0, 1.0]}, "exchange": True},
    "numerics": {"dx": 0.05, "c0": 10.0, "viscosity": "newtonian", "nu": 0.05, "density_range": [0.2, 5.0]},
    "time": {"end": 0.1},
    "gauges": ENERGY,
}
BOX = {
    "domain": {"size": [1.0, 0.3], "gravity": 9.81},
    "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [0.5, 0.2]}], "level": 0.2},
    "walls": {"left": {}, "right": {"slip": "no"}, "bottom": {}, "top": {}, "exchange": True},
    "numerics": {"dx": 0.02, "c0": 4.0, "state": "linear", "density_range": [0.01, 100.0]},
    "time": {"end": 0.1, "cfl": 0.3},
    "gauges": ENERGY,
}
POOL = {
    "numerics.dx": 0.1,
    "numerics.density_range": [0.01, 100.0],
    "numerics.state": "linear",
    "walls.exchange": True,
    "wavemaker.wave.ramp": 0.0,
    "time.end": 0.1,
    "gauges": ENERGY,
}


def varied(keys, **numerics):
    """Return `keys` with other numerics."""
    return {**keys, "numerics": {**keys["numerics"], **numerics}}


SMOOTHED = {"xsph": 0.5, "xsph_continuity": True}
SCENES = {
    "newtonian, periodic": (CHANNEL, {}, 3.0),
    "newtonian, periodic, midpoint, float32": (varied(CHANNEL, integrator="midpoint", precision="float32"), {}, 2.0),
    "newtonian, periodic, smoothed continuity": (varied(CHANNEL, **SMOOTHED), {}, 2.0),
    "summed, periodic": (varied(CHANNEL, density="summation", density_range=[0.5, 1.5]), {}, 0.5),
    "exchange": (BOX, {}, 6.0),
    "exchange, midpoint, newtonian, smoothed continuity": (
        varied(BOX, integrator="midpoint", viscosity="newtonian", nu=1e-4, **SMOOTHED),
        {},
        6.0,
    ),
    "exchange at a plate": ("pool", POOL, 8.0),
    "smoothed continuity": (tank(time={"end": 0.02}, gauges=ENERGY), {f"numerics.{k}": v for k, v in SMOOTHED.items()}, 0.5),
}


def thrown(simulation, speed):
    """Give each particle a velocity of its own, up to `speed` [m/s], and run."""
    p = simulation.particles
    rows = p.fluid
    angle = 2.399963 * identities(p.tags[rows])
    part, columns = p.layout.columns("velocity")
    getattr(p, part)[rows, columns] = speed * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    simulation.run()
    return simulation


@pytest.mark.parametrize("name", SCENES)
def test_new_terms_and_borders_are_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, name):
    """While cuts move, and particles pass walls, borders and slabs."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 5)
    source, overrides, speed = SCENES[name]
    scene = load_scene(source, overrides)
    columns, last = grid_of(scene)[0].columns, communicator.size - 1
    _, right = build(scene, Communicator()).domain.end_columns()
    cuts = (0, *(columns - right - last + rank for rank in range(1, last + 1)), columns)
    mine, alone = thrown(rebuilt(scene, communicator, cuts), speed), thrown(build(scene, Communicator()), speed)
    assert mine.domain.cuts != cuts or communicator.size == 1
    assert alone.steps > 10
    assert_same_run(mine, alone)
    counts = np.sum(communicator.allgather([wall.exchanged for wall in mine.domain.walls]), axis=0)
    np.testing.assert_array_equal(counts, [wall.exchanged for wall in alone.domain.walls])
    if scene.walls.exchange:
        assert counts.sum() > (0 if scene.domain.periodic else 10)
    if scene.domain.periodic:
        start = build(scene, Communicator())
        moved = [run.field("position")[np.argsort(run.field("id")), 1] for run in (alone, start)]
        assert (np.abs(moved[0] - moved[1]) > 0.5 * scene.domain.size[1]).any(), "nothing crossed a border"
