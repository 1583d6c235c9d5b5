"""Snapshots: one VTKHDF PolyData file each, complete or absent, and a series file over all of them.

Each rank writes one part. Where h5py is built with MPI all ranks write collectively; elsewhere rank 0 takes the parts of
the others one after another, so that its memory holds one part at a time. Both write the same datasets.
"""

import json
import os
from contextlib import nullcontext
from typing import NamedTuple

import h5py
import numpy as np

from .. import __version__
from ..moments import MOMENTS
from ..observers import Observer
from ..particles import FIELDS

POINT_DATA = ("id", "kind", *(field.name for field in FIELDS if field.snapshot))
KINDS = "0: fluid"


def part_of(simulation, precision, moments=None):
    """Return this rank's particles as {dataset: array}, vectors in three components, tensors in nine."""

    def in_space(values):
        """X and the vertical stay x and y in 2D, as viewers expect."""
        count, *sizes = values.shape
        space = np.zeros((count, *(3 for _ in sizes)))
        space[(slice(None), *map(slice, sizes))] = values
        return space.reshape(count, 3 ** len(sizes)) if sizes else space

    fields = {name: simulation.field(name) for name in POINT_DATA}
    if moments:
        fields.update(moments(simulation.particles, simulation.domain.starts, simulation.domain.slab))
    part = {"Points": in_space(simulation.field("position")).astype(precision)}
    for name, values in fields.items():
        part[f"PointData/{name}"] = in_space(values).astype(precision) if values.dtype == float else values
    count = len(part["Points"])
    part["Vertices/Connectivity"] = np.arange(count, dtype=np.int32)
    part["Vertices/Offsets"] = np.arange(count + 1, dtype=np.int32)
    return part


def write_snapshot(path, simulation, scene_text, precision, moments=None):
    """Write the fluid to `path` (VTKHDF PolyData, one part per rank); collective.

    Parameters
    ----------
    path : Path
    simulation : Simulation
    scene_text : str
        The scene with defaults filled in (JSON), for the metadata.
    precision : str
        "float64" or "float32", of real numbers.
    moments : Moments, optional
        What works out the kernel's moments; particles must then be in the order of the present time (`Simulation.present`).
    """
    communicator = simulation.communicator
    part = part_of(simulation, precision, moments)
    counts = np.array(communicator.allgather(len(part["Points"])))
    temporary = path.with_suffix(".partial")
    if communicator.size > 1 and h5py.get_config().mpi:
        with h5py.File(temporary, "w", driver="mpio", comm=communicator.comm) as file:
            _declare(file, part, counts, simulation, scene_text)
            _fill(file, part, counts, communicator.rank, collective=True)
    elif communicator.rank == 0:
        with h5py.File(temporary, "w") as file:
            _declare(file, part, counts, simulation, scene_text)
            for rank in range(communicator.size):
                _fill(file, communicator.receive(rank) if rank else part, counts, rank)
    else:
        communicator.send(part, 0)
    communicator.on_root(lambda: os.replace(temporary, path))


def _declare(file, part, counts, simulation, scene_text):
    """Create all datasets and the metadata; every rank alike."""
    root = _polydata(file)
    derived = [moment for moment in MOMENTS if f"PointData/{moment.name}" in part]
    units = {"id": "", "kind": "", **{field.name: simulation.state.unit(field) for field in (*FIELDS, *derived)}}
    total, parts = int(counts.sum()), len(counts)
    root["NumberOfPoints"] = counts
    for cells in ("Vertices", "Lines", "Polygons", "Strips"):
        group = root.create_group(cells)
        filled = cells == "Vertices"
        group["NumberOfCells"] = counts if filled else np.zeros(parts, int)
        group["NumberOfConnectivityIds"] = counts if filled else np.zeros(parts, int)
        if not filled:
            group["Offsets"] = np.zeros(parts, np.int32)
            group.create_dataset("Connectivity", (0,), np.int32)
    for name, values in part.items():
        length = total + parts if name.endswith("Offsets") else total
        dataset = root.create_dataset(name, (length, *values.shape[1:]), values.dtype)
        field = name.rsplit("/")[-1]
        if field in units:
            dataset.attrs["unit"] = units[field]
    root["PointData/kind"].attrs["values"] = KINDS
    meta = file.create_group("parsph")
    meta.attrs["version"] = __version__
    meta.attrs["time [s]"] = simulation.time
    meta.attrs["step"] = simulation.steps
    meta.attrs["ranks"] = parts
    meta.attrs["column cuts"] = simulation.domain.cuts
    meta.attrs["units"] = json.dumps(units)
    text = scene_text.encode()  # of fixed length: parallel HDF5 cannot write strings of variable length
    meta.create_dataset("scene", data=np.array(text, h5py.string_dtype("utf-8", len(text))))


def _polydata(file):
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0])
    root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
    return root


def _fill(file, part, counts, rank, collective=False):
    """Write one rank's part; a rank without particles takes the same calls with an empty selection."""
    before = int(counts[:rank].sum())
    for name, values in part.items():
        first = before + rank if name.endswith("Offsets") else before
        dataset = file["VTKHDF"][name]
        if collective:
            _write_collectively(dataset, first, values)
        else:
            dataset[first : first + len(values)] = values


def _write_collectively(dataset, first, values):
    """Write `values` to the rows from `first` on, together with all ranks.

    h5py's own assignment does nothing where there are no rows, and the other ranks would wait for ever.
    """
    memory, target = h5py.h5s.create_simple(values.shape), dataset.id.get_space()
    if len(values):
        target.select_hyperslab((first,) + (0,) * (values.ndim - 1), values.shape)
    else:
        memory.select_none()
        target.select_none()
    transfer = h5py.h5p.create(h5py.h5p.DATASET_XFER)
    transfer.set_dxpl_mpio(h5py.h5fd.MPIO_COLLECTIVE)
    dataset.id.write(memory, target, np.ascontiguousarray(values), dxpl=transfer)


class Shape(NamedTuple):
    """Shape and type of a dataset."""

    shape: tuple
    dtype: np.dtype
    unit: str


class Written(NamedTuple):
    """A snapshot on disk: file name, time [s] and the shapes of its datasets."""

    name: str
    time: float
    datasets: dict


class SnapshotWriter(Observer):
    """Writes snapshots and the series over them.

    Parameters
    ----------
    folder : Path
        The run's folder: files go to ``snapshots/`` in it, the series beside that.
    every : float
        Interval [s].
    scene_text : str
    precision : str
    moments : Moments, optional
        As `write_snapshot`.
    """

    phase = "snapshots"

    def __init__(self, folder, every, scene_text, precision, moments=None):
        super().__init__(every)
        self.folder, self.scene_text, self.precision, self.moments = folder, scene_text, precision, moments
        self.written, self.count, self.last_time = [], 0, None

    def begin(self, simulation):
        simulation.communicator.on_root(lambda: (self.folder / "snapshots").mkdir(exist_ok=True))

    def observe(self, simulation):
        path = self.folder / "snapshots" / f"{self.count:05d}.vtkhdf"
        with simulation.present() if self.moments else nullcontext():
            write_snapshot(path, simulation, self.scene_text, self.precision, self.moments)
        self.count, self.last_time = self.count + 1, simulation.time
        if simulation.communicator.rank == 0:
            self.written.append(Written(path.name, simulation.time, _datasets(path)))
        simulation.communicator.on_root(lambda: write_series(self.folder, self.written))

    def finish(self, simulation):
        if self.last_time != simulation.time:
            self.observe(simulation)  # the end of a run is worth a file even between two intervals


def write_series(folder, snapshots):
    """Write ``series.vtkhdf``: all `snapshots`, a list of `Written`, as one time series of virtual datasets."""
    temporary = folder / "series.partial"
    with h5py.File(temporary, "w") as file:
        root = _polydata(file)
        for name in snapshots[0].datasets:
            _join(root, name, snapshots)
        _steps(root, snapshots)
    os.replace(temporary, folder / "series.vtkhdf")


def _join(root, name, snapshots):
    """Create the virtual dataset `name` from those of all snapshots, one behind the other.

    h5py's own layouts take a tenth of a second for a few dozen snapshots, ten times as long as writing one.
    """
    lengths = [snapshot.datasets[name].shape[0] for snapshot in snapshots]
    _, *rest = snapshots[0].datasets[name].shape
    space = h5py.h5s.create_simple((sum(lengths), *rest))
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    row = 0
    for snapshot, length in zip(snapshots, lengths, strict=True):
        if length:
            place = space.copy()
            place.select_hyperslab((row,) + (0,) * len(rest), (length, *rest))
            source = h5py.h5s.create_simple((length, *rest))
            creation.set_virtual(place, f"snapshots/{snapshot.name}".encode(), f"VTKHDF/{name}".encode(), source)
        row += length
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    kind = h5py.h5t.py_create(snapshots[0].datasets[name].dtype)
    dataset = h5py.h5d.create(root.id, name.encode(), kind, space, creation, links)
    h5py.Dataset(dataset).attrs["unit"] = snapshots[0].datasets[name].unit


def _steps(root, snapshots):
    """The ``Steps`` group: where each time step begins in every dataset."""

    def begins(name):
        lengths = [snapshot.datasets[name].shape[0] for snapshot in snapshots]
        return np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.int64)

    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(snapshots)
    steps["Values"] = np.array([snapshot.time for snapshot in snapshots])
    steps["NumberOfParts"] = np.array([snapshot.datasets["NumberOfPoints"].shape[0] for snapshot in snapshots])
    steps["PartOffsets"] = begins("NumberOfPoints")
    steps["PointOffsets"] = begins("Points")
    cells = np.stack([begins(f"{kind}/Connectivity") for kind in ("Vertices", "Lines", "Strips", "Polygons")], axis=1)
    steps["CellOffsets"] = cells
    steps["ConnectivityIdOffsets"] = cells
    for name in snapshots[0].datasets:
        if name.startswith("PointData/"):
            steps[f"PointDataOffsets/{name.removeprefix('PointData/')}"] = begins(name)


def _datasets(path):
    """Return {name: Shape} of all datasets of a snapshot."""
    found = {}

    def note(name, node):
        if isinstance(node, h5py.Dataset):
            found[name] = Shape(node.shape, node.dtype, node.attrs.get("unit", ""))

    with h5py.File(path) as file:
        file["VTKHDF"].visititems(note)
    return found
