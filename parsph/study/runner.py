"""Runs the rows of a study: each a process of its own in its own folder, finished ones never again.

``scenes/<row>.json`` is what a row runs, ``rows/<row>/`` what it leaves, ``logs/<row>.log`` what it printed and
``failed/<row>.json`` why it failed. A row is finished when its folder has a summary.
"""

import itertools
import json
import math
import re
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ..errors import Interrupted, SceneError, Unfinished
from ..io.checkpoints import has_checkpoint
from ..io.folder import output_folder, write_whole
from ..io.results import Results
from ..parallel import python_command
from ..progress import console, duration
from ..run import resume, run
from ..scene.load import scene_text

FINISHED, FAILED, OPEN = "finished", "failed", "open"


class Workspace:
    """The folder of a study.

    Parameters
    ----------
    folder : Path
    """

    def __init__(self, folder):
        self.folder = Path(folder)

    def scene(self, row):
        """The path of what a row runs."""
        return self.folder / "scenes" / f"{row.name}.json"

    def run_folder(self, row):
        """The folder that a row's run leaves."""
        return self.folder / "rows" / row.name

    def log(self, row):
        """The path of what a row printed."""
        return self.folder / "logs" / f"{row.name}.log"

    def failure(self, row):
        """The path of why a row failed."""
        return self.folder / "failed" / f"{row.name}.json"

    def status(self, row):
        """Return "finished", "failed" or "open"."""
        if (self.run_folder(row) / "summary.json").exists():
            return FINISHED
        return FAILED if self.failure(row).exists() else OPEN

    def begun(self, row):
        """Return whether a row was stopped on its way, so that it can go on."""
        return self.status(row) == OPEN and has_checkpoint(self.run_folder(row))

    def results(self, row):
        """Return the `Results` of a finished row, None for others."""
        return Results(self.run_folder(row)) if self.status(row) == FINISHED else None

    def why(self, row):
        """Return why a row failed, one line; empty for others."""
        return json.loads(self.failure(row).read_text(encoding="utf-8"))["why"] if self.status(row) == FAILED else ""

    def reached(self, row):
        """Return how far a row got [s]: to its end, or where it failed, which its error says or else its last snapshot."""
        folder = self.run_folder(row)
        if not (folder / "scene.json").exists():
            return math.nan
        results = Results(folder)
        if results.summary:
            return results.scene["time"]["end"]
        told = re.search(r"at t = (\S+) s\b", self.why(row))
        if told:
            return float(told.group(1))
        return results.snapshot()["time"] if results.snapshots else math.nan

    def prepare(self, scenes):
        """Write the scenes of all rows ({row name: Scene}), keeping those that are there.

        Raises
        ------
        SceneError
            When a row is declared otherwise than what the folder has run.
        """
        for part in ("scenes", "rows", "logs", "failed"):
            (self.folder / part).mkdir(parents=True, exist_ok=True)
        for name, scene in scenes.items():
            path, text = self.folder / "scenes" / f"{name}.json", scene_text(scene)
            if not path.exists():
                write_whole(path, text)
            elif path.read_text(encoding="utf-8") != text:
                raise SceneError(
                    f"row {name} is declared otherwise than in this folder",
                    where=str(self.folder),
                    why="finished rows would be mixed with others",
                    cure="the same study and --set as before, or another --out",
                )

    def fail(self, row, why, code):
        """Record that a row failed."""
        write_whole(self.failure(row), json.dumps({"row": row.name, "exit code": code, "why": why}, indent=1))


def workspace(study, out, resume):
    """Return the `Workspace` of a study, with the scenes of all rows written.

    Parameters
    ----------
    study : Study
    out : path or None
        Default: ``studies/<name>-<NNN>``, the next free number.
    resume : bool
        Whether the folder may hold rows of the same study.

    Raises
    ------
    SceneError
        When the folder holds something else, or a scene of the study is wrong.
    """
    scenes = study.scenes()
    if out is not None and Path(out).exists() and not Path(out).is_dir():
        raise SceneError(f"{out} is no folder", where="--out", cure="name a folder")
    if resume and out is None:
        raise SceneError("needs the folder to go on with", where="--resume", cure="--out DIR, as it was printed")
    folder = Path(out) if resume else output_folder(study.name, out, parent="studies", consent="--resume")
    place = Workspace(folder)
    place.prepare(scenes)
    return place


def run_row(study, place, which, communicator):
    """Run one row in this process, on all its ranks: what a task of a job array does.

    Parameters
    ----------
    study : Study
    place : Workspace
    which : str
        Name of the row, or its number from 0.

    Raises
    ------
    SceneError
        When there is no such row.
    RunError
        When the run went wrong; it is recorded too.
    """
    row = row_of(study, which)
    if place.status(row) == FINISHED:
        console().print(f"row {row.name} is finished already")
        return
    try:
        if place.begun(row):
            resume(place.run_folder(row), communicator=communicator)
        else:
            run(place.scene(row), (), place.run_folder(row), overwrite=True, communicator=communicator)
    except Exception as error:
        if not isinstance(error, Interrupted | Unfinished):  # whichever rank sees it first
            place.fail(row, str(error), getattr(error, "exit_code", 1))
        raise
    if communicator.rank == 0:
        place.failure(row).unlink(missing_ok=True)


def row_of(study, which):
    """Return the row of this name or number; SceneError when there is none."""
    rows = study.rows
    if str(which).isdecimal() and int(which) < len(rows):
        return rows[int(which)]
    for row in rows:
        if row.name == which:
            return row
    raise SceneError(
        f"no row {which!r}", where="--row", cure=f"0 to {len(rows) - 1}, or a name of parsph study {study.name} --list"
    )


def run_rows(study, place, jobs, ranks):
    """Run all rows that are not finished, `jobs` at a time, each on `ranks` ranks. Failed ones are recorded, and run again.

    Raises
    ------
    Interrupted
        On Ctrl-C; finished rows are kept, others go on from their checkpoints.
    """
    rows = study.rows
    todo = [row for row in rows if place.status(row) != FINISHED]
    out = console()
    done = len(rows) - len(todo)
    out.print(
        f"{study.name}: {len(rows)} rows, {done} finished; {jobs} at a time on {ranks} rank(s) each; {place.folder}",
    )
    children, stopping, lock, begin = {}, threading.Event(), threading.Lock(), time.perf_counter()

    def work(row):
        nonlocal done
        if stopping.is_set():
            return
        code = _run_process(row, place, ranks, children, stopping)
        if stopping.is_set() or code in (Interrupted.exit_code, Unfinished.exit_code):
            return
        with lock:
            done += 1
            ran = done - (len(rows) - len(todo))
            left = (time.perf_counter() - begin) / ran * (len(todo) - ran)
            if code == 0:
                place.failure(row).unlink(missing_ok=True)
                summary = place.results(row).summary
                told = f"{summary['cpu [s]']:.1f} CPU s"
            else:
                place.fail(row, _last_error(place.log(row)), code)
                told = f"FAILED: {place.why(row)}"
            out.print(f"[{done}/{len(rows)}] {row.name}: {told}; eta {duration(left)}")

    with ThreadPoolExecutor(jobs) as pool:
        try:
            for future in [pool.submit(work, row) for row in todo]:
                future.result()
        except BaseException as error:
            stopping.set()
            for process in list(children.values()):
                process.terminate()
            if isinstance(error, KeyboardInterrupt):
                why = "finished rows are kept"
                raise Interrupted("interrupted", str(place.folder), why, f"go on with --resume --out {place.folder}") from None
            raise


def _run_process(row, place, ranks, children, stopping):
    """Run a row in a process of its own; return its exit code."""
    folder = str(place.run_folder(row))
    wanted = ["resume", folder] if place.begun(row) else ["run", str(place.scene(row)), "--out", folder, "--overwrite"]
    command = python_command("-m", "parsph", *wanted, ranks=ranks)
    with open(place.log(row), "w", encoding="utf-8") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        children[row.name] = process
        if stopping.is_set():
            process.terminate()
        code = process.wait()
        del children[row.name]
    return code


def _last_error(log):
    """Return what the last error in a row's log says, in one line."""
    text = log.read_text(encoding="utf-8", errors="replace")
    _, found, tail = ("\n" + text).rpartition("\nerror:")
    if not found:  # a traceback says it in its last line
        return text.strip().rpartition("\n")[2]
    first, *others = tail.split("\n")
    rest = itertools.takewhile(lambda line: line.startswith("  "), others)  # what follows is of the launcher
    return " ".join(" ".join([first, *rest]).split())
