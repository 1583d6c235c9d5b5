"""Linear waves: one of period, frequency and wavelength gives the rest; limits; what is imported when."""

import math

import pytest
from helpers import python

from parsph.errors import SceneError
from parsph.waves import (
    angular_frequency,
    breaking_height,
    decay_in_space,
    decay_in_time,
    dispersion,
    group_speed,
    highest_wave,
    mccowan,
    miche,
    regime,
    second_harmonic,
    ursell,
    viscosity_of_alpha,
)


@pytest.mark.parametrize("period", [0.5, 2.0, 20.0])
def test_period_frequency_and_wavelength_give_the_same_wave(period):
    wave = dispersion(1.3, 9.81, period=period)
    for other in (dispersion(1.3, 9.81, frequency=1 / period), dispersion(1.3, 9.81, wavelength=wave.wavelength)):
        for name, value in vars(wave).items():
            assert getattr(other, name) == pytest.approx(value, rel=1e-11), name
    assert wave.frequency == pytest.approx(2 * math.pi / period)
    assert wave.phase_speed == pytest.approx(wave.wavelength / period)
    assert wave.kd == pytest.approx(2 * math.pi / wave.wavelength * 1.3)


@pytest.mark.parametrize("given", [{}, {"period": 1.0, "frequency": 1.0}, {"period": 1.0, "frequency": 1.0, "wavelength": 2.0}])
def test_exactly_one_must_be_given(given):
    with pytest.raises(SceneError, match=rf"but got {' and '.join(given) or 'none'}; .* give one of them"):
        dispersion(1.0, 9.81, **given)


@pytest.mark.parametrize("period", [0.0, -1.0, math.inf, math.nan])
def test_a_period_is_a_number_above_0(period):
    with pytest.raises(SceneError, match=r"period: is .*; a number above 0"):
        dispersion(1.0, 9.81, period=period)


@pytest.mark.parametrize("kd", [1e-3, 0.3, 1.0, 4.0, 200.0, 1e4])
def test_group_speed_is_the_slope_of_the_dispersion(kd):
    step = 1e-5 * kd
    slope = (angular_frequency(kd + step, 1.0, 9.81) - angular_frequency(kd - step, 1.0, 9.81)) / (2 * step)
    assert group_speed(kd, 1.0, 9.81) == pytest.approx(slope, rel=1e-8)


def test_group_speed_is_that_of_the_waves_on_shallow_and_half_of_it_on_deep_water():
    assert group_speed(1e-4, 1.0, 9.81) == pytest.approx(math.sqrt(9.81), rel=1e-7)
    assert group_speed(100.0, 1.0, 9.81) == pytest.approx(0.5 * math.sqrt(9.81 / 100), rel=1e-12)


def test_viscous_decay_of_a_tank():
    """alpha = 0.02, h = 0.015 m, c0 = 20 m/s: nu = 3.75e-4 m^2/s, which takes 0.2 % a metre at k = 2 1/m, c_g = 1.5 m/s."""
    nu, k, depth = viscosity_of_alpha(0.02, 0.015, 20.0, 2), 2.0, 0.6
    assert nu == pytest.approx(3.75e-4)
    assert decay_in_time(nu, k) == pytest.approx(3e-3)
    assert decay_in_space(nu, k, depth, 9.81) * group_speed(k, depth, 9.81) == pytest.approx(3e-3)
    assert decay_in_space(nu, k, depth, 9.81) == pytest.approx(0.002, rel=0.2)


def test_breaking_in_deep_and_shallow_water():
    """A seventh of the wavelength, and 0.83 depths."""
    assert miche(1.0, 5.0) == pytest.approx(0.142)
    assert breaking_height(5.0, 1.0) == miche(1.0, 5.0)
    assert breaking_height(2.0) == breaking_height(2.0, 1e3) == pytest.approx(2 * 0.8332)
    assert miche(1e3, 2.0) > 2 * 0.8332
    assert mccowan(2.0) == pytest.approx(1.56)


def test_highest_steady_waves():
    """Both ends are known, 0.1411 L in deep water and 0.8332 d of a solitary wave; between them Miche's are up to 17 % more."""
    assert highest_wave(0.01, 1.0) == pytest.approx(0.1411 * 0.01, rel=2e-3)
    assert highest_wave(1e6, 1.0) == pytest.approx(0.8332, rel=1e-4)
    for length in (1.0, 3.0, 6.0, 10.0, 20.0):
        assert highest_wave(length, 1.0) < 1.005 * breaking_height(1.0, length) < 1.17 * highest_wave(length, 1.0)


def test_second_harmonic_in_deep_and_shallow_water():
    """kH/4 of the first, and 3 H L^2/(32 pi^2 d^3) of it."""
    assert second_harmonic(0.01, 1.0, 10.0) == pytest.approx(2 * math.pi * 0.01 / 4)
    assert second_harmonic(0.01, 100.0, 1.0) == pytest.approx(3 / (32 * math.pi**2) * ursell(0.01, 100.0, 1.0), rel=0.01)


@pytest.mark.parametrize(
    ("height", "wavelength", "expected"),
    [
        (0.0001, 5.0, "linear"),
        (0.005, 1.0, "linear"),
        (0.05, 1.0, "stokes"),
        (0.2, 5.0, "stokes"),
        (0.2, 12.0, "cnoidal or stream function"),
        (0.15, 1.0, "breaking"),
        (0.9, 50.0, "breaking"),
    ],
)
def test_regime(height, wavelength, expected):
    assert regime(height, wavelength, 1.0) == expected


def test_linear_ends_in_deep_water_where_le_mehaute_has_it():
    """H/(g T^2) = 0.001."""
    length = 9.81 / (2 * math.pi)  # of T = 1 s
    assert regime(0.98 * 0.001 * 9.81, length, 20.0) == "linear"
    assert regime(1.03 * 0.001 * 9.81, length, 20.0) == "stokes"


def test_slow_libraries_are_not_imported_before_they_are_needed(tmp_path):
    result = python("-c", "import sys, parsph.waves; print(sorted({'scipy', 'raschii'} & set(sys.modules)))", cwd=tmp_path)
    assert result.stdout.strip() == "[]", result.stderr
