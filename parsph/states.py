"""Equations of state: pressure, its inverse, and the compressible energy."""

from dataclasses import dataclass

import numpy as np

from .jit import jit
from .particles import FIRST_GHOST

TAIT, LINEAR, SHALLOW = range(3)
STATES = {"tait": TAIT, "linear": LINEAR, "shallow": SHALLOW}
EQUATIONS = {
    "tait": "p = rho0 c0^2/gamma ((rho/rho0)^gamma - 1)   [Szmidt eq. (15), Molteni et al. eq. (3.1)]",
    "linear": "p = c0^2 (rho - rho0)",
    "shallow": "p = g rho^2/2 with the depth as rho   [shallow water; Molteni et al. eqs. (2.1), (2.2)]",
}

# In shallow water the depth plays the density: what has other units than elsewhere.
SHALLOW_UNITS = {"density": "m", "start_density": "m", "pressure": "m^3/s^2", "mass": "m^2"}
SHALLOW_UNITS |= {"density_rate": "m/s", "last_density_rate": "m/s"}


@jit
def pressure_of(density, state):
    """Pressure [Pa] at `density` [kg/m^3]; `state` is (code, rho0, c0, gamma)."""
    code, rho0, c0, gamma = state
    if code == LINEAR:
        return c0 * c0 * (density - rho0)
    if code == SHALLOW:  # c0^2 = g rho0
        return 0.5 * c0 * c0 / rho0 * density * density
    ratio = density / rho0
    if gamma == 7.0:  # products: a general power costs more than the rest of the pass
        cube = ratio * ratio * ratio
        power = cube * cube * ratio
    else:
        power = ratio**gamma
    return rho0 * c0 * c0 / gamma * (power - 1.0)


@jit
def density_of(pressure, state):
    """Density [kg/m^3] at `pressure` [Pa]: the inverse state equation."""
    code, rho0, c0, gamma = state
    if code == LINEAR:
        return rho0 + pressure / (c0 * c0)
    if code == SHALLOW:
        return np.sqrt(2.0 * rho0 * pressure) / c0
    power = 1.0 + gamma * pressure / (rho0 * c0 * c0)
    if gamma == 7.0 and 0.5 < power < 2.0:  # Newton's root: a general power costs more than all else that a ghost needs
        ratio = 1.0 + pressure / (rho0 * c0 * c0)
        for _ in range(4):
            sixth = ratio * ratio * ratio
            sixth *= sixth
            ratio -= (ratio - power / sixth) / 7.0
        return rho0 * ratio
    return rho0 * power ** (1.0 / gamma)


@jit
def _densities(pressures, state):
    densities = np.empty(pressures.size)
    for k in range(pressures.size):
        densities[k] = density_of(pressures.flat[k], state)
    return densities


@jit
def density_gap(pressure, density, state):
    """How far a density is from that at a `pressure` [Pa], over itself: rho(p)/rho - 1, for one nearby.

    Without the power of `density_of`: a Newton step of the Tait equation, whose error is 3 gap^2.
    """
    code, rho0, c0, gamma = state
    if code != TAIT:
        return density_of(pressure, state) / density - 1.0
    now = pressure_of(density, state)
    return (pressure - now) / (gamma * now + rho0 * c0 * c0)


@jit
def update_pressure(rows, tags, first, last, density_column, lowest, highest, state):
    """Set the pressure, one column behind the density, of the fluid rows ``first:last``.

    Returns
    -------
    int
        The first row whose density is not within ``lowest..highest`` (NaN included), -1 if all are.
    """
    bad = -1
    for i in range(first, last):
        density = rows[i, density_column]
        if tags[i] < FIRST_GHOST and not (lowest < density < highest) and bad < 0:
            bad = i
        rows[i, density_column + 1] = pressure_of(density, state)
    return bad


@dataclass(frozen=True)
class State:
    """An equation of state with its numbers.

    Attributes
    ----------
    name : str
        "tait", "linear" or "shallow".
    rho0, c0, gamma : float
        Reference density [kg/m^3], sound speed [m/s], exponent [-]. In shallow water the density is the depth [m], and c0
        the speed of long waves on the reference depth, sqrt(g rho0).
    """

    name: str
    rho0: float
    c0: float
    gamma: float

    @property
    def constants(self):
        """What the compiled code gets: (code, rho0, c0, gamma)."""
        return STATES[self.name], self.rho0, self.c0, self.gamma

    def unit(self, field):
        """Return the unit of a particle field (an entry of `parsph.particles.FIELDS`)."""
        return SHALLOW_UNITS.get(field.name, field.unit) if self.name == "shallow" else field.unit

    def pressure(self, density):
        """Return the pressure [Pa] at `density` [kg/m^3], any shape."""
        return pressure_of.py_func(np.asarray(density), self.constants)

    def density(self, pressure):
        """Return the density [kg/m^3] at `pressure` [Pa], any shape."""
        return _densities(np.atleast_1d(np.asarray(pressure, float)), self.constants).reshape(np.shape(pressure))

    def still_density(self, head):
        """Return the density [kg/m^3] where water at rest has the potential `head` = g depth [m^2/s^2] above it, any shape.

        The solution of ``dp/d(depth) = rho g`` for this state; above the surface that of the surface.
        """
        head = np.maximum(head, 0.0) / self.c0**2
        if self.name == "linear" or self.gamma == 1.0:
            return self.rho0 * np.exp(head)
        return self.rho0 * (1.0 + (self.gamma - 1.0) * head) ** (1.0 / (self.gamma - 1.0))

    def energy(self, density):
        """Return the compressible energy per mass [J/kg], the integral of p/rho^2 from rho0 to `density`."""
        ratio = np.asarray(density) / self.rho0
        if self.name == "linear":
            return self.c0**2 * (np.log(ratio) + 1 / ratio - 1)
        if self.name == "shallow":
            return 0.5 * self.c0**2 * (ratio - 1)
        gamma = self.gamma
        return self.c0**2 / gamma * (ratio ** (gamma - 1) / (gamma - 1) + 1 / ratio - gamma / (gamma - 1))
