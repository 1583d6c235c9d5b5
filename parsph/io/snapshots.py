"""Snapshots of the fluid, and a series file over all of them."""

import json
import time
from contextlib import nullcontext, suppress
from functools import partial
from typing import NamedTuple

import h5py
import numpy as np

from ..errors import RunError
from ..moments import MOMENTS
from ..observers import Observer
from ..particles import FIELDS
from .polydata import created, in_space, root_of, rows_of, write_polydata

POINT_DATA = ("id", "kind", *(field.name for field in FIELDS if field.snapshot))
KINDS = "0: fluid"
LARGEST_SHARE = 0.02  # of the time that the series over all snapshots may take


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

    Returns
    -------
    int
        Number of particles of all ranks.
    """
    names, derived = ("position", *POINT_DATA), {}
    if moments:
        derived = moments(simulation.particles, simulation.domain.starts, simulation.domain.slab)

    def values_of(name):
        values = derived[name] if name in derived else simulation.field(name)
        return in_space(values).astype(precision, copy=False) if values.dtype == float else values

    data = {"Points" if name == "position" else name: partial(values_of, name) for name in (*names, *derived)}
    described = (*FIELDS, *(moment for moment in MOMENTS if moment.name in derived))
    units = {"id": "", "kind": "", **{field.name: simulation.state.unit(field) for field in described}}
    attributes = {**clock_of(simulation), "units": json.dumps(units), "kinds": KINDS}
    texts = {"scene": scene_text}
    return write_polydata(path, simulation.communicator, len(simulation.particles.fluid), data, units, attributes, texts)


def clock_of(simulation):
    """Return the metadata that all particle files have: time [s], step, and who owned what."""
    communicator, cuts = simulation.communicator, simulation.domain.cuts
    return {"time [s]": simulation.time, "step": simulation.steps, "ranks": communicator.size, "column cuts": cuts}


class Written(NamedTuple):
    """A snapshot on disk: file name, time [s], and the numbers of its parts and its particles."""

    name: str
    time: float
    parts: int
    points: int


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
        self._series = 0  # so many snapshots are in it
        self._series_ended = self._series_took = 0.0  # by the clock [s], the last time that it was written

    def begin(self, simulation):
        communicator = simulation.communicator
        self.written = communicator.on_root(lambda: self._earlier(simulation.time)) if simulation.steps else []
        self.count, self.last_time = len(self.written), self.written[-1].time if self.written else None
        communicator.on_root(lambda: (self.folder / "snapshots").mkdir(exist_ok=True))

    def _earlier(self, now):
        """Return what is there of the run up to `now` [s]; what came after is written again."""
        written = [_read(path) for path in sorted((self.folder / "snapshots").glob("*.vtkhdf"))]
        return [snapshot for snapshot in written if snapshot.time <= now]

    def observe(self, simulation):
        path = self.folder / "snapshots" / f"{self.count:05d}.vtkhdf"
        with simulation.present() if self.moments else nullcontext():
            points = write_snapshot(path, simulation, self.scene_text, self.precision, self.moments)
        self.count, self.last_time = self.count + 1, simulation.time
        if simulation.communicator.rank == 0:
            self.written.append(Written(path.name, simulation.time, simulation.communicator.size, points))
        simulation.communicator.on_root(self._extend_series)

    def finish(self, simulation):
        if self.last_time != simulation.time:
            self.observe(simulation)  # the end of a run is worth a file even between two intervals
        simulation.communicator.on_root(self._remove_later)
        simulation.communicator.on_root(self._complete_series)

    def close(self):
        with suppress(RunError, OSError):  # of a run that has failed, and has said why
            self._complete_series()

    def _extend_series(self):
        """Write the series, whose cost grows with the snapshots, unless the last time was too short a while ago."""
        if time.monotonic() - self._series_ended > self._series_took / LARGEST_SHARE:
            self._complete_series()

    def _complete_series(self):
        if self._series == len(self.written):
            return
        begin = time.monotonic()
        write_series(self.folder, self.written)
        self._series, self._series_ended = len(self.written), time.monotonic()
        self._series_took = self._series_ended - begin

    def _remove_later(self):
        """Remove what a run has left that was interrupted and then went on with fewer snapshots."""
        for path in (self.folder / "snapshots").glob("*.vtkhdf"):
            if int(path.stem) >= self.count:
                path.unlink()


class Shape(NamedTuple):
    """What rows of a dataset are: their shape, type and unit."""

    row: tuple
    dtype: np.dtype
    unit: str


def write_series(folder, snapshots):
    """Write ``series.vtkhdf``: all `snapshots`, a list of `Written`, as one time series of virtual datasets."""
    shapes = _shapes(folder / "snapshots" / snapshots[-1].name)
    rows = {name: [rows_of(name, snapshot.points, snapshot.parts) for snapshot in snapshots] for name in shapes}
    with created(folder / "series.vtkhdf") as file:
        root = root_of(file)
        for name, shape in shapes.items():
            _join(root, name, shape, rows[name], snapshots)
        _steps(root, rows, snapshots)


def _join(root, name, shape, lengths, snapshots):
    """Create the virtual dataset `name` from those of all snapshots, one behind the other.

    h5py's own layouts take a tenth of a second for a few dozen snapshots, ten times as long as writing one.
    """
    space = h5py.h5s.create_simple((sum(lengths), *shape.row))
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    first = 0
    for snapshot, length in zip(snapshots, lengths, strict=True):
        if length:
            place = space.copy()
            place.select_hyperslab((first,) + (0,) * len(shape.row), (length, *shape.row))
            source = h5py.h5s.create_simple((length, *shape.row))
            creation.set_virtual(place, f"snapshots/{snapshot.name}".encode(), f"VTKHDF/{name}".encode(), source)
        first += length
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    kind = h5py.h5t.py_create(shape.dtype)
    dataset = h5py.h5d.create(root.id, name.encode(), kind, space, creation, links)
    h5py.Dataset(dataset).attrs["unit"] = shape.unit


def _steps(root, rows, snapshots):
    """The ``Steps`` group: where each time step begins in every dataset, from the `rows` of each in all snapshots."""
    begins = {name: np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.int64) for name, lengths in rows.items()}
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(snapshots)
    steps["Values"] = np.array([snapshot.time for snapshot in snapshots])
    steps["NumberOfParts"] = np.array([snapshot.parts for snapshot in snapshots])
    steps["PartOffsets"] = begins["NumberOfPoints"]
    steps["PointOffsets"] = begins["Points"]
    cells = np.stack([begins[f"{kind}/Connectivity"] for kind in ("Vertices", "Lines", "Strips", "Polygons")], axis=1)
    steps["CellOffsets"] = cells
    steps["ConnectivityIdOffsets"] = cells
    for name in rows:
        if name.startswith("PointData/"):
            steps[f"PointDataOffsets/{name.removeprefix('PointData/')}"] = begins[name]


def _read(path):
    """Return what a snapshot on disk is, a `Written`."""
    with h5py.File(path) as file:
        counts = file["VTKHDF/NumberOfPoints"][:]
        return Written(path.name, float(file["parsph"].attrs["time [s]"]), len(counts), int(counts.sum()))


def _shapes(path):
    """Return {name: Shape} of all datasets of a snapshot."""
    found = {}

    def note(name, node):
        if isinstance(node, h5py.Dataset):
            found[name] = Shape(node.shape[1:], node.dtype, node.attrs.get("unit", ""))

    with h5py.File(path) as file:
        file["VTKHDF"].visititems(note)
    return found
