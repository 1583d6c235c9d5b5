"""The table of a study: one row a run, with labels, metrics and costs; as CSV and as HDF5."""

import csv
import math

import h5py
import numpy as np

from ..errors import SceneError
from ..io.results import Results
from .metrics import COSTS, METRICS
from .runner import FINISHED


class StudyTable:
    """The rows of a study with what was measured.

    Attributes
    ----------
    study : Study
    place : Workspace
    columns : dict
        Name to unit, in order: row, group, axes, status, metrics, how far it got, costs.
    rows : list of dict
        Column to value; numbers that a row does not have are NaN.
    notes : list of str
        Why a finished row lacks a number.
    """

    def __init__(self, study, place):
        self.study, self.place = study, place
        metrics = {name: METRICS[name].unit for name in study.metrics}
        costs = {name: unit for name, (_, unit) in COSTS.items()}
        self.columns = dict.fromkeys(["row", "group", *study.axes, "status"], "") | metrics | {"reached": "s"} | costs
        self.notes = []
        self.rows = [self._measured(row) for row in study.rows]

    def _measured(self, row):
        values = {"row": row.name, "group": row.group, "status": self.place.status(row)}
        values |= {axis: row.labels.get(axis, "") for axis in self.study.axes}
        results = self.place.results(row)
        own = self.study.metrics_of(row)
        for name in self.study.metrics:
            values[name] = self._metric(METRICS[name], row, results) if name in own else math.nan
        values["reached"] = self.place.reached(row)
        summary = results.summary if results else None
        for name, (key, _) in COSTS.items():
            if summary is None:
                values[name] = math.nan
            elif key:
                values[name] = summary[key]
            else:  # the mean over ranks, of all of them
                values[name] = summary["phases [s]"].get(name, (0, 0, 0))[1] * summary["ranks"]
        return values

    def _metric(self, metric, row, results):
        """Return the number, NaN where the row or what it is compared with is not there."""
        others = {role: self.study.reference(row, role) for role in metric.roles}
        found = {role: self.place.results(other) for role, other in others.items() if other}
        if results is None or any(found.get(role) is None for role in metric.roles):
            return math.nan
        try:
            return float(metric.measure(results, found))
        except SceneError as error:  # a row that cannot be measured is no reason to lose the others
            self.notes.append(f"`{row.name}`, {metric.name}: {error}")
            return math.nan

    def results(self, name):
        """Return the `Results` of the row `name`, None when it has not finished."""
        return self.place.results(next(row for row in self.study.rows if row.name == name))

    def left(self, name):
        """Return the `Results` of whatever the row `name` left, finished or not; None when it left nothing."""
        folder = self.place.run_folder(next(row for row in self.study.rows if row.name == name))
        return Results(folder) if (folder / "scene.json").exists() else None

    def select(self, **labels):
        """Return the finished rows with these labels (group among them), as ``select(group="layers", variant="M0")``."""
        wanted = labels.items()
        return [row for row in self.rows if row["status"] == FINISHED and all(row.get(k) == v for k, v in wanted)]

    def write(self):
        """Write ``results.csv`` and ``results.h5``."""
        header = [f"{name} [{unit}]" if unit not in ("", "-") else name for name, unit in self.columns.items()]
        with open(self.place.folder / "results.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(header)
            writer.writerows([[row[name] for name in self.columns] for row in self.rows])
        with h5py.File(self.place.folder / "results.h5", "w") as file:
            for name, unit in self.columns.items():
                values = [row[name] for row in self.rows]
                text = isinstance(values[0], str)
                data = np.array(values, h5py.string_dtype()) if text else np.array(values, float)
                file.create_dataset(name, data=data).attrs["unit"] = unit

    def markdown(self, columns=None, rows=None):
        """Return the lines of a Markdown table of the given columns and rows; default: all."""
        return markdown(columns or list(self.columns), self.rows if rows is None else rows)


def read_rows(path):
    """Return the rows of a ``results.csv``, dicts with names of columns without units; numbers that are missing are NaN."""
    with open(path, newline="", encoding="utf-8") as file:
        header, *lines = csv.reader(file)
    names = [name.partition(" [")[0] for name in header]
    numbers = {*METRICS, *COSTS, "reached"}
    return [{name: float(text) if name in numbers else text for name, text in zip(names, line, strict=True)} for line in lines]


def markdown(columns, rows):
    """Return the lines of a Markdown table of `rows`, dicts of text and numbers."""
    lines = ["| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    return lines + ["| " + " | ".join(_text(row[name]) for name in columns) + " |" for row in rows]


def _text(value):
    if isinstance(value, str):
        return value
    if math.isnan(value):
        return ""
    return f"{value:,.0f}" if float(value).is_integer() and abs(value) >= 100 else f"{value:.4g}"
