"""Linear wave theory against reference numbers."""

import math

import numpy as np
import pytest

from parsph.scene.load import load_scene
from parsph.scene.movers import maker_of
from parsph.waves import (
    Seiche,
    Sloshing,
    angular_frequency,
    flap_transfer,
    layer_reflection,
    phase_speed,
    pulse,
    viscosity_of_alpha,
    wavenumber,
)


@pytest.mark.parametrize("kd", [1e-3, 0.1, 0.5, 1.037, 3.0, 10.0, 60.0])
@pytest.mark.parametrize("depth", [0.2, 1.0, 30.0])
def test_wavenumber_inverts_angular_frequency(kd, depth):
    frequency = angular_frequency(kd / depth, depth, 9.81)
    assert wavenumber(frequency, depth, 9.81) == pytest.approx(kd / depth, rel=1e-12)


def test_shallow_and_deep_water_limits_of_the_dispersion():
    """omega = k sqrt(g d) for kd -> 0 and sqrt(g k) for kd -> infinity."""
    assert angular_frequency(1e-4, 1.0, 9.81) == pytest.approx(1e-4 * math.sqrt(9.81), rel=1e-8)
    assert angular_frequency(50.0, 1.0, 9.81) == pytest.approx(math.sqrt(9.81 * 50), rel=1e-12)


@pytest.mark.parametrize(("period", "depth", "gravity"), [(2.236969878, 1.0, 9.8), (0.3, 5.0, 9.81), (60.0, 0.7, 9.81)])
def test_phase_speed_is_wavelength_over_period(period, depth, gravity):
    """Between deep water, g T / (2 pi), and shallow water, sqrt(g d)."""
    c = phase_speed(period, depth, gravity)
    k = 2 * math.pi / (c * period)
    assert angular_frequency(k, depth, gravity) == pytest.approx(2 * math.pi / period, rel=1e-12)
    deep, shallow = gravity * period / (2 * math.pi), math.sqrt(gravity * depth)
    assert c < min(deep, shallow) * (1 + 1e-12)
    assert c == pytest.approx({0.3: deep, 60.0: shallow, 2.236969878: 6.061 / 2.236969878}[period], rel=3e-4)


# H/S of a flap hinged at the bed, Biesel (1951): (kd, H/S), evaluated in 40 decimal digits.
FLAP = [(0.1, 0.0500415141), (0.5, 0.2547437638), (1.0, 0.5280876236), (1.037, 0.5488367513), (2.0, 1.0412385909)]


@pytest.mark.parametrize(("kd", "transfer"), [*FLAP, (5.0, 1.6037523166)])
def test_flap_transfer_has_the_reference_numbers(kd, transfer):
    assert flap_transfer(kd) == pytest.approx(transfer, rel=1e-9)


@pytest.mark.parametrize("kd", [1e-3, 0.01, 0.05])
def test_flap_in_shallow_water_makes_waves_of_half_kd_strokes(kd):
    """H/S -> kd/2: the water that the triangle under the flap displaces leaves at sqrt(g d)."""
    assert flap_transfer(kd) == pytest.approx(0.5 * kd, rel=kd**2)


def test_flap_in_deep_water_makes_waves_of_two_strokes():
    """H/S -> 2 (1 - 1/kd) for kd -> infinity: all of the wave's motion is at the surface."""
    assert flap_transfer(40.0) == pytest.approx(2 * (1 - 1 / 40.0), rel=1e-10)


def test_flap_transfer_is_that_of_the_velocity_profile():
    """The propagating mode's share of the flap's velocity profile z/d, by quadrature (Dean & Dalrymple, section 6.3).

    ``H/S = 4 sinh(kd) int_0^d (z/d) cosh(kz) dz k / (sinh 2kd + 2kd)``.
    """
    z = np.linspace(0, 1, 20001)
    for kd in (0.3, 1.037, 2.5):
        profile = np.trapezoid(z * np.cosh(kd * z), z)
        expected = 4 * math.sinh(kd) * profile * kd / (math.sinh(2 * kd) + 2 * kd)
        assert flap_transfer(kd) == pytest.approx(expected, rel=1e-7)


def test_numbers_of_the_pool():
    """Molteni et al., section 3: the period is that of a 6.061 m wave on 1 m of water with g = 9.8."""
    scene = load_scene("pool")
    plate = maker_of(scene).motion
    k = wavenumber(2 * math.pi / plate.signal.period, scene.depth, scene.domain.gravity)
    assert (scene.domain.gravity, scene.depth, plate.signal.period) == (9.8, 1.0, 2.236969878)
    assert plate.signal.amplitude == pytest.approx(math.radians(5))
    assert 2 * math.pi / k == pytest.approx(6.061, abs=5e-4)
    assert flap_transfer(k * scene.depth) == pytest.approx(0.5486, abs=5e-4)
    stroke = 2 * math.sin(plate.signal.amplitude) * scene.depth
    assert stroke == pytest.approx(0.1743, abs=1e-4)
    least, largest = plate.reach(scene.depth)
    assert (largest - least) * flap_transfer(k * scene.depth) == pytest.approx(0.0956, abs=5e-4)


def test_viscosity_that_alpha_stands_for():
    """Half of Monaghan's (2005) alpha h c0 / 8 in 2D and / 10 in 3D, since approaching pairs alone feel it."""
    assert viscosity_of_alpha(0.02, 0.1, 60.0, 2) == pytest.approx(0.02 * 0.1 * 60.0 / 16)
    assert viscosity_of_alpha(0.02, 0.1, 60.0, 3) == pytest.approx(0.02 * 0.1 * 60.0 / 20)


SEICHE = Seiche(length=0.2, depth=0.2, amplitude=0.005, gravity=9.81)


def test_frequency_of_the_seiche():
    """Szmidt (2013), Fig. 2: 12.39 1/s for H = L = 0.2 m."""
    assert SEICHE.frequency == pytest.approx(12.39, abs=0.005)


def test_seiche_is_free_of_divergence_and_of_rotation():
    rng = np.random.default_rng(3)
    x, step = rng.uniform(0.02, 0.18, (50, 2)), 1e-5

    def slope(axis):
        shift = step * np.eye(2)[axis]
        return (SEICHE.velocity(x + shift) - SEICHE.velocity(x - shift)) / (2 * step)

    along, up = slope(0), slope(1)
    scale = np.abs(along).max()
    np.testing.assert_allclose(along[:, 0] + up[:, 1], 0, atol=1e-7 * scale)
    np.testing.assert_allclose(along[:, 1] - up[:, 0], 0, atol=1e-7 * scale)


def test_seiche_does_not_cross_bed_and_side_walls():
    height = np.linspace(0, 0.2, 11)
    for x in (0.0, 0.2):
        np.testing.assert_allclose(SEICHE.velocity(np.stack([0 * height + x, height], axis=1))[:, 0], 0, atol=1e-15)
    np.testing.assert_allclose(SEICHE.velocity(np.stack([height, 0 * height], axis=1))[:, 1], 0, atol=1e-15)


def test_seiche_lifts_the_surface_at_its_amplitude_times_frequency():
    """eta = A sin(omega t) cos(kx), so that d eta/dt = A omega cos(kx) at t = 0 is the vertical velocity at the surface."""
    x = np.linspace(0, 0.2, 9)
    up = SEICHE.velocity(np.stack([x, np.full(9, 0.2)], axis=1))[:, 1]
    np.testing.assert_allclose(up, 0.005 * SEICHE.frequency * np.cos(SEICHE.wavenumber * x), atol=1e-12)


def test_pulse_is_a_hump_that_travels_to_the_right():
    """Linear shallow-water equations, dH/dt = -H0 dv/dx and dv/dt = -g dH/dx: both are functions of x - sqrt(g H0) t."""
    x, depth, gravity = np.linspace(-20.0, 40.0, 4001), 2.5, 9.81
    level, velocity = pulse(x, depth, 0.02, 7.0, 3.0, gravity)
    assert level.max() == pytest.approx(2.52)
    assert x[level.argmax()] == pytest.approx(7.0)
    np.testing.assert_allclose(np.interp([4.0, 10.0], x, level), 2.5 + 0.02 / math.e, rtol=1e-7)
    c = math.sqrt(gravity * depth)
    flux, head = depth * np.gradient(velocity, x), gravity * np.gradient(level, x)
    np.testing.assert_allclose(flux, c * np.gradient(level, x), atol=1e-9)
    np.testing.assert_allclose(head, c * np.gradient(velocity, x), atol=1e-9)
    assert np.abs(head).max() > 0.01
    assert pulse([7.0], depth, 0.02, 7.0, 3.0, gravity)[1] == pytest.approx(0.02 * math.sqrt(gravity / depth))


@pytest.mark.parametrize(
    ("shape", "ratio"),
    [
        (("hyperbolic", 1, 0.7), lambda depth: depth / (20.0 - depth + 0.7)),
        (("hyperbolic", 1, 0.05), lambda depth: depth / (20.0 - depth + 0.05)),
        *((("power", m), lambda depth, m=m: (depth / 20.0) ** m) for m in (1, 2, 5)),
    ],
)
def test_reflection_of_a_layer_is_the_loss_on_the_way_there_and_back(shape, ratio):
    """By quadrature of sigma over the layer."""
    depth = 20.0 * (1 - np.linspace(1, 0, 200001) ** 3)
    integral = 0.3 * np.trapezoid(ratio(depth), depth)
    assert layer_reflection(0.3, 20.0, 3.1, *shape) == pytest.approx(math.exp(-2 * integral / 3.1), rel=1e-6)


def test_no_layer_reflects_everything():
    assert layer_reflection(0.3, 0, 3.1) == 1
    assert layer_reflection(0.0, 20.0, 3.1, "power", 2) == 1


def test_water_in_a_tank_that_moves_slowly_goes_with_it():
    """Three hundred times slower than its first mode it hardly sloshes."""
    theory, rate = Sloshing(1.0, 0.35, 9.81), 2 * math.pi / 400.0
    times = np.linspace(0.0, 400.0, 101)
    momentum = theory.momentum(times, lambda t: (rate * math.sin(rate * t), rate**2 * math.cos(rate * t)))
    np.testing.assert_allclose(momentum, rate * np.sin(rate * times), atol=3e-3 * rate)  # it begins with a jerk


def test_at_resonance_waves_in_a_tank_grow_with_time():
    """X = A sin(w t): the speed of the mode is -F A w^2 t sin(w t)/2, F = 4/pi tanh(k d)."""
    theory = Sloshing(1.0, 0.35, 9.81, modes=1)
    k, amplitude = math.pi, 0.01
    rate = math.sqrt(9.81 * k * math.tanh(0.35 * k))
    times = np.linspace(0.0, 20 * 2 * math.pi / rate, 401)

    def motion(t):
        return amplitude * rate * math.cos(rate * t), -amplitude * rate**2 * math.sin(rate * t)

    momentum = theory.momentum(times, motion)
    speed = -0.5 * 4 / math.pi * math.tanh(0.35 * k) * amplitude * rate**2 * times * np.sin(rate * times)
    expected = amplitude * rate * np.cos(rate * times) - 2 / (0.35 * k**2) * speed
    np.testing.assert_allclose(momentum, expected, atol=1e-5 * np.abs(expected).max())


def test_a_jerk_moves_the_water_beside_the_walls_alone():
    """Right after it the share of the water's mass that goes along is 1 - sum over odd n of 8 tanh(k_n d)/(k_n^3 L^2 d)."""
    theory = Sloshing(1.0, 0.35, 9.81, modes=40)
    momentum = theory.momentum([0.0, 1e-4], lambda t: (t, 1.0))[-1] / 1e-4
    k = np.pi * np.arange(1, 80, 2)
    assert momentum == pytest.approx(1 - (8 * np.tanh(0.35 * k) / (0.35 * k**3)).sum(), rel=1e-4)
    assert 0.3 < momentum < 0.45
