"""What paddles make: transfer, near field, second harmonic."""

import math

import numpy as np
import pytest

from parsph.errors import SceneError
from parsph.waves import (
    dispersion,
    evanescent_wavenumbers,
    flap_transfer,
    free_second_harmonic,
    madsen_limit,
    near_field,
    second_order,
    second_order_full,
    transfer,
    velocity_profile,
    wavenumber,
)
from parsph.waves.paddles import _cancelling

HINGES = [None, -1.5, 0.0, 0.4]
every_hinge = pytest.mark.parametrize("hinge", HINGES)


def shape(z, hinge):
    return np.ones_like(z) if hinge is None else np.maximum(z - hinge, 0) / (1 - hinge)


# H/S of piston and flap at the bed, Biesel (1951), evaluated apart from this code.
BIESEL = [
    (0.05, 0.049999993, 0.025005204),
    (0.2, 0.19999294, 0.10032847),
    (0.45, 0.44960563, 0.22852109),
    (1.0, 0.98178931, 0.52808762),
    (2.0, 1.6815789, 1.0412386),
    (5.0, 1.9980042, 1.6037523),
]


@pytest.mark.parametrize(("kd", "piston", "flap"), BIESEL)
def test_transfer_has_the_reference_numbers(kd, piston, flap):
    assert transfer(kd) == pytest.approx(piston, rel=6e-8)
    assert transfer(kd, 0) == pytest.approx(flap, rel=6e-8)
    assert flap_transfer(kd) == transfer(kd, 0)


@every_hinge
@pytest.mark.parametrize("kd", [0.3, 1.0, 4.0])
def test_transfer_is_the_progressive_share_of_the_paddle_s_shape(kd, hinge):
    """By quadrature: ``H/S = 4 sinh kd/(sinh 2kd + 2kd) k int f cosh kz dz``."""
    z = np.linspace(0, 1, 20001)
    share = kd * np.trapezoid(shape(z, hinge) * np.cosh(kd * z), z)
    assert transfer(kd, hinge) == pytest.approx(4 * math.sinh(kd) * share / (math.sinh(2 * kd) + 2 * kd), rel=1e-6)


@every_hinge
def test_long_waves_carry_the_water_that_the_paddle_displaces(hinge):
    """H/S -> kd int f dz / d for kd -> 0."""
    z = np.linspace(0, 1, 100001)
    assert transfer(1e-4, hinge) == pytest.approx(1e-4 * np.trapezoid(shape(z, hinge), z), rel=1e-7)


@every_hinge
def test_deep_water_sees_the_top_of_the_paddle_alone(hinge):
    """H/S -> 2 (1 - 1/((1 - e) kd))."""
    slope = 0 if hinge is None else 1 / (1 - hinge)
    for kd in (40.0, 50.0, 300.0):
        assert transfer(kd, hinge) == pytest.approx(2 * (1 - slope / kd), rel=1e-9)


@pytest.mark.parametrize("kd", [0.2, 1.3, 6.0])
def test_transfer_goes_on_smoothly_as_the_hinge_passes_the_bed(kd):
    below, bed, above = (transfer(kd, hinge) for hinge in (-1e-7, 0.0, 1e-7))
    assert below > bed > above
    assert below - above < 1e-6
    assert transfer(kd, -1e9) == pytest.approx(transfer(kd), rel=1e-8), "a hinge infinitely deep makes a piston"
    assert abs(second_order_full(0.1, kd, 1.0, -1e9) - second_order_full(0.1, kd, 1.0)) < 1e-9


@pytest.mark.parametrize("hinge", [1.0, 1.5, math.nan])
def test_a_hinge_above_the_water_is_an_error(hinge):
    with pytest.raises(SceneError, match="turns about a point below the still-water level; a number below 1"):
        transfer(1.0, hinge)


@pytest.mark.parametrize("kd", [0.01, 1.0, 50.0])
def test_evanescent_modes_solve_their_dispersion(kd):
    k = evanescent_wavenumbers(kd, 30)
    number = np.arange(1, 31)
    assert (((number - 0.5) * math.pi < k) & (k < number * math.pi)).all()
    np.testing.assert_allclose(-k * np.sin(k), kd * math.tanh(kd) * np.cos(k), atol=1e-10 * max(kd, 1) * 30)


@every_hinge
@pytest.mark.parametrize("kd", [0.4, 1.0, 5.0, 50.0])
def test_the_linear_solution_has_the_paddle_s_velocity_at_all_depths(kd, hinge):
    """Far wave plus modes: f(z) w S/2 cos wt. The sign of each mode and its amplitude follow from it."""
    z = np.linspace(0, 0.97, 60)
    np.testing.assert_allclose(velocity_profile(kd, hinge, z, 3000), shape(z, hinge), atol=4e-4)


@every_hinge
@pytest.mark.parametrize("kd", [0.4, 1.5, 5.0])
def test_far_wave_and_near_field_take_up_the_water_that_the_paddle_displaces(kd, hinge):
    """``k int f dz = H/S + k int E dx``, from ``d/dt int eta dx = int u dz`` and the far wave's flux c eta."""
    x = np.linspace(0, 1, 200001) ** 3 * 12
    z = np.linspace(0, 1, 20001)
    stored = np.trapezoid(near_field(kd, hinge, x, modes=30), x)
    displaced = np.trapezoid(shape(z, hinge), z)
    assert transfer(kd, hinge) / kd + stored == pytest.approx(displaced, rel=2e-3)


def test_near_field_of_a_piston_is_a_hump_before_it_while_it_is_forward():
    """Gone after three depths."""
    for kd in (0.5, 1.0, 2.0, 5.0):
        assert near_field(kd) > 0
        assert abs(near_field(kd, x_over_depth=3.0)) < 0.01 * near_field(kd)
    np.testing.assert_allclose(near_field(2.0, None, np.array([0.0, 0.5])), [near_field(2.0), near_field(2.0, None, 0.5)])


def test_madsen_s_second_harmonic():
    """Madsen (1971) by hand for kd = 0.5, H = 0.1 m, d = 1 m: cosh/sinh^3 = 7.9675, m1 = 0.49934."""
    expected = 0.01 / 32 * (3 * math.cosh(0.5) / math.sinh(0.5) ** 3 - 2 / 0.4993383)
    assert second_order(0.1, 0.5, 1.0) == pytest.approx(expected, rel=1e-6)
    assert second_order(0.2, 0.5, 2.0) == pytest.approx(2 * expected, rel=1e-6)
    assert second_order(0.1, 50.0, 1.0) == pytest.approx(-0.01 / 32, rel=1e-9)


def test_madsen_s_limit():
    assert madsen_limit(0.2, 11.4, 1.0)
    assert not madsen_limit(0.2, 11.5, 1.0)
    assert 0.2 * 11.4**2 < 8 * math.pi**2 / 3 < 0.2 * 11.5**2


@pytest.mark.parametrize(("kd", "error"), [(0.05, 2e-5), (0.1, 1e-4), (0.2, 1.2e-3), (0.3, 6e-3)])
def test_the_full_second_order_of_a_piston_is_madsen_s_in_long_waves(kd, error):
    """Sign, phase and size; both of Madsen's terms count: at kd = 0.3 the second has a tenth of the first."""
    full, madsen = second_order_full(0.1, kd, 1.0), second_order(0.1, kd, 1.0)
    assert full.real == pytest.approx(madsen, rel=error)
    assert abs(full.imag) < 1e-4 * full.real
    without = 0.01 / 32 * 3 * math.cosh(kd) / math.sinh(kd) ** 3
    assert abs(without / full.real - 1) > 4 * error


@pytest.mark.parametrize("hinge", [-1.0, 0.0, 0.3])
def test_flaps_need_more_second_harmonic_in_long_waves(hinge):
    """All paddles that make a long wave push alike the water of its bound second harmonic: ``E2 int f dz`` is one number."""
    z = np.linspace(0, 1, 20001)
    carried = second_order_full(0.1, 0.02, 1.0, hinge) * np.trapezoid(shape(z, hinge), z)
    assert carried == pytest.approx(second_order_full(0.1, 0.02, 1.0), rel=3e-3)


@every_hinge
def test_the_sums_over_modes_have_converged(hinge):
    for kd in (0.3, 1.0, 3.0):
        few, many = (second_order_full(1.0, kd, 1.0, hinge, modes) for modes in (100, 300))
        assert abs(few - many) < 2e-4 * abs(many)


def test_forcing_of_the_progressive_wave_is_that_of_stokes():
    """Far away the second-order potential is ``(3/8) a^2 omega cosh 2kz / sinh^4 kd sin 2(kx - wt)``.

    From ``Q = -iw b^2 (k_0^2 3/2 + 3/2 (w^2/g)^2)``, ``k_0 = ik``, over ``-4 w^2 + 2gk tanh 2kd``, with ``b = i g a / w``.
    """
    for kd in (0.4, 1.0, 2.0):
        head, a = kd * math.tanh(kd), 0.01
        w = math.sqrt(head)
        forcing = -1j * w * (1j * a / w) ** 2 * 1.5 * (head**2 - kd**2)
        bound = forcing / (2 * kd * math.tanh(2 * kd) - 4 * head)
        stokes = 3 / 8 * a**2 * w * math.cosh(2 * kd) / math.sinh(kd) ** 4
        assert bound == pytest.approx(1j * stokes, rel=1e-12)  # Re[i exp 2i(wt - kx)] = sin 2(kx - wt)


def test_free_second_harmonic_in_long_waves_is_as_large_as_the_bound_one():
    """A long piston's sine sends out a free wave that hides the bound one at the paddle: ``a = 3 H^2/(16 k^2 d^3)``."""
    kd, height = 0.05, 0.001
    assert free_second_harmonic(height, kd, 1.0) == pytest.approx(3 / 16 * height**2 / kd**2, rel=0.01)
    wave = dispersion(1.0, 9.81, period=3.0)
    assert free_second_harmonic(0.2, wave.kd, 1.0) == pytest.approx(4 * free_second_harmonic(0.1, wave.kd, 1.0))


@every_hinge
def test_the_second_harmonic_satisfies_the_equations_of_second_order(hinge):
    """The free mode's projection of the equations themselves, with products formed in time and integrals by quadrature.

    ``phi2_tt + g phi2_z = -d/dt |grad phi1|^2 - eta1 d/dz (phi1_tt + g phi1_z)`` at the surface and
    ``phi2_x = dX2/dt + X1 phi1_zz + dX1/dz phi1_z`` at the paddle, for a first order of six modes and d = g = H = 1.
    """
    kd, modes = 1.1, 6
    w = math.sqrt(kd * math.tanh(kd))
    K, half = wavenumber(2 * w, 1.0, 1.0), 0.5 / transfer(kd, hinge)
    k = np.concatenate([[1j * kd], evanescent_wavenumbers(kd, modes)])
    node, weight = np.polynomial.legendre.leggauss(60)
    node, weight = 0.5 * (node + 1), 0.5 * weight
    foot = 0.0 if hinge is None else max(hinge, 0.0)

    inside = np.concatenate([[0.0] if foot == 0 else foot * node, foot + (1 - foot) * node])
    share = np.concatenate([[0.0] if foot == 0 else foot * weight, (1 - foot) * weight])
    f = shape(inside, hinge)
    slope = np.where(f > 0, 0 if hinge is None else 1 / (1 - hinge), 0.0)
    mode = np.cos(k * inside[:, None])
    norm = (2 * k + np.sin(2 * k)) / (4 * k)
    part = -w * half * (share * f) @ mode / norm / k  # so that -k part cos(kz) sums to f w half

    phases = 2 * math.pi * np.arange(8) / 8

    def second(product):
        """Complex amplitude of exp(2iwt) in a product of fields, from eight times of a period."""
        return 2 * np.mean([product(np.exp(1j * phase)) * np.exp(-2j * phase) for phase in phases], axis=0)

    def forcing(x, part):
        wave = part * np.cos(k) * np.exp(-k * np.asarray(x)[:, None])

        def product(turn):
            def field(factor):
                return (wave * factor * turn).sum(1).real

            tan = -k * np.tan(k)  # d/dz of a mode over itself at the surface
            square = 2 * (field(-k) * field(-k * 1j * w) + field(tan) * field(tan * 1j * w))
            return -square + field(1j * w) * field(-(w**2) * tan - k**2)  # eta1 = -phi1_t

        return second(product)

    def moved(turn):
        displaced = (-1j * half * turn).real
        rise = (part * -k * np.sin(k * inside[:, None]) * turn).sum(1).real
        bend = (part * -(k**2) * mode * turn).sum(1).real
        return displaced * (f * bend + slope * rise)

    free = np.cosh(K * inside) / math.cosh(K)
    alone = part * (np.arange(modes + 1) == 0)
    x, far = np.linspace(0, 1, 20001) ** 2 * 15, forcing([0.0], alone)[0]
    near = np.trapezoid(np.cos(K * x) * (forcing(x, part) - forcing(x, alone)), x)
    surface = near + far * 2j * kd / (K**2 - 4 * kd**2)  # the far wave's, int cos(Kx) exp(-2ikx) dx without its end at infinity
    needed = (surface - (share * free) @ second(moved)) / (2 * w * (share * free) @ f)
    assert needed == pytest.approx(_cancelling(kd, -math.inf if hinge is None else hinge, modes), rel=1e-5)
