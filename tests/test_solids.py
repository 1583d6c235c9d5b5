"""Scenes with polygons: their faults, blocks of any shape, swinging bodies, and gauges on walls."""

import json
import math

import numpy as np
import pytest
import shapely
from helpers import tank

from parsph.errors import SceneError, SceneFaults
from parsph.scene.build import build, gauges_of
from parsph.scene.lattice import Lattice
from parsph.scene.load import json_schema, load_scene, scene_text
from parsph.scene.solids import boundaries_of, fillings_of
from parsph.wavemakers import Swing, oscillation

DX, REACH = 0.05, 0.15
TAN30 = math.tan(math.radians(30))
BASIN = {"name": "tank", "points": [[0.0, 0.8], [0.0, 0.0], [1.0, 0.0], [1.0, 0.8]], "fluid": "left"}


def wall(*points, **keys):
    return {"name": "wall", "points": [list(point) for point in points], **keys}


def box(left, bottom, right, top, **keys):
    return wall((left, bottom), (right, bottom), (right, top), (left, top), **{"name": "box", "fluid": "outside", **keys})


def water(*polygons, block=None, **sections):
    """Return the keys of a tank of 1 m x 0.8 m with 0.4 m of water, or another `block`, at spacing DX; reach REACH."""
    keys = {
        "domain": {"size": [1.0, 0.8]},
        "fluid": {"blocks": [block or {"low": [0.0, 0.0], "high": [1.0, 0.4]}]},
        "walls": {"polygons": list(polygons)},
        "numerics": {"dx": DX, "h_over_dx": 1.5},
        "time": {"end": 0.0},
    }
    return {**keys, **sections}


def poured(*points, **keys):
    """Return the keys of a polygon block."""
    return {"points": [list(point) for point in points], **keys}


def in_3d(*polygons, block=None):
    block = block or {"low": [0.0, 0.0, 0.0], "high": [1.0, 1.0, 0.4]}
    return water(*polygons, block=block, domain={"size": [1.0, 1.0, 0.8]})


# --- faults --------------------------------------------------------------------------------------------------------

TOP = [[0.0, 0.8], [0.0, 0.0]]
# name: (keys, where, part of what is wrong, part of why, part of the cure)
FAULTS = {
    "line that crosses itself": (
        water({**BASIN, "points": [*TOP, [0.6, 0.0], [0.6, 0.5], [0.3, 0.5], [0.3, 0.2], [1.0, 0.2]]}),
        "walls.polygons.0.points.2",
        "crosses itself",
        "at (0.6, 0.2) m",
        "does not cross or touch",
    ),
    "line that runs back on itself": (
        water({**BASIN, "points": [*TOP, [1.0, 0.0], [0.5, 0.0]]}),
        "walls.polygons.0.points.1",
        "crosses itself",
        "from point 1",
        "does not cross or touch",
    ),
    "polygon that crosses itself": (
        water(BASIN, wall((0.3, 0.1), (0.7, 0.5), (0.7, 0.1), (0.3, 0.5), fluid="outside")),
        "walls.polygons.1.points.0",
        "crosses itself",
        "at (0.5, 0.3) m",
        "does not cross or touch",
    ),
    "polygon without area": (
        water(BASIN, wall((0.3, 0.1), (0.5, 0.1), (0.7, 0.1), fluid="outside")),
        "walls.polygons.1.points.0",
        "crosses itself",
        "another one",
        "does not cross or touch",
    ),
    "block that crosses itself": (
        water(BASIN, block=poured((0, 0), (1, 0.4), (1, 0), (0, 0.4))),
        "fluid.blocks.0.points.0",
        "crosses itself",
        "at (0.5, 0.2) m",
        "does not cross or touch",
    ),
    "repeated point": (
        water({**BASIN, "points": [*TOP, [0.0, 0.0], [1.0, 0.0], [1.0, 0.8]]}),
        "walls.polygons.0.points.1",
        "equals the next point",
        "",
        "leave one out",
    ),
    "polygon closed by hand": (
        water(BASIN, wall((0.3, 0.1), (0.7, 0.1), (0.7, 0.5), (0.3, 0.5), (0.3, 0.1), fluid="outside")),
        "walls.polygons.1.points.4",
        "equals the next point",
        "",
        "closes itself",
    ),
    "line of one point": (
        water({**BASIN, "points": [[0.0, 0.8]]}),
        "walls.polygons.0.points",
        "at least 2",
        "",
        "vertices [m]",
    ),
    "polygon of two points": (
        water(BASIN, wall((0.3, 0.1), (0.7, 0.5), fluid="outside")),
        "walls.polygons.1.points",
        "has 2 points",
        "",
        "at least 3",
    ),
    "block of two points": (
        water(BASIN, block=poured((0, 0), (1, 0.4))),
        "fluid.blocks.0.points",
        "at least 3",
        "",
        "vertices [m]",
    ),
    "point in space": (
        water({**BASIN, "points": [*TOP, [1.0, 0.0, 0.0]]}),
        "walls.polygons.0.points.2",
        "at most 2",
        "",
        "vertices [m]",
    ),
    "point outside the domain": (
        water({**BASIN, "points": [*TOP, [1.1, 0.0], [1.0, 0.8]]}),
        "walls.polygons.0.points.2",
        "outside the domain",
        "(1.1, 0) m",
        "domain.size",
    ),
    "point of a block outside the domain": (
        water(BASIN, block=poured((0, 0), (1, -0.1), (1, 0.4))),
        "fluid.blocks.0.points.1",
        "outside the domain",
        "(1, -0.1) m",
        "domain.size",
    ),
    "thin obstacle": (
        water(BASIN, box(0.4, 0.1, 0.5, 0.3)),
        "walls.polygons.1.points.0",
        "the wall is 0.1 m near this point",
        "at the other",
        "at least 0.15 m",
    ),
    "narrow gap at a wall": (
        water(BASIN, box(0.07, 0.2, 0.4, 0.6)),
        "walls.polygons.1.points.0",
        "the gap to the next wall is 0.07 m",
        "two particles",
        "at least 0.1 m",
    ),
    "narrow gap at the bed": (
        water(BASIN, box(0.4, 0.06, 0.8, 0.3)),
        "walls.polygons.1.points.1",
        "the gap to the next wall is 0.06 m",
        "two particles",
        "at least 0.1 m",
    ),
    "narrow gap in one line": (
        water(
            {**BASIN, "points": [[0.2, 0.8], [0.2, 0.0], [0.29, 0.0], [0.29, 0.8]]},
            block=poured((0.2, 0), (0.29, 0), (0.2, 0.4)),
        ),
        "walls.polygons.0.points.0",
        "the gap to the next wall is 0.09 m",
        "two particles",
        "smaller numerics.dx",
    ),
    "fluid at the other side": (
        water({**BASIN, "fluid": "right"}),
        "fluid.blocks.0",
        "fluid on the wrong side",
        "0.4 m^2 of it lie behind 'tank', near its point",
        '"right" at walls.polygons.0',
    ),
    "block that reaches behind a basin": (
        water(box(0.1, 0.1, 0.9, 0.7, fluid="inside")),
        "fluid.blocks.0",
        "fluid on the wrong side",
        "0.16 m^2 of it lie behind 'box', near its point",
        '"inside" at walls.polygons.0',
    ),
    "block that reaches below a bed": (
        water(wall((0, 0.2), (1, 0.2))),
        "fluid.blocks.0",
        "fluid on the wrong side",
        "0.2 m^2 of it lie behind 'wall'",
        "another block",
    ),
    "open wall that ends in the fluid": (
        water(BASIN, wall((0.5, 0.8), (0.5, 0.2))),
        "walls.polygons.1.points.1",
        "an open wall ends in the fluid",
        "flows round its end",
        "an obstacle is a polygon",
    ),
    "open wall that ends below the waterline": (
        water({**BASIN, "points": [*TOP, [1.0, 0.0], [1.0, 0.2]]}),
        "walls.polygons.0.points.3",
        "an open wall ends in the fluid",
        "flows round its end",
        "above the water",
    ),
    "name taken twice": (
        water(BASIN, box(0.4, 0.1, 0.6, 0.3, name="tank")),
        "walls.polygons.1.name",
        "'tank' is taken",
        "",
        "a name of its own",
    ),
    "name of a side": (water({**BASIN, "name": "left"}), "walls.polygons.0.name", "'left' is taken", "", "a name of its own"),
    "name that another wall has by default": (
        water({**BASIN, "name": "wall-01"}, box(0.4, 0.1, 0.6, 0.3, name=None)),
        "walls.polygons.1.name",
        "'wall-01' is taken",
        "",
        "a name of its own",
    ),
    "polygon in 3D": (in_3d(BASIN), "walls.polygons", "polygons are for 2D", "", "sides of the domain"),
    "block of points in 3D": (
        in_3d(block=poured((0, 0), (1, 0), (1, 0.4))),
        "fluid.blocks.0.points",
        "polygons are for 2D",
        "",
        "low and high",
    ),
    "points and another low": (
        water(BASIN, block=poured((0, 0.1), (1, 0.1), (1, 0.4), low=[0.0, 0.0])),
        "fluid.blocks.0.low, high",
        "given beside points",
        "",
        "one of the two",
    ),
    "points and another high": (
        water(BASIN, block=poured((0, 0), (1, 0), (1, 0.4), high=[1.0, 0.5])),
        "fluid.blocks.0.low, high",
        "given beside points",
        "",
        "one of the two",
    ),
    "point of a block with one component": (
        water(BASIN, block=poured((0, 0), (1, 0.4), (1,))),
        "fluid.blocks.0.points.2",
        "at least 2",
        "",
        "vertices [m]",
    ),
    "block in an obstacle": (
        water(BASIN, box(0.3, 0.1, 0.7, 0.5), block={"low": [0.4, 0.2], "high": [0.6, 0.4]}),
        "fluid.blocks.0",
        "holds no particles",
        "",
        "dx",
    ),
    "motion without a period": (
        water(BASIN, box(0.4, 0.1, 0.6, 0.3, motion={"way": [0.05, 0.0]})),
        "walls.polygons.1.motion.period",
        "is missing",
        "",
        "period [s]",
    ),
    "motion too far round": (
        water(BASIN, box(0.4, 0.1, 0.6, 0.3, motion={"angle": 50.0, "period": 1.0})),
        "walls.polygons.1.motion.angle",
        "less than or equal to 45",
        "",
        "[degrees]",
    ),
    "force on a wall that is not there": (
        water(BASIN, gauges=[{"kind": "force", "wall": "tnak"}]),
        "gauges.0.wall",
        "no wall 'tnak'",
        "",
        "did you mean 'tank'?",
    ),
    "force on a side that is open": (
        water(BASIN, gauges=[{"kind": "force", "wall": "left"}]),
        "gauges.0.wall",
        "no wall 'left'",
        "",
        "one of: tank",
    ),
    "force in 3D": (in_3d() | {"gauges": [{"kind": "force", "wall": "bottom"}]}, "gauges.0.kind", "is for 2D", "", "another"),
    "force on nothing": (water(BASIN, gauges=[{"kind": "force"}]), "gauges.0.wall", "is missing", "", "name of a polygon wall"),
    "extent of one component": (
        water(BASIN, gauges=[{"kind": "pressure", "point": [0.0, 0.1], "extent": [0.1]}]),
        "gauges.0.extent",
        "has 1 components",
        "",
        "this scene has 2",
    ),
    "extent of three components": (
        water(BASIN, gauges=[{"kind": "pressure", "point": [0.0, 0.1], "extent": [0.0, 0.0, 0.1]}]),
        "gauges.0.extent",
        "has 3 components",
        "",
        "this scene has 2",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_says_where_what_why_and_the_cure(name):
    keys, where, what, why, cure = FAULTS[name]
    with pytest.raises(SceneFaults) as caught:
        load_scene(keys)
    faults = [fault for fault in caught.value.faults if fault.where == where and what in fault.what]
    assert faults, f"no {what!r} at {where}: {caught.value}"
    assert any(why in fault.why and cure in fault.cure for fault in faults), [(f.why, f.cure) for f in faults]
    assert all(fault.cure for fault in caught.value.faults)
    assert caught.value.exit_code == 2


GOOD = {
    "tank": water(BASIN),
    "basin": water(box(0, 0, 1, 0.8, fluid="inside")),
    "box in the water": water(BASIN, box(0.4, 0.1, 0.6, 0.3)),
    "box on the bed": water(BASIN, box(0.4, 0, 0.6, 0.3)),
    "box in a corner": water(BASIN, box(0, 0, 0.3, 0.3)),
    "box at the waterline": water(BASIN, box(0.4, 0.3, 0.6, 0.5)),
    "wall down to the bed": water(BASIN, wall((0.5, 0.8), (0.5, 0)), block={"low": [0.5, 0.0], "high": [1.0, 0.4]}),
    "box with a gap of two particles": water(BASIN, box(0.1, 0.1, 0.4, 0.3)),
    "box as thick as the ghosts reach": water(BASIN, box(0.4, 0.1, 0.55, 0.3)),
    "swinging box": water(BASIN, box(0.4, 0.1, 0.6, 0.3, motion={"way": [0.05, 0.0], "period": 1.0})),
    "walls by default names": water(BASIN, box(0.4, 0.1, 0.6, 0.3, name=None)),
    "beach": water(
        {**BASIN, "points": [*TOP, [0.4, 0.0], [1.0, 0.6 * TAN30], [1.0, 0.8]]},
        block=poured((0, 0), (0.4, 0), (0.4 + 0.2 / TAN30, 0.2), (0, 0.2)),
    ),
    "trough": water(wall((0, 0.3), (0.4, 0), (1, 0.6 * TAN30)), block=poured((0, 0.3), (0.4, 0), (0.4 + 0.3 / TAN30, 0.3))),
    "polygon block between mirrors": water(block=poured((0, 0), (1, 0), (1, 0.2), (0, 0.4)), walls={"bottom": {}}),
    "force on walls and sides": water(
        box(0.4, 0.1, 0.6, 0.3),
        walls={"top": {}, "polygons": [box(0.4, 0.1, 0.6, 0.3)]},
        gauges=[{"kind": "force", "wall": "top"}, {"kind": "force", "wall": "box"}],
    ),
}


@pytest.mark.parametrize("name", GOOD)
def test_a_good_scene_has_no_fault(name):
    assert load_scene(GOOD[name]).dim == 2


def test_faults_of_all_polygons_are_told_together():
    keys = water({**BASIN, "name": "top"}, wall((0.3, 0.1), (1.2, 0.1), (0.3, 0.1), fluid="outside"))
    with pytest.raises(SceneError) as caught:
        load_scene(keys)
    assert {fault.where for fault in caught.value.faults} >= {"walls.polygons.0.name", "walls.polygons.1.points.1"}


@pytest.mark.parametrize("name", GOOD)
def test_the_text_of_a_scene_with_polygons_is_the_scene(name, tmp_path):
    scene = load_scene(GOOD[name])
    path = tmp_path / "scene.json"
    path.write_text(scene_text(scene))
    assert load_scene(path) == scene


def test_low_and_high_of_a_polygon_block_are_those_of_its_points():
    block = load_scene(GOOD["beach"]).fluid.blocks[0]
    assert block.low == [0, 0]
    assert block.high == pytest.approx([0.4 + 0.2 / TAN30, 0.2])


def test_the_schema_takes_a_block_of_points_alone():
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(GOOD["tank"], json.loads(json_schema()))
    jsonschema.validate(GOOD["polygon block between mirrors"], json.loads(json_schema()))


# --- blocks of fluid -----------------------------------------------------------------------------------------------


def filled(keys):
    """Return the scene, the filling of its block, and the positions of its particles."""
    scene = load_scene(keys)
    return scene, fillings_of(scene)[0], build(scene).field("position")


def from_walls(scene, points):
    """Distances of points to the nearest wetted edge."""
    edges = np.concatenate([boundary.edges for boundary, _ in boundaries_of(scene)])
    return shapely.distance(shapely.multilinestrings(shapely.linestrings(edges)), shapely.points(points))


# solid is moved along the normal of a face, not away from the corner
@pytest.mark.parametrize(
    ("obstacle", "area"),
    [
        (box(0.4, 0.1, 0.6, 0.3), 0.04),
        (box(0.4, 0, 0.6, 0.3), 0.06),
        (box(0.42, 0.13, 0.61, 0.33), 0.038),
        (wall((0.3, 0.2), (0.5, 0.12), (0.7, 0.2), (0.5, 0.35), fluid="outside"), 0.046),
        (box(0.4, 0.1, 0.6, 0.3, motion={"way": [0.05, 0.0], "period": 1.0}), 0.04),
    ],
    ids=["on the lattice", "on the bed", "off the lattice", "rhomboid", "moving"],
)
def test_an_obstacle_in_a_rectangular_block_stays_dry(obstacle, area):
    scene, filling, position = filled(water(BASIN, obstacle))
    assert not shapely.contains_xy(shapely.Polygon(obstacle["points"]), *position.T).any()
    assert filling.count * filling.volume == pytest.approx(0.4 - area)
    assert filling.volume == pytest.approx(DX**2, rel=0.05)
    assert from_walls(scene, position).min() > (0.5 - 1e-3) * DX


SLOPES = {
    "beach": (GOOD["beach"], 0.2 * 0.4 + 0.5 * 0.2 * 0.2 / TAN30),
    "trapezium": (
        water(wall((0, 0.4), (0.3, 0), (0.7, 0), (1, 0.4)), block=poured((0.075, 0.3), (0.3, 0), (0.7, 0), (0.925, 0.3))),
        0.3 * (0.4 + 0.85) / 2,
    ),
    "bed with a step": (
        water({**BASIN, "points": [*TOP, [0.5, 0], [0.5, 0.2], [1, 0.2], [1, 0.8]]},
              block=poured((0, 0), (0.5, 0), (0.5, 0.2), (1, 0.2), (1, 0.4), (0, 0.4))),
        0.3,
    ),
    "trough": (GOOD["trough"], 0.5 * 0.3 * (0.4 + 0.3 / TAN30)),
    "wedge": (
        water({**BASIN, "points": [*TOP, [1, TAN30]]}, block=poured((0, 0), (0.4 / TAN30, 0.4), (0, 0.4))),
        0.5 * 0.4 * 0.4 / TAN30,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SLOPES)
def test_a_polygon_block_is_filled_and_half_a_spacing_from_its_walls(name):
    keys, area = SLOPES[name]
    scene, filling, position = filled(keys)
    assert len(position) == filling.count
    assert filling.count * filling.volume == pytest.approx(area)
    assert filling.volume == pytest.approx(DX**2, rel=0.05)
    assert shapely.contains_xy(shapely.Polygon(scene.fluid.blocks[0].points), *position.T).all()
    assert from_walls(scene, position).min() > (0.5 - 1e-3) * min(filling.lattice.step)


def test_a_rectangle_of_points_is_filled_as_one_of_corners():
    _, filling, position = filled(water(BASIN, block=poured((0, 0), (1, 0), (1, 0.4), (0, 0.4))))
    _, lattice, expected = filled(water(BASIN))
    assert isinstance(lattice, Lattice)
    assert filling.volume == pytest.approx(lattice.volume)
    np.testing.assert_allclose(position, expected, atol=1e-12)


def test_a_polygon_block_weighs_what_it_holds():
    scene, filling, _ = filled(GOOD["beach"])
    simulation = build(scene)
    mass, density = simulation.field("mass"), simulation.field("density")
    np.testing.assert_allclose(mass / density, filling.volume, rtol=1e-12)
    assert mass.sum() == pytest.approx(1000 * SLOPES["beach"][1], rel=1e-3)


def test_columns_share_the_particles_of_a_filling():
    scene, filling, position = filled(water(BASIN, box(0.42, 0.13, 0.61, 0.33)))
    grid = build(scene).domain.grid
    counts = filling.column_counts(grid)
    parts = [filling.between(grid, column, column + 1) for column in range(grid.columns)]
    assert counts.sum() == filling.count == len(position)
    assert [len(numbers) for numbers, _ in parts] == list(counts)
    assert sorted(np.concatenate([numbers for numbers, _ in parts])) == list(range(filling.count))
    np.testing.assert_array_equal(np.concatenate([points for _, points in parts])[:, 0].round(9).min(), 0.025)


# --- swinging bodies -----------------------------------------------------------------------------------------------

SWING = Swing(way=(0.3, -0.1), angle=math.radians(20), center=(0.4, 0.7), period=1.3, ramp=0.9)
TIMES = [0.05, 0.31, 0.7, 0.88, 0.95, 1.6, 4.2]


@pytest.mark.parametrize("ramp", [0.0, 0.9, 3.0])
def test_rates_of_an_oscillation_are_its_derivatives(ramp):
    step = 1e-5
    for time in TIMES:
        before, now, after = (oscillation(t, 1.3, ramp) for t in (time - step, time, time + step))
        assert now[1] == pytest.approx((after[0] - before[0]) / (2 * step), abs=1e-7)
        assert now[2] == pytest.approx((after[1] - before[1]) / (2 * step), abs=1e-7)


def test_an_oscillation_begins_from_rest_and_ends_in_a_sine():
    assert oscillation(-1.0, 1.3, 0.9) == oscillation(0.0, 1.3, 0.0) == (0, 0, 0)
    assert oscillation(1e-9, 1.3, 0.9) == pytest.approx((0, 0, 0), abs=1e-7)
    assert oscillation(0.9, 1.3, 0.9) == pytest.approx(oscillation(0.9, 1.3, 0.0))
    assert oscillation(1.3 / 4, 1.3, 0.0)[0] == pytest.approx(1)


@pytest.mark.parametrize("time", TIMES)
def test_velocity_and_acceleration_of_a_swing_are_the_derivatives_of_its_place(time):
    points, step = np.random.default_rng(5).uniform(-1, 1, (20, 2)), 1e-4
    before, now, after = (SWING.at(t).place(points) for t in (time - step, time, time + step))
    velocity, acceleration = (after - before) / (2 * step), (after - 2 * now + before) / step**2
    np.testing.assert_allclose(SWING.at(time).velocity(now), velocity, atol=1e-5)
    np.testing.assert_allclose(SWING.at(time).acceleration(now), acceleration, atol=1e-4)
    assert np.abs(velocity).max() > 1e-3


def test_a_swing_turns_counter_clockwise_about_its_center_and_keeps_distances():
    now = Swing((0.0, 0.0), math.radians(30), (0.4, 0.7), 1.0).at(0.25)
    np.testing.assert_allclose(now.place(np.array([[1.4, 0.7], [0.4, 0.7]])), [[0.4 + math.sqrt(0.75), 1.2], [0.4, 0.7]])
    np.testing.assert_allclose(now.turn(np.array([[1.0, 0.0]])), [[math.sqrt(0.75), 0.5]])
    points = np.random.default_rng(6).uniform(-1, 1, (20, 2))
    placed = SWING.at(0.6).place(points)
    apart, before = (np.linalg.norm(x[:, None] - x, axis=2) for x in (placed, points))
    np.testing.assert_allclose(apart, before, atol=1e-12)


def test_a_swing_without_center_turns_about_its_first_point():
    scene = load_scene(water(BASIN, box(0.4, 0.1, 0.6, 0.3, motion={"angle": 10.0, "period": 1.0})))
    (_, still), (boundary, motion) = boundaries_of(scene)
    assert still is None
    assert list(boundary.outlines) == [1]
    assert motion.center == (0.4, 0.1)
    assert motion.angle == pytest.approx(math.radians(10))


# --- gauges --------------------------------------------------------------------------------------------------------

DEPTH, WEIGHT = 0.2, 1000 * 9.81  # of the small tank
LINES = [
    wall((0, 0.3), (0, 0), name="west"),
    wall((0, 0), (0.2, 0), name="bed"),
    wall((0.2, 0), (0.2, 0.3), name="east"),
]
WALLS = {
    "polygons": ({"polygons": LINES}, ("west", "bed", "east")),
    "mirrors": (tank()["walls"], ("left", "bottom", "right")),
    "one polygon": ({"polygons": [{**BASIN, "points": [[0, 0.3], [0, 0], [0.2, 0], [0.2, 0.3]]}]}, ("tank",)),
    "box": (
        {"polygons": [{**BASIN, "points": [[0, 0.3], [0, 0], [0.2, 0], [0.2, 0.3]]}, box(0.06, 0.06, 0.14, 0.14)]},
        ("box",),
    ),
}


def measured(gauges, walls):
    """Return what `gauges` read in a small tank of still water at the beginning, without their times, by their names."""
    simulation = build(load_scene(tank(walls=WALLS[walls][0], gauges=gauges, time={"end": 0.0})))
    simulation.run()
    return {gauge.name: gauge.record()[0, 1:] for gauge in simulation.observers}


def forces(walls, about=(0.0, 0.0)):
    names = WALLS[walls][1]
    found = measured([{"kind": "force", "wall": name, "name": name, "about": list(about)} for name in names], walls)
    return [found[name] for name in names]


@pytest.mark.parametrize("walls", ["polygons", "mirrors"])
def test_still_water_pushes_side_walls_with_half_its_weight_times_depth_and_the_bed_with_all(walls):
    west, bed, east = forces(walls)
    push = WEIGHT * DEPTH**2 / 2
    assert west[:2] == pytest.approx([-push, 0], rel=5e-3, abs=1e-9)
    assert east[:2] == pytest.approx([push, 0], rel=5e-3, abs=1e-9)
    assert bed[:2] == pytest.approx([0, -WEIGHT * DEPTH * 0.2], rel=5e-3, abs=1e-9)
    assert bed[2] == pytest.approx(bed[1] * 0.1, rel=1e-6)


@pytest.mark.parametrize("walls", ["polygons", "mirrors"])
def test_moments_about_the_feet_of_side_walls_are_those_of_a_triangle_of_pressure(walls):
    """rho g H^3/6: the water at the left of a wall turns it clockwise, and that at the right counter-clockwise."""
    moment = WEIGHT * DEPTH**3 / 6
    assert forces(walls)[0][2] == pytest.approx(moment, rel=0.01)
    assert forces(walls, about=(0.2, 0.0))[2][2] == pytest.approx(-moment, rel=0.01)


def test_a_tank_carries_the_weight_of_its_water():
    (force,) = forces("one polygon", about=(0.1, 0.0))
    assert force == pytest.approx([0, -WEIGHT * DEPTH * 0.2, 0], rel=5e-3, abs=1e-6)


def test_still_water_lifts_a_box_with_the_weight_that_it_displaces():
    (force,) = forces("box", about=(0.1, 0.1))
    assert force == pytest.approx([0, WEIGHT * 0.08**2, 0], rel=0.01, abs=1e-6)


def test_a_pressure_gauge_with_an_extent_reads_the_mean_along_it():
    """Half of the long one is dry: p = 0 there."""
    gauges = [
        {"kind": "pressure", "name": "point", "point": [0.0, 0.1]},
        {"kind": "pressure", "name": "short", "point": [0.0, 0.1], "extent": [0.0, 0.06]},
        {"kind": "pressure", "name": "slanting", "point": [0.1, 0.1], "extent": [0.1, 0.1]},
        {"kind": "pressure", "name": "level", "point": [0.1, 0.05], "extent": [0.1, 0.0]},
        {"kind": "pressure", "name": "long", "point": [0.0, 0.2], "extent": [0.0, 0.2]},
    ]
    found = {name: value[0] for name, value in measured(gauges, "mirrors").items()}
    assert found["point"] == pytest.approx(WEIGHT * 0.1, rel=2e-3)
    for name in ("short", "slanting"):
        assert found[name] == pytest.approx(found["point"], rel=2e-3)
    assert found["level"] == pytest.approx(WEIGHT * 0.15, rel=2e-3)
    assert found["long"] == pytest.approx(WEIGHT * 0.1 / 4, rel=0.01)


def test_the_mean_of_an_extent_is_that_of_its_points():
    gauge = {"kind": "pressure", "point": [0.05, 0.1], "extent": [0.0, 0.06]}
    scene = load_scene(tank(gauges=[gauge], time={"end": 0.0}))
    points = gauges_of(scene, None, {}, [])[0].points
    assert len(points) == 12  # at most half a spacing apart
    np.testing.assert_allclose(points.mean(axis=0), [0.05, 0.1])
    singles = [{"kind": "pressure", "name": f"P{k}", "point": list(point)} for k, point in enumerate(points)]
    each = measured(singles, "mirrors").values()
    assert measured([gauge], "mirrors")["pressure-00"] == pytest.approx(np.mean(list(each)), rel=1e-12)


def test_the_surface_of_a_moving_wall_moves_with_it():
    """A force gauge of a box that turns reads the same on its turned surface: the water around it is at rest."""
    motion = {"angle": 20.0, "period": 1.0, "center": [0.1, 0.1]}
    walls = {"polygons": [WALLS["box"][0]["polygons"][0], box(0.06, 0.06, 0.14, 0.14, motion=motion)]}
    gauge = {"kind": "force", "wall": "box", "name": "box"}
    simulation = build(load_scene(tank(walls=walls, gauges=[gauge], time={"end": 0.0})))
    simulation.prepare()
    force = simulation.observers[0]
    still = force.measure(simulation)
    simulation.time = 0.25
    turned = force.measure(simulation)
    assert turned[1] == pytest.approx(WEIGHT * 0.08**2, rel=0.05)
    assert turned[0] == pytest.approx(0, abs=0.05 * still[1])
    assert abs(turned[0]) > 1e-9
