"""A whole study: rows, table, figures, report."""

import os
from importlib.util import find_spec

from .. import parallel
from ..errors import RunError, SceneError
from ..progress import console
from ..scene.load import parse_setting
from .declare import builtin_names, load_study
from .report import write_report
from .runner import FAILED, FINISHED, row_of, run_row, run_rows, workspace
from .table import StudyTable


def study(source, overrides=(), jobs=None, ranks=1, resume=False, out=None, quick=False, row=None):
    """Run a study, or what is left of it, and report it.

    Parameters
    ----------
    source : str or Path
        A built-in study, or a TOML file.
    overrides : list of str
        ``key=value``, on top of every row's own.
    jobs : int, optional
        So many rows at a time; default: as many as there are cores for.
    ranks : int
        Ranks per row.
    resume : bool
        Whether `out` may hold finished rows of the same study.
    out : path, optional
        Default: ``studies/<name>-<NNN>``.
    quick : bool
        The study's small size.
    row : str, optional
        Run this row alone, in this process and on its ranks, and report nothing.

    Raises
    ------
    SceneError
        Bad input; nothing was run.
    RunError
        When `row` went wrong, or every row did.
    """
    declared = load_study(source, quick).overridden(dict(map(parse_setting, overrides or ())))
    communicator = parallel.start()
    if row is not None:
        if out is None:
            raise SceneError("needs the study's folder", where="--row", cure="--out DIR, the same for all rows")
        row_of(declared, row)  # a wrong one must not leave a folder behind
        run_row(declared, communicator.on_root(lambda: workspace(declared, out, True)), row, communicator)
        return
    if communicator.size > 1:
        cure = f"parsph study {declared.name} --ranks {communicator.size}, without mpirun; or --row"
        raise SceneError("a study starts its ranks itself", where="mpirun", cure=cure)
    if find_spec("matplotlib") is None:
        why = "a study ends with figures"
        raise SceneError("matplotlib is not installed", where="study", why=why, cure="pip install 'parsph[plots]'")
    place = workspace(declared, out, resume)
    try:
        run_rows(declared, place, jobs or max(1, _cores() // ranks), ranks)
    finally:
        table = StudyTable(declared, place)
        table.write()
    _finish(declared, place, table)


def _cores():
    """Return how many cores this process may use, which in a batch job are fewer than there are."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _finish(declared, place, table):
    rows = declared.rows
    failed = [row for row in rows if place.status(row) == FAILED]
    if len(failed) == len(rows):
        raise RunError("all rows failed", str(place.folder), place.why(failed[0]))
    report = write_report(declared, table)
    finished = sum(place.status(row) == FINISHED for row in rows)
    tail = f"; {len(failed)} failed, see {place.folder / 'failed'}" if failed else ""
    console().print(f"{finished} of {len(rows)} rows finished{tail}\n{place.folder / 'results.csv'}\n{report}")


def print_studies():
    """Print the built-in studies."""
    for name in builtin_names():
        console().print(f"{name:14s} {load_study(name).title}")


def print_rows(source, overrides=(), quick=False):
    """Print number, name and size of all rows: what ``--row`` takes."""
    from ..scene.plan import costs

    declared = load_study(source, quick).overridden(dict(map(parse_setting, overrides or ())))
    scenes = declared.scenes()
    out = console()
    out.print(f"{declared.title}: metrics {', '.join(declared.metrics)}")
    total = 0.0
    for number, row in enumerate(declared.rows):
        cost = costs(scenes[row.name])
        total += cost["core seconds"]
        out.print(f"{number:4d}  {row.name:40s} {cost['particles']:>9,} particles {cost['core seconds']:8.0f} core s")
    out.print(f"about {total:,.0f} core s in all")
