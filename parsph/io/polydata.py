"""The layout of particle files: VTKHDF PolyData, one part per rank, complete or absent.

Where h5py is built with MPI all ranks write collectively; elsewhere rank 0 takes the parts of the others one after another,
so that its memory holds one part at a time. Both write the same datasets.
"""

import io
import os
from contextlib import contextmanager

import h5py
import numpy as np

from .. import __version__
from .folder import writing

ALIGNMENT = 1 << 20  # bytes: parallel file systems hand out, and lock, stripes of a megabyte or multiples of it


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
            with h5py.File(disk, "w", **options) as file:
                yield file
            if durable and disk.error is None:
                os.fsync(disk.fileno())
            if disk.error:
                raise disk.error
        os.replace(temporary, path)


def write_polydata(path, communicator, points, data, units, attributes, texts, durable=False):
    """Write particles to `path`; collective.

    Parameters
    ----------
    path : Path
    communicator : Communicator
    points : ndarray, shape (n, 3)
        Positions of this rank's particles [m].
    data : dict of str to ndarray, shape (n, ...)
        What is known of them.
    units : dict of str to str
        Units of the data, by name.
    attributes : dict
        Metadata, the same on all ranks: numbers and short texts.
    texts : dict of str to str
        Long texts, the same on all ranks.
    durable : bool
        Whether the file is to be on the disk, not only with the operating system, before its name says that it is complete.

    Raises
    ------
    RunError
        When it cannot be written; nothing is left of it.
    """
    count = len(points)
    part = {"Points": points, **{f"PointData/{name}": values for name, values in data.items()}}
    part["Vertices/Connectivity"] = np.arange(count, dtype=np.int32)
    part["Vertices/Offsets"] = np.arange(count + 1, dtype=np.int32)
    counts = np.array(communicator.allgather(count))
    options = {"alignment_threshold": ALIGNMENT, "alignment_interval": ALIGNMENT}
    if communicator.size > 1 and h5py.get_config().mpi:
        temporary = path.with_suffix(".partial")
        with writing(temporary), h5py.File(temporary, "w", driver="mpio", comm=communicator.comm, **options) as file:
            _declare(file, part, counts, units, attributes, texts)
            _fill(file, part, counts, communicator.rank, collective=True)
        communicator.on_root(lambda: _publish(temporary, path, durable))
    elif communicator.rank == 0:
        with created(path, durable, **options) as file:
            _declare(file, part, counts, units, attributes, texts)
            for rank in range(communicator.size):
                _fill(file, communicator.receive(rank) if rank else part, counts, rank)
    else:
        communicator.send(part, 0)
    communicator.barrier()


def _publish(temporary, path, durable):
    with writing(temporary):
        if durable:
            with open(temporary, "rb+") as file:
                os.fsync(file.fileno())
        os.replace(temporary, path)


def _declare(file, part, counts, units, attributes, texts):
    """Create all datasets and the metadata; every rank alike."""
    root = root_of(file)
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
    meta = file.create_group("parsph")
    meta.attrs["version"] = __version__
    for name, value in attributes.items():
        meta.attrs[name] = value
    for name, text in texts.items():
        text = text.encode()  # of fixed length: parallel HDF5 cannot write strings of variable length
        meta.create_dataset(name, data=np.array(text, h5py.string_dtype("utf-8", len(text))))


def root_of(file):
    """Create and return the group of a VTKHDF file that holds the particles."""
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
