"""Every wall treatment in still water, a standing wave, a dam break and an elliptical tank: errors, leaks, endurance, cost.

All with h/dx = 1.5, the largest that leaves the strip its only row; the walls are sides of the domain, which any treatment can
have, but for the ellipse. A row that fails is a result: the table has the time that it reached.
"""

import math

from ... import viz
from ...residuals import largest, residual_accelerations, root_mean_square
from ..declare import Group, Study
from ..report import figure
from ..runner import FAILED, FINISHED

TREATMENTS = {
    "mirror": {"walls.treatment": "mirror"},
    "mirror-plain": {"walls.treatment": "mirror-plain"},
    **{
        f"ghosts {name}": {"walls.treatment": "ghosts", "walls.interpolation": name}
        for name in ("hydrostatic", "shepard", "mls1")
    },
    "strip": {"walls.treatment": "strip"},
    **{f"deficiency {name}": {"walls.treatment": "deficiency", "walls.weights": name} for name in ("moments", "jones2010")},
    **{
        f"repulsion {name}": {"walls.treatment": "repulsion", "walls.repulsion": name}
        for name in ("monaghan-kajtar", "lennard-jones")
    },
}
WIDE = {"numerics.h_over_dx": 1.5}
TANK = {"left": {}, "right": {}, "bottom": {}}
ENERGY = {"kind": "energy", "every": 0.02}
PROBES = [{"kind": "pressure", "name": f"P{n}", "point": [0.0, z], "every": 0.02} for n, z in enumerate((0.0, 0.1, 0.2, 0.25))]
TRANSDUCER = {"kind": "pressure", "name": "P1", "point": [3.22, 0.16], "extent": [0.0, 0.09], "every": 0.002}
PERIOD = 0.507  # of the seiche [s]
COMMON = ("leaks", "step-cost", "wall-cost", "work")
CASES = {  # scene, title, metrics, the one that is drawn against the cost
    "still": ("still", "Still water", ("probe-error", "rest-energy", "lowest-row"), "probe-error"),
    "seiche": ("seiche", "Standing wave", ("frequency-error", "loss-per-period", "velocity-error"), "velocity-error"),
    "dam": ("dam-break-small", "Dam break", ("plateau", "energy-growth"), "plateau-error"),
    "ellipse": ("tank-ellipse", "Elliptical tank at constant pressure", ("rest-speed",), "rest-speed"),
}
METRICS = (*dict.fromkeys(metric for _, _, metrics, _ in CASES.values() for metric in metrics), "plateau-error", *COMMON)


def study(quick):
    """Return the study; quick: one resolution of each case, and shorter runs."""
    spacings = {
        "still": (0.02,) if quick else (0.02, 0.01),
        "seiche": (0.02,) if quick else (0.02, 0.01, 0.005),
        "dam": (0.03,) if quick else (0.02, 0.01),
        "ellipse": (0.1,) if quick else (0.05, 0.025),
    }
    still, dam = (3.0, 1.2) if quick else (10.0, 1.5)
    periods = 3 if quick else 5
    settings = {
        "still": {**_until(still), "gauges": [*PROBES, ENERGY], "numerics.c0_factor": 10.0},
        "seiche": {**_until(periods * PERIOD, 12 * periods), "gauges": [ENERGY]},
        "dam": {**_until(dam), "gauges": [TRANSDUCER, ENERGY], "walls": TANK},
        "ellipse": {**_until(20.0), "gauges": [{**ENERGY, "every": 0.2}]},
    }
    groups = []
    for case, (scene, _, metrics, _) in CASES.items():
        kept = {name: keys for name, keys in TREATMENTS.items() if case != "ellipse" or not name.startswith("mirror")}
        dx = {f"{spacing:g}": {"numerics.dx": spacing} for spacing in spacings[case]}
        more = ("plateau-error",) if case == "dam" else ()
        groups.append(Group(case, scene, settings[case] | WIDE, {"walls": kept, "dx": dx}, metrics=(*metrics, *more, *COMMON)))
    title = "Every wall treatment in still water, a standing wave, a dam break and an elliptical tank"
    return Study("wall-treatments", title, tuple(groups), METRICS, report=report)


def _until(end, snapshots=5):
    return {"time.end": end, "output.snapshots.every": end / snapshots}


def report(table, folder):
    """Return the report's lines: case by case the table, the error against the cost, and what stands out."""
    lines = []
    for case, (_, title, metrics, drawn) in CASES.items():
        rows = [row for row in table.rows if row["group"] == case]
        columns = ["walls", "dx", "status", "reached", *dict.fromkeys((*metrics, drawn)), *COMMON, "particles", "steps"]
        lines += ["", f"## {title}", "", *table.markdown(columns, rows), ""]
        finished = [row for row in rows if row["status"] == FINISHED]
        _endurance(lines, rows)
        if case in ("still", "ellipse"):
            _residuals(lines, table, rows)
        if finished:
            _cost(lines, folder, table, case, finished, drawn)
            _leaking(lines, finished)
    return lines


def _endurance(lines, rows):
    """Say which rows failed and when."""
    failed = [f"{row['walls']} at dx = {row['dx']} m: {row['reached']:.3g} s" for row in rows if row["status"] == FAILED]
    lines += [f"Failed, and the time reached: {'; '.join(failed)}." if failed else "All rows ran to their end.", ""]


def _leaking(lines, rows):
    leaky = [f"{row['walls']} at dx = {row['dx']} m: {row['leaks']:.0f}" for row in rows if row["leaks"] > 0]
    lines += [f"Particles behind walls at the end: {'; '.join(leaky) or 'none'}.", ""]


def _residuals(lines, table, rows):
    """Tabulate what walls leave of the accelerations at rest, at the coarsest resolution."""
    coarsest, told = max((row["dx"] for row in rows), key=float), []
    for row in rows:
        run = table.left(row["row"]) if row["dx"] == coarsest else None
        if run is None:
            continue
        found = residual_accelerations(run.scene)
        entry = {"walls": row["walls"]}
        for place, mask in found.places.items():
            for when, field in (("before", found.before[mask]), ("after", found.after[mask])):
                entry[f"{place}, {when}"] = f"{root_mean_square(field):.3g}, {largest(field):.3g}" if mask.any() else ""
        told.append(entry)
    if told:
        lines += [
            f"Accelerations at the beginning, dx = {coarsest} m, RMS and largest [m/s²] within the support radius of walls, "
            "without walls (before) and with them (after):",
            "",
            *table.markdown(list(told[0]), told),
            "",
        ]


def _cost(lines, folder, table, case, rows, drawn):
    drawing, ax = viz.figure(size=(7.2, 4.6))
    points = [(row["dx"], row["work"], abs(row[drawn]), row["walls"]) for row in rows]
    viz.error_against_cost(ax, points, "work [CPU s]", f"{drawn} [{table.columns[drawn]}]")
    figure(lines, folder, f"{case}-cost", f"{CASES[case][1]}: {drawn} against CPU time of all steps; labels: dx in m", drawing)
    best = sorted((abs(row[drawn]), row["walls"], row["dx"]) for row in rows if math.isfinite(row[drawn]))[:5]
    lines += [
        f"Smallest {drawn}: " + ", ".join(f"{name} at dx = {dx} m {error:.3g}" for error, name, dx in best) + ".",
        "",
    ]
