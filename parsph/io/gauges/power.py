"""Power: what takes energy from the fluid, term by term, so that its books can be closed."""

from dataclasses import replace

import numpy as np

from ...terms import NONE
from .base import Gauge, column_sums, total_of_columns


class PowerGauge(Gauge):
    """Power that viscosity and density diffusion give the fluid, below 0 where they take it, and what all else gives.

    ``dE/dt = sum_a m_a (v_a . dv_a/dt + p_a/rho_a^2 drho_a/dt - g . dx_a/dt)`` is the sum of the three: its integral over time
    is the change of energy but for the error of the time step. Pairs of fluid keep kinetic, potential and compressible energy,
    whatever they do (Price 2012, J. Comput. Phys. 231, 759), but by the first two; what all else gives is what walls do,
    tensile control, particle shifting and divergences other than the plain one.

    Sums run per column first and over the columns in their order.
    """

    columns = ("viscosity [W]", "diffusion [W]", "all else [W]")

    def begin(self, simulation):
        super().begin(simulation)
        sweep = simulation.sweep
        self._conserving = replace(sweep, terms=replace(sweep.terms, viscosity=NONE, diffusion=NONE))

    def measure(self, simulation):
        with simulation.present():
            domain, p = simulation.domain, simulation.particles
            simulation.prepare_sweep()
            whole = simulation.sweep.rates(p, domain.starts, domain.slab)
            part = self._conserving.rates(p, domain.starts, domain.slab)
            rows = p.fluid
            velocity, mass, density = (p.field(name, rows) for name in ("velocity", "mass", "density"))
            per_rate = p.field("pressure", rows) / density**2
            drift = whole[2][rows] if len(whole[2]) else 0.0
            gravity = np.array(simulation.sweep.gravity)

            def power(acceleration, density_rate):
                return mass * ((velocity * acceleration[rows]).sum(axis=1) + per_rate * density_rate[rows])

            viscosity = power(whole[0] - part[0], np.zeros_like(part[1]))
            diffusion = power(np.zeros_like(part[0]), whole[1] - part[1])
            rest = power(*part[:2]) - mass * ((velocity + drift) @ gravity)
            sums = column_sums(np.stack([viscosity, diffusion, rest], axis=1), np.searchsorted(rows, domain.column_bounds()))
        return total_of_columns(simulation.communicator.stack(sums))
