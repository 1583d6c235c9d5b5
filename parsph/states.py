"""Equations of state: pressure, its inverse, and the compressible energy."""

from dataclasses import dataclass

import numpy as np

from .jit import jit
from .particles import FIRST_GHOST

TAIT, LINEAR = range(2)
STATES = {"tait": TAIT, "linear": LINEAR}
EQUATIONS = {
    "tait": "p = rho0 c0^2/gamma ((rho/rho0)^gamma - 1)   [Szmidt eq. (15), Molteni et al. eq. (3.1)]",
    "linear": "p = c0^2 (rho - rho0)",
}


@jit
def pressure_of(density, state):
    """Pressure [Pa] at `density` [kg/m^3]; `state` is (code, rho0, c0, gamma)."""
    code, rho0, c0, gamma = state
    if code == LINEAR:
        return c0 * c0 * (density - rho0)
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
    return rho0 * (1.0 + gamma * pressure / (rho0 * c0 * c0)) ** (1.0 / gamma)


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
        "tait" or "linear".
    rho0, c0, gamma : float
        Reference density [kg/m^3], sound speed [m/s], exponent [-].
    """

    name: str
    rho0: float
    c0: float
    gamma: float

    @property
    def constants(self):
        """What the compiled code gets: (code, rho0, c0, gamma)."""
        return STATES[self.name], self.rho0, self.c0, self.gamma

    def pressure(self, density):
        """Return the pressure [Pa] at `density` [kg/m^3], any shape."""
        return pressure_of.py_func(np.asarray(density), self.constants)

    def density(self, pressure):
        """Return the density [kg/m^3] at `pressure` [Pa], any shape."""
        return density_of.py_func(np.asarray(pressure), self.constants)

    def energy(self, density):
        """Return the compressible energy per mass [J/kg], the integral of p/rho^2 from rho0 to `density`."""
        ratio = np.asarray(density) / self.rho0
        if self.name == "linear":
            return self.c0**2 * (np.log(ratio) + 1 / ratio - 1)
        gamma = self.gamma
        return self.c0**2 / gamma * (ratio ** (gamma - 1) / (gamma - 1) + 1 / ratio - gamma / (gamma - 1))
