"""The output folder of a run: found free, never overwritten unasked."""

import os
import platform
import re
import shutil
from pathlib import Path

from ..errors import SceneError


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
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
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


def write_whole(path, text):
    """Write a text file that is complete or absent, whoever else writes it."""
    temporary = path.with_name(f".{path.name}.{platform.node()}-{os.getpid()}")
    temporary.write_text(text, encoding="utf-8")
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
    for entry in ("scene.json", "series.vtkhdf", "summary.json"):
        (folder / entry).unlink(missing_ok=True)
    for entry in ("snapshots", "gauges"):
        shutil.rmtree(folder / entry, ignore_errors=True)
