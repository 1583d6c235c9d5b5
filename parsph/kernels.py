"""Smoothing kernels, in one, two and three dimensions.

With q = r/h every kernel reads ``W = N w(q) / h^dim`` and its gradient ``grad W = N s(q) / h^(dim+2) * r_ij`` with
``s = w'(q) / q``: a slope that holds the factor q needs no division by r. All formulas are free of branches and in the
precision of their argument, so that the loops around them become vector code.

The B-splines are sums of truncated powers, ``w = sum_k c_k (a_k - q)_+^n``, with knots a_k a smoothing length apart. Within the
innermost knot they are one polynomial without a linear part: there the slope is that of the polynomial, as w'(q) over a
small q would lose digits.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .errors import SceneError
from .jit import by_code, jit, like

WENDLAND_C2, GAUSSIAN, CUBIC_SPLINE, WENDLAND_C4, WENDLAND_C6, QUADRATIC_SPLINE, QUARTIC_SPLINE, QUINTIC_SPLINE = range(8)

GAUSSIAN_CUT = 3.0  # Szmidt's delta = 4d with h = 4d/3
SPHERES = 2.0, 2.0 * math.pi, 4.0 * math.pi  # what the unit sphere measures in 1, 2, 3 dimensions


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
def _wendland_c4_value(q):
    t = _positive(like(1.0, q) - like(0.5, q) * q)
    t3 = t * t * t
    return t3 * t3 * (like(1.0, q) + q * (like(3.0, q) + like(35 / 12, q) * q))


@jit
def _wendland_c4_slope(q):
    t = _positive(like(1.0, q) - like(0.5, q) * q)
    return like(-14 / 3, q) * t * t * t * t * t * (like(1.0, q) + like(2.5, q) * q)


@jit
def _wendland_c6_value(q):
    t = _positive(like(1.0, q) - like(0.5, q) * q)
    t2 = t * t
    t4 = t2 * t2
    return t4 * t4 * (like(1.0, q) + q * (like(4.0, q) + q * (like(6.25, q) + like(4.0, q) * q)))


@jit
def _wendland_c6_slope(q):
    t = _positive(like(1.0, q) - like(0.5, q) * q)
    t2 = t * t
    return like(-5.5, q) * t2 * t2 * t2 * t * (like(1.0, q) + q * (like(3.5, q) + like(4.0, q) * q))


@jit
def _quadratic_spline_value(q):
    outer, inner = _positive(like(1.5, q) - q), _positive(like(0.5, q) - q)
    return outer * outer - like(3.0, q) * inner * inner


@jit
def _quadratic_spline_slope(q):
    knot = like(0.5, q)
    outer = _positive(like(1.5, q) - q)
    return like(-4.0, q) if q < knot else like(-2.0, q) * outer / max(q, knot)


@jit
def _cubic_spline_value(q):
    outer, inner = _positive(like(2.0, q) - q), _positive(like(1.0, q) - q)
    return like(0.25, q) * outer * outer * outer - inner * inner * inner


@jit
def _cubic_spline_slope(q):
    knot = like(1.0, q)
    outer = _positive(like(2.0, q) - q)
    return like(-3.0, q) + like(2.25, q) * q if q < knot else like(-0.75, q) * outer * outer / max(q, knot)


@jit
def _quartic_spline_value(q):
    outer, middle, inner = _positive(like(2.5, q) - q), _positive(like(1.5, q) - q), _positive(like(0.5, q) - q)
    outer, middle, inner = outer * outer, middle * middle, inner * inner
    return outer * outer - like(5.0, q) * middle * middle + like(10.0, q) * inner * inner


@jit
def _quartic_spline_slope(q):
    knot = like(0.5, q)
    outer, middle = _positive(like(2.5, q) - q), _positive(like(1.5, q) - q)
    rest = like(-4.0, q) * (outer * outer * outer - like(5.0, q) * middle * middle * middle) / max(q, knot)
    return like(24.0, q) * q * q - like(30.0, q) if q < knot else rest


@jit
def _quintic_spline_value(q):
    outer, middle, inner = _positive(like(3.0, q) - q), _positive(like(2.0, q) - q), _positive(like(1.0, q) - q)
    outer4, middle4, inner4 = outer * outer * outer * outer, middle * middle * middle * middle, inner * inner * inner * inner
    return outer4 * outer - like(6.0, q) * middle4 * middle + like(15.0, q) * inner4 * inner


@jit
def _quintic_spline_slope(q):
    knot = like(1.0, q)
    outer, middle = _positive(like(3.0, q) - q), _positive(like(2.0, q) - q)
    outer, middle = outer * outer, middle * middle
    rest = like(-5.0, q) * (outer * outer - like(6.0, q) * middle * middle) / max(q, knot)
    return like(-120.0, q) + q * q * (like(120.0, q) - like(50.0, q) * q) if q < knot else rest


FORMULAS = {  # w(q) and w'(q) / q, by the code of the kernel
    WENDLAND_C2: (_wendland_c2_value, _wendland_c2_slope),
    GAUSSIAN: (_gaussian_value, _gaussian_slope),
    CUBIC_SPLINE: (_cubic_spline_value, _cubic_spline_slope),
    WENDLAND_C4: (_wendland_c4_value, _wendland_c4_slope),
    WENDLAND_C6: (_wendland_c6_value, _wendland_c6_slope),
    QUADRATIC_SPLINE: (_quadratic_spline_value, _quadratic_spline_slope),
    QUARTIC_SPLINE: (_quartic_spline_value, _quartic_spline_slope),
    QUINTIC_SPLINE: (_quintic_spline_value, _quintic_spline_slope),
}


@by_code({code: value for code, (value, _) in FORMULAS.items()})
def kernel_value(code, q):
    """w(q) of the kernel `code`."""


@by_code({code: slope for code, (_, slope) in FORMULAS.items()})
def kernel_slope(code, q):
    """w'(q) / q of the kernel `code`."""


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
        return self.norms[dim - 1] / h**dim * _compiled_profiles(self.code)[0](q.ravel()).reshape(q.shape)

    def slope(self, r, h, dim):
        """Return dW/dr [1/m^(dim+1)] for distances `r` [m] (any shape) and smoothing length `h` [m]."""
        q = np.asarray(r, float) / h
        return self.norms[dim - 1] / h ** (dim + 1) * q * _compiled_profiles(self.code)[1](q.ravel()).reshape(q.shape)

    def spread(self, dim):
        """Return the standard deviation of W in one direction over h [-]: ``sqrt(integral of W x^2 dV) / h``."""
        nodes, weights = np.polynomial.legendre.leggauss(32)
        pieces = np.arange(0.0, self.support, 0.5)  # between the knots of all kernels
        q = (pieces[:, None] + 0.25 * (nodes + 1.0)).ravel()
        shells = SPHERES[dim - 1] * np.tile(0.25 * weights, len(pieces)) * q ** (dim + 1) / dim
        return math.sqrt(float(self.value(q, 1.0, dim) @ shells))


@lru_cache
def _compiled_profiles(code):
    """Return what gives w(q), and w'(q) / q, of arrays of q."""

    def values(q):
        found = np.empty_like(q)
        for k in range(len(q)):
            found[k] = kernel_value(code, q[k])
        return found

    def slopes(q):
        found = np.empty_like(q)
        for k in range(len(q)):
            found[k] = kernel_slope(code, q[k])
        return found

    return jit(values), jit(slopes)


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


def _spline_norms(power, terms):
    """1 over the integrals of ``sum c (a - q)_+^n`` over the line, the plane and space, from pairs (c, a)."""

    def over(dim):
        falling = math.prod(power + k for k in range(1, dim + 1))
        return SPHERES[dim - 1] * math.factorial(dim - 1) * sum(c * a ** (power + dim) for c, a in terms) / falling

    return tuple(1 / over(dim) for dim in (1, 2, 3))


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
            "wendland-c4",
            WENDLAND_C4,
            2.0,
            (27 / 32, 9 / (4 * math.pi), 495 / (256 * math.pi)),
            (1.2, 4.5),
            "Wendland (1995), C4; Dehnen & Aly (2012), Mon. Not. R. Astron. Soc. 425, 1068. In 1D the same profile, normalised",
        ),
        Kernel(
            "wendland-c6",
            WENDLAND_C6,
            2.0,
            (15 / 16, 39 / (14 * math.pi), 1365 / (512 * math.pi)),
            (1.4, 5.0),
            "Wendland (1995), C6; Dehnen & Aly (2012), Mon. Not. R. Astron. Soc. 425, 1068. In 1D the same profile, normalised",
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
            "quadratic-spline",
            QUADRATIC_SPLINE,
            1.5,
            _spline_norms(2, ((1, 1.5), (-3, 0.5))),
            (1.3, 3.0),
            "B-spline M3, Schoenberg (1946); Monaghan (1985), Comput. Phys. Rep. 3, 71",
        ),
        Kernel(
            "cubic-spline",
            CUBIC_SPLINE,
            2.0,
            _spline_norms(3, ((0.25, 2), (-1, 1))),
            (1.0, 5.0),
            "B-spline M4, Monaghan & Lattanzio (1985)",
        ),
        Kernel(
            "quartic-spline",
            QUARTIC_SPLINE,
            2.5,
            _spline_norms(4, ((1, 2.5), (-5, 1.5), (10, 0.5))),
            (0.9, 2.0),
            "B-spline M5, Schoenberg (1946); Morris et al. (1997), J. Comput. Phys. 136, 214",
        ),
        Kernel(
            "quintic-spline",
            QUINTIC_SPLINE,
            3.0,
            _spline_norms(5, ((1, 3), (-6, 2), (15, 1))),
            (0.8, 2.0),
            "B-spline M6, Schoenberg (1946); Morris et al. (1997), J. Comput. Phys. 136, 214",
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
