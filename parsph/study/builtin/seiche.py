"""The standing wave of Szmidt (2013), section 5: kernels and their correction, resolution and support, and walls.

The rows of the paper have its numbers where it gives them: Gaussian kernel, midpoint steps, P0 = 10^5 Pa, smoothed velocities,
mirrors of equal pressure that particles behind them are exchanged at. Its amplitude is not given: 0.02 m. All others have an
amplitude of 0.005 m, small enough for linear theory, and the steps and sound speed of the scene.
"""

import math

import numpy as np

from ... import viz
from ...waves import Seiche
from ..declare import Group, Study
from ..metrics import amplitudes
from ..report import figure
from ..runner import FINISHED

METRICS = ("frequency-error", "loss-per-period", "velocity-error", "penetrations", "lowest-row", "step-cost", "work")
BASIN, PERIODS = 0.2, 5
PERIOD = 2 * math.pi / Seiche(BASIN, BASIN, 0.0, 9.81).frequency  # 0.507 s
PER_PERIOD, SOME = 20, 12  # snapshots a period, of the paper's rows and of the others
PICTURES, PAPER_PERIODS = (0.25, 0.75, 1.25, 2.25), 2.5  # periods
EARLY_PICTURES = (0.05, 0.1, 0.25, 1.25)  # corrected kernels do not get far
GAUSSIAN = {"numerics.kernel": "gaussian", "numerics.h_over_dx": 4 / 3}
KERNELS = {
    "gaussian": GAUSSIAN,
    "wendland-c2": {"numerics.kernel": "wendland-c2", "numerics.h_over_dx": 2.0},
    "wendland-c4": {"numerics.kernel": "wendland-c4", "numerics.h_over_dx": 2.4},
    "wendland-c6": {"numerics.kernel": "wendland-c6", "numerics.h_over_dx": 2.8},
    "quadratic-spline": {"numerics.kernel": "quadratic-spline", "numerics.h_over_dx": 2.0},
    "cubic-spline": {"numerics.kernel": "cubic-spline", "numerics.h_over_dx": 1.6},
    "quartic-spline": {"numerics.kernel": "quartic-spline", "numerics.h_over_dx": 1.5},
    "quintic-spline": {"numerics.kernel": "quintic-spline", "numerics.h_over_dx": 4 / 3},
}
QUICK_KERNELS = ("gaussian", "wendland-c2", "quintic-spline")
SUPPORTS = {
    "3d": {"numerics.h_over_dx": 1.0},
    "4d": {"numerics.h_over_dx": 4 / 3},
    "5d": {"numerics.h_over_dx": 5 / 3},
}
CORRECTED = {"corrected": {"numerics.kernel_correction": "linear"}}
EXCHANGE = {"walls.exchange": True}
WALLS = {
    "mirror": {"walls.treatment": "mirror"},
    "mirror-plain": {"walls.treatment": "mirror-plain", **EXCHANGE},
    "strip": {"walls.treatment": "strip"},
    "ghosts": {"walls.treatment": "ghosts"},
    "deficiency": {"walls.treatment": "deficiency"},
}
STEEPNESS = 0.02 * math.pi / BASIN  # kA of the paper's rows
DENSITIES = (0.9, 1.1)  # over rho0: the ends of the colours
BARS = {"frequency-error": 0.6, "loss-per-period": 1.5}  # [%], reached with Wendland C2 at 20 particles per depth
PAPER = {  # but not the walls; corrected kernels leave the density no bounds, so it gets wide ones
    **GAUSSIAN,
    "fluid.blocks.0.amplitude": 0.02,
    "domain.size": [0.2, 0.4],
    "numerics.c0": math.sqrt(7 * 1e5 / 1e3),
    "numerics.diffusion": "none",
    "numerics.xsph": 0.5,
    "numerics.integrator": "midpoint",
    "numerics.density_range": [0.2, 3.0],
    "time.dt": 2e-4,
}


def study(quick):
    """Return the study; quick: two resolutions, three kernels."""
    spacings = _spacings(0.02, 0.01) if quick else _spacings(0.02, 0.01, 0.005)
    shorter = {"0.005": {"time.dt": 1e-4}}  # 2e-4 s is unstable with h = 0.005 m
    paper_spacings = {dx: keys | shorter.get(dx, {}) for dx, keys in spacings.items()}
    middle = _spacings(0.01)
    kernels = {name: KERNELS[name] for name in QUICK_KERNELS} if quick else KERNELS
    plain, strip = ({"walls": {name: WALLS[name]}} for name in ("mirror-plain", "strip"))
    four = {"support": {"4d": SUPPORTS["4d"]}}
    others = {"walls": {name: keys for name, keys in WALLS.items() if name != "mirror"}}  # that is among the kernels
    some = {"walls": {name: WALLS[name] for name in ("mirror", "mirror-plain")}}
    accurate = _until(PERIODS, SOME) | GAUSSIAN
    paper = _until(PAPER_PERIODS, PER_PERIOD) | PAPER
    groups = (
        Group("paper", "seiche", paper, {**plain, "dx": paper_spacings, "support": SUPPORTS}),
        Group("paper-corrected", "seiche", paper, {**plain, "dx": middle, **four, "correction": CORRECTED}),
        Group("paper-strip", "seiche", paper, {**strip, "dx": paper_spacings, **four}),
        Group("kernels", "seiche", accurate, {"walls": {"mirror": WALLS["mirror"]}, "kernel": kernels, "dx": spacings}),
        Group("walls", "seiche", accurate, {**others, "kernel": {"gaussian": {}}, "dx": spacings}),
        Group("corrected", "seiche", accurate, {**some, "kernel": {"gaussian": {}}, "dx": spacings, "correction": CORRECTED}),
    )
    title = "A standing wave in a square basin: kernels, correction, resolution, walls (Szmidt, Figs. 3, 4, 5)"
    return Study("seiche", title, groups, METRICS, report=report)


def _spacings(*spacings):
    return {f"{dx:g}": {"numerics.dx": dx} for dx in spacings}


def _until(periods, snapshots):
    return {"time.end": periods * PERIOD, "output.snapshots.every": PERIOD / snapshots, "gauges": []}


def report(table, folder):
    """Return the report's lines, figure by figure: what the paper says and what our numbers say."""
    lines = []
    columns = ["walls", "dx", "support", "correction", "status", "reached", *METRICS[:-2], "particles", "work"]
    rows = [row for row in table.rows if row["group"].startswith("paper")]
    lines += ["", "## The paper's rows", "", *table.markdown(columns, rows), ""]
    lines += [
        f"Gaussian kernel, midpoint steps of 2e-4 s (d = 0.005 m: 1e-4 s), c0 = {PAPER['numerics.c0']:.4g} m/s of P0 = 1e5 Pa, "
        f"smoothed velocities (epsilon = 1/2), no diffusion, A = 0.02 m, {PAPER_PERIODS:g} periods of {PERIOD:.4g} s. "
        f"A wave so high is slower than linear theory by about (kA)²/8 = {STEEPNESS**2 / 8:.1%}.",
        "",
    ]
    _correction(lines, folder, table)
    _resolution(lines, folder, table)
    _strip(lines, folder, table)
    columns = ["kernel", "walls", "correction", "dx", "status", "reached", *METRICS[:-1], "particles", "work"]
    rows = [row for row in table.rows if not row["group"].startswith("paper")]
    lines += ["", "## Accuracy", "", f"A = 0.005 m, {PERIODS} periods, steps and diffusion of the scene.", ""]
    lines += [*table.markdown(columns, rows), ""]
    finished = [row for row in rows if row["status"] == FINISHED]
    if finished:
        _accuracy(lines, folder, table, finished)
    return lines


# --- the paper's figures ----------------------------------------------------------------------------------------------


def _row(table, **labels):
    """Return the first row with these labels, finished or not; None without one."""
    return next((row for row in table.rows if all(row.get(key) == value for key, value in labels.items())), None)


def _pictures(lines, folder, name, caption, table, chosen, times=PICTURES):
    """Draw particles at chosen times, a row of panels for each of the runs `chosen`, {label: row}; density as colour."""
    runs = {label: table.left(row["row"]) for label, row in chosen.items() if row is not None}
    runs = {label: run for label, run in runs.items() if run is not None and run.snapshots}
    if not runs:
        return
    drawing, panels = viz.figure(len(runs), len(times), size=(7.6, 0.5 + 1.75 * len(runs)))
    panels = np.reshape(panels, (len(runs), len(times)))
    for (label, run), line in zip(runs.items(), panels, strict=True):
        for periods, ax in zip(times, line, strict=True):
            _picture(ax, run, periods, label if ax is line[0] else "", ax is line[-1], ax in panels[-1])
    for ax, periods in zip(panels[0], times, strict=True):
        ax.set_title(f"t = {periods:g} T", fontsize=viz.SMALL + 1)
    figure(lines, folder, name, caption, drawing)


def _picture(ax, run, periods, label, with_bar, lowest):
    number = round(periods * PER_PERIOD)
    if number < len(run.snapshots):
        shot = run.snapshot(number)
        position = shot["position"][:, :2]
        density = shot["density"] / run.scene["fluid"]["rho0"]
        _, bar, _ = viz.particles(ax, position, density, "density / rho0 [-]", size=_area(run), limits=DENSITIES)
        if not with_bar:
            bar.remove()
    else:
        ax.text(0.5, 0.5, "it did not\nget so far", transform=ax.transAxes, ha="center", va="center", fontsize=viz.SMALL)
    ax.set(xlim=(-0.01, 0.21), ylim=(-0.01, 0.29), aspect="equal", ylabel=label, xlabel="x [m]" if lowest else "")
    ax.tick_params(labelsize=viz.SMALL - 1, labelbottom=lowest, labelleft=bool(label))


def _area(run):
    """Return the area of a marker [pt^2] that shows particles apart, as the paper does."""
    return (400.0 * run.scene["numerics"]["dx"]) ** 2


def _densities(table, row):
    """Return the least and the largest density over rho0 in the last snapshot of a row, as text."""
    run = None if row is None else table.left(row["row"])
    if run is None or not run.snapshots:
        return "not run"
    shot = run.snapshot()
    density = shot["density"] / run.scene["fluid"]["rho0"]
    return f"{density.min():.3f} to {density.max():.3f} at t = {shot['time']:.3f} s"


def _correction(lines, folder, table):
    plain = _row(table, group="paper", dx="0.01", support="4d")
    corrected = _row(table, group="paper-corrected")
    chosen = {"plain kernel": plain, "corrected kernel": corrected}
    _pictures(lines, folder, "fig-3", "Fig. 3: plain and corrected kernel, 400 particles", table, chosen, EARLY_PICTURES)
    lines += [
        "Paper, Fig. 3: the correction leads to unphysical changes of the density and is not recommended. "
        f"Here density over rho0 is from {_densities(table, plain)} with the plain kernel, and from "
        f"{_densities(table, corrected)} with the corrected one. Pressure vanishes at a free surface because sums lack "
        "neighbours there; corrected sums do not, and nothing holds the surface.",
        "",
    ]


def _resolution(lines, folder, table):
    rows = [row for row in table.rows if row["group"] == "paper"]
    for support in SUPPORTS:
        chosen = {f"d = {row['dx']} m": row for row in rows if row["support"] == support}
        caption = f"Fig. 4: resolutions, support {support}"
        _pictures(lines, folder, f"fig-4-{support}", caption, table, chosen)
    told = [_told(row, f"d = {row['dx']} m, {row['support']}") for row in rows]
    lines += [
        "Paper, Fig. 4: of the supports 3d, 4d and 5d, 4d gives results that are good enough. Here: " + "; ".join(told) + ".",
        "",
    ]


def _told(row, name):
    if row["status"] != FINISHED:
        return f"{name} failed at t = {row['reached']:.3f} s"
    return (
        f"{name}: velocities off by {row['velocity-error']:.1f} %, loss {row['loss-per-period']:.1f} % per period, "
        f"lowest row at {row['lowest-row']:.2f} d, {row['penetrations']:.0f} penetrations"
    )


def _strip(lines, folder, table):
    for row in [row for row in table.rows if row["group"] == "paper-strip"]:
        mirror = _row(table, group="paper", dx=row["dx"], support="4d")
        chosen = {"mirror particles": mirror, "strip, eq. (32)": row}
        _pictures(lines, folder, f"fig-5-{row['dx']}", f"Fig. 5: walls, d = {row['dx']} m", table, chosen)
        lines += [f"At d = {row['dx']} m, {_told(mirror, 'mirror particles')}; {_told(row, 'strip')}.", ""]
    lines += [
        "Paper, Fig. 5: the strip leads to satisfactory results in the fluid, except near the walls, where they deteriorate; "
        "mirror particles of equal pressure attract the fluid to the walls.",
        "",
    ]


# --- accuracy ------------------------------------------------------------------------------------------------------------


def _name(row):
    """Return what a row is called in figures: walls, kernel where walls are mirrors, and the correction."""
    kernel = [row["kernel"]] if row["walls"] == "mirror" else []
    return " ".join([*kernel, row["walls"], *[row["correction"]] * bool(row["correction"])])


def _accuracy(lines, folder, table, rows):
    for metric, unit, name in (
        ("velocity-error", "L2 error of the velocity, 5 periods [%]", "velocity-cost"),
        ("frequency-error", "frequency error [%]", "frequency-cost"),
        ("loss-per-period", "amplitude loss per period [%]", "loss-cost"),
    ):
        drawing, ax = viz.figure(size=(7.2, 4.6))
        points = [(row["dx"], row["work"], abs(row[metric]), _name(row)) for row in rows]
        viz.error_against_cost(ax, points, "work [CPU s]", unit)
        figure(
            lines,
            folder,
            name,
            f"{unit.partition(' [')[0].capitalize()} against CPU time of all steps; labels: d in m",
            drawing,
        )
    finest = min((row["dx"] for row in rows), key=float)
    drawing, ax = viz.figure(size=(7.2, 3.6))
    curves = {_name(row): _history(table, row) for row in rows if row["dx"] == finest}
    t = np.linspace(0.0, PERIODS, 400)
    labels = "t / T", "amplitude / A [-]"
    viz.against(ax, None, {}, *labels, log_y=False, theory={"theory": (t, np.cos(2 * math.pi * t))})
    viz.profile(ax, None, curves, *labels)
    figure(lines, folder, "amplitudes", f"Amplitude of the mode, d = {finest} m", drawing)
    within = [row for row in rows if all(abs(row[metric]) < bar for metric, bar in BARS.items())]
    told = ", ".join(
        f"{_name(row)} at d = {row['dx']} m ({row['frequency-error']:+.2f} %, {row['loss-per-period']:.2f} %, "
        f"{row['work']:.1f} CPU s)"
        for row in within
    )
    bars = f"{BARS['frequency-error']} % of frequency and {BARS['loss-per-period']} % of loss per period"
    lines += [f"Within {bars}: {told or 'none'}.", ""]
    lines += ["Height of the lowest row at the end, of 0.5 d at rest, at the finest resolution: "]
    lines[-1] += ", ".join(f"{_name(row)} {row['lowest-row']:.2f} d" for row in rows if row["dx"] == finest) + "."
    lines += [""]


def _history(table, row):
    t, shares = amplitudes(table.results(row["row"]))
    return t / PERIOD, shares
