"""Density diffusion in the continuity equation.

All forms add ``delta h c0 sum_b psi_ab . grad_a W_ab V_b`` with ``psi_ab = 2 (s_b - s_a) r_ba / r_ab^2``. Because
``r_ba . grad_a W_ab = -F r_ab^2``, the distance cancels and the loop needs no division. They differ in s:

- Molteni & Colagrossi (2009): s is the density. It diffuses the hydrostatic gradient too, which distorts water at rest
  near the surface and at walls.
- Fourtakas et al. (2019): s is the density without its hydrostatic part. Here ``s = rho0/c0^2 (w - g . x)`` with the enthalpy
  w of the state, which is the same everywhere in water at rest; ``rho - rho0 - rho0 g . x/c0^2`` to first order (that alone
  pumps density away from a bed, by 1 % of its pressure in 30 s with c0 = 10 sqrt(g depth)). Any direction of gravity.
- Antuono et al. (2010): what is linear between a pair is taken off, by the mean of two renormalised gradients (Randles &
  Libersky 1996), ``grad s_a = L_a sum_b (s_b - s_a) grad_a W_ab V_b`` with ``L_a = [sum_b (r_b - r_a) grad_a W_ab V_b]^-1``.
  Here s is without the hydrostatic part as well: the same for the fluid, since a linear part has no effect, and even at a
  wall: images have the reflected gradient, fixed ghosts none. Isolated particles, det L^-1 < 0.3, have none either. The
  gradients of neighbours are complete only after the sweep, so a pair has those of the evaluation before: an error of first
  order in the time step, in a term of the order of h^2.
"""

from ..formula import NONE, Formula
from ..jit import jit, like
from ..linear import cofactors
from .density import LEAST_DETERMINANT

MOLTENI, FOURTAKAS, ANTUONO = 1, 2, 3

DIFFUSIONS = {
    "none": NONE,
    "molteni": Formula(
        "molteni",
        MOLTENI,
        "drho_a/dt += 2 delta h c0 sum_b (rho_a - rho_b) F_ab m_b/rho_b",
        "Molteni & Colagrossi (2009), Comput. Phys. Commun. 180, 861",
    ),
    "fourtakas": Formula(
        "fourtakas",
        FOURTAKAS,
        "drho_a/dt += 2 delta h c0 sum_b (s_a - s_b) F_ab m_b/rho_b with s = rho0/c0^2 (enthalpy - g . x)",
        "Fourtakas et al. (2019), Comput. Fluids 190, 346, with the enthalpy for their hydrostatic density",
    ),
    "antuono": Formula(
        "antuono",
        ANTUONO,
        "drho_a/dt += 2 delta h c0 sum_b (s_a - s_b - (grad s_a + grad s_b)/2 . r_ab) F_ab m_b/rho_b, renormalised gradients "
        "of the evaluation before",
        "delta-SPH: Antuono et al. (2010), Comput. Phys. Commun. 181, 532; Marrone et al. (2011)",
    ),
}


@jit
def diffusing_density(code, excess, rho0, gamma, hydrostatic):
    """The s of a particle from its ``excess = rho - rho0`` and ``hydrostatic = rho0 (g . x)/c0^2``.

    The enthalpy over c0^2, ``integral of dp/(rho c0^2)``, is e + (gamma - 2)/2 e^2 + (gamma - 2)(gamma - 3)/6 e^3 + ... with
    ``e = excess/rho0``; gamma is 1 for the linear state.
    """
    if code == MOLTENI:
        return excess
    e = excess / rho0
    return excess * (1.0 + 0.5 * (gamma - 2.0) * e * (1.0 + (gamma - 3.0) / 3.0 * e)) - hydrostatic


@jit
def density_diffusion(delta_h_c0, VF, s_ab):
    """One neighbour's part of drho_a/dt; `VF` = F m_b/rho_b, `s_ab` = s_a - s_b without what is linear between the pair."""
    return like(2.0, VF) * delta_h_c0 * VF * s_ab


@jit
def renormalised_gradient(xx, xy, xz, yy, yz, zz, x, y, z, dim):
    """Return grad s of a particle: L times the sums x, y, z, from L^-1; zero where that is near singular."""
    a, b, c, d, e, f, determinant = cofactors(xx, xy, xz, yy, yz, zz, dim)
    if determinant < LEAST_DETERMINANT:
        return 0.0, 0.0, 0.0
    return (a * x + b * y + c * z) / determinant, (b * x + d * y + e * z) / determinant, (c * x + e * y + f * z) / determinant
