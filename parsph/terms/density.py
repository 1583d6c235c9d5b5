"""How the density follows the flow: integrated, or summed.

Beside a free surface a particle has neighbours on one side only. The plain divergence then counts what happens along the
surface in full and what happens across it by half. A wave strains the water there as much along as across, and oppositely, so
that the densities of the topmost rows swing, the rows shift against each other until they do not, and diffusion takes that out
of the wave: most of what waves lose in water without viscosity. The renormalised divergence is exact for linear velocities
wherever a particle is. It makes sound of short waves faster in the rows at the surface, by up to sqrt(2), which needs an
integrator that does not let sound grow.
"""

from ..formula import Formula
from ..jit import jit
from ..linear import cofactors

CONTINUITY, SUMMATION, SMOOTHED, RENORMALISED = 1, 2, 3, 4

LEAST_DETERMINANT = 0.3  # of -M/rho: the unit matrix inside the fluid, with a half in place of the 1 across a surface

DENSITIES = {
    "continuity": Formula(
        "continuity",
        CONTINUITY,
        "drho_a/dt = sum_b m_b v_ab . grad_a W_ab",
        "Szmidt (2013) eqs. (13), (34); Molteni et al. eq. (1.5)",
    ),
    "renormalised": Formula(
        "renormalised",
        RENORMALISED,
        "drho_a/dt = -rho_a tr(G M^-1), G = sum_b m_b v_ab grad_a W_ab, M = sum_b m_b r_ab grad_a W_ab; plain where M is near "
        "singular",
        "the divergence of a linear velocity, exact beside a free surface too: Randles & Libersky (1996)",
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


@jit
def renormalised(xx, xy, xz, yy, yz, zz, gxx, gxy, gxz, gyy, gyz, gzz, dim):
    """drho_a/dt from -M/rho_a and from the diagonal of G [kg/m^3/s] and the sums of opposite elements off it.

    In spray, below `LEAST_DETERMINANT`, it is the plain sum, the trace of G.
    """
    a, b, c, d, e, f, determinant = cofactors(xx, xy, xz, yy, yz, zz, dim)
    if determinant < LEAST_DETERMINANT:
        return gxx + gyy + gzz
    return (a * gxx + b * gxy + c * gxz + d * gyy + e * gyz + f * gzz) / determinant
