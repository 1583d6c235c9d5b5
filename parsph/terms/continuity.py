"""Continuity equation."""

from ..jit import jit
from .term import Term

CONTINUITY = Term(
    "continuity",
    1,
    "drho_a/dt = sum_b m_b v_ab . grad_a W_ab",
    "Szmidt (2013) eqs. (13), (34); Molteni et al. eq. (1.5)",
)


@jit
def continuity(mF, vr):
    """One neighbour's part of drho_a/dt; `mF` = m_b F, `vr` = v_ab . r_ab."""
    return mF * vr
