"""Flows that walls do not hold: an exact one, and the energy of any."""

import math

import numpy as np

from ...scene.initial import flow_of
from ...scene.load import load_scene
from .base import metric, total_energy


@metric("axes-error", "%")
def axes_error(results, references):
    """Stretching drop: error of the half axis that is further off at the end, those of the second moments of the particles."""
    scene = load_scene(results.scene)
    block = scene.fluid.blocks[0]
    if block.initial != "stretching":
        return math.nan
    flow, shot = flow_of(scene, block), results.snapshot()
    _, *theory = flow.at(shot["time"])
    errors = 100.0 * (flow.half_axes(shot["position"][:, :2]) / theory - 1.0)
    return float(errors[np.argmax(np.abs(errors))])


@metric("energy-change", "%", needs="energy")
def energy_change(results, references):
    """Kinetic, potential and compressible energy together at the end, over those at the beginning, minus 1."""
    total = total_energy(results)
    return float(100.0 * (total[-1] / total[0] - 1.0))
