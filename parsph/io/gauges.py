"""Gauges: small records of the flow with a sampling interval of their own.

A gauge gathers the few particles it needs, or sums per column, on rank 0, in the global order of (cell, id): its record
does not depend on the number of ranks.
"""

import numpy as np

from ..jit import jit
from ..kernels import kernel_value
from ..observers import Observer
from .tables import Table


class Gauge(Observer):
    """Base of all gauges: a table that gets a row whenever the gauge is due.

    Parameters
    ----------
    name : str
        The table is ``gauges/<name>.csv``.
    every : float
        Sampling interval [s].
    folder : Path or None
        The run's folder; None keeps the record in memory only.
    """

    phase = "gauges"
    columns = ()

    def __init__(self, name, every, folder=None):
        super().__init__(every)
        self.name, self.folder = name, folder
        self.records = []
        self._table = None

    def begin(self, simulation):
        if simulation.communicator.rank == 0 and self.folder is not None:
            self._table = Table(self.folder / "gauges" / f"{self.name}.csv", ["time [s]", *self.columns])

    def observe(self, simulation):
        values = self.measure(simulation)
        if simulation.communicator.rank == 0:
            row = [simulation.time, *values]
            self.records.append(row)
            if self._table:
                self._table.add(row)

    def finish(self, simulation):
        if self._table:
            self._table.close()

    def record(self):
        """Return what was recorded, shape (samples, 1 + columns), time [s] first."""
        return np.array(self.records).reshape(len(self.records), -1)

    def measure(self, simulation):
        """Return the values of the present time on rank 0; collective."""
        raise NotImplementedError


def particles_near(simulation, x):
    """Return what is within the kernel's reach of the plane at `x` [m], on rank 0; nothing elsewhere.

    Returns
    -------
    tuple of ndarray
        Position [m], shape (n, dim), mass [kg] and density [kg/m^3], in the order of (cell, id).
    """
    sweep, p = simulation.sweep, simulation.particles
    reach = sweep.kernel.support * sweep.h * sweep.h_growth
    first, last = simulation.domain.rows_between(x - reach, x + reach)
    rows = p.fluid
    rows = rows[np.searchsorted(rows, first) : np.searchsorted(rows, last)]
    rows = rows[np.abs(p.field("position", rows)[:, 0] - x) < reach]
    columns = *p.field("position", rows).T, p.field("mass", rows), p.field("density", rows)
    table = simulation.communicator.stack(np.stack(columns, axis=1))
    return table[:, : sweep.dim], table[:, sweep.dim], table[:, sweep.dim + 1]


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
        return (_top_of_water(position[close, -1], away[close], volume[close] * scale, sweep.h, sweep.kernel.code),)


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


@jit
def _top_of_water(heights, away, weights, h, kernel):
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


class PressureGauge(Gauge):
    """Pressure at a point of the fluid or of a wall.

    ``sum_b (p_b + rho0 g . (x - x_b)) V_b W / sum_b V_b W``: normalised, with the hydrostatic difference between particle and
    point compensated, so that it is exact for water at rest, one-sided at walls included. 0 where no fluid is near.
    """

    columns = ("pressure [Pa]",)

    def __init__(self, name, every, place, folder=None):
        super().__init__(name, every, folder)
        self.place = np.asarray(place, float)

    def measure(self, simulation):
        position, mass, density = particles_near(simulation, self.place[0])
        if simulation.communicator.rank:
            return ()
        sweep = simulation.sweep
        apart = self.place - position
        weights = mass / density * sweep.kernel.value(np.sqrt((apart**2).sum(axis=1)), sweep.h, sweep.dim)
        total = weights.sum()
        if total <= 0:
            return (0.0,)
        pressure = simulation.state.pressure(density) + sweep.rho0 * apart @ np.array(sweep.gravity)
        return ((weights * pressure).sum() / total,)


class EnergyGauge(Gauge):
    """Mass, energies and momentum of a region.

    Potential energy counts from height 0; compressible energy is the integral of p/rho^2 from rho0.
    Sums run per column first and over the columns in their order.

    Parameters
    ----------
    low, high : tuple of float
        Corners of the region [m].
    """

    columns = (
        "mass [kg]",
        "kinetic energy [J]",
        "potential energy [J]",
        "compressible energy [J]",
        "momentum x [kg m/s]",
        "momentum up [kg m/s]",
    )

    def __init__(self, name, every, low, high, folder=None):
        super().__init__(name, every, folder)
        self.low, self.high = np.asarray(low, float), np.asarray(high, float)

    def measure(self, simulation):
        p = simulation.particles
        rows = p.fluid
        position, velocity = p.field("position", rows), p.field("velocity", rows)
        mass, density = p.field("mass", rows), p.field("density", rows)
        inside = ((position >= self.low) & (position < self.high)).all(axis=1)
        mass = np.where(inside, mass, 0.0)
        parts = np.stack(
            [
                mass,
                0.5 * mass * (velocity**2).sum(axis=1),
                -mass * (position @ np.array(simulation.sweep.gravity)),
                mass * simulation.state.energy(density),
                mass * velocity[:, 0],
                mass * velocity[:, -1],
            ],
            axis=1,
        )
        bounds = np.searchsorted(rows, simulation.domain.column_bounds())
        sums = simulation.communicator.stack(column_sums(parts, bounds))
        return total_of_columns(sums)


@jit
def column_sums(values, bounds):
    """Sum rows of `values` (n, k) between consecutive `bounds`, one row after another; shape (len(bounds) - 1, k)."""
    sums = np.zeros((len(bounds) - 1, values.shape[1]))
    for column in range(len(bounds) - 1):
        for row in range(bounds[column], bounds[column + 1]):
            for k in range(values.shape[1]):
                sums[column, k] += values[row, k]
    return sums


def total_of_columns(sums):
    """Return the sum over columns (axis 0) in their order."""
    total = np.zeros(sums.shape[1])
    for row in sums:
        total += row
    return total
