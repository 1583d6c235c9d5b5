"""What the particles of one rank go through before a sweep: cells, migration, images, sort, halo."""

from contextlib import contextmanager
from copy import copy
from functools import reduce

import numpy as np

from ..columns import (
    LEFT,
    RIGHT,
    assign_cells,
    collect_leavers,
    count_cells,
    gather_rows,
    order_by_cell,
    place_rows,
)
from ..errors import RunError
from ..particles import FIRST_GHOST, identities
from ..walls import translated_images, wall_images
from .cost import column_costs
from .exchange import Exchange
from .slabs import Slab, balanced_cuts, imbalance

TURNS = 4  # of the walls at particles in a corner


class Domain:
    """The slab of one rank: its particles in columns, with the halos of its neighbours.

    Parameters
    ----------
    grid : Grid
    particles : Particles
    walls : list of MirrorWall
    reach : float
        Distance up to which walls mirror [m], the support radius.
    box : tuple of (low, high)
        What no particle may leave [m].
    gravity : tuple of float
        [m/s^2]
    state : State
    wetted : float
        Largest height above a moving wall's hinge that can be wet [m].
    communicator : Communicator
    cuts : sequence of int
        Column cuts between the ranks.
    ghosts, barrier, markers : FixedGhosts, Barrier, Markers, optional
        Of walls that are lines.
    exchanging : bool
        Whether fluid behind a mirror wall changes places with its images; else it is lost.
    borders : sequence of PeriodicBorder
        Of the axes along which everything repeats, that of x first.
    """

    def __init__(
        self,
        grid,
        particles,
        walls,
        reach,
        box,
        gravity,
        state,
        wetted,
        communicator,
        cuts,
        ghosts=None,
        barrier=None,
        markers=None,
        exchanging=False,
        borders=(),
    ):
        self.grid, self.particles, self.walls = grid, particles, walls
        self.ghosts, self.barrier, self.markers = ghosts, barrier, markers
        self.exchanging, self.borders = exchanging, borders
        self.reach, self.box, self.gravity, self.state = reach, box, gravity, state
        self.communicator = communicator
        self.exchange = Exchange(communicator, particles, ring=any(border.axis == 0 for border in borders))
        self._bands = [wall.band(reach, wetted) for wall in walls]
        for border in borders:
            self._bands += border.bands(reach, len(grid.shape))
        self._close = np.zeros(64, np.int32)
        self.starts, self.time = None, 0.0
        self.set_cuts(cuts)

    def set_cuts(self, cuts):
        """Own other columns from the next `arrange` on."""
        self.cuts = tuple(cuts)
        rank = self.communicator.rank
        self.slab = Slab(self.grid, self.cuts[rank], self.cuts[rank + 1])
        ring, stride = self.exchange.across is not None, self.grid.stride
        self._round_below = self.cuts[1] * stride if ring and rank else 0
        self._round_above = (self.grid.columns if not ring or rank else self.cuts[-2]) * stride
        self._counts = np.zeros(self.slab.cells, np.int64)
        self._near = self._cells_near_walls()
        self._between = {}
        if self.ghosts:
            self.ghosts.distribute(self.grid, self.cuts, rank)
        if self.barrier:
            self.barrier.distribute(self.grid, self.slab)
        if self.markers:
            self.markers.distribute(self.grid, self.cuts, rank)

    def _cells_near_walls(self):
        slab, grid = self.slab, self.grid
        near = np.zeros((slab.columns, *grid.shape[1:]), bool)
        for low, high in self._bands:
            index = []
            for d, (a, b) in enumerate(zip(low, high, strict=True)):
                edges = grid.low[d] + grid.cell * np.arange(grid.shape[d] + 1)
                if d == 0:
                    edges = edges[slab.first : slab.last + 1]
                index.append((edges[1:] >= a) & (edges[:-1] <= b))
            near |= reduce(np.logical_and.outer, index)
        return near.ravel()

    def arrange(self, time):
        """Bring all particles into the order of (cell, tag), each on its rank, with their images at `time` [s]."""
        self.time = time
        self.keep_inside(time)
        left = self._assign()
        if self.communicator.size > 1:
            self._migrate(left)
        self._mirror(time)
        if self.ghosts:
            self._stand(time)
        self._sort()

    def keep_inside(self, time):
        """Bring what crossed a periodic border or, with exchange, a mirror wall at `time` [s] back into the domain.

        In a corner that leans, the image at one wall may be behind another: so walls take turns until there are none.
        """
        for _ in range(TURNS if self.exchanging else 0):
            exchanged = 0
            for wall in self.walls:
                wall.move(time)
                exchanged += wall.exchange(self.particles, self.reach)
            if not exchanged:
                break
        for border in self.borders:
            border.come_in(self.particles)

    @contextmanager
    def preserved(self):
        """Whatever is arranged, exchanged and filled inside the ``with`` block, all is as before after it."""
        starts, time, walls = self.starts, self.time, [(copy(wall.numbers), wall.exchanged) for wall in self.walls]
        ghosts = {} if self.ghosts is None else {name: copy(value) for name, value in vars(self.ghosts).items()}
        try:
            with self.particles.preserved():
                yield
        finally:
            self.starts, self.time = starts, time
            for wall, (numbers, exchanged) in zip(self.walls, walls, strict=True):
                wall.numbers[:], wall.exchanged = numbers, exchanged
            if self.ghosts:
                vars(self.ghosts).update(ghosts)

    def _assign(self):
        p, slab, grid = self.particles, self.slab, self.grid
        if len(self._close) < len(p.tags):
            self._close = np.zeros(len(p.tags), np.int32)
        bad, left, self._close_count = assign_cells(
            p.shared,
            p.tags,
            p.cells,
            p.first,
            p.last,
            grid.low,
            1.0 / grid.cell,
            grid.shape,
            *self.box,
            slab.first * grid.stride,
            slab.last * grid.stride,
            self._round_below,
            self._round_above,
            self._near,
            self._close,
        )
        if bad >= 0:
            self._lost(bad, self._way_out(bad))
        return left

    def _way_out(self, row):
        """Return how the particle of `row` left the domain: through which wall, or where there is none."""
        p = self.particles
        position = p.field("position", slice(row, row + 1))[0]
        crossed = [wall.name for wall in self.walls if wall.motion is None and wall.distance(position) < 0]
        return f"crossed the {crossed[0]} wall" if crossed else "left the domain"

    def _lost(self, row, how):
        p = self.particles
        position = p.field("position", slice(row, row + 1))[0]
        velocity = p.field("velocity", slice(row, row + 1))[0]
        place = ", ".join(f"{x:.6g}" for x in position)
        speed = ", ".join(f"{v:.4g}" for v in velocity)
        raise RunError(
            f"particle {identities(p.tags[row])} {how} at t = {self.time:.6g} s: position ({place}) m, velocity ({speed}) m/s",
            why="the time step may be too long for the scene, or the domain too small for the flow",
            cure="try a smaller time.cfl, or a larger domain",
        )

    def _migrate(self, left):
        p = self.particles
        leavers = []
        for direction in (LEFT, RIGHT):
            rows = np.empty(left, np.int32)
            leavers.append(rows[: collect_leavers(p.cells, p.first, p.last, direction, rows)] if left else rows)
        last = p.last
        self.exchange.migrate(*leavers)
        place_rows(p.shared, p.cells, last, p.last, *self._place())
        cells = p.cells[last : p.last]
        lost = np.flatnonzero((cells < 0) | (cells >= self.slab.cells))
        if len(lost):
            self._lost(last + lost[0], "crossed a whole slab in one step")
        if len(self._close) < len(p.tags):
            self._close = np.resize(self._close, len(p.tags))
        near = last + np.flatnonzero(self._near[cells])
        self._close[self._close_count : self._close_count + len(near)] = near
        self._close_count += len(near)

    def _place(self):
        """Return where the slab is, as compiled code knows it: (low, 1/cell, shape of the grid, first cell of the slab)."""
        return self.grid.low, 1.0 / self.grid.cell, self.grid.shape, self.slab.first * self.grid.stride

    def _mirror(self, time):
        p = self.particles
        first_ghost, place = p.last, self._place()
        for wall in self.walls:
            wall.move(time)
            p.reserve(p.last + self._close_count + p.last - first_ghost)
            p.last, bad = wall_images(
                p.shared,
                p.tags,
                p.cells,
                self._close,
                self._close_count,
                first_ghost,
                p.last,
                p.layout.dim,
                wall.numbers,
                *wall.codes,
                self.gravity,
                self.state.constants,
                place,
                self.reach,
                p.layout.carried,
            )
            if bad >= 0:
                self._lost(bad, f"crossed the {wall.name} wall")
        for border in self.borders:
            p.reserve(p.last + self._close_count + p.last - first_ghost)
            ends, first = (border.axis, border.low, border.high, border.bits), p.last
            p.last = translated_images(
                p.shared, p.tags, p.cells, self._close, self._close_count, first_ghost, first, *ends, place, self.reach
            )
            if border.axis == 0 and self.communicator.size > 1:  # they stand at the other end
                self.exchange.trade_copies(first)
                place_rows(p.shared, p.cells, first, p.last, *place)

    def _stand(self, time):
        if self.ghosts.moving:
            self.ghosts.move(time)
            self.ghosts.distribute(self.grid, self.cuts, self.communicator.rank)
        self.ghosts.append(self.particles, self.grid, self.slab)

    def _sort(self):
        p, slab, stride = self.particles, self.slab, self.grid.stride
        count_cells(p.cells, p.first, p.last, self._counts)
        before, after = self.exchange.edge_counts(self._counts, stride)
        owned = int(self._counts.sum())
        first = int(before.sum())
        p.reserve(first + owned + int(after.sum()))
        starts = np.empty((slab.columns + 2) * stride + 1, np.int64)
        order_by_cell(p.cells, p.tags, p.first, p.last, self._counts, starts[stride:-stride], p.order)
        starts[stride:-stride] += first
        starts[0] = 0
        np.cumsum(before[:-1], out=starts[1:stride])
        np.cumsum(after, out=starts[-stride:])
        starts[-stride:] += first + owned
        columns = (tuple(range(rows.shape[1])) for rows in (p.shared, p.private))
        gather_rows(p.order, owned, p.shared, p.private, p.tags, *p.spare, first, *columns)
        p.swap(first, first + owned)
        p.tags[:first] = FIRST_GHOST  # halos are nobody's targets
        p.tags[first + owned : starts[-1]] = FIRST_GHOST
        self.starts = starts

    def start_halo(self):
        """Begin to exchange the edge columns with the neighbours; see `finish_halo`."""
        p = self.particles
        self.exchange.start_halo(self.starts, self.grid.stride, p.shared)
        if self.ghosts or self.markers:  # who is who in the halos: fluid to measure, ghosts to give values to
            self.exchange.start_halo(self.starts, self.grid.stride, p.tags)

    def finish_halo(self):
        """Wait until the halos are there."""
        self.exchange.finish_halo()

    def fill_ghosts(self):
        """Give the fixed ghosts of the slab and its halos their values; the halos must be there."""
        ghosts = self.ghosts
        ghosts.interpolate(self.particles, self.starts, self.grid)
        ghosts.complete(self.particles, self.starts, self.communicator)
        self.exchange.swap_values(ghosts.values, ghosts.share.sent, ghosts.share.received)
        ghosts.give(self.particles, self.starts)

    def push(self, time):
        """Let the markers of walls, where they stand at `time` [s], act on the accelerations that the sweep has set."""
        markers = self.markers
        if markers.moving:
            markers.move(time)
            markers.distribute(self.grid, self.cuts, self.communicator.rank)
        if markers.weights:
            markers.survey(self.particles, self.starts)
            if self.communicator.size > 1:
                self.exchange_edges(self.particles.acceleration)
                self.exchange_edges(markers.sums)
            markers.measure(self.particles, self.starts)
            self.exchange.swap_values(markers.strength, markers.share.sent, markers.share.received)
        markers.act(self.particles, self.starts)

    def stop_at_walls(self, time):
        """Take the velocity into polygon walls from the fluid that touches them at `time` [s]."""
        self.barrier.hold(self.particles, self.starts, time)

    def exchange_edges(self, array):
        """Exchange the edge columns of an array, one row per particle, with the neighbours."""
        self.exchange.start_halo(self.starts, self.grid.stride, array)
        self.exchange.finish_halo()

    def column_bounds(self):
        """Return the row at which each owned column begins, and the end of the last, shape (columns + 1,)."""
        stride = self.grid.stride
        return self.starts[stride : len(self.starts) - stride : stride]

    def rows_between(self, low, high):
        """Return (first, last) row of the owned columns that touch the x-interval ``low..high`` [m], widened by a
        column on both sides, since a particle may have moved a little after the sort.
        """
        if (low, high) not in self._between:  # layers ask every step
            self._between[low, high] = self._cells_between(low, high)
        a, b = self._between[low, high]
        return int(self.starts[a]), int(self.starts[b])

    def fluid_between(self, low, high):
        """Return the rows of the fluid that may be in the x-interval ``low..high`` [m], or a period away from it where x is
        periodic: there is what came in at an end after the sort, and what has copies in the interval.
        """
        periods = [border.period for border in self.borders if border.axis == 0]
        ways = [0.0, *(way for period in periods for way in (-period, period))]
        rows = [np.arange(*self.rows_between(low + way, high + way)) for way in ways]
        rows = np.unique(np.concatenate(rows)) if periods else rows[0]
        return rows[self.particles.tags[rows] < FIRST_GHOST]

    def _cells_between(self, low, high):
        slab, stride = self.slab, self.grid.stride
        a, b = (min(max((x - self.grid.low[0]) / self.grid.cell, 0.0), self.grid.columns) for x in (low, high))
        a = min(max(int(a) - 1, slab.first), slab.last) - slab.first + 1
        b = min(max(int(b) + 2, slab.first), slab.last) - slab.first + 1
        return a * stride, b * stride

    def end_columns(self):
        """Return how many columns at the left and at the right one rank must own together: those that the images of
        end walls and periodic ends, and their originals, lie in.
        """
        return end_columns(self.grid, self._bands)

    def column_costs(self):
        """Return the cost of a step in each column of the whole grid [pairs], on all ranks; see `parsph.domain.cost`."""
        counted = np.concatenate([[0], np.cumsum(self.particles.tags[: self.starts[-1]] < FIRST_GHOST)])
        shape = self.slab.columns + 2, *self.grid.shape[1:]
        fluid, rows = (np.diff(ends).reshape(shape) for ends in (counted[self.starts], self.starts))
        mine = column_costs(fluid, rows, self.ghosts.share.cells if self.ghosts else ())
        return np.concatenate(self.communicator.allgather(mine))

    def balance(self, tolerance=1.05):
        """Move the cuts if the ranks' shares of the cost differ; the particles follow in the next `arrange`.

        Returns
        -------
        float
            Largest share over mean share, before.
        """
        costs = self.column_costs()
        before = imbalance(costs, self.cuts)
        if before > tolerance:
            cuts = balanced_cuts(costs, self.communicator.size, *self.end_columns(), old=self.cuts)
            if imbalance(costs, cuts) < before:  # columns may be too coarse for anything better
                self.set_cuts(cuts)
        return before


def end_columns(grid, bands):
    """Return how many columns the outermost ranks must own for walls and periodic ends across x, from their bands."""
    left, right = 1, 1
    middle = grid.low[0] + 0.5 * grid.cell * grid.columns
    for low, high in bands:
        if np.isfinite(low[0]):
            if 0.5 * (low[0] + high[0]) < middle:
                left = max(left, int(grid.column_of(high[0])) + 1)
            else:
                right = max(right, grid.columns - int(grid.column_of(low[0])))
    return left, right
