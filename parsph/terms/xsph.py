"""Velocity smoothing: particles move with a velocity nearer to that of their neighbours."""

from ..formula import Formula
from ..jit import jit, like

XSPH = Formula(
    "xsph",
    1,
    "dx_a/dt = v_a + epsilon sum_b m_b/rho_ab (v_b - v_a) W_ab; 1/rho_ab is the mean of 1/rho_a and 1/rho_b",
    "Monaghan (1989); Szmidt (2013) eq. (36), which is epsilon = 1/2 for equal masses",
)


@jit
def smoothing_weight(mW, V_a, V_b):
    """m_b W_ab / rho_ab from `mW` = m_b W_ab and V = 1/rho."""
    return like(0.5, mW) * mW * (V_a + V_b)
