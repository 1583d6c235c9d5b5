"""Snapshots of the fluid, and a series file over all of them.

The series refers to the snapshots, and where these are many to files over `TOGETHER` of them, each of which is written once.
So what it takes to write it, time and memory, grows by two references in a hundred snapshots.
"""

import io
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
from .folder import write_whole
from .polydata import in_space, root_of, rows_of, write_polydata

POINT_DATA = ("id", "kind", *(field.name for field in FIELDS if field.snapshot))
KINDS = "0: fluid"
LARGEST_SHARE = 0.02  # of the time that the series over all snapshots may take
TOGETHER = 100  # snapshots in a file of their own of the series
CACHE = 1024  # bytes: HDF5 would keep all references of a series until it is written, 4 kB each


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
    """Snapshots on disk: file in the run's folder, time of the first [s], and numbers of parts and particles of all."""

    file: str
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
        self._series = self._parts = 0  # so many snapshots are in it, so many files of their own has it
        self._series_ended = self._series_took = 0.0  # by the clock [s], the last time that it was written

    def begin(self, simulation):
        communicator = simulation.communicator
        earlier = communicator.on_root(lambda: self._earlier(simulation.time)) if simulation.steps else []
        self.count, self.last_time = len(earlier), earlier[-1].time if earlier else None
        self.written = earlier if communicator.rank == 0 else []  # who writes the series
        communicator.on_root(lambda: (self.folder / "snapshots").mkdir(exist_ok=True))

    def _earlier(self, now):
        """Return what is there of the run up to `now` [s]; what came after is written again."""
        written = [_read(self.folder, path) for path in sorted((self.folder / "snapshots").glob("*.vtkhdf"))]
        return [snapshot for snapshot in written if snapshot.time <= now]

    def observe(self, simulation):
        path = self.folder / "snapshots" / f"{self.count:05d}.vtkhdf"
        with simulation.present() if self.moments else nullcontext():
            points = write_snapshot(path, simulation, self.scene_text, self.precision, self.moments)
        self.count, self.last_time = self.count + 1, simulation.time
        if simulation.communicator.rank == 0:
            name = str(path.relative_to(self.folder))
            self.written.append(Written(name, simulation.time, simulation.communicator.size, points))
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
        self._parts = write_series(self.folder, self.written, self._parts)
        self._series, self._series_ended = len(self.written), time.monotonic()
        self._series_took = self._series_ended - begin

    def _remove_later(self):
        """Remove what a run has left that was interrupted and then went on with fewer snapshots."""
        for path in (self.folder / "snapshots").glob("*.vtkhdf"):
            if int(path.stem) >= self.count:
                path.unlink()
        for path in (self.folder / "series").glob("*.vtkhdf"):
            if int(path.stem) >= self.count // TOGETHER:
                path.unlink()


class Shape(NamedTuple):
    """What rows of a dataset are: their shape, type and unit."""

    row: tuple
    dtype: np.dtype
    unit: str


def write_series(folder, snapshots, parts=0):
    """Write ``series.vtkhdf``: all `snapshots`, a list of `Written`, as one time series of virtual datasets.

    Parameters
    ----------
    folder : Path
        The run's folder.
    snapshots : list of Written
    parts : int
        So many files of their own are there already.

    Returns
    -------
    int
        So many are there now.
    """
    shapes, pieces = _shapes(folder / snapshots[-1].file), []
    whole = len(snapshots) // TOGETHER
    for number in range(whole):
        name, together = f"series/{number:05d}.vtkhdf", snapshots[number * TOGETHER : (number + 1) * TOGETHER]
        if number >= parts:
            (folder / "series").mkdir(exist_ok=True)
            _write_joined(folder / name, shapes, [each._replace(file=f"../{each.file}") for each in together], together)
        sums = (sum(getattr(each, what) for each in together) for what in ("parts", "points"))
        pieces.append(Written(name, together[0].time, *sums))
    _write_joined(folder / "series.vtkhdf", shapes, [*pieces, *snapshots[whole * TOGETHER :]], snapshots)
    return whole


def _write_joined(path, shapes, pieces, snapshots):
    """Write one file over `pieces`, which hold the time steps of `snapshots`; in memory first, where no disk can be full."""
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        cache = file.id.get_mdc_config()
        cache.set_initial_size, cache.initial_size, cache.min_size, cache.max_size = True, CACHE, CACHE, CACHE
        file.id.set_mdc_config(cache)
        root = root_of(file)
        for name, shape in shapes.items():
            _join(root, name, shape, pieces)
        _steps(root, shapes, snapshots)
    write_whole(path, image.getbuffer())


def _join(root, name, shape, pieces):
    """Create the virtual dataset `name` from those of all pieces, one behind the other.

    h5py's own layouts take a tenth of a second for a few dozen pieces, ten times as long as writing a snapshot.
    """
    lengths = [rows_of(name, piece.points, piece.parts) for piece in pieces]
    space = h5py.h5s.create_simple((sum(lengths), *shape.row))
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    first = 0
    for piece, length in zip(pieces, lengths, strict=True):
        if length:
            place = space.copy()
            place.select_hyperslab((first,) + (0,) * len(shape.row), (length, *shape.row))
            source = h5py.h5s.create_simple((length, *shape.row))
            creation.set_virtual(place, piece.file.encode(), f"VTKHDF/{name}".encode(), source)
        first += length
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    kind = h5py.h5t.py_create(shape.dtype)
    dataset = h5py.h5d.create(root.id, name.encode(), kind, space, creation, links)
    h5py.Dataset(dataset).attrs["unit"] = shape.unit


def _steps(root, names, snapshots):
    """The ``Steps`` group: where each time step begins in every dataset."""

    def begin(name):
        lengths = [rows_of(name, snapshot.points, snapshot.parts) for snapshot in snapshots]
        return np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.int64)

    begins = {name: begin(name) for name in names}
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(snapshots)
    steps["Values"] = np.array([snapshot.time for snapshot in snapshots])
    steps["NumberOfParts"] = np.array([snapshot.parts for snapshot in snapshots])
    steps["PartOffsets"] = begins["NumberOfPoints"]
    steps["PointOffsets"] = begins["Points"]
    cells = np.stack([begins[f"{kind}/Connectivity"] for kind in ("Vertices", "Lines", "Strips", "Polygons")], axis=1)
    steps["CellOffsets"] = cells
    steps["ConnectivityIdOffsets"] = cells
    for name in names:
        if name.startswith("PointData/"):
            steps[f"PointDataOffsets/{name.removeprefix('PointData/')}"] = begins[name]


def _read(folder, path):
    """Return what a snapshot in a run's folder is, a `Written`."""
    with h5py.File(path) as file:
        counts = file["VTKHDF/NumberOfPoints"][:]
        return Written(str(path.relative_to(folder)), float(file["parsph"].attrs["time [s]"]), len(counts), int(counts.sum()))


def _shapes(path):
    """Return {name: Shape} of all datasets of a snapshot."""
    found = {}

    def note(name, node):
        if isinstance(node, h5py.Dataset):
            found[name] = Shape(node.shape[1:], node.dtype, node.attrs.get("unit", ""))

    with h5py.File(path) as file:
        file["VTKHDF"].visititems(note)
    return found
