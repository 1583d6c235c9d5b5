"""Run-up on walls: known waterlines, sheets, drops, dry and moving walls, and what a scene may ask for."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import tank

from parsph.errors import SceneFaults
from parsph.io.gauges import RunupGauge, ascents
from parsph.io.gauges.runup import shoreline
from parsph.jit import compilations
from parsph.kernels import KERNELS
from parsph.parallel import Communicator
from parsph.run import load_code, run
from parsph.scene.build import build, gauges_of
from parsph.scene.load import load_scene
from parsph.scene.solids import ascents_of
from parsph.wavemakers import Swing

DX, H, FINE = 0.02, 0.04, 6  # spacing and smoothing length [m]; particles per dx where the fluid is to be a continuum
SLOPES = {"1:10": 0.1, "1:3": 1 / 3, "1:1": 1.0, "vertical": math.inf}


def pieces(*corners, length=0.1 * DX):
    """Return midpoints, normals to the left and lengths of the pieces of a line."""
    points, normals, lengths = [], [], []
    for a, b in zip(np.array(corners[:-1], float), np.array(corners[1:], float), strict=True):
        count = max(1, round(np.linalg.norm(b - a) / length))
        along = (b - a) / np.linalg.norm(b - a)
        points.append(a + (np.arange(count)[:, None] + 0.5) / count * (b - a))
        normals.append(np.tile([-along[1], along[0]], (count, 1)))
        lengths.append(np.full(count, np.linalg.norm(b - a) / count))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(lengths)


def beach(slope):
    """Return a bed from x = -1 to 0 m and a slope from there, 0.5 m high."""
    return pieces((-1.0, 0.0), (0.0, 0.0), (0.5 / slope, 0.5))


def lattice(x, z, dx):
    """Return the positions of a lattice between two x and two z."""
    axes = [a + dx * (np.arange(round((b - a) / dx)) + 0.5) for a, b in (x, z)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)


def pool(level, slope):
    """Return particles of still water on a `beach`, so fine that they are a continuum, and their volume."""
    dx = DX / FINE
    position = lattice((-0.3, level / slope + dx), (0.0, level), dx)
    return position[position[:, 1] > slope * position[:, 0]], dx * level / round(level / dx)


def simulation_of(position, volume, kernel="wendland-c2", time=0.0):
    """Return what a gauge sees of a simulation, with particles made by hand."""
    count = len(position)
    fields = {"position": position, "mass": np.full(count, 1000.0 * volume), "density": np.full(count, 1000.0)}
    return SimpleNamespace(
        particles=SimpleNamespace(tags=np.arange(count), field=lambda name, rows: fields[name][rows]),
        domain=SimpleNamespace(fluid_between=lambda low, high: np.arange(count), borders=()),
        sweep=SimpleNamespace(kernel=KERNELS[kernel], h=H, h_growth=1.0, dim=2),
        communicator=Communicator(),
        time=time,
    )


def read(line, level, position, volume=DX**2, **more):
    """Return what a gauge reads (run-up z, shoreline x, distance) of particles made by hand, on the only way up a wall."""
    (ascent,) = ascents(*line, level)
    return RunupGauge("", 1.0, ascent, more.pop("motion", None)).measure(simulation_of(position, volume, **more))


# --- known waterlines ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kernel", ["wendland-c2", "gaussian"])
@pytest.mark.parametrize("slope", SLOPES)
def test_still_water_ends_at_its_level_on_walls_of_any_slope(slope, kernel):
    """Levels on and off the lattice; the mark is elsewhere, at 0.21 m."""
    slope = min(SLOPES[slope], 1e9)
    for level in 0.2 + DX * np.array([0.0, 0.23, 0.5, 0.77]):
        z, x, distance = read(beach(slope), 0.21, *pool(level, slope), kernel=kernel)
        assert z == pytest.approx(level, abs=0.15 * DX)
        assert x == pytest.approx(z / slope, abs=1e-9)
        assert distance == pytest.approx((z - 0.21) * math.hypot(1, 1 / slope), abs=0.05 * DX)


def test_a_sheet_of_one_layer_is_followed_to_its_tip():
    """On a slope of 1:3; a spacing along it is 0.3 in height."""
    along, normal = np.array([3.0, 1.0]) / math.sqrt(10), np.array([-1.0, 3.0]) / math.sqrt(10)
    for tip in (0.5, 0.513, 0.521):
        sheet = np.arange(0.5 * DX, tip, DX)[:, None] * along + 0.5 * DX * normal
        z, x, _ = read(beach(1 / 3), 0.05, sheet)
        assert np.hypot(x, z) == pytest.approx(np.linalg.norm(sheet[-1] @ along) + 0.5 * DX, abs=1.5 * DX)
        assert z == pytest.approx((sheet[-1] @ along + 0.5 * DX) * along[1], abs=0.5 * DX)


def test_drops_above_a_dry_stretch_do_not_count_and_those_that_fall_into_the_water_do():
    water, volume = lattice((-0.3, 0.0), (0.0, 0.2), DX), DX**2
    still, *_ = read(beach(1e9), 0.2, water, volume)
    drop = lattice((-0.04, 0.0), (0.0, 0.04), DX)
    for height, counts in ((0.4, False), (0.34, False), (0.2 + DX, True)):
        z, *_ = read(beach(1e9), 0.2, np.concatenate([water, drop + np.array([0.0, height])]), volume)
        assert z == pytest.approx(height + 0.04 if counts else still, abs=0.25 * DX if counts else 1e-12)


def test_a_dry_wall_reads_its_lowest_point():
    """Nothing near; water that has drawn back from the foot; and water only far above it."""
    line = pieces((0.0, 0.1), (0.0, 0.5))
    away = lattice((-1.0, -0.5), (0.0, 0.3), DX)
    for position in (away, away[:0], lattice((-0.1, 0.0), (0.3, 0.4), DX)):
        z, x, distance = read(line, 0.05, position)
        assert z == pytest.approx(0.1, abs=0.06 * DX)
        assert x == 0.0
        assert distance == 0.0
    z, x, distance = read(beach(1 / 3), 0.1, away)
    assert (z, x) == pytest.approx((0.0, 0.0), abs=0.1 * DX)
    assert distance == pytest.approx(-0.1 * math.sqrt(10), abs=0.1 * DX)


def test_a_wall_under_water_reads_its_top():
    z, *_ = read(pieces((0.0, 0.0), (0.0, 0.2)), 0.1, lattice((-0.3, 0.3), (0.0, 0.4), DX))
    assert z == pytest.approx(0.2, abs=0.06 * DX)


def test_water_over_a_berm_has_the_berm_as_its_highest_and_the_front_as_its_last_point():
    """The way goes on to the highest point; water in the dip alone does not count."""
    line = pieces((-0.4, 0.0), (0.0, 0.2), (0.2, 0.14), (0.6, 0.3))
    layers = []
    for start, end in (((-0.4, 0.0), (0.0, 0.2)), ((0.0, 0.2), (0.2, 0.14))):
        a, b = np.array(start), np.array(end)
        way = (b - a) / np.linalg.norm(b - a)
        normal = np.array([-way[1], way[0]])
        row = a + np.arange(0.5 * DX, np.linalg.norm(b - a), DX)[:, None] * way
        layers.append(np.concatenate([row + (k + 0.5) * DX * normal for k in range(2)]))
    z, x, _ = read(line, 0.05, np.concatenate(layers))
    assert z == pytest.approx(0.2, abs=0.1 * DX)
    assert x == pytest.approx(0.2, abs=2.5 * DX)
    z, x, _ = read(line, 0.05, layers[1][layers[1][:, 0] > 0.1])
    assert (z, x) == pytest.approx((0.0, -0.4), abs=0.1 * DX)


def test_the_shoreline_is_interpolated_and_gaps_up_to_the_longest_are_bridged():
    along = np.arange(8.0)
    assert shoreline(np.array([1, 1, 1, -1, -1, -1, -1, -1.0]), along, 2.0) == 2.5
    assert shoreline(np.array([1, -1, 3, -1, -1, -1, -1, -1.0]), along, 2.0) == 2.75
    assert shoreline(np.array([1, -1, -1, 3, -1, -1, -1, -1.0]), along, 2.0) == 0.5
    assert shoreline(np.array([-1, -1, 3, -1, -1, -1, -1, -1.0]), along, 2.0) == 2.75
    assert shoreline(np.array([-1, -1, -1, 3, -1, -1, -1, -1.0]), along, 2.0) == 0.0
    assert shoreline(np.full(8, -1.0), along, 2.0) == 0.0
    assert shoreline(np.full(8, 1.0), along, 2.0) == 7.0


# --- the way up ----------------------------------------------------------------------------------------------------


def test_a_wall_has_a_way_up_from_each_place_where_still_water_meets_it():
    """From the nearest lowest point to the first highest one."""
    basin = pieces((-1.0, 0.5), (-1.0, 0.0), (1.0, 0.0), (2.5, 0.5))
    left, right = ascents(*basin, 0.2)
    assert (left.x, right.x) == pytest.approx((-1.0, 1.6), abs=1e-9)
    np.testing.assert_allclose(left.points[[0, -1]], [[-1, 0], [-1, 0.5]], atol=0.11 * DX)
    np.testing.assert_allclose(right.points[[0, -1]], [[1, 0], [2.5, 0.5]], atol=0.11 * DX)
    for ascent in (left, right):
        assert (np.linalg.norm(np.diff(ascent.points, axis=0), axis=1) < 0.12 * DX).all()


def test_a_polygon_has_them_wherever_its_first_point_is():
    corners = [(0.2, 0.1), (0.2, 0.4), (0.6, 0.4), (0.6, 0.1)]  # an obstacle, the fluid at the left of each edge
    for first in range(4):
        turned = corners[first:] + corners[:first]
        for level, start in ((0.3, 0.1), (0.05, 0.1)):
            left, right = ascents(*pieces(*turned, turned[0]), level)
            assert (left.x, right.x) == pytest.approx((0.2, 0.6), abs=0.06 * DX)
            for ascent, x in ((left, 0.2), (right, 0.6)):
                np.testing.assert_allclose(ascent.points[[0, -1]], [[x, start], [x, 0.4]], atol=0.06 * DX)


def test_what_stands_on_a_wall_ends_the_way():
    """A piece of the wall is missing: inside another solid."""
    points, normals, lengths = beach(1 / 3)
    bare = (points[:, 0] < 0.9) | (points[:, 0] > 1.1)
    (ascent,) = ascents(points[bare], normals[bare], lengths[bare], 0.2)
    assert ascent.points[-1, 0] == pytest.approx(0.9, abs=0.1 * DX)
    bare = (points[:, 0] < 0.2) | (points[:, 0] > 0.4)
    (ascent,) = ascents(points[bare], normals[bare], lengths[bare], 0.2)
    assert ascent.points[0, 0] == pytest.approx(0.4, abs=0.1 * DX)


def test_a_wall_under_water_or_without_a_rise_has_none():
    assert ascents(*pieces((0, 0), (0, 0.2)), 0.3) == []
    assert ascents(*pieces((0, 0.4), (1, 0.4)), 0.3) == []


# --- moving walls --------------------------------------------------------------------------------------------------


def test_a_gauge_moves_with_its_wall():
    """A wall and the water at it, both shifted, read the same but for the shift; the mark stays on the wall."""
    motion = Swing((0.1, 0.03), 0.0, (0.0, 0.0), 1.0)
    water = lattice((-0.3, 0.0), (0.0, 0.2), DX)
    line = beach(1e9)
    z, x, distance = read(line, 0.15, water)
    moved = read(line, 0.15, water + np.array([0.1, 0.03]), motion=motion, time=0.25)
    assert moved == pytest.approx((z + 0.03, x + 0.1, distance), abs=1e-9)


def test_a_wall_that_leans_meets_still_water_elsewhere():
    """Turned by 20 degrees about its foot, away from the water: a slope of tan 70 degrees."""
    motion = Swing((0.0, 0.0), -math.radians(20), (0.0, 0.0), 1.0)
    slope = math.tan(math.radians(70))
    z, x, distance = read(pieces((0.0, 0.0), (0.0, 0.5)), 0.2, *pool(0.2, slope), motion=motion, time=0.25)
    assert z == pytest.approx(0.2, abs=0.15 * DX)
    assert x == pytest.approx(z / slope, rel=1e-6)
    assert distance == pytest.approx(z / math.sin(math.radians(70)) - 0.2, abs=1e-6)


# --- scenes --------------------------------------------------------------------------------------------------------

LINE = {"name": "tank", "points": [[0.0, 0.3], [0.0, 0.0], [0.2, 0.0], [0.2, 0.3]]}
RUNUP = {"kind": "runup", "every": 0.005}


def at_the_beginning(**keys):
    """Return the records of the gauges of a small tank at t = 0."""
    simulation = build(load_scene(tank(time={"end": 0.0}, **keys)))
    simulation.run()
    return [gauge.record()[0, 1:] for gauge in simulation.observers]


@pytest.mark.parametrize(
    ("walls", "names"),
    [
        (tank()["walls"], ("left", "right")),
        ({"polygons": [LINE]}, ("tank", "tank")),
        ({**tank()["walls"], "treatment": "repulsion"}, ("left", "right")),
    ],
    ids=["mirrors", "ghosts", "markers"],
)
def test_water_in_a_tank_stands_at_its_level_on_both_sides(walls, names):
    left, right = at_the_beginning(
        walls=walls, gauges=[{**RUNUP, "wall": name, "x": x} for name, x in zip(names, (0.0, 0.2), strict=True)]
    )
    assert left == pytest.approx((0.2, 0.0, 0.0), abs=0.15 * 0.01)
    assert right == pytest.approx((0.2, 0.2, 0.0), abs=0.15 * 0.01)


def test_still_water_on_a_slope_as_a_scene_fills_it():
    """The lattice does not fill the tip: off by a third of a spacing at the most."""
    dx = 0.02
    keys = {
        "domain": {"size": [1.4, 0.5]},
        "walls": {"left": {}, "polygons": [{"name": "beach", "points": [[0.0, 0.0], [0.3, 0.0], [1.4, 1.1 / 3]]}]},
        "numerics": {"dx": dx},
    }
    for level in (0.2, 0.207, 0.212):
        fluid = {"blocks": [{"points": [[0, 0], [0.3, 0], [0.3 + 3 * level, level], [0, level]]}]}
        ((z, x, distance),) = at_the_beginning(**keys, fluid=fluid, gauges=[{**RUNUP, "wall": "beach"}])
        assert z == pytest.approx(level, abs=0.33 * dx)
        assert x == pytest.approx(0.3 + 3 * z, abs=1e-6)
        assert distance == pytest.approx((z - level) * math.sqrt(10), abs=1e-6)


def test_the_tables_have_units_and_no_code_is_compiled_while_it_runs(tmp_path):
    energy = {"kind": "energy", "every": 0.01}  # its sums are those of the log
    gauges = [{**RUNUP, "wall": "right", "name": "R"}, energy]
    keys = tank(gauges=gauges, output={"snapshots": {"every": 0.01}})
    load_code(load_scene(keys), Communicator())
    before = compilations()
    finished = run(keys, out=tmp_path / "run")
    assert compilations() == before
    header, *rows = (finished.folder / "gauges" / "R.csv").read_text().splitlines()
    assert header == "time [s],run-up z [m],shoreline x [m],distance [m]"
    assert len(rows) == 3


def test_the_wavemakers_plate_has_its_run_up_and_pressures():
    """At a quarter of its period it leans towards +x: the shoreline's x is that of the plate at this height."""
    maker = {"wave": {"kind": "oscillation", "angle": 10.0, "period": 1.0}}
    gauges = [{**RUNUP, "wall": "left"}, {"kind": "pressure", "point": [0.0, 0.1], "wall": "left"}]
    simulation = build(
        load_scene(
            tank(
                domain={"size": [0.6, 0.3]},
                fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.6, 0.2]}]},
                wavemaker=maker,
                gauges=gauges,
            )
        )
    )
    simulation.prepare()
    runup, pressure = simulation.observers[:2]
    assert runup.measure(simulation) == pytest.approx((0.2, 0.0, 0.0), abs=0.15 * 0.01)
    assert pressure.measure(simulation)[0] == pytest.approx(9810 * 0.1, rel=5e-3)
    simulation.time = 0.25
    z, x, _ = runup.measure(simulation)
    assert x == pytest.approx(z * math.tan(math.radians(10)), abs=1e-9)
    lower = 0.1 * math.cos(math.radians(10))
    assert pressure.measure(simulation)[0] == pytest.approx(9810 * (0.2 - lower), rel=5e-3)


def test_a_pressure_gauge_moves_with_the_wall_that_it_is_fixed_to():
    """A box in still water that sinks by 0.02 m: the pressure rises by that of so much water."""
    box = {
        "name": "box",
        "points": [[0.06, 0.06], [0.14, 0.06], [0.14, 0.14], [0.06, 0.14]],
        "fluid": "outside",
        "motion": {"way": [0.0, -0.02], "period": 1.0},
    }
    still = {"kind": "pressure", "point": [0.14, 0.1], "extent": [0.0, 0.02]}
    scene = load_scene(
        tank(
            walls={"polygons": [LINE, box]},
            gauges=[still, {**still, "wall": "box"}, {**still, "wall": "tank"}],
            time={"end": 0.0},
        )
    )
    simulation = build(scene)
    simulation.prepare()
    before = [gauge.measure(simulation)[0] for gauge in simulation.observers]
    assert before[0] == before[1] == before[2] == pytest.approx(9810 * 0.1, rel=5e-3)
    simulation.time = 0.25
    still, moved, fixed = (gauge.measure(simulation)[0] for gauge in simulation.observers)
    assert still == fixed == before[0]
    assert moved - still == pytest.approx(9810 * 0.02, rel=0.02)


BOX = {"name": "box", "points": [[0.06, 0.06], [0.14, 0.06], [0.14, 0.14], [0.06, 0.14]], "fluid": "outside"}
# name: (keys, where, part of what is wrong, part of why, part of the cure)
FAULTS = {
    "on a wall that is not there": (
        {"gauges": [{**RUNUP, "wall": "rihgt"}]},
        "gauges.0.wall",
        "no wall 'rihgt'",
        "",
        "did you mean 'right'?",
    ),
    "on the bed": ({"gauges": [{**RUNUP, "wall": "bottom"}]}, "gauges.0.wall", "no wall 'bottom'", "", "one of: left, right"),
    "on nothing": ({"gauges": [RUNUP]}, "gauges.0.wall", "is missing", "", "left, right"),
    "on one of two sides": (
        {"walls": {"polygons": [LINE]}, "gauges": [{**RUNUP, "wall": "tank"}]},
        "gauges.0.x",
        "is missing",
        "meets 'tank' at x = 0, 0.2 m",
        "x = 0.2",
    ),
    "on a wall under water": (
        {"walls": {"polygons": [LINE, BOX]}, "gauges": [{**RUNUP, "wall": "box"}]},
        "gauges.0.wall",
        "nothing to run up",
        "no part of 'box' rises from the still-water level, 0.2 m",
        "out of the water",
    ),
    "on a bed of ghosts": (
        {"walls": {**tank()["walls"], "treatment": "ghosts"}, "gauges": [{**RUNUP, "wall": "bottom"}]},
        "gauges.0.wall",
        "nothing to run up",
        "'bottom'",
        "out of the water",
    ),
    "outside the domain": (
        {"gauges": [{**RUNUP, "wall": "right", "x": 0.3}]},
        "gauges.0",
        "0.3 m lies outside",
        "",
        "0 to 0.2",
    ),
    "in 3D": (
        {
            "domain": {"size": [0.2, 0.2, 0.3]},
            "fluid": {"blocks": [{"low": [0, 0, 0], "high": [0.2, 0.2, 0.2]}]},
            "gauges": [{**RUNUP, "wall": "right"}],
        },
        "gauges.0.kind",
        "is for 2D",
        "",
        "another gauge",
    ),
    "pressure on a wall that is not there": (
        {"gauges": [{"kind": "pressure", "point": [0.2, 0.1], "wall": "wrigt"}]},
        "gauges.0.wall",
        "no wall 'wrigt'",
        "",
        "did you mean 'right'?",
    ),
    "pressure on a wall in 3D": (
        {
            "domain": {"size": [0.2, 0.2, 0.3]},
            "fluid": {"blocks": [{"low": [0, 0, 0], "high": [0.2, 0.2, 0.2]}]},
            "gauges": [{"kind": "pressure", "point": [0.2, 0.1, 0.1], "wall": "right"}],
        },
        "gauges.0.wall",
        "is for 2D",
        "",
        "leave it out",
    ),
    "where the vertical is periodic": (
        {
            "domain": {"size": [0.2, 0.2], "periodic": ["up"]},
            "fluid": {"blocks": [{"low": [0, 0], "high": [0.2, 0.2], "pressure": 0.0}]},
            "walls": {"left": {}, "right": {}},
            "numerics": {"dx": 0.01, "c0": 20.0},
            "gauges": [{**RUNUP, "wall": "right"}],
        },
        "gauges.0",
        "there is no surface",
        "periodic",
        "another gauge",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_says_where_what_why_and_the_cure(name):
    keys, where, what, why, cure = FAULTS[name]
    with pytest.raises(SceneFaults) as caught:
        load_scene(tank(**keys))
    (fault,) = (fault for fault in caught.value.faults if fault.where == where)
    assert what in fault.what
    assert why in fault.why
    assert cure in fault.cure


def test_the_place_that_is_named_is_the_one_that_is_read():
    scene = load_scene(tank(walls={"polygons": [LINE]}, gauges=[{**RUNUP, "wall": "tank", "x": x} for x in (0.05, 0.19)]))
    assert [gauge.ascent.x for gauge in gauges_of(scene, None, {}, [])] == pytest.approx([0.0, 0.2])
    assert [ascent.x for ascent in ascents_of(scene, "tank")] == pytest.approx([0.0, 0.2])
