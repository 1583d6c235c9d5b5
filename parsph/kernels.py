"""Smoothing kernels, in one, two and three dimensions.

With q = r/h every kernel reads ``W = N w(q) / h^dim`` and its gradient ``grad W = N s(q) / h^(dim+2) * r_ij`` with
``s = w'(q) / q``: a slope that holds the factor q needs no division by r. All formulas are free of branches and in the
precision of their argument, so that the loops around them become vector code.
"""

import math
from dataclasses import dataclass

import numpy as np

from .errors import SceneError
from .jit import jit, like

WENDLAND_C2, GAUSSIAN, CUBIC_SPLINE = range(3)

GAUSSIAN_CUT = 3.0  # Szmidt's delta = 4d with h = 4d/3


@jit
def _positive(value):
    return max(like(0.0, value), value)


@jit
def _wendland_c2_value(q):
    t = _positive(like(1.0, q) - like(0.5, q) * q)
    return t * t * t * t * (like(1.0, q) + like(2.0, q) * q)


@jit
def _wendland_c2_slope(q):
    t = _positive(like(1.0, q) - like(0.5, q) * q)
    return like(-5.0, q) * t * t * t


@jit
def _exponential(s):
    """exp(-s) for 0 <= s <= 9 to 1e-13, as (Taylor series of exp(-s/32))^32: without a call, so it runs in lanes."""
    x = like(-1 / 32, s) * s
    e = like(1.0, s) + x * like(1 / 10, s)
    e = like(1.0, s) + x * like(1 / 9, s) * e
    e = like(1.0, s) + x * like(1 / 8, s) * e
    e = like(1.0, s) + x * like(1 / 7, s) * e
    e = like(1.0, s) + x * like(1 / 6, s) * e
    e = like(1.0, s) + x * like(1 / 5, s) * e
    e = like(1.0, s) + x * like(1 / 4, s) * e
    e = like(1.0, s) + x * like(1 / 3, s) * e
    e = like(1.0, s) + x * like(1 / 2, s) * e
    e = like(1.0, s) + x * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    return e * e


@jit
def _gaussian_value(q):
    cut = like(GAUSSIAN_CUT**2, q)
    return _exponential(min(q * q, cut)) - like(math.exp(-(GAUSSIAN_CUT**2)), q)


@jit
def _gaussian_slope(q):
    cut = like(GAUSSIAN_CUT**2, q)
    inside = like(-2.0, q) if q * q < cut else like(0.0, q)
    return inside * _exponential(min(q * q, cut))


@jit
def _cubic_spline_value(q):
    outer, inner = _positive(like(2.0, q) - q), _positive(like(1.0, q) - q)
    return like(0.25, q) * outer * outer * outer - inner * inner * inner


@jit
def _cubic_spline_slope(q):
    outer, inner = _positive(like(2.0, q) - q), _positive(like(1.0, q) - q)
    return (like(-0.75, q) * outer * outer + like(3.0, q) * inner * inner) / max(q, like(1e-12, q))


@jit
def kernel_value(code, q):
    """w(q) of the kernel `code`."""
    if code == WENDLAND_C2:
        return _wendland_c2_value(q)
    if code == GAUSSIAN:
        return _gaussian_value(q)
    return _cubic_spline_value(q)


@jit
def kernel_slope(code, q):
    """w'(q) / q of the kernel `code`."""
    if code == WENDLAND_C2:
        return _wendland_c2_slope(q)
    if code == GAUSSIAN:
        return _gaussian_slope(q)
    return _cubic_spline_slope(q)


@dataclass(frozen=True)
class Kernel:
    """A smoothing kernel.

    Attributes
    ----------
    name : str
    code : int
        What the compiled code knows it by.
    support : float
        Radius of its support in smoothing lengths.
    norms : tuple of float
        N in one, two and three dimensions.
    h_over_dx : tuple of float
        Range of h/dx in which the sums are worth their name.
    source : str
    """

    name: str
    code: int
    support: float
    norms: tuple
    h_over_dx: tuple
    source: str

    def value(self, r, h, dim):
        """Return W(r) [1/m^dim] for distances `r` [m] (any shape) and smoothing length `h` [m]."""
        q = np.asarray(r, float) / h
        return self.norms[dim - 1] / h**dim * _value_of_all(self.code, q.ravel()).reshape(q.shape)

    def slope(self, r, h, dim):
        """Return dW/dr [1/m^(dim+1)] for distances `r` [m] (any shape) and smoothing length `h` [m]."""
        q = np.asarray(r, float) / h
        return self.norms[dim - 1] / h ** (dim + 1) * q * _slope_of_all(self.code, q.ravel()).reshape(q.shape)


@jit
def _value_of_all(code, q):
    values = np.empty_like(q)
    for k in range(len(q)):
        values[k] = kernel_value(code, q[k])
    return values


@jit
def _slope_of_all(code, q):
    values = np.empty_like(q)
    for k in range(len(q)):
        values[k] = kernel_slope(code, q[k])
    return values


def _gaussian_norms():
    """1/N of Szmidt eq. (6): the integral of exp(-q^2) - exp(-Q^2) over the ball of radius Q in 1, 2, 3 dimensions."""
    cut, tail = GAUSSIAN_CUT, math.exp(-(GAUSSIAN_CUT**2))
    line = math.sqrt(math.pi) * math.erf(cut)
    volumes = (
        line - 2 * cut * tail,
        math.pi * (1 - tail * (1 + cut**2)),
        math.pi * line - 2 * math.pi * cut * tail - 4 / 3 * math.pi * cut**3 * tail,
    )
    return tuple(1 / volume for volume in volumes)


KERNELS = {
    kernel.name: kernel
    for kernel in (
        Kernel(
            "wendland-c2",
            WENDLAND_C2,
            2.0,
            (3 / 4, 7 / (4 * math.pi), 21 / (16 * math.pi)),
            (1.0, 4.0),
            "Wendland (1995), C2; Molteni et al. eq. (1.7). In 1D the same profile, normalised",
        ),
        Kernel(
            "gaussian",
            GAUSSIAN,
            GAUSSIAN_CUT,
            _gaussian_norms(),
            (0.8, 2.0),
            "truncated at 3 h and renormalised, Szmidt (2013) eq. (6)",
        ),
        Kernel(
            "cubic-spline",
            CUBIC_SPLINE,
            2.0,
            (2 / 3, 10 / (7 * math.pi), 1 / math.pi),
            (1.0, 5.0),
            "Monaghan & Lattanzio (1985)",
        ),
    )
}


def kernel_named(name):
    """Return the `Kernel` called `name`.

    Raises
    ------
    SceneError
        When there is none of that name.
    """
    if name not in KERNELS:
        raise SceneError(f"no kernel {name!r}", cure=f"one of {', '.join(KERNELS)}")
    return KERNELS[name]
