"""The neighbour loop: every fluid particle gathers its own right-hand side.

For each cell the candidates of the neighbouring strips are copied to a small scratch, relative to the middle of the cell's
fluid, leaving out those beyond reach of the box around that fluid (a quarter to a third of them), and padded with particles
without mass far away. Then each fluid particle of the cell runs one loop over the scratch that has no branches and a length
that is a multiple of the vector width. Distances beyond the support cost arithmetic but no mispredicted branch. A particle's
sum has an order fixed by (cell, tag), so it does not depend on the number of ranks.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .jit import jit
from .kernels import kernel_slope, kernel_value
from .particles import FIRST_GHOST
from .terms.density import SUMMATION, continuity, summation
from .terms.diffusion import density_diffusion, diffusing_density
from .terms.momentum import pressure_pair
from .terms.viscosity import artificial_viscosity
from .terms.xsph import smoothing_weight

PADDING = 16
SCRATCH_ROWS = 12
FAR = 1.0e4  # support radii; its square is still far from the largest float32


@lru_cache
def compiled_sweep(dim, kernel, density_law, viscosity, diffusion, smoothing, single, variable_h):
    """Return the sweep for these shapes; numbers are run-time arguments.

    Parameters
    ----------
    dim, kernel, viscosity, diffusion, smoothing : int
        Number of dimensions and the codes of kernel and terms; 0 leaves a term out.
    single : bool
        Whether pairs are computed in float32 (one particle's sums included); the state stays float64.
    variable_h : bool
        Whether h grows where particles thin out (1D).
    """
    real = np.float32 if single else np.float64
    strips = 3 ** (dim - 1)

    def sweep(rows, tags, starts, first_cell, last_cell, grid, numbers, gravity, acceleration, density_rate, drift):
        cell_size, shape = grid
        reach2 = cell_size * cell_size
        h, norm, rho0, inverse_c2, alpha_h_c0, delta_h_c0, epsilon, h_over_dx, longest_h = numbers
        stride = 1
        for d in range(1, dim):
            stride *= shape[d]
        most = 0
        for cell in range(first_cell, last_cell):
            if tags_begin_with_fluid(tags, starts, cell):
                most = max(most, candidates(starts, cell, strips, stride, shape))
        scratch = np.empty((SCRATCH_ROWS, (most // PADDING + 1) * PADDING), real)
        chosen = np.empty(scratch.shape[1], np.int64)
        xs, ys, zs = scratch[0], scratch[1], scratch[2]
        us, vs, ws = scratch[3], scratch[4], scratch[5]
        ms, Ps, Vs, ss, Vols, hs = scratch[6], scratch[7], scratch[8], scratch[9], scratch[10], scratch[11]

        inverse_h = real(1.0 / h)
        slope_norm = norm if variable_h else norm / h ** (dim + 2)
        value_norm = norm if variable_h else norm / h**dim
        eta2 = real(0.01 * h * h)
        viscous = real(alpha_h_c0)
        diffusive = real(delta_h_c0)

        for cell in range(first_cell, last_cell):
            begin, end = starts[cell], starts[cell + 1]
            if not tags_begin_with_fluid(tags, starts, cell):
                continue
            # middle and half extent of the box around the fluid of the cell
            cx, cy, cz = rows[begin, 0], rows[begin, min(1, dim - 1)], rows[begin, dim - 1]
            ex, ey, ez = cx, cy, cz
            for i in range(begin + 1, end):
                if tags[i] >= FIRST_GHOST:
                    break
                cx, ex = min(cx, rows[i, 0]), max(ex, rows[i, 0])
                cy, ey = min(cy, rows[i, min(1, dim - 1)]), max(ey, rows[i, min(1, dim - 1)])
                cz, ez = min(cz, rows[i, dim - 1]), max(ez, rows[i, dim - 1])
            ex, ey, ez = 0.5 * (ex - cx), 0.5 * (ey - cy), 0.5 * (ez - cz)
            cx, cy, cz = cx + ex, cy + ey, cz + ez

            # candidates within reach of that box; the next one overwrites one that is not
            count, own = 0, 0
            for strip in range(strips):
                a = starts[cell + strip_offset(strip, strips, stride, shape) - 1]
                b = starts[cell + strip_offset(strip, strips, stride, shape) + 2]
                for j in range(a, b):
                    if j == begin:
                        own = count
                    beyond = max(abs(rows[j, 0] - cx) - ex, 0.0)
                    away = beyond * beyond
                    if dim > 1:
                        beyond = max(abs(rows[j, 1] - cy) - ey, 0.0)
                        away += beyond * beyond
                    if dim > 2:
                        beyond = max(abs(rows[j, 2] - cz) - ez, 0.0)
                        away += beyond * beyond
                    chosen[count] = j
                    count += away <= reach2

            # what pairs need of them, into the scratch
            for o in range(count):
                j = chosen[o]
                x = rows[j, 0] - cx
                hydrostatic = gravity[0] * x
                xs[o] = x
                us[o] = rows[j, dim]
                if dim > 1:
                    y = rows[j, 1] - cy
                    hydrostatic += gravity[1] * y
                    ys[o] = y
                    vs[o] = rows[j, dim + 1]
                if dim > 2:
                    z = rows[j, 2] - cz
                    hydrostatic += gravity[2] * z
                    zs[o] = z
                    ws[o] = rows[j, dim + 2]
                density = rows[j, 2 * dim]
                mass = rows[j, 2 * dim + 2]
                inverse = 1.0 / density
                ms[o] = mass
                Ps[o] = rows[j, 2 * dim + 1] * inverse * inverse
                Vs[o] = inverse
                if diffusion != 0:
                    ss[o] = diffusing_density(diffusion, density - rho0, rho0 * inverse_c2 * hydrostatic)
                    Vols[o] = mass * inverse
                if variable_h:
                    hs[o] = min(max(h_over_dx * mass * inverse, h), longest_h)
            padded = (count + PADDING - 1) // PADDING * PADDING
            for o in range(count, padded):
                xs[o] = FAR * cell_size
                ys[o] = 0.0
                zs[o] = 0.0
                us[o] = 0.0
                vs[o] = 0.0
                ws[o] = 0.0
                ms[o] = 0.0
                Ps[o] = 0.0
                Vs[o] = 0.0
                ss[o] = 0.0
                Vols[o] = 0.0
                hs[o] = h

            # one particle's sums at a time
            for i in range(begin, end):
                if tags[i] >= FIRST_GHOST:
                    break
                o = own + i - begin
                x, y, z = xs[o], ys[o], zs[o]
                u, v, w = us[o], vs[o], ws[o]
                P, V, s = Ps[o], Vs[o], ss[o]
                fx, fy, fz = real(0.0), real(0.0), real(0.0)
                rate, diffused = real(0.0), real(0.0)
                px, py, pz = real(0.0), real(0.0), real(0.0)
                for j in range(padded):
                    dx = x - xs[j]
                    du = u - us[j]
                    r2 = dx * dx
                    vr = du * dx
                    if dim > 1:
                        dy = y - ys[j]
                        dv = v - vs[j]
                        r2 += dy * dy
                        vr += dv * dy
                    if dim > 2:
                        dz = z - zs[j]
                        dw = w - ws[j]
                        r2 += dz * dz
                        vr += dw * dz
                    if variable_h:
                        inverse_h = real(2.0) / (hs[o] + hs[j])
                    q = np.sqrt(r2) * inverse_h
                    F = kernel_slope(kernel, q)
                    if variable_h:
                        F *= inverse_h * inverse_h * inverse_h
                    mF = ms[j] * F
                    pair = pressure_pair(P, Ps[j])
                    if viscosity != 0:
                        pair += artificial_viscosity(viscous, vr, r2, eta2, V, Vs[j])
                    force = mF * pair
                    fx -= force * dx
                    if density_law == SUMMATION or smoothing != 0:
                        W = kernel_value(kernel, q)
                        if variable_h:
                            W *= inverse_h
                    if density_law == SUMMATION:
                        rate += summation(ms[j], W)
                    else:
                        rate += continuity(mF, vr)
                    if dim > 1:
                        fy -= force * dy
                    if dim > 2:
                        fz -= force * dz
                    if diffusion != 0:
                        diffused += density_diffusion(diffusive, F * Vols[j], s, ss[j])
                    if smoothing != 0:
                        weight = smoothing_weight(ms[j] * W, V, Vs[j])
                        px -= weight * du
                        if dim > 1:
                            py -= weight * dv
                        if dim > 2:
                            pz -= weight * dw
                acceleration[i, 0] = slope_norm * fx + gravity[0]
                if dim > 1:
                    acceleration[i, 1] = slope_norm * fy + gravity[1]
                if dim > 2:
                    acceleration[i, 2] = slope_norm * fz + gravity[2]
                density_rate[i] = value_norm * rate if density_law == SUMMATION else slope_norm * (rate + diffused)
                if smoothing != 0:
                    drift[i, 0] = epsilon * value_norm * px
                    if dim > 1:
                        drift[i, 1] = epsilon * value_norm * py
                    if dim > 2:
                        drift[i, 2] = epsilon * value_norm * pz

    return jit(sweep)


@jit
def tags_begin_with_fluid(tags, starts, cell):
    """Whether `cell` holds a fluid particle: they come first."""
    return starts[cell] < starts[cell + 1] and tags[starts[cell]] < FIRST_GHOST


@jit
def strip_offset(strip, strips, stride, shape):
    """How many cells the middle of neighbouring strip `strip` lies behind the cell itself."""
    if strips == 1:
        return 0
    if strips == 3:
        return (strip - 1) * stride
    return (strip // 3 - 1) * stride + (strip % 3 - 1) * shape[-1]


@jit
def candidates(starts, cell, strips, stride, shape):
    """Number of particles in the strips around `cell`."""
    count = 0
    for strip in range(strips):
        offset = strip_offset(strip, strips, stride, shape)
        count += starts[cell + offset + 2] - starts[cell + offset - 1]
    return count


@dataclass(frozen=True)
class Sweep:
    """The neighbour loop of a scene with its numbers.

    Attributes
    ----------
    kernel : Kernel
    terms : Terms
    dim : int
    h : float
        Smoothing length [m].
    rho0, c0 : float
        Reference density [kg/m^3] and sound speed [m/s].
    gravity : tuple of float
        [m/s^2]
    alpha, delta, epsilon : float
        Strength of viscosity, diffusion and smoothing [-].
    single : bool
        Whether pairs are computed in float32.
    h_over_dx, h_growth : float
        In 1D h may grow with the spacing: ``h_a = h_over_dx m_a/rho_a`` within h and h_growth h. A pair has the mean of two.
    """

    kernel: object
    terms: object
    dim: int
    h: float
    rho0: float
    c0: float
    gravity: tuple
    alpha: float = 0.0
    delta: float = 0.0
    epsilon: float = 0.0
    single: bool = False
    h_over_dx: float = 2.0
    h_growth: float = 1.0

    @property
    def compiled(self):
        """The compiled loop."""
        codes = (self.terms.density.code, self.terms.viscosity.code, self.terms.diffusion.code, self.terms.smoothing.code)
        return compiled_sweep(self.dim, self.kernel.code, *codes, self.single, self.h_growth > 1)

    @property
    def numbers(self):
        """The run-time numbers of the compiled loop."""
        norm = self.kernel.norms[self.dim - 1]
        hc = self.h * self.c0
        longest = self.h * self.h_growth
        return self.h, norm, self.rho0, self.c0**-2, self.alpha * hc, self.delta * hc, self.epsilon, self.h_over_dx, longest

    def __call__(self, particles, starts, slab, first_column, last_column):
        """Set the rates of the fluid in the local columns ``first_column:last_column`` of `slab`."""
        stride, grid = slab.grid.stride, slab.grid
        self.compiled(
            particles.shared,
            particles.tags,
            starts,
            first_column * stride,
            last_column * stride,
            (grid.cell, grid.shape),
            self.numbers,
            self.gravity,
            particles.acceleration,
            particles.density_rate,
            particles.drift,
        )
