"""Polygon walls on slabs: every rank runs the whole scene alone too, and compares all bits."""

import numpy as np
import pytest
from test_slabs import assert_same_run, gathered, rebuilt, run

import parsph.simulation
from parsph.parallel import Communicator
from parsph.scene.build import build, grid_of
from parsph.scene.load import load_scene
from parsph.walls import INTERPOLATORS

DX = 0.04
TANK = {"name": "tank", "points": [[0.0, 0.5], [0.0, 0.0], [0.7, 0.0], [1.0, 0.2], [1.0, 0.5]]}
WEDGE = {"name": "wedge", "points": [[0.36, 0.0], [0.62, 0.0], [0.49, 0.2]], "fluid": "outside"}
MOTION = {"way": [0.05, 0.01], "angle": 20.0, "center": [0.55, 0.25], "period": 0.1, "ramp": 0.02}
FLAP = {
    "name": "flap",
    "points": [[0.48, 0.19], [0.62, 0.19], [0.62, 0.33], [0.48, 0.33]],
    "fluid": "outside",
    "motion": MOTION,
}
GAUGES = [
    {"kind": "pressure", "point": [0.5, 0.1], "extent": [0.4, 0.1], "every": 0.005},
    {"kind": "pressure", "point": [0.0, 0.06], "extent": [0.0, 0.1], "every": 0.005},
    {"kind": "force", "wall": "tank", "every": 0.005},
    {"kind": "energy", "every": 0.005},
    {"kind": "runup", "wall": "tank", "x": 0.0, "every": 0.005},
    {"kind": "runup", "wall": "tank", "x": 1.0, "every": 0.005},
]
STRENGTHS = {"diffusion": "antuono", "viscosity": "monaghan", "alpha": 0.1, "spray": "pressureless"}


def scene(interpolation="hydrostatic", polygons=(TANK, WEDGE), numerics=None, time=None):
    """Return a scene whose water begins out of balance: a high column at the left, a low one at the right."""
    gauges = [*GAUGES, *({"kind": "force", "wall": wall["name"], "every": 0.005} for wall in polygons[1:])]
    keys = {
        "domain": {"size": [1.0, 0.5]},
        "fluid": {
            "blocks": [
                {"low": [0.0, 0.0], "high": [0.48, 0.4]},
                {"points": [[0.52, 0.08], [0.7, 0.0], [1.0, 0.2], [0.52, 0.2]]},
            ]
        },
        "walls": {"polygons": list(polygons), "interpolation": interpolation},
        "numerics": {"dx": DX, "h_over_dx": 1.5, "density_range": [0.5, 1.5], **STRENGTHS, **(numerics or {})},
        "time": {"end": 0.03, "cfl": 0.3, **(time or {})},
        "gauges": gauges,
    }
    return load_scene(keys)


ALL_TERMS = {
    "tensile_control": "sun",
    "shifting": "lind",
    "reinitialise": "mls",
    "reinitialise_every": 7,
}
SCENES = {
    **{name: {"interpolation": name} for name in INTERPOLATORS},
    "all terms": {"numerics": ALL_TERMS},
    "all terms, midpoint": {"numerics": {**ALL_TERMS, "integrator": "midpoint"}, "interpolation": "mls1"},
    "renormalised divergence": {"numerics": {"integrator": "adams-bashforth", "density": "renormalised"}},
    "float32": {"numerics": {"precision": "float32"}},
    "settled": {"time": {"settle": 0.01, "end": 0.02}},
}


def both(keys, communicator, cuts_at=0.4):
    """Return (all ranks' run, which begins with narrow slabs at the left, the run alone)."""
    columns = grid_of(keys)[0].columns
    first = round(cuts_at * columns)
    cuts = (0, *(first + 2 * rank for rank in range(communicator.size - 1)), columns)
    mine = rebuilt(keys, communicator, cuts)
    before = mine.domain.cuts
    mine.run()
    return mine, run(keys, Communicator()), before


def assert_same_walls(mine, alone):
    """What the walls did: methods and stopped particles."""
    comm = mine.communicator
    assert sum(comm.allgather(mine.domain.barrier.stopped)) == alone.domain.barrier.stopped
    used = np.sum(comm.allgather(mine.domain.ghosts.methods_used), axis=0)
    np.testing.assert_array_equal(used, alone.domain.ghosts.methods_used)


@pytest.mark.parametrize("name", SCENES)
def test_polygon_walls_are_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, name):
    """Fields, masses and gauges, while cuts move every ten steps."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 10)
    mine, alone, cuts = both(scene(**SCENES[name]), communicator)
    assert grid_of(scene())[0].columns >= 9
    assert alone.steps > 25
    assert mine.domain.cuts != cuts or communicator.size == 1
    assert_same_run(mine, alone)
    np.testing.assert_array_equal(gathered(mine, "mass"), alone.field("mass"))
    assert_same_walls(mine, alone)
    for gauge in (alone.observers[2], *alone.observers[4:6]):
        assert np.ptp(gauge.record()[:, 1]) > 0
    if communicator.rank == 0:
        assert all(len(gauge.record()) == round(alone.end / 0.005) + 1 for gauge in mine.observers)


@pytest.mark.parametrize("interpolation", ["hydrostatic", "mls2"])
def test_a_wall_that_swings_over_slab_borders_is_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, interpolation):
    """Its ghosts and mirror points change columns and owners while it runs, and cuts stay."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 1000)
    keys = scene(interpolation, (TANK, FLAP)).model_dump(exclude_unset=True)
    keys["fluid"] = {"blocks": [{"points": [[0.0, 0.0], [0.7, 0.0], [1.0, 0.2], [1.0, 0.28], [0.0, 0.28]]}]}
    keys["gauges"] += [
        {"kind": "runup", "wall": "flap", "x": 0.62, "every": 0.005},
        {"kind": "pressure", "wall": "flap", "point": [0.48, 0.22], "every": 0.005},
    ]
    keys = load_scene(keys)
    mine, alone, _ = both(keys, communicator, 0.5)
    ghosts, grid = alone.domain.ghosts, alone.domain.grid
    columns = [grid.column_of(ghosts._rest[name][:, 0]) for name in ("position", "mirror")]
    now = [grid.column_of(getattr(ghosts, name)[:, 0]) for name in ("position", "mirror")]
    borders = np.array(mine.domain.cuts[1:-1])
    for before, after in zip(columns, now, strict=True):
        assert (before != after).sum() >= 3
        if communicator.size > 1:
            assert (np.searchsorted(borders, before, "right") != np.searchsorted(borders, after, "right")).any()
    assert alone.steps > 25
    assert_same_run(mine, alone)
    assert_same_walls(mine, alone)
    assert all((np.ptp(gauge.record()[:, 1:], axis=0) > 0).all() for gauge in alone.observers[-2:])
    np.testing.assert_array_equal(mine.domain.ghosts.position, ghosts.position)


def test_values_of_ghosts_in_slabs_and_halos_are_those_of_the_whole(communicator):
    """Rows of ghosts, whoever interpolated them."""
    keys = scene("mls1")
    alone = build(keys, Communicator())
    alone.evaluate(0.0)
    columns = grid_of(keys)[0].columns
    for first in range(1, columns - 2 * communicator.size + 2):
        cuts = (0, *(first + 2 * rank for rank in range(communicator.size - 1)), columns)
        mine = rebuilt(keys, communicator, cuts)
        mine.evaluate(0.0)
        stride, slab, starts = mine.domain.grid.stride, mine.domain.slab, alone.domain.starts
        begin = starts[slab.first * stride]
        rows = alone.particles.shared[begin : starts[(slab.last + 2) * stride]]
        p, end = mine.particles, mine.domain.starts[-1]
        found = p.layout.place("density_gradient")  # what the evaluation found for the next one: halos get it then
        np.testing.assert_array_equal(p.shared[:end, :found], rows[:, :found])
        np.testing.assert_array_equal(p.shared[p.first : p.last], rows[p.first : p.last])
        if communicator.size == 1:
            break
