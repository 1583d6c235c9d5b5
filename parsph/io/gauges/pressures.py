"""Pressure at points of the fluid or of walls."""

from functools import lru_cache

import numpy as np

from ...jit import jit
from ...kernels import kernel_value
from .base import Gauge, column_sums, fluid_near, reach_of


def pressures_at(simulation, points):
    """Return the pressure at points of the fluid or of walls [Pa], shape (n,), on rank 0; collective.

    ``sum_b (p_b + rho0 g . (x - x_b)) V_b W / sum_b V_b W``: normalised, with the hydrostatic difference between particle and
    point compensated, so that it is exact for water at rest, one-sided at walls included. 0 where no fluid is near, and
    where little is near and the pressure would be negative: above a waterline.

    Parameters
    ----------
    points : ndarray, shape (n, dim)
        [m]
    """
    position, mass, density, first, last = fluid_near(simulation, points)
    if simulation.communicator.rank:
        return np.zeros(0)
    sweep, dim = simulation.sweep, points.shape[1]
    pressure = simulation.state.pressure(density)
    scale = sweep.kernel.norms[dim - 1] / sweep.h**dim
    weight = sweep.rho0 * np.array(sweep.gravity)
    compiled = _compiled_pressures(sweep.kernel.code)
    numbers = weight, sweep.h, reach_of(simulation)
    return compiled(points, first, last, position, mass / density * scale, pressure, *numbers)


COVERED = 0.25  # share of the kernel that fluid fills at a waterline on a wall


@lru_cache
def _compiled_pressures(kernel):
    """Return what interpolates pressure at points with a kernel."""

    def pressures(points, first, last, position, weights, pressure, weight, h, reach):
        found = np.zeros(len(points))
        for k in range(len(points)):
            whole, total = 0.0, 0.0
            for j in range(first[k], last[k]):
                r2, head = 0.0, 0.0
                for d in range(points.shape[1]):
                    apart = points[k, d] - position[j, d]
                    r2 += apart * apart
                    head += weight[d] * apart
                if r2 < reach * reach:
                    VW = weights[j] * kernel_value(kernel, np.sqrt(r2) / h)
                    whole += VW
                    total += VW * (pressure[j] + head)
            if whole > 0.0:
                found[k] = total / whole
                if whole < COVERED:
                    found[k] = max(found[k], 0.0)
        return found

    return jit(pressures)


class PressureGauge(Gauge):
    """Pressure at a point of the fluid or of a wall, or its mean over several: see `pressures_at`.

    Parameters
    ----------
    points : ndarray, shape (n, dim)
        [m]
    motion : object or None
        What moves them, with the wall that they are fixed to: ``at(time)`` has ``place(points)``.
    """

    columns = ("pressure [Pa]",)

    def __init__(self, name, every, points, motion=None, folder=None):
        super().__init__(name, every, folder)
        self.points, self.motion = np.asarray(points, float), motion

    def measure(self, simulation):
        points = self.points if self.motion is None else self.motion.at(simulation.time).place(self.points)
        pressures = pressures_at(simulation, points)
        return (
            ()
            if simulation.communicator.rank
            else (column_sums(pressures[:, None], np.array([0, len(pressures)]))[0, 0] / len(pressures),)
        )
