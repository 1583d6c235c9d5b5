"""Wavemakers, absorption and bodies on slabs: every rank runs the whole scene alone too, and compares all bits."""

import numpy as np
import pytest
from test_ghost_slabs import both
from test_slabs import assert_same_run, gathered

import parsph.simulation
from parsph.bodies import Absorber, MovableWall
from parsph.scene.load import load_scene

SIDES = {"left": {}, "right": {}, "bottom": {}}
BOX = {"name": "box", "points": [[0.48, 0.09], [0.62, 0.09], [0.62, 0.23], [0.48, 0.23]], "fluid": "outside"}
WAVE = {"kind": "oscillation", "stroke": 0.06, "period": 0.1}
BODY = {"mass": 15.0, "stiffness": 50.0, "damping": 1.0, "preload": 0.0, "stops": [-0.05, 0.08]}
EVERY = {"every": 0.005}
LEVEL = {"kind": "level", "x": 0.5, **EVERY}
SCENES = {
    "piston of a mirror, absorption, right wall": {
        "walls": SIDES,
        "wavemaker": {"kind": "piston", "wave": WAVE, "absorption": {}},
        "bodies": [{"wall": "right", **BODY}],
        "gauges": [{"kind": "body", "wall": "right", **EVERY}, {"kind": "runup", "wall": "left", **EVERY}, LEVEL],
    },
    "flap over a sill of ghosts, box": {
        "walls": {**SIDES, "treatment": "ghosts", "polygons": [BOX]},
        "wavemaker": {"kind": "flap", "hinge": 0.12, "wave": WAVE},
        "bodies": [{"wall": "box", "direction": [1.0, 0.2], **BODY}],
        "gauges": [
            {"kind": "body", "wall": "box", **EVERY},
            {"kind": "runup", "wall": "left", **EVERY},
            {"kind": "force", "wall": "box", **EVERY},
            {"kind": "pressure", "wall": "left", "point": [0.0, 0.16], **EVERY},
        ],
    },
    "regular waves of a piston of ghosts, absorption": {
        "walls": {**SIDES, "treatment": "ghosts"},
        "wavemaker": {
            "kind": "piston",
            "wave": {"kind": "regular", "height": 0.05, "wavelength": 0.8, "ramp": 0.0},
            "absorption": {"distance": 0.3, "filter": 0.002},
        },
        "bodies": [{"wall": "right", **BODY}],
        "gauges": [{"kind": "body", "wall": "right", **EVERY}, LEVEL],
    },
}


def scene(name):
    """Return a scene with water 0.28 m deep, higher at the left, whose plate moves at once."""
    low = {"low": [0.0, 0.0], "high": [0.24, 0.32]}, {"low": [0.24, 0.0], "high": [1.0, 0.28]}
    keys = {
        "domain": {"size": [1.0, 0.6]},
        "fluid": {"blocks": list(low), "level": 0.28},
        "numerics": {
            "dx": 0.04,
            "h_over_dx": 1.5,
            "density_range": [0.4, 2.0],
            "diffusion": "fourtakas",
            "viscosity": "monaghan",
            "alpha": 0.1,
        },
        "time": {"end": 0.03, "cfl": 0.3},
        **SCENES[name],
    }
    return load_scene(keys)


@pytest.mark.parametrize("name", SCENES)
def test_walls_that_move_the_flow_or_are_moved_are_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, name):
    """Fields, gauges, and what was decided: each rank has the same way, speed and work, while cuts move every ten steps."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 10)
    mine, alone, _ = both(scene(name), communicator)
    assert alone.steps > 20
    assert_same_run(mine, alone)
    np.testing.assert_array_equal(gathered(mine, "mass"), alone.field("mass"))
    for one, other in zip(mine.movers, alone.movers, strict=True):
        for key in ("time", "way", "speed", "acceleration"):
            assert getattr(one.signal, key) == getattr(other.signal, key)
        assert other.signal.way != 0
        if isinstance(other, MovableWall):
            assert one.state == other.state
            assert other.work != 0
    assert {type(mover) for mover in alone.movers} >= {MovableWall}
    assert any(isinstance(mover, Absorber) for mover in alone.movers) == ("absorption" in name)
    for gauge in alone.observers:
        assert np.ptp(gauge.record()[:, 1]) > 0
