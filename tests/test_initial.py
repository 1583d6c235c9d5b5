"""What blocks of fluid begin with: velocities of their own, exact flows, and what is said of those that cannot be."""

import numpy as np
import pytest

from parsph.errors import SceneError
from parsph.flows import RotatingPatch, StretchingDrop, TaylorGreen
from parsph.parallel import Communicator
from parsph.scene.build import build
from parsph.scene.initial import flow_of
from parsph.scene.load import load_scene

PATCH = {"low": [0.5, 0.5], "high": [1.5, 1.5], "initial": "rotation", "rate": -2.0}
DROP = {"ellipse": {"center": [1.0, 1.0], "axes": [0.5, 0.3]}, "initial": "stretching", "rate": 2.0}
VORTICES = {"low": [0.0, 0.0], "high": [2.0, 2.0], "initial": "vortices", "speed": 1.5, "pressure": 100.0}


def keys(block, **sections):
    """Return the keys of a scene without weight; `sections` replace whole sections."""
    scene = {
        "domain": {"size": [2.0, 2.0], "gravity": 0.0},
        "fluid": {"blocks": [block]},
        "numerics": {"dx": 0.05, "c0": 30.0},
        "time": {"end": 0.01},
    }
    if block.get("initial") == "vortices":
        scene["domain"]["periodic"] = ["x", "up"]
    return {**scene, **sections}


def began(block, **sections):
    """Return the simulation of a block, not begun."""
    return build(load_scene(keys(block, **sections)), Communicator())


@pytest.mark.parametrize(
    ("block", "flow"),
    [
        (PATCH, RotatingPatch((0.5, 0.5), (1.5, 1.5), -2.0, 1000.0)),
        (VORTICES, TaylorGreen((0.0, 0.0), 2.0, 1.5, 0.0, 1000.0)),
    ],
    ids=["rotation", "vortices"],
)
def test_blocks_begin_with_velocity_and_pressure_of_the_flow(block, flow):
    simulation = began(block)
    position = simulation.field("position")
    np.testing.assert_array_equal(simulation.field("velocity"), flow.velocity(position))
    wanted = flow.pressure(position) + block.get("pressure", 0.0)
    np.testing.assert_allclose(simulation.field("pressure"), wanted, atol=1e-8 * 1000 * 30**2)
    np.testing.assert_allclose(simulation.field("mass"), simulation.field("density") * 0.05**2, rtol=1e-12)


def test_an_ellipse_stretches_about_its_middle():
    scene = load_scene(keys(DROP))
    flow = flow_of(scene, scene.fluid.blocks[0])
    assert isinstance(flow, StretchingDrop)
    np.testing.assert_allclose([flow.low, flow.high], [[0.5, 0.7], [1.5, 1.3]], atol=2e-4)  # a polygon of the same area
    simulation = began(DROP)
    position = simulation.field("position")
    np.testing.assert_allclose(simulation.field("velocity"), 2.0 * (position - 1.0) * [-1, 1], atol=1e-12)
    pressure = simulation.field("pressure")
    assert pressure[np.argmin(np.linalg.norm(position - 1, axis=1))] == pytest.approx(flow.pressure([[1.0, 1.0]])[0], rel=0.02)
    assert pressure.min() > -0.02 * pressure.max()


def test_a_velocity_is_added_to_whatever_the_block_does():
    still = {"low": [0.5, 0.5], "high": [1.0, 1.0], "velocity": [1.0, -2.0]}
    np.testing.assert_array_equal(began(still).field("velocity"), np.tile([1.0, -2.0], (100, 1)))
    moved = began({**PATCH, "velocity": [1.0, -2.0]}).field("velocity") - began(PATCH).field("velocity")
    np.testing.assert_allclose(moved, np.tile([1.0, -2.0], (400, 1)), atol=1e-14)
    tank = {"domain": {"size": [1.0, 1.0]}, "walls": {"left": {}, "right": {}, "bottom": {}}}
    seiche = {"low": [0.0, 0.0], "high": [1.0, 0.5], "initial": "seiche", "amplitude": 0.01}
    moved = began({**seiche, "velocity": [0.1, 0.0]}, **tank).field("velocity") - began(seiche, **tank).field("velocity")
    np.testing.assert_allclose(moved, np.tile([0.1, 0.0], (200, 1)), atol=1e-14)
    shallow = {"domain": {"size": [4.0]}, "numerics": {"dx": 0.1, "state": "shallow"}}
    block = {"low": [0.0], "high": [4.0], "depth": 1.0, "velocity": [0.3]}
    np.testing.assert_array_equal(began(block, **shallow).field("velocity"), np.full((40, 1), 0.3))


WEIGHT = {"domain": {"size": [2.0, 2.0], "gravity": 9.81}}
NOT_SQUARE = {"domain": {"size": [2.0, 1.0], "gravity": 0.0, "periodic": ["x", "up"]}}


@pytest.mark.parametrize(
    ("block", "sections", "where", "what"),
    [
        ({**PATCH, "rate": None}, {}, "fluid.blocks.0.rate", "is missing"),
        ({**PATCH, "rate": 0.0}, {}, "fluid.blocks.0.rate", "must not be 0"),
        ({**PATCH, "speed": 1.0}, {}, "fluid.blocks.0.speed", "has no meaning here"),
        ({**VORTICES, "speed": None}, {}, "fluid.blocks.0.speed", "is missing"),
        ({**PATCH, "initial": "still"}, {}, "fluid.blocks.0.rate", "has no meaning here"),
        ({**PATCH, "velocity": [1.0]}, {}, "fluid.blocks.0.velocity", "has 1 components"),
        (PATCH, WEIGHT, "domain.gravity", "must be 0"),
        ({**DROP, "initial": "rotation"}, {}, "fluid.blocks.0.initial", "rotation needs a rectangle"),
        ({**PATCH, "initial": "stretching"}, {}, "fluid.blocks.0.initial", "stretching needs an ellipse"),
        (
            {"points": [[0.5, 0.5], [1.5, 0.5], [1.0, 1.5]], "initial": "stretching", "rate": 1.0},
            {},
            "fluid.blocks.0.initial",
            "stretching needs an ellipse",
        ),
        (VORTICES, {"domain": {"size": [2.0, 2.0], "gravity": 0.0, "periodic": ["up"]}}, "domain.periodic", "must be both"),
        ({**VORTICES, "high": [2.0, 1.0]}, NOT_SQUARE, "fluid.blocks.0", "vortices need the whole of a square domain"),
        ({**VORTICES, "high": [2.0, 1.9]}, {}, "fluid.blocks.0", "vortices need the whole of a square domain"),
        (
            {"low": [0.0], "high": [2.0], "initial": "rotation", "rate": 1.0},
            {"domain": {"size": [2.0], "gravity": 0.0}},
            "fluid.blocks.0.initial",
            "rotation needs two dimensions",
        ),
        (
            {"low": [0.0, 0.0], "high": [2.0, 1.0], "initial": "seiche", "amplitude": 0.01},
            {"domain": {"size": [2.0, 2.0], "periodic": ["x"]}, "walls": {"bottom": {}}},
            "fluid.blocks.0.initial",
            "cannot begin so",
        ),
        ({**PATCH, "rate": 20.0}, {}, "numerics.c0", "30 m/s is too slow for a flow of 14.14 m/s"),
        ({**PATCH, "velocity": [4.0, 3.0]}, {}, "numerics.c0", "30 m/s is too slow for a flow of 6.414 m/s"),
        ({**DROP, "rate": 13.0}, {}, "numerics.c0", "30 m/s is too slow for a flow of 6.5"),
        ({**VORTICES, "speed": 6.5}, {}, "numerics.c0", "30 m/s is too slow for a flow of 6.5 m/s"),
    ],
)
def test_what_cannot_be_is_refused(block, sections, where, what):
    with pytest.raises(SceneError) as error:
        load_scene(keys({name: value for name, value in block.items() if value is not None}, **sections))
    fault = getattr(error.value, "faults", [error.value])[0]
    assert (fault.where, fault.what[: len(what)]) == (where, what)
    assert fault.cure
