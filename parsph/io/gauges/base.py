"""What all gauges share: a table with rows at an interval, and the fluid that they look at on rank 0."""

import numpy as np

from ...jit import jit
from ...observers import Observer
from ..tables import Table, read_table


class Gauge(Observer):
    """Base of all gauges: a table that gets a row whenever the gauge is due.

    Parameters
    ----------
    name : str
        The table is ``gauges/<name>.csv``.
    every : float
        Sampling interval [s].
    folder : Path or None
        The run's folder; None keeps the record in memory.
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
            path = self.folder / "gauges" / f"{self.name}.csv"
            self._table = Table(path, ["time [s]", *self.columns], simulation.time if simulation.steps else -np.inf)

    def observe(self, simulation):
        values = self.measure(simulation)
        if simulation.communicator.rank == 0:
            row = [simulation.time, *values]
            if self._table:
                self._table.add(row)
            else:
                self.records.append(row)

    def finish(self, simulation):
        if self._table:
            self._table.close()

    def record(self):
        """Return what was recorded, shape (samples, 1 + columns), time [s] first; on rank 0."""
        if self._table:
            return np.stack(list(read_table(self._table.path).values()), axis=1)
        return np.array(self.records).reshape(len(self.records), -1)

    def measure(self, simulation):
        """Return the values of the present time on rank 0; collective."""
        raise NotImplementedError


def gathered(simulation, low, high, wanted=None):
    """Return the fluid between two x [m] that is `wanted`, copies beyond periodic ends included, on rank 0; nothing elsewhere.

    Parameters
    ----------
    low, high : float
        [m]
    wanted : callable, optional
        Gets positions, shape (n, dim), and returns which of them, shape (n,).

    Returns
    -------
    tuple of ndarray
        Position [m], shape (n, dim), mass [kg] and density [kg/m^3], in the order of (cell, id), copies at the end.
    """
    p, dim, domain = simulation.particles, simulation.sweep.dim, simulation.domain
    rows = domain.fluid_between(low, high)
    position, image = p.field("position", rows), np.zeros(len(rows), int)
    for border in domain.borders:
        originals, copies, bits = border.copies_of(position, reach_of(simulation))
        position, rows = np.concatenate([position, copies]), np.concatenate([rows, rows[originals]])
        image = np.concatenate([image, image[originals] + bits])
    chosen = (position[:, 0] > low) & (position[:, 0] < high)
    if wanted is not None:
        chosen &= wanted(position)
    rows = rows[chosen]
    columns = [*position[chosen].T, p.field("mass", rows), p.field("density", rows)]
    table = simulation.communicator.stack(np.stack([*columns, image[chosen]] if domain.borders else columns, axis=1))
    if domain.borders:
        table = table[np.argsort(table[:, -1], kind="stable")]  # no rank's copies before another one's originals
    return table[:, :dim], table[:, dim], table[:, dim + 1]


def particles_near(simulation, x):
    """Return what is within the kernel's reach of the plane at `x` [m], on rank 0, as `gathered`."""
    reach = reach_of(simulation)
    return gathered(simulation, x - reach, x + reach)


def reach_of(simulation):
    """Return how far the kernel reaches [m]."""
    sweep = simulation.sweep
    return sweep.kernel.support * sweep.h * sweep.h_growth


def fluid_near(simulation, points):
    """Return the fluid within the kernel's reach of any of `points`, on rank 0, and where to look for it; collective.

    Parameters
    ----------
    points : ndarray, shape (n, dim)
        [m]

    Returns
    -------
    tuple of ndarray
        Position [m], shape (m, dim), mass [kg] and density [kg/m^3], sorted by x, and among equals by (cell, id); first and
        last, shape (n,): what is within reach of point k is among the rows ``first[k]:last[k]``. Elsewhere without rows.
    """
    reach, dim = reach_of(simulation), points.shape[1]
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
    order = np.argsort(position[:, 0], kind="stable")
    position, mass, density = position[order], mass[order], density[order]
    first = np.searchsorted(position[:, 0], points[:, 0] - reach)
    last = np.searchsorted(position[:, 0], points[:, 0] + reach)
    return position, mass, density, first, last


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
