"""Linear correction of the kernel and of its gradient: sums over neighbours that reproduce linear fields.

With the moment matrix ``A_a = sum_b V_b W_ab (1, x_b - x_a)(1, x_b - x_a)^T`` and ``C = A^-1``, the first row of C holds alpha
of the corrected kernel ``(alpha_0 + alpha . (x_b - x_a)) W_ab``, the row of an axis the beta of the corrected derivative along
it, ``(beta_0 + beta . (x_b - x_a)) W_ab`` (Szmidt eqs. (25)-(31)). A particle's own coefficients stand in its sums, so pairs
conserve momentum no more. Force (pressure and viscosity) and continuity take the corrected gradient, velocity smoothing and
summed densities the corrected value; the other terms keep the plain kernel.

Where neighbours are few or nearly in a line or a plane, A says next to nothing of some direction and C would blow noise up:
such a particle keeps the plain kernel. Lengths in A are over the kernel's standard deviation there, so that A is the unit
matrix inside the fluid, and 1/trace(C) is a share of a full neighbourhood that depends on no axes.
"""

import numpy as np

from ..formula import NONE, Formula
from ..jit import jit
from ..linear import invert_symmetric

LINEAR = 1

CORRECTIONS = {
    "none": NONE,
    "linear": Formula(
        "linear",
        LINEAR,
        "force and continuity with (beta_0 + beta . r_ba) W_ab for grad_a W_ab, smoothing and summation with "
        "(alpha_0 + alpha . r_ba) W_ab: rows of A^-1, A = sum_b V_b W_ab (1, r_ba)(1, r_ba)^T; plain where it is near singular",
        "Szmidt (2013) eqs. (25)-(31); Belytschko et al. (1998), Int. J. Numer. Methods Eng. 43, 785",
    ),
}

# Of C: on lattices dim + 1 inside the fluid, 6 to 10 at a flat surface, 12 to 20 at an edge, 22 to 40 in a corner of space; of
# a row or a sheet of particles jittered by a tenth of their spacing some 200.
LARGEST_TRACE = 60.0
WELL_CONDITIONED = 1e-3  # a smaller pivot makes the trace larger than that in any case


@jit
def invert_moments(moments):
    """Replace the non-dimensional A, shape (dim + 1, dim + 1), by its inverse C; return whether that is of use."""
    return invert_symmetric(moments, len(moments), WELL_CONDITIONED) and np.trace(moments) <= LARGEST_TRACE


@jit
def corrected_value(W, alpha_0, alpha_r):
    """The corrected W_ab; `alpha_r` = alpha . r_ab."""
    return (alpha_0 - alpha_r) * W


@jit
def corrected_derivative(Fx, W, beta_0, beta_r):
    """One component of the corrected grad_a W_ab; `beta_r` = beta . r_ab.

    `Fx` = F x_ab is that of the plain kernel for a particle that keeps it, whose beta is zero, and zero for the others.
    """
    return Fx + (beta_0 - beta_r) * W
