"""Validation cases against theory: case, metric, value, bar, pass.

Every bar is an upper limit on the absolute value. What a case cost is a row without a bar.
"""

import json
import os

from rich.table import Table
from rich.text import Text

from ..errors import SceneError
from ..progress import console
from . import (  # they register their cases in this order
    basins,  # noqa: F401
    channels,  # noqa: F401
    free,  # noqa: F401
    ghosts,  # noqa: F401
    kernels,  # noqa: F401
    long,  # noqa: F401
    robustness,  # noqa: F401
    shallow,  # noqa: F401
    soak,  # noqa: F401
    treatments,  # noqa: F401
    violent,  # noqa: F401
    wave_absorption,  # noqa: F401
    waves,  # noqa: F401
)
from .registry import CASES


def verify(cases=None, quick=False, json_file=None):
    """Run validation cases and print their results.

    Parameters
    ----------
    cases : list of str, optional
        Names; default: all.
    quick : bool
        Shorter runs.
    json_file : Path, optional
        Where to write the rows: objects with the keys case, metric, value, unit, bar, pass.

    Returns
    -------
    bool
        Whether every bar was met.

    Raises
    ------
    SceneError
        When there is no case of a name.
    """
    for name in cases or []:
        if name not in CASES:
            raise SceneError(f"no case {name!r}", where="verify", cure=f"one of {', '.join(CASES)}")
    rows = []
    for name in cases or CASES:
        begin = _processor_time()
        for metric, value, unit, bar in CASES[name](quick):
            rows.append(_row(name, metric, value, unit, bar))
        rows.append(_row(name, "cost", _processor_time() - begin, "CPU s", None))
        console().print(_table([row for row in rows if row["case"] == name]))
    if json_file:
        json_file.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return all(row["pass"] for row in rows)


def _processor_time():
    """Return the CPU time [s] of this process and of those it has started."""
    return sum(os.times()[:4])


def _row(name, metric, value, unit, bar):
    met = bar is None or abs(value) <= bar
    return {"case": name, "metric": metric, "value": float(value), "unit": unit, "bar": bar, "pass": bool(met)}


def _table(rows):
    table = Table("case", "metric", "value", "unit", "bar", "pass")
    for row in rows:
        bar = "" if row["bar"] is None else f"<= {row['bar']:g}"
        verdict = "" if row["bar"] is None else ("yes" if row["pass"] else Text("NO", "bold red"))
        table.add_row(row["case"], row["metric"], f"{row['value']:.4g}", row["unit"], bar, verdict)
    return table
