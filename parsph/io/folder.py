"""The output folder of a run: found free, never overwritten unasked, written to by one job at a time."""

import fcntl
import os
import platform
import re
import shutil
from contextlib import contextmanager
from pathlib import Path

from ..errors import RunError, SceneError

LOCK = ".lock"


def output_folder(name, out=None, overwrite=False, parent="runs", consent="--overwrite"):
    """Make and return the folder that a run writes to.

    Parameters
    ----------
    name : str
        Name of the scene; without `out` the folder is ``<parent>/<name>-<NNN>``, the next free number.
    out : path, optional
        Folder to use.
    overwrite : bool
        Whether an `out` that holds files may be emptied.
    consent : str
        What a user has to say for that.
    parent : str
        Where folders without a name of their own go.

    Raises
    ------
    SceneError
        When the folder holds files, or cannot be made or written to.
    """
    try:
        if out is None:
            return _next_free(Path(parent), re.sub(r"[^\w.-]+", "-", name))
        folder = Path(out)
        if folder.exists() and (not folder.is_dir() or any(entry.name != LOCK for entry in folder.iterdir())):
            if not overwrite:
                raise SceneError(
                    f"{folder} exists and is not empty",
                    where="--out",
                    why="an earlier run's output is never overwritten unasked",
                    cure=f"name another folder, or say {consent}",
                )
            _empty(folder)
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.touch()
        probe.unlink()
        return folder
    except OSError as error:
        raise SceneError(
            f"cannot write to {out or parent}: {error.strerror}",
            where="--out",
            cure="name a folder that you may write to",
        ) from error


class Claim:
    """What keeps the folder of a run for one job: a lock that the system gives up with the process, however it ends.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    SceneError
        When another process has it.
    """

    def __init__(self, folder):
        self._file = open(folder / LOCK, "a+", encoding="utf-8")  # noqa: SIM115 - open as long as the run
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._file.seek(0)
            holder = self._file.read() or "another process"
            self._file.close()
            why, cure = f"{holder} runs in it, and two would spoil each other's files", "wait for it, or take another folder"
            raise SceneError("is in use", where=str(folder), why=why, cure=cure) from None
        except OSError:  # a file system without locks
            return
        self._file.truncate(0)
        self._file.write(f"process {os.getpid()} on {platform.node()}")
        self._file.flush()

    def release(self):
        """Let others have the folder."""
        if not self._file.closed:
            self._file.truncate(0)  # it stays: who removes it may take it from under another who has just got it
            self._file.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.release()


@contextmanager
def writing(path):
    """Say in words why `path` cannot be written inside the ``with`` block, and leave nothing of it."""
    try:
        yield
    except (
        OSError,
        RuntimeError,
    ) as error:  # h5py raises either, by whether the disk is full at a write or as a file is closed
        path.unlink(missing_ok=True)
        raise failure(path, error) from error


def failure(path, error):
    """Return the `RunError` that says why `path` could not be written."""
    reason = os.strerror(error.errno) if getattr(error, "errno", None) else str(error)
    why = "what was written before is complete"
    return RunError(f"cannot be written: {reason}", where=str(path), why=why, cure="mend that, then go on with parsph resume")


def write_whole(path, content):
    """Write a small file of a text, or of bytes, that is complete or absent, whoever else writes it."""
    temporary = path.with_name(f".{path.name}.{platform.node()}-{os.getpid()}")
    with writing(temporary):
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
        os.replace(temporary, path)


def _next_free(parent, name):
    parent.mkdir(parents=True, exist_ok=True)
    taken = [int(m[1]) for p in parent.iterdir() if (m := re.fullmatch(re.escape(name) + r"-(\d{3,})", p.name))]
    number = max(taken, default=0) + 1
    while True:  # another run may take the number first
        folder = parent / f"{name}-{number:03d}"
        try:
            folder.mkdir()
            return folder
        except FileExistsError:
            number += 1


def _empty(folder):
    """Remove what a run of this program writes, and nothing else."""
    with Claim(folder):
        for entry in ("scene.json", "series.vtkhdf", "summary.json"):
            (folder / entry).unlink(missing_ok=True)
        for entry in ("snapshots", "series", "gauges", "checkpoints"):
            shutil.rmtree(folder / entry, ignore_errors=True)
