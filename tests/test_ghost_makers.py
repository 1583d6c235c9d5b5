"""Wavemakers of ghosts: as many as a wall at rest has, none in the fluid, and the fluid goes with the plate."""

import math

import numpy as np
import pytest
from helpers import tank

from parsph.kernels import KERNELS
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.scene.schema import SILL
from parsph.scene.solids import boundaries_of, motions_of

DX, LENGTH, HEIGHT = 0.02, 0.6, 0.3
WAVE = {"kind": "oscillation", "stroke": 0.08, "period": 0.5}
QUARTERS = (0.0, 0.125, 0.375)  # at rest, and at both extremes
MAKERS = {
    "piston": {"kind": "piston", "wave": WAVE},
    "flap at the bed": {"kind": "flap", "wave": WAVE},
    "flap over a sill": {"kind": "flap", "hinge": 0.1, "wave": WAVE},
    "flap below the bed": {"kind": "flap", "hinge": -0.2, "wave": WAVE},
}
PADDLE = {"name": "paddle", "points": [[0.1, HEIGHT], [0.1, 0.0]]}


def basin(maker=None, polygons=(), left=0.0, dx=DX, end=0.04):
    """Return a tank of ghosts, water from `left` on; the left wall is a side, or one of the polygons."""
    sides = {"right": {}, "bottom": {}, **({} if polygons else {"left": {}})}
    keys = tank(
        domain={"size": [LENGTH, HEIGHT]},
        fluid={"blocks": [{"low": [left, 0.0], "high": [LENGTH, 0.2]}]},
        walls={**sides, "polygons": list(polygons), "treatment": "ghosts"},
        numerics={"dx": dx, "diffusion": "fourtakas", "viscosity": "monaghan"},
        time={"end": end},
    )
    return load_scene(keys | ({"wavemaker": maker} if maker else {}))


def face(scene, time, z):
    """Where the left wall and the plate are at the heights z."""
    motion = motions_of(scene)[scene.wavemaker.wall].at(time)
    foot = 0.0 if scene.wavemaker.kind == "piston" else max(scene.wavemaker.hinge or 0.0, 0.0)
    low, high = motion.place(np.array([[0.0, foot], [0.0, HEIGHT]]))
    along = low[0] + (high[0] - low[0]) * (z - low[1]) / (high[1] - low[1])
    return np.where(z >= foot, along, 0.0)


@pytest.mark.parametrize("name", MAKERS)
def test_a_plate_at_rest_has_the_ghosts_of_a_wall_and_the_bed_goes_on_under_it_as_far_as_it_goes(name):
    """Rows of the bed's ghosts are longer by the reach of the plate and the ghosts that are needed beyond."""
    bare, scene = basin(), basin(MAKERS[name])
    ghosts, plain = build(scene).domain.ghosts, build(bare).domain.ghosts
    least, _ = motions_of(scene)["left"].reach(HEIGHT)
    layers = math.ceil(scene.reach / DX - 0.5)
    if "sill" in name:  # the bed ends at the sill
        assert ghosts.count == plain.count
        assert scene.wall_names.count(SILL) == 1
    else:
        # beyond the support radius behind the plate the bed of a wall at rest has no ghosts, that of a plate has
        extra = (ghosts.position[:, 0] < -scene.reach).sum()
        assert extra > 0
        assert ghosts.count - extra <= plain.count + layers
        assert ghosts.position[:, 0].min() < least - scene.reach + DX
    behind = [(abs(g.position[:, 1] - 0.15) < 0.5 * DX) & (g.position[:, 0] < 0) for g in (ghosts, plain)]
    np.testing.assert_allclose(
        np.sort(ghosts.position[behind[0]], axis=0), np.sort(plain.position[behind[1]], axis=0), atol=0.5 * DX
    )
    assert behind[0].sum() == behind[1].sum() == layers


@pytest.mark.parametrize("name", MAKERS)
def test_no_ghost_is_in_the_fluid_wherever_the_plate_is(name):
    scene = basin(MAKERS[name])
    ghosts = build(scene).domain.ghosts
    for time in QUARTERS:
        ghosts.move(time)
        x, z = ghosts.position.T
        inside = (x > face(scene, time, z) + 1e-9) & (x < LENGTH) & (z > 0) & (z < HEIGHT)
        assert not inside.any()
        behind = (x < face(scene, time, z)) & (x > face(scene, time, z) - DX) & (z > 0) & (z < HEIGHT)
        assert behind.sum() >= 14  # a whole layer stands right behind it


@pytest.mark.parametrize(("name", "most"), [("piston", 2e-3), ("flap at the bed", 0.025), ("flap over a sill", 0.045)])
def test_water_and_ghosts_fill_the_space_beside_a_plate_wherever_it_is(name, most):
    """But for the wedge that ghosts leave open, or fill twice, where a leaning plate meets the wall below it; 11 and 22
    degrees.
    """
    scene = basin(MAKERS[name])
    ghosts = build(scene).domain.ghosts
    x, z = (axis.ravel() for axis in np.meshgrid(DX * (np.arange(30) + 0.5), DX * (np.arange(23) + 0.5)))
    for time in QUARTERS:
        ghosts.move(time)
        position = np.stack([x + face(scene, time, z), z], axis=1)
        everything, volume = np.concatenate([position, ghosts.position]), np.append(np.full(len(x), DX**2), ghosts.volume)
        near = (x < 0.1) & (z < 0.25)
        apart = np.linalg.norm(position[near][:, None] - everything, axis=2)
        sums = (volume * KERNELS["wendland-c2"].value(apart, scene.h, 2)).sum(axis=1)
        assert np.abs(sums - 1).max() < (2e-3 if time == 0 else most)


def test_the_plate_ends_where_the_wall_below_it_begins():
    """Two boundaries, one at rest, one that moves; neither has ghosts that stand in for the other."""
    (still, nothing), (plate, motion) = boundaries_of(basin(MAKERS["flap over a sill"]))
    assert nothing is None
    assert motion.hinge == (0.0, 0.1)
    np.testing.assert_allclose(plate.edges[0][:, 0], 0.0, atol=1e-12)
    assert plate.edges[:, :, 1].min() == pytest.approx(0.1)
    assert plate.edges[:, :, 1].max() > HEIGHT  # prolonged at its free end
    assert still.edges[:, :, 0].min() == pytest.approx(0.0, abs=1e-12)


GENTLE = {"kind": "oscillation", "stroke": 0.02, "period": 0.3, "ramp": 0.1}


@pytest.mark.parametrize(
    ("maker", "polygons", "left"),
    [
        ({"kind": "piston", "wave": GENTLE}, (), 0.0),
        ({"kind": "flap", "hinge": 0.08, "wave": GENTLE}, (), 0.0),
        ({"kind": "piston", "wall": "paddle", "wave": GENTLE}, (PADDLE,), 0.1),
    ],
    ids=["side", "flap over a sill", "polygon wall"],
)
def test_the_water_next_to_a_plate_goes_with_it(maker, polygons, left):
    """Its velocity along x, half-way between bed and surface, or under the surface at a flap, and no particle is behind."""
    scene = basin(maker, polygons, left)
    simulation = build(scene)
    simulation.run()
    assert simulation.steps > 12
    position, velocity = simulation.field("position"), simulation.field("velocity")
    now = motions_of(scene)[scene.wavemaker.wall].at(simulation.time)
    low, high = (0.1, 0.18) if maker["kind"] == "flap" else (0.04, 0.16)
    near = position[:, 0] < left + 0.8 * DX + now.place(np.array([[left, 0.15]]))[0, 0] - left
    near &= (position[:, 1] > low) & (position[:, 1] < high)
    assert near.sum() >= 3
    plate = now.velocity(position[near])[:, 0]
    assert np.abs(plate).max() > 0.02
    np.testing.assert_allclose(velocity[near, 0], plate, atol=0.25 * np.abs(plate).max())
    assert simulation.domain.barrier.stopped == 0
    if maker["kind"] == "flap":  # the sill stands still
        below = (position[:, 0] < 0.8 * DX) & (position[:, 1] < 0.05)
        assert np.abs(velocity[below, 0]).max() < 0.2 * np.abs(plate).max()
