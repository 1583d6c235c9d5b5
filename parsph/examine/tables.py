"""What the commands share: records read and cut, tables and pictures shown."""

import json

from rich.table import Table

from .. import viz
from ..errors import SceneError
from ..progress import console
from ..scene.load import load_scene


def levels_of(results, gauges, start):
    """Return the records of level gauges (see `Results.levels`) from the time `start` [s] on."""
    t, levels, places, names = results.levels(gauges)
    late = t >= start
    if not late.any():
        raise SceneError(f"{start:g} s is after the end of the record", where="--start", cure=f"less than {t[-1]:g} s")
    return t[late], levels[:, late], places, names


def wave_period(results, given, instead=""):
    """Return the period [s] of a run's regular waves: the `given` one, or the wavemaker's.

    Parameters
    ----------
    results : Results
    given : float or None
        What the user says.
    instead : str
        What else would cure that there is none.
    """
    period = load_scene(results.scene).wave_period if given is None else given
    if period is None:
        why, cure = "the scene has no wavemaker that makes waves of one period", f"the period of the waves [s]{instead}"
        raise SceneError("is missing", "--period", why, cure)
    return period


def show(rows, json_file):
    """Print a table, and write its rows to `json_file` if there is one.

    Parameters
    ----------
    rows : list of dict of str to number or str
        What a row lacks stays empty.
    json_file : path or None
    """
    _check_folder(json_file)
    _print(rows)
    if json_file:
        json_file.write_text(json.dumps(rows, indent=1), encoding="utf-8")


def show_all(tables, json_file):
    """Print several tables under their names, and write them to `json_file` if there is one, as lists of rows by name."""
    _check_folder(json_file)
    for name, rows in tables.items():
        _print(rows, name)
    if json_file:
        json_file.write_text(json.dumps(tables, indent=1), encoding="utf-8")


def draw(path, artist, rows=1):
    """Let ``artist(ax)`` draw a figure, save it and print its path; without matplotlib say so and go on.

    Parameters
    ----------
    path : Path
    artist : callable
        Of one `ax`, or of an array of them where there are several rows.
    rows : int
        Of panels, above the same x.
    """
    try:
        drawing, ax = viz.figure(rows, share_x=rows > 1)
    except SceneError as error:
        console().print(f"no {path.name}: {error}")
        return
    artist(ax)
    console().print(str(viz.save(drawing, path)))


def _check_folder(json_file):
    if json_file and not json_file.parent.is_dir():
        raise SceneError(f"there is no folder {json_file.parent}", where="--json", cure="name a file in a folder that is there")


def _print(rows, title=None):
    columns = list(dict.fromkeys(name for row in rows for name in row))
    table = Table(*columns, title=title)
    for row in rows:
        table.add_row(*(f"{row[name]:.5g}" if isinstance(row.get(name), float) else str(row.get(name, "")) for name in columns))
    console().print(table)
