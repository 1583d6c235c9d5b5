"""Equations of state."""

import numpy as np
import pytest

from parsph.particles import FIRST_GHOST
from parsph.states import STATES, State, density_of, pressure_of, update_pressure

DENSITIES = np.linspace(850.0, 1150.0, 31)


@pytest.fixture(params=[(name, gamma) for name in STATES for gamma in (7.0, 1.4)], ids=lambda p: f"{p[0]}-{p[1]:g}")
def state(request):
    name, gamma = request.param
    return State(name, 1000.0, 31.0, gamma)


def test_pressure_and_density_are_inverse(state):
    np.testing.assert_allclose(state.density(state.pressure(DENSITIES)), DENSITIES, rtol=1e-13)


def test_reference_density_has_no_pressure(state):
    assert float(state.pressure(state.rho0)) == 0
    assert float(state.density(0.0)) == state.rho0


def test_sound_speed_is_c0_at_the_reference_density(state):
    """dp/drho = c0^2 at rho0, by central differences."""
    step = 0.01
    slope = (state.pressure(state.rho0 + step) - state.pressure(state.rho0 - step)) / (2 * step)
    assert float(slope) == pytest.approx(state.c0**2, rel=1e-6)


def test_derivative_of_the_compressible_energy_is_pressure_over_density_squared(state):
    step = 0.01
    slope = (state.energy(DENSITIES + step) - state.energy(DENSITIES - step)) / (2 * step)
    expected = state.pressure(DENSITIES) / DENSITIES**2
    np.testing.assert_allclose(slope, expected, atol=1e-6 * np.abs(expected).max())


def test_compressible_energy_is_smallest_and_zero_at_the_reference_density(state):
    assert float(state.energy(state.rho0)) == pytest.approx(0, abs=1e-12)
    assert (state.energy(DENSITIES[DENSITIES != 1000.0]) > 0).all()


def test_compiled_and_numpy_forms_agree(state):
    for density in DENSITIES:
        pressure = pressure_of(density, state.constants)
        assert pressure == pytest.approx(float(state.pressure(density)), rel=1e-12, abs=1e-9)
        assert density_of(pressure, state.constants) == pytest.approx(density, rel=1e-12)


@pytest.mark.parametrize(("value", "found"), [(1400.0, 2), (600.0, 2), (np.nan, 2), (1000.0, -1)])
def test_density_out_of_range_is_found(state, value, found):
    """NaN included: it must stay visible to compiled comparisons. Images are not judged."""
    rows = np.zeros((5, 7))
    rows[:, 4] = 1010.0
    rows[2, 4] = value
    tags = np.arange(5)
    rows[0, 4], tags[0] = np.nan, FIRST_GHOST
    assert update_pressure(rows, tags, 0, 5, 4, 700.0, 1300.0, state.constants) == found
    assert rows[1, 5] == pytest.approx(float(state.pressure(1010.0)))
