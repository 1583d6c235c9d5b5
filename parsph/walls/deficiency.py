"""Correction of the boundary deficiency: what the momentum equation lacks where the kernel is cut off by a wall.

Each marker j of a wall has a strength C_j such that the fluid beside it has no acceleration into the wall relative to it
(Jones et al. 2010, eqs. (7), (8)); a particle i gets ``-C_j W_ij weight_ij n_j`` from every marker in reach. Weights:

`jones2010`
    as printed: ``weight = (activation^2 + (glancing^2 + 1/2) distance) / sum over markers of the same times n_i . n_j`` with
    activation = spacing/|r_ij|, glancing = n . r_ij/|r_ij|, distance = 1 - |r_ij|/R, n_i the normal of the nearest marker;
    C_j is the mean of ``a_i . n_j / W_ij`` over near particles.
`moments`
    what the moments of Szmidt eqs. (23), (24) lack behind a wall of any shape; corners and curves need no blending. By the
    divergence theorem the moment ``sum_b V_b grad_a W_ab`` lacks ``S_i = sum_j W_ij s_j n_j``, s_j the length that marker j
    stands for, and the kernel is filled to ``gamma_i = 1 - sum_j s_j n_j . r_ij / |r_ij|^dim integral of W r^(dim-1) dr
    beyond |r_ij|``. What neighbours do is divided by gamma_i, or else fluid slides down along a wall at 0.3 g, and weight_ij
    is s_j / gamma_i. C_j is the least-squares fit of ``a_i + (v_i - v_w)/tau = C_j S_i/gamma_i`` over near particles,
    tau = h/c0: a velocity into the wall or off it decays too, which keeps the gap from wandering. The density's rate gets
    ``-rho_i sum_j (v_i - v_w,j) . n_j W_ij s_j / gamma_i``, so that it feels the wall come near (as Ferrand et al. 2013).

Near particles count with ``(1 - r^2/R_s^2)^2``, which fades out smoothly at R_s. A strength only pushes: fluid that is
pulled off a wall is not held back.
"""

import numpy as np

from ..formula import Formula
from ..jit import jit

JONES2010, MOMENTS = 1, 2
RELAXATION = 1.0  # of c0/h: 1/tau
LEAST_FILLED = 0.1  # gamma is 1/4 in a right-angled corner
NEAREST = 1e-3  # of the markers' spacing: nearer particles count as being so far away


WEIGHTS = {
    each.name: each
    for each in (
        Formula(
            "moments",
            MOMENTS,
            "dv_i/dt -= sum_j C_j W_ij s_j n_j / gamma_i, C_j from a_i = C_j sum_k W_ik s_k n_k / gamma_i beside marker j",
            "Jones et al. (2010) eq. (7), with weights from the moments of Szmidt (2013) eq. (24)",
        ),
        Formula(
            "jones2010",
            JONES2010,
            "dv_i/dt -= sum_j C_j W_ij weight_ij n_j, C_j the mean of a_i . n_j/W_ij beside marker j",
            "Jones et al. (2010) eqs. (7), (8)",
        ),
    )
}


@jit
def jones_weight(r, cosine, spacing, reach):
    """The weight of eq. (8) before it is normalised; `cosine` is n . r_ij/|r_ij|."""
    activation = spacing / r
    return activation * activation + (cosine * cosine + 0.5) * (1.0 - r / reach)


@jit
def sample_weight(r2, sample2):
    """How much a particle at the distance r counts for the strength of a marker; `sample2` is R_s^2."""
    left = max(1.0 - r2 / sample2, 0.0)
    return left * left


@jit
def outer_integral(tails, q):
    """What is left of the integral of w(q) q^(dim-1) beyond q, from the table of `outer_integrals`."""
    place = q * tails[0]
    k = int(place)
    if k >= len(tails) - 2:
        return 0.0
    return tails[k + 1] + (place - k) * (tails[k + 2] - tails[k + 1])


def outer_integrals(kernel, dim):
    """Return the table of a kernel that `outer_integral` reads: values per q, then the integrals from 0 to the support on."""
    count = 400
    q, step = np.linspace(0.0, kernel.support, count + 1, retstep=True)
    points, weights = np.polynomial.legendre.leggauss(6)
    middle = 0.5 * (q[:-1] + q[1:])
    inside = middle[:, None] + 0.5 * step * points
    values = kernel.value(inside, 1.0, dim) / kernel.norms[dim - 1] * inside ** (dim - 1)
    pieces = 0.5 * step * values @ weights
    return np.concatenate([[1.0 / step], np.cumsum(pieces[::-1])[::-1], [0.0]])
