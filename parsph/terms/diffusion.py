"""Density diffusion in the continuity equation.

Both forms add ``delta h c0 sum_b psi_ab . grad_a W_ab V_b`` with ``psi_ab = 2 (s_b - s_a) r_ba / r_ab^2``. Because
``r_ba . grad_a W_ab = -F r_ab^2``, the distance cancels and the loop needs no division. They differ in s alone:

- Molteni & Colagrossi (2009): s is the density. It diffuses the hydrostatic gradient too, which distorts water at rest
  near the surface and at walls.
- Fourtakas et al. (2019): s is the density without its hydrostatic part, here in linear form,
  ``s_b - s_a = rho_b - rho_a - rho0 g . (r_b - r_a) / c0^2``; any direction of gravity.
"""

from ..jit import jit, like
from .term import NONE, Term

MOLTENI, FOURTAKAS = 1, 2

DIFFUSIONS = {
    "none": NONE,
    "molteni": Term(
        "molteni",
        MOLTENI,
        "drho_a/dt += 2 delta h c0 sum_b (rho_a - rho_b) F_ab m_b/rho_b",
        "Molteni & Colagrossi (2009), Comput. Phys. Commun. 180, 861",
    ),
    "fourtakas": Term(
        "fourtakas",
        FOURTAKAS,
        "drho_a/dt += 2 delta h c0 sum_b (s_a - s_b) F_ab m_b/rho_b with s = rho - rho0 (g . x)/c0^2",
        "Fourtakas et al. (2019), Comput. Fluids 190, 346, hydrostatic part linearised",
    ),
}


@jit
def diffusing_density(code, excess, hydrostatic):
    """The s of a particle from its ``excess = rho - rho0`` and ``hydrostatic = rho0 (g . x)/c0^2``."""
    if code == FOURTAKAS:
        return excess - hydrostatic
    return excess


@jit
def density_diffusion(delta_h_c0, VF, s_a, s_b):
    """One neighbour's part of drho_a/dt; `VF` = F m_b/rho_b."""
    return like(2.0, VF) * delta_h_c0 * VF * (s_a - s_b)
