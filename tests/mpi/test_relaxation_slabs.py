"""Relaxation zones on slabs: every rank runs the whole alone too, and compares."""

import pytest
from helpers import tank
from test_slabs import assert_same_run, rebuilt

import parsph.simulation
from parsph.parallel import Communicator
from parsph.scene.build import build, grid_of
from parsph.scene.load import load_scene

WAVE = {"length": 0.5, "height": 0.04, "period": 0.7, "ramp": 0.0}
STILL = {"side": "right", "length": 0.4, "height": 0}


@pytest.mark.parametrize("density", ["matched", "none"])
def test_zones_are_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, density):
    """While cuts move through them, and with masses that change."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 5)
    keys = tank(
        domain={"size": [1.2, 0.3], "gravity": 9.81},
        fluid={"blocks": [{"low": [0.0, 0.0], "high": [1.2, 0.2]}]},
        numerics={"dx": 0.02, "diffusion": "fourtakas", "viscosity": "monaghan"},
        relaxation=[{**zone, "density": density} for zone in (WAVE, STILL)],
        time={"end": 0.1},
        gauges=[{"kind": "level", "x": 0.45, "every": 0.02}, {"kind": "energy", "every": 0.02}],
    )
    scene = load_scene(keys)
    columns, last = grid_of(scene, {})[0].columns, communicator.size - 1
    _, right = build(scene, Communicator()).domain.end_columns()
    cuts = (0, *(columns - right - last + rank for rank in range(1, last + 1)), columns)
    mine, alone = rebuilt(scene, communicator, cuts), build(scene, Communicator())
    for simulation in (mine, alone):
        simulation.run()
    assert mine.domain.cuts != cuts or communicator.size == 1
    assert alone.steps > 20
    assert abs(alone.field("velocity")).max() > 0.05
    assert_same_run(mine, alone)
