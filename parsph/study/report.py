"""The report of a study: what was run, the table, figures. Built-in studies add what their sources say."""

import platform
from datetime import date

from .. import __version__, viz
from .runner import FAILED, FINISHED


def write_report(study, table):
    """Draw the figures and write ``report.md`` beside them; return its path."""
    folder = table.place.folder
    lines = [f"# {study.title}", "", *_head(table), ""]
    lines += (study.report or general)(table, folder)
    failed = [row for row in study.rows if table.place.status(row) == FAILED]
    if failed:
        lines += ["", "## Failed rows", "", *(f"- `{row.name}`: {table.place.why(row)}" for row in failed)]
    if table.notes:
        lines += ["", "## Not measured", "", *(f"- {note}" for note in table.notes)]
    path = folder / "report.md"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _head(table):
    rows = [row for row in table.rows if row["status"] == FINISHED]
    cost = sum(row["cpu"] for row in rows)
    where = f"parsph {__version__}, {platform.machine()}, {date.today().isoformat()}"
    done = f"{len(rows)} of {len(table.rows)} rows finished, {cost:,.0f} CPU s in all"
    return [f"{done}. {where}. The whole table: `results.csv`, `results.h5`."]


def figure(lines, folder, name, caption, drawing):
    """Save a figure below ``figures/`` and add it to the report's lines."""
    viz.save(drawing, folder / "figures" / f"{name}.png")
    lines += ["", f"![{caption}](figures/{name}.png)", "", f"*{caption}*", ""]


def general(table, folder):
    """Report any study: each metric against the cost, and along each axis whose labels are numbers."""
    lines = []
    for metric in table.study.metrics:
        rows = [row for row in table.rows if row[metric] == row[metric]]
        drawing, ax = viz.figure()
        unit = table.columns[metric]
        points = [(row["row"], row["cpu"], abs(row[metric]), row["group"]) for row in rows]
        viz.error_against_cost(ax, points, ylabel=f"{metric} [{unit}]")
        figure(lines, folder, f"{metric}-cost", f"{metric} against cost", drawing)
        for axis in table.study.axes:
            curves = _along(rows, axis, table.study.axes, metric)
            if curves:
                drawing, ax = viz.figure()
                viz.against(ax, None, curves, axis, f"{metric} [{unit}]")
                figure(lines, folder, f"{metric}-{axis}", f"{metric} along {axis}", drawing)
    return [*lines, "", "## Table", "", *table.markdown()]


def _along(rows, axis, axes, metric):
    """Return {the other labels: (x, y)} where the labels of `axis` are numbers, {} where they are not."""
    curves = {}
    for row in rows:
        if not row[axis]:
            continue
        try:
            x = float(row[axis])
        except ValueError:
            return {}
        others = " ".join([row["group"], *(row[other] for other in axes if other != axis and row[other])])
        curves.setdefault(others, []).append((x, row[metric]))
    return {name: tuple(zip(*sorted(points), strict=True)) for name, points in curves.items() if len(points) > 1}
