"""Mass, energies and momentum of a region."""

import numpy as np

from .base import Gauge, column_sums, total_of_columns


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
