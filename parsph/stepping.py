"""Integrators and the limits of the time step.

An integrator is a few passes over the particles around calls of `evaluate`, which sets acceleration and density rate for
the present positions, velocities and densities. Passes hold the formulas; they touch fluid particles only.
"""

import math

from .jit import jit
from .particles import FIRST_GHOST

NOTHING, POSITION, RATES = range(3)  # what integrators keep beside velocity and density at the beginning of the step
BEYOND = 0.5  # how far rates are continued beyond the last ones, over their change in the step before


@jit
def predict(rows, start, tags, acceleration, density_rate, drift, first, last, axes, summed, dt, keeps):
    """Remember the beginning of the step in `start` and move on by `dt` with the rates at hand.

    An integrator that `keeps` the rates continues them by `BEYOND`.
    """
    smooth, dim = len(drift) > 0, len(axes)
    for i in range(first, last):
        if tags[i] >= FIRST_GHOST:
            continue
        for d in range(dim):
            v = rows[i, dim + d]
            start[i, d] = v
            if keeps == POSITION:
                start[i, dim + 1 + d] = rows[i, d]
            rows[i, d] += dt * (v + drift[i, d] if smooth else v)
            a = acceleration[i, d]
            if keeps == RATES:
                a += BEYOND * (a - start[i, dim + 1 + d])
                start[i, dim + 1 + d] = acceleration[i, d]
            rows[i, dim + d] = v + dt * a
        density = rows[i, 2 * dim]
        start[i, dim] = density
        if summed:
            continue
        rate = density_rate[i]
        if keeps == RATES:
            rate += BEYOND * (rate - start[i, 2 * dim + 1])
            start[i, 2 * dim + 1] = density_rate[i]
        rows[i, 2 * dim] = density + dt * rate


@jit
def verlet_correct(rows, start, tags, acceleration, density_rate, drift, first, last, axes, summed, dt):
    """Finish a drift-kick-drift step: full kick, second half of the drift with the new velocity.

    Returns
    -------
    tuple of float
        Largest squared speed [m^2/s^2] and largest squared acceleration [m^2/s^4].
    """
    smooth, dim = len(drift) > 0, len(axes)
    fastest, hardest = 0.0, 0.0
    for i in range(first, last):
        if tags[i] >= FIRST_GHOST:
            continue
        speed, pull = 0.0, 0.0
        for d in range(dim):
            a = acceleration[i, d]
            v = start[i, d] + dt * a
            rows[i, dim + d] = v
            rows[i, d] += 0.5 * dt * (v + drift[i, d] if smooth else v)
            speed += v * v
            pull += a * a
        rows[i, 2 * dim] = density_rate[i] if summed else start[i, dim] + dt * density_rate[i]
        fastest, hardest = max(fastest, speed), max(hardest, pull)
    return fastest, hardest


@jit
def midpoint_correct(rows, start, tags, acceleration, density_rate, drift, first, last, axes, summed, dt):
    """Finish a midpoint step: the whole step with the rates of its middle. Returns as `verlet_correct`."""
    smooth, dim = len(drift) > 0, len(axes)
    fastest, hardest = 0.0, 0.0
    for i in range(first, last):
        if tags[i] >= FIRST_GHOST:
            continue
        speed, pull = 0.0, 0.0
        for d in range(dim):
            a = acceleration[i, d]
            middle = rows[i, dim + d]
            v = start[i, d] + dt * a
            rows[i, d] = start[i, dim + 1 + d] + dt * (middle + drift[i, d] if smooth else middle)
            rows[i, dim + d] = v
            speed += v * v
            pull += a * a
        rows[i, 2 * dim] = density_rate[i] if summed else start[i, dim] + dt * density_rate[i]
        fastest, hardest = max(fastest, speed), max(hardest, pull)
    return fastest, hardest


class Integrator:
    """What integrators share.

    Attributes
    ----------
    keeps : int
        What it keeps beside velocity and density at the beginning of the step: `NOTHING`, `POSITION` or `RATES`.
    """

    keeps = NOTHING

    def begin(self, particles):
        """Take note of the rates of `particles` at the beginning of the run: most integrators have no need of them."""


class Verlet(Integrator):
    """Position-Verlet (drift-kick-drift), one evaluation per step.

    ``x(n+1/2) = x(n) + dt/2 v(n)``; rates at n+1/2 with velocity and density extrapolated to n+1/2 by the rates of the
    step before; ``v(n+1) = v(n) + dt a``, ``rho(n+1) = rho(n) + dt drho/dt``, ``x(n+1) = x(n+1/2) + dt/2 v(n+1)``
    (Monaghan 2005, eqs. (5.39)-(5.41), with the density advanced by the same pattern).
    """

    name = "verlet"
    evaluations = 1
    cfl = 0.4
    largest_cfl = 0.5
    equation = "x += dt/2 v;  v += dt a;  rho += dt drho/dt;  x += dt/2 v   [Monaghan (2005) eqs. (5.39)-(5.41)]"

    def step(self, particles, evaluate, time, dt):
        """Advance `particles` by `dt`; return the largest squared speed and acceleration."""
        _predict(particles, 0.5 * dt, self.keeps)
        evaluate(time + 0.5 * dt)
        return _correct(verlet_correct, particles, dt)


class AdamsBashforth(Verlet):
    """Position-Verlet whose velocities and densities of the middle follow the rates of the two steps before, one evaluation.

    ``v* = v(n) + dt/2 [a(n-1/2) + (a(n-1/2) - a(n-3/2))/2]``, the density alike, and the rest as `Verlet`. For constant steps
    that is the Adams-Bashforth extrapolation ``v* = 7/4 v(n) - v(n-1) + 1/4 v(n-2)``, the family of Shchepetkin & McWilliams
    (2005) with beta = 1/4. It is of second order for any sequence of steps. A sound wave of ``w dt = 0.3`` loses a thousandth
    a step (that of `Verlet`, beta = 0, grows by 2.4), and up to ``w dt = 0.76`` none grows, so that no density diffusion has
    to hold it. Against diffusion and viscosity it bears two thirds of what `Verlet` does.
    """

    name = "adams-bashforth"
    keeps = RATES
    equation = (
        "v* = v + dt/2 (3/2 a - 1/2 a'), rho alike; x += dt/2 v;  v += dt a(v*);  rho += dt drho/dt;  x += dt/2 v   "
        "[Shchepetkin & McWilliams (2005), beta = 1/4; Durran (1991)]"
    )

    def begin(self, particles):
        """Let the rates of the step before the first one be those of the beginning."""
        p, owned = particles, slice(particles.first, particles.last)
        for name, rates in (("last_acceleration", p.acceleration), ("last_density_rate", p.density_rate[:, None])):
            p.private[owned, p.layout.columns(name)[1]] = rates[owned]


class Midpoint(Integrator):
    """Midpoint predictor-corrector, two evaluations per step: ``y(n+1) = y(n) + dt f(y(n) + dt/2 f(y(n)))``.

    Szmidt (2013) eqs. (38), (39).
    """

    name = "midpoint"
    keeps = POSITION
    evaluations = 2
    cfl = 0.5
    largest_cfl = 0.8
    equation = "y* = y + dt/2 f(y);  y += dt f(y*)   [Szmidt (2013) eqs. (38), (39)]"

    def step(self, particles, evaluate, time, dt):
        """Advance `particles` by `dt`; return the largest squared speed and acceleration."""
        evaluate(time)
        _predict(particles, 0.5 * dt, self.keeps)
        evaluate(time + 0.5 * dt)
        return _correct(midpoint_correct, particles, dt)


INTEGRATORS = {integrator.name: integrator for integrator in (Verlet, AdamsBashforth, Midpoint)}


def _predict(p, dt, keeps):
    predict(*_arrays(p), dt, keeps)


def _correct(compiled, p, dt):
    return compiled(*_arrays(p), dt)


def _arrays(p):
    """Return the arguments that all passes share."""
    return p.shared, p.private, p.tags, p.acceleration, p.density_rate, p.drift, p.first, p.last, p.layout.axes, p.summed


VISCOUS_LIMIT = 0.125


def time_step_limit(h, c0, gravity, cfl, speed=0.0, acceleration=0.0, nu=0.0):
    """Return the longest step [s]: ``min(CFL h / (c0 + |v|), CFL sqrt(h / max(|a|, g)), 0.125 h^2/nu)``.

    The last is that of viscosity (Morris et al. 1997, eq. (31)).

    Parameters
    ----------
    h, c0, gravity : float
        Smoothing length [m], sound speed [m/s], gravity [m/s^2].
    cfl : float
    speed, acceleration : float
        Largest of the fluid [m/s], [m/s^2].
    nu : float
        Kinematic viscosity [m^2/s].
    """
    pull = max(acceleration, gravity)
    force = math.sqrt(h / pull) if pull > 0 else math.inf
    viscous = VISCOUS_LIMIT * h * h / nu if nu > 0 else math.inf
    return min(cfl * min(h / (c0 + speed), force), viscous)
