"""Periodic axes: copies beyond the ends and in corners, what comes in, what gauges see there, and what scenes may say.

Those of the vertical alone are in test_channels.py; several ranks in mpi/test_periodic_slabs.py.
"""

import itertools
import math

import numpy as np
import pytest
from helpers import domain_of, images_of, jittered_lattice, tank, water

from parsph.columns import Grid
from parsph.errors import RunError, SceneError
from parsph.io.gauges import LevelGauge, gathered
from parsph.kernels import KERNELS
from parsph.particles import FIRST_FIXED, IMAGE_SHIFT
from parsph.scene.build import borders_of, build, walls_of
from parsph.scene.load import load_scene
from parsph.scene.plan import print_plan
from parsph.sweep import Sweep
from parsph.terms import VISCOSITIES, Terms
from parsph.walls import MirrorWall, PeriodicBorder

REACH, SIZE = 0.2, (1.0, 0.9, 0.5)
FREE = {
    "domain": {"size": [0.4, 0.2], "gravity": 0.0, "periodic": ["x", "up"]},
    "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [0.4, 0.2], "pressure": 0.0}]},
    "numerics": {"dx": 0.02, "c0": 20.0, "viscosity": "newtonian", "nu": 1e-3},
    "time": {"end": 0.3},
}
BED = tank(
    domain={"size": [0.4, 0.3], "gravity": 9.81, "periodic": ["x"]},
    fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.4, 0.2]}]},
    walls={"bottom": {}},
)
BASIN = tank(
    domain={"size": [0.3, 0.2, 0.2], "periodic": ["y", "x"]},
    fluid={"blocks": [{"low": [0.0, 0.0, 0.0], "high": [0.3, 0.2, 0.1]}]},
    walls={"bottom": {}},
    numerics={"dx": 0.02, "diffusion": "fourtakas", "viscosity": "monaghan"},
)


def endless(fields, axes, size, **options):
    """Return a domain that is periodic along these axes."""
    dim = len(size)
    borders = [PeriodicBorder(axis, 0.0, size[axis], (1 << 2 * axis, 2 << 2 * axis)) for axis in axes]
    grid = Grid.around((0.0,) * dim, size, REACH)
    return domain_of(grid, fields, reach=REACH, box=((0.0,) * dim, size), borders=borders, **options)


def scattered(dim, count=400, seed=3):
    """Random particles in the box."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(0, 1, (count, dim)) * SIZE[:dim]
    return {"position": position, "velocity": rng.normal(0, 1, position.shape), "mass": rng.uniform(1, 2, count)}


@pytest.mark.parametrize(("dim", "axes"), [(1, (0,)), (2, (0,)), (2, (0, 1)), (3, (0, 1)), (3, (0, 2)), (3, (0, 1, 2))])
def test_copies_are_all_translations_that_reach_the_domain(dim, axes):
    """By a period along each axis or several at once, each once, with all that a particle carries."""
    fields, size = scattered(dim), np.array(SIZE[:dim])
    domain = endless(fields, axes, SIZE[:dim])
    domain.arrange(0.0)
    images, parents = images_of(domain)
    p, position, expected = domain.particles, fields["position"], []
    near = {1: position < REACH, -1: size - position < REACH, 0: np.ones(position.shape, bool)}
    for ways in itertools.product((-1, 0, 1), repeat=dim):
        if any(ways) and all(way == 0 or d in axes for d, way in enumerate(ways)):
            chosen = np.logical_and.reduce([near[way][:, d] for d, way in enumerate(ways)])
            expected += (position[chosen] + np.array(ways) * size).tolist()
    assert sorted(p.field("position", images).reshape(-1, dim).tolist()) == sorted(expected)
    assert len(np.unique(p.tags[images])) == len(expected) > 50
    for name in ("velocity", "density", "pressure", "mass"):
        np.testing.assert_array_equal(p.field(name, images), p.field(name, parents))


def rates(domain, sweep):
    """Return acceleration and density rate in the order of numbers."""
    domain.arrange(0.0)
    p = domain.particles
    sweep(p, domain.starts, domain.slab, 1, domain.grid.columns + 1)
    rows = p.fluid[np.argsort(p.tags[p.fluid])]
    return p.acceleration[rows], p.density_rate[rows]


def viscous_sweep():
    return Sweep(KERNELS["wendland-c2"], Terms(viscosity=VISCOSITIES["monaghan"]), 2, REACH / 2, 1000.0, 20.0, (0, 0), 0.1)


def stirred(position, seed=9):
    """Return fields of particles at `position`, with velocities and densities of their own."""
    rng = np.random.default_rng(seed)
    density = 1000.0 * rng.uniform(0.98, 1.02, len(position))
    velocity = rng.normal(0, 1, position.shape)
    return {"position": position, "velocity": velocity, "density": density, "pressure": water().pressure(density)}


def test_rates_are_those_of_a_row_of_copies():
    """Three periods side by side on a bed that mirrors them, the middle one compared."""
    fields, count = stirred(scattered(2)["position"]), 400
    row = {name: np.concatenate([values] * 3) for name, values in fields.items()}
    row["position"][:count, 0] -= SIZE[0]
    row["position"][2 * count :, 0] += SIZE[0]
    bed = [MirrorWall("bottom", (0.0, 0.0), (0.0, 1.0), "plain", "no", 64)]
    whole = domain_of(Grid.around((-1.0, 0.0), (2.0, SIZE[1]), REACH), row, walls=bed, reach=REACH)
    mine = endless(fields, (0,), SIZE[:2], walls=bed)
    for one, other in zip(rates(mine, viscous_sweep()), rates(whole, viscous_sweep()), strict=True):
        np.testing.assert_allclose(one, other[count : 2 * count], rtol=0, atol=1e-11 * np.abs(other).max())


@pytest.mark.parametrize("way", [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (0.17, 0.93)])
def test_a_shifted_flow_has_the_same_forces(way):
    """There is no place like any other: the same particles, moved by a part of the periods and round the ends."""
    size = 1.0, 0.9
    fields = stirred(jittered_lattice(2, (20, 18), 0.05) % size)
    shifted = {**fields, "position": (fields["position"] + np.array(way) * size) % size}
    found = [rates(endless(each, (0, 1), size), viscous_sweep()) for each in (fields, shifted)]
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-11 * np.abs(one).max())


@pytest.mark.parametrize("x", [-1e-20, -1e-9, -0.05, 1.0, 1.00001, 1.05])
def test_what_leaves_at_one_end_of_x_comes_in_at_the_other(x):
    domain = endless({"position": np.array([[x, 0.4]])}, (0,), (1.0, 0.9))
    domain.arrange(0.0)
    ((inside, z),) = domain.particles.field("position", domain.particles.fluid)
    assert 0 <= inside < 1.0
    assert (inside, z) == (pytest.approx(0.0 if x == -1e-20 else x % 1.0, abs=1e-15), 0.4)


@pytest.mark.parametrize("x", [math.nan, math.inf, -1.1, 2.3])
def test_what_is_farther_than_a_period_away_is_lost(x):
    domain = endless({"position": np.array([[0.5, 0.4]])}, (0,), (1.0, 0.9))
    domain.particles.shared[0, 0] = x
    with pytest.raises(RunError, match="particle 0 left the domain"):
        domain.arrange(0.0)


@pytest.mark.parametrize("integrator", ["verlet", "midpoint", "adams-bashforth"])
def test_a_uniform_flow_goes_round_as_through_space(integrator):
    """Rigidly, round the ends of x and of the vertical several times, with the neighbours and densities that it had."""
    simulation = build(load_scene(FREE, {"numerics.integrator": integrator}))
    start, speed = simulation.field("position")[np.argsort(simulation.field("id"))], np.array([5.0, -3.0])
    p = simulation.particles
    p.view("velocity")[p.fluid] = speed
    simulation.run()
    np.testing.assert_allclose(simulation.field("velocity"), [speed] * 200, atol=1e-9)
    np.testing.assert_allclose(simulation.field("density"), 1000.0, rtol=1e-9)
    position = simulation.field("position")[np.argsort(simulation.field("id"))]
    rounds = (start + 0.3 * speed - position) / (0.4, 0.2)
    np.testing.assert_allclose(rounds, np.round(rounds), atol=1e-8)
    assert (np.abs(np.round(rounds)) >= 3).all()
    assert ((position >= 0) & (position < (0.4, 0.2))).all()


def test_water_on_a_bed_does_not_feel_the_ends():
    """It settles by its weight, each column of particles alike, and nothing drives it along."""
    simulation = build(load_scene(BED, {"time.end": 0.05}))
    simulation.run()
    velocity = simulation.field("velocity")[np.argsort(simulation.field("id"))].reshape(40, 20, 2)
    assert np.abs(velocity[..., 1]).max() > 1e-5
    np.testing.assert_allclose(velocity[..., 0], 0.0, atol=1e-10)
    np.testing.assert_allclose(velocity[..., 1], velocity[:1, :, 1].repeat(40, axis=0), atol=1e-10)


def test_a_column_of_water_is_there_where_the_vertical_has_ends():
    """Compressed by its own weight, with the sound speed of its depth, whatever the horizontal does."""
    scene, closed = load_scene(BED), load_scene({**BED, "domain": {"size": [0.4, 0.3]}, "walls": tank()["walls"]})
    assert (scene.rho0, scene.c0) == (closed.rho0, closed.c0)
    assert scene.rho0 < scene.fluid.rho0
    assert load_scene(FREE).rho0 == 1000.0


def test_a_hump_on_shallow_water_goes_round():
    """Out at the right end, in at the left one, where a gauge reads its crest; after a period it is where it began."""
    length, speed = 60.0, math.sqrt(9.81)
    keys = {"low": [0.0], "high": [length], "depth": 1.0, "initial": "pulse", "amplitude": 0.01, "center": 30.0, "width": 6.0}
    period = length / speed
    overrides = {"domain.size": [length], "domain.periodic": ["x"], "fluid.blocks": [keys], "walls": {}, "damping": []}
    gauges = [{"kind": "level", "x": x, "every": period / 100} for x in (0.0, 30.0)]
    simulation = build(
        load_scene("swe-pulse", {**overrides, "time.end": period, "gauges": gauges, "output.snapshots.every": 1.0})
    )
    simulation.run()
    end, middle = (gauge.record() for gauge in simulation.observers)
    assert end[np.argmax(end[:, 1]), 0] == pytest.approx(0.5 * period, rel=0.02)
    for gauge in (end, middle):
        assert gauge[:, 1].max() == pytest.approx(1.01, abs=5e-4)
    assert middle[-1, 1] == pytest.approx(1.01, abs=1e-3)
    assert end[-1, 1] == pytest.approx(1.0, abs=1e-3)


# --- gauges --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("keys", "places"), [(BED, [(0.0,), (0.2,)]), (BASIN, [(0.0, 0.0), (0.16, 0.0), (0.0, 0.1), (0.16, 0.1)])]
)
def test_level_gauges_see_across_the_ends(keys, places):
    simulation = build(load_scene(keys))
    simulation.domain.arrange(0.0)
    dim = len(places[0]) + 1
    sides = ((-math.inf,) * (dim - 1) + (0.0,), (math.inf,) * dim)
    levels = [LevelGauge("", 1.0, place, sides).measure(simulation)[0] for place in places]
    assert levels[0] == pytest.approx(keys["fluid"]["blocks"][0]["high"][-1], abs=0.02)
    np.testing.assert_allclose(levels, levels[0], rtol=0, atol=1e-12)


def test_pressures_and_forces_are_seen_across_the_ends():
    """Alike at the ends and in the middle, since the densities repeat from there on."""
    points = [{"kind": "pressure", "point": [x, 0.05], "every": 1.0} for x in (0.0, 0.2, 0.4)]
    simulation = build(load_scene(BED, {"gauges": [*points, {"kind": "force", "wall": "bottom", "every": 1.0}]}))
    p = simulation.particles
    x, z = p.field("position", p.fluid).T
    p.view("density")[p.fluid, 0] *= 1 + 0.001 * np.cos(10 * math.pi * x) * z
    simulation.domain.arrange(0.0)
    *pressures, (_, force, _) = (gauge.measure(simulation) for gauge in simulation.observers)
    np.testing.assert_allclose(pressures, [pressures[0]] * 3, rtol=1e-10)
    assert pressures[0][0] == pytest.approx(1000 * 9.81 * 0.15, rel=0.2)
    assert force == pytest.approx(-1000 * 9.81 * 0.2 * 0.4, rel=0.02)


@pytest.mark.parametrize(("low", "high"), [(-0.08, 0.08), (0.32, 0.48), (0.3, 0.39), (-0.08, 0.48), (0.1, 0.2)])
@pytest.mark.parametrize("way", [0.06, -0.06])
def test_what_came_in_after_the_sort_is_seen(way, low, high):
    simulation = build(load_scene(FREE))
    p, domain = simulation.particles, simulation.domain
    domain.arrange(0.0)
    p.shared[p.fluid, 0] += way
    domain.keep_inside(0.0)
    position = simulation.field("position")
    expected = []
    for ways in itertools.product((-1, 0, 1), repeat=2):
        moved = position + np.array(ways) * (0.4, 0.2)
        near = ((moved > -0.08) & (moved < (0.48, 0.28))).all(axis=1) & (moved[:, 0] > low) & (moved[:, 0] < high)
        expected += moved[near].tolist()
    found, mass, _ = gathered(simulation, low, high)
    assert len(mass) == len(expected) > 40
    np.testing.assert_allclose(sorted(found.round(9).tolist()), sorted(np.round(expected, 9).tolist()), atol=1e-9)


# --- scenes --------------------------------------------------------------------------------------------------------


def test_bits_of_copies_are_their_own_beside_a_flap_with_a_sill():
    keys = {
        **BASIN,
        "domain": {"size": [0.3, 0.2, 0.2], "periodic": ["y"]},
        "walls": {"left": {}, "right": {}, "bottom": {}},
        "wavemaker": {"hinge": 0.04, "wave": {"kind": "oscillation", "angle": 3.0, "period": 1.0}},
    }
    scene = load_scene(keys)
    walls = walls_of(scene)
    bits = [wall.bit for wall in walls] + [bit for border in borders_of(scene) for bit in border.bits]
    assert len(walls) == 4
    assert len(set(bits)) == len(bits) == 6
    assert sum(bits) << IMAGE_SHIFT < FIRST_FIXED


def test_borders_are_in_the_order_of_the_axes_whatever_the_scene_says():
    scene = load_scene(BASIN)
    assert [(border.axis, border.low, border.high) for border in borders_of(scene)] == [(0, 0.0, 0.3), (1, 0.0, 0.2)]


def test_plan_names_each_periodic_axis(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    print_plan(load_scene(BASIN), "basin")
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "periodic x, every 0.3 m" in text
    assert "periodic y, every 0.2 m" in text


POLYGON = {"points": [[0.1, 0.3], [0.1, 0.0]], "fluid": "right"}
FAULTS = {
    "a left wall": (BED, {"walls.left": {}}, "walls.left: there is no such side; x is periodic; leave it out"),
    "a right wall": (BED, {"walls.right": {}}, "walls.right: there is no such side; x is periodic"),
    "a front wall": (BASIN, {"walls.front": {}}, "walls.front: there is no such side; y is periodic"),
    "a wavemaker": (
        BED,
        {"wavemaker": {"wave": {"kind": "oscillation", "angle": 3.0, "period": 1.0}}},
        "wavemaker: there is no end to stand at; x is periodic; leave it out",
    ),
    "a layer": (BED, {"damping": [{"length": 0.1}]}, "damping: there is no end to stand at; x is periodic"),
    "a relaxation zone": (
        BED,
        {"relaxation": [{"length": 0.1, "height": 0.01, "period": 0.5}]},
        "relaxation: there is no end to stand at; x is periodic",
    ),
    "a polygon": (BED, {"walls.polygons": [POLYGON]}, "walls.polygons: cannot be where x is periodic"),
    "ghosts": (BED, {"walls.treatment": "ghosts"}, "walls.treatment: cannot be where x is periodic"),
    "too short": (BED, {"domain.size": [0.07, 0.3]}, "domain.size: 0.07 m are too few; a particle would meet another and its "),
    "too narrow": (BASIN, {"domain.size": [0.3, 0.1, 0.2]}, "a width of at least 0.16 m, two supports of the kernel"),
    "y in 2D": (BED, {"domain.periodic": ["y"]}, "domain.periodic: there is no y in 2D; leave it out"),
    "up in 1D": (
        "swe-pulse",
        {"domain.periodic": ["up"]},
        "domain.periodic: there is no up in 1D; leave it out",
    ),
    "x twice": (BED, {"domain.periodic": ["x", "x"]}, 'domain.periodic: names an axis twice; ["x"]'),
    "a layer in 1D": ("swe-pulse", {"domain.periodic": ["x"], "walls": {}}, "damping: there is no end to stand at"),
    "no pressure where all is periodic": (
        BED,
        {"domain.periodic": ["x", "up"], "walls": {}},
        "fluid.blocks.0.pressure: is missing",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_what_does_not_fit_periodic_axes_is_refused(name):
    source, overrides, text = FAULTS[name]
    with pytest.raises(SceneError) as caught:
        load_scene(source, overrides)
    assert text in str(caught.value)
