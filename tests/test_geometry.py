"""Polygon walls: where ghosts stand, what they mirror, and the wetted surface."""

import math

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon

from parsph.geometry import Boundary, Outline

DX, REACH = 0.05, 0.2
LAYERS = 4


def line(*points, fluid="left"):
    return Outline("line", points, fluid)


def polygon(*points, fluid="outside"):
    return Outline("polygon", points, fluid)


def box(left, bottom, right, top, fluid="outside"):
    return polygon((left, bottom), (right, bottom), (right, top), (left, top), fluid=fluid)


def vee(opening, apex=(1.0, 0.2), length=0.8):
    """Two walls that meet below in a corner of the fluid of `opening` degrees."""
    x, y = length * math.sin(math.radians(opening / 2)), length * math.cos(math.radians(opening / 2))
    return line((apex[0] - x, apex[1] + y), apex, (apex[0] + x, apex[1] + y))


def boundary(*outlines, reach=REACH):
    return Boundary(dict(enumerate(outlines)), DX, reach)


def heights(points, edges):
    """Distances of `points` to the nearest of the wetted edges."""
    return shapely.distance(shapely.MultiLineString(list(edges)), shapely.points(points))


def beyond(ghosts, corner, turn):
    """Ghosts in the quadrant at `corner` that lies in the direction of the signs `turn`."""
    return ((ghosts.position - corner) * turn > 0).all(axis=1)


TAN30 = math.tan(math.radians(30))
TANK = line((0, 1), (0, 0), (2, 0), (2, 1))
BED = line((0, 0.2), (2, 0.2))
WALLS = {
    "tank": [TANK],
    "narrow tank": [line((0, 1), (0, 0), (0.15, 0), (0.15, 1))],
    "basin": [box(0.2, 0.2, 1.8, 0.9, fluid="inside")],
    "box": [box(0.5, 0.3, 1, 0.8)],
    "box in a tank": [TANK, box(0.5, 0.3, 1, 0.8)],
    "box sunk into a bed": [BED, box(0.5, 0.05, 1, 0.5)],
    "box that stands on a bed": [TANK, box(0.5, 0, 1, 0.5)],
    "box in a corner": [TANK, box(0, 0, 0.5, 0.5)],
    "step": [line((0, 0.2), (1, 0.2), (1, 0.7), (2, 0.7))],
    "beach": [line((0, 1), (0, 0), (1, 0), (2, TAN30))],
    "V of 30 degrees": [vee(30)],
    "wedge of 30 degrees": [line((0, 1), (0, 0), (1.5, 1.5 * TAN30))],
    "bed that ends in 30 degrees": [line((2, TAN30 * 1.5), (0.5, 0), (2, 0), fluid="right")],
    "triangle of 30 degrees": [polygon((0.5, 0.5), (1.3, 0.5), (0.5, 0.5 + 0.8 * TAN30))],
    "round pile": [polygon(*((1 + 0.3 * math.cos(a), 1 + 0.3 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 25)[:-1]))],
}
CLOSED = [name for name, outlines in WALLS.items() if len(outlines) == 1 and outlines[0].closed]


# --- where ghosts stand --------------------------------------------------------------------------------------------


def test_ghosts_of_a_tank_continue_the_lattice_of_the_fluid_corners_included():
    ghosts = boundary(TANK).ghosts()
    place = ghosts.position / DX - 0.5
    assert np.abs(place - np.round(place)).max() < 1e-9
    np.testing.assert_allclose(ghosts.volume, DX**2, rtol=1e-9)
    sites = {tuple(site) for site in np.round(place).astype(int)}
    assert len(sites) == len(place)
    lattice = np.array([(i, k) for i in range(-LAYERS, 40 + LAYERS) for k in range(-LAYERS, 20)])
    apart = heights((lattice + 0.5) * DX, boundary(TANK).edges)
    behind = (lattice[:, 0] < 0) | (lattice[:, 0] >= 40) | (lattice[:, 1] < 0)
    assert {tuple(site) for site in lattice[behind & (apart < REACH)]} <= sites


@pytest.mark.parametrize("spacings", [4, 5, 6, 7, 9, 10])
def test_volumes_of_ghosts_in_a_box_are_the_area_that_they_fill(spacings):
    width, height = spacings * DX, 0.6
    ghosts = boundary(box(0.5, 0.3, 0.5 + width, 0.3 + height)).ghosts()
    dry = max(width - 2 * LAYERS * DX, 0) * (height - 2 * LAYERS * DX)
    assert ghosts.volume.sum() == pytest.approx(width * height - dry, rel=0.01)


@pytest.mark.parametrize("name", CLOSED)
def test_all_ghosts_of_a_closed_wall_stand_in_its_solid(name):
    walls = boundary(*WALLS[name])
    assert shapely.contains_xy(walls.solid, *walls.ghosts().position.T).all()


@pytest.mark.parametrize("angle", [0, 12, 30, 45, 60, 90, 135, 180, 250, 330])
def test_ghosts_of_a_straight_wall_stand_in_layers_and_mirror_at_the_same_height(angle):
    along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    normal = np.array([-along[1], along[0]])
    ghosts = boundary(line((0.3, 0.4), (0.3 + along[0], 0.4 + along[1]))).ghosts()
    depth, layer = -(ghosts.position - (0.3, 0.4)) @ normal, np.arange(LAYERS) + 0.5
    assert np.abs(depth[:, None] / DX - layer).min(axis=1).max() < 1e-9
    assert len(np.unique(np.round(depth / DX - 0.5))) == LAYERS
    np.testing.assert_allclose(ghosts.mirror - ghosts.position, 2 * depth[:, None] * normal, atol=1e-12)
    np.testing.assert_allclose(ghosts.direction, np.tile(normal, (len(depth), 1)), atol=1e-12)
    assert not ghosts.through_point.any()


def test_a_line_is_prolonged_at_its_free_ends_by_whole_spacings():
    walls = boundary(BED)
    place = walls.ghosts().position / DX - 0.5
    assert np.abs(place - np.round(place)).max() < 1e-9
    assert (place.min(axis=0)[0], place.max(axis=0)[0]) == pytest.approx((-8, 47))
    assert walls.free_ends(0) == (True, True)
    assert walls.elements(0)[2].sum() == pytest.approx(2)


def test_an_end_at_another_wall_is_not_prolonged():
    walls = boundary(line((0, 1), (0, 0), (2, 0)), line((2, 0), (2, 1)))
    assert walls.free_ends(0) == (True, False)
    assert walls.free_ends(1) == (False, True)
    assert walls.edges.max() == pytest.approx(2)


@pytest.mark.parametrize(
    "lines",
    [
        [line((0, 1), (0, 0), (2, 0)), line((2, 0), (2, 1))],
        [line((0, 1), (0, 0)), line((0, 0), (2, 0)), line((2, 0), (2, 1))],
    ],
    ids=["two", "three"],
)
def test_a_tank_of_several_lines_has_the_ghosts_of_one(lines):
    whole, pieces = boundary(TANK).ghosts(), boundary(*lines).ghosts()
    assert len(pieces.position) == len(whole.position)
    a, b = (np.lexsort(np.round(ghosts.position / DX, 6).T) for ghosts in (whole, pieces))
    np.testing.assert_allclose(pieces.position[b], whole.position[a], atol=1e-9)
    np.testing.assert_allclose(pieces.mirror[b], whole.mirror[a], atol=1e-6)
    np.testing.assert_array_equal(pieces.through_point[b], whole.through_point[a])


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (TANK, line(*TANK.points[::-1], fluid="right")),
        (box(0.5, 0.3, 1, 0.8), polygon(*box(0.5, 0.3, 1, 0.8).points[::-1])),
        (box(0.5, 0.3, 1, 0.8, "inside"), polygon(*box(0.5, 0.3, 1, 0.8).points[::-1], fluid="inside")),
    ],
    ids=["left, right", "obstacle", "basin"],
)
def test_the_direction_of_the_points_makes_no_difference(one, other):
    one, other = boundary(one), boundary(other)
    assert one.solid.symmetric_difference(other.solid).area < 1e-12
    a, b = one.ghosts(), other.ghosts()
    rows, others = (np.lexsort(np.round(ghosts.position, 9).T) for ghosts in (a, b))
    for field in ("position", "mirror", "direction", "through_point", "volume"):
        np.testing.assert_allclose(getattr(a, field)[rows], getattr(b, field)[others], atol=1e-9, err_msg=field)
    for number in (0, 1):  # midpoints and normals of the surface
        values = [walls.elements(0)[number] for walls in (one, other)]
        np.testing.assert_allclose(*(np.sort(each.round(9), axis=0) for each in values), atol=1e-9)


@pytest.mark.parametrize("number", [0, 1])
def test_ghosts_belong_to_the_outline_nearest_to_them(number):
    walls = boundary(*WALLS["box in a tank"])
    ghosts = walls.ghosts()
    inside = shapely.contains_xy(Polygon(walls.outlines[1].points), *ghosts.position.T)
    np.testing.assert_array_equal(ghosts.part == number, inside == bool(number))


# --- what they mirror ----------------------------------------------------------------------------------------------


# `_tolerance` from the foot on the other edge, so the corner counts as one of the solid: bisector, and not through it
@pytest.mark.parametrize(
    ("outlines", "corner", "turn"),
    [
        ([TANK], (0, 0), (-1, -1)),
        ([TANK], (2, 0), (1, -1)),
        (WALLS["basin"], (1.8, 0.9), (1, 1)),
        (WALLS["box sunk into a bed"], (0.5, 0.2), (1, -1)),
        (WALLS["box that stands on a bed"], (0.5, 0), (1, -1)),
        (WALLS["box that stands on a bed"], (1, 0), (-1, -1)),
        (WALLS["box in a corner"], (0, 0.5), (-1, -1)),
        (WALLS["step"], (1, 0.2), (1, -1)),
    ],
)
def test_ghosts_at_a_corner_of_the_fluid_mirror_through_it(outlines, corner, turn):
    ghosts = boundary(*outlines).ghosts()
    chosen = beyond(ghosts, corner, turn) & (np.linalg.norm(ghosts.position - corner, axis=1) < REACH)
    assert chosen.sum() == 13
    np.testing.assert_allclose(ghosts.mirror[chosen], 2 * np.array(corner) - ghosts.position[chosen], atol=1e-5 * DX)
    way = ghosts.mirror[chosen] - ghosts.position[chosen]
    along = way / np.linalg.norm(way, axis=1)[:, None]
    np.testing.assert_allclose(ghosts.direction[chosen], along, atol=1e-5)
    assert ghosts.through_point[chosen].all()


def test_ghosts_behind_a_face_do_not_mirror_through_a_point():
    ghosts = boundary(TANK).ghosts()
    corners = beyond(ghosts, (0, 0), (-1, -1)) | beyond(ghosts, (2, 0), (1, -1))
    np.testing.assert_array_equal(ghosts.through_point, corners)


@pytest.mark.parametrize("outlines", [WALLS["box"], WALLS["box sunk into a bed"]], ids=["box", "sunk"])
def test_where_two_faces_of_an_obstacle_are_equally_near_ghosts_mirror_along_the_bisector(outlines):
    ghosts, corner = boundary(*outlines).ghosts(), np.array([0.5, outlines[-1].points[-1][1]])
    arm = ghosts.position - corner
    tie = (np.abs(arm[:, 0] + arm[:, 1]) < 1e-9) & (np.abs(arm) < REACH).all(axis=1)
    assert tie.sum() == LAYERS
    np.testing.assert_allclose(ghosts.mirror[tie], corner - arm[tie], atol=1e-9)
    np.testing.assert_allclose(ghosts.direction[tie], np.tile([-math.sqrt(0.5), math.sqrt(0.5)], (LAYERS, 1)), atol=1e-9)
    assert not ghosts.through_point[tie].any()


def test_a_slight_bend_is_no_corner():
    """Below 20 degrees the line is round: the tangential velocity stays."""
    bend = boundary(line((0, 0.2), (1, 0.2), (2, 0.2 + math.tan(math.radians(15))))).ghosts()
    assert not bend.through_point.any()
    assert boundary(line((0, 0.2), (1, 0.2), (2, 0.2 + math.tan(math.radians(25))))).ghosts().through_point.any()


@pytest.mark.parametrize("name", WALLS)
def test_no_ghost_mirrors_a_point_of_a_solid(name):
    walls = boundary(*WALLS[name])
    ghosts = walls.ghosts()
    assert len(ghosts.mirror) > 50
    assert np.isfinite(ghosts.mirror).all()
    assert not shapely.contains_xy(walls.solid.buffer(-1e-4 * DX), *ghosts.mirror.T).any()
    np.testing.assert_allclose(np.linalg.norm(ghosts.direction, axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize("name", WALLS)
def test_a_mirror_point_is_no_farther_from_the_wall_than_its_ghost_but_across_a_corner_of_the_solid(name):
    walls = boundary(*WALLS[name])
    ghosts = walls.ghosts()
    depth, height = heights(ghosts.position, walls.edges), heights(ghosts.mirror, walls.edges)
    along = (ghosts.direction * (ghosts.mirror - ghosts.position)).sum(axis=1)
    assert (depth > (0.5 - 1e-6) * DX).all()
    assert (depth < REACH).all()
    assert (along >= depth - 1e-4 * DX).all()
    far = height > depth + 1e-4 * DX
    vertices = np.concatenate([outline.points for outline in walls.outlines.values()])
    middle = 0.5 * (ghosts.mirror + ghosts.position)[far]
    assert (np.linalg.norm(middle[:, None] - vertices, axis=2).min(axis=1) < 1e-4 * DX).all()


def test_ghosts_of_a_channel_mirror_up_to_its_middle():
    """Three spacings wide: ghosts deeper than half of that have their mirror points half-way to the facing wall."""
    ghosts = boundary(*WALLS["narrow tank"]).ghosts()
    x, y = ghosts.position.T
    left = (x < 0) & (y > 0)
    np.testing.assert_allclose(ghosts.mirror[left, 0], np.minimum(-x[left], 0.075), atol=1e-9)
    np.testing.assert_allclose(ghosts.mirror[left, 1], y[left])
    right = (x > 0.15) & (y > 0)
    np.testing.assert_allclose(ghosts.mirror[right, 0], np.maximum(0.3 - x[right], 0.075), atol=1e-9)


def test_ghosts_of_a_v_mirror_up_to_half_of_the_way_to_its_other_side():
    """At the distance r from the apex of a V of 30 degrees that way is r tan 30."""
    outline = vee(30)
    ghosts, apex = boundary(outline).ghosts(), np.array(outline.points[1])
    face = ~ghosts.through_point & (ghosts.position[:, 0] < apex[0])
    along = np.array(outline.points[0]) - apex
    along /= np.linalg.norm(along)
    r, s = (ghosts.position[face] - apex) @ along, heights(ghosts.position[face], boundary(outline).edges)
    foot = apex + r[:, None] * along
    way = np.linalg.norm(ghosts.mirror[face] - foot, axis=1)
    np.testing.assert_allclose(way, np.minimum(s, 0.5 * r * TAN30), atol=1e-9)
    assert (way < 0.9 * s).sum() > 5


def test_ghosts_below_an_acute_corner_mirror_along_its_bisector():
    outline = vee(30)
    ghosts, apex = boundary(outline).ghosts(), np.array(outline.points[1])
    assert ghosts.through_point.sum() > 5
    arm = ghosts.mirror[ghosts.through_point] - apex
    depth = np.linalg.norm(ghosts.position[ghosts.through_point] - apex, axis=1)
    inside = np.abs(np.arctan2(arm[:, 0], arm[:, 1])) < math.radians(15) + 1e-9
    assert inside.all()
    np.testing.assert_allclose(np.linalg.norm(arm, axis=1), depth, rtol=1e-6)


# --- walls that touch ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "foot"), [("box sunk into a bed", 0.2), ("box that stands on a bed", 0.0)], ids=["sunk", "standing"]
)
def test_a_bed_and_the_box_on_it_have_no_wetted_edge_between_them(name, foot):
    walls = boundary(*WALLS[name])
    points, _, lengths = walls.elements(0)
    on_bed = np.abs(points[:, 1] - foot) < 1e-6
    assert lengths[on_bed].sum() == pytest.approx(1.5, abs=1e-5)
    assert not ((points[on_bed, 0] > 0.5) & (points[on_bed, 0] < 1)).any()
    points, normals, lengths = walls.elements(1)
    assert lengths.sum() == pytest.approx(2 * (0.5 - foot) + 0.5, abs=1e-5)
    assert points[:, 1].min() > foot
    assert normals[:, 1].min() > -1e-9
    middle = walls.edges.mean(axis=1)
    assert not ((middle[:, 0] > 0.51) & (middle[:, 0] < 0.99) & (middle[:, 1] < foot + 1e-6)).any()


@pytest.mark.parametrize(
    ("name", "foot"), [("box sunk into a bed", 0.2), ("box that stands on a bed", 0.0)], ids=["sunk", "standing"]
)
def test_the_foot_of_a_box_is_a_corner_of_the_fluid_and_its_top_is_none(name, foot):
    walls = boundary(*WALLS[name])
    inner = walls.inner_ends()
    for x, y, expected in ((0.5, foot, True), (1, foot, True), (0.5, 0.5, False), (1, 0.5, False)):
        at = np.linalg.norm(walls.edges - (x, y), axis=2) < 1e-4 * DX
        assert at.sum() == 2
        assert (inner[at] == expected).all()


def test_inner_ends_are_those_in_corners_of_the_fluid():
    np.testing.assert_array_equal(boundary(TANK).inner_ends(), [[False, True], [True, True], [True, False]])
    assert boundary(*WALLS["basin"]).inner_ends().all()
    assert not boundary(*WALLS["box"]).inner_ends().any()
    assert not boundary(line((0, 0.2), (1, 0.2), (2, 0.2))).inner_ends().any()
    np.testing.assert_array_equal(boundary(*WALLS["step"]).inner_ends(), [[False, True], [True, False], [False, False]])


# --- the wetted surface --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", WALLS)
def test_the_surface_is_made_of_short_pieces_with_unit_normals_into_the_fluid(name):
    walls = boundary(*WALLS[name])
    for number in walls.outlines:
        points, normals, lengths = walls.elements(number)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-12)
        assert lengths.max() <= 1.5 * DX
        assert heights(points, walls.edges).max() < 1e-9
        off = 1e-3 * DX * normals
        assert not shapely.contains_xy(walls.solid, *(points + off).T).any()
        assert shapely.contains_xy(walls.solid, *(points - off).T).all()


@pytest.mark.parametrize(("name", "length"), [("tank", 4.0), ("basin", 4.6), ("box", 2.0), ("beach", 2 + math.hypot(1, TAN30))])
def test_lengths_of_the_surface_add_up_to_the_wetted_length(name, length):
    assert boundary(*WALLS[name]).elements(0)[2].sum() == pytest.approx(length)


@pytest.mark.parametrize("name", CLOSED)
def test_a_constant_pressure_does_not_push_a_closed_wall(name):
    _, normals, lengths = boundary(*WALLS[name]).elements(0)
    np.testing.assert_allclose(lengths @ normals, 0, atol=1e-12)


def test_a_constant_pressure_pushes_the_bed_down_with_its_length():
    for outline in (TANK, BED, box(0, 0, 2, 1, "inside")):
        points, normals, lengths = boundary(outline).elements(0)
        bed = points[:, 1] < points[:, 1].min() + 1e-9
        np.testing.assert_allclose(-lengths[bed] @ normals[bed], [0, -2], atol=1e-12)


# --- fluid beside walls --------------------------------------------------------------------------------------------


def scattered(walls):
    """Random points of the fluid, and their distances to all wetted edges, shape (n, edges)."""
    points = np.random.default_rng(4).uniform(0, 1.9, (3000, 2))
    points = points[~shapely.contains_xy(walls.solid, *points.T)]
    return points, shapely.distance(shapely.points(points)[:, None], shapely.linestrings(walls.edges))


@pytest.mark.parametrize("name", ["tank", "basin", "box", "beach", "step"])
def test_points_near_a_wall_are_pushed_off_half_a_spacing_and_others_stay(name):
    walls = boundary(*WALLS[name])
    points, distances = scattered(walls)
    of_one = np.sort(distances, axis=1)[:, 1] > DX
    points, before = points[of_one], distances[of_one].min(axis=1)
    pushed = walls.pushed_off(points, 0.5 * DX)
    assert heights(pushed, walls.edges).min() > (0.5 - 1e-9) * DX
    np.testing.assert_array_equal(pushed[before >= 0.5 * DX], points[before >= 0.5 * DX])
    moved = np.linalg.norm(pushed - points, axis=1)
    np.testing.assert_allclose(moved, np.maximum(0.5 * DX - before, 0), atol=1e-12)
    assert (moved > 0).sum() > 10


# other; one that is nearest to a corner of the solid is moved along the normal of a face, not away from the corner
@pytest.mark.parametrize("name", ["tank", "basin", "beach", "wedge of 30 degrees", "box"])
def test_points_at_corners_are_pushed_off_both_walls(name):
    walls = boundary(*WALLS[name])
    points, _ = scattered(walls)
    assert heights(walls.pushed_off(points, 0.5 * DX), walls.edges).min() > (0.5 - 1e-3) * DX


# rounding, the overlay of shapely takes all of the fluid for solid
@pytest.mark.parametrize(
    ("points", "level"),
    [
        (((0, 1), (1, 0.2), (2, 1)), 0.7),
        (((0, 0.3), (0.4, 0), (1, 0.6 * TAN30)), 0.2),
        (((0, 0.3), (0.4, 0), (1, 0.6 * TAN30)), 0.3),
    ],
)
def test_fluid_that_fills_a_trough_is_not_behind_its_faces(points, level):
    left, (x, y), right = points
    sides = [(x + (end - x) * (level - y) / (top - y), level) for end, top in (left, right)]
    walls, fluid = boundary(line(*points), reach=2 * 1.5 * DX), Polygon([sides[0], (x, y), sides[1]])
    assert walls.behind(0, fluid)[0] < 1e-6 * DX**2


def test_fluid_behind_a_wall_is_found_and_what_an_obstacle_takes_of_it_does_not_count():
    walls = boundary(TANK, box(0.5, 0.3, 1, 0.8))
    fluid = Polygon([(0, 0), (2, 0), (2, 0.5), (0, 0.5)])
    assert walls.behind(0, fluid)[0] < 1e-6 * DX**2
    assert walls.behind(1, fluid) == (0.0, None)
    area, place = boundary(line(*TANK.points, fluid="right")).behind(0, Polygon([(0.5, 0), (1, 0), (1, 0.1), (0.5, 0.1)]))
    assert area == pytest.approx(0.05, rel=1e-4)
    assert (place > (0.5, 0)).all()
    assert (place < (1, 0.1)).all()
    assert boundary(WALLS["basin"][0]).behind(0, fluid)[0] == pytest.approx(1 - 1.6 * 0.3, rel=1e-4)
