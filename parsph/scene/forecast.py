"""What a scene will need on many ranks: a model of time, messages, bytes and memory.

It counts what is in the columns of cells at the beginning, cuts them as a run does, and prices what the rank with the most
has to do. `parsph plan SCENE --ranks N` prints it, `parsph bench --scaling` and the tests hold it against measurements.
"""

import math
from dataclasses import dataclass
from functools import reduce

import numpy as np
from rich.table import Table

from ..domain import balanced_cuts, imbalance, most_ranks
from ..domain.cost import column_costs
from ..io.checkpoints import bytes_on_disk
from ..moments import Correction
from ..particles import Layout, room_for
from ..progress import console, duration, size_text
from ..stepping import INTEGRATORS
from ..walls.shares import Share
from .build import borders_of, columns_of, state_of, walls_of
from .lattice import Lattice
from .plan import SECONDS_PER_STEP, costs
from .solids import fillings_of, ghosts_of, motions_of

SECONDS_PER_MESSAGE = 1.0e-5  # of a core, both its ends: MPI's part was measured, 3e-6 to 5e-6; Python's is assumed as much
LATENCY = 2.0e-6  # s, of a cluster's fabric such as InfiniBand: assumed
BANDWIDTH = 5.0e9  # bytes/s between two ranks: assumed
BYTES_PER_PROCESS = 2.3e8  # interpreter, libraries, compiled code: measured
CORES = 64  # of a node: assumed
GOOD = 0.8  # efficiency down to which ranks are worth their cores
ASSUMPTIONS = (
    "the water is where it is at the beginning; cuts follow it as it moves",
    "every core is as fast as the one that was measured, also when all cores of its node work: no limit of memory bandwidth",
    f"a message takes {1e6 * SECONDS_PER_MESSAGE:g} microseconds of the core, {1e6 * LATENCY:g} microseconds on the way and "
    f"{1e-9 * BANDWIDTH:g} GB/s (of a cluster's fabric such as InfiniBand), none of it hidden behind the sweep",
    "agreeing on the time step takes 2 log2(ranks) such latencies; ranks are not disturbed by anything else",
    f"a node has {CORES} cores; beside its particles a rank has {1e-6 * BYTES_PER_PROCESS:g} MB of interpreter and libraries",
    "gauges, snapshots and balancing are left out",
)


@dataclass(frozen=True)
class Census:
    """What is in each column of cells at the beginning.

    Attributes
    ----------
    fluid, rows, ghosts : ndarray of int, shape (columns,)
        Fluid particles; all rows, with images and fixed ghosts; fixed ghosts.
    cost : ndarray, shape (columns,)
        See `parsph.domain.cost`.
    """

    fluid: np.ndarray
    rows: np.ndarray
    ghosts: np.ndarray
    cost: np.ndarray


def census(scene):
    """Return the `Census` of a scene."""
    grid, _ = columns_of(scene)
    motions = motions_of(scene)
    planes = [[] for _ in range(scene.dim)]  # of each axis, those that act at once: (origin, its image, way out, sense)
    for wall in walls_of(scene, motions):
        axis = int(np.flatnonzero(wall.normal)[0])
        plane = [(wall.point[axis], wall.point[axis], -wall.normal[axis], -1.0)]
        planes[axis] += [plane] * (plane not in planes[axis])  # a sill and the plate above it are in one plane
    for border in borders_of(scene):
        planes[border.axis].append([(border.low, border.high, -1.0, 1.0), (border.high, border.low, 1.0, 1.0)])
    fluid, rows = np.zeros(grid.shape, int), np.zeros(grid.shape, int)
    for filling in fillings_of(scene):
        for cells, walls in ((fluid, [[]] * scene.dim), (rows, planes)):
            cells += _cells_of(filling, grid, walls, scene.reach)
    lines, _ = ghosts_of(scene, state_of(scene), motions)
    ghosts, mirrors = np.zeros(grid.shape, int), ()
    if lines:
        share = Share(lines.position, lines.mirror, grid, (0, grid.columns), 0)
        ghosts, mirrors = _counted(lines.position[share.standing], grid), share.cells
    rows += ghosts
    halo = [(1, 1)] + [(0, 0)] * (scene.dim - 1)
    cost = column_costs(np.pad(fluid, halo), np.pad(rows, halo), mirrors)
    return Census(*(cells.reshape(grid.columns, -1).sum(axis=1) for cells in (fluid, rows, ghosts)), cost)


def _cells_of(filling, grid, planes, reach):
    """Return the number of particles of a filling in each cell, with their images at `planes`."""
    if isinstance(filling, Lattice):  # a product: one axis at a time
        counts = []
        for x, walls, low, cells in zip(filling.axes, planes, grid.low, grid.shape, strict=True):
            index = np.floor((_with_images(x[:, None], 0, walls, reach)[:, 0] - low) / grid.cell).astype(int)
            counts.append(np.bincount(np.clip(index, 0, cells - 1), minlength=cells))
        return reduce(np.multiply.outer, counts)
    cells = np.zeros(grid.shape, int)
    for _, _, points in filling.blocks():
        for axis, walls in enumerate(planes):
            points = _with_images(points, axis, walls, reach)
        cells += _counted(points, grid)
    return cells


def _with_images(points, axis, planes, reach):
    """Return `points` and behind them their images at planes across an axis."""
    for together in planes:
        images = []
        for origin, place, outwards, sense in together:
            near = points[(origin - points[:, axis]) * outwards < reach].copy()
            near[:, axis] = place + sense * (near[:, axis] - origin)
            images.append(near)
        points = np.concatenate([points, *images])
    return points


def _counted(points, grid):
    """Return the number of points in each cell."""
    index = np.floor((points - np.array(grid.low)) / grid.cell).astype(int)
    places = np.ravel_multi_index(tuple(index.T), grid.shape, mode="clip")
    return np.bincount(places, minlength=math.prod(grid.shape)).reshape(grid.shape)


@dataclass(frozen=True)
class Forecast:
    """What a scene needs on so many ranks; what differs between ranks is that of the rank with the most.

    Attributes
    ----------
    ranks : int
    columns : float
        Columns of a rank, mean.
    imbalance : float
        Largest over mean cost.
    computing, communicating : float
        [s] a step.
    messages, bytes : tuple of float
        A step, mean over ranks and largest.
    memory : float
        Arrays of particles [bytes].
    """

    ranks: int
    columns: float
    imbalance: float
    computing: float
    communicating: float
    messages: tuple
    bytes: tuple
    memory: float

    @property
    def step(self):
        """Time of a step [s]."""
        return self.computing + self.communicating


def forecast(scene, ranks, found=None, step=None):
    """Return the `Forecast` of a scene.

    Parameters
    ----------
    scene : Scene
    ranks : int
    found : Census, optional
        That of the scene, where it is known already.
    step : float, optional
        Measured time of a step on one rank [s]; without it that of `parsph plan`.

    Raises
    ------
    SceneError
        When there are too many ranks for the columns.
    """
    found = found or census(scene)
    grid, ends = columns_of(scene)
    cuts = balanced_cuts(found.cost, ranks, *ends)
    layout = Layout(scene.dim, scene.features)
    if step is None:
        total = costs(scene)
        step = total["core seconds"] / total["steps"]
    evaluations = INTEGRATORS[scene.numerics.integrator].evaluations
    messages, row_bytes = _halo(scene, layout)
    sent, told, memory = np.zeros(ranks), np.zeros(ranks), np.zeros(ranks)
    value_bytes = 8 * (scene.dim + 2)
    for rank in range(ranks):
        first, last = cuts[rank], cuts[rank + 1]
        rows, fluid = found.rows[first:last].sum(), found.fluid[first:last].sum()
        for edge, there in ((first, rank > 0), (last - 1, rank < ranks - 1)):
            if there:
                values = found.ghosts[edge]
                told[rank] += evaluations * (messages + (values > 0))
                sent[rank] += evaluations * (row_bytes * found.rows[edge] + value_bytes * values + 8 * grid.stride)
        if "x" in scene.periodic and ranks > 1 and rank in (0, ranks - 1):  # migrants round the ends, and copies there
            copies = found.rows[1 if rank == 0 else 0]  # as many as particles from the first end on, and as stand before it
            told[rank] += evaluations * 2
            sent[rank] += evaluations * 8 * copies * (layout.width("shared") + layout.width("private") + 1)
        ghosts = found.ghosts[first:last].sum()
        images = rows - fluid - ghosts
        halos = found.rows[first - 1] * (rank > 0) + (found.rows[last] if rank < ranks - 1 else 0)
        needed = rows + halos + ghosts + 2 * images  # new ones are made while the old ones are still there
        capacity = room_for(fluid) if needed <= room_for(fluid) else room_for(needed)
        memory[rank] = capacity * _bytes_of_row(scene, layout)
    share = imbalance(found.cost, cuts) / ranks
    waiting = told.max() * (SECONDS_PER_MESSAGE + LATENCY) + sent.max() / BANDWIDTH + 2 * math.ceil(math.log2(ranks)) * LATENCY
    return Forecast(
        ranks=ranks,
        columns=grid.columns / ranks,
        imbalance=share * ranks,
        computing=SECONDS_PER_STEP + max(step - SECONDS_PER_STEP, 0.0) * share,
        communicating=waiting,
        messages=(float(told.mean()), float(told.max())),
        bytes=(float(sent.mean()), float(sent.max())),
        memory=float(memory.max()),
    )


def _halo(scene, layout):
    """Return (messages to a neighbour, bytes of a row in its halo) of an evaluation, without values of ghosts."""
    family = scene.treatment.family
    messages, numbers = 3, layout.width("shared")  # migrants, counts, rows
    if scene.lines or family == "markers":  # who is who
        messages, numbers = messages + 1, numbers + 1
    if scene.treatment.corrects:  # accelerations, sums over markers
        messages, numbers = messages + 2, numbers + 2 * scene.dim + 1
    return messages, 8 * numbers


def _bytes_of_row(scene, layout):
    extra = Correction.width(scene.dim) * (scene.numerics.kernel_correction != "none")
    return layout.bytes_per_particle() + 8 * extra


def print_forecast(scene, ranks):
    """Print what a scene needs on up to so many ranks, and what of it is assumed."""
    out, found, total = console(), census(scene), costs(scene)
    grid, ends = columns_of(scene)
    most = most_ranks(grid.columns, *ends)
    last = min(ranks, most)
    rows = [forecast(scene, number, found) for number in [*(2**k for k in range(most.bit_length()) if 2**k < last), last]]
    alone = rows[0].step
    names = "ranks", "columns", "imbalance", "s/step", "speed-up", "efficiency", "messages", "sent", "memory", "a node's", "run"
    table = Table(*names, title="each rank, a step (messages, bytes, memory: of the rank with the most)", title_justify="left")
    for column in table.columns:
        column.justify = "right"
    for row in rows:
        speed_up = alone / row.step
        table.add_row(
            f"{row.ranks:,}",
            f"{row.columns:.1f}",
            f"{row.imbalance:.2f}",
            f"{row.step:.3g}",
            f"{speed_up:.1f}",
            f"{speed_up / row.ranks:.0%}",
            f"{row.messages[1]:g}",
            size_text(row.bytes[1]),
            size_text(row.memory + BYTES_PER_PROCESS),
            size_text(min(row.ranks, CORES) * (row.memory + BYTES_PER_PROCESS)),
            duration(row.step * total["steps"]),
        )
    out.print(table)
    good = [row.ranks for row in rows if alone / row.step / row.ranks >= GOOD]
    out.print(
        f"{grid.columns:,} columns of cells, {grid.cell:.3g} m wide; the ends keep the first {ends[0]} and the last {ends[1]} "
        f"on a rank each: at most {most:,} ranks. Of those above, up to {good[-1]:,} are used to {GOOD:.0%} or more."
    )
    out.print(
        "slabs are cut along x alone: a halo is as large on many ranks as on few, and the load is shared to within a column"
    )
    layout = Layout(scene.dim, scene.features)
    kept = size_text(total["particles"] * bytes_on_disk(layout))
    out.print(f"a checkpoint: {kept}; {total['snapshots']} snapshots: {size_text(total['disk'])}")
    out.print(_field_table(scene, layout))
    for assumption in ASSUMPTIONS:
        out.print(f"assumed: {assumption}")


def _field_table(scene, layout):
    """Return the table of what a particle takes in memory."""
    table = Table("field", "unit", "part", "bytes", title="memory of a particle", title_justify="left")
    state, told = state_of(scene), 0
    for field in layout.fields:
        size, part = 8 * layout.components(field), field.part
        if part in ("shared", "private"):  # a sort needs both
            size, part = 2 * size, f"{part}, twice"
        table.add_row(field.name, state.unit(field), part, str(size))
        told += size
    table.add_row("tag, cell, order, passes", "", "", str(_bytes_of_row(scene, layout) - told))
    table.add_row("all", "", "", str(_bytes_of_row(scene, layout)))
    return table
