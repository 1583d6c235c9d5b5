"""Snapshots of the fluid, and a series file over all of them."""

import json
from contextlib import nullcontext
from typing import NamedTuple

import h5py
import numpy as np

from ..moments import MOMENTS
from ..observers import Observer
from ..particles import FIELDS
from .polydata import created, in_space, root_of, write_polydata

POINT_DATA = ("id", "kind", *(field.name for field in FIELDS if field.snapshot))
KINDS = "0: fluid"


def write_snapshot(path, simulation, scene_text, precision, moments=None):
    """Write the fluid to `path`; collective.

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
    fields = {name: simulation.field(name) for name in POINT_DATA}
    if moments:
        fields.update(moments(simulation.particles, simulation.domain.starts, simulation.domain.slab))
    for name, values in fields.items():
        fields[name] = in_space(values).astype(precision) if values.dtype == float else values
    derived = [moment for moment in MOMENTS if moment.name in fields]
    units = {"id": "", "kind": "", **{field.name: simulation.state.unit(field) for field in (*FIELDS, *derived)}}
    points = in_space(simulation.field("position")).astype(precision)
    attributes = {**clock_of(simulation), "units": json.dumps(units), "kinds": KINDS}
    write_polydata(path, simulation.communicator, points, fields, units, attributes, {"scene": scene_text})


def clock_of(simulation):
    """Return the metadata that all particle files have: time [s], step, and who owned what."""
    communicator, cuts = simulation.communicator, simulation.domain.cuts
    return {"time [s]": simulation.time, "step": simulation.steps, "ranks": communicator.size, "column cuts": cuts}


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
        communicator = simulation.communicator
        self.written = communicator.on_root(lambda: self._earlier(simulation.time)) if simulation.steps else []
        self.count, self.last_time = len(self.written), self.written[-1].time if self.written else None
        communicator.on_root(lambda: (self.folder / "snapshots").mkdir(exist_ok=True))

    def _earlier(self, time):
        """Return what is there of the run up to `time` [s]; what came after is written again."""
        paths = sorted((self.folder / "snapshots").glob("*.vtkhdf"))
        written = [Written(path.name, *_read(path)) for path in paths]
        return [snapshot for snapshot in written if snapshot.time <= time]

    def observe(self, simulation):
        path = self.folder / "snapshots" / f"{self.count:05d}.vtkhdf"
        with simulation.present() if self.moments else nullcontext():
            write_snapshot(path, simulation, self.scene_text, self.precision, self.moments)
        self.count, self.last_time = self.count + 1, simulation.time
        if simulation.communicator.rank == 0:
            self.written.append(Written(path.name, *_read(path)))
        simulation.communicator.on_root(lambda: write_series(self.folder, self.written))

    def finish(self, simulation):
        if self.last_time != simulation.time:
            self.observe(simulation)  # the end of a run is worth a file even between two intervals
        simulation.communicator.on_root(self._remove_later)

    def _remove_later(self):
        """Remove what a run has left that was interrupted and then went on with fewer snapshots."""
        for path in (self.folder / "snapshots").glob("*.vtkhdf"):
            if int(path.stem) >= self.count:
                path.unlink()


def write_series(folder, snapshots):
    """Write ``series.vtkhdf``: all `snapshots`, a list of `Written`, as one time series of virtual datasets."""
    with created(folder / "series.vtkhdf") as file:
        root = root_of(file)
        for name in snapshots[0].datasets:
            _join(root, name, snapshots)
        _steps(root, snapshots)


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


def _read(path):
    """Return the time [s] of a snapshot and {name: Shape} of all its datasets."""
    found = {}

    def note(name, node):
        if isinstance(node, h5py.Dataset):
            found[name] = Shape(node.shape, node.dtype, node.attrs.get("unit", ""))

    with h5py.File(path) as file:
        file["VTKHDF"].visititems(note)
        return float(file["parsph"].attrs["time [s]"]), found
