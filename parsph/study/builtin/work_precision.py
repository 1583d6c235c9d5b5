"""What accuracy costs: six flows with a reference each, resolutions, the presets, and from `standard` one change at a time.

The flows: a standing wave in a basin, regular waves over a bed, a solitary wave on a wall, a dam break, a square that rotates,
a drop that stretches. Presets replace what the scenes themselves say of the keys that presets govern.
"""

import math
from dataclasses import dataclass

from ... import viz
from ...scene.presets import PRESETS
from ..declare import Group, Study
from ..report import figure
from ..runner import FINISHED
from ..table import markdown
from .wall_treatments import ENERGY, PERIOD, TRANSDUCER

WAVE_PERIOD = 1.626  # of the regular waves [s]
LEVELS = [{"kind": "level", "x": x, "every": 0.02} for x in (1.5, 2.3, 3.1, 4.2, 5.3, 6.4, 7.5)]
RUNUP = {"kind": "runup", "wall": "right", "every": 0.005}


@dataclass(frozen=True)
class Case:
    """A flow with a reference.

    Attributes
    ----------
    scene, title : str
    metric : str
        Its error.
    reference : str
        What the error is against.
    settings : dict
        Overrides of the scene.
    spacings : dict
        Particles per depth, edge or radius to dx [m], coarse to fine.
    c0 : float or None
        Sound speed [m/s] where no depth decides it.
    """

    scene: str
    title: str
    metric: str
    reference: str
    settings: dict
    spacings: dict
    c0: float | None = None


CASES = {
    "seiche": Case(
        "seiche",
        "Standing wave",
        "velocity-error",
        "velocities over five periods, L2, linear theory",
        {"time.end": 5 * PERIOD, "output.snapshots.every": PERIOD / 12, "gauges": [ENERGY]},
        {"10": 0.02, "20": 0.01, "40": 0.005},
    ),
    "waves": Case(
        "regular-waves",
        "Regular waves",
        "wave-error",
        "first harmonics along two wavelengths behind the wavemaker, periods 7 to 10, the steady wave asked for",
        {"time.end": 10 * WAVE_PERIOD, "output.snapshots.every": 5 * WAVE_PERIOD, "gauges": LEVELS},
        {"8": 0.0625, "12": 0.5 / 12, "16": 0.03125},
    ),
    "solitary": Case(
        "solitary-wall",
        "Solitary wave on a wall",
        "runup-error",
        "run-up, potential flow",
        {"output.snapshots.every": 2.9, "gauges": [RUNUP]},
        {"10": 0.025, "20": 0.0125, "30": 0.25 / 30},
    ),
    "dam": Case(
        "dam-break",
        "Dam break",
        "plateau-error",
        "pressure on the wall behind the front, Buchner's record",
        {"time.end": 1.5, "output.snapshots.every": 0.75, "gauges": [TRANSDUCER]},
        {"20": 0.03, "40": 0.015, "80": 0.0075},
    ),
    "patch": Case(
        "square-patch",
        "Rotating square",
        "energy-change",
        "energy at omega t = 4, which is conserved",
        {"output.snapshots.every": 1.0, "gauges": [ENERGY]},
        {"25": 0.04, "50": 0.02, "100": 0.01},
        c0=10.0,
    ),
    "drop": Case(
        "elliptical-drop",
        "Stretching drop",
        "axes-error",
        "half axes at A t = 0.75, the exact flow",
        {"output.snapshots.every": 0.25, "gauges": [ENERGY]},
        {"25": 0.04, "50": 0.02, "100": 0.01},
        c0=15.0,
    ),
}
METRICS = (*(case.metric for case in CASES.values()), "work")
CHANGED = "-changes"  # groups
PER = "particles per length"
HALVING = ("standard: error", "standard: cost", "draft, dx/2: error", "draft, dx/2: cost")
COSTS = {"work": "work [CPU s]", "wall": "wall [s]"}
COLUMNS = ("work", "wall", "ranks", "particles")
STANDARD, DRAFT = "standard", "draft"
CHANGES = {  # from `standard`, one at a time
    "h/dx 1.5": {"numerics.h_over_dx": 1.5},
    "h/dx 2.5": {"numerics.h_over_dx": 2.5},
    "Wendland C4, h/dx 2.4": {"numerics.kernel": "wendland-c4", "numerics.h_over_dx": 2.4},
    "quintic spline, h/dx 4/3": {"numerics.kernel": "quintic-spline", "numerics.h_over_dx": 4 / 3},
    "c0 / 1.5": {"numerics.c0_factor": 8.0},
    "1.5 c0": {"numerics.c0_factor": 18.0},
    "continuity": {"numerics.density": "continuity"},
    "continuity, verlet": {"numerics.density": "continuity", "numerics.integrator": "verlet"},
    "continuity, midpoint": {"numerics.density": "continuity", "numerics.integrator": "midpoint"},
    "continuity, antuono": {"numerics.density": "continuity", "numerics.diffusion": "antuono"},
    "delta 0.02": {"numerics.delta": 0.02},
    "delta 0.1": {"numerics.delta": 0.1},
    "float64": {"numerics.precision": "float64"},
}


def study(quick):
    """Return the study; quick: the presets alone."""
    groups = []
    for name, case in CASES.items():
        axes = {"numerics": {preset: {"numerics.preset": preset} for preset in PRESETS}, "per": _spacings(case)}
        groups.append(Group(name, case.scene, case.settings, axes, metrics=(case.metric, "work")))
        if not quick:
            changed = {change: _of_case(case, keys) for change, keys in CHANGES.items()}
            axes = {"numerics": changed, "per": _spacings(case, finest=False)}
            settings = {**case.settings, "numerics.preset": STANDARD}
            groups.append(Group(name + CHANGED, case.scene, settings, axes, metrics=(case.metric, "work")))
    title = "What accuracy costs: six flows with a reference, presets and one change at a time"
    return Study("work-precision", title, tuple(groups), METRICS, report=report)


def _spacings(case, finest=True):
    """Return the axis of resolutions, the finest among them or not."""
    return {per: {"numerics.dx": dx} for per, dx in list(case.spacings.items())[: None if finest else -1]}


def _of_case(case, keys):
    """Return a change for a flow whose sound speed is a number of its own."""
    factor = keys.get("numerics.c0_factor")
    if case.c0 is None or factor is None:
        return keys
    return {"numerics.c0": case.c0 * factor / PRESETS[STANDARD]["c0_factor"]}


def report(table, folder):
    """Return the report's lines: presets, what each change does, then flow by flow error against cost."""
    lines = ["", "## Presets", "", *presets(table.rows), "", "## Standard and draft", "", *halving(table.rows), ""]
    if any(row["group"].endswith(CHANGED) for row in table.rows):
        lines += ["## One change at a time", "", *changes(table.rows), ""]
    for name, case in CASES.items():
        rows = rows_of(table.rows, name)
        lines += ["", f"## {case.title}", "", f"`{case.metric}` [%]: {case.reference}.", ""]
        lines += table.markdown(["numerics", "per", "status", "reached", case.metric, *COLUMNS], rows)
        for cost in COSTS:
            caption = caption_of(table.rows, name, cost)
            figure(lines, folder, f"{name}-{cost}", caption, draw(table.rows, name, cost))
    return lines


def rows_of(rows, name):
    """Return those of a flow, presets and changes."""
    return [row for row in rows if row["group"] in (name, name + CHANGED)]


def _row(rows, name, numerics, per):
    """Return the row of a flow with this preset or change and resolution when it has finished with an error, else None."""
    found = (row for row in rows_of(rows, name) if (row["numerics"], row["per"]) == (numerics, per))
    return next((row for row in found if row["status"] == FINISHED and math.isfinite(row[CASES[name].metric])), None)


def presets(rows):
    """Return the lines of a table: error and CPU time of all steps, by flow, resolution and preset."""
    told = []
    for name, case in CASES.items():
        for per in case.spacings:
            entry = {"flow": case.title, PER: per}
            for preset in PRESETS:
                row = _row(rows, name, preset, per)
                entry[preset] = f"{row[case.metric]:+.3g} %, {row['work']:.3g} s" if row else "none"
            told.append(entry)
    return markdown(list(told[0]), told)


def halving(rows):
    """Return the lines of a table: `standard` and a `draft` with half the spacing, error and cost over those of `draft`."""
    told = []
    for name, case in CASES.items():
        for per in case.spacings:
            draft, *others = (_row(rows, name, *of) for of in ((DRAFT, per), (STANDARD, per), (DRAFT, str(2 * int(per)))))
            if draft is None:
                continue
            ratios = [abs(row[key] / draft[key]) if row else math.nan for row in others for key in (case.metric, "work")]
            told.append(dict(zip(("flow", PER, *HALVING), (case.title, per, *ratios), strict=True)))
    return markdown(list(told[0]), told) if told else ["No draft has finished."]


def changes(rows):
    """Return the lines of a table: error and cost of each change over those of `standard`, at the second finest resolutions."""
    told = []
    for change in CHANGES:
        entry = {"change": change}
        for name, case in CASES.items():
            changed, standard = (_row(rows, name, numerics, list(case.spacings)[-2]) for numerics in (change, STANDARD))
            ratios = (
                [f"{abs(changed[key] / standard[key]):.2g}" for key in (case.metric, "work")] if changed and standard else []
            )
            entry[case.title] = ", ".join(ratios) or "none"
        told.append(entry)
    return markdown(list(told[0]), told)


def caption_of(rows, name, cost):
    """Return the caption of `draw`."""
    ranks = next((f"{row['ranks']:.0f} rank(s); " for row in _finished(rows, name)), "")
    return f"{CASES[name].title}: {CASES[name].metric} against {cost}; {ranks}labels: {PER}"


def draw(rows, name, cost):
    """Return the figure of the error of a flow against "work" or "wall", with the Pareto front; changes on it are named."""
    case, rows = CASES[name], _finished(rows, name)
    best = viz.pareto([row[cost] for row in rows], [abs(row[case.metric]) for row in rows])
    points = []
    for number, row in enumerate(rows):
        changed = row["group"].endswith(CHANGED)
        label = f"{row['numerics']}: {row['per']}" * (number in best) if changed else row["per"]
        points.append((label, row[cost], abs(row[case.metric]), "standard with one change" if changed else row["numerics"]))
    drawing, ax = viz.figure(size=(7.2, 4.8))
    viz.error_against_cost(ax, points, COSTS[cost], f"{case.metric} [%]")
    return drawing


def _finished(rows, name):
    return [row for row in rows_of(rows, name) if row["status"] == FINISHED]
