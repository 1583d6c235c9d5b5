"""The grid of cells and the sort by (cell, tag)."""

import numpy as np
import pytest
from helpers import domain_of

from parsph.columns import (
    LAYERS,
    Grid,
    candidates,
    cell_of,
    cells_of_block,
    cells_per_column,
    ends_of_layers,
    order_by_cell,
    order_by_layer,
    within_reach,
)
from parsph.errors import RunError
from parsph.particles import FIRST_GHOST

DIMS = (1, 2, 3)


def cells_of(grid, position):
    """Cells by numpy, x slowest."""
    index = np.floor((position - grid.low) / grid.cell).astype(int)
    return np.ravel_multi_index(index.T, grid.shape)


def random_case(dim, seed, count=300):
    rng = np.random.default_rng(seed)
    grid = Grid.around((0.0,) * dim, (1.3, 0.7, 0.9)[:dim], 0.21)
    position = rng.uniform(0, 1, (count, dim)) * np.array((1.3, 0.7, 0.9)[:dim])
    return rng, grid, position


@pytest.mark.parametrize("dim", DIMS)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_sort_equals_lexsort_by_cell_and_tag(dim, seed):
    rng, grid, position = random_case(dim, seed)
    tags = rng.permutation(len(position))
    domain = domain_of(grid, {"position": position}, tags=tags)
    domain.arrange(0.0)
    expected = np.lexsort((tags, cells_of(grid, position)))
    p = domain.particles
    np.testing.assert_array_equal(p.tags[p.first : p.last], tags[expected])
    np.testing.assert_array_equal(p.field("position", p.fluid), position[expected])


@pytest.mark.parametrize("dim", DIMS)
def test_sort_follows_moving_particles(dim):
    """Each sort starts from the order of the last one: the result may not depend on that."""
    rng, grid, position = random_case(dim, 4)
    tags = np.arange(len(position))
    domain = domain_of(grid, {"position": position}, tags=tags)
    p = domain.particles
    for _ in range(5):
        domain.arrange(0.0)
        moved = np.clip(p.field("position", p.fluid) + rng.uniform(-0.1, 0.1, (len(tags), dim)), 0, 0.69)
        p.shared[p.fluid, :dim] = moved
        domain.arrange(0.0)
        by_id = np.empty_like(moved)
        by_id[p.tags[p.fluid]] = p.field("position", p.fluid)
        expected = np.lexsort((tags, cells_of(grid, by_id)))
        np.testing.assert_array_equal(p.tags[p.fluid], tags[expected])


def test_sort_is_stable():
    """Rows of equal cell and tag keep their order."""
    rng = np.random.default_rng(5)
    cells = rng.integers(0, 20, 500).astype(np.int32)
    counts = np.bincount(cells, minlength=20).astype(np.int64)
    starts, order = np.empty(21, np.int64), np.empty(500, np.int32)
    order_by_cell(cells, np.zeros(500, np.int64), 0, 500, counts, starts, order)
    np.testing.assert_array_equal(order, np.argsort(cells, kind="stable"))
    np.testing.assert_array_equal(starts, np.searchsorted(np.sort(cells), np.arange(21)))


@pytest.mark.parametrize("dim", DIMS)
def test_starts_bound_the_particles_of_each_cell(dim):
    _, grid, position = random_case(dim, 6)
    domain = domain_of(grid, {"position": position})
    domain.arrange(0.0)
    p, stride = domain.particles, grid.stride
    counts = np.diff(domain.starts)[stride:-stride]
    np.testing.assert_array_equal(counts, np.bincount(cells_of(grid, position), minlength=grid.columns * stride))
    assert domain.starts[-1] == p.last - p.first


@pytest.mark.parametrize("size", [1.0, 0.7, 12.122, 6.0610000000001, 0.3])
@pytest.mark.parametrize("cell", [0.2, 0.04, 0.1, 0.30000000000000004])
def test_grid_has_a_margin_of_a_cell_on_all_sides(size, cell):
    """No loop over neighbours asks where the grid ends, and no mirror image lies outside it."""
    grid = Grid.around((-0.13, 0.0), (-0.13 + size, size), cell)
    ends = np.array([[-0.13, 0.0], [-0.13 + size, size]])
    inner = [np.unravel_index(cell_of(ends, k, grid.low, 1 / grid.cell, grid.shape), grid.shape) for k in (0, 1)]
    assert min(inner[0]) >= 1
    assert all(index <= n - 2 for index, n in zip(inner[1], grid.shape, strict=True))
    reach = cell * (1 - 1e-12)
    beyond = np.array([ends[0] - reach, ends[1] + reach])
    outer = [np.floor((point - grid.low) / grid.cell).astype(int) for point in beyond]
    assert (outer[0] >= 0).all()
    assert (outer[1] < grid.shape).all()


def test_cells_of_one_column_follow_each_other():
    grid = Grid.around((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 0.3)
    rows = np.random.default_rng(7).uniform(0, 1, (50, 3))
    for k, row in enumerate(rows):
        column = cell_of(rows, k, grid.low, 1 / grid.cell, grid.shape) // grid.stride
        assert column == grid.column_of(row[0])


@pytest.mark.parametrize("shape", [(9,), (5, 12), (4, 5, 10)])
@pytest.mark.parametrize("most", [1, 8])
def test_blocks_hold_each_cell_but_those_of_the_margin_once(shape, most):
    held = np.zeros(np.prod(shape), int)
    for cell in range(len(held)):
        held[cell : cell + cells_of_block(cell, most, shape)] += 1
    inner = np.ones(shape, int)
    for axis in range(1, len(shape)):
        inner.swapaxes(0, axis)[[0, -1]] = 0
    assert (held == inner.ravel()).all()


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_what_is_within_reach_of_a_height_stands_together(dim):
    grid = Grid.around((0.0,) * dim, (1.0,) * dim, 0.13)
    rows = np.random.default_rng(dim).uniform(0.0, 1.0, (600, dim))
    cells = np.array([cell_of(rows, k, grid.low, 1 / grid.cell, grid.shape) for k in range(len(rows))])
    order = np.argsort(cells, kind="stable")
    rows, starts = rows[order], np.searchsorted(cells[order], np.arange(np.prod(grid.shape) + 1))
    strips, stride, most = 3 ** (dim - 1), cells_per_column(grid.shape), 1 if dim == 1 else 4
    chosen, places, ends = np.empty(1000, np.uint32), np.empty(1000, np.uint32), ends_of_layers(most)
    seen = 0
    for cell in range(stride, len(starts) - 1 - stride):
        n = cells_of_block(cell, most, grid.shape)
        heights = rows[starts[cell] : starts[cell + n], -1]
        if not len(heights):
            continue
        around = cell, n, strips, stride, grid.shape
        lowest = heights.min() - grid.cell
        count, own = order_by_layer(rows, starts, *around, lowest, grid.cell, chosen, places, ends)
        assert count == candidates(starts, *around)
        assert sorted(places[:count]) == list(range(count))
        for k, height in enumerate(heights):
            assert chosen[own + k] == starts[cell] + k
            first, last = within_reach(height, lowest, grid.cell, ends)
            near = np.abs(rows[chosen[:count], -1] - height) < grid.cell
            inside = (places[:count] >= first) & (places[:count] < last)
            assert not (near & ~inside).any()
            apart = np.abs(rows[chosen[:count], -1] - height)[inside]
            assert (apart < grid.cell * (1 + 1.01 / LAYERS)).all() or height - heights.min() < grid.cell / LAYERS
            seen += 1
    assert seen == len(rows)


@pytest.mark.parametrize("place", [np.nan, np.inf, 99.0, -99.0])
def test_particle_outside_the_box_is_named(place):
    _, grid, position = random_case(2, 8)
    position[17, 1] = place
    with pytest.raises(RunError, match="particle 17 left the domain"):
        domain_of(grid, {"position": position}, box=((0.0, 0.0), (1.3, 0.7))).arrange(0.0)


def test_tags_of_images_sort_behind_those_of_all_fluid():
    assert FIRST_GHOST > 2**40
