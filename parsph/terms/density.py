"""How the density follows the flow: integrated, or summed."""

from ..formula import Formula
from ..jit import jit

CONTINUITY, SUMMATION, SMOOTHED = 1, 2, 3

DENSITIES = {
    "continuity": Formula(
        "continuity",
        CONTINUITY,
        "drho_a/dt = sum_b m_b v_ab . grad_a W_ab",
        "Szmidt (2013) eqs. (13), (34); Molteni et al. eq. (1.5)",
    ),
    "summation": Formula(
        "summation",
        SUMMATION,
        "rho_a = sum_b m_b W_ab",
        "Monaghan (1992), the integral of the continuity equation as long as masses do not change; Jones et al. (2010) eq. (3)",
    ),
}

# The sum of the smoothed velocity is complete only after the sweep, so continuity has that of the evaluation before: a lag of
# one evaluation, an error of first order in the time step in a correction that is of second order in h.
SMOOTHED_CONTINUITY = Formula(
    "smoothed continuity",
    SMOOTHED,
    "drho_a/dt = sum_b m_b G_ab . grad_a W_ab with the smoothed velocity G, v and the smoothing of the evaluation before",
    "Szmidt (2013) eqs. (34), (36): the corrected velocities are used in the continuity equation too",
)


@jit
def continuity(mF, vr):
    """One neighbour's part of drho_a/dt; `mF` = m_b F, `vr` = v_ab . r_ab, of the smoothed velocities where they are meant."""
    return mF * vr


@jit
def summation(m, W):
    """One neighbour's part of rho_a."""
    return m * W
