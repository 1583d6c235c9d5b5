"""Absorbing layers: formulas against numpy, whole runs against their mirror images, and still water."""

import math

import numpy as np
import pytest
from helpers import domain_of, tank, water

from parsph.columns import Grid
from parsph.damping import KILLINGS, PROFILES, SWITCHES, DampingZone, decay, sigma_over_sigma0
from parsph.particles import FIRST_GHOST
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.states import State
from parsph.waves import phase_speed

START, LENGTH, SOFTENING, SIGMA0 = 2.0, 1.0, 0.05, 7.0
NAMES = ("position", "velocity", "density", "mass")


def zone(direction=1, start=START, with_density=False, sigma0=SIGMA0, **options):
    given = {"softening": SOFTENING, "density_factor": 1.0 if with_density else 0.0, "level": 1.0, "weight": 9810.0}
    state = options.pop("state", water().constants)
    return DampingZone(start, direction, LENGTH, sigma0, state, **{**given, **options})


def sample(count=200, seed=4, dim=2):
    """Return particles over 0 < x < 3 with velocities, densities, masses and accelerations."""
    rng = np.random.default_rng(seed)
    fields = {
        "position": rng.uniform(0, 1, (count, dim)) * [3] + [0] * dim,
        "velocity": rng.normal(0, 1, (count, dim)),
        "density": rng.uniform(990, 1030, count),
        "mass": rng.uniform(1, 2, count),
    }
    fields["position"][:, 1:] /= 3
    particles = domain_of(Grid.around((0.0,) * dim, (3.0,) + (1.0,) * (dim - 1), 0.2), fields).particles
    particles.acceleration[: len(particles.tags)] = rng.normal(0, 1, (len(particles.tags), dim))
    return particles


def apply(layer, particles, dt):
    """Damp all rows; return {field: (before, after)}."""
    rows = slice(particles.first, particles.last)
    before = {name: particles.field(name, rows).copy() for name in NAMES}
    layer.act(particles, particles.first, particles.last, 0.0, dt)
    return {name: (before[name], particles.field(name, rows)) for name in NAMES}


def restrained(layer, particles):
    """Weaken the force on all rows; return the accelerations (before, after)."""
    rows = slice(particles.first, particles.last)
    before = particles.acceleration[rows].copy()
    layer.restrain(particles, particles.first, particles.last)
    return before, particles.acceleration[rows]


def hyperbolic(x):
    """Molteni et al., section 2.1: sigma0 (x - x0) / ((x0 + L) - x + 0.5 h)."""
    return SIGMA0 * (x - START) / ((START + LENGTH) - x + SOFTENING)


def left_over(s):
    """What is left after sigma dt = s: exp(-s) to second order."""
    return 1 / (1 + s + s**2 / 2)


# --- the decay over a step -----------------------------------------------------------------------------------------


def test_decay_is_the_exponential_to_second_order():
    """The remainder is s^3/6 to leading order and never more."""
    s = np.geomspace(1e-4, 30, 400)
    error = decay.py_func(s) - np.exp(-s)
    assert (error >= -1e-15).all()
    assert (error <= s**3 / 6 + 1e-15).all()
    assert (decay(1e-2) - math.exp(-1e-2)) / 1e-6 == pytest.approx(1 / 6, rel=0.02)


def test_decay_falls_from_one_and_never_below_zero():
    s = np.concatenate([[0.0], np.geomspace(1e-9, 1e150, 2000)])
    values = np.array([decay(x) for x in s])
    assert values[0] == 1
    assert (np.diff(values) < 0).all()
    assert (values > 0).all()
    assert 0 <= decay(1e300) <= decay(1e150)


def test_many_steps_approach_the_exact_exponential_with_the_square_of_the_step():
    """dv/dt = -sigma v over a tenth of a second in n steps: twice as many leave a fourth of the error."""
    errors = []
    for steps in (1, 2, 4, 8):
        particles = sample()
        start = particles.field("velocity", slice(particles.first, particles.last)).copy()
        for _ in range(steps):
            fields = apply(zone(), particles, 0.02 / steps)
        x, after = fields["position"][0][:, 0], fields["velocity"][1]
        inside = (x > START) & (x < START + 0.8)
        exact = start[inside] * np.exp(-hyperbolic(x[inside]) * 0.02)[:, None]
        errors.append(np.abs(after[inside] - exact).max())
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, rtol=0.2)
    assert errors[0] > 1e-5


@pytest.mark.parametrize("sigma_dt", [1e-6, 1.0, 1e6, 1e300])
@pytest.mark.parametrize("profile", PROFILES)
def test_damping_is_stable_for_any_strength(sigma_dt, profile):
    """It takes energy and never turns a velocity round, however long the step."""
    fields = apply(zone(sigma0=sigma_dt, with_density=True, profile=profile), sample(), 1.0)
    (before, after), (_, density), (_, mass) = fields["velocity"], fields["density"], fields["mass"]
    assert (np.abs(after) <= np.abs(before)).all()
    assert (after * before >= 0).all()
    assert (density > 900).all()
    assert np.isfinite(mass).all()


# --- profiles ------------------------------------------------------------------------------------------------------

SHAPES = {
    "hyperbolic": ({"profile": "hyperbolic"}, lambda depth: depth / (LENGTH - depth + SOFTENING)),
    "softer": ({"profile": "hyperbolic", "softening": 0.3}, lambda depth: depth / (LENGTH - depth + 0.3)),
    **{f"power {m}": ({"profile": "power", "exponent": m}, lambda depth, m=m: (depth / LENGTH) ** m) for m in (1, 2, 3, 20)},
}


def test_every_profile_is_tested():
    assert {shape[0]["profile"] for shape in SHAPES.values()} == set(PROFILES)


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("direction", [1, -1])
def test_velocities_fall_by_the_profile(shape, direction, dim):
    """All components alike: v -> v / (1 + s + s^2/2) with s = sigma(x) dt."""
    dt, start = 0.05, START if direction > 0 else 3.0 - START
    options, ratio = SHAPES[shape]
    fields = apply(zone(direction, start, **options), sample(dim=dim), dt)
    depth, (before, after) = direction * (fields["position"][0][:, 0] - start), fields["velocity"]
    inside = depth > 0
    expected = before[inside] * left_over(SIGMA0 * dt * ratio(depth[inside]))[:, None]
    assert inside.sum() > 30
    np.testing.assert_allclose(after[inside], expected, rtol=1e-12)
    np.testing.assert_array_equal(after[~inside], before[~inside])
    assert np.abs(after - before).max() > 1e-3


def test_numbers_of_the_other_profile_have_no_effect():
    """So that a study may change the profile alone, on a scene that gives the numbers of both."""
    for profile, other in (("hyperbolic", {"exponent": 5}), ("power", {"softening": 0.4})):
        fields = [apply(zone(profile=profile, **more), sample(), 0.05) for more in ({}, other)]
        np.testing.assert_array_equal(fields[0]["velocity"][1], fields[1]["velocity"][1])
    scene = tank(damping=[{"length": 0.05, "softening": 0.003, "exponent": 3}])
    assert load_scene(scene, {"damping.0.profile": "power"}).damping[0].exponent == 3


@pytest.mark.parametrize("shape", SHAPES)
def test_profiles_rise_up_to_the_outer_end_and_stay_finite_beyond(shape):
    """A particle beyond the end is damped as hard as at it, or harder."""
    options, ratio = SHAPES[shape]
    numbers = PROFILES[options["profile"]], LENGTH, options.get("softening", SOFTENING), options.get("exponent", 1)

    def value(depth):
        return sigma_over_sigma0(numbers[0], depth, *numbers[1:])

    assert value(0.0) == 0
    assert value(LENGTH) == pytest.approx(ratio(LENGTH))
    inside = [value(depth) for depth in np.linspace(0, LENGTH, 50)]
    assert (np.diff(inside) > 0).all()
    assert value(LENGTH) <= value(1.2 * LENGTH) < 2 * value(LENGTH)


def test_outer_end_of_the_hyperbolic_profile_is_length_over_softening():
    assert sigma_over_sigma0(PROFILES["hyperbolic"], LENGTH, LENGTH, SOFTENING, 1) == pytest.approx(LENGTH / SOFTENING)


# --- where, and what -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [{}, {"switch": "vx"}, {"profile": "power"}])
def test_nothing_outside_the_layer_changes(options):
    fields = apply(zone(with_density=True, **options), sample(), 0.05)
    outside = fields["position"][0][:, 0] <= START
    assert outside.sum() > 30
    for before, after in fields.values():
        np.testing.assert_array_equal(after[outside], before[outside])
    np.testing.assert_array_equal(*fields["position"])


def test_a_layer_at_the_left_is_the_mirror_image_of_one_at_the_right():
    right, left = sample(), sample()
    left.shared[:, 0] = 3.0 - left.shared[:, 0]
    a = apply(zone(1, START, True), right, 0.05)
    b = apply(zone(-1, 3.0 - START, True), left, 0.05)
    for name in ("velocity", "density", "mass"):
        np.testing.assert_allclose(a[name][1], b[name][1], rtol=1e-12)
    assert zone(-1, 1.0).span == (0.0, 1.0)
    assert zone(1, START).span == (2.0, 3.0)


def test_images_are_neither_damped_nor_restrained():
    particles = sample()
    particles.tags[:] += FIRST_GHOST
    for before, after in apply(zone(with_density=True), particles, 0.05).values():
        np.testing.assert_array_equal(after, before)
    np.testing.assert_array_equal(*restrained(zone(killing="f1"), particles))


def test_rows_that_are_not_asked_for_are_left_alone():
    particles = sample()
    rows = particles.shared.copy()
    middle = particles.first + 100
    zone(with_density=True).act(particles, particles.first, middle, 0.0, 0.05)
    np.testing.assert_array_equal(particles.shared[middle:], rows[middle:])
    assert (particles.shared[:middle] != rows[:middle]).any()


# --- density -------------------------------------------------------------------------------------------------------


def still_density(position, state=None):
    """Hydrostatic density of water with its level at 1 m."""
    return (state or water()).density(9810.0 * (1.0 - position[:, 1]))


def test_density_relaxes_to_that_of_still_water_at_its_height():
    """Towards rho_s(z), not rho0: with gravity, damping towards rho0 would lift the water.

    One step under a strong layer leaves (gamma - 1)/2 of the square of a deviation; a few leave nothing.
    """
    particles = sample()
    first = apply(zone(with_density=True, sigma0=1e12), particles, 1.0)
    position, (before, after) = first["position"][0], first["density"]
    inside = position[:, 0] > START + 1e-3
    still = still_density(position)
    gap = np.abs(before / still - 1)
    assert gap[inside].max() > 1e-3
    assert (np.abs(after / still - 1) < 3.5 * gap**2 + 1e-14)[inside].all()
    for _ in range(4):
        after = apply(zone(with_density=True, sigma0=1e12), particles, 1.0)["density"][1]
    np.testing.assert_allclose(after[inside], still[inside], rtol=1e-14)


@pytest.mark.parametrize("name", ["tait", "linear"])
@pytest.mark.parametrize("factor", [0.25, 1.0, 16.0])
def test_deviation_of_the_density_falls_as_fast_as_its_factor_says(factor, name):
    """To the square of a small deviation; where the state is linear, exactly."""
    dt, state, particles = 0.01, water(name=name), sample()
    rows = slice(particles.first, particles.last)
    still = still_density(particles.shared[rows], state)
    gap = (1e-3 if name == "tait" else 0.2) * np.random.default_rng(7).uniform(-1, 1, len(still))
    particles.shared[rows, 4] = still * (1 + gap)
    fields = apply(zone(density_factor=factor, state=state.constants), particles, dt)
    x, (before, after) = fields["position"][0][:, 0], fields["density"]
    inside = x > START
    s = hyperbolic(x[inside]) * dt
    expected = still[inside] + left_over(factor * s) * (before - still)[inside]
    error = 3.5 * gap[inside] ** 2 if name == "tait" else 0.0
    assert (np.abs(after[inside] / expected - 1) <= error * (1 - left_over(factor * s)) + 1e-13).all()
    assert np.abs(after / before - 1).max() > 1e-4
    velocity, damped = fields["velocity"]
    np.testing.assert_allclose(damped[inside], velocity[inside] * left_over(s)[:, None], rtol=1e-12)


def test_mass_follows_the_density_so_that_volumes_stay():
    fields = apply(zone(with_density=True), sample(), 0.05)
    (density, damped), (mass, left) = fields["density"], fields["mass"]
    np.testing.assert_allclose(left / damped, mass / density, rtol=1e-14)
    assert np.abs(left / mass - 1).max() > 1e-3


def test_density_and_mass_are_left_alone_unless_asked_for():
    fields = apply(zone(), sample(), 0.05)
    np.testing.assert_array_equal(*fields["density"])
    np.testing.assert_array_equal(*fields["mass"])


def test_still_water_stays_as_it_is():
    particles = sample()
    rows = slice(particles.first, particles.last)
    particles.shared[rows, 2:4] = 0
    particles.shared[rows, 4] = water().density(9810.0 * (1.0 - particles.shared[rows, 1]))
    for before, after in apply(zone(with_density=True), particles, 0.05).values():
        np.testing.assert_allclose(after, before, rtol=1e-14)


def test_depth_of_shallow_water_relaxes_to_the_level():
    state, level = State("shallow", 1.5, math.sqrt(9.81 * 1.5), 7.0), 1.2
    given = {"level": level, "weight": 0.0, "surface_pressure": float(state.pressure(level)), "density_factor": 1.0}
    layer = DampingZone(START, 1, LENGTH, SIGMA0, state.constants, softening=SOFTENING, **given)
    particles = sample(dim=1)
    particles.shared[:, 2] = np.random.default_rng(1).uniform(0.5, 2, len(particles.shared))
    fields = apply(layer, particles, 0.05)
    x, (before, after), (mass, left) = fields["position"][0][:, 0], fields["density"], fields["mass"]
    inside = x > START
    expected = level + left_over(hyperbolic(x[inside]) * 0.05) * (before[inside] - level)
    np.testing.assert_allclose(after[inside], expected, rtol=1e-13)
    np.testing.assert_allclose(left / after, mass / before, rtol=1e-14)


# --- switches and killing functions --------------------------------------------------------------------------------

# Who is damped, by the velocity across the layer (positive: with the wave), the vertical one and the force across.
ACTING = {
    "none": lambda across, up, force: np.ones(len(across), bool),
    "vx": lambda across, up, force: across < 0,
    "vx-vy": lambda across, up, force: (across < 0) & (up < 0),
    "fx-vx": lambda across, up, force: (across < 0) & (force < 0),
}
FALLING = {"f1": lambda ratio: 1 - ratio, "f2": lambda ratio: 1 - ratio**2}


def test_every_switch_and_killing_function_is_tested():
    assert set(ACTING) == set(SWITCHES)
    assert {"none", *FALLING} == set(KILLINGS)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("switch", SWITCHES)
@pytest.mark.parametrize("direction", [1, -1])
def test_a_switch_chooses_who_is_damped(switch, direction, dim):
    """Velocity, density and mass of the others stay to the bit."""
    dt, start = 0.05, START if direction > 0 else 3.0 - START
    particles = sample(dim=dim, count=300)
    fields = apply(zone(direction, start, with_density=True, switch=switch), particles, dt)
    before, after = fields["velocity"]
    depth = direction * (fields["position"][0][:, 0] - start)
    force = direction * particles.acceleration[particles.first : particles.last, 0]
    damped = (depth > 0) & ACTING[switch](direction * before[:, 0], before[:, -1], force)
    assert damped.sum() > 10
    assert switch == "none" or ((depth > 0) & ~damped).sum() > 10
    s = SIGMA0 * dt * depth[damped] / (LENGTH - depth[damped] + SOFTENING)
    np.testing.assert_allclose(after[damped], before[damped] * left_over(s)[:, None], rtol=1e-12)
    assert (fields["density"][1][damped] != fields["density"][0][damped]).all()
    for name in ("velocity", "density", "mass"):
        np.testing.assert_array_equal(fields[name][1][~damped], fields[name][0][~damped])


def test_switches_know_the_velocity_in_one_dimension():
    for switch in ("vx", "fx-vx"):
        particles = sample(dim=1)
        fields = apply(zone(switch=switch), particles, 0.05)
        x, (before, after) = fields["position"][0][:, 0], fields["velocity"]
        force = particles.acceleration[particles.first : particles.last, 0]
        expected = (x > START) & ACTING[switch](before[:, 0], None, force)
        np.testing.assert_array_equal((after != before)[:, 0], expected)


def test_water_at_rest_is_not_moving_against_the_wave():
    particles = sample()
    particles.shared[:, 2:4] = 0
    for name, (before, after) in apply(zone(with_density=True, switch="vx"), particles, 0.05).items():
        np.testing.assert_array_equal(after, before, err_msg=name)


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("killing", FALLING)
@pytest.mark.parametrize("direction", [1, -1])
def test_a_killing_function_multiplies_the_horizontal_force(killing, direction, dim):
    """f1 = 1 - depth/L, f2 = 1 - (depth/L)^2 inside the layer; nothing else changes."""
    start, particles = START if direction > 0 else 3.0 - START, sample(dim=dim)
    rows = particles.shared.copy()
    before, after = restrained(zone(direction, start, killing=killing), particles)
    depth = direction * (particles.field("position", slice(particles.first, particles.last))[:, 0] - start)
    inside = depth > 0
    expected = before[inside, 0] * FALLING[killing](depth[inside] / LENGTH)
    np.testing.assert_allclose(after[inside, 0], expected, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(after[~inside], before[~inside])
    np.testing.assert_array_equal(after[:, 1:], before[:, 1:])
    np.testing.assert_array_equal(particles.shared, rows)
    assert np.abs(after - before).max() > 0.1


@pytest.mark.parametrize("killing", FALLING)
def test_beyond_the_outer_end_the_force_stays_off(killing):
    particles = sample()
    particles.shared[:, 0] += 2.0
    before, after = restrained(zone(killing=killing), particles)
    beyond = particles.field("position", slice(particles.first, particles.last))[:, 0] >= START + LENGTH
    assert beyond.sum() > 30
    assert (after[beyond, 0] == 0).all()
    assert (before[beyond, 0] != 0).all()


# --- layers of scenes ----------------------------------------------------------------------------------------------


def layer_of(overrides, **sections):
    """Return the first layer that a scene's simulation has."""
    return build(load_scene(tank(**sections), overrides)).zones[0]


def test_a_layer_stands_where_its_scene_says():
    right = layer_of({"damping": [{"length": 0.05, "v_ref": 3.0}]})
    assert (right.start, right.direction, right.length) == (pytest.approx(0.15), 1, 0.05)
    assert right.sigma0 == pytest.approx(3.0 / 0.05)
    assert right.softening == pytest.approx(0.5 * 0.02)
    left = layer_of({"damping": [{"length": 0.05, "side": "left", "sigma0": 7.0, "softening": 0.003}]})
    assert (left.start, left.direction) == (0.05, -1)
    assert (left.sigma0, left.softening) == (7.0, 0.003)
    assert layer_of({"damping": [{"length": 0.05}], "numerics.c0": 30.0}).sigma0 == pytest.approx(30.0 / 0.05)
    power = layer_of({"damping": [{"length": 0.05, "profile": "power", "exponent": 3, "switch": "fx-vx", "killing": "f2"}]})
    assert (power.profile, power.exponent, power.switch, power.killing) == ("power", 3, "fx-vx", "f2")


def test_still_water_of_a_layer_is_that_of_its_scene():
    layer = layer_of({"damping": [{"length": 0.05, "density": "plain"}], "fluid.level": 0.21, "fluid.rho0": 900.0})
    assert (layer.level, layer.weight, layer.surface_pressure) == (0.21, pytest.approx(900 * 9.81), 0.0)


def test_matched_density_is_damped_by_the_square_of_sound_over_phase_speed():
    """What a layer takes of a level is sigma_rho (c/c0)^2: matched to sigma with c the wavemaker's, else of long waves."""
    with_maker = load_scene("pool", {"damping.0.density": "matched"})
    c = phase_speed(with_maker.wavemaker.wave.period, 1.0, 9.8)
    assert build(with_maker).zones[0].density_factor == pytest.approx((with_maker.c0 / c) ** 2)
    assert c == pytest.approx(6.061 / 2.236969878, rel=1e-4)
    damping = {"damping": [{"length": 0.05, "density": "matched"}]}
    assert layer_of(damping).density_factor == pytest.approx(20.0**2)
    assert layer_of({**damping, "numerics.c0": 30.0}).density_factor == pytest.approx(30.0**2 / (9.81 * 0.2))
    for density, factor in (("none", 0.0), ("plain", 1.0)):
        assert layer_of({"damping": [{"length": 0.05, "density": density}]}).density_factor == factor


@pytest.fixture
def calls(monkeypatch):
    """Count what runs ask of their layers."""
    found = {"restrain": 0, "act": 0}
    for name in found:
        original = getattr(DampingZone, name)

        def counted(self, *arguments, name=name, original=original):
            found[name] += 1
            return original(self, *arguments)

        monkeypatch.setattr(DampingZone, name, counted)
    return found


def test_layers_are_asked_for_what_they_do_and_no_more(calls):
    """Damped once a step; the force weakened after each evaluation, and never in a scene without a killing function."""
    for integrator in ("verlet", "midpoint"):
        for killing in KILLINGS:
            calls.update(restrain=0, act=0)
            overrides = {"damping": [{"length": 0.1, "killing": killing}], "numerics.integrator": integrator}
            simulation = build(load_scene(tank(time={"end": 0.003}), overrides))
            simulation.run()
            assert calls["act"] == simulation.steps > 2
            assert calls["restrain"] == (simulation.evaluations if killing != "none" else 0)


@pytest.mark.parametrize("killing", FALLING)
def test_an_evaluation_ends_with_the_weakened_force(killing):
    """Pressure and viscosity of a moving tank; with a layer at either end."""
    forces = {}
    layers = [{"side": side, "length": 0.08, "killing": killing} for side in ("left", "right")]
    for name, damping in (("free", []), ("weak", layers)):
        simulation = build(load_scene(tank(damping=damping)))
        moved = moving(simulation, 0.2, False)
        put(simulation, moved)
        simulation.prepare()
        forces[name] = simulation.particles.acceleration[simulation.particles.fluid]
    x = simulation.field("position")[:, 0]
    ratio = np.maximum(np.abs(x - 0.1) - 0.02, 0) / 0.08
    expected = forces["free"] * np.stack([FALLING[killing](ratio), np.ones(len(x))], axis=1)
    np.testing.assert_allclose(forces["weak"], expected, rtol=1e-12, atol=1e-12)


# --- whole runs ----------------------------------------------------------------------------------------------------


def fields_of(simulation):
    """Return the fields in the order of the particles' numbers."""
    order = np.argsort(simulation.field("id"))
    return {name: simulation.field(name)[order] for name in NAMES}


def put(simulation, fields):
    """Give the fluid other fields, in the order of the particles' numbers."""
    p = simulation.particles
    rows = p.fluid
    for name, values in fields.items():
        _, columns = p.layout.columns(name)
        p.shared[rows, columns] = values[p.tags[rows]].reshape(len(rows), -1)


def moving(simulation, length, mirrored):
    """Return smooth fields without symmetry, that every switch divides, on a basin of `length`; or their mirror image."""
    fields = fields_of(simulation)
    x = (length - fields["position"][:, 0] if mirrored else fields["position"][:, 0]) / length
    across = np.sin(math.pi * x) * (np.sin(2 * math.pi * x + 0.3) + 0.4 * np.sin(9 * x + 0.2))  # none at the walls
    if simulation.sweep.dim == 1:
        swell, velocity = 1 + 0.05 * np.exp(-(((x - 0.55) / 0.1) ** 2)), 0.2 * across[:, None]
    else:
        z = fields["position"][:, 1] / length
        swell = 1 + 1e-3 * np.cos(2 * x + 0.2)
        velocity = np.stack([0.3 * across * np.cos(3 * z + 0.2), 0.3 * z * np.cos(11 * x + 0.4)], axis=1)
    if mirrored:
        velocity[:, 0] *= -1
    fields["velocity"] = velocity
    fields["density"] = fields["density"] * swell
    fields["mass"] = fields["mass"] * swell
    return fields


def lagoon(layers, density="continuity"):
    """Shallow water of 40 m x 1 m."""
    keys = {
        "domain": {"size": [40.0]},
        "fluid": {"blocks": [{"low": [0.0], "high": [40.0], "depth": 1.0}]},
        "walls": {"left": {}, "right": {}},
        "damping": layers,
        "numerics": {"state": "shallow", "dx": 0.4, "h_over_dx": 2.5, "density": density},
        "time": {"end": 5.0},
    }
    return keys, [{"length": 15.0, "sigma0": 1.0, **layer} for layer in layers]


def basin(layers):
    """A tank of 0.4 m x 0.2 m."""
    keys = tank(
        domain={"size": [0.4, 0.3], "gravity": 9.81},
        fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.4, 0.2]}]},
        time={"end": 0.025},
    )
    return keys, [{"length": 0.25, "v_ref": 3.0, **layer} for layer in layers]


def end_of(scene, layer, mirrored):
    """Run a layer at the right or, mirrored, at the left; return the fields as of a layer at the right."""
    keys, layers = scene([{"side": "left" if mirrored else "right", **layer}] if layer is not None else [])
    simulation = build(load_scene({**keys, "damping": layers}))
    length = keys["domain"]["size"][0]
    put(simulation, moving(simulation, length, mirrored))
    simulation.run()
    fields = fields_of(simulation)
    if mirrored:
        lines = fields["mass"].reshape(round(length / keys["numerics"]["dx"]), -1).shape
        numbers = np.arange(len(fields["mass"])).reshape(lines)[::-1].ravel()
        fields = {name: values[numbers] for name, values in fields.items()}
        fields["position"][:, 0] = length - fields["position"][:, 0]
        fields["velocity"][:, 0] *= -1
    return fields


LAYERS = {
    "all": {},
    **{f"switch {switch}": {"switch": switch} for switch in SWITCHES if switch != "none"},
    **{f"killing {killing}": {"killing": killing} for killing in FALLING},
    "power": {"profile": "power", "exponent": 2},
    "plain density": {"density": "plain"},
    "matched density, f1, fx-vx": {"density": "matched", "killing": "f1", "switch": "fx-vx"},
}


@pytest.mark.parametrize("scene", [lagoon, basin])
def test_a_run_with_a_layer_at_the_left_is_the_mirror_image_of_one_at_the_right(scene):
    """Of every kind; up to rounding, since sums run in another order. No two kinds end alike, so each one acts."""
    ends = {"no layer": end_of(scene, None, False)}
    for name, layer in LAYERS.items():
        if scene is lagoon and layer.get("switch") == "vx-vy":
            continue
        ends[name] = end_of(scene, layer, False)
        image = end_of(scene, layer, True)
        for field, values in ends[name].items():
            np.testing.assert_allclose(
                image[field], values, rtol=0, atol=1e-10 * np.abs(values).max(), err_msg=f"{name}: {field}"
            )
    names = list(ends)
    for k, name in enumerate(names):
        for other in names[:k]:
            assert np.abs(ends[name]["velocity"] - ends[other]["velocity"]).max() > 1e-3, f"{name} is {other}"


@pytest.mark.parametrize("name", LAYERS)
def test_still_water_in_a_layer_stays_still(name):
    """With a layer at either end nothing moves by more than a tenth of a spacing, nor faster than 1 % of a wave."""
    layers = [{"side": side, "length": 0.1, **LAYERS[name]} for side in ("left", "right")]
    simulation = build(load_scene(tank(damping=layers, time={"end": 0.1})))
    before = fields_of(simulation)
    simulation.run()
    after = fields_of(simulation)
    assert np.abs(after["position"] - before["position"]).max() < 0.1 * 0.01
    assert np.abs(after["velocity"]).max() < 0.01 * math.sqrt(9.81 * 0.2)
    assert after["mass"].sum() == pytest.approx(before["mass"].sum(), rel=2e-3)


@pytest.mark.parametrize("density", ["continuity", "summation"])
def test_a_lake_at_rest_in_layers_stays_at_rest(density):
    for name, layer in LAYERS.items():
        if layer.get("switch") == "vx-vy":
            continue
        keys, layers = lagoon([{"side": side, **layer} for side in ("left", "right")], density)
        simulation = build(load_scene({**keys, "damping": layers}))
        simulation.run()
        assert np.abs(simulation.field("velocity")).max() < 1e-12, name
        np.testing.assert_allclose(simulation.field("density"), 1, rtol=1e-11, err_msg=name)
