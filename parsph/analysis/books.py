"""Energy books: what the fluid's energy has changed by, and what took it."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError


@dataclass(frozen=True)
class Books:
    """Energy books of a run, from its beginning to each time.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s]
    kinetic, potential, compressible : ndarray, shape (n,)
        Change of each energy [J].
    viscosity, diffusion, rest : ndarray, shape (n,)
        What viscosity, density diffusion and all else have given the fluid [J].
    """

    time: np.ndarray
    kinetic: np.ndarray
    potential: np.ndarray
    compressible: np.ndarray
    viscosity: np.ndarray
    diffusion: np.ndarray
    rest: np.ndarray

    @property
    def change(self):
        """Change of kinetic, potential and compressible energy together [J], shape (n,)."""
        return self.kinetic + self.potential + self.compressible

    @property
    def open(self):
        """What of the change nothing accounts for [J], shape (n,): the error of the time step, and of sampling the power."""
        return self.change - self.viscosity - self.diffusion - self.rest


def energy_books(energy, power):
    """Return the `Books` of a run from its records.

    Parameters
    ----------
    energy : ndarray, shape (m, 5) or wider
        Of a gauge of energy, of everything: time [s], mass, then kinetic, potential and compressible energy [J].
    power : ndarray, shape (n, 4)
        Of a gauge of power: time [s], then the power of viscosity, diffusion and all else [W]. It should have several samples
        in whatever dissipates; their trapezoids are summed.

    Raises
    ------
    SceneError
        When a record has no two samples, or they have no time in common.
    """
    from scipy.integrate import cumulative_trapezoid  # slow to import, and few need it

    energy, power = np.asarray(energy, float), np.asarray(power, float)
    if min(len(energy), len(power)) < 2 or energy[-1, 0] < power[1, 0]:
        why = "the change between two samples is what is accounted for"
        raise SceneError("too few samples", where="record", why=why, cure="gauges of energy and power over the same time")
    time = power[power[:, 0] <= energy[-1, 0], 0]
    changes = (np.interp(time, energy[:, 0], part) - np.interp(time[0], energy[:, 0], part) for part in energy[:, 2:5].T)
    given = cumulative_trapezoid(power[: len(time), 1:], time, axis=0, initial=0)
    return Books(time, *changes, *given.T)
