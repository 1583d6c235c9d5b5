"""What a study is: groups of scenes that span axes of overrides, and the metrics that every row of its table gets.

A study is a TOML file, or one of the built-in ones, which are Python. Rows are run by `parsph.study.runner`.
"""

import importlib
import itertools
import math
import os
import pkgutil
import re
from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from ..errors import SceneError, did_you_mean
from ..scene.load import load_scene, read_keys, told_at_once, validated
from . import builtin
from .metrics import COSTS, METRICS

MOST_ROWS = 10_000  # of a study from a file: checks of some seconds, and a job array that queues take


@dataclass(frozen=True)
class Row:
    """One run of a study.

    Attributes
    ----------
    name : str
        Folder name: the group and the labels.
    group : str
    labels : dict
        Axis to label.
    base : str
        Scene.
    overrides : dict
        Dotted keys to values.
    """

    name: str
    group: str
    labels: dict
    base: str
    overrides: dict


@dataclass(frozen=True)
class Group:
    """Scenes that differ along axes.

    Attributes
    ----------
    name : str
    base : str
        Scene.
    settings : dict
        Overrides of all of them.
    axes : dict
        Axis to {label: overrides}; rows are all combinations.
    references : dict
        Role to group, where it is not that of the study.
    on_top : dict
        Overrides that come last.
    metrics : tuple of str
        Those of the study's that its rows get; empty: all.
    """

    name: str
    base: str
    settings: dict = field(default_factory=dict)
    axes: dict = field(default_factory=dict)
    references: dict = field(default_factory=dict)
    on_top: dict = field(default_factory=dict)
    metrics: tuple = ()

    def rows(self):
        """Return the rows of this group."""
        rows = []
        for labels in itertools.product(*self.axes.values()):
            overrides = dict(self.settings)
            for axis, label in zip(self.axes, labels, strict=True):
                overrides |= self.axes[axis][label]
            overrides |= self.on_top
            name = re.sub(r"[^\w.-]+", "-", "_".join([self.name, *map(str, labels)]))
            rows.append(Row(name, self.name, dict(zip(self.axes, map(str, labels), strict=True)), self.base, overrides))
        return rows


@dataclass(frozen=True)
class Study:
    """A matrix of scenes, what is measured on them, and how it is reported.

    Attributes
    ----------
    name, title : str
    groups : tuple of Group
    metrics : tuple of str
        Names of `parsph.study.metrics.METRICS`.
    references : dict
        Role to group name, as {"infinite": "far"}: metrics that compare take the first row of that group whose labels agree
        on the axes that both have.
    report : callable or None
        ``report(table, folder)`` returns Markdown lines and draws its figures; None: the general report.
    """

    name: str
    title: str
    groups: tuple
    metrics: tuple
    references: dict = field(default_factory=dict)
    report: object = None

    @cached_property
    def rows(self):
        """All rows, in order."""
        return [row for group in self.groups for row in group.rows()]

    @property
    def axes(self):
        """Names of all axes, in order of appearance."""
        return list(dict.fromkeys(axis for group in self.groups for axis in group.axes))

    def metrics_of(self, row):
        """Return the names of the metrics that a row gets."""
        return next(group.metrics for group in self.groups if group.name == row.group) or self.metrics

    def reference(self, row, role):
        """Return the row that `row` is compared with in this role, None when there is none or others are compared with it."""
        own = next(group.references for group in self.groups if group.name == row.group)
        group = own.get(role, self.references.get(role))
        compared = {holder.references.get(role) for holder in (self, *self.groups)}
        for other in self.rows if row.group not in compared else []:
            shared = other.labels.keys() & row.labels.keys()
            if other.group == group and all(other.labels[axis] == row.labels[axis] for axis in shared):
                return other
        return None

    def overridden(self, settings):
        """Return this study with overrides (a dict) on top of all rows' own."""
        return replace(self, groups=tuple(replace(group, on_top=settings) for group in self.groups))

    def scenes(self):
        """Return {row name: Scene} of all rows, checked, with the metrics' own demands.

        Raises
        ------
        SceneFaults
            With the faults of all rows.
        """
        scenes, faults = {}, {}
        compared = {name for group in (self, *self.groups) for name in group.references.values()}
        for row in self.rows:
            try:
                scene = load_scene(row.base, row.overrides)
                for metric in self.metrics_of(row) if row.group not in compared else ():
                    METRICS[metric].check(scene)
                scenes[row.name] = scene
            except SceneError as error:
                for fault in getattr(error, "faults", [error]):
                    faults.setdefault((fault.what, fault.where, fault.why, fault.cure), []).append(row.name)
        if faults:
            raise told_at_once(list(faults.items()), "the study", lambda entry: _of_rows(*entry))
        return scenes


def _of_rows(fault, rows):
    """Return the error for a fault that several rows share."""
    what, where, why, cure = fault
    more = f" and {len(rows) - 1} more" if len(rows) > 1 else ""
    return SceneError(what, f"row {rows[0]}{more}: {where}".rstrip(": "), why, cure)


def builtin_names():
    """Return the names of the built-in studies."""
    return sorted(module.name.replace("_", "-") for module in pkgutil.iter_modules(builtin.__path__))


def load_study(source, quick=False):
    """Return the study that `source` names.

    Parameters
    ----------
    source : str or Path
        A built-in study, or a TOML file.
    quick : bool
        Its small size.

    Raises
    ------
    SceneError, SceneFaults
        When there is no such study, or its declaration is wrong.
    """
    if str(source) in builtin_names():
        module = importlib.import_module(f"{builtin.__name__}.{str(source).replace('-', '_')}")
        return module.study(quick)
    path = Path(source)
    if not os.path.exists(path):
        cure = f"{did_you_mean(source, builtin_names())}built-in studies: {', '.join(builtin_names())}; or a TOML file"
        raise SceneError(f"no study {str(source)!r}", cure=cure)
    try:
        return validated(StudyFile, read_keys(path), "the study").study(path.stem, quick)
    except RecursionError:
        raise SceneError("is nested too deeply", where=str(path), cure="settings as { numerics.dx = 0.1 }") from None


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class GroupSection(_Section):
    """A group of a study's TOML file."""

    name: str = Field(pattern=r"^\w[\w.-]*$", description="name of the group: letters, digits and . _ -")
    base: str | None = Field(None, description="scene; default: that of the study")
    settings: dict = Field({}, description='overrides of all its rows, as { "time.end" = 5.0 }')
    axes: dict[str, dict[str, dict]] = Field({}, description="axis, label, overrides; rows are all combinations")
    references: dict[str, str] = Field({}, description="role to group, where it is not that of the study")

    def group(self, base, settings):
        """Return the `Group` that this declares, given the study's scene and settings."""
        axes = {axis: {label: _dotted(overrides) for label, overrides in labels.items()} for axis, labels in self.axes.items()}
        return Group(self.name, self.base or base, settings | _dotted(self.settings), axes, self.references)


class StudyFile(_Section):
    """A study's TOML file."""

    title: str = Field("", description="one line for the report")
    base: str = Field("pool", description="scene of all groups that name none")
    metrics: list[str] = Field(description="what is measured on every row")
    settings: dict = Field({}, description='overrides of all rows, as { "time.end" = 5.0 }')
    quick: dict = Field({}, description="more overrides with --quick")
    references: dict[str, str] = Field({}, description='role to group, as { infinite = "far" }')
    groups: list[GroupSection] = Field(min_length=1, description="groups of rows")

    def study(self, name, quick):
        """Return the `Study` that this declares.

        Raises
        ------
        SceneFaults
            When metrics, groups or references do not fit together.
        """
        names = [group.name for group in self.groups]
        faults = [
            SceneError(f"two groups are called {other!r}", where="groups", cure="a name of its own for each")
            for other in _repeated(names)
        ]
        rows = sum(math.prod(map(len, group.axes.values())) for group in self.groups)
        if rows > MOST_ROWS:
            faults.append(
                SceneError(f"{rows:,} rows, more than {MOST_ROWS:,}", "groups", cure="fewer labels, or several studies")
            )
        taken = {"row", "group", "status", "reached", *COSTS, *self.metrics}
        for number, group in enumerate(self.groups):
            for axis in taken.intersection(group.axes):
                why = "the table has a column of that name"
                faults.append(SceneError(f"{axis!r} is taken", f"groups.{number}.axes", why, "another name for the axis"))
        for number, metric in enumerate(self.metrics):
            faults += metric_faults(metric, f"metrics.{number}", self.references)
        for where, holder in (("", self), *((f"groups.{number}.", group) for number, group in enumerate(self.groups))):
            for role, group in holder.references.items():
                if group not in names:
                    cure = f"one of: {', '.join(names)}"
                    faults.append(SceneError(f"no group {group!r}", where=f"{where}references.{role}", cure=cure))
        if faults:
            raise told_at_once(faults, "the study")
        settings = _dotted(self.settings) | (_dotted(self.quick) if quick else {})
        groups = tuple(group.group(self.base, settings) for group in self.groups)
        declared = Study(name, self.title or name, groups, tuple(self.metrics), self.references)
        twice = _repeated(row.name for row in declared.rows)
        if twice:
            why = "a folder takes letters, digits and . _ - of groups and labels"
            cure = "other names or labels"
            called = [SceneError(f"two rows are called {row!r}", "groups", why, cure) for row in twice]
            raise told_at_once(called, "the study")
        return declared


def _repeated(names):
    """Return those that occur more than once, in order of appearance."""
    return [name for name, count in Counter(names).items() if count > 1]


def _dotted(settings, prefix=""):
    """Return overrides with their full keys: in TOML ``numerics.dx = 0.1`` is a table in a table, and means "numerics.dx"."""
    flat = {}
    for key, value in settings.items():
        inner = isinstance(value, dict) and value  # an empty section is a value: a wall without keys
        flat |= _dotted(value, f"{prefix}{key}.") if inner else {f"{prefix}{key}": value}
    return flat


def metric_faults(name, where, references):
    """Return what is wrong with a metric of this name, a list of SceneError."""
    if name not in METRICS:
        cure = f"{did_you_mean(name, METRICS)}one of: {', '.join(METRICS)}"
        return [SceneError(f"unknown metric {name!r}", where=where, cure=cure)]
    missing = [role for role in METRICS[name].roles if role not in references]
    if missing:
        cure = f'[references] {missing[0]} = "name of a group"'
        return [SceneError(f"{name!r} compares with {' and '.join(missing)}", where=where, why="no group is that", cure=cure)]
    return []
