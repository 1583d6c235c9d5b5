"""Relaxation zones: the compiled wave against the theory, the relaxation itself, ramps, scenes and what they may not be."""

import math

import numpy as np
import pytest
from helpers import domain_of, tank, water

from parsph.columns import Grid
from parsph.damping import DampingZone
from parsph.errors import SceneError
from parsph.jit import compilations
from parsph.parallel import Communicator
from parsph.particles import FIRST_GHOST
from parsph.relaxation import (
    EXPONENT,
    RelaxationZone,
    bernoulli_constant,
    dynamic_head,
    orbital_velocity,
    transport,
)
from parsph.run import load_code, wave_heights
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.scene.zones import describe_zone
from parsph.waves import REGULAR_THEORIES, regular_wave

DEPTH, GRAVITY, LEVEL = 1.0, 9.81, 1.2
START, LENGTH, RATE = 2.0, 1.0, 7.0
NAMES = ("position", "velocity", "density", "mass")


@pytest.fixture(params=REGULAR_THEORIES, scope="module")
def wave(request):
    return regular_wave(0.2, DEPTH, GRAVITY, wavelength=5.0, theory=request.param)


def zone(wave=None, direction=1, start=START, rate=RATE, **options):
    given = {"level": LEVEL, "bed": LEVEL - DEPTH, "weight": 1000 * GRAVITY}
    return RelaxationZone(start, direction, LENGTH, rate, water().constants, wave, **{**given, **options})


def sample(count=200, seed=4, dim=2):
    """Return particles over 0 < x < 3 and 0.2 < z < 1.2 with velocities, densities and masses."""
    rng = np.random.default_rng(seed)
    fields = {
        "position": rng.uniform(0, 1, (count, dim)) * [3] + [0] * dim,
        "velocity": rng.normal(0, 1, (count, dim)),
        "density": rng.uniform(990, 1030, count),
        "mass": rng.uniform(1, 2, count),
    }
    fields["position"][:, 1:] = fields["position"][:, 1:] / 3 + LEVEL - DEPTH
    return domain_of(Grid.around((0.0,) * dim, (3.0,) + (1.4,) * (dim - 1), 0.2), fields).particles


def apply(acting, particles, time, dt):
    """Let a zone act on all rows; return {field: (before, after)}."""
    rows = slice(particles.first, particles.last)
    before = {name: particles.field(name, rows).copy() for name in NAMES}
    acting.act(particles, particles.first, particles.last, time, dt)
    return {name: (before[name], particles.field(name, rows)) for name in NAMES}


def target_of(wave, position, time, share=1.0):
    """Velocity [m/s] that particles are relaxed to, shape (n, dim): the wave's, less its mean transport."""
    z = np.minimum(position[:, -1] - (LEVEL - DEPTH), DEPTH + wave.elevation(0.0, 0.0))
    target = np.zeros(position.shape)
    target[:, [0, -1]] = share * wave.velocity(position[:, 0], z, time)
    target[:, 0] -= share**2 * transport(wave) / DEPTH
    return target


# --- the wave ------------------------------------------------------------------------------------------------------


def test_compiled_velocities_are_those_of_the_theory(wave):
    """At random places and times, to 1e-12 of the largest."""
    rng = np.random.default_rng(1)
    x, z, t = rng.uniform(-9, 9, 300), rng.uniform(0, 1.15, 300), rng.uniform(0, 20, 300)
    j = np.arange(1, len(wave.velocities) + 1)
    scales = wave.velocities / (1 + np.exp(-2 * j * wave.wavenumber * DEPTH))
    turns = wave.wavenumber * x - wave.frequency * t
    places = zip(turns, z, strict=True)
    found = np.array([orbital_velocity(turn, up, wave.wavenumber, DEPTH, scales) for turn, up in places])
    expected = wave.velocity(x, z, t)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_transport_is_the_integral_over_the_depth(wave):
    """By the trapezoidal rule over z, averaged over a wave; and the energy over the celerity, for low waves."""
    x = wave.wavelength * np.arange(200) / 200
    flux = []
    for place in x:
        z = np.linspace(0, DEPTH + wave.elevation(place, 0.0), 400)
        flux.append(np.trapezoid(wave.velocity(place, z, 0.0)[:, 0], z))
    assert transport(wave) == pytest.approx(np.mean(flux), rel=1e-4)
    low = regular_wave(0.01, DEPTH, GRAVITY, wavelength=5.0)
    assert transport(low) == pytest.approx(GRAVITY * 0.01**2 / 8 / low.celerity, rel=1e-3)


def test_pressure_vanishes_at_the_surface_of_an_exact_wave():
    """Bernoulli: ``g (d - z) + head`` is 0 all along the surface, of the order H^2 of linear waves."""
    for theory, bound in (("fenton", 1e-6), ("stokes", 2e-4), ("airy", 0.1)):
        wave = regular_wave(0.2, DEPTH, GRAVITY, wavelength=5.0, theory=theory)
        x = np.linspace(0, 5, 40)
        eta, constant = wave.elevation(x, 0.0), bernoulli_constant(wave)
        along, up = wave.velocity(x, DEPTH + eta, 0.0).T
        pressure = -GRAVITY * eta + dynamic_head.py_func(along, up, wave.celerity, constant)
        assert np.abs(pressure).max() < bound * GRAVITY * 0.2, theory


# --- relaxation ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("direction", [1, -1])
def test_velocities_come_nearer_to_those_of_the_wave(wave, direction, dim):
    """By 1/(1 + s + s^2/2) with s = rate (depth/L)^2 dt; outside nothing changes, nor density and mass."""
    dt, time, start = 0.05, 3.3, START if direction > 0 else 3.0 - START
    fields = apply(zone(wave, direction, start), sample(dim=dim), time, dt)
    position, (before, after) = fields["position"][0], fields["velocity"]
    inside = direction * (position[:, 0] - start)
    s = RATE * dt * np.maximum(inside / LENGTH, 0) ** EXPONENT
    target = target_of(wave, position, time)
    expected = target + (before - target) / (1 + s + s**2 / 2)[:, None]
    np.testing.assert_allclose(after[inside > 0], expected[inside > 0], rtol=1e-11, atol=1e-13)
    np.testing.assert_array_equal(after[inside <= 0], before[inside <= 0])
    for name in ("position", "density", "mass"):
        np.testing.assert_array_equal(*fields[name])


@pytest.mark.parametrize("density_factor", [0.0, 5.0])
@pytest.mark.parametrize("direction", [1, -1])
def test_still_water_is_an_absorbing_layer_of_the_same_profile_to_the_bit(direction, density_factor):
    start = START if direction > 0 else 3.0 - START
    water_of = {"level": LEVEL, "weight": 1000 * GRAVITY, "density_factor": density_factor}
    power = {"profile": "power", "exponent": EXPONENT}
    layer = DampingZone(start, direction, LENGTH, RATE, water().constants, **power, **water_of)
    damped = apply(layer, sample(), 1.0, 0.05)
    for wave, time in ((None, 1.0), (regular_wave(0.2, DEPTH, GRAVITY, wavelength=5.0), 0.0)):  # which has not begun
        relaxed = apply(zone(wave, direction, start, density_factor=density_factor), sample(), time, 0.05)
        for name in NAMES:
            np.testing.assert_array_equal(relaxed[name][1], damped[name][1], err_msg=name)
    assert (damped["velocity"][1] != damped["velocity"][0]).any()


def test_densities_come_nearer_to_those_of_the_waves_pressure(wave):
    """All the way with a strong rate; particles keep their volume."""
    fields = apply(zone(wave, rate=1e9, density_factor=10.0), sample(), 3.3, 0.05)
    position, (before, after), (mass, left) = fields["position"][0], fields["density"], fields["mass"]
    inside = position[:, 0] > START + 0.05
    z = np.minimum(position[:, 1] - (LEVEL - DEPTH), DEPTH + wave.elevation(0.0, 0.0))
    along, up = wave.velocity(position[:, 0], z, 3.3).T
    head = wave.celerity * along - 0.5 * (along**2 + up**2) + bernoulli_constant(wave)
    expected = water().density(1000 * (GRAVITY * (LEVEL - position[:, 1]) + head))
    gap = np.abs(expected / before - 1)
    assert (np.abs(after / expected - 1)[inside] <= 3.1 * gap[inside] ** 2 + 1e-12).all()  # a Newton step
    np.testing.assert_allclose(left / after, mass / before, rtol=1e-14)
    np.testing.assert_array_equal(after[position[:, 0] < START], before[position[:, 0] < START])


@pytest.mark.parametrize("strength", [1e-6, 1.0, 1e6, 1e100])
def test_relaxation_is_stable_for_any_strength(wave, strength):
    """No component goes beyond its target, however long the step."""
    fields = apply(zone(wave, rate=strength, density_factor=7.0), sample(), 3.3, 1.0)
    target, (before, after) = target_of(wave, fields["position"][0], 3.3), fields["velocity"]
    rest = (after - target) * np.sign(before - target)
    assert (rest >= -1e-12).all()
    assert (rest <= np.abs(before - target) + 1e-12).all()
    for name in ("density", "mass"):
        assert np.isfinite(fields[name][1]).all()
        assert (fields[name][1] > 0).all()


def test_particles_above_the_crest_have_its_velocity(wave):
    particles = sample()
    particles.shared[:, 1] += 5.0
    fields = apply(zone(wave, rate=1e9), particles, 3.3, 1.0)
    inside = fields["position"][0][:, 0] > START + 0.1
    assert np.abs(fields["velocity"][1][inside]).max() < 1.0
    expected = target_of(wave, fields["position"][0], 3.3)
    np.testing.assert_allclose(fields["velocity"][1][inside], expected[inside], rtol=0, atol=1e-9)


@pytest.mark.parametrize(("time", "share"), [(-1.0, 0.0), (0.0, 0.0), (0.5, 0.14644660940672624), (2.0, 1.0), (9.0, 1.0)])
def test_the_target_sets_in_smoothly(wave, time, share):
    """With (1 - cos(pi t/T))/2, here T = 2 s; what goes with the height squared, with its square."""
    fields = apply(zone(wave, rate=1e9, ramp=2.0), sample(), time, 0.05)
    inside = fields["position"][0][:, 0] > START + 0.1
    expected = target_of(wave, fields["position"][0], time, share)
    np.testing.assert_allclose(fields["velocity"][1][inside], expected[inside], rtol=0, atol=1e-9)


def test_without_ramp_the_wave_is_there_at_once(wave):
    fields = apply(zone(wave, rate=1e9), sample(), 1e-9, 0.05)
    inside = fields["position"][0][:, 0] > START + 0.1
    expected = target_of(wave, fields["position"][0], 0.0)
    np.testing.assert_allclose(fields["velocity"][1][inside], expected[inside], rtol=0, atol=1e-6)


@pytest.mark.parametrize("direction", [1, -1])
def test_nothing_is_driven_into_the_wall(wave, direction):
    """u of the target falls to 0 over the margin at the outer end; w does not."""
    start, margin = START if direction > 0 else 3.0 - START, 0.4
    fields = apply(zone(wave, direction, start, rate=1e9, margin=margin), sample(), 3.3, 1.0)
    position, (_, after) = fields["position"][0], fields["velocity"]
    off = LENGTH - direction * (position[:, 0] - start)
    target = target_of(wave, position, 3.3)
    target[:, 0] *= np.clip(off / margin, 0, 1)
    inside = off < LENGTH - 0.1
    np.testing.assert_allclose(after[inside], target[inside], rtol=0, atol=1e-9)
    assert (off[inside] < margin).sum() > 10


def test_images_are_left_alone(wave):
    particles = sample()
    particles.tags[particles.first] = FIRST_GHOST
    before = particles.shared[particles.first].copy()
    apply(zone(wave, start=-1.0, density_factor=1.0), particles, 3.3, 0.05)
    np.testing.assert_array_equal(particles.shared[particles.first], before)


# --- the profile ---------------------------------------------------------------------------------------------------


def made_and_reflected(sigma, with_level, steps=600):
    """Solve linear long waves, speed, wavelength and period 1, in a zone of length 1 behind which u is prescribed.

    ``(iw + sigma) u + eta' = 0``, ``(iw [+ sigma]) eta + u' = 0`` by the classical Runge-Kutta method, from the wall on.

    Parameters
    ----------
    sigma : callable
        Strengths, shape (n,), at a distance from the inner edge.

    Returns
    -------
    ndarray, shape (n,), twice
        What of a difference as large as the wave at the wall comes out, and what of a wave that comes in.
    """
    w, step = 2j * np.pi, 1 / steps
    values = np.zeros((2, 2, len(sigma(0.0))), complex)  # u and eta, of the solutions that begin with u = 1 and eta = 1
    values[0, 0], values[1, 1] = 1, 1

    def slope(y, values):
        strength = sigma(1 - y)
        return np.stack([-(w + strength * with_level) * values[1], -(w + strength) * values[0]])

    for k in range(steps):
        y = k * step
        a = slope(y, values)
        b = slope(y + step / 2, values + step / 2 * a)
        c = slope(y + step / 2, values + step / 2 * b)
        values = values + step / 6 * (a + 2 * b + 2 * c + slope(y + step, values + step * c))
    out, back = (values[0] + values[1]) / 2, (values[1] - values[0]) / 2
    return np.abs(out[0] - out[1] * back[0] / back[1]), np.abs(out[1] / back[1])


PROFILES_IN_USE = {
    "linear": (lambda s: s, 0.066),
    "quadratic": (lambda s: s**EXPONENT, 0.049),
    "cubic": (lambda s: s**3, 0.060),
    "exponential": (lambda s: math.expm1(max(s, 0.0) ** 3.5) / (math.e - 1), 0.066),
    "tanh": (lambda s: 0.5 * (1 + math.tanh(6 * (s - 0.5))), 0.102),
}


@pytest.mark.parametrize("name", PROFILES_IN_USE)
def test_the_profile_is_the_best_of_those_in_use(name):
    """The larger of both errors at the best strength, of zones that relax the velocity alone; what the docstring says."""
    profile, expected = PROFILES_IN_USE[name]
    rates = np.arange(6.0, 90.0, 2.0)
    errors = made_and_reflected(lambda s: rates * profile(s), False)
    assert np.max(errors, axis=0).min() == pytest.approx(expected, abs=2e-3)
    assert expected >= PROFILES_IN_USE["quadratic"][1]


def test_with_the_level_errors_fall_exponentially():
    """``exp(-integral of sigma)`` of the difference at the wall, and its square of a wave that comes."""
    rates = np.array([3.0, 6.0, 10.0])
    made, reflected = made_and_reflected(lambda s: rates * s**EXPONENT, True)
    np.testing.assert_allclose(reflected, np.exp(-2 * rates / 3), rtol=1e-4)
    np.testing.assert_allclose(made, np.exp(-rates / 3), rtol=1e-4)


# --- scenes --------------------------------------------------------------------------------------------------------


def basin(relaxation, **sections):
    """Return the keys of a tank of 1.2 m x 0.2 m."""
    keys = {
        "domain": {"size": [1.2, 0.3], "gravity": 9.81},
        "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [1.2, 0.2]}]},
        "numerics": {"dx": 0.02, "diffusion": "fourtakas", "viscosity": "monaghan"},
        "relaxation": relaxation,
    }
    return tank(**{**keys, **sections})


WAVE = {"length": 0.5, "height": 0.02, "period": 0.7}


def test_zones_stand_where_their_scene_says():
    left, right = build(load_scene(basin([WAVE, {"side": "right", "length": 0.4, "height": 0}]))).zones
    assert (left.start, left.direction, left.length) == (0.5, -1, 0.5)
    assert (right.start, right.direction, right.length) == (pytest.approx(0.8), 1, 0.4)
    assert left.rate == right.rate == pytest.approx(40 / 0.7)  # what comes to the right end has the period of the left
    assert left.ramp == pytest.approx(1.4)
    assert (left.bed, left.level, left.weight) == (0.0, 0.2, 9810.0)
    assert left.margin == pytest.approx(0.08)  # 2 h, h = 2 dx
    assert left.wave.height == 0.02
    assert left.wave.period == pytest.approx(0.7)
    assert right.wave is None
    c0 = load_scene(basin([WAVE])).c0
    assert left.density_factor == pytest.approx((c0 / left.wave.celerity) ** 2)
    assert right.density_factor == pytest.approx(left.density_factor, rel=0.02)  # nonlinear waves are faster


def test_keys_of_a_zone_are_those_of_its_wave():
    keys = {"length": 0.5, "height": 0.02, "wavelength": 0.7, "theory": "airy", "ramp": 0.1, "rate": 5.0, "density": "none"}
    (made,) = build(load_scene(basin([keys]))).zones
    assert (made.wave.wavelength, len(made.wave.velocities)) == (0.7, 1)
    assert (made.ramp, made.rate, made.density_factor) == (0.1, 5.0, 0.0)


def test_the_period_of_a_scene_is_that_of_its_zone():
    assert load_scene(basin([WAVE])).wave_period == pytest.approx(0.7)
    linear = load_scene(basin([{"length": 0.5, "height": 0.02, "wavelength": 0.7, "theory": "airy"}]))
    assert linear.wave_period == pytest.approx(
        2 * math.pi / math.sqrt(9.81 * 2 * math.pi / 0.7 * math.tanh(0.4 * math.pi / 0.7))
    )
    assert load_scene(basin([{"length": 0.5, "height": 0, "rate": 3.0}])).wave_period is None
    assert load_scene("pool").wave_period == pytest.approx(2.237, rel=1e-3)


def test_a_zone_that_makes_waves_makes_them_without_end():
    assert load_scene(basin([WAVE])).endless_waves
    assert not load_scene(basin([{"length": 0.5, "height": 0, "period": 0.7}])).endless_waves
    assert load_scene("pool").endless_waves


def test_heights_are_reported_beside_the_one_asked_for():
    """Over the last two periods, of runs of six periods and more."""
    scene = load_scene(basin([WAVE], time={"end": 4.3}, gauges=[{"kind": "level", "x": 0.7}]))
    simulation = build(scene)
    (gauge,) = simulation.observers
    t = np.linspace(0, 4.3, 1000)
    gauge.record = lambda: np.stack([t, 0.2 + 0.009 * np.cos(2 * math.pi * t / 0.7)], axis=1)
    told = wave_heights(scene, simulation)
    assert told["wave height, expected [m]"] == 0.02
    assert list(told["wave height [m]"].values()) == [pytest.approx(0.018, rel=1e-3)]


def test_the_plan_says_what_a_zone_does():
    scene = load_scene(basin([WAVE, {"side": "right", "length": 0.4, "height": 0}]))
    told, _ = describe_zone(scene, scene.relaxation[0])
    assert "0.5 m (0.69 wavelengths), fenton waves of 0.02 m, 0.7 s" in told
    assert "velocity and density by up to 57.1 per s" in told
    told, _ = describe_zone(scene, scene.relaxation[1])
    assert told.startswith("0.4 m, still water")


# name: (overrides of the tank with a zone at the left, where, part of what is wrong, part of the cure)
FAULTS = {
    "too long": ({"relaxation.0.length": 1.2}, "relaxation.0.length", "too long", "less than"),
    "second at a side": ({"relaxation": [WAVE, WAVE]}, "relaxation.1.side", "second zone at the left", "one per side"),
    "overlap": (
        {"relaxation": [WAVE, {"side": "right", "length": 0.9, "height": 0}]},
        "relaxation",
        "overlap",
        "at most 1.2 m",
    ),
    "overlap with a layer": ({"damping": [{"length": 0.9}]}, "relaxation", "overlap", "at most 1.2 m"),
    "layer at its side": (
        {"damping": [{"length": 0.3, "side": "left"}]},
        "relaxation.0.side",
        "absorbing layer at the left",
        "one of the two",
    ),
    "outside the fluid": ({"fluid.blocks.0.low": [0.6, 0.0]}, "relaxation.0", "outside the fluid", "longer"),
    "wavemaker in it": (
        {"wavemaker": {"kind": "piston", "wave": {"kind": "regular", "height": 0.02, "period": 0.7}}},
        "relaxation.0.side",
        "moving wall",
        "another side",
    ),
    "body in it": (
        {"bodies": [{"wall": "left", "mass": 50.0, "stops": [-0.01, 0.01]}]},
        "relaxation.0.side",
        "moving wall",
        "another side",
    ),
    "breaking": ({"relaxation.0.height": 0.15}, "relaxation.0.height", "beyond breaking", "at most 0.0962 m"),
    "no period": ({"relaxation": [{"length": 0.5, "height": 0.02}]}, "relaxation.0", "exactly one of period", "one of them"),
    "two periods": ({"relaxation.0.frequency": 2.0}, "relaxation.0", "period and frequency", "one of them"),
    "two periods of still water": (
        {"relaxation": [{"length": 0.5, "height": 0, "period": 1.0, "frequency": 2.0}]},
        "relaxation.0",
        "period and frequency",
        "one of them",
    ),
    "no theory of it": (
        {"relaxation.0.theory": "stokes", "relaxation.0.period": 3.0},
        "relaxation.0.theory",
        "no theory of waves so long",
        "fenton",
    ),
    "no strength": ({"relaxation": [{"length": 0.5, "height": 0}]}, "relaxation.0.rate", "is missing", "[1/s]"),
    "summed densities": (
        {"numerics.density": "summation", "numerics.density_range": [0.4, 1.3], "numerics.diffusion": "none"},
        "relaxation.0.density",
        "nothing to act on",
        '"none"',
    ),
    "no gravity": ({"domain.gravity": 0.0, "numerics.c0": 20.0}, "relaxation", "no water", "gravity > 0"),
    "periodic": ({"domain.periodic": ["up"]}, "relaxation", "no surface", "leave it out"),
    "one dimension": (
        {"domain.size": [1.2], "fluid.blocks": [{"low": [0.0], "high": [1.2]}], "walls": {}, "numerics.c0": 9.0},
        "relaxation",
        "two dimensions",
        "leave it out",
    ),
    "no length": ({"relaxation.0.length": 0.0}, "relaxation.0.length", "greater than", "of the zone [m]"),
    "unknown theory": ({"relaxation.0.theory": "cnoidal"}, "relaxation.0.theory", "airy", "of the wave"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_says_where_what_and_the_cure(name):
    overrides, where, what, cure = FAULTS[name]
    with pytest.raises(SceneError) as caught:
        load_scene(basin([WAVE]), overrides)
    faults = [fault for fault in caught.value.faults if fault.where == where]
    assert faults, f"nothing about {where}: {caught.value}"
    assert any(what in fault.what for fault in faults), f"not {what!r}: {caught.value}"
    assert any(cure in fault.cure for fault in faults), f"no cure with {cure!r}: {[f.cure for f in faults]}"


# --- whole runs ----------------------------------------------------------------------------------------------------


def test_water_begins_to_move_and_stays_smooth():
    """After a period the water in the zone moves about as that of the wave."""
    gauges = [{"kind": "level", "x": 0.7}]
    scene = load_scene(basin([{**WAVE, "ramp": 0.35}], time={"end": 0.7}, gauges=gauges))
    simulation = build(scene)
    simulation.run()
    position, velocity = simulation.field("position"), simulation.field("velocity")
    made = simulation.zones[0]
    inner = (position[:, 0] > 0.1) & (position[:, 0] < 0.4)  # off the wall, and where sigma is no longer small
    expected = made.wave.velocity(position[:, 0], position[:, 1], simulation.time)
    off = np.sqrt(np.mean((velocity - expected)[inner] ** 2) / np.mean(expected[inner] ** 2))
    assert off < 0.25
    assert wave_heights(scene, simulation) == {}  # too short to tell


def test_a_zone_of_no_height_leaves_still_water_still():
    scene = load_scene(basin([{"length": 0.5, "height": 0, "period": 0.7}], time={"end": 0.1}))
    simulation = build(scene)
    simulation.run()
    assert np.abs(simulation.field("velocity")).max() < 0.01 * math.sqrt(9.81 * 0.2)


def test_no_code_is_compiled_while_it_runs():
    """With zones at both ends; on a first block that no such wave could run over."""
    blocks = [{"low": [1.0, 0.14], "high": [1.2, 0.2]}, {"low": [0.0, 0.0], "high": [1.0, 0.2]}]
    zones = [{**WAVE, "height": 0.05}, {"side": "right", "length": 0.3, "height": 0}]
    scene = load_scene(basin(zones, fluid={"blocks": blocks}, time={"end": 0.001}))
    load_code(scene, Communicator())
    before = compilations()
    build(scene).run()
    assert compilations() == before
