"""Snapshots: one VTKHDF PolyData file each, complete or absent, and a series file over all of them.

Each rank writes one part. Where h5py is built with MPI all ranks write collectively; elsewhere rank 0 takes the parts of
the others one after another, so that its memory holds one part at a time. Both write the same datasets.
"""

import json
import os

import h5py
import numpy as np

from .. import __version__
from ..observers import Observer
from ..particles import FIELDS

POINT_DATA = ("id", "kind", *(field.name for field in FIELDS if field.snapshot))
UNITS = {"id": "", "kind": "", **{field.name: field.unit for field in FIELDS}}
KINDS = "0: fluid"


def part_of(simulation, precision):
    """Return this rank's particles as {dataset: array}, positions in three components."""

    def in_space(vectors):
        """X and the vertical stay x and y in 2D, as viewers expect."""
        space = np.zeros((len(vectors), 3))
        space[:, : vectors.shape[1]] = vectors
        return space

    part = {"Points": in_space(simulation.field("position")).astype(precision)}
    for name in POINT_DATA:
        values = simulation.field(name)
        if values.ndim == 2:
            values = in_space(values)
        part[f"PointData/{name}"] = values.astype(precision) if values.dtype == float else values
    count = len(part["Points"])
    part["Vertices/Connectivity"] = np.arange(count, dtype=np.int32)
    part["Vertices/Offsets"] = np.arange(count + 1, dtype=np.int32)
    return part


def write_snapshot(path, simulation, scene_text, precision):
    """Write the fluid to `path` (VTKHDF PolyData, one part per rank); collective.

    Parameters
    ----------
    path : Path
    simulation : Simulation
    scene_text : str
        The scene with defaults filled in (JSON), for the metadata.
    precision : str
        "float64" or "float32", of real numbers.
    """
    communicator = simulation.communicator
    part = part_of(simulation, precision)
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
        if field in UNITS:
            dataset.attrs["unit"] = UNITS[field]
    root["PointData/kind"].attrs["values"] = KINDS
    meta = file.create_group("parsph")
    meta.attrs["version"] = __version__
    meta.attrs["time [s]"] = simulation.time
    meta.attrs["step"] = simulation.steps
    meta.attrs["ranks"] = parts
    meta.attrs["column cuts"] = simulation.domain.cuts
    meta.attrs["units"] = json.dumps(UNITS)
    meta["scene"] = scene_text


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
        rows = slice(first, first + len(values))
        if collective:
            with dataset.collective:
                dataset[rows] = values
        else:
            dataset[rows] = values


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
    """

    phase = "snapshots"

    def __init__(self, folder, every, scene_text, precision):
        super().__init__(every)
        self.folder, self.scene_text, self.precision = folder, scene_text, precision
        self.written = []

    def begin(self, simulation):
        simulation.communicator.on_root(lambda: (self.folder / "snapshots").mkdir(exist_ok=True))

    def observe(self, simulation):
        path = self.folder / "snapshots" / f"{len(self.written):05d}.vtkhdf"
        write_snapshot(path, simulation, self.scene_text, self.precision)
        self.written.append((path.name, simulation.time))
        simulation.communicator.on_root(lambda: write_series(self.folder, self.written))


def write_series(folder, snapshots):
    """Write ``series.vtkhdf``: all `snapshots`, a list of (file name, time [s]), as one time series of virtual datasets."""
    sources = [folder / "snapshots" / name for name, _ in snapshots]
    shapes, types, parts, units = {}, {}, [], {}
    for path in sources:
        with h5py.File(path) as file:
            root = file["VTKHDF"]
            parts.append(len(root["NumberOfPoints"]))
            for name in _datasets(root):
                shapes.setdefault(name, []).append(root[name].shape)
                types[name] = root[name].dtype
                units[name] = root[name].attrs.get("unit")
    temporary = folder / "series.partial"
    with h5py.File(temporary, "w") as file:
        root = _polydata(file)
        for name, sizes in shapes.items():
            layout = h5py.VirtualLayout((sum(s[0] for s in sizes), *sizes[0][1:]), types[name])
            row = 0
            for path, size in zip(sources, sizes, strict=True):
                if size[0]:
                    source = h5py.VirtualSource(f"snapshots/{path.name}", f"VTKHDF/{name}", size)
                    layout[row : row + size[0]] = source
                row += size[0]
            dataset = root.create_virtual_dataset(name, layout)
            if units[name] is not None:
                dataset.attrs["unit"] = units[name]
        _steps(root, [time for _, time in snapshots], parts, {n: [s[0] for s in sizes] for n, sizes in shapes.items()})
    os.replace(temporary, folder / "series.vtkhdf")


def _steps(root, times, parts, lengths):
    """The ``Steps`` group: where each time step begins in every dataset."""

    def begins(sizes):
        return np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)

    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(times)
    steps["Values"] = np.array(times)
    steps["NumberOfParts"] = np.array(parts)
    steps["PartOffsets"] = begins(parts)
    steps["PointOffsets"] = begins(lengths["Points"])
    kinds = ("Vertices", "Lines", "Strips", "Polygons")
    cells = [begins(lengths[f"{kind}/Connectivity"]) for kind in kinds]
    steps["CellOffsets"] = np.stack(cells, axis=1)
    steps["ConnectivityIdOffsets"] = np.stack(cells, axis=1)
    for name in lengths:
        if name.startswith("PointData/"):
            steps[f"PointDataOffsets/{name.removeprefix('PointData/')}"] = begins(lengths[name])


def _datasets(root):
    names = []
    root.visititems(lambda name, node: names.append(name) if isinstance(node, h5py.Dataset) else None)
    return names
