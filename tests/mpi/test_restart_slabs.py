"""Runs that go on from a checkpoint, on all ranks and on one, against those that never stopped: every field and record."""

import numpy as np
import pytest
import test_channel_slabs
import test_ghost_slabs
import test_mover_slabs
import test_treatments
from helpers import tank
from test_slabs import assert_same_run, gathered

import parsph.simulation
from parsph.io.checkpoints import Checkpoint, write_checkpoint
from parsph.observers import Observer
from parsph.parallel import Communicator
from parsph.scene.build import build
from parsph.scene.load import load_scene

RELAXED = tank(
    domain={"size": [1.2, 0.3], "gravity": 9.81},
    fluid={"blocks": [{"low": [0.0, 0.0], "high": [1.2, 0.2]}]},
    numerics={"dx": 0.02, "diffusion": "fourtakas", "viscosity": "monaghan"},
    relaxation=[{"length": 0.5, "height": 0.04, "period": 0.7, "ramp": 0.0}],
    damping=[{"side": "right", "length": 0.4, "density": "plain"}],
    time={"end": 0.05},
    gauges=[{"kind": "level", "x": 0.45, "every": 0.01}, {"kind": "energy", "every": 0.01}],
)
DAM_BREAK = {"time.end": 10.0, "gauges": [{"kind": "level", "x": 505.0, "every": 2.5}]}
SCENES = {
    "relaxation, layer": lambda: load_scene(RELAXED),
    "shallow water, summed": lambda: load_scene("swe-dam-break", DAM_BREAK),
    **{f"ghosts: {name}": lambda keys=keys: test_ghost_slabs.scene(**keys) for name, keys in test_ghost_slabs.SCENES.items()},
    **{f"movers: {name}": lambda name=name: test_mover_slabs.scene(name) for name in test_mover_slabs.SCENES},
    **{
        f"walls: {name}": lambda name=name: test_treatments.scene(test_treatments.WALLS[name])
        for name in ("strip with a flap", "deficiency that bulge")
    },
    **{
        f"terms: {name}": lambda name=name: load_scene(*test_channel_slabs.SCENES[name][:2])
        for name in (
            "newtonian, periodic, midpoint, float32",
            "newtonian, periodic, smoothed continuity",
            "summed, periodic",
            "exchange",
        )
    },
}


class Saver(Observer):
    """Writes a checkpoint at the end of the step of this number, and lets the run go on."""

    settles = True

    def __init__(self, path, step):
        super().__init__()
        self.path, self.wait = path, step

    def due(self, time):
        self.wait -= 1
        return self.wait == 0

    def observe(self, simulation):
        write_checkpoint(self.path, simulation, "{}", {"of": simulation.steps})


def run(scene, communicator, path=None, step=0, checkpoint=None):
    """Return the finished run of a scene, from a checkpoint or with one written to `path` on the way."""
    simulation = build(scene, communicator, checkpoint=checkpoint)
    gauges = list(simulation.observers)
    if path:
        simulation.observers.append(Saver(path, step))
    if checkpoint:
        checkpoint.examine(communicator)
        checkpoint.restore(simulation)
    simulation.run()
    simulation.observers = gauges
    return simulation


def assert_goes_on(rest, whole):
    """A run from a checkpoint ends as the whole one, and its records are the end of those."""
    for gauge, other in zip(rest.observers, whole.observers, strict=True):
        count = len(gauge.records)
        other.records = other.records[len(other.records) - count :]
    assert_same_run(rest, whole)
    np.testing.assert_array_equal(gathered(rest, "mass"), whole.field("mass"))
    for one, other in zip(rest.movers, whole.movers, strict=True):
        assert one.memory == other.memory
    assert rest.evaluations == whole.evaluations


@pytest.mark.parametrize("name", SCENES)
def test_a_run_goes_on_to_the_same_bits_on_other_ranks(communicator, monkeypatch, tmp_path, name):
    """From one rank to all and from all to one; while the water settles too; gauge rows come once."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 10)
    scene, alone = SCENES[name](), Communicator()
    step = 5 if scene.time.settle else 9
    mine, single = tmp_path / "all.vtkhdf", tmp_path / f"single-{communicator.rank}.vtkhdf"
    whole = run(scene, alone, single, step)
    run(scene, communicator, mine, step)
    assert whole.steps > step + 3
    checkpoint = communicator.on_root(lambda: Checkpoint(mine))
    assert 0 < checkpoint.totals["of"] < whole.steps
    assert (checkpoint.time < 0) == bool(scene.time.settle)
    assert_goes_on(run(scene, alone, checkpoint=checkpoint), whole)
    assert_goes_on(run(scene, communicator, checkpoint=communicator.on_root(lambda: Checkpoint(single))), whole)
