"""The layout of particle files: VTKHDF PolyData, one part per rank, complete or absent.

Where h5py is built with MPI all ranks write collectively; elsewhere rank 0 takes the parts of the others, one after another in
pieces of a bounded size. Both write the same datasets, one after another, so that no rank holds a copy of more than one.

Datasets are contiguous, not chunked: each rank writes, and later reads, one slice of each, which is one stretch of the file.
Chunks would be larger or smaller than such slices, which differ between ranks and move from file to file, so two ranks would
share them; they serve to compress or to enlarge datasets, which particle files do not need. Datasets begin at multiples of
`ALIGNMENT`. What else a parallel file system needs is said outside: stripes of a folder (``lfs setstripe``), and hints to
MPI's files, by a file that the variable ``ROMIO_HINTS`` names.
"""

import io
import math
import os
from contextlib import contextmanager

import h5py
import numpy as np

from .. import __version__
from .folder import writing

ALIGNMENT = 1 << 20  # bytes: parallel file systems hand out, and lock, stripes of a megabyte or multiples of it
PIECE = 1 << 26  # bytes that rank 0 holds of others at a time
CELLS = "Vertices", "Lines", "Polygons", "Strips"


def in_space(values):
    """Return vectors, shape (n, dim), or tensors, (n, dim, dim), in three components and nine; X and the vertical stay x and y
    in 2D, as viewers expect. Scalars stay as they are.
    """
    count, *sizes = values.shape
    space = np.zeros((count, *(3 for _ in sizes)))
    space[(slice(None), *map(slice, sizes))] = values
    return space.reshape(count, 3 ** len(sizes)) if sizes else space


class _Disk(io.FileIO):
    """A file for HDF5 to write to that keeps failures to itself until it is asked: with a full disk HDF5 can neither close its
    file nor forget it, and takes the process down with it.
    """

    def __init__(self, path):
        super().__init__(path, "w+")
        self.error = None

    def __repr__(self):  # what h5py calls the file
        return str(self.name)

    def write(self, data):
        rest = memoryview(data).cast("B")
        try:
            while rest and self.error is None:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.error = error
        return len(data)

    def readinto(self, buffer):
        view = memoryview(buffer).cast("B")
        count = super().readinto(view)
        view[count:] = bytes(len(view) - count)  # what could not be written is not there to be read again
        return len(view)

    def truncate(self, size=None):
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size


@contextmanager
def created(path, durable=False, **options):
    """Give an HDF5 file to write to, for one process, that is called `path` when it is complete.

    Parameters
    ----------
    path : Path
    durable : bool
        Whether it is to be on the disk before it is called so, not only with the system.
    options
        Of `h5py.File`.

    Raises
    ------
    RunError
        When it cannot be written; nothing is left of it.
    """
    temporary = path.with_suffix(".partial")
    with writing(temporary):
        with _Disk(temporary) as disk:
            try:
                with h5py.File(disk, "w", **options) as file:
                    yield file
            except Exception:  # HDF5 reads again what could not be written, and finds fault with it
                if disk.error is None:
                    raise
            if durable and disk.error is None:
                os.fsync(disk.fileno())
            if disk.error:
                raise disk.error
        os.replace(temporary, path)


def write_polydata(path, communicator, count, data, units, attributes, texts, durable=False):
    """Write particles to `path`; collective.

    Parameters
    ----------
    path : Path
    communicator : Communicator
    count : int
        Number of this rank's particles.
    data : dict of str to callable
        What is known of them: each is called once and returns an ndarray, shape (count, ...); "Points" are their positions [m],
        shape (count, 3).
    units : dict of str to str
        Units of the data, by name.
    attributes : dict
        Metadata, the same on all ranks: numbers and short texts.
    texts : dict of str to str
        Long texts, the same on all ranks.
    durable : bool
        Whether the file is to be on the disk, not only with the operating system, before its name says that it is complete.

    Returns
    -------
    int
        Number of particles of all ranks.

    Raises
    ------
    RunError
        When it cannot be written; nothing is left of it.
    """
    datasets = {name if name == "Points" else f"PointData/{name}": values for name, values in data.items()}
    datasets["Vertices/Connectivity"] = lambda: np.arange(count, dtype=np.int32)
    datasets["Vertices/Offsets"] = lambda: np.arange(count + 1, dtype=np.int32)
    counts = np.array(communicator.allgather(count))
    options = {"alignment_threshold": ALIGNMENT, "alignment_interval": ALIGNMENT}
    if communicator.size > 1 and h5py.get_config().mpi:
        temporary = path.with_suffix(".partial")
        with writing(temporary), h5py.File(temporary, "w", driver="mpio", comm=communicator.comm, **options) as file:
            _write(file, communicator, counts, datasets, units, attributes, texts)
        communicator.on_root(lambda: _publish(temporary, path, durable))
    elif communicator.rank == 0:
        with created(path, durable, **options) as file:
            _write(file, communicator, counts, datasets, units, attributes, texts)
    else:
        for values in datasets.values():
            _send(values(), communicator)
    communicator.barrier()
    return int(counts.sum())


def _publish(temporary, path, durable):
    with writing(temporary):
        if durable:
            with open(temporary, "rb+") as file:
                os.fsync(file.fileno())
        os.replace(temporary, path)


def rows_of(name, points, parts):
    """Return how many rows the dataset `name` has in a file of so many particles in so many parts."""
    group, _, field = name.rpartition("/")
    if group in CELLS[1:]:
        points = 0  # there are none of these
    if field.startswith("NumberOf"):
        return parts
    return points + parts if field == "Offsets" else points


def _write(file, communicator, counts, datasets, units, attributes, texts):
    """Write all there is; of every rank that has the file open."""
    root, parts = root_of(file), len(counts)
    root["NumberOfPoints"] = counts
    for cells in CELLS:
        for number in ("NumberOfCells", "NumberOfConnectivityIds"):
            root[f"{cells}/{number}"] = counts if cells == "Vertices" else np.zeros(parts, int)
    for cells in CELLS[1:]:
        root[f"{cells}/Offsets"] = np.zeros(parts, np.int32)
        root.create_dataset(f"{cells}/Connectivity", (0,), np.int32)
    meta = file.create_group("parsph")
    meta.attrs["version"] = __version__
    for name, value in attributes.items():
        meta.attrs[name] = value
    for name, text in texts.items():
        text = text.encode()  # of fixed length: parallel HDF5 cannot write strings of variable length
        meta.create_dataset(name, data=np.array(text, h5py.string_dtype("utf-8", len(text))))
    for name, values in datasets.items():
        sizes = [rows_of(name, count, 1) for count in counts.tolist()]
        _write_dataset(root, name, values(), sizes, units.get(name.rsplit("/")[-1]), communicator)


def root_of(file):
    """Create and return the group of a VTKHDF file that holds the particles."""
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0])
    root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
    return root


def _write_dataset(root, name, values, sizes, unit, communicator):
    dataset = root.create_dataset(name, (sum(sizes), *values.shape[1:]), values.dtype)
    if unit is not None:
        dataset.attrs["unit"] = unit
    _fill(dataset, values, sizes, communicator)


def _fill(dataset, values, sizes, communicator):
    """Write the rows of all ranks, so many each; `values` are those of this one."""
    if dataset.file.driver == "mpio":
        _write_collectively(dataset, sum(sizes[: communicator.rank]), values)
        return
    dataset[: len(values)] = values
    first = len(values)
    for rank in range(1, communicator.size):
        for rows in _pieces(sizes[rank], values):
            piece = np.empty((rows.stop - rows.start, *values.shape[1:]), values.dtype)
            communicator.receive(piece, rank)
            dataset[first + rows.start : first + rows.stop] = piece
        first += sizes[rank]


def _send(values, communicator):
    """Have rank 0 write the rows of this rank."""
    for rows in _pieces(len(values), values):
        communicator.send(np.ascontiguousarray(values[rows]), 0)


def _pieces(count, like):
    """Return slices of so many rows, each of at most `PIECE` bytes of rows like those of an array."""
    step = max(1, PIECE // (like.itemsize * math.prod(like.shape[1:])))
    return [slice(first, min(first + step, count)) for first in range(0, count, step)]


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
