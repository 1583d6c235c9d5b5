"""Nonlinear regular waves obey the equations that they are to solve."""

import math
from functools import lru_cache

import numpy as np
import pytest

from parsph.errors import SceneError
from parsph.waves import REGULAR_THEORIES, dispersion, regular, regular_wave, second_harmonic

G = 9.81
CASES = [(0.1, 1.0, 2.0), (0.3, 1.0, 2.0), (0.02, 2.0, 0.9), (0.15, 0.6, 3.0)]  # H, d [m], T [s]


@lru_cache
def wave_of(case, theory="fenton"):
    height, depth, period = case
    return regular_wave(height, depth, G, period=period, theory=theory)


@pytest.mark.parametrize("case", CASES)
def test_stream_function_waves_solve_the_equations_at_the_surface(case):
    """In the frame of the crests the surface is a streamline and Bernoulli's sum is constant on it."""
    wave = wave_of(case)
    x = np.linspace(0, wave.wavelength, 1001)
    eta = wave.elevation(x, 0.3)
    u, w = wave.velocity(x, wave.depth + eta, 0.3).T
    along = u - wave.celerity
    np.testing.assert_allclose(along * np.gradient(eta, x, edge_order=2), w, atol=3e-4 * wave.celerity)
    bernoulli = 0.5 * (along**2 + w**2) + G * eta
    assert np.ptp(bernoulli) < 2e-5 * G * wave.height


@pytest.mark.parametrize("case", CASES)
def test_stream_function_waves_are_as_asked(case):
    height, depth, period = case
    wave = wave_of(case)
    assert wave.period == pytest.approx(period, rel=1e-9)
    assert wave.celerity * wave.period == pytest.approx(wave.wavelength)
    assert wave.elevation(0, 0) - wave.elevation(wave.wavelength / 2, 0) == pytest.approx(height, rel=1e-6)
    x = np.linspace(0, wave.wavelength, 400, endpoint=False)
    assert abs(wave.elevation(x, 0).mean()) < 1e-9, "the mean level is the still-water level"
    assert wave.wavelength > dispersion(depth, G, period=period).wavelength
    crest = wave.velocity(0, depth + wave.elevation(0, 0), 0)
    assert 0 < crest[0] < wave.celerity, "a crest whose water overtakes it breaks"
    assert abs(crest[1]) < 1e-12


@pytest.mark.parametrize("theory", REGULAR_THEORIES)
def test_velocity_has_no_mean_below_the_troughs_and_no_divergence(theory):
    wave, step = wave_of(CASES[1], theory), 1e-5
    t = np.linspace(0, wave.period, 200, endpoint=False)
    assert np.abs(wave.velocity(0.7, 0.4, t).mean(axis=0)).max() < 1e-12
    x, z = np.meshgrid(np.linspace(0, 5, 11), np.linspace(0.01, 0.9, 11))
    sides = [
        (wave.velocity(x + a, z + b, 0.2) - wave.velocity(x - a, z - b, 0.2)) / (2 * step) for a, b in ((step, 0), (0, step))
    ]
    np.testing.assert_allclose(sides[0][..., 0], -sides[1][..., 1], atol=1e-7)
    np.testing.assert_allclose(sides[1][..., 0], sides[0][..., 1], atol=1e-7)
    np.testing.assert_allclose(wave.velocity(x, 0 * z, 0.2)[..., 1], 0, atol=1e-15)


def test_waves_run_to_larger_x():
    wave = wave_of(CASES[0])
    assert wave.elevation(wave.celerity * 0.4, 0.4) == pytest.approx(wave.elevation(0, 0))


@pytest.mark.parametrize("theory", REGULAR_THEORIES)
def test_low_waves_of_all_theories_are_linear(theory):
    """``u = (omega H/2) cosh kz / sinh kd`` under the crest."""
    wave, linear = regular_wave(1e-4, 1.0, G, frequency=0.5, theory=theory), dispersion(1.0, G, period=2.0)
    assert wave.wavelength == pytest.approx(linear.wavelength, rel=1e-6)
    k = linear.wavenumber
    expected = linear.frequency * 0.5e-4 * math.cosh(0.3 * k) / math.sinh(k)
    assert wave.velocity(0, 0.3, 0)[0] == pytest.approx(expected, rel=1e-3)
    np.testing.assert_allclose(
        wave.elevation([0.0, 0.6], 0.1), 0.5e-4 * np.cos(k * np.array([0, 0.6]) - 0.1 * math.pi), atol=1e-7
    )


def test_fifth_order_and_stream_function_agree():
    one, other = (wave_of(CASES[0], theory) for theory in ("stokes", "fenton"))
    assert one.wavelength == pytest.approx(other.wavelength, rel=1e-6)
    np.testing.assert_allclose(one.elevations, other.elevations[:5], atol=1e-6)
    np.testing.assert_allclose(one.velocities, other.velocities[:5], atol=1e-5)
    share = other.elevations[1] / other.elevations[0]
    assert share == pytest.approx(second_harmonic(0.1, other.wavelength, 1.0), rel=0.02)


def test_deep_water_does_not_overflow():
    wave = regular_wave(0.05, 60.0, G, wavelength=1.0)
    assert np.isfinite(wave.velocity(0.2, [0.0, 30.0, 60.0], 0.1)).all()
    assert wave.celerity == pytest.approx(math.sqrt(G / (2 * math.pi)) * (1 + 0.5 * (0.05 * math.pi) ** 2), rel=1e-3)


def test_faults_say_what_is_valid():
    with pytest.raises(SceneError, match=r"height: is 0\.9 m; steady waves .* m long have at most 0\.\d+ m; a lower"):
        regular_wave(0.9, 1.0, G, period=2.0)
    with pytest.raises(SceneError, match=r"H L\^2/d\^3 is 188, and the series needs less than 40; 'fenton'"):
        regular_wave(0.3, 1.0, G, wavelength=25.0, theory="stokes")
    with pytest.raises(SceneError, match="did you mean 'fenton'"):
        regular_wave(0.3, 1.0, G, period=2.0, theory="fentom")
    with pytest.raises(SceneError, match="exactly one"):
        regular_wave(0.3, 1.0, G)


@pytest.mark.parametrize("theory", REGULAR_THEORIES)
@pytest.mark.parametrize("depth", [3.0, 15.0, 60.0, 120.0, 1e3, 1e9])
def test_water_of_any_depth_has_waves_or_a_reason(theory, depth):
    try:
        wave = regular_wave(0.05, depth, G, wavelength=1.0, theory=theory)
    except SceneError as error:
        assert error.where == "wavelength"  # noqa: PT017
        assert depth > 15.0
        return
    assert np.isfinite(wave.velocity(0.2, [0.0, 0.5 * depth, depth], 0.1)).all()


def test_a_search_that_finds_no_wave_of_a_period_ends(monkeypatch):
    """So near the highest wave the equations have several solutions, between which the period jumps."""
    monkeypatch.setattr(regular, "MOST_SOLUTIONS", 4)
    with pytest.raises(SceneError, match=r"height: no wave of 20 s could be found; near the highest wave.*; a lower or short"):
        regular_wave(0.375, 0.5, 1.5, frequency=0.05)
