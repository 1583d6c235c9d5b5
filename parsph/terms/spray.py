"""Spray: what particles with hardly any neighbours do."""

from ..formula import NONE, Formula
from ..jit import jit

PRESSURELESS = 1
FEW = 0.5  # of the dimension: div r of particles with fewer neighbours than those at a flat surface (about 0.7)

SPRAYS = {
    "none": NONE,
    "pressureless": Formula(
        "pressureless",
        PRESSURELESS,
        "drho_a/dt -= max(0, 1 - div r / (dim/2)) c0/h (rho_a - rho0), div r = -sum_b V_b r_ab . grad_a W_ab",
        "drops of one or a few particles have no inside to press: without it they ring, undamped, until a density fails",
    ),
}


@jit
def spray_rate(div_r, dim, excess, c0_over_h):
    """What a particle of spray loses of its `excess` = rho - rho0 [kg/m^3/s]; nothing inside the fluid and at its surface."""
    return -max(0.0, 1.0 - div_r / (FEW * dim)) * c0_over_h * excess
