"""Absorbing layers: sponge zones that relax the flow towards still water.

``dv/dt = ... - sigma(x) v`` and, where a scene asks for it, ``drho/dt = ... - sigma(x) (rho - rho_s(z))`` with rho_s the
hydrostatic density of the still water at that height (with gravity, damping towards rho0 would lift the water), and
``sigma = sigma0 (x - x0) / ((x0 + L) - x + 0.5 h)``, sigma0 = v_ref / L (Molteni et al. eqs. (2.3), (2.4), section 2.1).
Near the outer end sigma dt exceeds 1, so the terms are integrated exactly: a factor exp(-sigma dt), stable for any sigma.
"""

import math
from dataclasses import dataclass

from .jit import jit
from .particles import FIRST_GHOST
from .states import density_of


@jit
def hyperbolic(depth, length, h):
    """sigma/sigma0 at `depth` [m] inside a layer of `length` [m]; the 0.5 h softens its outer end."""
    return depth / (max(length - depth, 0.0) + 0.5 * h)


@jit
def relax(rows, tags, first, last, dim, start, direction, length, h, sigma0_dt, with_density, level, weight, state):
    """Damp velocities (and density deviations) of the fluid rows ``first:last`` inside the layer."""
    for i in range(first, last):
        depth = (rows[i, 0] - start) * direction
        if depth <= 0.0 or tags[i] >= FIRST_GHOST:
            continue
        factor = math.exp(-sigma0_dt * hyperbolic(depth, length, h))
        for d in range(dim):
            rows[i, dim + d] *= factor
        if with_density:
            still = density_of(weight * (level - rows[i, dim - 1]), state)
            rows[i, 2 * dim] = still + factor * (rows[i, 2 * dim] - still)


@dataclass(frozen=True)
class DampingZone:
    """A hyperbolic absorbing layer at one end of the basin.

    Attributes
    ----------
    start : float
        x0 [m], the inner edge.
    direction : int
        +1 when the layer extends to larger x, -1 to smaller.
    length, h : float
        L and smoothing length [m].
    sigma0 : float
        v_ref / L [1/s].
    with_density : bool
        Whether the density is damped too.
    level, weight : float
        Still-water level [m] and rho0 g [N/m^3]: the hydrostatic density to damp towards.
    state : tuple
        Constants of the equation of state.
    """

    start: float
    direction: int
    length: float
    h: float
    sigma0: float
    with_density: bool
    level: float
    weight: float
    state: tuple

    def apply(self, particles, first, last, dt):
        """Damp the fluid rows ``first:last`` over `dt` [s]."""
        relax(
            particles.shared,
            particles.tags,
            first,
            last,
            particles.layout.dim,
            self.start,
            self.direction,
            self.length,
            self.h,
            self.sigma0 * dt,
            self.with_density,
            self.level,
            self.weight,
            self.state,
        )

    @property
    def span(self):
        """The x-interval of the layer [m]."""
        end = self.start + self.direction * self.length
        return min(self.start, end), max(self.start, end)
