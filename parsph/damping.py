"""Absorbing layers: sponge zones that relax the flow towards still water.

``dv/dt = ... - sigma(x) v`` and, where a scene asks for it, ``drho/dt = ... - sigma(x) (rho - rho_s(z))`` with rho_s the
hydrostatic density of the still water at that height (with gravity, damping towards rho0 would lift the water), Molteni et
al. eqs. (2.3), (2.4). What leaves with the density is mass: the particle keeps its volume. A layer may act on some particles
only (switches), and weaken the force that drives the flow through it (killing functions), section 2.

Near the outer end sigma dt exceeds 1. So the terms are integrated by themselves after each step, implicitly and to second
order, ``exp(-s) = 1 / (1 + s + s^2/2) + O(s^3)`` with s = sigma dt: stable for any sigma, and a fourth of the time that
the exponential takes.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

from .jit import jit
from .particles import FIRST_GHOST
from .states import density_gap

HYPERBOLIC, POWER = range(2)
PROFILES = {"hyperbolic": HYPERBOLIC, "power": POWER}
ALWAYS, BACKWARD, BACKWARD_AND_DOWN, DRIVEN_BACKWARD = range(4)
SWITCHES = {"none": ALWAYS, "vx": BACKWARD, "vx-vy": BACKWARD_AND_DOWN, "fx-vx": DRIVEN_BACKWARD}
UNTOUCHED, LINEAR_FALL, PARABOLIC_FALL = range(3)
KILLINGS = {"none": UNTOUCHED, "f1": LINEAR_FALL, "f2": PARABOLIC_FALL}


@jit
def sigma_over_sigma0(profile, depth, length, softening, exponent):
    """The profile at `depth` [m] inside a layer of `length` [m]; sigma stays finite at its outer end and beyond."""
    if profile == HYPERBOLIC:
        return depth / (max(length - depth, 0.0) + softening)
    ratio = min(depth / length, 1.0)
    value = ratio
    for _ in range(exponent - 1):
        value *= ratio
    return value


@jit
def decay(s):
    """What is left of a quantity after sigma dt = `s`: exp(-s) to second order, in (0, 1] for every s."""
    return 1.0 / (1.0 + s * (1.0 + 0.5 * s))


@jit
def killing(code, depth, length):
    """The factor on the force across a layer at `depth` [m]: f1 or f2, from 1 at its inner edge to 0 at its outer end."""
    ratio = min(depth / length, 1.0)
    if code == LINEAR_FALL:
        return 1.0 - ratio
    return 1.0 - ratio * ratio


@jit
def acts(switch, direction, across, upwards, force):
    """Whether a layer damps a particle with these velocities [m/s] and this horizontal force; the wave comes along
    `direction`, so "negative" is against it.
    """
    if switch == ALWAYS:
        return True
    if across * direction >= 0.0:
        return False
    if switch == BACKWARD_AND_DOWN:
        return upwards < 0.0
    if switch == DRIVEN_BACKWARD:
        return force * direction < 0.0
    return True


@lru_cache
def compiled_layer(dim, profile, switch, with_density, state_code):
    """Return the pass that damps the fluid rows of a layer, for these codes; numbers are run-time arguments."""

    def relax(rows, tags, acceleration, first, last, edge, exponent, sigma0_dt, density_factor, still, numbers):
        start, direction, length, softening = edge
        level, weight, surface_pressure = still
        state = (state_code, *numbers)
        for i in range(first, last):
            depth = (rows[i, 0] - start) * direction
            if depth <= 0.0 or tags[i] >= FIRST_GHOST:
                continue
            if not acts(switch, direction, rows[i, dim], rows[i, 2 * dim - 1], acceleration[i, 0]):
                continue
            s = sigma0_dt * sigma_over_sigma0(profile, depth, length, softening, exponent)
            factor = decay(s)
            for d in range(dim):
                rows[i, dim + d] *= factor
            if with_density:
                gap = density_gap(surface_pressure + weight * (level - rows[i, dim - 1]), rows[i, 2 * dim], state)
                change = 1.0 + gap * (1.0 - decay(density_factor * s))
                rows[i, 2 * dim] *= change
                rows[i, 2 * dim + 2] *= change

    return jit(relax)


@jit
def weaken(rows, tags, acceleration, first, last, edge, code):
    """Multiply the horizontal acceleration of the fluid rows ``first:last`` inside the layer by its killing function."""
    start, direction, length, _ = edge
    for i in range(first, last):
        depth = (rows[i, 0] - start) * direction
        if depth > 0.0 and tags[i] < FIRST_GHOST:
            acceleration[i, 0] *= killing(code, depth, length)


@dataclass(frozen=True)
class DampingZone:
    """An absorbing layer at one end of the basin.

    Attributes
    ----------
    start : float
        x0 [m], the inner edge.
    direction : int
        +1 when the layer extends to larger x, -1 to smaller.
    length : float
        L [m].
    sigma0 : float
        Strength [1/s].
    state : tuple
        Constants of the equation of state.
    profile : str
        "hyperbolic": ``sigma0 depth / (L - depth + softening)``; "power": ``sigma0 (depth / L)^exponent``.
    softening : float
        What keeps the hyperbolic profile finite at the outer end [m]; 0.5 h in the paper.
    exponent : int
        m of the power profile.
    switch : str
        Which particles are damped: "none": all; "vx": those that move against the wave; "vx-vy": against it and downwards;
        "fx-vx": those that move against it and are driven that way.
    killing : str
        What the horizontal force (pressure and viscosity) is multiplied by: "none", "f1" = 1 - depth/L, "f2" = 1 - (depth/L)^2.
    density_factor : float
        Strength of the damping of the density over that of the velocity; 0: none.
    level, weight, surface_pressure : float
        Still-water level [m], rho0 g [N/m^3] and pressure at that level [Pa]: the hydrostatic density to damp towards.
    """

    start: float
    direction: int
    length: float
    sigma0: float
    state: tuple
    profile: str = "hyperbolic"
    softening: float = 0.0
    exponent: int = 1
    switch: str = "none"
    killing: str = "none"
    density_factor: float = 0.0
    level: float = 0.0
    weight: float = 0.0
    surface_pressure: float = 0.0

    @cached_property
    def edge(self):
        """What the compiled code knows of the place: (start, direction, length, softening)."""
        return self.start, float(self.direction), self.length, self.softening

    @cached_property
    def _numbers(self):
        """What the compiled code knows of the density: its factor, the still water, the state without its code."""
        return self.density_factor, (self.level, self.weight, self.surface_pressure), tuple(self.state[1:])

    @property
    def weakens(self):
        """Whether it weakens the force."""
        return self.killing != "none"

    def act(self, particles, first, last, time, dt):
        """Damp the fluid rows ``first:last``, which are at `time` [s], over the `dt` [s] before it."""
        codes = PROFILES[self.profile], SWITCHES[self.switch], self.density_factor > 0, self.state[0]
        relax = compiled_layer(particles.layout.dim, *codes)
        p = particles
        relax(p.shared, p.tags, p.acceleration, first, last, self.edge, self.exponent, self.sigma0 * dt, *self._numbers)

    def restrain(self, particles, first, last):
        """Weaken the force on the fluid rows ``first:last``, after each evaluation, where there is a killing function."""
        weaken(particles.shared, particles.tags, particles.acceleration, first, last, self.edge, KILLINGS[self.killing])

    @cached_property
    def span(self):
        """The x-interval of the layer [m]."""
        end = self.start + self.direction * self.length
        return min(self.start, end), max(self.start, end)
