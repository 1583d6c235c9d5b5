"""The grid of cells, numbered x slowest, and the sort by (cell, tag) that everything else stands on.

Cells are as wide as the kernel's support. The grid is anchored at a point of the scene and has a margin of at least one
cell around everything that can hold a fluid particle, so no loop over neighbours needs to ask where the grid ends. Cells
of one x-column follow each other: a neighbourhood is a few contiguous strips, a slab or a halo one contiguous slice.
"""

import math
from dataclasses import dataclass

import numpy as np

from .jit import jit
from .particles import FIRST_GHOST

LEFT, RIGHT, DROPPED = -2, -3, -1
LAYERS = 8  # on a support radius, along the last axis
BLOCKS = 1, 32, 1  # cells, along the last axis, that share their candidates in 1, 2, 3 dimensions
FAR = 1.0e4  # support radii: where particles without mass fill a scratch up; its square is far from the largest float32


@dataclass(frozen=True)
class Grid:
    """A global grid of square (cubic) cells.

    Attributes
    ----------
    low : tuple of float
        Its lower corner [m].
    cell : float
        Edge of a cell [m].
    shape : tuple of int
        Number of cells in each direction.
    """

    low: tuple
    cell: float
    shape: tuple

    @classmethod
    def around(cls, low, high, cell):
        """Return the grid that holds the box ``low..high`` [m] and a margin of a cell on all sides."""
        shape = tuple(math.floor((b - a) / cell * (1 + 1e-12)) + 3 for a, b in zip(low, high, strict=True))
        return cls(tuple(float(a - cell) for a in low), float(cell), shape)

    @property
    def columns(self):
        """Number of x-columns."""
        return self.shape[0]

    @property
    def stride(self):
        """Number of cells in an x-column."""
        return math.prod(self.shape[1:])

    def column_of(self, x):
        """Return the column that holds the coordinate(s) `x` [m]."""
        return np.floor((np.asarray(x) - self.low[0]) / self.cell).astype(int)


@jit
def cell_of(rows, i, low, inverse, shape):
    """Return the global cell of row `i`; positions are the first columns of `rows`."""
    cell = 0
    for d in range(len(shape)):
        cell = cell * shape[d] + int((rows[i, d] - low[d]) * inverse)
    return cell


@jit
def assign_cells(
    rows,
    tags,
    cells,
    first,
    last,
    low,
    inverse,
    shape,
    box_low,
    box_high,
    first_cell,
    last_cell,
    round_below,
    round_above,
    near,
    close,
):
    """Put every fluid particle of ``first:last`` into its cell; drop ghosts; mark those that left the slab.

    Parameters
    ----------
    rows, tags, cells : ndarray
        `cells` is written: local cell, or LEFT, RIGHT, DROPPED.
    low, inverse, shape, box_low, box_high : tuples and float
        The grid, and the box that no particle may leave [m].
    first_cell, last_cell : int
        Global cells of the slab.
    round_below, round_above : int
        What left to global cells below the one, or from the other on, went through an end of a periodic x: that is to the left
        of the first slab, or to the right of the last one.
    near : ndarray of bool, one per cell of the slab
        Cells whose particles can have mirror images.
    close : ndarray of int32
        Written: the rows of particles in such cells.

    Returns
    -------
    tuple of int
        (first row outside the box or -1, number of particles that left, number of rows in `close`)
    """
    bad, left, count = -1, 0, 0
    for i in range(first, last):
        if tags[i] >= FIRST_GHOST:
            cells[i] = DROPPED
            continue
        for d in range(len(shape)):
            if not (box_low[d] <= rows[i, d] <= box_high[d]):  # NaN lands here too
                bad = i
        if bad >= 0:
            break
        cell = cell_of(rows, i, low, inverse, shape)
        if cell < first_cell:
            cells[i] = RIGHT if cell < round_below else LEFT
            left += 1
        elif cell >= last_cell:
            cells[i] = LEFT if cell >= round_above else RIGHT
            left += 1
        else:
            cells[i] = cell - first_cell
            if near[cell - first_cell]:
                close[count] = i
                count += 1
    return bad, left, count


@jit
def place_rows(rows, cells, first, last, low, inverse, shape, first_cell):
    """Put the rows ``first:last`` into their local cells, those of a slab that begins with the global cell `first_cell`."""
    for i in range(first, last):
        cells[i] = cell_of(rows, i, low, inverse, shape) - first_cell


@jit
def count_cells(cells, first, last, counts):
    """Count the particles of each cell of the slab into `counts`."""
    counts[:] = 0
    for i in range(first, last):
        if cells[i] >= 0:
            counts[cells[i]] += 1


@jit
def order_by_cell(cells, tags, first, last, counts, starts, order):
    """Set `order` to the rows sorted by (cell, tag).

    A stable counting sort keeps the order of tags that the last sort left; what moved between cells is mended by an
    insertion sort inside each cell.

    Parameters
    ----------
    counts : ndarray of int64
        Particles per cell.
    starts : ndarray of int64, one longer
        Written: where each cell begins in `order`.
    """
    starts[0] = 0
    for c in range(len(counts)):
        starts[c + 1] = starts[c] + counts[c]
        counts[c] = starts[c]
    for i in range(first, last):
        c = cells[i]
        if c >= 0:
            order[counts[c]] = i
            counts[c] += 1
    for c in range(len(counts)):
        for k in range(starts[c] + 1, starts[c + 1]):
            row = order[k]
            tag = tags[row]
            place = k
            while place > starts[c] and tags[order[place - 1]] > tag:
                order[place] = order[place - 1]
                place -= 1
            order[place] = row


@jit
def gather_rows(order, count, shared, private, tags, to_shared, to_private, to_tags, offset, shared_columns, private_columns):
    """Copy the rows named by ``order[:count]`` to the sorted arrays, from row `offset` on.

    The columns are tuples, whose lengths are known when this is compiled, so that rows are copied without loops.
    """
    for k in range(count):
        i = order[k]
        for column in range(len(shared_columns)):
            to_shared[offset + k, column] = shared[i, column]
        for column in range(len(private_columns)):
            to_private[offset + k, column] = private[i, column]
        to_tags[offset + k] = tags[i]


@jit
def collect_leavers(cells, first, last, direction, rows):
    """Write the rows marked `direction` to `rows` and return how many there are."""
    count = 0
    for i in range(first, last):
        if cells[i] == direction:
            rows[count] = i
            count += 1
    return count


@jit
def cells_per_column(shape):
    """Number of cells in an x-column of a grid of this shape."""
    stride = 1
    for d in range(1, len(shape)):
        stride *= shape[d]
    return stride


@jit
def strip_offset(strip, strips, stride, shape):
    """How many cells the middle of neighbouring strip `strip` lies behind the cell itself."""
    if strips == 1:
        return 0
    if strips == 3:
        return (strip - 1) * stride
    return (strip // 3 - 1) * stride + (strip % 3 - 1) * shape[-1]


@jit
def cells_of_block(cell, most, shape):
    """Return how many cells the block that begins with `cell` has, up to `most` along the last axis; 0 where none begins.

    Blocks lie within a column, so that they are the same on any number of ranks, and hold no cell of the grid's margin.
    """
    if len(shape) == 1:
        return 1
    if len(shape) == 3:
        row = cell // shape[-1] % shape[1]
        if row == 0 or row == shape[1] - 1:
            return 0
    place = cell % shape[-1] - 1
    return min(most, shape[-1] - 2 - place) if place >= 0 and place % most == 0 else 0


@jit
def candidates(starts, cell, cells, strips, stride, shape):
    """Number of particles in the strips around the block of `cells` that begins with `cell`."""
    count = 0
    for strip in range(strips):
        offset = strip_offset(strip, strips, stride, shape)
        count += starts[cell + offset + cells + 1] - starts[cell + offset - 1]
    return count


@jit
def fluid_box(rows, tags, begin, end, dim):
    """Return middle and half extent [m], three numbers each, of the box around the fluid among the rows ``begin:end``.

    Without any fluid there its extent is negative.
    """
    y, z = min(1, dim - 1), dim - 1
    cx = cy = cz = np.inf
    ex = ey = ez = -np.inf
    for i in range(begin, end):
        if tags[i] < FIRST_GHOST:
            cx, ex = min(cx, rows[i, 0]), max(ex, rows[i, 0])
            cy, ey = min(cy, rows[i, y]), max(ey, rows[i, y])
            cz, ez = min(cz, rows[i, z]), max(ez, rows[i, z])
    ex, ey, ez = 0.5 * (ex - cx), 0.5 * (ey - cy), 0.5 * (ez - cz)
    return (cx + ex, cy + ey, cz + ez), (ex, ey, ez)


@jit
def choose_candidates(rows, starts, cell, strips, stride, shape, middle, extent, reach2, chosen, first_own):
    """Write to `chosen` the rows around `cell` within reach of the box that `middle` and `extent` [m] describe.

    Returns
    -------
    tuple of int
        How many, and the place in `chosen` of the row `first_own`.
    """
    dim = len(shape)
    count, own = 0, 0
    for strip in range(strips):
        a = starts[cell + strip_offset(strip, strips, stride, shape) - 1]
        b = starts[cell + strip_offset(strip, strips, stride, shape) + 2]
        for j in range(a, b):
            if j == first_own:
                own = count
            beyond = max(abs(rows[j, 0] - middle[0]) - extent[0], 0.0)
            away = beyond * beyond
            if dim > 1:
                beyond = max(abs(rows[j, 1] - middle[1]) - extent[1], 0.0)
                away += beyond * beyond
            if dim > 2:
                beyond = max(abs(rows[j, 2] - middle[2]) - extent[2], 0.0)
                away += beyond * beyond
            chosen[count] = j  # the next one overwrites one that is out of reach
            count += away <= reach2
    return count, own


@jit
def layer_of(height, lowest, reach, most):
    """Return in which layer `height` [m] lies, 0 from `lowest` [m] on, up to `most`; a support radius `reach` has `LAYERS`."""
    return min(max(int((height - lowest) * (LAYERS / reach)), 0), most)


@jit
def ends_of_layers(block):
    """Return room for the ends of all layers around a block of up to so many cells, whose neighbours reach a cell further."""
    return np.empty((block + 2) * LAYERS + 4, np.int64)


@jit
def order_by_layer(rows, starts, cell, cells, strips, stride, shape, lowest, reach, chosen, places, ends):
    """Write to `chosen` the rows around the block of `cells` from `cell` on, to `places` where each stands if ordered by layer.

    Layers lie across the last axis, and begin at `lowest` [m]; each ends in that order where `ends` says for the next one.

    Returns
    -------
    tuple of int
        How many, and the place in `chosen` of the first row of `cell`.
    """
    count, own = 0, 0
    ends[:] = 0
    for strip in range(strips):
        a = starts[cell + strip_offset(strip, strips, stride, shape) - 1]
        b = starts[cell + strip_offset(strip, strips, stride, shape) + cells + 1]
        if strip == strips // 2:
            own = count + starts[cell] - a
        for j in range(a, b):
            layer = layer_of(rows[j, len(shape) - 1], lowest, reach, len(ends) - 3)
            chosen[count], places[count] = j, layer
            ends[layer + 2] += 1
            count += 1
    for layer in range(2, len(ends)):
        ends[layer] += ends[layer - 1]
    following = ends[1:]
    for k in range(count):
        layer = places[k]
        places[k] = following[layer]
        following[layer] += 1
    return count, own


@jit
def within_reach(height, lowest, reach, ends):
    """Return between which places of the order by layer all is that may be within `reach` [m] of `height` [m]."""
    most = len(ends) - 3
    return ends[layer_of(height - reach, lowest, reach, most)], ends[layer_of(height + reach, lowest, reach, most) + 1]


@jit
def most_candidates(starts, first_cell, last_cell, most_cells, strips, stride, shape):
    """Return the largest number of candidates of any block of up to so many cells."""
    most = 0
    for cell in range(first_cell, last_cell):
        cells = cells_of_block(cell, most_cells, shape)
        if starts[cell] < starts[cell + cells]:
            most = max(most, candidates(starts, cell, cells, strips, stride, shape))
    return most
