"""How the density follows the flow: integrated, or summed."""

from ..jit import jit
from .term import Term

CONTINUITY, SUMMATION = 1, 2

DENSITIES = {
    "continuity": Term(
        "continuity",
        CONTINUITY,
        "drho_a/dt = sum_b m_b v_ab . grad_a W_ab",
        "Szmidt (2013) eqs. (13), (34); Molteni et al. eq. (1.5)",
    ),
    "summation": Term(
        "summation",
        SUMMATION,
        "rho_a = sum_b m_b W_ab",
        "Monaghan (1992), the integral of the continuity equation as long as masses do not change",
    ),
}


@jit
def continuity(mF, vr):
    """One neighbour's part of drho_a/dt; `mF` = m_b F, `vr` = v_ab . r_ab."""
    return mF * vr


@jit
def summation(m, W):
    """One neighbour's part of rho_a."""
    return m * W
