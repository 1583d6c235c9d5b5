"""Viscosity in the momentum equation."""

from ..jit import jit, like
from .term import NONE, Term

MONAGHAN = 1

VISCOSITIES = {
    "none": NONE,
    "monaghan": Term(
        "monaghan",
        MONAGHAN,
        "Pi_ab = -alpha h c0 (v_ab . r_ab) / (r_ab^2 + 0.01 h^2) / rho_ab, approaching pairs only; 1/rho_ab is the mean "
        "of 1/rho_a and 1/rho_b; equivalent to nu = alpha h c0 / (2 (dim + 2))",
        "Monaghan (1992); Monaghan (2005) eq. (8.6)",
    ),
}


@jit
def artificial_viscosity(alpha_h_c0, vr, r2, eta2, V_a, V_b):
    """Pi_ab of an approaching pair, 0 of a leaving one.

    `vr` = v_ab . r_ab; `V` = 1/rho: the mean of the inverses spares the loop a division and keeps the pair's symmetry.
    """
    half = like(0.5, vr)
    return -alpha_h_c0 * half * (V_a + V_b) * min(vr, like(0.0, vr)) / (r2 + eta2)
