"""Shallow water in one dimension, the depth as density: rest, pulses, layers and dams against theory."""

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import brentq

from parsph.analysis import reflection_ratio
from parsph.errors import RunError
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.waves import DamBreak, layer_reflection

GRAVITY, DEPTH = 9.81, 2.5
SHALLOW_DENSITIES = ("continuity", "summation")
SPEED = math.sqrt(GRAVITY * DEPTH)
HUMP = {"low": [0.0], "high": [60.0], "depth": DEPTH, "initial": "pulse", "amplitude": 0.02, "center": 20.0, "width": 4.0}


def pond(blocks=(HUMP,), end=4.0, gauges=(), damping=(), **numerics):
    """Return the simulation of a pond from x = 0 to the end of the last block."""
    viscous = {"viscosity": "monaghan", "alpha": 0.5} if numerics.get("h_growth", 1.0) > 1 else {}
    keys = {
        "domain": {"size": [blocks[-1]["high"][0]], "gravity": GRAVITY},
        "fluid": {"blocks": list(blocks)},
        "walls": {"left": {}, "right": {}},
        "numerics": {"state": "shallow", "dx": 0.25, "h_over_dx": 2.5, **viscous, **numerics},
        "time": {"end": end},
        "gauges": list(gauges),
        "damping": list(damping),
    }
    return build(load_scene(keys))


def still(*depths, length=30.0):
    """Return blocks of these depths, side by side."""
    edges = [length * k for k in range(len(depths) + 1)]
    return [{"low": [a], "high": [b], "depth": depth} for (a, b), depth in zip(itertools.pairwise(edges), depths, strict=True)]


def flow(simulation):
    """Return position, depth and velocity from left to right."""
    x = simulation.field("position")[:, 0]
    order = np.argsort(x)
    return x[order], simulation.field("density")[order], simulation.field("velocity")[order, 0]


# --- the scene -----------------------------------------------------------------------------------------------------


def test_numbers_that_follow_from_the_keys():
    """Speeds are those of long waves on the deepest block; the level is its depth unless given."""
    blocks = still(1.0, DEPTH, 0.4)
    keys = {"state": "shallow", "dx": 0.25, "h_over_dx": 2.5, "h_growth": 4.0, "viscosity": "monaghan", "alpha": 0.5}
    scene = load_scene(
        {"domain": {"size": [90.0]}, "fluid": {"blocks": blocks}, "numerics": keys, "time": {"end": 1.0}},
    )
    assert scene.shallow
    assert (scene.rho0, scene.level, scene.depth) == (DEPTH, DEPTH, DEPTH)
    assert scene.c0 == pytest.approx(SPEED)
    assert scene.density_range == (0.0, 2.0)
    assert scene.reach == pytest.approx(2 * 2.5 * 0.25 * 4)
    assert load_scene(scene.model_dump(), {"fluid.level": 1.2}).level == 1.2
    assert load_scene(scene.model_dump(), {"numerics.density_range": [0.5, 3.0]}).density_range == (0.5, 3.0)
    assert not load_scene("still").shallow
    assert load_scene("still").density_range == (0.7, 1.3)


@pytest.mark.parametrize("name", ["swe-pulse", "swe-pulse-infinite", "swe-pulse-reflecting"])
def test_pulse_scenes_are_those_of_the_paper(name):
    """Molteni et al., section 2: X = 500 m, H0 = 1 m, A = 18 m, x0 = 3/4 X; only the ends differ."""
    scene = load_scene(name)
    block = scene.fluid.blocks[0]
    assert (block.depth, block.width, block.center) == (1.0, 18.0, 375.0)
    assert (block.low, block.high) == ([0.0], scene.domain.size)
    assert [zone.density for zone in scene.damping] == ["plain"] * (name == "swe-pulse")
    ends = {"swe-pulse": 550.0, "swe-pulse-infinite": 1000.0, "swe-pulse-reflecting": 500.0}
    assert scene.domain.size == [ends[name]]
    assert (scene.time.end, scene.numerics.dx) == (247.0, 0.5)


@pytest.mark.parametrize("density", SHALLOW_DENSITIES)
def test_it_begins_as_the_scene_says(density):
    """H = H0 + a exp(-(x - x0)^2/A^2), v = (H - H0) sqrt(g/H0); masses are depth times spacing, over the sum of W V."""
    x, depth, velocity = flow(simulation := pond(density=density))
    hump = 0.02 * np.exp(-(((x - 20) / 4) ** 2))
    np.testing.assert_allclose(x, 0.25 * (np.arange(240) + 0.5), rtol=1e-12)
    np.testing.assert_allclose(depth, DEPTH + hump, rtol=1e-14)
    np.testing.assert_allclose(velocity, hump * math.sqrt(GRAVITY / DEPTH), rtol=1e-14)
    away = 0.25 * np.abs(np.arange(-10, 11))
    sums = 0.25 * simulation.sweep.kernel.value(away, 0.625, 1).sum() if density == "summation" else 1.0
    mass = simulation.field("mass")[np.argsort(simulation.field("id"))]
    np.testing.assert_allclose(mass, depth * 0.25 / sums, rtol=1e-13)
    assert sums == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize(
    ("kernel", "h_over_dx", "growth"),
    [
        ("wendland-c2", 1.5, 1.0),
        ("wendland-c2", 2.5, 1.0),
        ("gaussian", 1.33, 1.0),
        ("wendland-c2", 1.5, 8.0),
        ("wendland-c2", 2.5, 8.0),
    ],
)
def test_summation_on_a_lattice_gives_the_depth(kernel, h_over_dx, growth):
    """Beside walls too, out of reach of a step of the bed of another depth; where h grows, up to the tail of the kernel."""
    length = 30.0 if growth == 1 else 120.0
    simulation = pond(
        still(DEPTH, 0.7, length=length), kernel=kernel, h_over_dx=h_over_dx, density="summation", h_growth=growth
    )
    simulation.prepare()
    p = simulation.particles
    x, sums = simulation.field("position")[:, 0], p.density_rate[p.fluid]
    away = np.abs(x - length)
    far = away > simulation.domain.reach
    expected = np.where(x < length, DEPTH, 0.7)
    assert far.sum() > 200
    np.testing.assert_allclose(sums[far], expected[far], rtol=1e-13 if growth == 1 else 1e-7)
    assert np.abs(sums / expected - 1)[~far].max() > 0.1


@pytest.mark.parametrize("value", [6.0, -0.1, math.nan])
def test_a_depth_out_of_range_is_told_as_one(value):
    """Default: from 0 to twice the largest depth."""
    simulation = pond(still(DEPTH))
    simulation.prepare()
    simulation.particles.shared[simulation.particles.fluid[7], 2] = value
    with pytest.raises(
        RunError, match=r"particle 7 at \(1\.875\) m: depth .* m at t = 0 s.*0 to 5 m \(numerics.density_range\)"
    ):
        simulation.evaluate(0.0)


# --- rest and motion -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("growth", [1.0, 8.0])
@pytest.mark.parametrize("density", SHALLOW_DENSITIES)
def test_a_lake_at_rest_stays_at_rest(density, growth):
    """For 30 s, in which a wave crosses it five times."""
    simulation = pond(still(DEPTH), end=30.0, density=density, h_growth=growth)
    simulation.run()
    x, depth, velocity = flow(simulation)
    np.testing.assert_allclose(depth, DEPTH, rtol=1e-10)
    assert np.abs(velocity).max() < 1e-10
    np.testing.assert_allclose(x, 0.25 * (np.arange(120) + 0.5), atol=1e-9)


@pytest.mark.parametrize("integrator", ["verlet", "midpoint"])
@pytest.mark.parametrize("density", SHALLOW_DENSITIES)
def test_a_pulse_travels_with_the_speed_of_long_waves_and_keeps_its_mass(density, integrator):
    """To the right alone, its height as it was, and the energy of its motion as that of its level."""
    gauges = [{"kind": "energy", "every": 0.5}]
    simulation = pond(gauges=gauges, density=density, integrator=integrator)

    def place():
        x, depth, _ = flow(simulation)
        weight = (depth - DEPTH) ** 2
        return float((weight * x).sum() / weight.sum())

    simulation.prepare()
    begin, mass = place(), simulation.field("mass").copy()
    while simulation.time < simulation.end:
        simulation.advance()
    assert place() - begin == pytest.approx(SPEED * 4.0, rel=0.01)
    np.testing.assert_array_equal(np.sort(simulation.field("mass")), np.sort(mass))
    _, depth, velocity = flow(simulation)
    rise, current = depth - DEPTH, velocity * math.sqrt(DEPTH / GRAVITY)
    assert rise.max() == pytest.approx(0.02, rel=0.01)
    assert np.abs(rise - current).max() < 0.02 * 2 * 0.02, "half the difference is what runs to the left"
    energy = simulation.observers[0].record()
    total = energy[:, 2] + energy[:, 4]
    assert np.ptp(total) < 5e-3 * 2 * energy[0, 2]
    assert energy[0, 2] == pytest.approx(0.25 * GRAVITY * 0.02**2 * 4 * math.sqrt(math.pi / 2) * 2, rel=0.02)


@pytest.mark.parametrize("integrator", ["verlet", "midpoint"])
def test_summed_densities_are_never_integrated(integrator):
    """Whatever an evaluation works with is a sum of a moment before, and each step ends with the last sum to the bit."""
    simulation, seen = pond(density="summation", integrator=integrator), []
    evaluate, p = simulation.evaluate, simulation.particles

    def watched(time):
        evaluate(time)
        seen.append(np.abs(p.shared[p.fluid, 2] / p.density_rate[p.fluid] - 1).max())

    simulation.evaluate = watched
    simulation.prepare()
    for _ in range(10):
        simulation.advance()
        np.testing.assert_array_equal(p.shared[p.fluid, 2], p.density_rate[p.fluid])
    assert len(seen) > 10
    assert max(seen) < 2e-3


def test_viscosity_takes_the_energy_of_a_pulse():
    """The figures of the test above could also come of a record that never changes."""
    gauges = [{"kind": "energy", "every": 0.5}]
    simulation = pond(gauges=gauges, viscosity="monaghan", alpha=0.5)
    simulation.run()
    energy = simulation.observers[0].record()
    assert energy[-1, 2] < 0.95 * energy[0, 2]
    assert np.ptp(energy[:, 2] + energy[:, 4]) > 0.05 * 2 * energy[0, 2]


def test_a_gauge_sees_the_pulse_pass():
    """Crest at x0 + c t with the pulse's height; the depth is interpolated between the particles on both sides."""
    simulation = pond(gauges=[{"kind": "level", "x": 30.1, "every": 0.01}])
    simulation.run()
    t, level = simulation.observers[0].record().T
    expected = DEPTH + 0.02 * np.exp(-(((30.1 - 20 - SPEED * t) / 4) ** 2))
    np.testing.assert_allclose(level, expected, atol=0.02 * 0.02)
    assert len(t) == 401


def test_a_gauge_of_depth_interpolates_and_is_0_on_dry_ground():
    """Beside a wall, and at the front, it has the depth of the last particle."""
    blocks = [{**HUMP, "high": [40.0]}]
    keys = [{"kind": "level", "x": x, "name": str(x)} for x in (0.0, 10.0, 20.03, 39.9, 40.3, 59.0)]
    scene = load_scene(
        {
            "domain": {"size": [60.0]},
            "fluid": {"blocks": blocks},
            "walls": {"left": {}},
            "numerics": {"state": "shallow", "dx": 0.25, "h_over_dx": 2.5},
            "time": {"end": 0.0},
            "gauges": keys,
        }
    )
    simulation = build(scene)
    simulation.run()
    x, depth, _ = flow(simulation)
    found = [gauge.record()[0, 1] for gauge in simulation.observers]
    expected = [depth[0], *np.interp([10.0, 20.03, 39.9], x, depth), depth[-1], 0.0]
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    assert found[2] != pytest.approx(found[1], abs=1e-3)


# --- absorbing layers ----------------------------------------------------------------------------------------------

X, CENTER, END = 150.0, 90.0, 56.0  # the basin, where the pulse begins, and when its reflection is back


def particles(simulation):
    """Return what `reflection_ratio` compares."""
    fields = {name: simulation.field(name) for name in ("id", "density", "mass")}
    return {**fields, **{name: simulation.field(name)[:, 0] for name in ("position", "velocity")}}


def reflecting_pulse(length, zones):
    """Return the particles of swe-pulse, shortened, after the pulse has been at the basin's end; `length` of water."""
    overrides = {
        "domain.size": [length],
        "fluid.blocks.0.high": [length],
        "fluid.blocks.0.center": CENTER,
        "damping": zones,
        "time.end": END,
    }
    simulation = build(load_scene("swe-pulse", overrides))
    simulation.run()
    return particles(simulation)


@pytest.fixture(scope="module")
def ends():
    """The runs with a wall and with nothing at the basin's end."""
    return reflecting_pulse(X, []), reflecting_pulse(2 * X, [])


@pytest.mark.parametrize(
    ("zone", "tolerance"),
    [
        ({"length": 20.0, "softening": 1.0}, 1.5),
        ({"length": 50.0, "softening": 1.0}, 1.5),
        ({"length": 20.0, "profile": "power", "exponent": 1, "sigma0": 0.3}, 1.05),
        ({"length": 20.0, "profile": "power", "exponent": 2, "sigma0": 0.3}, 1.05),
        ({"length": 20.0, "profile": "power", "exponent": 4, "sigma0": 0.6}, 1.05),
        ({"length": 10.0, "profile": "power", "exponent": 1, "sigma0": 0.3}, 1.05),
    ],
)
def test_a_layer_that_damps_depth_and_velocity_reflects_as_theory_says(ends, zone, tolerance):
    """R = exp(-(2/c) integral of sigma): within a factor of 1.5 for layers of a few thousandths, else within 5 %."""
    reflecting, infinite = ends
    layer = reflecting_pulse(X + zone["length"], [{"density": "plain", **zone}])
    found = reflection_ratio(layer, reflecting, infinite, GRAVITY, (0.0, X))
    speed = math.sqrt(GRAVITY)
    sigma0 = zone.get("sigma0", speed / zone["length"])
    shape = zone.get("profile", "hyperbolic"), zone.get("exponent", 1), zone.get("softening", 0.0)
    theory = layer_reflection(sigma0, zone["length"], speed, *shape)
    assert theory / tolerance < found < theory * tolerance


def test_a_layer_that_damps_velocities_alone_absorbs_less(ends):
    """It is not matched, and where the wall behind it holds the water there is no velocity to damp."""
    reflecting, infinite = ends
    zone = {"length": 20.0, "profile": "power", "exponent": 1, "sigma0": 0.3}
    found = reflection_ratio(reflecting_pulse(X + 20, [zone]), reflecting, infinite, GRAVITY, (0.0, X))
    assert 3 * layer_reflection(0.3, 20.0, math.sqrt(GRAVITY), "power", 1) < found < 0.95


# --- dams ----------------------------------------------------------------------------------------------------------

WET = 0.1


def stoker(r):
    """Return depth and speed between rarefaction and shock, and the shock's speed, for g = 1, depths 1 and r (Stoker 1957)."""

    def mismatch(depth):
        return 2 * (1 - math.sqrt(depth)) - (depth - r) * math.sqrt((depth + r) / (2 * depth * r))

    middle = brentq(mismatch, r * (1 + 1e-9), 1)
    speed = 2 * (1 - math.sqrt(middle))
    return middle, speed, middle * speed / (middle - r)


def wet_bed(xi):
    """Return the exact depth and velocity at (x - x0)/t, r = 0.1."""
    middle, speed, shock = stoker(WET)
    inside = (xi > -1) & (xi < speed - math.sqrt(middle))
    depth = np.select([xi <= -1, inside, xi < shock], [1.0, (2 - xi) ** 2 / 9, middle], WET)
    return depth, np.select([xi <= -1, inside, xi < shock], [0.0, 2 * (1 + xi) / 3, speed], 0.0)


def dry_bed(xi):
    """Return the exact depth and velocity at (x - x0)/t over dry ground (Ritter 1892)."""
    return np.select([xi <= -1, xi < 2], [1.0, (2 - xi) ** 2 / 9], 0.0), np.select(
        [xi <= -1, xi < 2], [0.0, 2 * (1 + xi) / 3], 0.0
    )


def dam(name, length, end, blocks):
    """Run a dam of half the usual length; return the flow over (x - x0)/t."""
    simulation = build(load_scene(name, {"domain.size": [length], "fluid.blocks": blocks, "time.end": end}))
    mass = simulation.field("mass").sum()
    simulation.run()
    assert simulation.field("mass").sum() == pytest.approx(mass, rel=1e-14)
    x, depth, velocity = flow(simulation)
    return (x - 0.5 * length) / end, depth, velocity


def test_stoker_solves_the_jump_conditions():
    """Mass and momentum across the shock, in its frame, and the invariant u + 2 sqrt(h) across the rarefaction."""
    middle, speed, shock = stoker(WET)
    assert middle * (speed - shock) == pytest.approx(-WET * shock)
    assert middle * (speed - shock) ** 2 + middle**2 / 2 == pytest.approx(WET * shock**2 + WET**2 / 2)
    assert speed + 2 * math.sqrt(middle) == pytest.approx(2)
    assert (middle, speed, shock) == pytest.approx((0.39617, 0.74115, 0.99139), abs=1e-5)


def test_the_exact_solution_of_the_package_is_that_of_this_module():
    """Scaled: depths by 1.7, gravity 9.81."""
    xi, unit = np.linspace(-1.5, 2.5, 400), math.sqrt(9.81 * 1.7)
    for right, exact in ((1.7 * WET, wet_bed), (0.0, dry_bed)):
        dam = DamBreak(1.7, right, 9.81)
        np.testing.assert_allclose(dam.depth(xi * unit * 3.0, 3.0), 1.7 * exact(xi)[0], rtol=1e-9, atol=1e-12)
        assert dam.bore == pytest.approx(unit * (stoker(WET)[2] if right else 2))


def test_dam_break_over_wet_ground():
    """Stoker: 300 particles, 100 s. Depth, velocity, the state between the waves and the place of the shock."""
    blocks = [{"low": [0.0], "high": [150.0], "depth": 1.0}, {"low": [150.0], "high": [300.0], "depth": WET}]
    xi, depth, velocity = dam("swe-dam-break", 300.0, 100.0, blocks)
    middle, speed, shock = stoker(WET)
    h, u = wet_bed(xi)
    assert len(xi) == 300
    assert np.mean(np.abs(depth - h)) < 0.006
    assert np.mean(np.abs(velocity - u)) < 0.012
    plateau = (xi > speed - math.sqrt(middle) + 0.2) & (xi < shock - 0.2)
    np.testing.assert_allclose(depth[plateau], middle, rtol=0.02)
    np.testing.assert_allclose(velocity[plateau], speed, rtol=0.02)
    front = xi[np.flatnonzero(depth > 0.5 * (middle + WET))[-1]]
    assert front == pytest.approx(shock, abs=0.03)


def test_dam_break_over_dry_ground():
    """Ritter: 150 particles, 60 s. At the dam h = 4/9, u = 2/3 at all times; the front never runs ahead of 2 sqrt(g h0)."""
    xi, depth, velocity = dam("swe-dam-break-dry", 300.0, 60.0, [{"low": [0.0], "high": [150.0], "depth": 1.0}])
    h, u = dry_bed(xi)
    assert len(xi) == 150
    assert np.mean(np.abs(depth - h)) < 0.004
    assert np.mean(np.abs(velocity - u)) < 0.004
    assert np.interp(0.0, xi, depth) == pytest.approx(4 / 9, rel=0.015)
    assert np.interp(0.0, xi, velocity) == pytest.approx(2 / 3, rel=0.015)
    assert 1.15 < xi[-1] < 2
    assert (np.diff(depth) < 1e-4).all()
    assert depth.min() > 0
