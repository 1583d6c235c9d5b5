"""The single strip of ghosts with solved normal velocities, Szmidt eq. (32)."""

import numpy as np
import pytest

from parsph.parallel import Communicator
from parsph.particles import FIRST_FIXED, FIRST_GHOST
from parsph.scene.build import build
from parsph.scene.load import load_scene

DX = 0.02
MOTION = {"way": [0.01, 0.0], "angle": 8.0, "center": [0.3, 0.0], "period": 0.4}
WALLS = {
    "sides": {"left": {}, "right": {}, "bottom": {}},
    "polygon": {"polygons": [{"points": [[0.0, 0.5], [0.0, 0.1], [0.25, 0.0], [0.6, 0.2], [0.6, 0.5]]}]},
    "curve": {"polygons": [{"ellipse": {"center": [0.3, 0.25], "axes": [0.28, 0.2]}, "fluid": "inside"}]},
    "moving": {
        "left": {},
        "right": {},
        "bottom": {},
        "polygons": [
            {"points": [[0.22, 0.12], [0.38, 0.12], [0.38, 0.26], [0.22, 0.26]], "fluid": "outside", "motion": MOTION}
        ],
    },
    "no slip": {"left": {"slip": "no"}, "right": {"slip": "no"}, "bottom": {"slip": "no"}},
}
BLOCKS = {
    "polygon": [{"points": [[0.0, 0.3], [0.0, 0.1], [0.25, 0.0], [0.6, 0.2], [0.6, 0.3]]}],
    "curve": [{"ellipse": {"center": [0.3, 0.25], "axes": [0.28, 0.2]}}],
}


def scene(name, kernel="wendland-c2", treatment="strip"):
    blocks = BLOCKS.get(name, [{"low": [0.0, 0.0], "high": [0.6, 0.3]}])
    return load_scene(
        {
            "domain": {"size": [0.6, 0.5]},
            "fluid": {"blocks": blocks, "level": 0.3},
            "walls": {"treatment": treatment, **WALLS[name]},
            "numerics": {"dx": DX, "h_over_dx": 1.33, "kernel": kernel, "density_range": [0.5, 2.0], "diffusion": "fourtakas"},
            "time": {"end": 0.1},
        }
    )


def stirred(keys, time=0.05):
    """Return a simulation of fluid with random velocities, its ghosts filled at `time`."""
    simulation = build(keys, Communicator())
    p, rng = simulation.particles, np.random.default_rng(4)
    rows = slice(p.first, p.last)
    p.shared[rows, :2] += rng.uniform(-0.2, 0.2, (p.last - p.first, 2)) * DX
    p.shared[rows, 2:4] = rng.normal(0, 1, (p.last - p.first, 2))
    simulation.evaluate(time)
    return simulation


def normal_velocities(simulation):
    """Return what is interpolated at the wall points: normal velocities relative to the wall, and their scale."""
    ghosts, p, sweep = simulation.domain.ghosts, simulation.particles, simulation.sweep
    rows = slice(p.first, p.last)
    x, v = p.field("position", rows), p.field("velocity", rows)
    volume = p.field("mass", rows) / p.field("density", rows)
    points = 0.5 * (ghosts.position + ghosts.mirror)
    weight = volume * sweep.kernel.value(np.linalg.norm(points[:, None] - x, axis=2), sweep.h, 2)
    relative = v[None] - ghosts.wall[:, None, :2]
    into = (weight[:, :, None] * relative * ghosts.direction[:, None]).sum(axis=(1, 2))
    fluid = p.tags[rows] < FIRST_GHOST
    return into, np.abs((weight[:, :, None] * relative * ghosts.direction[:, None]).sum(axis=2)[:, fluid].sum(axis=1)).max()


@pytest.mark.parametrize("name", WALLS)
@pytest.mark.parametrize("kernel", ["wendland-c2", "gaussian"])
def test_interpolated_normal_velocity_vanishes_at_every_wall_point(name, kernel):
    """Relative to the wall, for any velocities of the fluid: straight walls, corners, curves, moving walls."""
    simulation = stirred(scene(name, kernel=kernel))
    standing = simulation.particles.tags[simulation.particles.first : simulation.particles.last] >= FIRST_FIXED
    assert standing.sum() > 60
    into, scale = normal_velocities(simulation)
    inside = np.isin(np.arange(len(into)), simulation.domain.ghosts.share.standing)
    reached = inside & _all_neighbours_stand(simulation)
    assert reached.sum() > 40
    assert scale > 0.1
    np.testing.assert_allclose(into[reached], 0, atol=1e-10 * scale)


def _all_neighbours_stand(simulation):
    """Which wall points feel no ghost that stands outside the grid, beyond the ends of open walls."""
    ghosts, reach = simulation.domain.ghosts, simulation.sweep.kernel.support * simulation.sweep.h
    points = 0.5 * (ghosts.position + ghosts.mirror)
    away = np.setdiff1d(np.arange(ghosts.count), ghosts.share.standing)
    return (np.linalg.norm(points[:, None] - ghosts.position[away], axis=2) > reach).all(axis=1)


def test_there_is_one_row_of_ghosts_half_a_spacing_behind_the_wall():
    ghosts = build(scene("sides"), Communicator()).domain.ghosts
    depth = np.linalg.norm(ghosts.position - ghosts.mirror, axis=1) / 2
    assert np.isclose(depth, 0.5 * DX).mean() > 0.9
    assert depth.max() < DX


def test_still_water_solves_to_no_velocity():
    simulation = build(scene("sides"), Communicator())
    simulation.evaluate(0.0)
    np.testing.assert_allclose(simulation.domain.ghosts.values[:, :2], 0, atol=1e-15)


def test_tangential_velocities_and_pressures_are_those_of_other_fixed_ghosts():
    """The normal velocities are not: they are solved for."""
    strip, ghosts = (stirred(scene("sides", treatment=name)).domain.ghosts for name in ("strip", "ghosts"))
    number = {tuple(np.round(x, 9)): k for k, x in enumerate(ghosts.position)}
    straight = np.flatnonzero(~strip.turned & (np.abs(strip.values[:, :2]).sum(axis=1) > 0))
    same = [number[tuple(np.round(strip.position[k], 9))] for k in straight]
    normal = strip.direction[straight]
    along = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    ours, theirs = strip.values[straight], ghosts.values[same]
    assert len(straight) > 50
    np.testing.assert_allclose((ours[:, :2] * along).sum(axis=1), (theirs[:, :2] * along).sum(axis=1), atol=1e-12)
    np.testing.assert_array_equal(ours[:, 2:], theirs[:, 2:])
    assert np.abs(((ours - theirs)[:, :2] * normal).sum(axis=1)).max() > 0.1


def test_a_strip_keeps_water_in_its_tank():
    """A seiche for a tenth of a second: nobody beyond a wall, and the water moves."""
    simulation = build(
        load_scene("seiche", {"walls.treatment": "strip", "numerics.h_over_dx": 1.5, "time.end": 0.1}), Communicator()
    )
    simulation.run()
    x = simulation.field("position")
    assert ((x[:, 0] >= 0) & (x[:, 0] <= 0.2) & (x[:, 1] >= 0)).all()
    assert np.abs(simulation.field("velocity")).max() > 0.05
