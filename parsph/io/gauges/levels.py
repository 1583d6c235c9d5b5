"""Water surface above a point of the bed, and the depth of shallow water."""

from functools import lru_cache

import numpy as np

from ...jit import jit
from ...kernels import kernel_value
from .base import Gauge, particles_near


class LevelGauge(Gauge):
    """Water surface above a point of the bed.

    The volume fraction ``sum_b m_b/rho_b W(x - x_b)`` is one half at a flat surface. The level is where it falls through one
    half at the top of the highest body of water that is at least a smoothing length thick, so that drops and spray do not
    count and an overturning crest counts once.

    Parameters
    ----------
    place : tuple of float
        Horizontal position [m] (x, and y in 3D).
    sides : tuple of (low, high)
        Box whose sides mirror the fluid, so that a gauge beside a wall reads right [m]; infinite where open.
    """

    columns = ("level [m]",)

    def __init__(self, name, every, place, sides, folder=None):
        super().__init__(name, every, folder)
        self.place, self.sides = np.asarray(place, float), sides

    def measure(self, simulation):
        position, mass, density = particles_near(simulation, self.place[0])
        if simulation.communicator.rank:
            return ()
        sweep = simulation.sweep
        reach = sweep.kernel.support * sweep.h
        position, volume = _with_images(position, mass / density, self.sides, self.place, reach)
        away = ((position[:, :-1] - self.place) ** 2).sum(axis=1)
        close = away < reach**2
        if not close.any():
            return (self.sides[0][-1],)
        scale = sweep.kernel.norms[sweep.dim - 1] / sweep.h**sweep.dim
        return (_compiled_top(sweep.kernel.code)(position[close, -1], away[close], volume[close] * scale, sweep.h),)


def _with_images(position, volume, sides, place, reach):
    """Add the mirror images at those sides of the box that are within `reach` of the gauge, and at the bed."""
    for d in range(position.shape[1]):
        for side in (sides[0][d], sides[1][d]):
            vertical = d == position.shape[1] - 1
            if not np.isfinite(side) or (not vertical and abs(place[d] - side) >= reach):
                continue
            near = np.abs(position[:, d] - side) < reach
            images = position[near].copy()
            images[:, d] = 2 * side - images[:, d]
            position, volume = np.concatenate([position, images]), np.concatenate([volume, volume[near]])
    return position, volume


@jit
def _fraction(z, heights, away, weights, h, kernel):
    total = 0.0
    for j in range(len(heights)):
        dz = z - heights[j]
        total += weights[j] * kernel_value(kernel, np.sqrt(away[j] + dz * dz) / h)
    return total


@lru_cache
def _compiled_top(kernel):
    """Return what finds the top of the water for a kernel."""

    def top_of_water(heights, away, weights, h):
        """Height where the volume fraction falls through one half, from above, ignoring water thinner than h."""
        step = 0.1 * h
        z = heights.max() + 3.0 * h
        bottom = heights.min()
        surface, wet = bottom, 0
        below = _fraction(z, heights, away, weights, h, kernel)
        while z > bottom:
            above = below
            z -= step
            below = _fraction(z, heights, away, weights, h, kernel)
            if below >= 0.5:
                if wet == 0:
                    surface = z + step * (below - 0.5) / (below - above)
                wet += 1
                if wet >= 10:
                    return surface
            else:
                wet = 0
        return surface

    return jit(top_of_water)


class DepthGauge(Gauge):
    """Depth of shallow water at a place: between the depths of the particles on both sides; 0 where none is near.

    Parameters
    ----------
    x : float
        [m]
    """

    columns = ("level [m]",)

    def __init__(self, name, every, x, folder=None):
        super().__init__(name, every, folder)
        self.place = np.array([x], float)

    def measure(self, simulation):
        position, _, density = particles_near(simulation, self.place[0])
        if simulation.communicator.rank:
            return ()
        if not len(position):
            return (0.0,)
        order = np.argsort(position[:, 0], kind="stable")
        return (np.interp(self.place[0], position[order, 0], density[order]),)
