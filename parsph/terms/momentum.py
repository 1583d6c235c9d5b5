"""Pressure in the momentum equation."""

from ..formula import Formula
from ..jit import jit

MOMENTUM = Formula(
    "momentum",
    1,
    "dv_a/dt = -sum_b m_b (p_a/rho_a^2 + p_b/rho_b^2) grad_a W_ab + g",
    "symmetric form, conserves momentum; Szmidt (2013) eqs. (14), (35); Molteni et al. eq. (1.6), signs mended",
)


@jit
def pressure_pair(P_a, P_b):
    """p_a/rho_a^2 + p_b/rho_b^2 from the two quotients P = p/rho^2."""
    return P_a + P_b
