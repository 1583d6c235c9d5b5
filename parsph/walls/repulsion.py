"""Repulsion: what keeps fluid from going through a line of markers, by distance alone.

A marker at r_j pushes a particle at r_i along ``r_ij = r_i - r_j`` with the acceleration ``f(|r_ij|)``. Markers stand so
many times closer than particles (beta), so a particle that slides along a wall feels no bumps.
"""

from ..formula import NONE, Formula
from ..jit import jit

MONAGHAN_KAJTAR, LENNARD_JONES = 1, 2
CLOSEST = 0.01  # of the spacing of the markers: nearer to the pole of the force it grows no more


REPULSIONS = {
    each.name: each
    for each in (
        NONE,
        Formula(
            "monaghan-kajtar",
            MONAGHAN_KAJTAR,
            "f = K/beta^(dim-1) Phi(2r/R) / (r - d), Phi(q) = 1.77/32 (1 + 5q/2 + 2q^2)(2 - q)^5, d the markers' spacing",
            "Monaghan & Kajtar (2009), Comput. Phys. Commun. 180, 1811",
        ),
        Formula(
            "lennard-jones",
            LENNARD_JONES,
            "f = K/beta^(dim-1) ((R/r)^4 - (R/r)^2) / r for r < R",
            "Monaghan (1994), J. Comput. Phys. 110, 399",
        ),
    )
}


@jit
def monaghan_kajtar(r, reach, spacing):
    """The acceleration at distance `r` [m] over K [1/m]; it ends at `reach` [m], its pole is at the markers' `spacing` [m]."""
    q = 2.0 * r / reach
    if q >= 2.0:
        return 0.0
    left = 2.0 - q
    shape = 1.77 / 32.0 * (1.0 + 2.5 * q + 2.0 * q * q) * left * left * left * left * left
    return shape / max(r - spacing, CLOSEST * spacing)


@jit
def lennard_jones(r, reach, spacing):
    """The acceleration at distance `r` [m] over K [1/m]; it ends at `reach` [m], powers 4 and 2."""
    if r >= reach:
        return 0.0
    ratio = reach / max(r, CLOSEST * spacing)
    square = ratio * ratio
    return square * (square - 1.0) * ratio / reach


@jit
def repulsion(law, r, reach, spacing):
    """The acceleration of the `law` at distance `r` [m] over K [1/m]."""
    if law == MONAGHAN_KAJTAR:
        return monaghan_kajtar(r, reach, spacing)
    return lennard_jones(r, reach, spacing)
