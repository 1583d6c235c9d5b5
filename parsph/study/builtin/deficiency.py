"""The boundary deficiency and its correction, Jones et al. (2010), Figs. 3 to 8, beside other walls.

Accelerations are those of a fluid in equilibrium at its beginning, where all of them are errors; runs of the same scenes tell
what a step costs. Still water and the bed that bulges run in time.
"""

import numpy as np

from ... import viz
from ...parallel import Communicator
from ...residuals import largest, residual_accelerations, residuals_of, root_mean_square
from ...scene.build import build
from ...scene.load import load_scene
from ...walls.deficiency import jones_weight
from ..declare import Group, Study
from ..report import figure
from ..table import markdown

COSTS = ("step-cost", "wall-cost", "leaks")
METRICS = ("rest-energy", "energy-growth", "lowest-row", *COSTS)
CORRECTIONS = {
    "moments": {"walls.treatment": "deficiency", "walls.weights": "moments"},
    "jones2010": {"walls.treatment": "deficiency", "walls.weights": "jones2010"},
}
WALLS = {
    **CORRECTIONS,
    "repulsion": {"walls.treatment": "repulsion"},
    "mirror": {"walls.treatment": "mirror"},
    "ghosts": {"walls.treatment": "ghosts"},
    "strip": {"walls.treatment": "strip", "numerics.h_over_dx": 1.5},
}
SHAPES = {  # walls that are possible there, and an end after some tens of steps [s]
    "column-1d": (("moments", "jones2010", "repulsion", "mirror"), 0.25),
    "column": (tuple(WALLS), 0.15),
    "tank-rectangle": (tuple(WALLS), 4.0),
    "tank-ellipse": (tuple(name for name in WALLS if name != "mirror"), 4.0),
}
STILL, BULGING = ("moments", "jones2010", "repulsion", "mirror"), ("moments", "jones2010", "repulsion", "ghosts")
GAUGES = [{"kind": "energy", "every": 0.02}]
BED, AMPLITUDE, LEVEL = 0.1, 0.06, 0.4  # of the scene bulging-wall [m]
BULGE = 0.3, 0.7  # from where to where the bed of Fig. 4 bulges [m]
MIDDLE = 0.08  # of its middle, where it bends to one side alone: half a width [m]
FULL = {"into the fluid": 1.875, "out of the fluid": 2.625}  # when it stands out furthest [s]
PRESSURE = 1500.0  # of the fluid over the bulge [Pa], that of water half as deep
DIP = 0.9  # of the largest strength
ARC, SPACING, REACH = 1.0, 0.25, 0.775  # of Fig. 6 [m]


def study(quick):
    """Return the study; quick: still water without mirrors and the bulging bed at 0.02 m, for 3 s and 1.2 s."""
    dx = {"numerics.dx": 0.02 if quick else 0.01}
    still, bulge = ({**dx, **_until(end), "gauges": GAUGES} for end in ((3.0, 1.2) if quick else (10.0, 3.0)))
    groups = [
        Group(shape, shape, {**_until(end), "gauges": []}, {"walls": _walls(names)}, metrics=COSTS)
        for shape, (names, end) in SHAPES.items()
    ]
    groups += [
        Group("still", "still", still, {"walls": _walls(STILL[:3] if quick else STILL)}),
        Group("bulging-wall", "bulging-wall", bulge, {"walls": _walls(BULGING)}),
    ]
    title = "Correction of the boundary deficiency (Jones et al., Figs. 3 to 8) beside other walls"
    return Study("deficiency", title, tuple(groups), METRICS, report=report)


def _until(end):
    return {"time.end": end, "output.snapshots.every": end}


def _walls(names):
    return {name: WALLS[name] for name in names}


def report(table, folder):
    """Return the report's lines, figure by figure: what the paper says and what our numbers say."""
    lines = ["", "## Residual accelerations", ""]
    residuals = {shape: {name: _residuals(shape, name) for name in names} for shape, (names, _) in SHAPES.items()}
    _table(lines, table, residuals)
    _line(lines, folder, residuals["column-1d"])
    _bulges(lines, folder)
    _column(lines, folder, residuals["column"])
    _weights(lines, folder)
    _tank(lines, folder, residuals["tank-rectangle"], "tank-rectangle", 7)
    _tank(lines, folder, residuals["tank-ellipse"], "tank-ellipse", 8)
    _verdict(lines, residuals)
    lines += ["## In time", ""]
    _still(lines, folder, table)
    _bulging(lines, folder, table)
    return lines


def _residuals(shape, name):
    return residual_accelerations(shape, WALLS[name])


# --- what is left -----------------------------------------------------------------------------------------------------


def _table(lines, table, residuals):
    told = []
    for shape, by_walls in residuals.items():
        costs = {row["walls"]: row["step-cost"] for row in table.select(group=shape)}
        for name, found in by_walls.items():
            row = {"scene": shape, "walls": name}
            for place, mask in found.places.items():
                for when, acceleration in (("before", found.before[mask]), ("after", found.after[mask])):
                    row[f"{place}, {when}"] = _pair(acceleration)
            told.append({**row, "step [µs per particle]": costs.get(name, np.nan)})
    lines += [
        "RMS and largest acceleration [m/s²] of the particles within the support radius of a wall, without walls (before) and "
        "with them (after): away from corners and sharp ends, and in them, where walls in reach turn by more than 45 degrees. "
        "Particles near a free surface do not count. The strip is for h/dx = 1.5, the others for h/dx = 5.",
        "",
        *table.markdown(list(told[0]), told),
        "",
    ]


def _pair(acceleration):
    if not len(acceleration):
        return ""
    return f"{root_mean_square(acceleration):.3g}, {largest(acceleration):.3g}"


def _left(found, place):
    """Return the RMS that is left of the accelerations at a place, over what was there [-]."""
    mask = found.places[place]
    return root_mean_square(found.after[mask]) / root_mean_square(found.before[mask])


def _verdict(lines, residuals):
    lines += ["", "What is left of the RMS of the deficiency:", ""]
    for shape in ("tank-rectangle", "tank-ellipse"):
        ours, theirs = (residuals[shape][name] for name in ("moments", "jones2010"))
        lines += [
            f"- {shape}: along walls {_left(ours, 'walls'):.2%} with moments, {_left(theirs, 'walls'):.2%} with jones2010; in "
            f"corners and ends {_left(ours, 'corners'):.2%} and {_left(theirs, 'corners'):.2%}."
        ]
    lines += [""]


# --- the paper's figures --------------------------------------------------------------------------------------------------


def _line(lines, folder, residuals):
    """Fig. 3: acceleration along a line of constant pressure."""
    scene = load_scene("column-1d")
    block = scene.fluid.blocks[0]
    first = next(iter(residuals.values()))
    x = first.position[:, 0]
    ends = block.low[0], block.high[0]
    W = [scene.kernel.value(np.abs(x - end), scene.h, 1) for end in ends]
    theory = 2.0 * block.pressure / scene.fluid.rho0 * (W[1] - W[0])
    curves = {"before correction": (x, first.before[:, 0])}
    curves |= {f"after, {name}": (x, residuals[name].after[:, 0]) for name in CORRECTIONS}
    drawing, ax = viz.figure()
    viz.against(ax, None, curves, "x [m]", "acceleration [m/s²]", log_y=False, theory={"2 p/rho W": (x, theory)})
    figure(lines, folder, "fig-3", "Fig. 3: acceleration in 1D without any gradient of pressure", drawing)
    off = np.abs(first.before[:, 0] - theory).max() / np.abs(theory).max()
    lines += [
        "Paper, Fig. 3: the deficiency is similar in shape to the kernel. Here it differs from 2 p/rho W by at most "
        f"{off:.1%} of its largest; what the corrections leave: {_ranked(residuals)}.",
        "",
    ]


def _ranked(residuals):
    return ", ".join(f"{name} {_left(residuals[name], 'walls'):.2%}" for name in CORRECTIONS)


def _column(lines, folder, residuals):
    """Fig. 5: vertical acceleration in the middle of a column."""
    scene = load_scene("column")
    middle = 0.5 * scene.domain.size[0]
    first = next(iter(residuals.values()))
    inside = np.abs(first.position[:, 0] - middle) < scene.numerics.dx
    order = np.argsort(first.position[inside, 1], kind="stable")[::2]
    z = first.position[inside, 1][order]
    curves = {"before correction": (z, first.before[inside, 1][order])}
    curves |= {f"after, {name}": (z, residuals[name].after[inside, 1][order]) for name in CORRECTIONS}
    drawing, ax = viz.figure()
    viz.against(ax, None, curves, "height [m]", "vertical acceleration [m/s²]", log_y=False)
    figure(lines, folder, "fig-5", "Fig. 5: vertical acceleration in the middle of the column", drawing)
    lines += [
        "Paper, Fig. 5: the deficiency at the bottom goes with the kernel although there is a gradient of pressure; there is a "
        f"small one at the free surface too. Here {first.before[inside, 1].min():.3g} m/s² at the bottom before correction; "
        f"at the highest particles {curves['before correction'][1][-1]:+.2f} m/s²; left along walls: {_ranked(residuals)}.",
        "",
    ]


def _weights(lines, folder):
    """Fig. 6: weights of three markers of a concave and of a convex wall, as red, green and blue."""
    angles = np.pi / 2 + SPACING / ARC * np.array([-1.0, 0.0, 1.0])
    markers = ARC * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    drawing, panels = viz.figure(1, 2, size=(7.2, 3.4))
    for ax, name, into in ((panels[0], "concave", -1.0), (panels[1], "convex", 1.0)):
        edges = np.linspace(-1.1, 1.1, 221), np.linspace(ARC - 0.8, ARC + 0.8, 161)
        points = np.stack(np.meshgrid(*edges), axis=-1).reshape(-1, 2)
        shares = _shares(points, markers, into * markers / ARC)
        shares[into * (np.linalg.norm(points, axis=1) - ARC) < 0] = 0.0
        reached = shares.any(axis=1)
        colours = np.where(reached[:, None], np.clip(shares, 0.0, 1.0), 1.0).reshape(161, 221, 3)
        ax.imshow(colours, origin="lower", extent=(-1.1, 1.1, ARC - 0.8, ARC + 0.8), interpolation="nearest")
        turn = np.linspace(np.pi / 2 - 1.0, np.pi / 2 + 1.0, 100)
        viz.walls(ax, [ARC * np.stack([np.cos(turn), np.sin(turn)], axis=1)])
        ax.plot(*markers.T, "o", color="white", markeredgecolor="black", markersize=viz.POINT, zorder=4)
        ax.set(xlim=(-1.05, 1.05), ylim=(0.22, 1.78), xlabel="x [m]", title=f"{name} wall")
        ax.title.set_fontsize(viz.SMALL + 1)
        ax.tick_params(labelsize=viz.SMALL)
    caption = "Fig. 6: weights of three markers as red, green and blue, influence radius 0.775 m, spacing 0.25 m, radius 1 m"
    figure(lines, folder, "fig-6", caption, drawing)


def _shares(points, markers, normals):
    """Return the weights of eq. (8), normalised, of `markers` at `points`, shape (n, markers); 0 beyond their reach."""
    away = points[:, None] - markers
    r = np.linalg.norm(away, axis=2).clip(1e-9)
    cosine = (away * normals).sum(axis=2) / r
    weight = np.where(r < REACH, jones_weight.py_func(r, cosine, SPACING, REACH), 0.0)
    alike = normals @ normals.T
    whole = (weight * alike[r.argmin(axis=1)]).sum(axis=1)
    return np.divide(weight, whole[:, None], out=np.zeros_like(weight), where=whole[:, None] > 0)


def _tank(lines, folder, residuals, shape, number):
    """Figs. 7, 8: accelerations before and after in a closed tank, and the strengths of the markers round it."""
    first = next(iter(residuals.values()))
    fields = {"before": first.before} | {f"after, {name}": residuals[name].after for name in reversed(CORRECTIONS)}
    drawing, panels = viz.figure(1, 3, size=(9.6, 2.9))
    limits = 0.0, largest(first.before)
    for ax, (name, field) in zip(panels, fields.items(), strict=True):
        size = np.linalg.norm(field, axis=1)
        _, bar, _ = viz.particles(ax, first.position, size, "|a| [m/s²]", limits=limits, vectors=field, unit="m/s²")
        if ax is not panels[-1]:
            bar.remove()
            ax.set_ylabel("z [m]" if ax is panels[0] else "")
        ax.set_title(name, fontsize=viz.SMALL + 1)
    figure(
        lines, folder, f"fig-{number}", f"Fig. {number}: accelerations in {shape}; each panel scales its own arrows", drawing
    )
    strengths = {name: _strengths(shape, name) for name in CORRECTIONS}
    drawing, ax = viz.figure()
    viz.profile(ax, None, strengths, "marker, counter-clockwise from the lower left", "C / largest C [-]")
    figure(lines, folder, f"fig-{number}-strengths", f"Fig. {number}: strengths of the markers of {shape}", drawing)
    if number == 7:
        lines += [
            "Paper, Fig. 7: the strengths have four dips, at the corners, and the correction is slightly too strong there. "
            f"Here the strengths of jones2010 have {_dips(strengths['jones2010'][1])} dips, those of moments "
            f"{_dips(strengths['moments'][1])}. {_over(residuals)}",
            "",
        ]
    else:
        lines += [
            f"Paper, Fig. 8: the correction is too weak at the sharp ends of the ellipse, and good where walls bend "
            f"little. {_over(residuals)} Along the rest of the wall the corrections leave: {_ranked(residuals)}.",
            "",
        ]


def _strengths(shape, name):
    """Return numbers of the markers, counter-clockwise from the lower left, and their strengths over the largest."""
    scene = load_scene(shape, WALLS[name])
    simulation = build(scene, Communicator())
    simulation.evaluate(0.0)
    markers, block = simulation.domain.markers, scene.fluid.blocks[0]
    low, high = np.array(block.low), np.array(block.high)
    start = low - 0.5 * (low + high)
    apart = markers.position - 0.5 * (low + high)
    angle = np.arctan2(apart[:, 1], apart[:, 0]) - np.arctan2(start[1], start[0])
    size = np.abs(markers.strength[np.argsort(angle % (2 * np.pi)), 0])
    return np.arange(len(size)), size / size.max()


def _dips(strength):
    """Return how often, on the way round, strengths fall below a share of the largest."""
    low = strength < DIP * strength.max()
    return int((low & ~np.roll(low, 1)).sum())


def _over(residuals):
    """Return a sentence on the sign of what is left in corners and at ends: along or against the deficiency."""
    told = []
    for name in CORRECTIONS:
        found = residuals[name]
        mask = found.places["corners"]
        along = (found.after[mask] * found.before[mask]).sum() / (found.before[mask] ** 2).sum()
        told.append(f"{name} {'too strong' if along < 0 else 'too weak'} by {abs(along):.1%}")
    return f"In corners and at sharp ends: {', '.join(told)} of the deficiency."


# --- the bulging bed at rest ------------------------------------------------------------------------------------------------


def _bulges(lines, folder):
    """Fig. 4: what is left over a bed that has bulged, with ghosts laid anew, ghosts carried along, and markers."""
    told, drawing, panels = [], *viz.figure(2, 2, size=(7.6, 4.4))
    for line, (way, time) in zip(panels, FULL.items(), strict=True):
        row = {"bed": way}
        for name in ("ghosts", *CORRECTIONS):
            anew, carried = _over_bulge(name, way, time)
            x, z = carried.position.T
            over = carried.near & (np.abs(x - 0.5) < MIDDLE) & (z < 0.5 * (BED + LEVEL))
            normal = _bed_normals(x[over], way)
            row["before"] = _along_normal(carried.before[over], normal)
            if name == "ghosts":
                row["ghosts, anew"] = _along_normal(anew.after[over], normal)
            row[f"{name}, carried along"] = _along_normal(carried.after[over], normal)
            if name in ("ghosts", "moments"):
                ax = line[("ghosts", "moments").index(name)]
                shown = (z < BED + 0.1) & (np.abs(x - 0.5) < 0.28)
                size = np.linalg.norm(carried.after[shown], axis=1)
                viz.particles(ax, carried.position[shown], size, "|a| [m/s²]", limits=(0.0, 20.0))
                ax.set_title(f"{name}, {way}", loc="left", fontsize=viz.SMALL + 1)
        told.append(row)
    caption = "Fig. 4: accelerations over a bed that has bulged, which carried ghosts or markers along, at constant pressure"
    figure(lines, folder, "fig-4", caption, drawing)
    lines += [
        "Paper, Fig. 4: virtual particles that move with a wall that deforms clump, which gives too much pressure where it "
        f"bulges into the fluid and too little where it bulges out. Over the middle of a bed bulged by {AMPLITUDE:g} m over a "
        f"length of {BULGE[1] - BULGE[0]:g} m, at a constant pressure of {PRESSURE:g} Pa, RMS acceleration and mean "
        "along the normal (positive: too much pressure) [m/s²]:",
        "",
        *markdown(list(told[0]), told),
        "",
    ]


def _bed_heights(x, way):
    """Return the bed's height [m] where it stands out furthest, and its slope, at `x` [m]."""
    height = AMPLITUDE if way == "into the fluid" else -AMPLITUDE
    length = BULGE[1] - BULGE[0]
    place = np.pi * np.clip((x - BULGE[0]) / length, 0.0, 1.0)
    return BED + height * np.sin(place) ** 2, height * np.pi / length * np.sin(2 * place)


def _bed_normals(x, way):
    """Return the normals of the bulged bed into the fluid at `x` [m], shape (n, 2)."""
    _, slope = _bed_heights(x, way)
    return np.stack([-slope, np.ones(len(x))], axis=1) / np.sqrt(1.0 + slope**2)[:, None]


def _along_normal(acceleration, normal):
    return f"{root_mean_square(acceleration):.3g}, {(acceleration * normal).sum(axis=1).mean():+.3g}"


def _over_bulge(name, way, time):
    """Return the `Residuals` over a bed made as bulged, and those with the walls of a flat bed moved there at `time` [s]."""
    calm = {**WALLS[name], "domain.gravity": 0.0, "numerics.c0": 34.0, "gauges": [], "numerics.diffusion": "none"}
    x = np.linspace(*BULGE, 81)
    bed = np.stack([x, _bed_heights(x, way)[0]], axis=1).tolist()
    sides = [0.0, 0.7], [0.0, BED], [1.0, BED], [1.0, 0.7]
    outline = {"name": "tank", "points": [*sides[:2], *bed, *sides[2:]], "fluid": "left"}
    block = {"points": [sides[1], *bed, sides[2], [1.0, LEVEL], [0.0, LEVEL]], "pressure": PRESSURE}
    level = {**outline, "points": [*sides[:2], *([end, BED] for end in BULGE), *sides[2:]]}
    level["bulge"] = {"edge": 2, "amplitude": AMPLITUDE, "period": 1.5, "ramp": 0.75}
    shaped = load_scene("bulging-wall", {**calm, "walls.polygons": [outline], "fluid.blocks": [block]})
    flat = build(load_scene("bulging-wall", {**calm, "walls.polygons": [level]}), Communicator())
    carried = build(shaped, Communicator())
    carried.domain.ghosts, carried.domain.markers = flat.domain.ghosts, flat.domain.markers
    return residual_accelerations(shaped), residuals_of(shaped, carried, time)


# --- runs -------------------------------------------------------------------------------------------------------------------


def _still(lines, folder, table):
    columns = ["walls", "status", "reached", "rest-energy", "energy-growth", *METRICS[2:], "particles", "steps", "cpu"]
    rows = [row for row in table.rows if row["group"] == "still"]
    lines += ["Still water, 0.6 m by 0.3 m:", "", *table.markdown(columns, rows), ""]
    curves = {row["walls"]: _kinetic(table.results(row["row"])) for row in table.select(group="still")}
    if curves:
        drawing, ax = viz.figure(size=(7.2, 3.4))
        viz.profile(ax, None, curves, "t [s]", "kinetic over potential energy [-]")
        ax.set_yscale("log")
        figure(
            lines, folder, "still-energy", "Still water: kinetic energy with the correction and with repulsion alone", drawing
        )
        peaks = ", ".join(f"{name} {energy.max():.1e} at {t[energy.argmax()]:.2f} s" for name, (t, energy) in curves.items())
        lines += [
            "Paper: repulsion alone has a transient at the start, for particles must find other distances from the wall; the "
            f"correction avoids it. Largest kinetic over potential energy here: {peaks}.",
            "",
        ]


def _kinetic(run):
    record = run.table(next(iter(run.gauges("energy"))))
    ratio = record["kinetic energy [J]"] / record["potential energy [J]"]
    moving = ratio > 0
    return record["time [s]"][moving], ratio[moving]


def _bulging(lines, folder, table):
    columns = ["walls", "status", "reached", *COSTS, "particles", "steps", "cpu"]
    rows = [row for row in table.rows if row["group"] == "bulging-wall"]
    lines += ["A bed that bulges into the water and out of it, with gravity:", "", *table.markdown(columns, rows), ""]
    runs = {row["walls"]: table.left(row["row"]) for row in rows}
    runs = {name: run for name, run in runs.items() if run is not None and run.snapshots}
    if not runs:
        return
    drawing, panels = viz.figure(2, 2, size=(7.6, 5.2))
    for ax, (name, run) in zip(panels.flat, runs.items(), strict=False):
        shot = run.snapshot()
        weight = run.scene["fluid"]["rho0"] * run.scene["domain"]["gravity"] * (LEVEL - BED)
        viz.particles(ax, shot["position"][:, :2], shot["pressure"] / weight, "p / (rho0 g H)", limits=(0.0, 1.3))
        ax.set_title(f"{name}, t = {shot['time']:.2f} s", loc="left", fontsize=viz.SMALL + 1)
    for ax in panels.flat[len(runs) :]:
        ax.set_visible(False)
    figure(lines, folder, "bulging-wall", "The bulging bed at the end of each run", drawing)
