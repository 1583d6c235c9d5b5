"""Fixed ghost walls and the terms that came with them: interpolation, mirror laws, barrier, renormalised gradients,
tensile control, shifting, spray, density filters, settling; and small scenes that are hard on walls.
"""

import math

import numpy as np
import pytest
from helpers import Probe, domain_of, grid_around, jittered_lattice, water

from parsph.columns import Grid
from parsph.geometry import Boundary, Outline
from parsph.kernels import KERNELS
from parsph.linear import solve_symmetric
from parsph.particles import FIRST_FIXED
from parsph.reinitialisation import DensityFilter
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.states import State, density_of
from parsph.sweep import Sweep
from parsph.terms import DIFFUSIONS, FILTERS, SHIFTINGS, SPRAYS, TENSILE_CONTROLS, Terms
from parsph.walls import INTERPOLATORS, Barrier, FixedGhosts, Lines
from parsph.walls.ghosts import mirror_laws
from parsph.walls.interpolation import (
    DRY,
    HYDROSTATIC,
    MLS1,
    MLS2,
    NORMALISED,
    SFDI,
    SHEPARD,
    compiled_interpolation,
    compiled_shapes,
    room_for,
)
from parsph.walls.mirror import SLIPS
from parsph.wavemakers import Swing

DX, RHO0, C0 = 0.05, 1000.0, 20.0
WENDLAND = KERNELS["wendland-c2"]
CODES = {name: each.code for name, each in INTERPOLATORS.items()}
CONVEX = ["normalised", "hydrostatic", "shepard"]
LINEAR = ["mls1", "mls2", "sfdi"]
GRAVITY = {1: (0.0,), 2: (1.5, -9.81), 3: (1.5, -2.0, -9.81)}

# --- shape functions -----------------------------------------------------------------------------------------------


def shapes_of(method, apart, kernels=None):
    """Return (method it came to, shapes) for neighbours `apart`, shape (n, dim), over R; V W of equal volumes by default."""
    apart = np.asarray(apart, float)
    count, dim = apart.shape
    if kernels is None:
        kernels = WENDLAND.value(2 * np.linalg.norm(apart, axis=1), 1.0, dim)
    shapes = np.full(count + 1, np.nan)
    room = np.zeros((dim, count + 1))
    room[:, :count] = apart.T
    kernels = np.append(kernels, np.nan)  # what lies behind the neighbours must not matter
    found = compiled_shapes(WENDLAND.code)(CODES[method], room, kernels, count, 2.0, room_for(dim, count + 1), shapes)
    return found, shapes[:count]


def neighbours(dim, jitter, reach=3.0, seed=1):
    """Yield neighbours over R of points at half a spacing from a wall at the bottom of a jittered block, nothing behind it."""
    cells = (11,) * (dim - 1) + (6,)
    points = jittered_lattice(dim, cells, 1.0, seed, jitter)
    rng = np.random.default_rng(seed + 1)
    for _ in range(10):
        place = np.append(rng.uniform(5.0, 6.0, dim - 1), 0.5)
        apart = (points - place) / reach
        yield apart[np.linalg.norm(apart, axis=1) < 1]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("jitter", [0.1, 0.3])
@pytest.mark.parametrize("name", INTERPOLATORS)
def test_shapes_at_a_wall_sum_to_one_and_come_to_their_own_method(name, jitter, dim):
    for reach in (3.0, 4.0):
        for apart in neighbours(dim, jitter, reach):
            found, shapes = shapes_of(name, apart)
            assert found == CODES[name]
            assert shapes.sum() == pytest.approx(1, abs=1e-12)
            if name in CONVEX:
                assert (shapes >= 0).all()


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("jitter", [0.1, 0.3])
@pytest.mark.parametrize("name", LINEAR)
def test_linear_fields_are_reproduced_at_a_wall(name, jitter, dim):
    for apart in neighbours(dim, jitter):
        _, shapes = shapes_of(name, apart)
        np.testing.assert_allclose(shapes @ apart, 0, atol=1e-10)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("jitter", [0.1, 0.3])
def test_quadratic_fields_are_reproduced_by_mls2(jitter, dim):
    for apart in neighbours(dim, jitter):
        for a in range(dim):
            for b in range(dim):
                assert shapes_of("mls2", apart)[1] @ (apart[:, a] * apart[:, b]) == pytest.approx(0, abs=1e-9)


def test_hydrostatic_weights_are_the_normalised_ones_and_shepard_weighs_near_ones_more():
    apart = next(neighbours(2, 0.3))
    np.testing.assert_array_equal(shapes_of("hydrostatic", apart)[1], shapes_of("normalised", apart)[1])
    kernels = WENDLAND.value(2 * np.linalg.norm(apart, axis=1), 1.0, 2)
    np.testing.assert_allclose(shapes_of("normalised", apart)[1], kernels / kernels.sum(), rtol=1e-12)
    r = np.linalg.norm(apart, axis=1)
    weights = (1 - r) ** 4 / r**2
    np.testing.assert_allclose(shapes_of("shepard", apart)[1], weights / weights.sum(), rtol=1e-12)


TRIANGLE = [[0.1, 0.2], [-0.3, 0.1], [0.2, -0.3]]
FIVE = [*TRIANGLE, [0.4, 0.4], [-0.2, 0.5]]
ROW = [[x, 0.1 + 0.5 * x] for x in (-0.6, -0.3, -0.1, 0.1, 0.25, 0.4, 0.6)]
CIRCLE = [[0.1 + 0.5 * math.cos(a), 0.5 * math.sin(a)] for a in (0, 0.9, 1.7, 2.9, 3.8, 5.0, 5.7)]
FALLBACKS = {
    "mls2 with as many neighbours as terms": ("mls2", [*FIVE, [-0.5, -0.4]], MLS2),
    "mls2 with fewer than six": ("mls2", FIVE, MLS1),
    "mls2 on a circle": ("mls2", CIRCLE, MLS1),
    "mls2 with fewer than three": ("mls2", TRIANGLE[:2], NORMALISED),
    "mls2 on a line": ("mls2", ROW, NORMALISED),
    "mls2 on two lines": ("mls2", [*ROW, *([x, y + 0.2] for x, y in ROW)], MLS1),
    "mls1 with three": ("mls1", TRIANGLE, MLS1),
    "mls1 with fewer than three": ("mls1", TRIANGLE[:2], NORMALISED),
    "mls1 on a line": ("mls1", ROW, NORMALISED),
    "sfdi with three": ("sfdi", TRIANGLE, SFDI),
    "sfdi with fewer than three": ("sfdi", TRIANGLE[:2], NORMALISED),
    "sfdi on a line": ("sfdi", ROW, NORMALISED),
    "shepard with two": ("shepard", TRIANGLE[:2], SHEPARD),
    "hydrostatic with two": ("hydrostatic", TRIANGLE[:2], HYDROSTATIC),
    "normalised with two": ("normalised", TRIANGLE[:2], NORMALISED),
}


@pytest.mark.parametrize("case", FALLBACKS)
def test_where_a_polynomial_is_not_determined_a_lower_one_takes_its_place(case):
    name, apart, expected = FALLBACKS[case]
    found, shapes = shapes_of(name, apart)
    assert found == expected
    assert shapes.sum() == pytest.approx(1, abs=1e-12)
    if expected in (MLS1, MLS2, SFDI):
        np.testing.assert_allclose(shapes @ np.array(apart), 0, atol=1e-10)
    else:
        assert (shapes >= 0).all()


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", INTERPOLATORS)
def test_a_single_neighbour_gives_its_value_and_none_is_dry(name, dim):
    found, shapes = shapes_of(name, [[0.3] * dim])
    assert found == (CODES[name] if name in CONVEX else NORMALISED)
    np.testing.assert_array_equal(shapes, 1)
    assert shapes_of(name, np.zeros((0, dim)))[0] == DRY


@pytest.mark.parametrize("name", [name for name in INTERPOLATORS if name != "shepard"])
def test_neighbours_whose_kernel_is_zero_are_none(name):
    assert shapes_of(name, [[1.0, 0.0]], np.zeros(1))[0] == DRY


@pytest.mark.parametrize("name", INTERPOLATORS)
def test_a_neighbour_at_the_point_itself_is_no_division_by_zero(name):
    for apart in ([[0.0, 0.0]], [[0.0, 0.0], *FIVE, [-0.5, -0.4]]):
        found, shapes = shapes_of(name, apart)
        assert found != DRY
        assert shapes.sum() == pytest.approx(1, abs=1e-12)


# --- interpolation among particles ---------------------------------------------------------------------------------


def block_of(dim, jitter=0.2, cells=None):
    """Return fields of a jittered block of still, hydrostatic water with its corner at the origin, without walls."""
    position = jittered_lattice(dim, cells or {2: (14, 10), 3: (9, 9, 8)}[dim], DX, 3, jitter)
    count = len(position)
    return {
        "position": position,
        "velocity": np.zeros((count, dim)),
        "density": np.full(count, RHO0),
        "pressure": RHO0 * (position @ np.array(GRAVITY[dim])),
        "mass": np.full(count, RHO0 * DX**dim),
    }


def interpolated(name, fields, points, gravity):
    """Return (velocity, pressure, methods used) at `points`, shape (n, dim)."""
    dim, h = points.shape[1], 1.5 * DX
    everything = np.concatenate([fields["position"], points])
    grid = grid_around(everything, WENDLAND.support * h)
    domain = domain_of(grid, fields)
    domain.arrange(0.0)
    p = domain.particles
    index = np.floor((points - np.array(grid.low)) / grid.cell).astype(np.int64)
    cells = np.ravel_multi_index(tuple(index.T), grid.shape) + grid.stride
    order = np.argsort(cells, kind="stable")
    values, used = np.full((len(points), dim + 1), np.nan), np.full(len(points), -1)
    numbers = h, WENDLAND.norms[dim - 1] / h**dim, RHO0
    compiled_interpolation(dim, WENDLAND.code, CODES[name])(
        p.shared, p.tags, domain.starts, points[order], cells[order], (grid.cell, grid.shape), numbers, gravity, values, used
    )
    back = np.argsort(order)
    return values[back, :dim], values[back, dim], used[back]


def points_in(fields, count=60, seed=8, outside=0.0):
    """Return random points in the box around the particles, larger by `outside` spacings."""
    low, high = (fields["position"].min(axis=0) - outside * DX, fields["position"].max(axis=0) + outside * DX)
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", ["hydrostatic", *LINEAR])
def test_hydrostatic_pressure_is_reproduced_at_any_point(name, dim):
    """Half a spacing outside of the block included, one-sided; positive everywhere, so that no limit at the surface acts."""
    fields = block_of(dim)
    fields["pressure"] += 50 * RHO0
    points = points_in(fields, outside=0.5)
    _, pressure, used = interpolated(name, fields, points, GRAVITY[dim])
    assert (used != DRY).all()
    expected = RHO0 * (points @ np.array(GRAVITY[dim])) + 50 * RHO0
    np.testing.assert_allclose(pressure, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", INTERPOLATORS)
def test_nothing_is_extrapolated_beyond_the_neighbours(name, dim):
    """Velocities, and pressures on the level of the point; `shepard` and `normalised` mean the pressures as they are."""
    fields = block_of(dim)
    rng = np.random.default_rng(9)
    fields["velocity"] = rng.normal(0, 1, fields["velocity"].shape)
    fields["pressure"] = fields["pressure"] + rng.uniform(2e4, 3e4, len(fields["position"]))
    points = points_in(fields, outside=1.5)
    velocity, pressure, used = interpolated(name, fields, points, GRAVITY[dim])
    assert (used != DRY).all()
    heads = fields["position"] @ np.array(GRAVITY[dim])
    for k, point in enumerate(points):
        near = np.linalg.norm(fields["position"] - point, axis=1) < 3 * DX
        level = 0.0 if name in ("shepard", "normalised") else RHO0 * (point @ np.array(GRAVITY[dim]) - heads[near])
        limits = [*fields["velocity"][near].T, fields["pressure"][near] + level]
        for value, limit in zip([*velocity[k], pressure[k]], limits, strict=True):
            slack = 1e-12 * np.abs(limit).max()
            assert limit.min() - slack <= value <= limit.max() + slack


@pytest.mark.parametrize("name", INTERPOLATORS)
def test_pressure_is_not_negative_where_less_than_half_is_covered(name):
    """Above the block, and only there: suction inside is kept."""
    fields = block_of(2)
    fields["pressure"][:] = -500.0
    top = 10 * DX
    for height, expected in ((top + 0.4 * DX, 0.0), (top + DX, 0.0), (top - DX, -500.0), (5 * DX, -500.0)):
        points = np.stack([np.linspace(5, 9, 7) * DX, np.full(7, height)], axis=1)
        _, pressure, used = interpolated(name, fields, points, (0.0, 0.0))
        assert (used != DRY).all()
        np.testing.assert_allclose(pressure, expected, atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", INTERPOLATORS)
def test_points_without_fluid_near_are_dry(name, dim):
    fields = block_of(dim)
    fields["velocity"][:] = 3.0
    fields["pressure"][:] = 100.0
    high = fields["position"].max(axis=0)
    points = np.stack([high + np.append(np.zeros(dim - 1), 3.01 * DX), high + 9 * DX, high - 4 * DX])
    velocity, pressure, used = interpolated(name, fields, points, GRAVITY[dim])
    assert used.tolist()[:2] == [DRY, DRY]
    assert used[2] == CODES[name]
    assert not velocity[:2].any()
    assert not pressure[:2].any()


def basin(*polygons, **sections):
    """Return the keys of a small tank of polygon walls, 0.5 m x 0.5 m with 0.3 m of water at spacing DX."""
    lines = {"name": "tank", "points": [[0.0, 0.5], [0.0, 0.0], [0.5, 0.0], [0.5, 0.5]]}
    keys = {
        "domain": {"size": [0.5, 0.5]},
        "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [0.5, 0.3]}]},
        "walls": {"polygons": [lines, *polygons]},
        "numerics": {"dx": DX, "h_over_dx": 1.5, "diffusion": "antuono", "viscosity": "monaghan"},
        "time": {"end": 0.01},
    }
    return {**keys, **{name: {**keys.get(name, {}), **values} for name, values in sections.items()}}


@pytest.mark.parametrize("name", INTERPOLATORS)
def test_ghosts_do_not_read_ghosts(name):
    """Whatever the ghosts among the candidates carry, NaN included, the values are the same bits."""
    keys = basin()
    keys["walls"]["interpolation"] = name
    simulation = build(load_scene(keys))
    simulation.prepare()
    domain, p = simulation.domain, simulation.particles
    before = domain.ghosts.values.copy()
    rows = np.flatnonzero(p.tags[: domain.starts[-1]] >= FIRST_FIXED)
    assert len(rows) > 50
    p.shared[rows, 2:7] = np.nan  # all that is given to them
    domain.ghosts.values[:] = np.nan
    domain.fill_ghosts()
    mine = domain.ghosts.share.mine
    np.testing.assert_array_equal(domain.ghosts.values[mine], before[mine])
    assert np.isfinite(p.shared[rows]).all()


# --- small systems of equations ------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", range(1, 11))
def test_symmetric_systems_are_solved(size):
    rng = np.random.default_rng(size)
    for _ in range(5):
        root = rng.normal(0, 1, (size, size + 3))
        matrix, vector = np.full((size + 2, size + 2), np.nan), np.full(size + 2, np.nan)
        matrix[:size, :size], vector[:size] = root @ root.T, rng.normal(0, 1, size)
        expected = np.linalg.solve(matrix[:size, :size], vector[:size])
        assert solve_symmetric(matrix, vector, size, 1e-9)
        np.testing.assert_allclose(vector[:size], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((2, 2)),
        [[1.0, 1.0], [1.0, 1.0]],
        [[1.0, 2.0], [2.0, 4.0 + 1e-9]],
        [[1.0, 0.0], [0.0, -1.0]],
        [[np.nan, 0.0], [0.0, 1.0]],
        [[1.0, 0.0], [0.0, np.nan]],
        [[2.0, 1.0, 3.0], [1.0, 2.0, 3.0], [3.0, 3.0, 6.0]],
    ],
    ids=["zero", "ones", "nearly", "negative", "NaN first", "NaN last", "third is the sum of two"],
)
def test_singular_systems_are_refused(matrix):
    assert not solve_symmetric(np.array(matrix, float), np.ones(len(matrix)), len(matrix), 1e-6)


def test_a_scale_of_the_unknowns_is_no_ill_condition():
    matrix = np.diag([1.0, 1e-6, 1e6]) + 0.0
    vector = np.array([1.0, 2e-6, 3e6])
    assert solve_symmetric(matrix, vector, 3, 1e-2)
    np.testing.assert_allclose(vector, [1, 2, 3], rtol=1e-12)


# --- mirror laws ---------------------------------------------------------------------------------------------------


def slanting(angle):
    """Return the ghosts of a straight wall through (1, 1) that rises by `angle` degrees, with the fluid at its left."""
    along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    points = (tuple(1 - 0.5 * along), tuple(1 + 0.5 * along))
    return Boundary({0: Outline("wall", points, "left")}, DX, 3 * DX).ghosts()


def fixed_ghosts(ghosts, slip="free", motion=None, gravity=(0.0, -9.81)):
    return FixedGhosts([(ghosts, [SLIPS[slip]], motion)], "mls1", WENDLAND, 1.5 * DX, RHO0, gravity, water(C0))


def mirrored(fixed, found, used=None):
    """Return (velocity, density, pressure) that ghosts get from (velocity, pressure) `found` at their mirror points."""
    chosen = np.arange(fixed.count)
    used = np.full(fixed.count, MLS1) if used is None else used
    geometry = fixed.position, fixed.mirror, fixed.direction, fixed.turned, fixed.wall
    mirror_laws(chosen, *geometry, found, used, fixed.gravity, fixed.state.constants, fixed.values)
    return fixed.values[:, :2], fixed.values[:, 2], fixed.values[:, 3]


ANGLES = [0, 20, 45, 90, 150, 250]
SWING = Swing((0.3, -0.1), math.radians(20), (0.7, 0.8), 1.3, 0.4)


@pytest.mark.parametrize("angle", ANGLES)
def test_still_water_goes_on_behind_a_wall_of_any_slope(angle):
    """p_m + rho_m g (z_m - z_g): that of the depth of the ghost, but for compression between the two."""
    fixed = fixed_ghosts(slanting(angle))
    heights = fixed.mirror[:, 1], fixed.position[:, 1]
    still, right = (fixed.state.pressure(fixed.state.still_density(9.81 * (2.0 - height))) for height in heights)
    velocity, density, pressure = mirrored(fixed, np.column_stack([np.zeros((fixed.count, 2)), still]))
    expected = still + (RHO0 + still / C0**2) * 9.81 * (heights[0] - heights[1])
    np.testing.assert_allclose(pressure, expected, rtol=1e-12)
    np.testing.assert_allclose(pressure, right, atol=0.01 * RHO0 * 9.81 * 5 * DX)
    np.testing.assert_allclose(density, fixed.state.density(expected), rtol=1e-12)
    assert not velocity.any()


@pytest.mark.parametrize("angle", ANGLES)
def test_free_slip_turns_the_normal_velocity_and_keeps_the_tangential(angle):
    fixed = fixed_ghosts(slanting(angle))
    found = np.random.default_rng(2).normal(0, 1, (fixed.count, 3))
    velocity, _, _ = mirrored(fixed, found)
    normal = np.array([-math.sin(math.radians(angle)), math.cos(math.radians(angle))])
    tangent = np.array([normal[1], -normal[0]])
    np.testing.assert_allclose(velocity @ normal, -found[:, :2] @ normal, atol=1e-12)
    np.testing.assert_allclose(velocity @ tangent, found[:, :2] @ tangent, atol=1e-12)


def test_no_slip_and_corners_turn_all_of_the_velocity():
    found = np.random.default_rng(2).normal(0, 1, (1000, 3))
    fixed = fixed_ghosts(slanting(30), "no")
    np.testing.assert_array_equal(mirrored(fixed, found[: fixed.count])[0], -found[: fixed.count, :2])
    corner = Boundary({0: Outline("wall", ((0.0, 1.0), (0.0, 0.0), (1.0, 0.0)), "left")}, DX, 3 * DX).ghosts()
    fixed = fixed_ghosts(corner)
    beyond = (fixed.position < 0).all(axis=1)
    assert beyond.sum() == 8  # of 3 x 3, the farthest is out of reach
    np.testing.assert_array_equal(mirrored(fixed, found[: fixed.count])[0][beyond], -found[: fixed.count, :2][beyond])
    assert (fixed.turned == beyond).all()


@pytest.mark.parametrize("time", [0.1, 0.39, 0.9])
def test_ghosts_and_mirror_points_move_with_their_wall(time):
    fixed = fixed_ghosts(slanting(20), motion=SWING)
    rest = fixed.position.copy(), fixed.mirror.copy(), fixed.direction.copy()
    fixed.move(time)
    now, step = SWING.at(time), 1e-4
    np.testing.assert_allclose(fixed.position, now.place(rest[0]), atol=1e-12)
    np.testing.assert_allclose(fixed.mirror, now.place(rest[1]), atol=1e-12)
    np.testing.assert_allclose(fixed.direction, now.turn(rest[2]), atol=1e-12)
    at = [0.5 * (SWING.at(t).place(rest[0]) + SWING.at(t).place(rest[1])) for t in (time - step, time, time + step)]
    np.testing.assert_allclose(fixed.wall[:, :2], (at[2] - at[0]) / (2 * step), atol=1e-5)
    np.testing.assert_allclose(fixed.wall[:, 2:], (at[2] - 2 * at[1] + at[0]) / step**2, atol=1e-4)
    fixed.move(0.0)
    np.testing.assert_allclose(fixed.position, rest[0], atol=1e-14)
    assert not fixed.wall.any()


@pytest.mark.parametrize("slip", SLIPS)
def test_fluid_that_moves_with_a_swinging_wall_is_not_pushed_by_its_velocity(slip):
    """No slip: ghosts go on with the rigid motion. Free slip: nothing normal to the wall to turn."""
    fixed = fixed_ghosts(slanting(20), slip, SWING)
    fixed.move(0.3)
    now = SWING.at(0.3)
    velocity, _, _ = mirrored(fixed, np.column_stack([now.velocity(fixed.mirror), np.zeros(fixed.count)]))
    expected = now.velocity(fixed.position if slip == "no" else fixed.mirror)
    np.testing.assert_allclose(velocity, expected, atol=1e-12)
    assert np.abs(velocity).max() > 0.01


def test_an_accelerated_wall_presses():
    """p_g - p_m = rho_m (g - a_w) . (x_g - x_m); a wall that falls freely carries no pressure."""
    fixed = fixed_ghosts(slanting(70), motion=SWING)
    fixed.move(0.25)
    found = np.column_stack([np.zeros((fixed.count, 2)), np.full(fixed.count, 2e4)])
    _, density, pressure = mirrored(fixed, found)
    middle = 0.5 * (fixed.position + fixed.mirror)
    pull = np.array(fixed.gravity) - SWING.at(0.25).acceleration(middle)
    expected = 2e4 + (RHO0 + 2e4 / C0**2) * (pull * (fixed.position - fixed.mirror)).sum(axis=1)
    np.testing.assert_allclose(pressure, expected, rtol=1e-12)
    np.testing.assert_allclose(density, fixed.state.density(expected), rtol=1e-12)
    fixed.wall[:, 2:] = fixed.gravity
    np.testing.assert_array_equal(mirrored(fixed, found)[2], 2e4)


def test_ghosts_without_fluid_have_no_pressure_and_the_velocity_of_the_wall():
    fixed = fixed_ghosts(slanting(20), motion=SWING)
    fixed.move(0.25)
    velocity, density, pressure = mirrored(fixed, np.full((fixed.count, 3), 7.0), np.full(fixed.count, DRY))
    np.testing.assert_array_equal(velocity, fixed.wall[:, :2])
    assert (density == RHO0).all()
    assert (pressure == 0).all()


@pytest.mark.parametrize("name", ["hydrostatic", *LINEAR])
@pytest.mark.parametrize("slope", [0.0, 0.2, 0.45])
def test_ghosts_below_still_water_on_a_slope_carry_the_pressure_of_their_depth(name, slope):
    """The whole way: from particles that fit no lattice through mirror points to the rows of the ghosts."""
    keys = basin(fluid={"blocks": [{"points": [[0.0, 0.0], [0.5, slope], [0.5, 0.5], [0.0, 0.5]]}], "level": 0.5})
    keys["walls"] = {"polygons": [{"points": [[0.0, 0.5], [0.0, 0.0], [0.5, slope], [0.5, 0.5]]}], "interpolation": name}
    simulation = build(load_scene(keys))
    p, domain = simulation.particles, simulation.domain
    weight = simulation.sweep.rho0 * 9.81
    density = simulation.state.density(weight * (0.5 - p.field("position", p.fluid)[:, 1]))
    p.shared[p.fluid, 4] = density
    simulation.evaluate(0.0)
    rows = np.flatnonzero(p.tags[: domain.starts[-1]] >= FIRST_FIXED)
    ghosts = p.tags[rows] - FIRST_FIXED
    below = domain.ghosts.mirror[ghosts, 1] < 0.5 - 2 * DX
    rows, ghosts = rows[below], ghosts[below]
    assert len(rows) > 60
    level = 0.5 - domain.ghosts.mirror[ghosts, 1]
    depth_more = domain.ghosts.mirror[ghosts, 1] - p.shared[rows, 1]
    at_mirror = weight * level
    expected = at_mirror + (simulation.sweep.rho0 + at_mirror / simulation.state.c0**2) * 9.81 * depth_more
    np.testing.assert_allclose(p.shared[rows, 5], expected, atol=1e-9 * expected.max())
    np.testing.assert_allclose(p.shared[rows, 4], simulation.state.density(expected), rtol=1e-12)
    np.testing.assert_allclose(p.shared[rows, 6], p.shared[rows, 4] * domain.ghosts.volume[ghosts], rtol=1e-12)


# --- barrier -------------------------------------------------------------------------------------------------------


def held(lines, position, velocity, time=0.0):
    """Return (positions, velocities, how many were stopped) after one pass of the barrier of `lines`."""
    position, velocity = np.atleast_2d(np.asarray(position, float)), np.atleast_2d(np.asarray(velocity, float))
    grid = Grid.around((-1.0, -1.0), (3.0, 3.0), 3 * DX)
    domain = domain_of(grid, {"position": position, "velocity": velocity})
    domain.arrange(0.0)
    barrier = Barrier(lines, DX)
    barrier.distribute(grid, domain.slab)
    barrier.hold(domain.particles, domain.starts, time)
    p = domain.particles
    rows = p.fluid[np.argsort(p.tags[p.fluid])]
    return p.field("position", rows), p.field("velocity", rows), barrier.stopped


def lines_of(*outlines, motion=None):
    boundary = Boundary(dict(enumerate(outlines)), DX, 3 * DX)
    return [Lines(boundary.edges, boundary.normals, boundary.inner_ends(), motion)]


def straight(angle, motion=None):
    """Return (lines, tangent, normal) of a wall through (1, 1)."""
    tangent = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    points = (tuple(1 - 0.5 * tangent), tuple(1 + 0.5 * tangent))
    return lines_of(Outline("wall", points, "left"), motion=motion), tangent, np.array([-tangent[1], tangent[0]])


@pytest.mark.parametrize("angle", ANGLES)
def test_a_particle_at_a_wall_loses_its_velocity_into_it_and_nothing_else(angle):
    lines, tangent, normal = straight(angle)
    place = np.ones(2) + 0.2 * DX * normal + 0.1 * tangent
    position, velocity, stopped = held(lines, place, 0.7 * tangent - 3.0 * normal)
    np.testing.assert_array_equal(position[0], place)
    np.testing.assert_allclose(velocity[0], 0.7 * tangent, atol=1e-12)
    assert stopped == 1


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize(("height", "speed"), [(0.26, -3.0), (0.5, -3.0), (0.2, 3.0), (0.0, 0.0), (-2.1, -3.0)])
def test_farther_than_a_quarter_spacing_or_on_its_way_out_nothing_happens(angle, height, speed):
    lines, tangent, normal = straight(angle)
    start = np.ones(2) + height * DX * normal, 0.7 * tangent + speed * normal
    if height == 0.0:
        start = np.ones(2), 0.0 * normal
    position, velocity, stopped = held(lines, *start)
    np.testing.assert_allclose(position[0], start[0], atol=1e-15)
    np.testing.assert_array_equal(velocity[0], start[1])
    assert stopped == 0


@pytest.mark.parametrize("angle", ANGLES)
def test_a_particle_behind_a_wall_is_put_back_on_its_line(angle):
    lines, tangent, normal = straight(angle)
    for depth in (0.01, 0.5, 1.9):
        place = np.ones(2) - depth * DX * normal + 0.2 * tangent
        position, velocity, _ = held(lines, place, 0.7 * tangent + 0.2 * normal)
        np.testing.assert_allclose(position[0], np.ones(2) + 0.2 * tangent, atol=1e-12)
        np.testing.assert_array_equal(velocity[0], 0.7 * tangent + 0.2 * normal)  # it is already on its way out


CORNER = Outline("corner", ((0.0, 1.0), (0.0, 0.0), (1.0, 0.0)), "left")


def test_in_a_corner_of_the_fluid_both_walls_hold():
    for place, expected in (
        ((0.1, 0.1), (0.1, 0.1)),
        ((-0.3, 0.1), (0.0, 0.1)),
        ((-0.3, -0.6), (0.0, 0.0)),
        ((0.1, -0.6), (0.1, 0.0)),
    ):
        position, velocity, stopped = held(lines_of(CORNER), np.array(place) * DX, (-3.0, -2.0))
        np.testing.assert_allclose(position[0] / DX, expected, atol=1e-12)
        np.testing.assert_allclose(velocity[0], 0, atol=1e-12)
        assert stopped == 1


BOX = Outline("box", ((1.0, 1.0), (1.5, 1.0), (1.5, 1.5), (1.0, 1.5)), "outside")
BOX_TURNED = Outline("box", ((1.5, 1.5), (1.0, 1.5), (1.0, 1.0), (1.5, 1.0)), "outside")


def test_an_outer_corner_lets_pass():
    """Beyond the end of a face its line does not act."""
    for place, before, after in (
        ((-0.1, 0.1), (3.0, -3.0), (3.0, -3.0)),  # over the corner: in front of no face
        ((-0.1, -0.2), (0.0, -3.0), (0.0, -3.0)),  # in front of the left face, below the line of the upper one
        ((-0.1, -0.2), (3.0, -3.0), (0.0, -3.0)),
        ((0.2, 0.1), (3.0, -3.0), (3.0, 0.0)),  # over the upper face
    ):
        start = np.array([1.0, 1.5]) + DX * np.array(place)
        position, velocity, _ = held(lines_of(BOX), start, before)
        np.testing.assert_array_equal(position[0], start)
        np.testing.assert_allclose(velocity[0], after, atol=1e-12)


@pytest.mark.parametrize("outline", [BOX, BOX_TURNED], ids=["box", "box from its other corner"])
@pytest.mark.parametrize("corner", [0, 1, 2, 3])
@pytest.mark.parametrize("face", [0, 1])
def test_a_particle_just_behind_one_face_near_an_outer_corner_is_put_on_that_face(outline, corner, face):
    """It came through the face a hundredth of a spacing away, not through that which is one and a half away."""
    vertex = np.array([[1.0, 1.0], [1.5, 1.0], [1.5, 1.5], [1.0, 1.5]][corner])
    inward = np.sign(np.array([1.25, 1.25]) - vertex)
    depth = np.array([0.01, 1.5] if face == 0 else [1.5, 0.01])
    start = vertex + DX * depth * inward
    position, velocity, _ = held(lines_of(outline), start, 2.0 * inward)
    expected, speed = start.copy(), 2.0 * inward
    expected[face], speed[face] = vertex[face], 0.0
    np.testing.assert_allclose(position[0], expected, atol=1e-12)
    np.testing.assert_allclose(velocity[0], speed, atol=1e-12)


def test_the_barrier_never_gives_energy():
    rng = np.random.default_rng(7)
    position = np.array([1.0, 1.0]) + rng.uniform(-0.2, 0.7, (400, 2))
    velocity = rng.normal(0, 1, (400, 2))
    _, after, stopped = held(lines_of(BOX), position, velocity)
    assert stopped > 5
    assert (np.linalg.norm(after, axis=1) <= np.linalg.norm(velocity, axis=1) + 1e-12).all()


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("time", [0.3, 0.9])
def test_a_moving_wall_takes_a_particle_along(angle, time):
    """It stands where the wall is at that time; one that the wall runs into has the normal velocity of the wall there."""
    lines, tangent, normal = straight(angle, SWING)
    now = SWING.at(time)
    (tangent, normal), (place,) = now.turn(np.array([tangent, normal])), now.place(np.ones((1, 2)))
    for height in (0.1, -0.4):
        start = place + height * DX * normal
        (wall,) = now.velocity(start[None])
        for relative, kept in ((-2.0, 0.0), (2.0, 2.0)):
            position, velocity, _ = held(lines, start, wall + relative * normal + 0.6 * tangent, time)
            np.testing.assert_allclose(position[0], place + max(height, 0) * DX * normal, atol=1e-12)
            np.testing.assert_allclose(velocity[0], wall + kept * normal + 0.6 * tangent, atol=1e-12)


# --- equations of state --------------------------------------------------------------------------------------------


def test_density_is_the_inverse_of_pressure_wherever_the_root_is_newtons_or_not():
    """gamma = 7: from 0.7 to 1.3 rho0, at both ends of the range of Newton's root, and one number at a time."""
    state = State("tait", RHO0, C0, 7.0)
    ends = RHO0 * np.array([0.5, 2.0]) ** (1 / 7)
    density = np.concatenate([np.linspace(700, 1300, 601), ends, ends * (1 + 1e-9), ends * (1 - 1e-9)])
    np.testing.assert_allclose(state.density(state.pressure(density)), density, rtol=1e-13)
    single = [density_of(float(pressure), state.constants) for pressure in state.pressure(density)]
    np.testing.assert_allclose(single, density, rtol=1e-13)


@pytest.mark.parametrize(("name", "gamma"), [("tait", 7.0), ("tait", 1.4), ("tait", 1.0), ("tait", 2.0), ("linear", 7.0)])
def test_still_water_carries_its_own_weight(name, gamma):
    """dp/d(depth) = rho g, by central differences; above the surface the density is that of the surface."""
    state, depth, step = State(name, RHO0, C0, gamma), np.linspace(0.01, 3.0, 30), 1e-4
    slope = (
        state.pressure(state.still_density(9.81 * (depth + step))) - state.pressure(state.still_density(9.81 * (depth - step)))
    ) / (2 * step)
    np.testing.assert_allclose(slope, 9.81 * state.still_density(9.81 * depth), rtol=1e-6)
    np.testing.assert_array_equal(state.still_density(np.array([0.0, -1.0])), RHO0)


# --- renormalised gradients and their diffusion --------------------------------------------------------------------

CELLS = {1: (40,), 2: (16, 15), 3: (11, 10, 10)}
H = 1.3 * DX


def particles(dim, jitter=0.2):
    """Return fields of a jittered block at rest."""
    position = jittered_lattice(dim, CELLS[dim], DX, 1, jitter)
    count = len(position)
    mass = RHO0 * DX**dim * np.random.default_rng(5).uniform(0.9, 1.1, count)
    fields = {"position": position, "velocity": np.zeros((count, dim)), "density": np.full(count, RHO0), "mass": mass}
    return {**fields, "pressure": np.zeros(count)}


def sweep_of(dim, gravity=None, **terms):
    terms, numbers = Terms(**{k: v for k, v in terms.items() if k != "shift"}), {"shift": terms.get("shift", 2.0)}
    return Sweep(WENDLAND, terms, dim, H, RHO0, C0, gravity or (0.0,) * dim, delta=0.1, gamma=2.0, **numbers)


def rates_of(fields, sweep, before=None, evaluations=1):
    """Return (rows of particles in the order of their tags, the particles) after a pass `before` and so many evaluations."""
    grid = grid_around(fields["position"], WENDLAND.support * H)
    features = "verlet", sweep.terms.diffusion.name
    domain = domain_of(grid, fields, gravity=sweep.gravity, state=water(C0), features=features)
    p = domain.particles
    p.drift = np.zeros((len(p.tags), sweep.dim))
    domain.arrange(0.0)
    if before:
        before(p, domain.starts, domain.slab)
    for _ in range(evaluations):
        sweep(p, domain.starts, domain.slab, 1, grid.columns + 1)
        p.carry()
    return p.fluid[np.argsort(p.tags[p.fluid])], p


def gradients_of(fields, sweep):
    rows, p = rates_of(fields, sweep)
    return p.density_gradient[rows]


def inside(fields, layers):
    """Whether particles are so many spacings away from the sides of their block."""
    dim = fields["position"].shape[1]
    place = fields["position"] / DX
    return ((place > layers) & (place < np.array(CELLS[dim]) - layers)).all(axis=1)


def linear_density(fields, dim):
    """Set a linear density and return its gradient without the hydrostatic part [kg/m^4]; with gamma = 2 what diffuses is
    linear in it.
    """
    slope = np.array([12.0, -7.0, 5.0][:dim])
    hydrostatic = RHO0 * np.array(GRAVITY[dim]) / C0**2
    fields["density"] = RHO0 + fields["position"] @ (slope + hydrostatic)
    return slope


@pytest.mark.parametrize("dim", CELLS)
def test_the_gradient_of_a_linear_density_is_exact(dim):
    """Inside, and wherever else there is one."""
    fields, sweep = particles(dim), sweep_of(dim, GRAVITY[dim], diffusion=DIFFUSIONS["antuono"])
    slope = linear_density(fields, dim)
    found = gradients_of(fields, sweep)
    within = inside(fields, 2.6)
    assert within.sum() > 20
    exact = within | (found != 0).any(axis=1)
    assert exact.sum() > 1.5 * within.sum() or dim == 1
    np.testing.assert_allclose(found[exact], np.broadcast_to(slope, found[exact].shape), atol=1e-10 * np.abs(slope).max())


@pytest.mark.parametrize("dim", CELLS)
def test_isolated_particles_have_no_gradient(dim):
    """One alone, and in more dimensions two and a row, whose gradient is not determined."""
    sweep = sweep_of(dim, diffusion=DIFFUSIONS["antuono"])
    for count in (1,) if dim == 1 else (1, 2, 6):
        position = 0.5 * DX * np.ones((count, dim))
        position[:, 0] += DX * np.arange(count)
        fields = {"position": position, "density": RHO0 + 10.0 * np.arange(count), "mass": np.full(count, RHO0 * DX**dim)}
        assert not gradients_of(fields, sweep).any()


@pytest.mark.parametrize("dim", CELLS)
def test_antuono_diffusion_leaves_linear_dynamic_densities_alone(dim):
    """Away from surfaces, where all neighbours have a gradient; Fourtakas' form does not."""
    rates = {}
    for name in ("antuono", "fourtakas"):
        sweep = sweep_of(dim, GRAVITY[dim], diffusion=DIFFUSIONS[name])
        fields = particles(dim)
        linear_density(fields, dim)
        rows, p = rates_of(fields, sweep, evaluations=2)
        away = inside(fields, 3.4 if dim < 3 else 4.0)
        if name == "antuono":
            apart = np.linalg.norm(fields["position"][:, None] - fields["position"], axis=2) < 2 * H
            known = (p.density_gradient[rows] != 0).any(axis=1)
            away = (known | ~apart).all(axis=1)
            assert away.sum() > 10
            chosen = away
        rates[name] = np.abs(p.density_rate[rows][chosen]).max()
    assert rates["antuono"] < 1e-9 * rates["fourtakas"]


@pytest.mark.parametrize("dim", CELLS)
def test_antuono_diffusion_equals_the_sum_over_all_pairs(dim):
    fields, sweep = particles(dim), sweep_of(dim, GRAVITY[dim], diffusion=DIFFUSIONS["antuono"])
    x, m = fields["position"], fields["mass"]
    rho = fields["density"] = RHO0 * np.random.default_rng(4).uniform(0.98, 1.02, len(x))
    rows, p = rates_of(fields, sweep, evaluations=2)
    away = x[:, None] - x
    r = np.linalg.norm(away, axis=2)
    F = WENDLAND.slope(r, H, dim) / np.where(r > 0, r, 1.0)
    s = rho - RHO0 * (x @ np.array(GRAVITY[dim])) / C0**2
    slopes = np.einsum("ab,abi,abj->aij", -F * m / rho, away, away)
    pulls = np.einsum("ab,abi->ai", -F * (m / rho) * (s[:, None] - s), away)
    known = np.linalg.det(slopes) > 0.3
    gradient = np.zeros_like(x)
    gradient[known] = np.linalg.solve(slopes[known], pulls[known][:, :, None])[:, :, 0]
    np.testing.assert_allclose(p.density_gradient[rows], gradient, atol=1e-11 * np.abs(gradient).max())
    np.testing.assert_array_equal(p.field("density_gradient", rows), p.density_gradient[rows])
    mean = 0.5 * np.einsum("abi,abi->ab", gradient[:, None] + gradient, away)
    expected = 2 * 0.1 * H * C0 * ((s[:, None] - s - mean) * F * m / rho).sum(axis=1)
    np.testing.assert_allclose(p.density_rate[rows], expected, atol=1e-11 * np.abs(expected).max())
    gains = m / rho * p.density_rate[rows]
    assert abs(gains.sum()) < 1e-12 * np.abs(gains).sum()


# --- tensile control, shifting, spray ------------------------------------------------------------------------------


def covering(fields, dim):
    """Return div r of all particles by the sum over all pairs."""
    away = np.linalg.norm(fields["position"][:, None] - fields["position"], axis=2)
    return -(WENDLAND.slope(away, H, dim) * away * fields["mass"]).sum(axis=1) / fields["density"]


@pytest.mark.parametrize("dim", CELLS)
def test_tensile_control_acts_on_suction_inside_the_fluid_only(dim):
    """There |p_a| stands in place of p_a, as far as the particle lies inside."""
    fields = particles(dim)
    fields["pressure"] = np.random.default_rng(6).uniform(-1e3, 1e3, len(fields["density"]))
    found = {}
    for name in ("none", "sun"):
        rows, p = rates_of(fields, sweep_of(dim, tensile=TENSILE_CONTROLS[name]))
        found[name] = p.acceleration[rows]
    change = found["sun"] - found["none"]
    low = {1: 0.75, 2: 0.75, 3: 2.75 / 3}[dim]
    share = np.clip((covering(fields, dim) / dim - low) / (1 - low), 0, 1)
    acts = (fields["pressure"] < 0) & (share > 1e-9)
    assert 10 < acts.sum() < 0.6 * len(acts)
    assert not share[~inside(fields, 0.8)].any() or dim == 1
    scale = np.abs(change).max()
    np.testing.assert_allclose(change[~acts], 0, atol=1e-12 * scale)
    away = fields["position"][:, None] - fields["position"]
    r = np.linalg.norm(away, axis=2)
    pull = np.einsum("ab,abi->ai", fields["mass"] * WENDLAND.slope(r, H, dim) / np.where(r > 0, r, 1.0), away)
    excess = -2 * share * np.minimum(fields["pressure"], 0) / fields["density"] ** 2
    np.testing.assert_allclose(change, -excess[:, None] * pull, atol=1e-11 * scale)


def drift_of(fields, dim, law="lind", **numbers):
    rows, p = rates_of(fields, sweep_of(dim, shifting=SHIFTINGS[law], **numbers))
    return p.drift[rows]


@pytest.mark.parametrize("dim", CELLS)
def test_shifting_needs_a_velocity_and_leaves_the_surface_alone(dim):
    fields = particles(dim)
    fields["mass"][:] = RHO0 * DX**dim
    assert not drift_of(fields, dim).any()
    fields["velocity"][:] = 2.0 / math.sqrt(dim)
    drift = np.linalg.norm(drift_of(fields, dim), axis=1)
    assert not drift[~inside(fields, 0.7)].any() or dim == 1  # in 1D the outermost of a jittered row may have closer neighbours
    assert (drift[inside(fields, 2.6)] > 0).mean() > 0.3


@pytest.mark.parametrize("dim", [2, 3])
def test_particles_shift_towards_a_hole(dim):
    """All next to it, in a lattice; and away from a particle too many. In one dimension a hole is a surface."""
    fields = particles(dim, 0.0)
    fields["mass"][:] = 1.05 * RHO0 * DX**dim
    fields["velocity"][:] = 1.0
    lone = np.array(CELLS[dim]) // 2 * DX + 0.5 * DX
    apart = np.linalg.norm(fields["position"] - lone, axis=1)
    holed = {name: values[apart > 0.1 * DX] for name, values in fields.items()}
    away = lone - holed["position"]
    near = np.linalg.norm(away, axis=1) < 1.5 * DX
    assert near.sum() == 3**dim - 1 or dim == 3
    drift = drift_of(holed, dim)
    assert ((drift * away).sum(axis=1)[near] > 0).all()
    still = np.linalg.norm(away, axis=1) > 2.7 * DX
    assert np.abs(drift[still & inside(holed, 2.6)]).max(initial=0) < 1e-12
    crowded = {name: np.concatenate([values, values[:1]]) for name, values in fields.items()}
    crowded["position"] = np.concatenate([fields["position"], lone[None] + 0.5 * DX])
    away = crowded["position"] - crowded["position"][-1]
    near = (np.linalg.norm(away, axis=1) < 0.9 * DX) & (np.linalg.norm(away, axis=1) > 0)
    assert ((drift_of(crowded, dim) * away).sum(axis=1)[near] > 0).all()


@pytest.mark.parametrize("dim", CELLS)
def test_the_shift_is_at_most_half_of_the_speed(dim):
    fields = particles(dim, 0.3)
    fields["velocity"] = np.random.default_rng(3).normal(0, 1, fields["velocity"].shape)
    speed = np.linalg.norm(fields["velocity"], axis=1)
    gentle, hard = (np.linalg.norm(drift_of(fields, dim, shift=shift), axis=1) for shift in (0.5, 1000.0))
    assert (hard <= 0.5 * speed * (1 + 1e-12)).all()
    assert (hard > 0.5 * speed * (1 - 1e-9)).sum() > 10
    twice = np.linalg.norm(drift_of(fields, dim, shift=1.0), axis=1)
    free = twice < 0.49 * speed
    np.testing.assert_allclose(twice[free], 2 * gentle[free], rtol=1e-9)


@pytest.mark.parametrize("shift", [0.5, 1000.0])
def test_measured_by_the_speed_of_the_flow_particles_shift_whatever_their_own(shift):
    """As those do that move with a tenth of the sound speed, their largest shift too."""
    fields = particles(2, 0.3)
    still = drift_of(fields, 2, "sun", shift=shift)
    fields["velocity"] = np.tile([0.06 * C0, -0.08 * C0], (len(still), 1))
    np.testing.assert_array_equal(drift_of(fields, 2, "sun", shift=shift), still)
    np.testing.assert_allclose(still, drift_of(fields, 2, shift=shift), atol=1e-12)
    assert np.linalg.norm(still, axis=1).max() > (0.0499 * C0 if shift > 1 else 0.01)


@pytest.mark.parametrize("dim", [2, 3])
def test_spray_is_nothing_inside_and_at_a_flat_surface(dim):
    fields = particles(dim, 0.1)
    fields["mass"][:] = RHO0 * DX**dim
    fields["density"] = RHO0 * np.random.default_rng(3).uniform(0.99, 1.01, len(fields["density"]))
    found = {}
    for name in ("none", "pressureless"):
        rows, p = rates_of(fields, sweep_of(dim, spray=SPRAYS[name]))
        found[name] = p.density_rate[rows]
    change = found["pressureless"] - found["none"]
    place = fields["position"] / DX
    ends = np.sum((place < 2.6) | (place > np.array(CELLS[dim]) - 2.6), axis=1)
    assert (ends == 1).sum() > 20
    np.testing.assert_array_equal(change[ends <= 1], 0)
    np.testing.assert_allclose(
        change, -np.maximum(0, 1 - covering(fields, dim) / (0.5 * dim)) * C0 / H * (fields["density"] - RHO0), atol=1e-9
    )


@pytest.mark.parametrize("dim", CELLS)
@pytest.mark.parametrize("density", [990.0, 1000.0, 1015.0])
def test_a_lone_particle_of_spray_goes_to_the_reference_density(dim, density):
    fields = {"position": np.full((1, dim), 0.5), "density": np.array([density]), "mass": np.full(1, RHO0 * DX**dim)}
    rows, p = rates_of(fields, sweep_of(dim, spray=SPRAYS["pressureless"]))
    assert p.density_rate[rows][0] == pytest.approx(-C0 / H * (density - RHO0), rel=1e-12, abs=1e-12)


# --- density filters -----------------------------------------------------------------------------------------------


def filtered(fields, dim, law):
    sweep = sweep_of(dim)
    rows, p = rates_of(fields, sweep, DensityFilter(sweep, FILTERS[law], 1))
    return p.field("density", rows)


@pytest.mark.parametrize("dim", CELLS)
def test_the_plain_filter_is_the_sum_over_all_pairs(dim):
    fields = particles(dim)
    apart = np.linalg.norm(fields["position"][:, None] - fields["position"], axis=2)
    expected = (fields["mass"] * WENDLAND.value(apart, H, dim)).sum(axis=1)
    np.testing.assert_allclose(filtered(fields, dim, "plain"), expected, rtol=1e-12)
    assert expected.min() < 0.8 * RHO0 < expected.max()


@pytest.mark.parametrize("dim", CELLS)
@pytest.mark.parametrize("law", ["shepard", "mls"])
def test_uniform_densities_stay_up_to_the_surface(dim, law):
    fields = particles(dim)
    fields["density"][:] = 1013.0
    np.testing.assert_allclose(filtered(fields, dim, law), 1013.0, rtol=1e-12)


@pytest.mark.parametrize("dim", CELLS)
def test_linear_densities_stay_with_mls_alone(dim):
    fields = particles(dim)
    linear_density(fields, dim)
    np.testing.assert_allclose(filtered(fields, dim, "mls"), fields["density"], rtol=1e-11)
    for law in ("shepard", "plain"):
        assert np.abs(filtered(fields, dim, law) - fields["density"]).max() > 0.1


@pytest.mark.parametrize("law", ["shepard", "mls"])
def test_a_lone_particle_and_a_row_keep_the_density_of_their_own(law):
    for count in (1, 5):
        position = np.stack([DX * np.arange(count), np.zeros(count)], axis=1)
        fields = {"position": position, "density": np.full(count, 1007.0), "mass": np.full(count, RHO0 * DX**2)}
        np.testing.assert_allclose(filtered(fields, 2, law), 1007.0, rtol=1e-12)


@pytest.mark.parametrize("every", [1, 4])
def test_densities_are_summed_anew_every_so_many_steps_only(every):
    simulation = build(load_scene(basin(numerics={"reinitialise": "mls", "reinitialise_every": every})))
    original, steps = simulation.density_filter, []

    class Counted:
        def __init__(self):
            self.every = original.every

        def __call__(self, *arguments):
            before = simulation.field("density")
            original(*arguments)
            steps.append(simulation.steps)
            assert (simulation.field("density") != before).any()

    simulation.density_filter = Counted()
    simulation.run()
    assert simulation.steps >= 12
    assert steps == list(range(every, simulation.steps + 1, every))


# --- settling ------------------------------------------------------------------------------------------------------


def test_a_scene_that_settles_begins_at_zero_and_at_rest():
    """On a slope, where the block fits no lattice; a wall that swings begins with t = 0 too."""
    keys = basin(fluid={"blocks": [{"points": [[0.0, 0.0], [0.5, 0.2], [0.5, 0.4], [0.0, 0.4]]}], "level": 0.4})
    motion = {"way": [0.05, 0.0], "period": 0.5}
    keys["walls"] = {
        "polygons": [
            {"points": [[0.0, 0.5], [0.0, 0.0], [0.5, 0.2], [0.5, 0.5]], "fluid": "left"},
            {
                "name": "flap",
                "points": [[0.1, 0.25], [0.3, 0.25], [0.3, 0.45], [0.1, 0.45]],
                "fluid": "outside",
                "motion": motion,
            },
        ]
    }
    keys["time"] = {"end": 0.02, "settle": 0.05}
    keys["gauges"] = [{"kind": kind, "every": 0.01, **more} for kind, more in GAUGES.items()]
    simulation = build(load_scene(keys))
    start = np.sort(simulation.field("position"), axis=0)
    probe = Probe(0.01, lambda now: (np.abs(now.field("velocity")).max(), now.domain.ghosts.wall.any()))
    simulation.observers.append(probe)
    simulation.prepare()
    assert simulation.time == 0
    assert simulation.steps > 10
    assert not simulation.field("velocity").any()
    assert np.abs(np.sort(simulation.field("position"), axis=0) - start).max() > 1e-4 * DX
    while simulation.time < simulation.end:
        simulation.advance()
    assert [time for time, _ in probe.seen] == [0.0, 0.01, 0.02]
    assert probe.seen[0][1][0] == 0
    assert probe.seen[-1][1][0] > 0
    for gauge in simulation.observers[:-1]:
        np.testing.assert_array_equal(gauge.record()[:, 0], [0.0, 0.01, 0.02])


GAUGES = {
    "energy": {},
    "level": {"x": 0.4},
    "pressure": {"point": [0.0, 0.1], "extent": [0.0, 0.05]},
    "force": {"wall": "flap"},
}


def test_settling_makes_the_beginning_calmer():
    """The same block with and without: the largest acceleration at t = 0."""
    pulls = {}
    for settle in (0.0, 0.15):
        keys = basin(fluid={"blocks": [{"points": [[0.0, 0.0], [0.5, 0.2], [0.5, 0.4], [0.0, 0.4]]}], "level": 0.4})
        keys["walls"] = {"polygons": [{"points": [[0.0, 0.5], [0.0, 0.0], [0.5, 0.2], [0.5, 0.5]]}]}
        keys["time"] = {"end": 0.02, "settle": settle}
        simulation = build(load_scene(keys))
        simulation.prepare()
        pulls[settle] = np.sqrt((simulation.particles.acceleration[simulation.particles.fluid] ** 2).mean())
    assert pulls[0.15] < 0.5 * pulls[0.0]


# --- hard inputs ---------------------------------------------------------------------------------------------------

TIP = {"name": "tip", "points": [[2.0, 0.5], [2.6, 0.2], [2.6, 0.8]], "fluid": "outside"}
DAM = {
    "numerics.dx": DX,
    "numerics.c0": 30.0,
    "domain.size": [3.22, 1.6],
    "walls.polygons": [
        {"name": "tank", "points": [[0.0, 1.6], [0.0, 0.0], [3.22, 0.0]]},
        {"name": "wall", "points": [[3.22, 0.0], [3.22, 1.6]]},
    ],
    "fluid.level": 0.4,
    "fluid.blocks": [{"low": [0.0, 0.0], "high": [0.5, 0.4]}],
    "gauges": [],
    "time.end": 0.2,
}


def dam(*blocks, polygons=(), **keys):
    """Return a scene: a low dam break, with other blocks of water and walls."""
    more = {"fluid.blocks": [*DAM["fluid.blocks"], *blocks], "walls.polygons": [*DAM["walls.polygons"], *polygons]}
    return load_scene("dam-break-small", {**DAM, **more, **keys})


def block(left, bottom, across=1, up=1):
    return {"low": [left, bottom], "high": [left + across * DX, bottom + up * DX]}


def survives(scene, velocity=None, thrown=0):
    """Run a scene whose last `thrown` particles begin with a velocity; nobody is lost, densities stay in range, nobody is
    behind a wall at the end.
    """
    simulation = build(scene)
    p = simulation.particles
    count = len(p.fluid)
    if thrown:
        p.shared[p.fluid[p.tags[p.fluid] >= count - thrown], 2:4] = velocity
    range_seen = Probe(0.01, lambda now: (now.field("density").min(), now.field("density").max()))
    simulation.observers.append(range_seen)
    simulation.run()
    np.testing.assert_array_equal(np.sort(simulation.field("id")), np.arange(count))
    low, high = (factor * simulation.state.rho0 for factor in scene.density_range)
    seen = np.array([values for _, values in range_seen.seen])
    assert low < seen.min() <= seen.max() < high
    assert np.isfinite(simulation.field("velocity")).all()
    return simulation


def not_behind(simulation, slack=1e-9):
    """No particle is in a solid."""
    import shapely

    from parsph.scene.solids import boundaries_of

    position = simulation.field("position")
    for boundary, _ in boundaries_of(simulation.scene):
        inner = boundary.solid.buffer(-slack)
        assert not shapely.contains_xy(inner, *position.T).any()


THROWS = {
    "at a wall": ((3.0, 1.0), (3.0, 0.0), ()),
    "at a wall, slanting": ((3.0, 1.0), (2.1, -2.1), ()),
    "at the bed": ((2.0, 0.25), (0.0, -3.0), ()),
    "into a corner": ((3.0, 0.17), (2.12, -2.12), ()),
    "into a corner along the bed": ((3.0, 0.0), (3.0, 0.0), ()),
    "at the tip of an obstacle": ((1.7, 0.475), (3.0, 0.0), (TIP,)),
    "a hair above the tip of an obstacle": ((1.7, 0.476), (3.0, 0.0), (TIP,)),
    "at the upper corner of an obstacle": ((2.4, 1.0), (2.0, -2.2), (TIP,)),
    "between an obstacle and a wall": ((2.75, 0.3), (3.0, 0.0), (TIP,)),
}


@pytest.mark.parametrize("case", THROWS)
def test_a_lone_particle_thrown_at_a_wall_comes_to_no_harm(case):
    place, velocity, polygons = THROWS[case]
    scene = dam(block(*place), polygons=polygons)
    simulation = survives(scene, velocity, 1)
    simulation.scene = scene
    not_behind(simulation)


@pytest.mark.parametrize("thickness", [1, 2])
@pytest.mark.parametrize("speed", [0.0, 3.0])
def test_a_film_slides_down_a_wall(thickness, speed):
    scene = dam(block(0.0, 0.9, thickness, 10))
    simulation = survives(scene, (0.0, -speed), 10 * thickness)
    simulation.scene = scene
    not_behind(simulation)
    ids = simulation.field("id")
    film = simulation.field("position")[ids >= 80]
    falls = 0.2 * speed + 0.5 * 9.81 * 0.2**2
    if speed == 0:  # it falls freely along a wall of free slip
        assert film[:, 1].mean() == pytest.approx(0.9 + 5 * DX - falls, abs=DX)


@pytest.mark.parametrize("across", [2, 3])
@pytest.mark.parametrize("lean", [0.0, 0.3])
def test_a_gap_narrower_than_the_support_holds_its_water(across, lean):
    """Between two vertical or leaning walls over a bed: it stays, about as high as it was."""
    width = across * DX * math.hypot(1, lean / 0.8) * (1 + 1e-6)
    walls = [[0.1, 0.9], [0.1 + lean, 0.1], [0.1 + lean + width, 0.1], [0.1 + width, 0.9]]
    top = [[0.1 + 0.5 * lean, 0.5], [0.1 + 0.5 * lean + width, 0.5]]
    keys = {
        "domain": {"size": [1.0, 1.0]},
        "fluid": {"blocks": [{"points": [walls[1], walls[2], top[1], top[0]]}]},
        "walls": {"polygons": [{"points": walls}]},
        "numerics": {"dx": DX, "h_over_dx": 1.5, "diffusion": "antuono", "viscosity": "monaghan", "spray": "pressureless"},
        "time": {"end": 0.2, "cfl": 0.3},
    }
    scene = load_scene(keys)
    start = build(scene).field("position")
    simulation = survives(scene)
    simulation.scene = scene
    not_behind(simulation)
    assert simulation.field("position")[:, 1].mean() == pytest.approx(start[:, 1].mean(), abs=0.5 * DX)
    assert simulation.field("position")[:, 1].max() < 0.5 + 2 * DX


def test_the_energy_of_a_dam_break_does_not_grow():
    """At cfl 0.3, from one sample to the next by no more than 1e-4 of what there was at the beginning."""
    gauges = [{"kind": "energy", "every": 0.01}]
    scene = dam(**{"time.end": 1.0, "gauges": gauges, "fluid.blocks": [{"low": [0.0, 0.0], "high": [1.2, 0.6]}]})
    assert scene.cfl == 0.3
    simulation = build(scene)
    simulation.run()
    energy = simulation.observers[0].record()[:, 2:5].sum(axis=1)
    assert len(energy) == 101
    assert np.diff(energy).max() < 1e-4 * energy[0]
    assert energy[-1] < energy[0]
