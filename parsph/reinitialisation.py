"""The pass that sums densities anew, now and then: re-initialisation.

Same order of sums as in the sweep: no dependence on the number of ranks.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .columns import cells_per_column, choose_candidates, fluid_box, most_candidates
from .jit import jit
from .kernels import kernel_value
from .particles import FIRST_GHOST
from .terms.filter import filtered_density


@lru_cache
def compiled_filter(dim, kernel, law):
    """Return the pass that sums densities anew, for these codes; numbers are run-time arguments."""
    strips = 3 ** (dim - 1)
    size = dim + 1

    def sum_densities(rows, tags, starts, first_cell, last_cell, grid, numbers, densities):
        cell_size, shape = grid
        h, norm = numbers
        stride = cells_per_column(shape)
        most = most_candidates(starts, first_cell, last_cell, 1, strips, stride, shape)
        chosen = np.empty(most + 1, np.int64)
        apart, moments, masses = np.empty(size), np.empty((size, size)), np.empty(size)
        for cell in range(first_cell, last_cell):
            begin, end = starts[cell], starts[cell + 1]
            middle, extent = fluid_box(rows, tags, begin, end, dim)
            if extent[0] < 0.0:
                continue
            reach2 = cell_size * cell_size
            count, _ = choose_candidates(rows, starts, cell, strips, stride, shape, middle, extent, reach2, chosen, begin)
            for i in range(begin, end):
                if tags[i] >= FIRST_GHOST:
                    break
                moments[:] = 0.0
                masses[:] = 0.0
                for k in range(count):
                    j = chosen[k]
                    r2 = 0.0
                    apart[0] = 1.0
                    for d in range(dim):
                        apart[1 + d] = (rows[j, d] - rows[i, d]) / h
                        r2 += apart[1 + d] * apart[1 + d]
                    mass = rows[j, 2 * dim + 2]
                    mW = mass * norm / h**dim * kernel_value(kernel, np.sqrt(r2))
                    VW = mW / rows[j, 2 * dim]
                    for a in range(size):
                        masses[a] += mW * apart[a]
                        for b in range(size):
                            moments[a, b] += VW * apart[a] * apart[b]
                densities[i] = filtered_density(law, masses, moments)

    return jit(sum_densities)


@dataclass(frozen=True)
class DensityFilter:
    """Densities summed over neighbours anew, every so many steps.

    Attributes
    ----------
    sweep : Sweep
        Whose kernel it shares.
    law : Formula
    every : int
        Steps between two.
    """

    sweep: object
    law: object
    every: int

    def __call__(self, particles, starts, slab):
        """Replace the densities of the fluid of `slab`; pressures and halos are then out of date."""
        sweep, p = self.sweep, particles
        compiled = compiled_filter(sweep.dim, sweep.kernel.code, self.law.code)
        sweep.over_slab(compiled, p, starts, slab, p.density_rate)
        rows = p.fluid
        p.shared[rows, p.layout.columns("density")[1]] = p.density_rate[rows, None]
