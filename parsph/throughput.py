"""How fast snapshots and checkpoints are written, with the writer at hand and on the disk at hand."""

import json
import shutil
import tempfile
import time
from functools import partial
from pathlib import Path
from statistics import median

import h5py
from rich.table import Table

from . import parallel
from .bench import bench_scene
from .io.checkpoints import write_checkpoint
from .io.snapshots import write_snapshot
from .progress import console
from .scene.build import build
from .scene.load import scene_text

H_OVER_DX = 2.0
STEPS = 5


def throughput(particles, repeats, json_file=None, folder=None, communicator=None):
    """Write particle files of a tank on all ranks of the job, and print how long it takes.

    Parameters
    ----------
    particles : int
    repeats : int
        The median of so many counts.
    json_file : Path, optional
        Where to write the rows: objects with the keys file, writer, ranks, particles, bytes, seconds, steps.
    folder : Path, optional
        Where to write the files, which are removed again; default: here.
    communicator : Communicator, optional

    Returns
    -------
    list of dict
        The rows.
    """
    comm = communicator or parallel.start()
    scene = bench_scene(particles, H_OVER_DX, "float64")
    simulation = build(scene, comm)
    simulation.prepare()
    count, text = sum(comm.allgather(len(simulation.particles.fluid))), scene_text(scene)
    step = _seconds(comm, simulation.advance, STEPS)
    writers = {
        "snapshot, float64": partial(write_snapshot, simulation=simulation, scene_text=text, precision="float64"),
        "snapshot, float32": partial(write_snapshot, simulation=simulation, scene_text=text, precision="float32"),
        "checkpoint": partial(write_checkpoint, simulation=simulation, scene_text=text, totals={}),
    }
    rows, work = [], Path(comm.on_root(lambda: tempfile.mkdtemp(prefix=".bench-", dir=folder or ".")))
    path = work / "written.vtkhdf"
    try:
        for name, write in writers.items():
            seconds = _seconds(comm, partial(write, path), repeats)
            size = comm.on_root(lambda: path.stat().st_size)
            row = {"file": name, "writer": writer_of(comm), "ranks": comm.size, "particles": count}
            rows.append({**row, "bytes": size, "seconds": seconds, "steps": seconds / step})
    finally:
        comm.on_root(lambda: shutil.rmtree(work))
    if comm.rank == 0:
        _print(rows)
        if json_file:
            json_file.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return rows


def writer_of(communicator):
    """Return the name of the writer of particle files."""
    if communicator.size == 1:
        return "one rank"
    return "collective" if h5py.get_config().mpi else "gather"


def _seconds(communicator, action, repeats):
    """Return the median time of a collective call, after a first one."""
    times = []
    for _ in range(repeats + 1):
        communicator.barrier()
        begin = time.perf_counter()
        action()
        communicator.barrier()
        times.append(time.perf_counter() - begin)
    return median(times[1:])


def _print(rows):
    table = Table("file", "writer", "ranks", "particles", "MB", "s", "MB/s", "s per million particles", "in steps")
    for column in table.columns[2:]:
        column.justify = "right"
    for row in rows:
        size, seconds = row["bytes"] / 1e6, row["seconds"]
        table.add_row(
            row["file"],
            row["writer"],
            str(row["ranks"]),
            f"{row['particles']:,}",
            f"{size:.1f}",
            f"{seconds:.3f}",
            f"{size / seconds:.0f}",
            f"{1e6 * seconds / row['particles']:.2f}",
            f"{row['steps']:.1f}",
        )
    console().print(table)
