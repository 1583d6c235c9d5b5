"""What cases share: a scene run on one rank, and the records of its level gauges."""

import numpy as np

from ..parallel import Communicator
from ..scene.build import build
from ..scene.load import load_scene


def run_scene(source, overrides=()):
    """Return the scene and the finished `Simulation`."""
    scene, simulation = built(source, overrides)
    simulation.run()
    return scene, simulation


def built(source, overrides=()):
    """Return the scene and its `Simulation` on one rank, not begun."""
    scene = load_scene(source, overrides)
    return scene, build(scene, Communicator())


def levels_of(simulation):
    """Return times [s], shape (samples,), levels [m], shape (gauges, samples), and places [m] of the level gauges."""
    gauges = [gauge for gauge in simulation.observers if getattr(gauge, "columns", ()) == ("level [m]",)]
    records = [gauge.record() for gauge in gauges]
    return records[0][:, 0], np.array([record[:, 1] for record in records]), np.array([gauge.place[0] for gauge in gauges])
