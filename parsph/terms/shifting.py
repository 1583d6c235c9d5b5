"""Particle shifting: particles move a little towards where there are fewer, away from the free surface.

The surface is known by ``div r = -sum_b V_b r_ab . grad_a W_ab``, the dimension inside the fluid and less at a surface.
"""

from ..formula import NONE, Formula
from ..jit import jit

LIND = 1
SURFACE = (0.75, 0.75, 2.75 / 3)  # div r over the dimension, in 1, 2, 3 dimensions, below which a particle is at the surface
LARGEST_SHIFT = 0.5  # of the particle's own speed

SHIFTINGS = {
    "none": NONE,
    "lind": Formula(
        "lind",
        LIND,
        "dx_a/dt = v_a - shift h |v_a| grad C_a inside the fluid, grad C_a = sum_b m_b/rho_b grad_a W_ab; at most |v_a|/2",
        "Lind et al. (2012), J. Comput. Phys. 231, 1499; Skillen et al. (2013); faded out at the surface by div r",
    ),
}


@jit
def inside_fluid(div_r, dim):
    """How far a particle lies inside the fluid: 0 at the surface, 1 where div r is the dimension, linear between."""
    low = SURFACE[dim - 1]
    return min(max((div_r / dim - low) / (1.0 - low), 0.0), 1.0)


@jit
def shift_factor(strength_h, speed, crowding, inside):
    """The factor on -grad C in the shifting velocity [m^2/s]; `crowding` is |grad C| [1/m]."""
    factor = strength_h * speed * inside
    largest = LARGEST_SHIFT * speed
    return largest / crowding if factor * crowding > largest else factor
