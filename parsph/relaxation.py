"""Relaxation zones: the flow is relaxed towards a regular wave, which so is made and let go on; what else comes is taken up.

``dv/dt = ... - sigma(x) (v - v_t(x, z, t))``, and ``drho/dt = ... - f sigma(x) (rho - rho(p_t(x, z, t)))``, with velocity and
pressure of the wave at the particle's place. A difference from the target is damped as the whole flow is in an absorbing layer
(`parsph.damping`): still water is the wave of no height. Mayer, Garapon & Soerensen (1998), A fractional step method for
unsteady free-surface flow with applications to non-linear wave dynamics, Int. J. Numer. Meth. Fluids 28, 293-315, relax
velocity and level; f is that of matched layers, by which the difference in level decays as fast as the one in velocity, and
what leaves or comes with the density is mass.

Strength: ``sigma = rate (depth/length)^2``, which begins smoothly at the inner edge. At its closed wall a zone has to do with
a difference as large as the wave, which crosses it once: of linear waves of group speed c_g ``exp(-rate length / 3 c_g)`` is
left of it, and the square of that of a wave that comes to the zone. With velocity alone relaxed it is the root, and sigma is a
change of impedance that itself reflects: a strong zone makes the height asked for, a weak one reflects little. By the linear
equations of long waves such a zone of one wavelength does both to 5 % at its best strength; to 6 % with a cubic profile, 7 %
with a linear one or the exponential of power 3.5 of volume-of-fluid codes, 10 % with a tanh from 0 to 1. With the density the
profile does not matter.

The wall behind the zone is closed. So the target carries no water along: the mean transport of the wave (Stokes' drift) is
taken off its velocity, ``u_t = u - q/d``. Without that, the current that brings it back would pile up the water on its way.
Beside the wall, within the reach of the kernel, u_t falls to 0, so that no particle is driven into it.

The step is that of absorbing layers, implicit and of second order: stable for any sigma.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from .damping import POWER, decay, sigma_over_sigma0
from .jit import jit
from .particles import FIRST_GHOST
from .states import density_gap
from .wavemakers.signals import ramp

EXPONENT = 2  # of the profile
PHASES = 720  # at which means over a wave are taken


@jit
def orbital_velocity(turn, z, wavenumber, depth, scales):
    """Velocity u, w [m/s] of a wave at the phase ``turn = kx - omega t`` and `z` [m] above the bed, as `RegularWave.velocity`.

    ``u = sum_j S_j e^{jk(z-d)} (1 + e^{-2jkz}) cos j turn``, w the same with 1 - e and sin; ``S_j = U_j / (1 + e^{-2jkd})``.
    Powers of the first harmonic's functions stand for those of the others.
    """
    grow, fall, c, s = math.exp(wavenumber * (z - depth)), math.exp(-2.0 * wavenumber * z), math.cos(turn), math.sin(turn)
    grow_j, fall_j, c_j, s_j = 1.0, 1.0, 1.0, 0.0
    along, up = 0.0, 0.0
    for j in range(len(scales)):
        grow_j *= grow
        fall_j *= fall
        c_j, s_j = c_j * c - s_j * s, s_j * c + c_j * s
        along += scales[j] * grow_j * (1.0 + fall_j) * c_j
        up += scales[j] * grow_j * (1.0 - fall_j) * s_j
    return along, up


@jit
def dynamic_head(along, up, celerity, constant):
    """``p/rho - g(d - z) = c u - (u^2 + w^2)/2 + K`` [m^2/s^2] in a steady wave with u and w [m/s]: Bernoulli along with it."""
    return celerity * along - 0.5 * (along * along + up * up) + constant


@jit
def share_beside_wall(inside, length, margin):
    """What the closed wall at the end of a zone leaves of u_t so far `inside` [m]: it falls to 0 over the `margin` [m]."""
    off = length - inside
    return 1.0 if off >= margin else max(off, 0.0) / margin


@jit
def towards(value, target, left):
    """A value that has come nearer to its target: ``v_t + (v - v_t) left``."""
    return target + (value - target) * left


@lru_cache
def compiled_zone(dim, with_density, state_code):
    """Return the pass that relaxes the fluid rows of a zone, for these codes; numbers are run-time arguments."""

    def relax(rows, tags, first, last, edge, rate_dt, wave, now, water, state_numbers):
        start, direction, length, margin = edge
        wavenumber, depth, celerity, constant, drift, highest, scales = wave
        share, turned = now
        bed, level, weight, density, density_factor = water
        state = (state_code, *state_numbers)
        for i in range(first, last):
            inside = (rows[i, 0] - start) * direction
            if inside <= 0.0 or tags[i] >= FIRST_GHOST:
                continue
            s = rate_dt * sigma_over_sigma0(POWER, inside, length, 0.0, EXPONENT)
            left = decay(s)
            z = min(rows[i, dim - 1] - bed, highest)
            along, up = orbital_velocity(wavenumber * rows[i, 0] - turned, z, wavenumber, depth, scales)
            along, up = share * along, share * up
            driven = (along - share * share * drift) * share_beside_wall(inside, length, margin)
            rows[i, dim] = towards(rows[i, dim], driven, left)
            for d in range(1, dim - 1):
                rows[i, dim + d] = towards(rows[i, dim + d], 0.0, left)
            rows[i, 2 * dim - 1] = towards(rows[i, 2 * dim - 1], up, left)
            if with_density:
                head = dynamic_head(along, up, celerity, share * share * constant)
                pressure = weight * (level - rows[i, dim - 1]) + density * head
                change = 1.0 + density_gap(pressure, rows[i, 2 * dim], state) * (1.0 - decay(density_factor * s))
                rows[i, 2 * dim] *= change
                rows[i, 2 * dim + 2] *= change

    return jit(relax)


def transport(wave):
    """Return the mean transport q of a wave [m^2/s]: the mean over a period of the integral of u from the bed to the surface.

    ``integral of u dz = sum_j U_j/(jk) sinh(jk(d + eta))/cosh(jkd) cos j(kx - omega t)``.

    Parameters
    ----------
    wave : RegularWave
    """
    x, j = _over_a_wave(wave), np.arange(1, len(wave.velocities) + 1)
    jk, eta = j * wave.wavenumber, wave.elevation(x, 0.0)[:, None]
    rise = (np.exp(jk * eta) - np.exp(-jk * (2 * wave.depth + eta))) / (1 + np.exp(-2 * jk * wave.depth))
    return float((wave.velocities / jk * rise * np.cos(jk * x[:, None])).sum(-1).mean())


def bernoulli_constant(wave):
    """Return K [m^2/s^2] of `dynamic_head`, which is such that the pressure at the surface is 0, on average.

    Parameters
    ----------
    wave : RegularWave
    """
    x = _over_a_wave(wave)
    eta = wave.elevation(x, 0.0)
    along, up = wave.velocity(x, wave.depth + eta, 0.0).T
    return float(np.mean(wave.gravity * eta - wave.celerity * along + 0.5 * (along**2 + up**2)))


def _over_a_wave(wave):
    return wave.wavelength * np.arange(PHASES) / PHASES


@dataclass(frozen=True, eq=False)
class RelaxationZone:
    """A zone at one end of the basin in which the flow is relaxed towards a wave.

    Attributes
    ----------
    start : float
        x [m] of the inner edge.
    direction : int
        +1 when the zone extends to larger x, -1 to smaller.
    length : float
        [m]
    rate : float
        Strength at the outer end [1/s].
    state : tuple
        Constants of the equation of state.
    wave : RegularWave or None
        The target, to larger x and with a crest at x = 0 at t = 0, wherever the zone is; None: still water.
    ramp : float
        Duration of the smooth start [s]; before t = 0 the target is still water.
    level, bed : float
        Still-water level and bed [m].
    weight : float
        rho0 g [N/m^3].
    margin : float
        So near the outer end, where a closed wall stands, the horizontal velocity of the target falls to 0 [m].
    density_factor : float
        Strength of the relaxation of the density over that of the velocity; 0: none.
    """

    start: float
    direction: int
    length: float
    rate: float
    state: tuple
    wave: object = None
    ramp: float = 0.0
    level: float = 0.0
    bed: float = 0.0
    weight: float = 0.0
    margin: float = 0.0
    density_factor: float = 0.0

    weakens = False  # it leaves forces as they are

    @cached_property
    def _numbers(self):
        """What the compiled code knows of the wave and of the water."""
        wave = self.wave
        edge = self.start, float(self.direction), self.length, self.margin
        density = self.weight / wave.gravity if wave else 0.0
        water = self.bed, self.level, self.weight, density, self.density_factor
        if wave is None:
            return edge, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.zeros(0)), water
        j = np.arange(1, len(wave.velocities) + 1)
        scales = wave.velocities / (1 + np.exp(-2 * j * wave.wavenumber * wave.depth))
        crest = wave.depth + float(wave.elevation(0.0, 0.0))
        head = wave.celerity, bernoulli_constant(wave), transport(wave) / wave.depth
        return edge, (wave.wavenumber, wave.depth, *head, crest, scales), water

    def _now(self, time):
        """Return what the ramp leaves of the wave at `time` [s], and how far it has turned, omega t within a turn."""
        if self.wave is None or time <= 0:
            return 0.0, 0.0
        return float(ramp(time, self.ramp)[0]), math.fmod(self.wave.frequency * time, 2 * math.pi)

    def act(self, particles, first, last, time, dt):
        """Relax the fluid rows ``first:last``, which are at `time` [s], over the `dt` [s] before it."""
        edge, wave, water = self._numbers
        relax = compiled_zone(particles.layout.dim, self.density_factor > 0, self.state[0])
        p = particles
        relax(p.shared, p.tags, first, last, edge, self.rate * dt, wave, self._now(time), water, tuple(self.state[1:]))

    @cached_property
    def span(self):
        """The x-interval of the zone [m]."""
        end = self.start + self.direction * self.length
        return min(self.start, end), max(self.start, end)
