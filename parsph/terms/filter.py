"""Density re-initialisation: what the density of a particle is when it is summed over its neighbours anew."""

from ..formula import NONE, Formula
from ..jit import jit
from ..linear import solve_symmetric

PLAIN, SHEPARD, MLS = 1, 2, 3

FILTERS = {
    "none": NONE,
    "plain": Formula(
        "plain", PLAIN, "rho_a = sum_b m_b W_ab", "Szmidt (2013) eq. (37), Monaghan (1992); falls off at a free surface"
    ),
    "shepard": Formula(
        "shepard",
        SHEPARD,
        "rho_a = sum_b m_b W_ab / sum_b V_b W_ab",
        "zeroth order; Bonet & Lok (1999), Comput. Methods Appl. Mech. Eng. 180, 97",
    ),
    "mls": Formula(
        "mls",
        MLS,
        "rho_a = sum_b m_b W_ab beta . (1, r_ba), with beta so that linear densities stay",
        "first order; Colagrossi & Landrini (2003), J. Comput. Phys. 191, 448; shepard where ill-conditioned",
    ),
}

WELL_CONDITIONED = 1e-3


@jit
def filtered_density(law, masses, moments):
    """The new density from ``masses = sum m W (1, r_ba/h)`` and ``moments = sum V W (1, r_ba/h)(1, r_ba/h)``."""
    if law == PLAIN:
        return masses[0]
    whole = moments[0, 0]
    density = masses[0] / whole
    if law == MLS:
        solution = masses.copy()
        if solve_symmetric(moments, solution, len(masses), WELL_CONDITIONED):
            density = solution[0]
    return density
