"""Control of the tensile instability: particles under suction repel instead of clumping."""

from ..formula import NONE, Formula
from ..jit import jit

SUN = 1

TENSILE_CONTROLS = {
    "none": NONE,
    "sun": Formula(
        "sun",
        SUN,
        "dv_a/dt: |p_a| in place of p_a, as far as particle a lies inside the fluid",
        "Sun et al. (2018), Comput. Phys. Commun. 224, 63 (p_b - p_a where p_a < 0, not at the free surface)",
    ),
}


@jit
def tensile_excess(P_a, inside):
    """What |p_a| adds to p_a/rho_a^2 of a particle under suction; `inside` is 0 at the free surface and 1 in the fluid."""
    return -2.0 * inside * min(P_a, 0.0)
