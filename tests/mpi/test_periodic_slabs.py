"""Periodic ends on slabs: what goes round them, copies beyond them, checkpoints and messages, against the whole on one rank."""

import numpy as np
import pytest
from helpers import domain_of, tank
from test_restart_slabs import assert_goes_on
from test_slabs import assert_same_run, rebuilt

import parsph.simulation
from parsph.columns import Grid
from parsph.io.checkpoints import Checkpoint, write_checkpoint
from parsph.parallel import Communicator
from parsph.particles import identities
from parsph.scene.build import build
from parsph.scene.forecast import forecast
from parsph.scene.load import load_scene
from parsph.walls import MirrorWall, PeriodicBorder

ENERGY = {"kind": "energy", "every": 0.005}
FREE = {
    "domain": {"size": [1.5, 0.5], "gravity": 0.0, "periodic": ["up", "x"]},
    "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [1.5, 0.5], "pressure": 1000.0}]},
    "numerics": {"dx": 0.05, "c0": 10.0, "viscosity": "newtonian", "nu": 0.05, "density_range": [0.2, 5.0]},
    "time": {"end": 0.08},
    "gauges": [ENERGY, *({"kind": "pressure", "point": [x, 0.0], "every": 0.01} for x in (0.0, 0.7, 1.45))],
}
BED = tank(
    domain={"size": [0.8, 0.3], "gravity": 9.81, "periodic": ["x"]},
    fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.8, 0.14]}]},
    walls={"bottom": {}, "exchange": True},
    numerics={"dx": 0.02, "diffusion": "fourtakas", "viscosity": "monaghan", "density_range": [0.5, 1.5]},
    time={"end": 0.055},
    gauges=[
        ENERGY,
        *({"kind": "level", "x": x, "every": 0.005} for x in (0.0, 0.4, 0.79)),
        {"kind": "pressure", "point": [0.8, 0.0], "extent": [0.0, 0.05], "every": 0.005},
        {"kind": "force", "wall": "bottom", "every": 0.005},
    ],
)
SHALLOW = {
    "walls": {},
    "damping": [],
    "domain": {"size": [30.0], "periodic": ["x"]},
    "fluid.blocks": [{"low": [0.0], "high": [30.0], "depth": 1.0}],
    "time.end": 1.75,
    "output.snapshots.every": 1.0,
    "gauges": [{"kind": "energy", "every": 0.1}, *({"kind": "level", "x": x, "every": 0.1} for x in (0.0, 15.0, 29.9))],
}


def scene(name):
    """Return one of the scenes: its name and, behind a comma, the integrator."""
    kind, _, integrator = name.partition(", ")
    overrides = {"numerics.integrator": integrator} if integrator else {}
    return load_scene(*{"free": (FREE, overrides), "bed": (BED, overrides), "shallow": ("swe-pulse", SHALLOW)}[kind])


SPEEDS = {  # along x, and in any direction [m/s]
    "free, verlet": (30.0, 2.0),
    "free, midpoint": (-30.0, 2.0),
    "free, adams-bashforth": (30.0, 2.0),
    "bed, verlet": (25.0, 0.3),
    "shallow": (-30.0, 0.5),
}


def flowing(simulation, speeds):
    """Let the fluid flow along x, each particle with a velocity of its own added."""
    p = simulation.particles
    rows, (along, other) = p.fluid, speeds
    angle = 2.399963 * identities(p.tags[rows])
    velocity = other * np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, : p.layout.dim]
    velocity[:, 0] += along
    p.view("velocity")[rows] = velocity
    return simulation


def crowded(name, communicator):
    """Return a simulation of which the first rank has as much as it can, until cuts are moved."""
    right = build(scene(name), Communicator()).domain.end_columns()[1]
    columns, last = build(scene(name), Communicator()).domain.grid.columns, communicator.size - 1
    cuts = (0, *(columns - right - last + rank for rank in range(1, last + 1)), columns)
    return rebuilt(scene(name), communicator, cuts)


@pytest.mark.parametrize("name", SPEEDS)
def test_what_flows_round_is_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, name):
    """While cuts move; nobody is lost, and all have been round, half of them twice."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 5)
    mine = flowing(crowded(name, communicator), SPEEDS[name])
    alone = flowing(build(scene(name), Communicator()), SPEEDS[name])
    cuts, size = mine.domain.cuts, scene(name).domain.size[0]
    way = 0.0
    alone.prepare()
    while alone.time < alone.end:
        alone.advance()
        way += alone.last_dt * abs(alone.field("velocity")[:, 0]).min()
    mine.run()
    assert way > 1.5 * size, "not all particles have been round"
    assert mine.domain.cuts != cuts or communicator.size == 1
    assert_same_run(mine, alone)
    position = alone.field("position")[:, 0]
    assert ((position >= 0) & (position < size)).all()


def newcomers(simulation):
    """Return how many particles have come in at an end of x since the sort."""
    domain, rows = simulation.domain, simulation.particles.fluid
    columns = domain.slab.first + np.searchsorted(domain.column_bounds(), rows, side="right") - 1
    return int((np.abs(domain.grid.column_of(simulation.field("position")[:, 0]) - columns) > 1).sum())


def advanced(name, communicator, steps, checkpoint=None):
    """Return a simulation after so many steps, from the beginning or from a checkpoint."""
    simulation = build(scene(name), communicator, checkpoint=checkpoint)
    if checkpoint:
        checkpoint.restore(simulation)
    else:
        flowing(simulation, SPEEDS[name])
    simulation.prepare()
    while simulation.steps < steps:
        simulation.advance()
    return simulation


@pytest.mark.parametrize("name", SPEEDS)
def test_a_run_goes_on_to_the_same_bits_while_particles_go_round(communicator, monkeypatch, tmp_path, name):
    """From one rank to all and from all to one, from a moment when particles have come in, but not yet gone to their rank."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 10)
    alone, least = Communicator(), 5
    single = advanced(name, alone, least)
    while not newcomers(single):
        single.advance()
    step = single.steps
    mine = advanced(name, communicator, step)
    assert sum(communicator.allgather(newcomers(mine))) == newcomers(single)
    paths = tmp_path / "all.vtkhdf", tmp_path / f"single-{communicator.rank}.vtkhdf"
    write_checkpoint(paths[0], mine, "{}", {})
    write_checkpoint(paths[1], single, "{}", {})
    while single.steps < step + 30:
        single.advance()
    for path, ranks in zip(paths, (alone, communicator), strict=True):
        checkpoint = communicator.on_root(lambda path=path: Checkpoint(path))
        assert_goes_on(advanced(name, ranks, single.steps, checkpoint), single)


@pytest.mark.parametrize("dim", [2, 3])
def test_slab_with_copies_is_a_slice_of_the_whole(communicator, dim):
    """Corners of all axes and a wall included, of particles some of which have just left."""
    size, cell = (2.03, 0.47, 0.5)[:dim], 0.2
    grid = Grid.around((0.0,) * dim, size, cell)
    rng, count = np.random.default_rng(dim), 300 * dim
    fields = {"position": rng.uniform(0, 1, (count, dim)) * size, "velocity": rng.normal(0, 1, (count, dim))}
    wall = MirrorWall("bottom", (0.0,) * dim, (0.0,) * (dim - 1) + (1.0,), "hydrostatic", "free", 64)
    borders = [PeriodicBorder(axis, 0.0, size[axis], (1 << 2 * axis, 2 << 2 * axis)) for axis in range(dim - 1)]
    bands = [band for border in borders for band in border.bands(cell, dim)]
    assert len(bands) == 2 * (dim - 1)
    cuts = (0, *(3 + rank for rank in range(communicator.size - 1)), grid.columns)
    shared = {"walls": [wall], "reach": cell, "box": ((0.0,) * dim, size), "borders": borders}
    mine = domain_of(grid, fields, cuts=cuts, communicator=communicator, **shared)
    whole = domain_of(grid, fields, **shared)
    for way in (0.15, -0.12, 0.18):
        for domain in (mine, whole):
            p = domain.particles
            rows = p.fluid
            x = p.shared[rows, 0]
            p.shared[rows, 0] = x + np.where(identities(p.tags[rows]) % 3, way, -way)
            domain.arrange(0.0)
            domain.start_halo()
            domain.finish_halo()
        stride = grid.stride
        starts = whole.starts[mine.slab.first * stride : (mine.slab.last + 2) * stride + 1]
        np.testing.assert_array_equal(mine.starts, starts - starts[0])
        rows = whole.particles.shared[starts[0] : starts[-1]]
        np.testing.assert_array_equal(mine.particles.shared[: mine.starts[-1]], rows)
        own = slice(starts[0] + mine.particles.first, starts[0] + mine.particles.last)
        np.testing.assert_array_equal(
            mine.particles.tags[mine.particles.first : mine.particles.last], whole.particles.tags[own]
        )
    assert len(whole.particles.fluid) == count


def test_messages_round_the_ends_are_those_that_are_expected(communicator):
    """Two more an evaluation, of the first and of the last rank."""
    expected = forecast(scene("bed"), communicator.size)
    simulation = build(scene("bed"), communicator)
    simulation.prepare()
    exchange = simulation.domain.exchange
    messages, sent = exchange.messages, exchange.bytes
    for _ in range(5):
        simulation.step(simulation.longest_step())
    counts = np.array(communicator.allgather(((exchange.messages - messages) / 5, (exchange.bytes - sent) / 5)))
    assert (counts[:, 0].mean(), counts[:, 0].max()) == expected.messages
    assert (counts[:, 1].mean(), counts[:, 1].max()) == pytest.approx(expected.bytes, rel=0.1)
