"""The step on one page."""

import math
from contextlib import contextmanager
from copy import copy

import numpy as np

from .errors import RunError
from .particles import identities
from .schedule import rounded, shortened
from .states import update_pressure
from .stepping import time_step_limit
from .timing import Spread, Timers

BALANCE_EVERY = 20  # steps, in which nothing runs through more than a column


class Simulation:
    """A scene that runs.

    Parameters
    ----------
    domain : Domain
        The slab of this rank, with its particles.
    sweep : Sweep
    state : State
    integrator : Integrator
    zones : list of DampingZone or RelaxationZone
        What acts on the fluid at the ends of the basin.
    end : float
        When to stop [s].
    dt : float or None
        Constant time step [s]; None: as long as the limits allow.
    cfl : float
    density_range : tuple of float
        What the density may become, over rho0 [-].
    density_filter : DensityFilter, optional
    settling : float
        How long the fluid comes to rest before t = 0 [s].
    correction : Correction, optional
        The pass before the sweep, in scenes with a corrected kernel.
    """

    def __init__(
        self,
        domain,
        sweep,
        state,
        integrator,
        zones,
        end,
        dt,
        cfl,
        density_range,
        density_filter=None,
        settling=0.0,
        correction=None,
    ):
        self.domain, self.sweep, self.state = domain, sweep, state
        self.integrator, self.zones, self.end = integrator, zones, rounded(end)
        self._weakening = [zone for zone in zones if zone.weakens]
        self.fixed_dt, self.cfl = dt, cfl
        self.density_filter = density_filter
        self.settling, self.rest_time = settling, 10.0 * sweep.h / sweep.c0
        self.correction = correction
        self._staged = correction is not None or domain.ghosts is not None
        self.density_range = tuple(factor * state.rho0 for factor in density_range)
        self.communicator = domain.communicator
        self.observers, self.movers = [], []  # movers: what decides on the ways of walls, at the end of each step
        self.timers = Timers()
        self.time, self.steps, self.evaluations = 0.0, 0, 0
        self.imbalance, self.last_dt = Spread(1.0), 0.0  # largest over mean cost of the ranks, whenever the cuts were looked at
        self._extremes = 0.0, 0.0

    @property
    def particles(self):
        """The particles of this rank, at the present time."""
        return self.domain.particles

    # --- one evaluation: rates for the present positions, velocities and densities ---------------------------------

    def evaluate(self, time):
        """Set acceleration and density rate of all fluid particles; walls stand where they are at `time` [s]."""
        particles, domain, timers = self.particles, self.domain, self.timers
        columns = domain.slab.columns
        self._arrange(time)
        if self._staged:  # something of all neighbours must be known before the sweep
            self._finish_halo()
            self.prepare_sweep()
            with timers("sweep"):
                self.sweep(particles, domain.starts, domain.slab, 1, columns + 1)
        else:
            if self.communicator.size > 1:  # the inner columns are swept while the edges travel
                with timers("sweep"):
                    self.sweep(particles, domain.starts, domain.slab, 2, columns)
            self._finish_halo()
            edges = {(1, 2), (columns, columns + 1)} if self.communicator.size > 1 else {(1, columns + 1)}
            with timers("sweep"):
                for first, last in edges:
                    self.sweep(particles, domain.starts, domain.slab, first, last)
        if domain.markers:
            with timers("markers"):
                domain.push(time)
        particles.carry()
        for zone in self._weakening:
            with timers("damping"):
                zone.restrain(particles, *domain.rows_between(*zone.span))
        self.evaluations += 1

    def prepare_sweep(self):
        """Work out what the sweep needs to know of the arranged fluid: the coefficients of a corrected kernel."""
        if self.correction:
            with self.timers("correction"):
                self.correction(self.particles, self.domain.starts, self.domain.slab)

    def _arrange(self, time):
        """Bring pressures, order and images up to date, and begin to exchange the halos."""
        with self.timers("state"):
            self._update_pressure()
        with self.timers("arrange"):
            self.domain.arrange(time)
        if self.communicator.size > 1:
            with self.timers("halo"):
                self.domain.start_halo()

    def _finish_halo(self):
        """Wait for the halos, then give the fixed ghosts their values."""
        if self.communicator.size > 1:
            with self.timers("halo"):
                self.domain.finish_halo()
        if self.domain.ghosts:
            with self.timers("ghosts"):
                self.domain.fill_ghosts()

    def _update_pressure(self):
        p = self.particles
        bad = update_pressure(p.shared, p.tags, p.first, p.last, 2 * p.layout.dim, *self.density_range, self.state.constants)
        if bad >= 0:
            place = ", ".join(f"{x:.6g}" for x in p.field("position", slice(bad, bad + 1))[0])
            what, unit = ("depth", "m") if self.state.name == "shallow" else ("density", "kg/m^3")
            density = p.field("density", slice(bad, bad + 1))[0]
            raise RunError(
                f"particle {identities(p.tags[bad])} at ({place}) m: {what} {density:.6g} {unit} at t = {self.time:.6g} s",
                why="outside the range {:.6g} to {:.6g} {} (numerics.density_range)".format(*self.density_range, unit),
                cure="try a smaller time.cfl or time.dt, or more diffusion or viscosity",
            )

    # --- one step -------------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by `dt` [s]: fluid, then absorbing layers and relaxation zones on top of it, what polygon walls let nothing
        through, what crossed a border, and the walls that the flow moves.
        """
        with self.timers("step passes"):
            self._extremes = self.integrator.step(self.particles, self.evaluate, self.time, dt)
        for zone in self.zones:
            with self.timers("damping"):
                zone.act(self.particles, *self.domain.rows_between(*zone.span), self.time + dt, dt)
        if self.domain.barrier:
            with self.timers("barrier"):
                self.domain.stop_at_walls(self.time + dt)
        with self.timers("arrange"):
            self.domain.keep_inside(self.time + dt)
        for mover in self.movers if self.time >= 0 else ():  # while the water settles all walls stand still
            with self.timers("movers"):
                mover.advance(self, self.time + dt)
        self.steps, self.last_dt = self.steps + 1, dt

    def filter_densities(self):
        """Sum all densities anew; the rates belong to other rows and densities then, so they are worked out again."""
        self._arrange(self.time)
        self._finish_halo()
        with self.timers("density filter"):
            self.density_filter(self.particles, self.domain.starts, self.domain.slab)
        self.evaluate(self.time)

    def longest_step(self):
        """Return the longest stable step [s] of all ranks for what the fluid does now."""
        if self.fixed_dt is not None:
            return self.fixed_dt
        speed, pull = (math.sqrt(square) for square in self._extremes)
        gravity = math.hypot(*self.sweep.gravity)
        limit = time_step_limit(self.sweep.h, self.sweep.c0, gravity, self.cfl, speed, pull, self.sweep.nu)
        with self.timers("agreeing on dt"):
            return self.communicator.minimum(limit)

    def first_step(self):
        """Return the length of the first step [s] before anything moves, without asking the other ranks."""
        gravity = math.hypot(*self.sweep.gravity)
        return self.fixed_dt or time_step_limit(self.sweep.h, self.sweep.c0, gravity, self.cfl, nu=self.sweep.nu)

    # --- the run --------------------------------------------------------------------------------------------------

    def settle(self):
        """Let the fluid come to rest before the beginning: steps up to t = 0 in which its velocity decays."""
        p = self.particles
        velocity = p.layout.columns("velocity")[1]
        while self.time < 0:
            dt = min(self.longest_step(), -self.time)
            self.step(dt)
            p.shared[p.first : p.last, velocity] /= 1.0 + dt / self.rest_time
            self.time = 0.0 if dt == -self.time else self.time + dt
            if self.time < 0:
                self._observe(settling=True)
        p.shared[p.first : p.last, velocity] = 0.0

    def prepare(self):
        """Let the observers begin, settle where the scene says so, set the rates at the beginning, which the first prediction
        needs, and decide on what the flow moves. What comes from a checkpoint goes on where it was.
        """
        for observer in self.observers:
            observer.begin(self)
        if self.steps == 0:
            self.time = 0.0 - self.settling
            if self.communicator.size > 1:
                self.share_columns()
            self._begin()
        elif self.time >= 0:
            return
        if self.time < 0:
            self.settle()
            self._begin()
        for mover in self.movers:
            mover.advance(self, self.time)
        self._observe()

    def _begin(self):
        self.evaluate(self.time)
        self.integrator.begin(self.particles)

    def share_columns(self):
        """Balance before anything moves: what walls cost is known only once all particles are in their cells."""
        with self.timers("balance"):
            for _ in range(self.communicator.size):  # a cut moves at most to the next old one
                cuts = self.domain.cuts
                self.domain.arrange(self.time)
                self.domain.balance()
                if self.domain.cuts == cuts:
                    break

    def run(self):
        """Run from `prepare` to the end; the observers see every time at which they are due."""
        self.prepare()
        while self.time < self.end:
            self.advance()
        for observer in self.observers:
            observer.finish(self)

    def advance(self):
        """Make one step, shortened where output is due, then whatever is due beside the step."""
        due = min([self.end, *(observer.next for observer in self.observers)])
        dt, after = shortened(self.longest_step(), self.time, due)
        self.step(dt)
        self.time = after
        if self.density_filter and self.steps % self.density_filter.every == 0:
            self.filter_densities()
        self._observe()
        if self.communicator.size > 1 and self.steps % BALANCE_EVERY == 0:
            with self.timers("balance"):
                self.imbalance.add(self.domain.balance())

    def _observe(self, settling=False):
        for observer in self.observers:
            if (observer.settles or not settling) and observer.due(self.time):
                with self.timers(observer.phase):
                    observer.observe(self)

    # --- going on later -----------------------------------------------------------------------------------------------

    def memory(self):
        """Return what a run needs to know to go on, beside its particles: numbers, and lists of them; collective."""
        extremes = np.max(self.communicator.allgather(self._extremes), axis=0).tolist()
        clock = {"time": self.time, "steps": self.steps, "evaluations": self.evaluations, "last dt": self.last_dt}
        return {**clock, "extremes": extremes, "movers": [mover.memory for mover in self.movers]}

    def recall(self, memory):
        """Go on from what `memory` said."""
        self.time, self.steps, self.evaluations = memory["time"], memory["steps"], memory["evaluations"]
        self.last_dt, self._extremes = memory["last dt"], tuple(memory["extremes"])
        for mover, known in zip(self.movers, memory["movers"], strict=True):
            mover.memory = known

    # --- looking at it --------------------------------------------------------------------------------------------

    @contextmanager
    def present(self):
        """Give particles the order, images, halos and ghosts of the present time inside the ``with`` block; collective.

        They have moved since the last sort, which was that of an evaluation. Afterwards all is as it was, to the bit: the run
        does not notice.
        """
        correction = copy(self.correction)  # which counts
        try:
            with self.domain.preserved():
                self._arrange(self.time)
                self._finish_halo()
                yield
        finally:
            self.correction = correction

    def field(self, name):
        """Return a field of this rank's fluid, in the order of (cell, id): a copy, shape (n,) or (n, dim).

        Names are those of `parsph.particles.FIELDS`, "id" and "kind".
        """
        p = self.particles
        rows = p.fluid
        if name == "id":
            return identities(p.tags[rows])
        if name == "kind":
            return np.zeros(len(rows), np.int8)
        if name == "pressure":  # the stored one belongs to the last evaluation
            return self.state.pressure(p.field("density", rows))
        return p.field(name, rows)
