"""Smoothing kernels against quadrature and finite differences."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from parsph.errors import SceneError
from parsph.kernels import GAUSSIAN_CUT, KERNELS, kernel_named, kernel_slope, kernel_value

DIMS = (1, 2, 3)
every_kernel = pytest.mark.parametrize("kernel", KERNELS.values(), ids=list(KERNELS))


@every_kernel
@pytest.mark.parametrize("dim", DIMS)
def test_kernel_integrates_to_one(kernel, dim):
    """The integral over the support, ``int W S r^(dim-1) dr`` with the unit sphere's surface S, is 1."""
    h, surface = 0.37, (2, 2 * math.pi, 4 * math.pi)[dim - 1]

    def shell(r):
        return float(kernel.value(r, h, dim)) * surface * r ** (dim - 1)

    integral, _ = quad(shell, 0, kernel.support * h, points=[h], epsabs=1e-13, epsrel=1e-13)
    assert integral == pytest.approx(1, abs=1e-11)


@every_kernel
@pytest.mark.parametrize("dim", DIMS)
def test_slope_is_derivative_of_value(kernel, dim):
    """dW/dr by central differences, away from the ends of the polynomial pieces."""
    h = 0.37
    r = h * np.linspace(0.013, kernel.support - 0.017, 97)
    step = 1e-5 * h
    difference = (kernel.value(r + step, h, dim) - kernel.value(r - step, h, dim)) / (2 * step)
    scale = np.abs(difference).max()
    np.testing.assert_allclose(kernel.slope(r, h, dim), difference, atol=2e-9 * scale)


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
@pytest.mark.parametrize("formula", [kernel_value, kernel_slope], ids=["value", "slope"])
def test_single_precision_follows_double_precision(kernel, formula):
    """float32 in, float32 out: a constant in double precision would lift the pair arithmetic and halve its speed."""
    scale = max(abs(formula(kernel.code, q)) for q in np.linspace(0.1, kernel.support, 50))
    for q in np.linspace(0.1, 1.1 * kernel.support, 67).astype(np.float32):
        double, single = formula(kernel.code, float(q)), formula(kernel.code, q)
        assert single == pytest.approx(double, abs=2e-6 * scale)
    variants = [signature for signature in formula.signatures if str(signature[1]) == "float32"]
    assert variants
    assert all(str(formula.overloads[signature].signature.return_type) == "float32" for signature in variants)


def test_unknown_kernel_is_an_error_that_names_those_there_are():
    with pytest.raises(SceneError, match=r"wendland-c3.*wendland-c2, gaussian, cubic-spline"):
        kernel_named("wendland-c3")
