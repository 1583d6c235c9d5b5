"""The shallow-water hump of Molteni et al., section 2, Figs. 1-6, with the reflection that theory gives drawn in.

The reflection ratio is that of eqs. (2.7), (2.8). Theory holds for layers that damp depth and velocity alike, without killing
functions and switches: ``exp(-(2/c) integral of sigma)``.
"""

import itertools
import math

import numpy as np

from ... import viz
from ...waves import layer_reflection
from ..declare import Group, Study
from ..report import figure

BASIN, WIDTH, SOFTENING = 500.0, 18.0, 1.0
SPEED = math.sqrt(9.81)
PROFILES = {
    "m = 1": {"profile": "power", "exponent": 1},
    "m = 2": {"profile": "power", "exponent": 2},
    "m = 3": {"profile": "power", "exponent": 3},
    "hyperbolic": {},
}
TREATMENTS = {
    "f1": {"killing": "f1"},
    "f2": {"killing": "f2"},
    "vx": {"switch": "vx"},
    "f1+vx": {"killing": "f1", "switch": "vx"},
    "velocity only": {"density": "none"},
    "velocity only, f1+vx": {"density": "none", "killing": "f1", "switch": "vx"},
}
STRENGTHS = (2.0, 4.0, 8.0, 16.0)


def study(quick):
    """Return the study; quick: four lengths, two spacings, one more width."""
    lengths = (10, 20, 50, 200) if quick else (5, 10, 20, 35, 50, 75, 100, 150, 200)
    fewer = (20, 50, 200) if quick else (10, 20, 50, 100, 200)
    widths = (9.0, WIDTH) if quick else (9.0, WIDTH, 36.0, 54.0)
    spacings = (1.0, 0.5) if quick else (1.0, 0.5, 0.25)
    strengths = (4.0, 16.0) if quick else STRENGTHS
    of_width = {f"{width:g}": {"fluid.blocks.0.width": width} for width in (WIDTH, *(w for w in widths if w != WIDTH))}
    of_spacing = {f"{dx:g}": {"numerics.dx": dx} for dx in spacings}
    paper = {"numerics.dx": 1.0, "numerics.h_over_dx": 2.0}
    settings = {"output.snapshots.every": 247.0}
    two = {name: PROFILES[name] for name in ("m = 1", "hyperbolic")}
    groups = [
        Group("infinite", "swe-pulse-infinite", settings, {"width": of_width}),
        Group("reflecting", "swe-pulse-reflecting", settings, {"width": of_width}),
        Group("profiles", "swe-pulse", settings, {"profile": _zones(PROFILES), "length": _lengths(lengths)}),
        Group(
            "strengths",
            "swe-pulse",
            settings,
            {
                "profile": _zones({name: PROFILES[name] for name in ("m = 1", "m = 2", "m = 3")}),
                "strength": {f"{s:g}": {"damping.0.v_ref": s * SPEED} for s in strengths},
                "length": _lengths(fewer),
            },
        ),
        Group(
            "treatments",
            "swe-pulse",
            settings,
            {"profile": _zones(two), "treatment": _zones(TREATMENTS), "length": _lengths(lengths)},
        ),
        Group(
            "widths",
            "swe-pulse",
            settings,
            {
                "treatment": _zones({"pure": {}, **{name: TREATMENTS[name] for name in ("f1", "f1+vx")}}),
                "width": {name: keys for name, keys in of_width.items() if name != f"{WIDTH:g}"},
                "length": _lengths(fewer),
            },
        ),
        *_compared("fine", settings, {"dx": of_spacing, "length": _lengths((10, 20, 50, 100, 200))}, {"dx": of_spacing}),
        *_compared("paper", settings | paper, {"length": _lengths((10, 20, 50, 100, 200))}, {}),
    ]
    title = "Absorbing layers in shallow water, 1D (Molteni et al., Figs. 1-6)"
    roles = {"infinite": "infinite", "reflecting": "reflecting"}
    return Study("absorbing-1d", title, tuple(groups), ("reflection-ratio",), roles, report)


def _compared(name, settings, axes, shared):
    """Return a group and its own infinite and reflecting ones."""
    roles = {"infinite": f"{name}-infinite", "reflecting": f"{name}-reflecting"}
    return (
        Group(roles["infinite"], "swe-pulse-infinite", settings, shared),
        Group(roles["reflecting"], "swe-pulse-reflecting", settings, shared),
        Group(name, "swe-pulse", settings, axes, roles),
    )


def _zones(variants):
    """Return the overrides of variants of the layer; sections are merged key by key, so axes may share the layer."""
    return {name: {f"damping.0.{key}": value for key, value in keys.items()} for name, keys in variants.items()}


def _lengths(lengths):
    return {f"{length:g}": _layer_of(float(length)) for length in lengths}


def _layer_of(length):
    far = BASIN + length
    return {"domain.size": [far], "fluid.blocks.0.high": [far], "damping.0.length": length}


def report(table, folder):
    """Return the report's lines, figure by figure: what the paper says and what our numbers say."""
    lines = ["## Figures"]
    _pulse(lines, folder, table)
    _profiles(lines, folder, table)
    _strengths(lines, folder, table)
    _treatments(lines, folder, table)
    _widths(lines, folder, table)
    _resolution(lines, folder, table)
    columns = ["row", "reflection-ratio", "particles", "steps", "evaluations", "cpu", "damping"]
    return [*lines, "", "## Table", "", *table.markdown(columns)]


def _curve(rows):
    """Return (length, reflection ratio) arrays of rows, sorted."""
    return tuple(np.array(sorted((float(row["length"]), row["reflection-ratio"]) for row in rows)).reshape(-1, 2).T)


def _theory(profile, factor=1.0, softening=SOFTENING):
    """Return (length, reflection) of theory; sigma0 = factor c/L."""
    lengths = np.linspace(2, 200, 100)
    exponent = PROFILES[profile].get("exponent", 1)
    kind = PROFILES[profile].get("profile", "hyperbolic")
    values = [layer_reflection(factor * SPEED / L, L, SPEED, kind, exponent, softening) for L in lengths]
    return lengths, np.array(values)


def _at(rows, length):
    """Return the reflection ratio at a length, NaN if there is none."""
    return next((row["reflection-ratio"] for row in rows if row["length"] == f"{length:g}"), math.nan)


def _draw(lines, folder, name, caption, curves, theory=None):
    if not any(len(x) for x, _ in curves.values()):
        return
    drawing, ax = viz.figure(size=(7.2, 4.2))
    viz.against(ax, None, curves, "length of the layer [m]", "reflection ratio R [-]", theory=theory)
    figure(lines, folder, name, caption, drawing)


def _pulse(lines, folder, table):
    runs = {group: table.select(group=group, width=f"{WIDTH:g}") for group in ("infinite", "reflecting")}
    if not all(runs.values()):
        return
    drawing, ax = viz.figure()
    curves = {}
    for name, rows in runs.items():
        results = table.results(rows[0]["row"])
        if not curves:
            first = results.snapshot(0)
            curves["at t = 0"] = first["position"][:, 0], first["density"]
        last = results.snapshot()
        curves[f"{name}, t = {last['time']:.0f} s"] = last["position"][:, 0], last["density"]
    viz.profile(ax, None, curves, "x [m]", "depth H [m]")
    figure(lines, folder, "fig-1", "Fig. 1: the pulse, reflected and run on", drawing)


def _profiles(lines, folder, table):
    found = {name: table.select(group="profiles", profile=name) for name in PROFILES}
    theory = {f"theory, {name}": _theory(name) for name in PROFILES}
    _draw(lines, folder, "fig-2", "Fig. 2: profiles, sigma0 = c/L", {k: _curve(rows) for k, rows in found.items()}, theory)
    hyperbolic = found["hyperbolic"]
    told = []
    for length in (10, 20, 50, 100, 200):
        value, exact = _at(hyperbolic, length), layer_reflection(SPEED / length, length, SPEED, softening=SOFTENING)
        if not math.isnan(value):
            told.append(f"L = {length}: {value:.2e} (theory {exact:.2e})")
    lines += [
        "Paper: for short layers m = 1 and the hyperbolic profile do best. Theory says that power laws with sigma0 = c/L "
        "reflect exp(-2/(m + 1)) whatever L: 0.37, 0.51, 0.61. Hyperbolic, measured: " + "; ".join(told) + ".",
    ]


def _strengths(lines, folder, table):
    rows = table.select(group="strengths")
    curves, theory = {}, {}
    for profile in ("m = 1", "m = 2", "m = 3"):
        for strength in STRENGTHS:
            label = f"{strength:g}"
            curves[f"{profile}, {label} c/L"] = _curve([r for r in rows if r["profile"] == profile and r["strength"] == label])
        theory[f"theory, {profile}, 8 c/L"] = _theory(profile, 8.0)
    _draw(lines, folder, "strengths", "Power laws with a larger sigma0 (not in the paper)", curves, theory)
    longest = [row for row in rows if row["length"] == "50"]
    if longest:
        best = min(longest, key=lambda row: row["reflection-ratio"])
        hyperbolic = _at(table.select(group="profiles", profile="hyperbolic"), 50)
        lines += [
            f"At L = 50 m the best power law is {best['profile']} with sigma0 = {best['strength']} c/L: R = "
            f"{best['reflection-ratio']:.2e}; hyperbolic with c/L: {hyperbolic:.2e}."
        ]


def _treatments(lines, folder, table):
    for number, profile in (("m1", "m = 1"), ("hyperbolic", "hyperbolic")):
        curves = {"pure": _curve(table.select(group="profiles", profile=profile))}
        for name in TREATMENTS:
            curves[name] = _curve(table.select(group="treatments", profile=profile, treatment=name))
        caption = f"Figs. 3, 4, 5: {profile}, killing functions and the switch vx < 0"
        _draw(lines, folder, f"fig-3-4-5-{number}", caption, curves, {"theory, pure": _theory(profile)})
    lines += ["Paper: f1 improves on the pure profile, more than f2; best of all is hyperbolic + f1 + vx < 0.", ""]
    for length in (20, 50, 100, 200):
        ranked = []
        for profile in ("m = 1", "hyperbolic"):
            named = {"pure": table.select(group="profiles", profile=profile)}
            named |= {name: table.select(group="treatments", profile=profile, treatment=name) for name in TREATMENTS}
            ranked += [(_at(rows, length), f"{profile} {name}") for name, rows in named.items()]
        ranked = sorted(entry for entry in ranked if not math.isnan(entry[0]))
        if ranked:
            told = ", ".join(f"{name} {value:.2e}" for value, name in ranked)
            lines += [f"- L = {length} m, best first: {told}"]


def _widths(lines, folder, table):
    curves = {}
    for treatment in ("pure", "f1", "f1+vx"):
        for width in dict.fromkeys(row["width"] for row in table.select(group="widths")):
            curves[f"{treatment}, A = {width} m"] = _curve(table.select(group="widths", treatment=treatment, width=width))
    _draw(lines, folder, "fig-6", "Fig. 6: wider and narrower pulses, hyperbolic", curves, {"theory": _theory("hyperbolic")})
    lines += [
        "Paper: a wider pulse needs a longer layer for the same ratio; theory of a matched layer knows no width. Pure:",
        "",
    ]
    for width in dict.fromkeys(row["width"] for row in table.select(group="widths")):
        rows = table.select(group="widths", treatment="pure", width=width)
        lines += [f"- A = {width} m: " + ", ".join(f"L = {L:g}: {R:.2e}" for L, R in zip(*_curve(rows), strict=True))]


def _resolution(lines, folder, table):
    rows = table.select(group="fine")
    curves = {}
    for dx in dict.fromkeys(row["dx"] for row in rows):
        curves[f"dx = {dx} m, h = 2.5 dx"] = _curve([row for row in rows if row["dx"] == dx])
    curves["paper: dx = 1 m, h = 2 m"] = _curve(table.select(group="paper"))
    caption = "Resolution, with the same softening of the layer's end (1 m)"
    _draw(lines, folder, "resolution", caption, curves, {"theory": _theory("hyperbolic")})
    floors = sorted(((float(row["dx"]), row["reflection-ratio"]) for row in rows if row["length"] == "200"), reverse=True)
    exact = layer_reflection(SPEED / 200, 200, SPEED, softening=SOFTENING)
    excess = [(dx, math.sqrt(max(value**2 - exact**2, 0.0))) for dx, value in floors]
    lines += [
        "The floor, R at L = 200 m beyond theory (as energies): " + ", ".join(f"dx = {dx:g} m: {v:.2e}" for dx, v in excess)
    ]
    for (dx, above), (finer, below) in itertools.pairwise(excess):
        if above > 0 and below > 0:
            lines[-1] += f"; order {math.log(above / below) / math.log(dx / finer):.1f} from {dx:g} to {finer:g} m"
    lines[-1] += "."
