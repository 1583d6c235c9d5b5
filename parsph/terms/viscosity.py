"""Viscosity in the momentum equation.

Newtonian viscosity is the stress of the strain rates of both particles of a pair, Jones et al. (2010) eq. (5), with

    eps_a = D_a - 1/3 tr(D_a) 1,    D_a = sum_b m_b/rho_b (v_ba grad_a W_ab + its transpose).

- The printed strain rate has v_b alone in its first two sums; with the difference v_ba a translation has none, whatever the
  neighbours.
- The third of the trace (2/3 of the divergence) belongs to a fluid of three dimensions without bulk viscosity. It stays a
  third in two dimensions, which are a plane flow of that fluid, and in one, where 4/3 mu of the elongation is left.
- The strain rates of neighbours are those of the evaluation before, so that one sweep does: it sums the new ones while it
  uses the others. The viscous force lags by one evaluation, an error of first order in the time step.
- A derivative of a derivative does not see a velocity that jumps to and fro from particle to particle. Gravity and walls
  drive that pattern (in Poiseuille's flow it grows larger than the flow), and nothing takes it away. So pairs also feel
  Monaghan's viscosity, acting on what the strain rates of the two do not explain of their velocity difference, with a
  quarter of nu. It vanishes where the velocity is linear and has the order of the other errors elsewhere. All of nu would
  halve the error of the profile, but damps the pattern at 14 nu/h^2 in 2D, more than the verlet integrator bears at
  dt = 0.125 h^2/nu: it is stable up to 1/dt.
"""

from ..formula import NONE, Formula
from ..jit import jit, like

MONAGHAN, NEWTONIAN = 1, 2

UNSEEN = 0.25  # of nu, for what strain rates do not see

VISCOSITIES = {
    "none": NONE,
    "monaghan": Formula(
        "monaghan",
        MONAGHAN,
        "Pi_ab = -alpha h c0 (v_ab . r_ab) / (r_ab^2 + 0.01 h^2) / rho_ab, approaching pairs only; 1/rho_ab is the mean "
        "of 1/rho_a and 1/rho_b; equivalent to nu = alpha h c0 / (4 (dim + 2))",
        "Monaghan (1992); Monaghan (2005) eq. (8.6)",
    ),
    "newtonian": Formula(
        "newtonian",
        NEWTONIAN,
        "dv_a/dt += sum_b m_b (mu eps_a/rho_a^2 + mu eps_b/rho_b^2) . grad_a W_ab, eps = grad v + (grad v)^T - 2/3 div v, "
        "of the evaluation before; Monaghan's form with nu/4 on what eps does not explain of v_ab . r_ab",
        "Jones et al. (2010) eq. (5) with velocity differences; Monaghan (2005) eq. (8.6) for the rest",
    ),
}


@jit
def artificial_viscosity(alpha_h_c0, vr, r2, eta2, V_a, V_b):
    """Pi_ab of an approaching pair, 0 of a leaving one.

    `vr` = v_ab . r_ab; `V` = 1/rho: the mean of the inverses spares the loop a division and keeps the pair's symmetry.
    """
    half = like(0.5, vr)
    return -alpha_h_c0 * half * (V_a + V_b) * min(vr, like(0.0, vr)) / (r2 + eta2)


@jit
def unseen_viscosity(strength, mu, vr, rQr, r2, eta2, V_a, V_b):
    """Pi_ab of what strain rates do not explain of a pair's velocity difference.

    `vr` = v_ab . r_ab; `rQr` = r_ab . (Q_a + Q_b) . r_ab with Q = mu D/rho^2: half of r . D . r is v_ab . r_ab where the
    velocity is linear. `strength` = 2 (dim + 2) times UNSEEN; without that Monaghan's viscosity would be that of mu.
    """
    unseen = mu * like(0.5, vr) * (V_a * V_a + V_b * V_b) * vr - like(0.25, vr) * rQr
    return -strength * unseen / (r2 + eta2)
