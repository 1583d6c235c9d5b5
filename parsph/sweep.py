"""The neighbour loop: every fluid particle gathers its own right-hand side, in one pass for all terms.

A term that needs sums of its neighbours too has those of the evaluation before, which rows carry.

For each block of cells, one above the other, the candidates of the neighbouring strips are copied to a small scratch,
relative to the middle of the block's fluid and in the order of thin layers across the last axis, with particles without mass
far away behind them. What is within reach of a particle stands together there. So each fluid particle of the block runs one
loop over a part of the scratch that has no branches and a length that is a multiple of the vector width: distances beyond the
support cost arithmetic but no mispredicted branch. A particle's sum has an order fixed by (cell, tag) and heights, so it does
not depend on the number of ranks.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .columns import (
    BLOCKS,
    FAR,
    cells_of_block,
    cells_per_column,
    ends_of_layers,
    fluid_box,
    most_candidates,
    order_by_layer,
    within_reach,
)
from .jit import VECTOR, jit
from .kernels import kernel_slope, kernel_value
from .particles import FIRST_GHOST, FOUND
from .terms.correction import corrected_derivative, corrected_value
from .terms.density import RENORMALISED, SMOOTHED, SUMMATION, continuity, renormalised, summation
from .terms.diffusion import ANTUONO, density_diffusion, diffusing_density, renormalised_gradient
from .terms.momentum import pressure_pair
from .terms.shifting import FASTEST, SUN, inside_fluid, shift_factor
from .terms.spray import spray_rate
from .terms.tensile import tensile_excess
from .terms.viscosity import MONAGHAN, NEWTONIAN, UNSEEN, artificial_viscosity, unseen_viscosity
from .terms.xsph import smoothing_weight

SCRATCH_ROWS = 12
STRAINS, SMOOTHINGS, GRADIENTS = 6, 3, 3  # further rows, in scenes that carry them from one evaluation to the next


@lru_cache
def compiled_sweep(
    dim, kernel, density_law, viscosity, diffusion, smoothing, tensile, shifting, spray, correction, single, variable_h
):
    """Return the sweep for these shapes; numbers are run-time arguments.

    Parameters
    ----------
    dim, kernel, density_law, viscosity, diffusion, smoothing, tensile, shifting, spray, correction : int
        Number of dimensions and the codes of kernel and terms; 0 leaves a term out.
    single : bool
        Whether pairs are computed in float32 (one particle's sums included); the state stays float64.
    variable_h : bool
        Whether h grows where particles thin out (1D).
    """
    real, padding = (np.float32, VECTOR // 4) if single else (np.float64, VECTOR // 8)
    strips, block = 3 ** (dim - 1), BLOCKS[dim - 1]

    crowded = tensile != 0 or shifting != 0
    strained = viscosity == NEWTONIAN
    smoothed = density_law == SMOOTHED
    sloped = diffusion == ANTUONO
    first_strain = SCRATCH_ROWS
    first_smoothing = first_strain + STRAINS * strained
    first_gradient = first_smoothing + SMOOTHINGS * smoothed
    scratch_rows = first_gradient + GRADIENTS * sloped

    def sweep(
        rows,
        carried,
        coefficients,
        tags,
        starts,
        first_cell,
        last_cell,
        grid,
        numbers,
        gravity,
        strain_rate,
        density_gradient,
        acceleration,
        density_rate,
        drift,
    ):
        cell_size, shape = grid
        strain_column, smoothing_column, gradient_column = carried
        h, norm, rho0, inverse_c2, alpha_h_c0, delta_h_c0, epsilon, shift_h, h_over_dx, longest_h, gamma, viscosity_mu = numbers
        stride = cells_per_column(shape)
        room = most_candidates(starts, first_cell, last_cell, block, strips, stride, shape) + padding
        scratch = np.empty((scratch_rows, room), real)
        densities, pressures = np.empty(room), np.empty(room)
        chosen, places = np.empty(room, np.uint32), np.empty(room, np.uint32)
        ends = ends_of_layers(block)
        xs, ys, zs = scratch[0], scratch[1], scratch[2]
        us, vs, ws = scratch[3], scratch[4], scratch[5]
        ms, Ps, Vs, ss, Vols, hs = scratch[6], scratch[7], scratch[8], scratch[9], scratch[10], scratch[11]
        if strained:
            Qxx, Qxy, Qxz = scratch[first_strain], scratch[first_strain + 1], scratch[first_strain + 2]
            Qyy, Qyz, Qzz = scratch[first_strain + 3], scratch[first_strain + 4], scratch[first_strain + 5]
        if smoothed:
            sus, svs, sws = scratch[first_smoothing], scratch[first_smoothing + 1], scratch[first_smoothing + 2]
        if sloped:
            gxs, gys, gzs = scratch[first_gradient], scratch[first_gradient + 1], scratch[first_gradient + 2]

        inverse_h = real(1.0 / h)
        slope_norm = norm if variable_h else norm / h ** (dim + 2)
        value_norm = norm if variable_h else norm / h**dim
        eta2 = real(0.01 * h * h)
        viscous = real(alpha_h_c0)
        diffusive = real(delta_h_c0)
        mu, unseen, third = real(viscosity_mu), real(UNSEEN * 2 * (dim + 2)), real(1.0 / 3.0)
        c0_over_h = 1.0 / (h * np.sqrt(inverse_c2))

        for cell in range(first_cell, last_cell):
            cells = cells_of_block(cell, block, shape)
            begin, end = starts[cell], starts[cell + cells]
            middle, extent = fluid_box(rows, tags, begin, end, dim)
            if extent[0] < 0.0:
                continue
            lowest = middle[dim - 1] - extent[dim - 1] - cell_size
            count, own = order_by_layer(
                rows, starts, cell, cells, strips, stride, shape, lowest, cell_size, chosen, places, ends
            )
            cx, cy, cz = middle

            # what pairs need of them, into the scratch
            for k in range(count):
                j, o = chosen[k], places[k]
                xs[o] = rows[j, 0] - cx
                us[o] = rows[j, dim]
                if dim > 1:
                    ys[o] = rows[j, 1] - cy
                    vs[o] = rows[j, dim + 1]
                if dim > 2:
                    zs[o] = rows[j, 2] - cz
                    ws[o] = rows[j, dim + 2]
                densities[o], pressures[o], ms[o] = rows[j, 2 * dim], rows[j, 2 * dim + 1], rows[j, 2 * dim + 2]
                if strained:
                    Qxx[o] = rows[j, strain_column]
                    if dim > 1:
                        Qxy[o] = rows[j, strain_column + 1]
                        Qyy[o] = rows[j, strain_column + dim]
                    if dim > 2:
                        Qxz[o] = rows[j, strain_column + 2]
                        Qyz[o] = rows[j, strain_column + 4]
                        Qzz[o] = rows[j, strain_column + 5]
                if smoothed:
                    sus[o] = rows[j, smoothing_column]
                    if dim > 1:
                        svs[o] = rows[j, smoothing_column + 1]
                    if dim > 2:
                        sws[o] = rows[j, smoothing_column + 2]
                if sloped:  # halves: a pair takes the mean of two
                    gxs[o] = 0.5 * rows[j, gradient_column]
                    if dim > 1:
                        gys[o] = 0.5 * rows[j, gradient_column + 1]
                    if dim > 2:
                        gzs[o] = 0.5 * rows[j, gradient_column + 2]
            for o in range(count):  # apart from the copies, so that vectors do it
                density = densities[o]
                inverse = 1.0 / density
                Ps[o] = pressures[o] * inverse * inverse
                Vs[o] = inverse
                if diffusion != 0:
                    hydrostatic = gravity[0] * xs[o]
                    if dim > 1:
                        hydrostatic += gravity[1] * ys[o]
                    if dim > 2:
                        hydrostatic += gravity[2] * zs[o]
                    ss[o] = diffusing_density(diffusion, density - rho0, rho0, gamma, rho0 * inverse_c2 * hydrostatic)
                if diffusion != 0 or strained:
                    Vols[o] = ms[o] * inverse
                if strained:
                    scale = viscosity_mu * inverse * inverse
                    for row in range(first_strain, first_strain + STRAINS):
                        scratch[row, o] *= scale
                if variable_h:
                    hs[o] = min(max(h_over_dx * ms[o] * inverse, h), longest_h)
            for row in range(scratch_rows):
                for o in range(count, count + padding):
                    scratch[row, o] = 0.0
            for o in range(count, count + padding):
                xs[o] = FAR * cell_size

            # one particle's sums at a time
            for i in range(begin, end):
                if tags[i] >= FIRST_GHOST:
                    continue
                o = places[own + i - begin]
                first, last = within_reach(rows[i, dim - 1], lowest, cell_size, ends)
                padded = (last - first + padding - 1) // padding * padding
                x, y, z = xs[o], ys[o], zs[o]
                u, v, w = us[o], vs[o], ws[o]
                P, V, s = Ps[o], Vs[o], ss[o]
                fx, fy, fz = real(0.0), real(0.0), real(0.0)
                rate, diffused = real(0.0), real(0.0)
                px, py, pz = real(0.0), real(0.0), real(0.0)
                nx, ny, nz, filled = real(0.0), real(0.0), real(0.0), real(0.0)
                if density_law == RENORMALISED:
                    Mxx, Mxy, Mxz, Myy, Myz, Mzz = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
                    Gxx, Gxy, Gxz, Gyy, Gyz, Gzz = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
                if strained:
                    Axx, Axy, Axz, Ayy, Ayz, Azz = Qxx[o], Qxy[o], Qxz[o], Qyy[o], Qyz[o], Qzz[o]
                    Dxx, Dxy, Dxz = real(0.0), real(0.0), real(0.0)
                    Dyy, Dyz, Dzz = real(0.0), real(0.0), real(0.0)
                if smoothed:
                    su, sv, sw = sus[o], svs[o], sws[o]
                if sloped:
                    gx, gy, gz = gxs[o], gys[o], gzs[o]
                    Lxx, Lxy, Lxz, Lyy, Lyz, Lzz = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
                    sx, sy, sz = real(0.0), real(0.0), real(0.0)
                if correction != 0:  # rows of C; those of gradients over what slope_norm has more than value_norm
                    h2 = h * h
                    plain = real(coefficients[i, -1])
                    alpha, alpha_x = real(coefficients[i, 0]), real(coefficients[i, 1])
                    beta_x, beta_xx = real(h2 * coefficients[i, 1]), real(h2 * coefficients[i, dim + 1])
                    if dim > 1:
                        alpha_y = real(coefficients[i, 2])
                        beta_y, beta_xy = real(h2 * coefficients[i, 2]), real(h2 * coefficients[i, dim + 2])
                        beta_yy = real(h2 * coefficients[i, 2 * dim + 1])
                    if dim > 2:
                        alpha_z = real(coefficients[i, 3])
                        beta_z, beta_xz = real(h2 * coefficients[i, 3]), real(h2 * coefficients[i, 6])
                        beta_yz, beta_zz = real(h2 * coefficients[i, 8]), real(h2 * coefficients[i, 9])
                for k in range(padded):
                    j = np.uint64(first + k)
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
                    if diffusion != 0 or strained:
                        VF = Vols[j] * F
                    pair = pressure_pair(P, Ps[j])
                    if viscosity == MONAGHAN:
                        pair += artificial_viscosity(viscous, vr, r2, eta2, V, Vs[j])
                    if strained:
                        qxx = Axx + Qxx[j]
                        sx, trace = qxx * dx, qxx
                        if dim > 1:
                            qxy, qyy = Axy + Qxy[j], Ayy + Qyy[j]
                            sx += qxy * dy
                            sy = qxy * dx + qyy * dy
                            trace += qyy
                        if dim > 2:
                            qxz, qyz, qzz = Axz + Qxz[j], Ayz + Qyz[j], Azz + Qzz[j]
                            sx += qxz * dz
                            sy += qyz * dz
                            sz = qxz * dx + qyz * dy + qzz * dz
                            trace += qzz
                        rQr = sx * dx
                        fx += mF * sx
                        if dim > 1:
                            rQr += sy * dy
                            fy += mF * sy
                        if dim > 2:
                            rQr += sz * dz
                            fz += mF * sz
                        pair += third * trace
                        pair += unseen_viscosity(unseen, mu, vr, rQr, r2, eta2, V, Vs[j])
                        Dxx -= VF * du * dx
                        if dim > 1:
                            Dxy -= VF * (du * dy + dv * dx)
                            Dyy -= VF * dv * dy
                        if dim > 2:
                            Dxz -= VF * (du * dz + dw * dx)
                            Dyz -= VF * (dv * dz + dw * dy)
                            Dzz -= VF * dw * dz
                    if density_law == SUMMATION or smoothing != 0 or correction != 0:
                        W = kernel_value(kernel, q)
                        if variable_h:
                            W *= inverse_h
                    if correction != 0:  # of a particle of its own: beta . r_ab along each axis, then the sums
                        alpha_r, x_r = alpha_x * dx, beta_xx * dx
                        if dim > 1:
                            alpha_r += alpha_y * dy
                            x_r += beta_xy * dy
                            y_r = beta_xy * dx + beta_yy * dy
                        if dim > 2:
                            alpha_r += alpha_z * dz
                            x_r += beta_xz * dz
                            y_r += beta_yz * dz
                            z_r = beta_xz * dx + beta_yz * dy + beta_zz * dz
                        kept = plain * F
                        force = ms[j] * pair
                        wx = corrected_derivative(kept * dx, W, beta_x, x_r)
                        fx -= force * wx
                        vr = du * wx
                        if dim > 1:
                            wy = corrected_derivative(kept * dy, W, beta_y, y_r)
                            fy -= force * wy
                            vr += dv * wy
                        if dim > 2:
                            wz = corrected_derivative(kept * dz, W, beta_z, z_r)
                            fz -= force * wz
                            vr += dw * wz
                        if smoothed:
                            vr += (su - sus[j]) * wx
                            if dim > 1:
                                vr += (sv - svs[j]) * wy
                            if dim > 2:
                                vr += (sw - sws[j]) * wz
                        W = corrected_value(W, alpha, alpha_r)
                    else:
                        force = mF * pair
                        fx -= force * dx
                        if dim > 1:
                            fy -= force * dy
                        if dim > 2:
                            fz -= force * dz
                        if smoothed:
                            vr += (su - sus[j]) * dx
                            if dim > 1:
                                vr += (sv - svs[j]) * dy
                            if dim > 2:
                                vr += (sw - sws[j]) * dz
                    if density_law == SUMMATION:
                        rate += summation(ms[j], W)
                    elif density_law == RENORMALISED:
                        mFx = mF * dx
                        Mxx -= mFx * dx
                        Gxx += mFx * du
                        if dim > 1:
                            mFy = mF * dy
                            Mxy -= mFx * dy
                            Myy -= mFy * dy
                            Gxy += mFx * dv + mFy * du
                            Gyy += mFy * dv
                        if dim > 2:
                            mFz = mF * dz
                            Mxz -= mFx * dz
                            Myz -= mFy * dz
                            Mzz -= mFz * dz
                            Gxz += mFx * dw + mFz * du
                            Gyz += mFy * dw + mFz * dv
                            Gzz += mFz * dw
                    elif correction != 0:
                        rate += continuity(ms[j], vr)
                    else:
                        rate += continuity(mF, vr)
                    if diffusion != 0:
                        s_ab = s - ss[j]
                        if sloped:
                            VFx, linear = VF * dx, (gx + gxs[j]) * dx
                            Lxx -= VFx * dx
                            sx -= VFx * s_ab
                            if dim > 1:
                                VFy = VF * dy
                                linear += (gy + gys[j]) * dy
                                Lxy -= VFx * dy
                                Lyy -= VFy * dy
                                sy -= VFy * s_ab
                            if dim > 2:
                                VFz = VF * dz
                                linear += (gz + gzs[j]) * dz
                                Lxz -= VFx * dz
                                Lyz -= VFy * dz
                                Lzz -= VFz * dz
                                sz -= VFz * s_ab
                            s_ab -= linear
                        diffused += density_diffusion(diffusive, VF, s_ab)
                    if crowded:
                        nx += mF * dx
                        if dim > 1:
                            ny += mF * dy
                        if dim > 2:
                            nz += mF * dz
                    if crowded or spray != 0:
                        filled -= mF * r2
                    if smoothing != 0:
                        weight = smoothing_weight(ms[j] * W, V, Vs[j])
                        px -= weight * du
                        if dim > 1:
                            py -= weight * dv
                        if dim > 2:
                            pz -= weight * dw
                if density_law == RENORMALISED:
                    n = slope_norm * V
                    M = n * Mxx, n * Mxy, n * Mxz, n * Myy, n * Myz, n * Mzz
                    rate = real(renormalised(*M, Gxx, Gxy, Gxz, Gyy, Gyz, Gzz, dim))
                div_r = slope_norm * filled * V
                if crowded:
                    inside = inside_fluid(div_r, dim)
                if tensile != 0:
                    excess = real(tensile_excess(P, inside))
                    fx -= excess * nx
                    fy -= excess * ny
                    fz -= excess * nz
                acceleration[i, 0] = slope_norm * fx + gravity[0]
                if dim > 1:
                    acceleration[i, 1] = slope_norm * fy + gravity[1]
                if dim > 2:
                    acceleration[i, 2] = slope_norm * fz + gravity[2]
                density_rate[i] = value_norm * rate if density_law == SUMMATION else slope_norm * (rate + diffused)
                if spray != 0:
                    density_rate[i] += spray_rate(div_r, dim, rows[i, 2 * dim] - rho0, c0_over_h)
                if strained:
                    strain_rate[i, 0] = slope_norm * real(2.0) * Dxx
                    if dim > 1:
                        strain_rate[i, 1] = slope_norm * Dxy
                        strain_rate[i, dim] = slope_norm * real(2.0) * Dyy
                    if dim > 2:
                        strain_rate[i, 2] = slope_norm * Dxz
                        strain_rate[i, 4] = slope_norm * Dyz
                        strain_rate[i, 5] = slope_norm * real(2.0) * Dzz
                if sloped:
                    n = slope_norm
                    L = n * Lxx, n * Lxy, n * Lxz, n * Lyy, n * Lyz, n * Lzz
                    solved = renormalised_gradient(*L, n * sx, n * sy, n * sz, dim)
                    for d in range(dim):
                        density_gradient[i, d] = solved[d]
                if smoothing != 0 or shifting != 0:
                    toward = 0.0
                    if shifting != 0:  # grad C is taken with the density of the particle itself
                        crowding = slope_norm * V * np.sqrt(nx * nx + ny * ny + nz * nz)
                        if shifting == SUN:
                            speed = FASTEST / np.sqrt(inverse_c2)
                        else:
                            speed2 = u * u  # what a dimension less leaves unset in the scratch must not count
                            if dim > 1:
                                speed2 += v * v
                            if dim > 2:
                                speed2 += w * w
                            speed = np.sqrt(speed2)
                        toward = slope_norm * V * shift_factor(shift_h, speed, crowding, inside)
                    drift[i, 0] = epsilon * value_norm * px - toward * nx
                    if dim > 1:
                        drift[i, 1] = epsilon * value_norm * py - toward * ny
                    if dim > 2:
                        drift[i, 2] = epsilon * value_norm * pz - toward * nz

    return jit(sweep)


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
    alpha, delta, epsilon, shift : float
        Strength of viscosity, diffusion, smoothing and shifting [-].
    single : bool
        Whether pairs are computed in float32.
    h_over_dx, h_growth : float
        In 1D h may grow with the spacing: ``h_a = h_over_dx m_a/rho_a`` within h and h_growth h. A pair has the mean of two.
    gamma : float
        Exponent of the state [-]; 1 for the linear one.
    nu : float
        Kinematic viscosity [m^2/s] of newtonian viscosity, 0 without it.
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
    shift: float = 0.0
    single: bool = False
    h_over_dx: float = 2.0
    h_growth: float = 1.0
    gamma: float = 7.0
    nu: float = 0.0

    @property
    def compiled(self):
        """The compiled loop."""
        return compiled_sweep(self.dim, self.kernel.code, *self.terms.codes, self.single, self.h_growth > 1)

    @property
    def numbers(self):
        """The run-time numbers of the compiled loop."""
        norm = self.kernel.norms[self.dim - 1]
        hc = self.h * self.c0
        strengths = self.alpha * hc, self.delta * hc, self.epsilon, self.shift * self.h
        longest_h, mu = self.h * self.h_growth, self.rho0 * self.nu
        return self.h, norm, self.rho0, self.c0**-2, *strengths, self.h_over_dx, longest_h, self.gamma, mu

    def __call__(self, particles, starts, slab, first_column, last_column):
        """Set the rates of the fluid in the local columns ``first_column:last_column`` of `slab`."""
        self._sum(particles, starts, slab, first_column, last_column, [getattr(particles, name) for name in FOUND])

    def rates(self, particles, starts, slab):
        """Return acceleration [m/s^2], density rate [kg/m^3/s] and drift [m/s] of the fluid of `slab`, in arrays like those of
        `particles`, which stay as they are.
        """
        arrays = {name: np.zeros_like(getattr(particles, name)) for name in FOUND}
        self._sum(particles, starts, slab, 1, slab.columns + 1, arrays.values())
        return [arrays[name] for name in ("acceleration", "density_rate", "drift")]

    def over_slab(self, compiled, particles, starts, slab, found):
        """Run a compiled pass beside the sweep, with its kernel, over the fluid of all columns of `slab`; it fills `found`."""
        grid = slab.grid
        cells = grid.stride, (slab.columns + 1) * grid.stride
        numbers = self.h, self.kernel.norms[self.dim - 1]
        compiled(particles.shared, particles.tags, starts, *cells, (grid.cell, grid.shape), numbers, found)

    def _sum(self, particles, starts, slab, first_column, last_column, rates):
        stride, grid = slab.grid.stride, slab.grid
        self.compiled(
            particles.shared,
            particles.layout.carried,
            particles.correction,
            particles.tags,
            starts,
            first_column * stride,
            last_column * stride,
            (grid.cell, grid.shape),
            self.numbers,
            self.gravity,
            *rates,
        )
