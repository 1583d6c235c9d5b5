"""Gauges: small records of the flow with a sampling interval of their own.

A gauge gathers the few particles it needs, or sums per column, on rank 0, in the global order of (cell, id): its record
does not depend on the number of ranks.
"""

import numpy as np

from ..jit import jit
from ..kernels import kernel_value
from ..observers import Observer
from ..particles import FIRST_GHOST
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


def gathered(simulation, low, high, wanted=None):
    """Return the fluid between two x [m] that is `wanted`, on rank 0; nothing elsewhere.

    Parameters
    ----------
    low, high : float
        [m]
    wanted : callable, optional
        Gets positions, shape (n, dim), and returns which of them, shape (n,).

    Returns
    -------
    tuple of ndarray
        Position [m], shape (n, dim), mass [kg] and density [kg/m^3], in the order of (cell, id).
    """
    p, dim = simulation.particles, simulation.sweep.dim
    first, last = simulation.domain.rows_between(low, high)
    rows = first + np.flatnonzero(p.tags[first:last] < FIRST_GHOST)
    position = p.field("position", rows)
    chosen = (position[:, 0] > low) & (position[:, 0] < high)
    if wanted is not None:
        chosen &= wanted(position)
    rows = rows[chosen]
    table = np.stack([*position[chosen].T, p.field("mass", rows), p.field("density", rows)], axis=1)
    table = simulation.communicator.stack(table)
    return table[:, :dim], table[:, dim], table[:, dim + 1]


def particles_near(simulation, x):
    """Return what is within the kernel's reach of the plane at `x` [m], on rank 0, as `gathered`."""
    reach = _reach(simulation)
    return gathered(simulation, x - reach, x + reach)


def _reach(simulation):
    sweep = simulation.sweep
    return sweep.kernel.support * sweep.h * sweep.h_growth


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
    sweep, reach, dim = simulation.sweep, _reach(simulation), points.shape[1]
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    size = np.floor((high - low) / reach).astype(int) + 3
    near = np.zeros(size, bool)
    index = np.floor((points - low) / reach).astype(int) + 1
    for shift in np.ndindex((3,) * dim):
        near[tuple((index + np.array(shift) - 1).T)] = True

    def wanted(position):
        cells = np.floor((position - low) / reach).astype(int) + 1
        inside = ((cells >= 0) & (cells < size)).all(axis=1)
        return inside & near[tuple(np.where(inside[:, None], cells, 0).T)]

    position, mass, density = gathered(simulation, low[0], high[0], wanted)
    if simulation.communicator.rank:
        return np.zeros(0)
    order = np.argsort(position[:, 0], kind="stable")
    position, volume, density = position[order], (mass / density)[order], density[order]
    pressure = simulation.state.pressure(density)
    first = np.searchsorted(position[:, 0], points[:, 0] - reach)
    last = np.searchsorted(position[:, 0], points[:, 0] + reach)
    scale = sweep.kernel.norms[dim - 1] / sweep.h**dim
    weight = sweep.rho0 * np.array(sweep.gravity)
    return _pressures(points, first, last, position, volume * scale, pressure, weight, sweep.h, reach, sweep.kernel.code)


COVERED = 0.25  # share of the kernel that fluid fills at a waterline on a wall


@jit
def _pressures(points, first, last, position, weights, pressure, weight, h, reach, kernel):
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


class PressureGauge(Gauge):
    """Pressure at a point of the fluid or of a wall, or its mean over several: see `pressures_at`.

    Parameters
    ----------
    points : ndarray, shape (n, dim)
        [m]
    """

    columns = ("pressure [Pa]",)

    def __init__(self, name, every, points, folder=None):
        super().__init__(name, every, folder)
        self.points = np.asarray(points, float)

    def measure(self, simulation):
        pressures = pressures_at(simulation, self.points)
        return (
            ()
            if simulation.communicator.rank
            else (column_sums(pressures[:, None], np.array([0, len(pressures)]))[0, 0] / len(pressures),)
        )


class ForceGauge(Gauge):
    """Force and moment of the fluid's pressure on a wall, per metre of width: ``F = -sum p n dl`` over its pieces.

    Parameters
    ----------
    points, normals, lengths : ndarray, shapes (n, 2), (n, 2), (n,)
        Pieces of the wall: midpoints [m], normals into the fluid, lengths [m].
    motion : Swing or None
        What moves them.
    about : tuple of float
        What the moment is taken about [m]; counter-clockwise is positive.
    """

    columns = ("force x [N/m]", "force up [N/m]", "moment [N]")

    def __init__(self, name, every, points, normals, lengths, motion, about, folder=None):
        super().__init__(name, every, folder)
        self.points, self.normals, self.lengths = points, normals, lengths
        self.motion, self.about = motion, np.asarray(about, float)

    def measure(self, simulation):
        points, normals = self.points, self.normals
        if self.motion is not None:
            now = self.motion.at(simulation.time)
            points, normals = now.place(points), now.turn(normals, points)
        pressures = pressures_at(simulation, points)
        if simulation.communicator.rank:
            return ()
        push = -(pressures * self.lengths)[:, None] * normals
        arm = points - self.about
        parts = np.column_stack([push, arm[:, 0] * push[:, 1] - arm[:, 1] * push[:, 0]])
        return tuple(column_sums(parts, np.array([0, len(parts)]))[0])


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
