"""Mirror walls, at rest and moving."""

import math

import numpy as np
import pytest
from helpers import domain_of, images_of, tank, water

from parsph.columns import Grid
from parsph.errors import RunError
from parsph.kernels import KERNELS
from parsph.particles import FIRST_GHOST
from parsph.scene.build import walls_of
from parsph.scene.load import load_scene
from parsph.scene.schema import SILL
from parsph.walls import MirrorWall
from parsph.walls.mirror import LAWS, SLIPS
from parsph.wavemakers import Flap, Oscillation

REACH, GRAVITY = 0.2, (0.0, -9.81)
PLATE = Flap((0.0, 0.0), Oscillation(math.radians(8), 1.7, ramp=0.6))
MOVING = 0.31  # a time at which angle, rate and acceleration of PLATE all differ from zero


def wall(normal, point=(0.0, 0.0), law="hydrostatic", slip="free", bit=1, motion=None):
    return MirrorWall("wall", point, normal, law, slip, bit, motion)


def mirrored(walls, position, velocity=None, density=None, time=0.0, gravity=GRAVITY):
    """Return (images, parents) as {field: array} of particles at `position` inside a large grid."""
    dim = position.shape[1]
    fields = {"position": position, "mass": np.linspace(1, 2, len(position))}
    if velocity is not None:
        fields["velocity"] = velocity
    if density is not None:
        fields["density"] = density
    grid = Grid.around((-2.0,) * dim, (3.0,) * dim, 0.25)
    domain = domain_of(grid, fields, walls, gravity, water(), REACH)
    domain.arrange(time)
    ghosts, parents = images_of(domain)
    p = domain.particles
    names = ("position", "velocity", "density", "pressure", "mass")
    pick = {name: p.field(name, slice(None)) for name in names}
    return ({n: a[ghosts] for n, a in pick.items()}, {n: a[parents] for n, a in pick.items()}, p.tags[ghosts])


def cloud(count=40, low=0.01, high=0.99, seed=2):
    """Random particles in a strip right of x = 0, with velocities and densities."""
    rng = np.random.default_rng(seed)
    position = np.stack([rng.uniform(low, 0.19, count), rng.uniform(low, high, count)], axis=1)
    return position, rng.normal(0, 1, (count, 2)), rng.uniform(980, 1030, count)


def plate():
    """Normal into the fluid and the direction up along PLATE's plate at the time MOVING."""
    angle = PLATE.signal.at(MOVING)[0]
    return np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])


def beside_plate(count=40):
    """Random particles within reach of the plate at the time MOVING, away from the bed."""
    position, velocity, density = cloud(count, low=0.02, high=0.8)
    normal, up = plate()
    distance, along = position[:, :1] * 0.9, position[:, 1:] + 0.3
    return along * up + distance * normal, velocity, density


@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.parametrize("side", [((1.0, 0.0), (0.0, 0.0)), ((-1.0, 0.0), (0.2, 0.0)), ((0.0, 1.0), (0.3, 0.0))])
def test_mirror_is_an_involution(slip, side):
    """The image of an image is the particle again: mirror at the same plane, seen from the other side."""
    normal, point = side
    position, velocity, density = cloud()
    if normal[1]:
        position = position[:, ::-1]
    kinds = {"law": "plain", "slip": slip}
    images, parents, _ = mirrored([wall(normal, point, **kinds)], position, velocity, density)
    assert len(images["position"]) > 10
    other = wall(tuple(-n for n in normal), point, **kinds)
    again, _, _ = mirrored([other], images["position"], images["velocity"], images["density"])
    order, expected = np.argsort(again["position"][:, 1]), np.argsort(parents["position"][:, 1])
    for name in ("position", "velocity", "density"):
        np.testing.assert_allclose(again[name][order], parents[name][expected], rtol=0, atol=1e-12, err_msg=name)
    assert len(again["position"]) == len(images["position"])


def test_mirror_along_the_bed_is_an_involution_at_an_inclined_plate():
    position, _, _ = beside_plate()
    images, parents, _ = mirrored([wall((1.0, 0.0), motion=PLATE)], position, time=MOVING)
    again, _, _ = mirrored([wall((-1.0, 0.0), motion=PLATE)], images["position"], time=MOVING)
    order, expected = np.argsort(again["position"][:, 1]), np.argsort(parents["position"][:, 1])
    np.testing.assert_allclose(again["position"][order], parents["position"][expected], atol=1e-13)


def test_images_stand_where_their_parents_stand_on_the_other_side_and_only_within_reach():
    position = np.array([[0.05, 0.5], [0.19, 0.5], [0.21, 0.5], [0.9, 0.5]])
    images, parents, _ = mirrored([wall((1.0, 0.0))], position)
    np.testing.assert_allclose(np.sort(images["position"][:, 0]), [-0.19, -0.05])
    np.testing.assert_array_equal(images["mass"], parents["mass"])


def test_free_slip_reverses_the_normal_velocity_and_keeps_the_tangential_one():
    images, parents, _ = mirrored([wall((1.0, 0.0))], *cloud())
    np.testing.assert_array_equal(images["velocity"], parents["velocity"] * [-1, 1])


def test_no_slip_reverses_the_whole_velocity():
    images, parents, _ = mirrored([wall((1.0, 0.0), slip="no")], *cloud())
    np.testing.assert_array_equal(images["velocity"], -parents["velocity"])


def plate_motion(position):
    """Velocity and acceleration of the plate's rotation at `position`: leaning to +x by theta turns (x, z) by
    ``v = theta' (z, -x)``, ``a = theta'' (z, -x) - theta'^2 (x, z)``.
    """
    _, rate, acceleration = PLATE.signal.at(MOVING)
    turned = position[:, ::-1] * [1, -1]
    return rate * turned, acceleration * turned - rate**2 * position


@pytest.mark.parametrize("slip", SLIPS)
def test_velocities_of_images_are_relative_to_the_moving_plate(slip):
    """Free slip: ``v - 2 [(v - v_w) . n] n``; no slip: ``2 v_w - v``."""
    images, parents, _ = mirrored([wall((1.0, 0.0), slip=slip, motion=PLATE)], *beside_plate(), time=MOVING)
    v, (v_wall, _), (normal, _) = parents["velocity"], plate_motion(parents["position"]), plate()
    free = v - 2 * ((v - v_wall) @ normal)[:, None] * normal
    np.testing.assert_allclose(images["velocity"], free if slip == "free" else 2 * v_wall - v, atol=1e-13)


@pytest.mark.parametrize("motion", [None, PLATE], ids=["at rest", "moving"])
def test_hydrostatic_images_continue_the_pressure(motion):
    """``p_image - p = rho (g - a_w) . (x_image - x)``, with the density that belongs to it."""
    position, velocity, density = beside_plate() if motion else cloud()
    if not motion:
        position = position[:, ::-1]
    normal = (1.0, 0.0) if motion else (0.0, 1.0)
    images, parents, _ = mirrored([wall(normal, motion=motion)], position, velocity, density, time=MOVING)
    acceleration = plate_motion(parents["position"])[1] if motion else 0.0
    way = images["position"] - parents["position"]
    rise = parents["density"] * ((np.array(GRAVITY) - acceleration) * way).sum(axis=1)
    np.testing.assert_allclose(images["pressure"] - parents["pressure"], rise, rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(images["density"], water().density(images["pressure"]), rtol=1e-14)
    assert np.abs(rise).max() > 1


def test_plain_images_have_the_density_and_pressure_of_their_parents():
    position, velocity, density = cloud()
    images, parents, _ = mirrored([wall((0.0, 1.0), law="plain")], position[:, ::-1], velocity, density)
    np.testing.assert_array_equal(images["density"], parents["density"])
    np.testing.assert_array_equal(images["pressure"], parents["pressure"])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("slip", SLIPS)
def test_images_of_water_at_rest_are_at_rest(law, slip):
    images, _, _ = mirrored([wall((0.0, 1.0), law=law, slip=slip)], cloud()[0])
    assert (images["velocity"] == 0).all()
    assert len(images["velocity"]) > 0


def test_a_right_angled_corner_makes_three_images():
    """One per wall and one across the corner; along one wall there is one, far from both there is none."""
    walls = [wall((1.0, 0.0), bit=1), wall((0.0, 1.0), bit=2)]
    position = np.array([[0.03, 0.07], [0.05, 1.0], [1.0, 0.05], [1.0, 1.0]])
    images, parents, tags = mirrored(walls, position)
    corner = np.isclose(parents["position"], position[0]).all(axis=1)
    expected = {(-0.03, 0.07), (0.03, -0.07), (-0.03, -0.07)}
    assert {tuple(x) for x in np.round(images["position"][corner], 12)} == expected
    assert corner.sum() == 3
    assert len(images["position"]) == 5
    assert len(set(tags)) == 5


def test_a_corner_of_three_walls_makes_seven_images():
    sides = [tuple(np.eye(3)[axis]) for axis in range(3)]
    walls = [MirrorWall("wall", (0.0,) * 3, side, "plain", "free", 1 << k) for k, side in enumerate(sides)]
    images, _, tags = mirrored(walls, np.array([[0.03, 0.05, 0.07]]), gravity=(0.0, 0.0, -9.81))
    signs = 1 - 2 * np.array(list(np.ndindex(2, 2, 2)))[1:]
    assert {tuple(x) for x in np.round(images["position"], 12)} == {tuple(s * (0.03, 0.05, 0.07)) for s in signs}
    assert len(tags) == len(set(tags)) == 7


def test_a_particle_beyond_a_wall_is_named():
    with pytest.raises(RunError, match="particle 1 crossed the wall wall"):
        mirrored([wall((1.0, 0.0))], np.array([[0.05, 0.5], [-1e-6, 0.5]]))


# --- a flap ------------------------------------------------------------------------------------------------------------


def test_images_at_a_leaning_plate_have_the_height_of_their_parents():
    """Mirrored along the bed: reflected squarely, the bed would not map onto itself."""
    images, parents, _ = mirrored([wall((1.0, 0.0), motion=PLATE)], *beside_plate(), time=MOVING)
    np.testing.assert_array_equal(images["position"][:, 1], parents["position"][:, 1])
    middle = 0.5 * (images["position"] + parents["position"])
    np.testing.assert_allclose(middle @ plate()[0], 0, atol=1e-15)


@pytest.mark.parametrize("slip", SLIPS)
def test_a_point_of_the_plate_maps_to_itself_and_moves_with_the_plate(slip):
    """Its mean with its image has the plate's normal velocity, ``theta' s`` at the distance s from the hinge."""
    normal, up = plate()
    along = np.linspace(0.1, 1.0, 9)[:, None]
    position = along * up + 1e-13 * normal
    velocity = np.random.default_rng(3).normal(0, 1, position.shape)
    images, parents, _ = mirrored([wall((1.0, 0.0), slip=slip, motion=PLATE)], position, velocity, time=MOVING)
    assert len(images["position"]) == 9
    np.testing.assert_allclose(images["position"], parents["position"], atol=1e-12)
    mean = 0.5 * (images["velocity"] + parents["velocity"]) @ normal
    distance = np.linalg.norm(parents["position"], axis=1)
    np.testing.assert_allclose(mean, PLATE.signal.at(MOVING)[1] * distance, rtol=1e-10)


def test_the_plate_follows_its_angle():
    moving = wall((1.0, 0.0), motion=PLATE)
    moving.move(MOVING)
    np.testing.assert_allclose(moving.numbers[2:4], plate()[0], atol=1e-15)


# --- walls of some heights ---------------------------------------------------------------------------------------------

HINGE = 0.4
HINGED = Flap((0.0, HINGE), Oscillation(math.radians(12), 1.7))
LEANING = 1.7 / 4  # leans by its amplitude


def flap_over_sill(hinge=HINGE, motion=HINGED):
    """The two walls of a flap that is hinged above the bed."""
    sill = MirrorWall("sill", (0.0, 0.0), (1.0, 0.0), "hydrostatic", "free", 1, span=(-np.inf, hinge))
    flap = MirrorWall("flap", (0.0, 0.0), (1.0, 0.0), "hydrostatic", "free", 2, motion, span=(hinge, np.inf))
    return [sill, flap]


def test_a_wall_mirrors_at_its_heights_alone():
    """The lower end belongs to it, the upper one to the next."""
    some = MirrorWall("wall", (0.0, 0.0), (1.0, 0.0), "plain", "free", 1, span=(0.2, 0.5))
    heights = np.array([0.1, 0.2 - 1e-12, 0.2, 0.35, 0.5 - 1e-12, 0.5, 0.7])
    images, parents, _ = mirrored([some], np.stack([np.full(7, 0.05), heights], axis=1))
    assert sorted(parents["position"][:, 1]) == list(heights[2:5])
    np.testing.assert_array_equal(images["position"], parents["position"] * [-1, 1])
    assert [some.distance((0.05, z)) for z in (0.1, 0.3, 0.5)] == [np.inf, 0.05, np.inf]


def test_each_particle_near_a_hinge_has_one_image_that_of_the_wall_at_its_height():
    """Just below it the sill's, upright; just above it the flap's, which starts from the same line."""
    position = np.array([[0.05, HINGE - 1e-9], [0.05, HINGE + 1e-9], [0.16, HINGE + 0.3], [0.16, HINGE - 0.3]])
    images, parents, tags = mirrored(flap_over_sill(), position, time=LEANING)
    assert len(set(tags % FIRST_GHOST)) == len(tags) == 4
    slope = math.tan(math.radians(12))
    expected = [(-0.05, HINGE), (-0.05, HINGE), (2 * slope * 0.3 - 0.16, HINGE + 0.3), (-0.16, HINGE - 0.3)]
    order = np.lexsort(images["position"].T)
    np.testing.assert_allclose(images["position"][order], np.array(expected)[np.lexsort(np.array(expected).T)], atol=1e-8)
    below = parents["position"][:, 1] < HINGE
    assert (images["velocity"][below] == 0).all()


@pytest.mark.parametrize("hinge", [0.0, HINGE])
@pytest.mark.parametrize("lean", [-12, 12])
def test_fluid_and_images_fill_the_space_at_a_leaning_flap(hinge, lean):
    """The kernel's sum over both is that beside an upright wall, one to a few per mille: above the sill, and in the corner
    of a flap that is hinged at the bed.
    """
    dx, h = 0.02, 0.04
    slope = math.tan(math.radians(lean))
    x, z = (axis.ravel() for axis in np.meshgrid(dx * (np.arange(40) + 0.5), dx * (np.arange(-30, 70) + 0.5)))
    inside = z > 0 if hinge == 0 else z > -1
    position = np.stack([x + slope * np.maximum(z - hinge, 0.0), z], axis=1)[inside]
    motion = Flap((0.0, hinge), Oscillation(math.radians(abs(lean)), 1.7))
    walls = flap_over_sill(hinge, motion)
    if hinge == 0:
        walls = [walls[1], wall((0.0, 1.0), bit=4)]
    images, _, _ = mirrored(walls, position, time=LEANING if lean > 0 else 3 * LEANING)
    everything = np.concatenate([position, images["position"]])
    near = (position[:, 0] < 0.25) & (position[:, 1] > max(hinge - 0.2, 0.0)) & (position[:, 1] < hinge + 0.3)
    apart = np.linalg.norm(position[near][:, None] - everything, axis=2)
    sums = dx**2 * KERNELS["wendland-c2"].value(apart, h, 2).sum(axis=1)
    assert near.sum() > 100
    assert np.abs(sums - 1).max() < 0.004


def test_a_flap_in_three_dimensions_mirrors_as_in_two_at_any_place_across():
    position, velocity, density = beside_plate(12)
    flat, _, _ = mirrored([wall((1.0, 0.0), motion=PLATE)], position, velocity, density, time=MOVING)
    plate = MirrorWall("wall", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "hydrostatic", "free", 1, PLATE)
    across = np.linspace(0.1, 0.9, 12)
    fields = [np.stack([part[:, 0], across * scale, part[:, 1]], axis=1) for part, scale in ((position, 1), (velocity, 0))]
    solid, parents, _ = mirrored([plate], *fields, density, time=MOVING, gravity=(0.0, 0.0, -9.81))
    order = [np.argsort(images["position"][:, -1]) for images in (flat, solid)]
    for name in ("position", "velocity"):
        np.testing.assert_allclose(solid[name][order[1]][:, [0, 2]], flat[name][order[0]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(solid["pressure"][order[1]], flat["pressure"][order[0]], rtol=1e-10)
    np.testing.assert_array_equal(solid["position"][:, 1], parents["position"][:, 1])
    assert len(solid["position"]) == 12


def test_the_left_wall_of_a_scene_stands_still_below_a_hinge():
    wave = {"kind": "oscillation", "stroke": 0.01, "period": 1.0}
    maker = {"kind": "flap", "wave": wave}
    low, high = walls_of(load_scene(tank(wavemaker={**maker, "hinge": 0.08})))[:2]
    assert (low.name, low.span, low.motion) == (SILL, (-np.inf, 0.08), None)
    assert (high.name, high.span, high.motion.hinge) == ("left", (0.08, np.inf), (0.0, 0.08))
    assert len({wall.bit for wall in walls_of(load_scene(tank(wavemaker={**maker, "hinge": 0.08})))}) == 4
    for keys in (maker, {**maker, "hinge": -0.2}, {"kind": "piston", "wave": wave}):
        walls = walls_of(load_scene(tank(wavemaker=keys)))
        assert [wall.name for wall in walls] == ["left", "right", "bottom"]
        assert walls[0].span == (-np.inf, np.inf)
        assert [wall.motion is None for wall in walls] == [False, True, True]
