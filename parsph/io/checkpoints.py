"""Checkpoints: what a run needs to go on, to the bit, on any number of ranks.

A checkpoint is a particle file as snapshots are, in float64, with the fields that live from one step to the next
(`parsph.particles.FIELDS`), in the order of the particles, so that the columns of any rank are one slice of it. A text beside
them holds the clock, what decides on the ways of walls, and the checksums of all parts. Schedules and records of observers
follow from the time and from their files.
"""

import json
import math
import signal
import time
import zlib
from functools import partial

import h5py
import numpy as np

from ..errors import Interrupted, ParsphError, RunError, Unfinished
from ..observers import Observer
from ..particles import identities
from .polydata import in_space, write_polydata
from .snapshots import clock_of

KEPT = 2  # a damaged one has one before it
BLOCK = 1 << 20  # rows that are read at a time
LOOK = 0.5  # s of the clock between two looks whether a checkpoint is wanted
LARGEST_SHARE = 0.02  # of the time that scheduled checkpoints may take
SPEED = 5e7  # bytes/s that a first checkpoint is expected to be written with
WANTED, TIME_UP, ASKED, INTERRUPTED = 1, 2, 3, 4  # what a look finds; all but the first end the run


def folder_of(run):
    """Return the folder of a run's checkpoints."""
    return run / "checkpoints"


def bytes_on_disk(layout):
    """Return the bytes of a particle in a checkpoint: number, vertex, and the fields, vectors with three components."""
    lasting = [field for field in layout.fields if field.lasting]
    return 8 + 8 + 8 * sum(3 if field.rank == 1 else layout.components(field) for field in lasting)


def has_checkpoint(run):
    """Return whether the folder of a run holds a checkpoint."""
    return any(folder_of(run).glob("*.vtkhdf"))


def write_checkpoint(path, simulation, scene_text, totals):
    """Write the state of a run between two steps to `path`; collective.

    Parameters
    ----------
    path : Path
    simulation : Simulation
    scene_text : str
        The scene with defaults filled in (JSON).
    totals : dict
        What the run has used up so far, for its summary; numbers, lists and dicts of them.

    Raises
    ------
    RunError
        When it cannot be written, or something of it is not finite.
    """
    communicator, p = simulation.communicator, simulation.particles
    rows, layout = p.fluid, p.layout
    data = {"id": lambda: identities(p.tags[rows])}
    for field in layout.fields:
        if field.lasting:
            data["Points" if field.name == "position" else field.name] = partial(_copied, field, p, rows)
    # each is copied twice, here and to be written, so that one copy at a time is in memory
    sums = {name: _examined(name, values(), data["id"], simulation.time) for name, values in data.items()}
    counts = np.diff(np.searchsorted(rows, simulation.domain.column_bounds()))
    parts = communicator.allgather((sums, counts))
    memory = {
        "simulation": simulation.memory(),
        "totals": totals,
        "checksums": {name: [sums[name] for sums, _ in parts] for name in sums},
        "column counts": np.concatenate([counts for _, counts in parts]).tolist(),
    }
    text = json.dumps(memory)
    units = {field.name: simulation.state.unit(field) for field in layout.fields}
    attributes = {**clock_of(simulation), "memory checksum": zlib.crc32(text.encode())}
    texts = {"scene": scene_text, "memory": text}
    write_polydata(path, communicator, len(rows), data, units, attributes, texts, durable=True)


def _copied(field, particles, rows):
    values = particles.field(field.name, rows)
    return in_space(values) if field.rank == 1 else values


def _checksum(values, begun=0):
    return zlib.crc32(np.ascontiguousarray(values).data, begun)


def _examined(name, values, ids, now):
    """Return the checksum of values that are all finite."""
    bad = ~np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
    if bad.any():
        name = "position" if name == "Points" else name
        what = f"particle {ids()[np.argmax(bad)]}: {name} is not a number at t = {now:.6g} s"
        raise RunError(what, cure="go on from the checkpoint before with a smaller time.cfl, or more diffusion or viscosity")
    return _checksum(values)


class Checkpoint:
    """A checkpoint on disk.

    Parameters
    ----------
    path : Path

    Raises
    ------
    Damaged
        When it cannot be read, or its text is not what was written.
    """

    def __init__(self, path):
        self.path = path
        try:
            with h5py.File(path) as file:
                meta = file["parsph"]
                text = bytes(meta["memory"][()])
                if zlib.crc32(text) != meta.attrs["memory checksum"]:
                    raise Damaged("its text has another checksum than when it was written")
                self.version, self.sizes = str(meta.attrs["version"]), file["VTKHDF/NumberOfPoints"][:]
        except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:
            raise Damaged(f"it cannot be read ({error})") from None
        self._memory = json.loads(text)
        self.totals = self._memory["totals"]
        self.counts = np.array(self._memory["column counts"])
        self.time, self.step = (self._memory["simulation"][name] for name in ("time", "steps"))
        if self.counts.sum() != self.sizes.sum():
            raise Damaged("its parts have other sizes than when they were written")

    def examine(self, communicator):
        """Compare all parts with their checksums, each rank some of them; collective.

        Raises
        ------
        Damaged
            On all ranks, when one has found a difference.
        """
        found = "; ".join(filter(None, communicator.allgather(self._differences(communicator.rank, communicator.size))))
        if found:
            raise Damaged(found)

    def _differences(self, rank, size):
        """Return what differs in the parts rank, rank + size, ..., empty when nothing does."""
        begins = np.concatenate([[0], np.cumsum(self.sizes)])
        try:
            with h5py.File(self.path) as file:
                for part in range(rank, len(self.sizes), size):
                    for name, sums in self._memory["checksums"].items():
                        found, dataset = 0, file["VTKHDF"][name if name == "Points" else f"PointData/{name}"]
                        for first in range(begins[part], begins[part + 1], BLOCK):
                            found = _checksum(dataset[first : min(first + BLOCK, begins[part + 1])], found)
                        if found != sums[part]:
                            return f"{name} of part {part} has another checksum than when it was written"
        except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:
            return f"it cannot be read ({error})"
        return ""

    def fill(self, particles, first_column, last_column):
        """Add the particles of the columns ``first_column:last_column``, in their order."""
        first, last = (int(self.counts[:column].sum()) for column in (first_column, last_column))
        layout, fields = particles.layout, {}
        with h5py.File(self.path) as file:
            root = file["VTKHDF"]
            tags = root["PointData/id"][first:last]
            for field in layout.fields:
                if field.lasting:
                    dataset = root["Points"] if field.name == "position" else root[f"PointData/{field.name}"]
                    values = dataset[first:last].reshape(last - first, math.prod(dataset.shape[1:]))
                    fields[field.name] = values[:, : layout.components(field)]
        particles.add(tags, **fields)

    def restore(self, simulation):
        """Set clock and walls of a simulation whose particles are those of the checkpoint, and let observers go on after it."""
        simulation.recall(self._memory["simulation"])
        for observer in simulation.observers:
            if observer.schedule:
                observer.schedule.due(self.time)  # what was due up to here was seen before


class Damaged(ParsphError):
    """A checkpoint that is not what was written."""


def latest(run, communicator):
    """Return the newest `Checkpoint` of a run that is whole, None when there is none, and what is wrong with newer ones, a list
    of texts; collective.

    Parameters
    ----------
    run : Path
        The run's folder.
    """
    paths, damages = communicator.on_root(lambda: sorted(folder_of(run).glob("*.vtkhdf"), reverse=True)), []
    for path in paths:
        try:
            checkpoint = communicator.on_root(lambda path=path: Checkpoint(path))
            checkpoint.examine(communicator)
            return checkpoint, damages
        except Damaged as damage:
            damages.append(f"{path} is damaged and is not used: {damage}")
    return None, damages


class Checkpoints(Observer):
    """Writes checkpoints: at intervals of the clock, when the run is asked to end, before its time is up, and at its end.

    They never shorten a step, so a run has the same bits with them and without. The ranks agree on them at a look, every half
    a second or so.

    Parameters
    ----------
    run : Path
        The run's folder.
    scene_text : str
    every : float
        Interval [s of the clock], longer where checkpoints would take more than a fiftieth of the time; 0: only when the run is
        asked to end.
    walltime : float or None
        Time that the run has [s of the clock], counted from `begun`.
    begun : float
        When the process began, by `time.monotonic` [s].
    signals : Signals
    totals : callable
        Returns what the run has used up so far, see `write_checkpoint`; collective.
    """

    phase = "checkpoints"
    settles = True

    def __init__(self, run, scene_text, every, walltime, begun, signals, totals):
        super().__init__()
        self.folder, self.scene_text, self.every = folder_of(run), scene_text, every
        self.walltime, self.begun, self.signals, self.totals = walltime, begun, signals, totals
        self._finding, self._stride = 0, 1
        self._steps = 2  # until the next look: the first is after a step, so that each part of a run gets on

    def begin(self, simulation):
        self._communicator = simulation.communicator
        self._communicator.on_root(lambda: self.folder.mkdir(exist_ok=True))
        self._looked = self._written = time.monotonic()
        self._last_step = simulation.steps or None
        self._took = 0.0  # s, by the last one
        self._expected = 1.0 + sum(self._communicator.allgather(simulation.particles.nbytes)) / SPEED

    def due(self, now):
        self._steps -= 1
        if self._steps:
            return False
        since = time.monotonic() - self._looked
        stride = max(1, int(self._stride * min(2.0, LOOK / max(since, 1e-6))))
        finding, self._stride = map(int, self._communicator.minimum(np.array([-self._look(since), float(stride)])))
        self._finding, self._steps, self._looked = -finding, self._stride, time.monotonic()
        return self._finding > 0

    def _look(self, since):
        """Return what this rank finds, `since` seconds after its last look; rank 0 watches the clock for all."""
        if self.signals.received:
            return INTERRUPTED if self.signals.received == signal.SIGINT else ASKED
        if self._communicator.rank:
            return 0
        now = time.monotonic()
        if self.walltime is not None and now - self.begun + 2 * (since + self._expected) > self.walltime:
            return TIME_UP
        return WANTED if self.every and now - self._written > max(self.every, self._took / LARGEST_SHARE) else 0

    def observe(self, simulation):
        begin = time.monotonic()
        path = self.folder / f"{simulation.steps:09d}.vtkhdf"
        write_checkpoint(path, simulation, self.scene_text, self.totals())
        simulation.communicator.on_root(self._remove_old)
        self._looked = self._written = time.monotonic()
        self._took = self._expected = self._written - begin
        self._last_step = simulation.steps
        if self._finding > WANTED:
            end = self._end(simulation.time)
            end.alike = True
            raise end

    def finish(self, simulation):
        self._finding = 0
        if self.every and self._last_step != simulation.steps:
            self.observe(simulation)

    def _remove_old(self):
        for path in sorted(self.folder.glob("*.vtkhdf"))[:-KEPT]:
            path.unlink()

    def _end(self, now):
        run = self.folder.parent
        where, cure = str(run), f"go on with parsph resume {run}"
        if self._finding == INTERRUPTED:
            return Interrupted(f"interrupted at t = {now:.6g} s", where, "what was written up to here is complete", cure)
        why = "a signal asked it to end" if self._finding == ASKED else f"its {self.walltime:g} s of wall time are nearly over"
        return Unfinished(f"stopped at t = {now:.6g} s, with a checkpoint", where, why, cure)
