"""Corrected kernels and moments on slabs: every rank runs the whole scene alone too, and compares all bits."""

import h5py
import numpy as np
import pytest
from helpers import tank
from test_ghost_slabs import FLAP, TANK, assert_same_walls
from test_ghost_slabs import scene as polygons
from test_slabs import assert_same_run, gathered, rebuilt, run, skewed_cuts

import parsph.simulation
from parsph.io.snapshots import SnapshotWriter
from parsph.moments import MOMENTS, Moments
from parsph.parallel import Communicator
from parsph.scene.build import build
from parsph.scene.load import load_scene


def falling(end=0.02, **numerics):
    """A column that collapses at one end of a long domain, and a single particle, which keeps the plain kernel."""
    numbers = {"dx": 0.01, "viscosity": "monaghan", "alpha": 0.3, "density_range": [0.5, 1.5], "kernel_correction": "linear"}
    return load_scene(
        tank(
            domain={"size": [1.0, 0.3], "gravity": 9.81},
            fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.1, 0.2]}, {"low": [0.5, 0.2], "high": [0.51, 0.21]}]},
            numerics={**numbers, **numerics},
            time={"end": end},
            gauges=[{"kind": "level", "x": 0.05, "every": 0.005}, {"kind": "energy", "every": 0.005}],
        )
    )


CORRECTED = {
    "gradients": {},
    "float32": {"precision": "float32"},
    "all terms": {"xsph": 0.5, "diffusion": "antuono", "tensile_control": "sun", "shifting": "lind", "spray": "pressureless"},
    "midpoint, gaussian": {"integrator": "midpoint", "kernel": "gaussian", "h_over_dx": 4 / 3, "xsph": 0.5},
}


@pytest.mark.parametrize("name", CORRECTED)
def test_corrected_runs_are_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, name):
    """All water begins on the first rank, and cuts move; so often the plain kernel, too."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 10)
    scene = falling(**CORRECTED[name])
    mine, alone = rebuilt(scene, communicator, skewed_cuts(communicator)), run(scene, Communicator())
    mine.run()
    assert mine.domain.cuts != skewed_cuts(communicator) or communicator.size == 1
    assert_same_run(mine, alone)
    assert sum(communicator.allgather(mine.correction.plain)) == alone.correction.plain >= alone.evaluations
    plain = run(falling(**CORRECTED[name], kernel_correction="none"), Communicator())
    assert np.abs(plain.field("velocity") - alone.field("velocity")).max() > 1e-3


def test_corrected_runs_between_polygon_walls_are_the_same_on_all_ranks_to_the_bit(communicator):
    keys = polygons(numerics={"kernel_correction": "linear"}, time={"end": 0.01})
    mine, alone = build(keys, communicator), run(keys, Communicator())
    mine.run()
    assert_same_run(mine, alone)
    assert_same_walls(mine, alone)
    assert sum(communicator.allgather(mine.correction.plain)) == alone.correction.plain


def swinging():
    keys = polygons("mls1", (TANK, FLAP)).model_dump(exclude_unset=True)
    keys["fluid"] = {"blocks": [{"points": [[0.0, 0.0], [0.7, 0.0], [1.0, 0.2], [1.0, 0.28], [0.0, 0.28]]}]}
    return load_scene(keys)


LOOKED_AT = {
    "a wall that swings": swinging,
    "a wavemaker, layers, smoothing": lambda: load_scene(
        "pool", {"time.end": 0.1, "numerics.dx": 0.1, "numerics.xsph": 0.5, "wavemaker.wave.ramp": 0.0}
    ),
    "renormalised gradients, midpoint": lambda: falling(
        0.05, diffusion="antuono", integrator="midpoint", c0_factor=5.0, kernel_correction="none"
    ),
    "corrected": lambda: falling(0.05, c0_factor=5.0),
}


@pytest.mark.parametrize("name", LOOKED_AT)
def test_moments_in_snapshots_change_no_bit_of_a_run_and_are_the_same_on_all_ranks(communicator, monkeypatch, tmp_path, name):
    """Sorting, migrating and mirroring at the present time, eight times, leaves no trace."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 7)
    scene = LOOKED_AT[name]()

    def looked_at(folder, comm, moments):
        simulation = build(scene, comm)
        writer = SnapshotWriter(folder, scene.time.end / 8, "{}", "float64", Moments(simulation.sweep) if moments else None)
        comm.on_root(folder.mkdir)
        simulation.observers.insert(0, writer)
        simulation.run()
        simulation.observers.remove(writer)
        return simulation

    folders = [tmp_path / "all", *(tmp_path / f"{which}-{communicator.rank}" for which in ("alone", "bare"))]
    mine = looked_at(folders[0], communicator, True)
    alone, bare = (
        looked_at(folder, Communicator(), moments) for folder, moments in zip(folders[1:], (True, False), strict=True)
    )
    assert_same_run(mine, bare)
    assert_same_run(alone, bare)
    np.testing.assert_array_equal(gathered(mine, "mass"), bare.field("mass"))
    if bare.domain.ghosts:
        assert_same_walls(mine, bare)
        assert_same_walls(alone, bare)
    if bare.correction:
        assert alone.correction.plain == bare.correction.plain
    moved = 0
    for path in sorted((folders[2] / "snapshots").iterdir()):
        together, single, plain = (h5py.File(folder / "snapshots" / path.name)["VTKHDF"] for folder in folders)
        order, before = np.argsort(single["PointData/id"]), np.argsort(plain["PointData/id"])
        moved += (single["PointData/id"][:] != plain["PointData/id"][:]).any()
        names = ["Points", *(f"PointData/{field}" for field in plain["PointData"])]
        assert set(single["PointData"]) - set(plain["PointData"]) == {moment.name for moment in MOMENTS}
        for field in names:
            np.testing.assert_array_equal(single[field][:][order], plain[field][:][before], err_msg=field)
        for field in (*names, *(f"PointData/{moment.name}" for moment in MOMENTS)):
            np.testing.assert_array_equal(together[field], single[field], err_msg=field)
        for root in (together, single, plain):
            root.file.close()
    assert moved or "midpoint" not in name, "some particle is to be in another cell than at the last sort"
