"""Particle shifting: particles move a little towards where there are fewer, away from the free surface.

Measured by its own speed a particle in the middle of a vortex, or where a flow divides, does not shift, though there lattices
are torn and stretched the most; measured by the speed of the whole flow it does, also in water at rest.

The surface is known by ``div r = -sum_b V_b r_ab . grad_a W_ab``, the dimension inside the fluid and less at a surface.
"""

from ..formula import NONE, Formula
from ..jit import jit

LIND, SUN = 1, 2
SURFACE = (0.75, 0.75, 2.75 / 3)  # div r over the dimension, in 1, 2, 3 dimensions, below which a particle is at the surface
LARGEST_SHIFT = 0.5  # of the speed that it is measured by
FASTEST = 0.1  # of the sound speed: what flows are as fast as

SHIFTINGS = {
    "none": NONE,
    "lind": Formula(
        "lind",
        LIND,
        "dx_a/dt = v_a - shift h |v_a| grad C_a inside the fluid, grad C_a = sum_b m_b/rho_b grad_a W_ab; at most |v_a|/2",
        "Lind et al. (2012), J. Comput. Phys. 231, 1499; Skillen et al. (2013); faded out at the surface by div r",
    ),
    "sun": Formula(
        "sun",
        SUN,
        "dx_a/dt = v_a - shift h U grad C_a inside the fluid, U = c0/10, grad C_a = sum_b m_b/rho_b grad_a W_ab; at most U/2",
        "Sun et al. (2017), Comput. Methods Appl. Mech. Eng. 315, 25, without the tensile factor; faded out as with lind",
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
