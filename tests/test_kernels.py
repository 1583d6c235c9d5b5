"""Smoothing kernels against quadrature and finite differences."""

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import quad
from scipy.interpolate import BSpline

from parsph.errors import SceneError
from parsph.kernels import FORMULAS, GAUSSIAN_CUT, KERNELS, kernel_named, kernel_slope, kernel_value

DIMS = (1, 2, 3)
every_kernel = pytest.mark.parametrize("kernel", KERNELS.values(), ids=list(KERNELS))


def moment(kernel, dim, power):
    """``int W |r/h|^power dV`` by adaptive quadrature, which is told where the polynomial pieces end."""
    h, surface = 0.37, (2, 2 * math.pi, 4 * math.pi)[dim - 1]

    def shell(r):
        return float(kernel.value(r, h, dim)) * surface * r ** (dim - 1) * (r / h) ** power

    knots = h * np.arange(0.5, kernel.support, 0.5)
    return quad(shell, 0, kernel.support * h, points=knots, epsabs=1e-13, epsrel=1e-13)[0]


@every_kernel
@pytest.mark.parametrize("dim", DIMS)
def test_kernel_integrates_to_one(kernel, dim):
    """The integral over the support, ``int W S r^(dim-1) dr`` with the unit sphere's surface S, is 1."""
    assert moment(kernel, dim, 0) == pytest.approx(1, abs=1e-11)


@every_kernel
@pytest.mark.parametrize("dim", DIMS)
def test_slope_is_derivative_of_value(kernel, dim):
    """dW/dr by central differences, away from the ends of the polynomial pieces."""
    h = 0.37
    q = np.linspace(0.013, kernel.support - 0.017, 97)
    r, step = h * q[np.abs(2 * q - np.round(2 * q)) > 1e-3], 1e-5 * h
    assert len(r) > 80
    difference = (kernel.value(r + step, h, dim) - kernel.value(r - step, h, dim)) / (2 * step)
    scale = np.abs(difference).max()
    np.testing.assert_allclose(kernel.slope(r, h, dim), difference, atol=2e-9 * scale)


def bump(power, rest):
    """The polynomial ``(1 - q/2)^power * rest`` of Wendland's kernels."""
    return Polynomial([1, -0.5]) ** power * Polynomial(rest)


WENDLANDS = {
    "wendland-c2": (bump(4, [1, 2]), 1),
    "wendland-c4": (bump(6, [1, 3, 35 / 12]), 2),
    "wendland-c6": (bump(8, [1, 4, 25 / 4, 4]), 3),
}


@pytest.mark.parametrize("name", WENDLANDS)
def test_wendland_kernels_have_the_smoothness_of_their_names(name):
    """C2k: no odd power of q up to 2k - 1, so that W is 2k times differentiable at its centre."""
    profile, k = WENDLANDS[name]
    q = np.linspace(0, 2, 33)
    np.testing.assert_allclose(KERNELS[name].value(q, 1.0, 2) / KERNELS[name].norms[1], profile(q), atol=1e-14)
    odd = profile.coef[1::2]
    np.testing.assert_allclose(odd[:k], 0, atol=1e-14)
    assert abs(odd[k]) > 0.1


SPLINES = {"quadratic-spline": 3, "cubic-spline": 4, "quartic-spline": 5, "quintic-spline": 6}


@pytest.mark.parametrize("name", SPLINES)
def test_splines_in_one_dimension_are_the_cardinal_ones(name):
    """M_n on n intervals of length h, with unit integral and the sum over a lattice of spacing h always 1."""
    kernel, order = KERNELS[name], SPLINES[name]
    assert kernel.support == order / 2
    cardinal = BSpline.basis_element(np.arange(order + 1) - order / 2)
    q = np.linspace(0, order / 2, 41)
    np.testing.assert_allclose(kernel.value(q, 1.0, 1), cardinal(q), atol=1e-14)
    lattice = np.arange(-4, 5)[:, None] + np.linspace(0, 1, 11)
    np.testing.assert_allclose(kernel.value(np.abs(lattice), 1.0, 1).sum(axis=0), 1, atol=1e-14)


@every_kernel
@pytest.mark.parametrize("dim", DIMS)
def test_spread_is_the_standard_deviation_in_one_direction(kernel, dim):
    assert kernel.spread(dim) == pytest.approx(math.sqrt(moment(kernel, dim, 2) / dim), rel=1e-11)


def test_the_gaussian_takes_the_supports_of_the_paper():
    """Szmidt: delta = 3d, 4d, 5d with Q = 3, so h/dx = 1, 4/3, 5/3."""
    low, high = KERNELS["gaussian"].h_over_dx
    assert low <= 1
    assert high >= 5 / 3
    assert [GAUSSIAN_CUT * h for h in (1, 4 / 3, 5 / 3)] == pytest.approx([3, 4, 5])


@every_kernel
def test_names_and_codes_are_unique_and_the_default_suits_every_kernel(kernel):
    assert sum(other.code == kernel.code for other in KERNELS.values()) == 1
    assert kernel.h_over_dx[0] <= 2.0 <= kernel.h_over_dx[1]


@every_kernel
def test_kernel_falls_from_the_centre_and_is_never_negative(kernel):
    r = np.linspace(0, kernel.support, 400)
    assert (np.diff(kernel.value(r, 1.0, 2)) <= 1e-15).all()
    assert (kernel.value(r, 1.0, 2) >= 0).all()


@every_kernel
@pytest.mark.parametrize("dim", DIMS)
def test_kernel_and_slope_vanish_beyond_the_support(kernel, dim):
    """The slope vanishes exactly; the Gaussian's value to the rounding of exp(-9) - exp(-9)."""
    r = 0.5 * kernel.support * np.array([1 + 1e-9, 1.01, 2.0, 1e4])
    np.testing.assert_allclose(kernel.value(r, 0.5, dim), 0, atol=1e-15 * kernel.value(0.0, 0.5, dim))
    assert (kernel.slope(r, 0.5, dim) == 0).all()


def test_gaussian_norm_in_two_dimensions_is_that_of_the_paper():
    """Szmidt (2013) eq. (6): ``N = pi h^2 [1 - exp(-Q^2)(1 + Q^2)]``, and W = (exp(-q^2) - exp(-Q^2)) / N."""
    h, q, cut = 0.6, 0.8, GAUSSIAN_CUT
    norm = math.pi * h**2 * (1 - math.exp(-(cut**2)) * (1 + cut**2))
    expected = (math.exp(-(q**2)) - math.exp(-(cut**2))) / norm
    assert float(KERNELS["gaussian"].value(q * h, h, 2)) == pytest.approx(expected, rel=1e-12)


def test_wendland_c2_is_that_of_the_paper():
    """Molteni et al. eq. (1.7) in 2D: ``7/(4 pi h^2) (1 - q/2)^4 (1 + 2q)``."""
    h, q = 0.6, np.linspace(0, 2, 9)
    expected = 7 / (4 * math.pi * h**2) * (1 - q / 2) ** 4 * (1 + 2 * q)
    np.testing.assert_allclose(KERNELS["wendland-c2"].value(q * h, h, 2), expected, rtol=1e-13, atol=1e-15)


@every_kernel
@pytest.mark.parametrize(("formula", "which"), [(kernel_value, 0), (kernel_slope, 1)], ids=["value", "slope"])
def test_single_precision_follows_double_precision(kernel, formula, which):
    """float32 in, float32 out: a constant in double precision would lift the pair arithmetic and halve its speed."""
    scale = max(abs(formula(kernel.code, q)) for q in np.linspace(0, kernel.support, 50))
    for q in np.linspace(0, 1.1 * kernel.support, 251).astype(np.float32):
        double, single = formula(kernel.code, float(q)), formula(kernel.code, q)
        assert single == pytest.approx(double, abs=2e-6 * scale)
    compiled = FORMULAS[kernel.code][which]
    assert {str(argument): str(found.signature.return_type) for (argument,), found in compiled.overloads.items()} == {
        "float64": "float64",
        "float32": "float32",
    }


def test_unknown_kernel_is_an_error_that_names_those_there_are():
    with pytest.raises(SceneError, match=f"wendland-c3.*{', '.join(KERNELS)}"):
        kernel_named("wendland-c3")
