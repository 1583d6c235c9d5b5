"""Absorbing layers."""

import math

import numpy as np
import pytest
from helpers import domain_of, water

from parsph.columns import Grid
from parsph.damping import DampingZone, hyperbolic
from parsph.particles import FIRST_GHOST

START, LENGTH, H, SIGMA0 = 2.0, 1.0, 0.1, 7.0


def zone(direction=1, start=START, with_density=False, sigma0=SIGMA0):
    state = water().constants
    return DampingZone(start, direction, LENGTH, H, sigma0, with_density, level=1.0, weight=9810.0, state=state)


def sample(count=200, seed=4):
    """Return particles over 0 < x < 3 with velocities and densities."""
    rng = np.random.default_rng(seed)
    fields = {
        "position": rng.uniform(0, 1, (count, 2)) * [3, 1],
        "velocity": rng.normal(0, 1, (count, 2)),
        "density": rng.uniform(990, 1030, count),
    }
    return domain_of(Grid.around((0.0, 0.0), (3.0, 1.0), 0.2), fields).particles


def apply(layer, particles, dt):
    """Damp all rows; return {field: (before, after)}."""
    names, rows = ("position", "velocity", "density"), slice(particles.first, particles.last)
    before = {name: particles.field(name, rows).copy() for name in names}
    layer.apply(particles, particles.first, particles.last, dt)
    return {name: (before[name], particles.field(name, rows)) for name in names}


def profile(x):
    """Molteni et al., section 2.1: sigma0 (x - x0) / ((x0 + L) - x + 0.5 h)."""
    return SIGMA0 * (x - START) / ((START + LENGTH) - x + 0.5 * H)


def test_velocities_fall_by_the_exact_exponential():
    """dv/dt = -sigma v over dt is the factor exp(-sigma dt), not its expansion."""
    dt = 0.05
    fields = apply(zone(), sample(), dt)
    x, (before, after) = fields["position"][0][:, 0], fields["velocity"]
    inside = x > START
    expected = before[inside] * np.exp(-profile(x[inside]) * dt)[:, None]
    assert inside.sum() > 30
    np.testing.assert_allclose(after[inside], expected, rtol=1e-12)


def test_nothing_outside_the_layer_changes():
    fields = apply(zone(with_density=True), sample(), 0.05)
    outside = fields["position"][0][:, 0] <= START
    assert outside.sum() > 30
    for before, after in fields.values():
        np.testing.assert_array_equal(after[outside], before[outside])
    np.testing.assert_array_equal(*fields["position"])


@pytest.mark.parametrize("sigma_dt", [1e-6, 1.0, 1e6, 1e300])
def test_damping_is_stable_for_any_strength(sigma_dt):
    """It takes energy and never turns a velocity round, however long the step."""
    fields = apply(zone(sigma0=sigma_dt, with_density=True), sample(), 1.0)
    (before, after), (_, density) = fields["velocity"], fields["density"]
    assert (np.abs(after) <= np.abs(before)).all()
    assert (after * before >= 0).all()
    assert (density > 900).all()


def test_two_half_steps_are_one_step():
    once = apply(zone(with_density=True), sample(), 0.04)
    twice = sample()
    for _ in range(2):
        halves = apply(zone(with_density=True), twice, 0.02)
    for name in ("velocity", "density"):
        np.testing.assert_allclose(halves[name][1], once[name][1], rtol=1e-13)


def test_a_layer_at_the_left_is_the_mirror_image_of_one_at_the_right():
    right, left = sample(), sample()
    left.shared[:, 0] = 3.0 - left.shared[:, 0]
    a = apply(zone(1, START, True), right, 0.05)
    b = apply(zone(-1, 3.0 - START, True), left, 0.05)
    for name in ("velocity", "density"):
        np.testing.assert_allclose(a[name][1], b[name][1], rtol=1e-12)
    assert zone(-1, 1.0).span == (0.0, 1.0)
    assert zone(1, START).span == (2.0, 3.0)


def test_density_relaxes_to_that_of_still_water_at_its_height():
    """Towards rho_s(z), not rho0: with gravity, damping towards rho0 would lift the water."""
    fields = apply(zone(with_density=True, sigma0=1e9), sample(), 1.0)
    position, (before, after) = fields["position"][0], fields["density"]
    inside = position[:, 0] > START + 1e-3
    still = water().density(9810.0 * (1.0 - position[:, 1]))
    np.testing.assert_allclose(after[inside], still[inside], rtol=1e-14)
    assert np.abs(before - still)[inside].max() > 1


def test_density_is_left_alone_unless_asked_for():
    fields = apply(zone(), sample(), 0.05)
    np.testing.assert_array_equal(*fields["density"])


def test_still_water_stays_as_it_is():
    particles = sample()
    rows = slice(particles.first, particles.last)
    particles.shared[rows, 2:4] = 0
    particles.shared[rows, 4] = water().density(9810.0 * (1.0 - particles.shared[rows, 1]))
    for before, after in apply(zone(with_density=True), particles, 0.05).values():
        np.testing.assert_allclose(after, before, rtol=1e-15)


def test_images_are_not_damped():
    particles = sample()
    particles.tags[:] += FIRST_GHOST
    for before, after in apply(zone(with_density=True), particles, 0.05).values():
        np.testing.assert_array_equal(after, before)


def test_profile_is_softened_at_its_outer_end_and_finite_beyond():
    """At the end sigma/sigma0 is L / (0.5 h); a particle beyond it is damped as hard."""
    assert hyperbolic(LENGTH, LENGTH, H) == pytest.approx(LENGTH / (0.5 * H))
    assert hyperbolic(0.0, LENGTH, H) == 0
    assert math.isfinite(hyperbolic(1.5 * LENGTH, LENGTH, H))
    values = [hyperbolic(depth, LENGTH, H) for depth in np.linspace(0, 1.2 * LENGTH, 50)]
    assert (np.diff(values) > 0).all()
