"""Equations of state."""

import numpy as np
import pytest

from parsph.particles import FIELDS, FIRST_GHOST
from parsph.states import STATES, State, density_gap, density_of, pressure_of, update_pressure

DENSITIES = np.linspace(850.0, 1150.0, 31)


@pytest.fixture(params=[(name, gamma) for name in STATES for gamma in (7.0, 1.4)], ids=lambda p: f"{p[0]}-{p[1]:g}")
def state(request):
    name, gamma = request.param
    return State(name, 1000.0, 31.0, gamma)


def test_pressure_and_density_are_inverse(state):
    np.testing.assert_allclose(state.density(state.pressure(DENSITIES)), DENSITIES, rtol=1e-13)


def test_reference_density_has_no_pressure(state):
    """In shallow water it is no depth that has none."""
    reference = 0.0 if state.name == "shallow" else state.rho0
    assert float(state.pressure(reference)) == 0
    assert float(state.density(0.0)) == reference


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
    """In shallow water the energy of a column, g H/2 over that of the reference depth, has no smallest value."""
    assert float(state.energy(state.rho0)) == pytest.approx(0, abs=1e-12)
    others = DENSITIES[DENSITIES != 1000.0]
    signs = np.sign(others - 1000.0) if state.name == "shallow" else 1
    assert (signs * state.energy(others) > 0).all()


def test_compiled_and_numpy_forms_agree(state):
    for density in DENSITIES:
        pressure = pressure_of(density, state.constants)
        assert pressure == pytest.approx(float(state.pressure(density)), rel=1e-12, abs=1e-9)
        assert density_of(pressure, state.constants) == pytest.approx(density, rel=1e-12)


def test_gap_of_a_density_is_its_relative_distance_from_that_of_a_pressure(state):
    """A Newton step where the state is a power law: off by (gamma - 1)/2 of the square of the gap, and exact elsewhere."""
    for density in DENSITIES[::5]:
        for gap in (-0.02, -1e-4, 0.0, 1e-4, 0.02):
            pressure = float(state.pressure(density * (1 + gap)))
            found = density_gap(pressure, density, state.constants)
            error = 0.55 * (state.gamma - 1) * gap**2 if state.name == "tait" else 0.0
            assert found == pytest.approx(gap, rel=1e-9, abs=error + 1e-12)


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


GRAVITY, DEPTHS = 9.81, np.array([1e-3, 0.2, 1.0, 1.7, 30.0])


@pytest.fixture
def shallow():
    """Water of 1.7 m: sqrt(g H) is the speed of long waves on it."""
    return State("shallow", 1.7, np.sqrt(GRAVITY * 1.7), 7.0)


def test_pressure_of_shallow_water_is_that_of_its_column(shallow):
    """p = g H^2 / 2, the hydrostatic pressure over the depth, whatever the reference depth."""
    np.testing.assert_allclose(shallow.pressure(DEPTHS), 0.5 * GRAVITY * DEPTHS**2, rtol=1e-14)
    np.testing.assert_allclose(shallow.density(shallow.pressure(DEPTHS)), DEPTHS, rtol=1e-14)
    for depth in DEPTHS:
        assert density_of(pressure_of(depth, shallow.constants), shallow.constants) == pytest.approx(depth, rel=1e-14)


def test_energy_of_shallow_water_is_half_g_times_the_depth(shallow):
    """Times the mass H dx that is g H^2/2 dx, the potential energy of the column, up to a constant per mass."""
    energy = shallow.energy(DEPTHS)
    np.testing.assert_allclose(energy - energy[0], 0.5 * GRAVITY * (DEPTHS - DEPTHS[0]), rtol=1e-13)


def test_units_of_shallow_water_are_those_of_a_depth(shallow):
    units = {field.name: shallow.unit(field) for field in FIELDS}
    assert (units["density"], units["pressure"], units["mass"]) == ("m", "m^3/s^2", "m^2")
    assert (units["position"], units["velocity"]) == ("m", "m/s")
    for name in ("tait", "linear"):
        for field in FIELDS:
            assert State(name, 1000.0, 31.0, 7.0).unit(field) == field.unit


def test_what_the_integrator_keeps_has_the_unit_of_what_it_is_kept_of(shallow):
    """`parsph plan` and every snapshot's metadata name it."""
    for field in FIELDS:
        if field.name.startswith("start_"):
            of = next(other for other in FIELDS if other.name == field.name.removeprefix("start_"))
            assert shallow.unit(field) == shallow.unit(of)
