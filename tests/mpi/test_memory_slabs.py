"""No rank holds more than its own share of the particles, while a scene is built, and while files are written and read.

Measured in bytes that numpy allocates: on all ranks, against the same on one.
"""

import tracemalloc

import numpy as np
import pytest
from helpers import tank
from test_slabs import gathered, rebuilt

from parsph.io import polydata, snapshots
from parsph.io.checkpoints import Checkpoint, write_checkpoint
from parsph.io.snapshots import write_snapshot
from parsph.parallel import Communicator
from parsph.scene import lattice
from parsph.scene.build import build, cuts_of, grid_of
from parsph.scene.load import load_scene
from parsph.scene.solids import fillings_of

SLACK = 500_000  # bytes: what does not grow with the particles
DX = 0.004
LONG = {"domain": {"size": [6.0, 0.4], "gravity": 9.81}, "numerics": {"dx": DX, "h_over_dx": 1.5}}
BOX = {"points": [[3.0, 0.1], [3.2, 0.1], [3.2, 0.2], [3.0, 0.2]], "fluid": "outside"}
SCENES = {
    "block": tank(**LONG, fluid={"blocks": [{"low": [0.0, 0.0], "high": [6.0, 0.2]}]}),
    "polygons": tank(
        **LONG,
        fluid={"level": 0.3, "blocks": [{"points": [[0.0, 0.0], [6.0, 0.0], [6.0, 0.25], [0.0, 0.3]]}]},
        walls={"left": {}, "right": {}, "bottom": {}, "polygons": [BOX]},
    ),
}
BEACH = tank(
    **LONG,
    fluid={"level": 0.3, "blocks": [{"points": [[0.0, 0.0], [4.0, 0.0], [6.0, 0.2], [6.0, 0.3], [0.0, 0.3]]}]},
    walls={"polygons": [{"points": [[0.0, 0.4], [0.0, 0.0], [4.0, 0.0], [6.0, 0.2], [6.0, 0.4]], "fluid": "left"}]},
)


def peak_of(action, *arguments):
    """Return the largest number of bytes allocated at a time inside a call, and what it returned."""
    tracemalloc.start()
    result = action(*arguments)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak, result


def share_of(simulation):
    """Return this rank's share of all particles."""
    counts = simulation.communicator.allgather(len(simulation.particles.fluid))
    return counts[simulation.communicator.rank] / sum(counts)


@pytest.fixture(params=SCENES)
def scene(request, monkeypatch):
    monkeypatch.setattr(lattice, "BLOCK", 1 << 12)
    monkeypatch.setattr(polydata, "PIECE", 1 << 16)
    return load_scene(SCENES[request.param])


def placed(scene, communicator, grid):
    """Return the positions of this rank's particles at the beginning."""
    cuts = cuts_of(scene, communicator.size, communicator)
    (filling,) = fillings_of(scene, communicator)
    return filling.between(grid, *cuts[communicator.rank : communicator.rank + 2])[1]


def test_placing_particles_takes_a_share_of_the_memory_of_one_rank(communicator, scene):
    grid, _ = grid_of(scene)
    whole, alone = peak_of(placed, scene, Communicator(), grid)
    assert whole > alone.nbytes > 2 * SLACK, "all positions would be seen"
    peak, mine = peak_of(placed, scene, communicator, grid)
    assert peak < len(mine) / len(alone) * whole + SLACK


def test_building_takes_a_share_of_the_memory_of_one_rank(communicator, scene):
    whole, alone = peak_of(build, scene, Communicator())
    count = len(alone.particles.fluid)
    assert whole > 200 * count > 10_000_000
    del alone
    peak, mine = peak_of(build, scene, communicator)
    share = share_of(mine)
    assert share < 1.1 / communicator.size
    assert peak < share * whole + SLACK


def test_files_are_written_with_a_share_of_the_memory(communicator, scene, tmp_path):
    """One copy of one field of the own particles, and a piece of what others have."""
    mine = build(scene, communicator)
    mine.domain.arrange(0.0)
    count, share = sum(communicator.allgather(len(mine.particles.fluid))), share_of(mine)
    path = tmp_path / "0.vtkhdf"
    snapshot, _ = peak_of(write_snapshot, path, mine, "{}", "float64")
    checkpoint, _ = peak_of(write_checkpoint, path, mine, "{}", {})
    field = (3 + 2 + 2) * 8 * count  # of three components, the two that it has, and rows and their places
    assert snapshot < share * field + SLACK
    assert checkpoint < share * field + SLACK
    found = communicator.on_root(lambda: Checkpoint(path))
    reading, _ = peak_of(lambda: build(scene, communicator, checkpoint=found))
    whole, _ = peak_of(lambda: build(scene, Communicator(), checkpoint=found))
    assert reading < share * whole + SLACK


def test_rank_0_writes_a_bounded_piece_at_a_time_where_another_rank_has_all(communicator, tmp_path, monkeypatch):
    monkeypatch.setattr(polydata, "PIECE", 1 << 16)
    keys = {**SCENES["block"], "fluid": {"blocks": [{"low": [4.0, 0.0], "high": [6.0, 0.2]}], "level": 0.2}}
    scene = load_scene(keys)
    columns, size = build(scene, Communicator()).domain.grid.columns, communicator.size
    cuts = (0, *(100 + rank for rank in range(size - 1)), columns)
    mine = rebuilt(scene, communicator, cuts)
    mine.domain.arrange(0.0)
    counts = communicator.allgather(len(mine.particles.fluid))
    assert counts[:-1] == [0] * (size - 1)
    for name, write in (
        ("s", lambda path: write_snapshot(path, mine, "{}", "float64")),
        ("c", lambda path: write_checkpoint(path, mine, "{}", {})),
    ):
        peak, _ = peak_of(write, tmp_path / f"{name}.vtkhdf")
        assert counts[communicator.rank] or peak < SLACK < 24 * counts[-1]
    found = communicator.on_root(lambda: Checkpoint(tmp_path / "c.vtkhdf"))
    found.examine(communicator)
    again = build(scene, communicator, checkpoint=found)
    for name in ("id", "position", "mass"):
        np.testing.assert_array_equal(gathered(again, name), gathered(mine, name))


def test_a_polygon_is_filled_alike_on_all_ranks(communicator, monkeypatch):
    """Ids, places and counts per column; in blocks of a few lines, with lines moved across borders of columns."""
    scene = load_scene(BEACH)
    grid = build(scene, Communicator()).domain.grid
    (whole,) = fillings_of(scene)
    assert isinstance(whole, lattice.Filling)
    ids, places = whole.between(grid, 0, grid.columns)
    np.testing.assert_array_equal(ids, np.arange(whole.count))
    counts = whole.column_counts(grid)
    np.testing.assert_array_equal(counts, np.bincount(grid.column_of(places[:, 0]), minlength=grid.columns))
    monkeypatch.setattr(lattice, "BLOCK", 500)
    (mine,) = fillings_of(scene, communicator)
    np.testing.assert_array_equal(mine.column_counts(grid), counts)
    cuts = cuts_of(scene, communicator.size, communicator)
    own = slice(*cuts[communicator.rank : communicator.rank + 2])
    columns = grid.column_of(places[:, 0])
    chosen = (columns >= own.start) & (columns < own.stop)
    for found, expected in zip(mine.between(grid, own.start, own.stop), (ids, places), strict=True):
        np.testing.assert_array_equal(found, expected[chosen])
    assert mine.count == whole.count


def test_rank_0_alone_keeps_the_list_of_snapshots_and_writes_the_series(communicator, tmp_path, monkeypatch):
    """Also of a run that goes on, of which all ranks know how many there are."""
    keys = {"time": {"end": 0.002}, "output": {"snapshots": {"every": 0.001}}}
    scene = load_scene(tank(**keys))
    build(scene, communicator, folder=tmp_path).run()
    later = build(scene, communicator, folder=tmp_path)
    later.time, later.steps = 0.002, 5
    (writer,) = [observer for observer in later.observers if isinstance(observer, snapshots.SnapshotWriter)]
    seen = []
    monkeypatch.setattr(snapshots, "write_series", lambda folder, found, parts: seen.append(len(found)) or parts)
    writer.begin(later)
    writer.close()
    assert writer.count == 3
    assert seen == ([3] if communicator.rank == 0 else [])
