"""Slabs against the whole: each rank builds the same global state, and compares its part with the slice of that."""

import h5py
import numpy as np
import pytest
from helpers import domain_of, tank, water

import parsph.simulation
from parsph.columns import Grid
from parsph.domain import balanced_cuts
from parsph.domain.domain import end_columns
from parsph.errors import ParsphError, SceneError
from parsph.io.snapshots import POINT_DATA, write_snapshot
from parsph.kernels import KERNELS
from parsph.parallel import Communicator
from parsph.scene.build import build, grid_of
from parsph.scene.load import load_scene
from parsph.sweep import Sweep
from parsph.terms import DIFFUSIONS, VISCOSITIES, Terms
from parsph.walls import MirrorWall

SIZE, CELL, GRAVITY = (2.0, 0.7), 0.1, (0.0, -9.81)
GRID = Grid.around((0.0, 0.0), SIZE, CELL)


def fields(seed=1, count=800):
    """Random particles, the same on every rank."""
    rng = np.random.default_rng(seed)
    density = rng.uniform(990, 1010, count)
    return {
        "position": rng.uniform(0.01, 0.99, (count, 2)) * SIZE,
        "velocity": rng.normal(0, 1, (count, 2)),
        "density": density,
        "pressure": water().pressure(density),
        "mass": rng.uniform(1, 2, count),
    }


def walls():
    sides = (((0.0, 0.0), (1.0, 0.0)), (SIZE, (-1.0, 0.0)), ((0.0, 0.0), (0.0, 1.0)))
    return [MirrorWall("wall", point, n, "hydrostatic", "free", 1 << k) for k, (point, n) in enumerate(sides)]


def pair(communicator, particles):
    """Return (the slab of this rank, the whole on this rank alone) of the same particles between walls."""
    reach = 0.99 * CELL
    left, right = end_columns(GRID, [wall.band(reach, SIZE[-1]) for wall in walls()])
    cuts = balanced_cuts(np.ones(GRID.columns), communicator.size, left, right)
    shared = {"gravity": GRAVITY, "reach": reach, "box": ((0.0, 0.0), SIZE)}
    mine = domain_of(GRID, particles, walls(), cuts=cuts, communicator=communicator, **shared)
    return mine, domain_of(GRID, particles, walls(), **shared)


def test_slab_with_its_halos_is_a_slice_of_the_whole(communicator):
    """Rows, their order and the cell starts: what a neighbour sent lies where the whole has it."""
    mine, whole = pair(communicator, fields())
    mine.arrange(0.0)
    whole.arrange(0.0)
    mine.start_halo()
    mine.finish_halo()
    stride, slab, p = GRID.stride, mine.slab, mine.particles
    # local column 0 is the one before the slab; the whole has one column before the grid's first as well
    starts = whole.starts[slab.first * stride : (slab.last + 2) * stride + 1]
    np.testing.assert_array_equal(mine.starts, starts - starts[0])
    rows = whole.particles.shared[starts[0] : starts[-1]]
    np.testing.assert_array_equal(p.shared[: mine.starts[-1]], rows)
    own = slice(starts[0] + p.first, starts[0] + p.last)
    np.testing.assert_array_equal(p.tags[p.first : p.last], whole.particles.tags[own])
    assert p.last - p.first > 0


@pytest.mark.parametrize("single", [False, True], ids=["float64", "float32"])
def test_rates_are_those_of_the_whole_to_the_bit(communicator, single):
    mine, whole = pair(communicator, fields(2))
    terms = Terms(viscosity=VISCOSITIES["monaghan"], diffusion=DIFFUSIONS["fourtakas"])
    sweep = Sweep(KERNELS["wendland-c2"], terms, 2, 0.49 * CELL, 1000.0, 20.0, GRAVITY, 0.1, 0.1, 0.0, single)
    for domain in (mine, whole):
        domain.arrange(0.0)
        domain.start_halo()
        domain.finish_halo()
        sweep(domain.particles, domain.starts, domain.slab, 1, domain.slab.columns + 1)
    p, q = mine.particles, whole.particles
    same = np.isin(q.tags[q.fluid], p.tags[p.fluid])
    np.testing.assert_array_equal(p.tags[p.fluid], q.tags[q.fluid][same])
    np.testing.assert_array_equal(p.acceleration[p.fluid], q.acceleration[q.fluid][same])
    np.testing.assert_array_equal(p.density_rate[p.fluid], q.density_rate[q.fluid][same])


def test_migration_keeps_every_particle_exactly_once(communicator):
    """Particles wander by up to a column a time; each is then on one rank, in its slab, with all its fields."""
    particles = fields(3)
    mine, _ = pair(communicator, particles)
    p, rng = mine.particles, np.random.default_rng(4)
    where = particles["position"].copy()
    moved = 0
    for _ in range(15):
        where = np.clip(where + rng.uniform(-0.09, 0.09, where.shape), 0.001, np.array(SIZE) - 0.001)
        p.shared[p.fluid, :2] = where[p.tags[p.fluid]]
        before = set(p.tags[p.fluid])
        mine.arrange(0.0)
        rows = p.fluid
        ids = p.tags[rows]
        moved += len(set(ids) - before)
        everyone = np.concatenate(communicator.allgather(ids))
        np.testing.assert_array_equal(np.sort(everyone), np.arange(len(where)))
        columns = GRID.column_of(p.field("position", rows)[:, 0])
        assert ((columns >= mine.slab.first) & (columns < mine.slab.last)).all()
        np.testing.assert_array_equal(p.field("position", rows), where[ids])
        for name in ("velocity", "density", "mass"):
            np.testing.assert_array_equal(p.field(name, rows), particles[name][ids])
    assert sum(communicator.allgather(moved)) > 50 or communicator.size == 1


def test_a_particle_that_jumps_over_a_slab_is_lost_with_its_name(communicator):
    if communicator.size < 3:
        pytest.skip("it takes three ranks to jump over one")
    mine, _ = pair(communicator, fields(5))
    p = mine.particles
    if communicator.rank == 0:
        p.shared[p.fluid[0], 0] = SIZE[0] - 0.01
        number = int(p.tags[p.fluid[0]])
    number = communicator.broadcast(number if communicator.rank == 0 else None)
    caught = None
    try:
        mine._migrate(mine._assign())
    except ParsphError as error:
        caught = str(error)
    told = [text for text in communicator.allgather(caught) if text]
    assert len(told) == 1
    assert f"particle {number} crossed a whole slab" in told[0]


@pytest.mark.parametrize("ranks", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("seed", range(4))
def test_cuts_are_monotone_keep_the_end_columns_and_share_the_cost(ranks, seed):
    rng = np.random.default_rng(seed)
    cost = rng.integers(0, 50, 40).astype(float) * (rng.uniform(size=40) > 0.3)
    left, right = rng.integers(1, 5, 2)
    cuts = balanced_cuts(cost, ranks, left, right)
    assert (cuts[0], cuts[-1], len(cuts)) == (0, 40, ranks + 1)
    assert (np.diff(cuts) >= 1).all()
    if ranks > 1:
        assert cuts[1] >= left
        assert cuts[-2] <= 40 - right
    if ranks <= 3:  # with few ranks no end column binds: nobody is over the mean by more than a column
        assert np.add.reduceat(cost, cuts[:-1]).max() <= cost.sum() / ranks + cost.max() + cost[:left].sum()


def test_cuts_move_at_most_to_the_next_old_one():
    """So that particles only ever go to a neighbour."""
    old = (0, 10, 20, 30, 40)
    for cost in (np.eye(40)[2], np.eye(40)[38], np.ones(40)):
        cuts = balanced_cuts(cost, 4, 2, 2, old=old)
        assert (np.diff(cuts) >= 1).all()
        for rank in (1, 2, 3):
            assert old[rank - 1] < cuts[rank] < old[rank + 1]


def test_cuts_without_cost_still_give_everyone_a_column():
    assert (np.diff(balanced_cuts(np.zeros(12), 5)) >= 1).all()


def test_too_many_ranks_say_how_many_would_do():
    most = 10 - 2 - 3 + 2
    assert len(balanced_cuts(np.ones(10), most, 2, 3)) == most + 1
    with pytest.raises(SceneError, match=f"too many ranks: 9 for 10 columns.*at most {most} ranks") as caught:
        balanced_cuts(np.ones(10), 9, 2, 3)
    assert caught.value.exit_code == 2


def collapse(end=0.04):
    """Water at one end of a long domain: most ranks begin without any."""
    keys = tank(
        domain={"size": [1.0, 0.3], "gravity": 9.81},
        fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.1, 0.2]}]},
        numerics={"dx": 0.01, "diffusion": "fourtakas", "viscosity": "monaghan", "alpha": 0.3},
        time={"end": end},
        gauges=[{"kind": "level", "x": 0.05, "every": 0.005}, {"kind": "energy", "every": 0.005}],
    )
    return load_scene(keys)


def run(scene, communicator, folder=None):
    simulation = build(scene, communicator, folder)
    simulation.run()
    return simulation


def skewed_cuts(communicator):
    """Return cuts of `collapse` that leave all ranks but the first without water."""
    columns, last = grid_of(collapse())[0].columns, communicator.size - 1
    return (0, *(columns - 3 - last + rank for rank in range(1, last + 1)), columns)


def rebuilt(scene, communicator, cuts):
    """Build a scene with the given cuts, which stay until cuts are moved for the first time."""
    import parsph.scene.build as building

    original = building.balanced_cuts
    building.balanced_cuts = lambda *_, **__: tuple(cuts)
    try:
        simulation = building.build(scene, communicator)
        simulation.share_columns = lambda: None
        return simulation
    finally:
        building.balanced_cuts = original


def gathered(simulation, name):
    """Return a field of all ranks, on all of them, in rank order."""
    return np.concatenate(simulation.communicator.allgather(simulation.field(name)))


def assert_same_run(mine, alone):
    assert (mine.steps, mine.time, mine.last_dt) == (alone.steps, alone.time, alone.last_dt)
    for name in ("id", "position", "velocity", "density", "pressure"):
        np.testing.assert_array_equal(gathered(mine, name), alone.field(name), err_msg=name)
    if mine.communicator.rank == 0:
        for one, other in zip(mine.observers, alone.observers, strict=True):
            np.testing.assert_array_equal(one.record(), other.record())


def test_moving_cuts_lose_nobody_and_change_no_bit(communicator, monkeypatch):
    """All water begins on the first rank; balanced every five steps, it comes to others while it runs along the bed."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 5)
    mine = rebuilt(collapse(0.05), communicator, skewed_cuts(communicator))
    mine.run()
    if communicator.size > 1:
        assert sum(count > 0 for count in communicator.allgather(len(mine.particles.fluid))) > 1
        assert mine.domain.cuts != skewed_cuts(communicator)
    np.testing.assert_array_equal(np.sort(gathered(mine, "id")), np.arange(200))
    assert_same_run(mine, run(collapse(0.05), Communicator()))


GAUGES = [{"kind": "energy", "every": 0.25, "name": "all"}]
# The right layer begins close to the plate, so that something moves in it; a killing function at the plate would let
# the water through.
LAYERS = [
    {"side": "left", "length": 0.9, "sigma0": 2.0, "density": "matched", "switch": "fx-vx"},
    {"side": "right", "length": 11.2, "density": "matched", "switch": "fx-vx", "killing": "f1"},
]
SCENES = {
    "dam break: summation and a growing h": (
        "swe-dam-break",
        {"time.end": 40.0, "gauges": [*GAUGES, {"kind": "level", "x": 510.0, "every": 2.5}]},
    ),
    "pulse in a layer that damps the depth": (
        "swe-pulse",
        {
            "time.end": 8.0,
            "fluid.blocks.0.center": 490.0,
            "gauges": [*GAUGES, {"kind": "level", "x": 500.0, "every": 0.5}, {"kind": "level", "x": 549.9, "every": 0.5}],
        },
    ),
    "pool with layers at both ends, matched density, switch and killing": (
        "pool",
        {
            "time.end": 0.3,
            "numerics.dx": 0.1,
            "wavemaker.wave.ramp": 0.0,
            "damping": LAYERS,
            "gauges": [{"kind": "energy", "every": 0.05}, {"kind": "level", "x": 1.0, "every": 0.05}],
        },
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_layers_and_shallow_water_are_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, name):
    """Nearly all begins on the first rank, and cuts move through the layers; masses too, which layers change."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 20)
    source, overrides = SCENES[name]
    scene = load_scene(source, overrides)
    domain, last = build(scene, Communicator()).domain, communicator.size - 1
    columns, (_, right) = domain.grid.columns, domain.end_columns()
    cuts = (0, *(columns - right - last + rank for rank in range(1, last + 1)), columns)
    mine = rebuilt(scene, communicator, cuts)
    assert mine.domain.cuts == cuts
    mine.run()
    assert mine.domain.cuts != cuts or communicator.size == 1
    alone = run(scene, Communicator())
    assert_same_run(mine, alone)
    np.testing.assert_array_equal(gathered(mine, "mass"), alone.field("mass"))
    if scene.damping:
        bare = run(load_scene(source, {**overrides, "damping": []}), Communicator())
        assert np.abs(np.sort(bare.field("velocity")[:, 0]) - np.sort(alone.field("velocity")[:, 0])).max() > 1e-4
        assert np.ptp(alone.observers[0].record()[:, 1]) > 0, "mass of water that is damped"
    assert alone.observers[0].record().shape[0] > 6


def test_ranks_without_particles_take_part(communicator, monkeypatch):
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 1000)
    mine = rebuilt(collapse(), communicator, skewed_cuts(communicator))
    mine.run()
    counts = communicator.allgather(len(mine.particles.fluid))
    assert counts[0] == 200
    assert not any(counts[1:])
    assert_same_run(mine, run(collapse(), Communicator()))


def test_snapshot_of_all_ranks_is_that_of_one(communicator, tmp_path):
    """Through parallel HDF5 where h5py has it, through rank 0 where not; a rank without particles included."""
    scenes = load_scene(tank()), collapse()
    runs = build(scenes[0], communicator), rebuilt(scenes[1], communicator, skewed_cuts(communicator))
    for number, (scene, mine) in enumerate(zip(scenes, runs, strict=True)):
        mine.prepare()
        alone = build(scene, Communicator())
        alone.prepare()
        together, single = tmp_path / f"{number}-all.vtkhdf", tmp_path / f"{number}-{communicator.rank}.vtkhdf"
        write_snapshot(together, mine, "{}", "float64")
        write_snapshot(single, alone, "{}", "float64")
        with h5py.File(together) as a, h5py.File(single) as b:
            assert len(a["VTKHDF/NumberOfPoints"]) == communicator.size == a["parsph"].attrs["ranks"]
            assert a["VTKHDF/NumberOfPoints"][:].sum() == b["VTKHDF/NumberOfPoints"][0]
            for name in ("Points", *(f"PointData/{name}" for name in POINT_DATA)):
                np.testing.assert_array_equal(a["VTKHDF"][name], b["VTKHDF"][name], err_msg=name)


def test_an_error_on_the_root_is_raised_on_all(communicator):
    def fail():
        raise SceneError("no room", where="--out", cure="make some")

    with pytest.raises(SceneError, match="--out: no room; make some"):
        communicator.on_root(fail)
    assert communicator.on_root(lambda: 7) == 7


def test_minimum_and_stack_are_over_all_ranks(communicator):
    assert communicator.minimum(float(communicator.rank + 1)) == 1
    rows = communicator.stack(np.full((communicator.rank, 2), communicator.rank))
    expected = np.repeat(np.arange(communicator.size), np.arange(communicator.size)) if communicator.rank == 0 else []
    np.testing.assert_array_equal(rows[:, 0], expected)
