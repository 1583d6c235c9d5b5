"""Walls compared: the interpolators of polygon walls, and mirror walls, in still water and in a dam break.

Cases and figures are those of Huang et al., Water 11(5), 1110 (2019), sections 4.1 and 4.2, Figs. 3, 4, 7 and 9.
"""

import math

import numpy as np

from ... import viz
from ...walls import INTERPOLATORS
from ..declare import Group, Study
from ..metrics import EARLY, arrival, buchner, impact, largest, plateau_of, probe_errors, probes, rms
from ..report import figure
from ..runner import FINISHED

REFERENCE = "mls2"
STILL = ("probe-error", "probe-error-early", "probe-error-largest", "rest-energy")
DAM = ("plateau",)
SHARED = ("energy-growth", "wall-cost", "step-cost", "stopped", "fallbacks")
GOAL, AT_REST = 0.5, 1e-6  # probe error [%], kinetic over potential energy
MEASURED, IMPACT = "measured (Buchner)", "P1: p / (rho0 g H) [-]"
STEP, WALLS = "CPU per step [ms]", "of it at walls [ms]"
FASTER, WALLS_FASTER = f"speed-up over {REFERENCE} [-]", "of the work at walls [-]"


def study(quick):
    """Return the study; quick: still water at two spacings for 4 s, a dam break of 1,800 particles for 1.5 s."""
    still = _spacings(0.02, 0.01) if quick else _spacings(0.02, 0.01, 0.005)
    dam = _spacings(0.02) if quick else _spacings(0.0156, 0.0078)
    groups = (
        Group("still", "still-tank", _until(4.0 if quick else 35.0), {"walls": _walls(force_gauge=5), "dx": still}),
        Group("dam", "dam-break-small", _until(1.5 if quick else 2.5), {"walls": _walls(force_gauge=1), "dx": dam}),
    )
    title = "Interpolators of polygon walls, and mirror walls (Huang et al., Figs. 3, 4, 7, 9)"
    return Study("walls", title, groups, (*STILL, *DAM, *SHARED), report=report)


def _until(end):
    return {"time.end": end, "output.snapshots.every": end}


def _spacings(*spacings):
    return {f"{dx:g}": {"numerics.dx": dx} for dx in spacings}


def _walls(force_gauge):
    """Return the overrides of each kind of wall; a gauge of force names its wall."""
    mirror = {"walls": {"left": {}, "right": {}, "bottom": {}}, f"gauges.{force_gauge}.wall": "right"}
    return {**{name: {"walls.interpolation": name} for name in INTERPOLATORS}, "mirror": mirror}


def report(table, folder):
    """Return the report's lines: what the paper says and what our numbers say."""
    lines = []
    for group, title, metrics, tell in (("still", "Still water", STILL, _still), ("dam", "Dam break", DAM, _dam)):
        rows = [row for row in table.rows if row["group"] == group]
        columns = ["walls", "dx", "status", *metrics, *SHARED, "particles", "steps", "cpu"]
        lines += ["", f"## {title}", "", *table.markdown(columns, rows), ""]
        missing = [f"{row['walls']} at dx = {row['dx']} m" for row in rows if row["status"] != FINISHED]
        if missing:
            lines += [f"Not finished: {', '.join(missing)}. Why rows failed is said at the end.", ""]
        finished = table.select(group=group)
        if finished:
            tell(lines, folder, table, finished)
            _costs(lines, folder, table, finished)
    return lines


def _spacings_of(rows):
    """Return the labels of the spacings, the coarsest first."""
    return sorted({row["dx"] for row in rows}, key=float, reverse=True)


def _middle(rows):
    """Return the middle spacing, of two the finer, and its rows by wall."""
    spacings = _spacings_of(rows)
    dx = spacings[len(spacings) // 2]
    return dx, _at(rows, dx)


def _at(rows, dx):
    return {row["walls"]: row for row in rows if row["dx"] == dx}


def _ranked(values, form, reverse=False):
    """Return "name value, ..." of a dict, the smallest (the largest) first, without those that are not finite."""
    known = [(value, name) for name, value in values.items() if math.isfinite(value)]
    return ", ".join(f"{name} {form.format(value)}" for value, name in sorted(known, reverse=reverse)) or "none"


def _column(rows, metric):
    return {wall: row[metric] for wall, row in rows.items()}


# --- still water --------------------------------------------------------------------------------------------------------


def _still(lines, folder, table, rows):
    _histories(lines, folder, table, rows)
    _errors(lines, folder, rows)
    lines += [
        "Paper, section 4.1: the normalised interpolation oscillates at the beginning and fluctuates on, SFDI oscillates at "
        "the beginning; MLS and the improved Shepard interpolation are steady, and nearly agree. Here, RMS error of all probes "
        "over rho0 g H, the smallest first:",
        "",
    ]
    for dx in _spacings_of(rows):
        own = _at(rows, dx)
        errors, energies = _column(own, "probe-error"), _column(own, "rest-energy")
        within = [wall for wall, error in errors.items() if error <= GOAL]
        calm = [wall for wall, energy in energies.items() if energy <= AT_REST]
        lines += [
            f"- dx = {dx} m: {_ranked(errors, '{:.3g} %')}; within {GOAL:g} %: {', '.join(within) or 'none'}. "
            f"In the first second: {_ranked(_column(own, 'probe-error-early'), '{:.3g} %')}. "
            f"Kinetic over potential energy at the end: {_ranked(energies, '{:.1e}')}; "
            f"within {AT_REST:g}: {', '.join(calm) or 'none'}."
        ]
        if REFERENCE in errors:
            ratios = {wall: error / errors[REFERENCE] for wall, error in errors.items()}
            lines[-1] += f" Errors over that of {REFERENCE}: {_ranked(ratios, '{:.2f}')}."
    lines += [""]


def _histories(lines, folder, table, rows):
    """Draw pressures against time at the middle resolution, and tabulate their errors probe by probe."""
    dx, own = _middle(rows)
    runs = {wall: table.results(row["row"]) for wall, row in own.items()}
    records = {wall: probes(run) for wall, run in runs.items()}
    names = list(next(iter(records.values())))
    drawing, panels = viz.figure(len(names), 2, size=(7.2, 0.9 + 1.9 * len(names)), share_x=True)
    for name, pair in zip(names, panels, strict=True):
        for ax, begin, end in ((pair[0], 0.0, EARLY), (pair[1], EARLY, math.inf)):
            curves = {}
            for wall, record in records.items():
                t, pressure, exact = record[name]
                shown = (t >= begin) & (t <= end)
                curves[wall] = t[shown], pressure[shown]
            still = {"exact": (t[shown], np.full(shown.sum(), exact))}
            viz.against(ax, None, {}, "t [s]", f"{name}: p / (rho0 g H)", log_y=False, theory=still)
            viz.profile(ax, None, curves, "t [s]", f"{name}: p / (rho0 g H)")
            if ax is not panels[0][0]:
                ax.get_legend().remove()
    caption = f"Fig. 3: pressure on the left wall, dx = {dx} m; left: the first second, right: the rest"
    figure(lines, folder, "fig-3", caption, drawing)
    for when, early in (("in the first second", True), ("at the times of probe-error", False)):
        told = []
        for wall, run in runs.items():
            errors = probe_errors(run, early)
            told.append({"walls": wall, **{name: f"{rms(error):.3f}, {largest(error):.3f}" for name, error in errors.items()}})
        lines += [f"Errors at dx = {dx} m {when}, RMS and largest [% of rho0 g H]:", ""]
        lines += [*table.markdown(["walls", *names], told), ""]


def _errors(lines, folder, rows):
    curves = {}
    for row in rows:
        curves.setdefault(row["walls"], []).append((float(row["dx"]), row["probe-error"]))
    label = "probe error, RMS [% of rho0 g H]"
    drawing, ax = viz.figure()
    along = {wall: tuple(np.array(sorted(points)).T) for wall, points in curves.items()}
    viz.against(ax, None, along, "dx [m]", label, bars={f"{GOAL:g} %": GOAL})
    figure(lines, folder, "error-dx", "Error against spacing", drawing)
    drawing, ax = viz.figure(size=(7.2, 4.4))
    viz.error_against_cost(ax, [(row["dx"], row["cpu"], row["probe-error"], row["walls"]) for row in rows], ylabel=label)
    figure(lines, folder, "error-cost", "Error against CPU time of the whole run; labels: dx in m", drawing)


# --- dam break ------------------------------------------------------------------------------------------------------------


def _dam(lines, folder, table, rows):
    dx, own = _middle(rows)
    records = {wall: impact(table.results(row["row"])) for wall, row in own.items()}
    experiment = buchner(table.results(rows[0]["row"]))
    there = arrival(*experiment)
    mean = plateau_of(*experiment, there)
    arrivals = {wall: arrival(*record) for wall, record in records.items()}
    _impacts(lines, folder, dx, records | {MEASURED: experiment}, arrivals | {MEASURED: there})
    late = {wall: time - there for wall, time in arrivals.items()}
    plateaus = _column(own, "plateau")
    apart = {wall: abs(value - mean) / mean for wall, value in plateaus.items()}
    lines += [
        "Paper, section 4.2: MLS, SFDI and the improved Shepard interpolation agree, and the normalised one reads "
        "significantly more; all arrive later than the measured front. "
        f"Here, at dx = {dx} m, it arrives so long after the measured front, which is there at {there:.3f} s (less than 0: "
        f"before it): {_ranked(late, '{:+.3f} s')}. "
        f"Plateau of P1 over rho0 g H (measured: {mean:.3f}): {_ranked(plateaus, '{:.3f}')}; "
        f"difference from the measured one, the smallest first: {_ranked(apart, '{:.1%}')}.",
        "",
        f"Largest rise of the energy, over the potential one at first: {_ranked(_column(own, 'energy-growth'), '{:.1e}')}. "
        f"How often a particle was stopped at the line of a wall: {_ranked(_column(own, 'stopped'), '{:.0f}')}.",
        "",
    ]


def _impacts(lines, folder, dx, records, arrivals):
    """Draw the pressures at the right wall, as they are and from their arrivals on."""
    drawing, panels = viz.figure(2, 1, size=(7.2, 6.4))
    for ax, zeros, label in (
        (panels[0], dict.fromkeys(arrivals, 0.0), "t [s]"),
        (panels[1], arrivals, "t since arrival [s]"),
    ):
        curves = {name: (t - zeros[name], pressure) for name, (t, pressure) in records.items() if math.isfinite(zeros[name])}
        points = {MEASURED: curves.pop(MEASURED)}
        viz.against(ax, None, points, label, IMPACT, log_y=False)[MEASURED].set(color="black", linestyle="none")
        viz.profile(ax, None, curves, label, IMPACT)
    panels[1].set_xlim(left=-0.2)
    panels[1].get_legend().remove()
    caption = f"Fig. 7: pressure at the gauge P1 on the right wall, dx = {dx} m; below, from the arrival of each on"
    figure(lines, folder, "fig-7", caption, drawing)


# --- cost -----------------------------------------------------------------------------------------------------------------


def _costs(lines, folder, table, rows):
    """Draw and tabulate what a step costs, and how many times as fast it is as with quadratic moving least squares."""
    number = {"still": "4", "dam": "9"}[rows[0]["group"]]
    costs = [_cost(row, _at(rows, row["dx"]).get(REFERENCE)) for row in rows]
    drawing, panels = viz.figure(1, 2, size=(7.2, 3.6))
    for ax, key, log_y in ((panels[0], STEP, True), (panels[1], FASTER, False)):
        curves = {}
        for cost in costs:
            curves.setdefault(cost["walls"], []).append((cost["particles"], cost[key]))
        along = {wall: tuple(np.array(sorted(points)).T) for wall, points in curves.items()}
        viz.against(ax, None, along, "particles", key, log_y=log_y)
    figure(lines, folder, f"fig-{number}", f"Fig. {number}: CPU time of a step, and speed-up over {REFERENCE}", drawing)
    lines += [*table.markdown([name for name in costs[0] if name != "particles"], costs), ""]
    dx, _ = _middle(rows)
    chosen = {cost["walls"]: cost for cost in costs if cost["dx"] == dx}
    steps, walls = (_ranked(_column(chosen, key), "{:.2f}", reverse=True) for key in (FASTER, WALLS_FASTER))
    lines += [
        f"Speed-up over {REFERENCE} at dx = {dx} m, the fastest first: {steps}; of the work at walls alone: {walls}. "
        "Mirror walls have no such work of their own: their images are made where particles are sorted."
    ]


def _cost(row, reference):
    """Return what a step of a row costs, and how it compares with the reference row (None where there is none)."""
    (step, walls), (step_there, walls_there) = _times(row), _times(reference)
    return {
        "walls": row["walls"],
        "dx": row["dx"],
        "particles": row["particles"],
        STEP: step,
        WALLS: walls,
        FASTER: step_there / step,
        WALLS_FASTER: walls_there / walls if walls else math.nan,
    }


def _times(row):
    """Return the CPU time of a step, and of what it does at walls [ms]; NaN without a row."""
    if row is None:
        return math.nan, math.nan
    step = 1e-3 * row["step-cost"] * row["particles"]
    return step, step * row["wall-cost"]
