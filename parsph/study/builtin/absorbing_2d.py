"""The wave pool of Molteni et al., section 3, Figs. 8-20, and the quantitative evaluation that the paper leaves open.

Every variant of the layer times its length in wavelengths: reflection coefficient, difference of levels and of kinetic energy
from the infinite pool, and cost. The paper's variants take v_ref = c0; those that begin with "soft", "linear" and "matched" are
ours.
"""

import numpy as np

from ... import viz
from ..declare import Group, Study
from ..report import figure

WAVELENGTH, PERIOD, POOL = 6.061, 2.236969878, 6.061
LENGTHS = {"1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0}
VARIANTS = {
    "M0": {},
    "VxVy": {"switch": "vx-vy"},
    "Vx": {"switch": "vx"},
    "Fx&Vx": {"switch": "fx-vx"},
    "f1": {"killing": "f1"},
    "f2": {"killing": "f2"},
    "f1+Vx": {"killing": "f1", "switch": "vx"},
    "soft": {"v_ref": 6.26},
    "soft+f1+Vx": {"v_ref": 6.26, "killing": "f1", "switch": "vx"},
    "linear": {"v_ref": 9.09, "profile": "power"},
    "linear+f1+Vx": {"v_ref": 9.09, "profile": "power", "killing": "f1", "switch": "vx"},
    "matched": {"v_ref": 4.06, "density": "matched"},
}
OURS = ("soft", "soft+f1+Vx", "linear", "linear+f1+Vx", "matched")
IMPULSES = ("M0", "VxVy", "Vx", "f1", "linear+f1+Vx", "matched")
PLACES = (1.0, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0)
PAPER_PLACES = (1.0, 2.0, 3.0, 4.0, 5.0)
METRICS = ("reflection", "incident", "level-difference", "energy-difference", "energy-excess", "residual-energy")
BARS = {"1/2": 0.05, "1": 0.02}


def study(quick):
    """Return the study; quick: 10 instead of 20 particles per depth, two lengths, 20 s."""
    gauges = [{"kind": "level", "x": x} for x in PLACES]
    gauges.append({"kind": "energy", "name": "energy-pool", "low": [-1.0, -1.0], "high": [POOL, 10.0], "every": 0.02})
    end = 20.0 if quick else 25.0
    settings = {"output.snapshots.every": end, "time.end": end}
    if quick:
        settings["numerics.dx"] = 0.1
    waves = {**settings, "gauges": gauges}
    lengths = {name: _layer_of(share) for name, share in LENGTHS.items() if not quick or name in ("1/2", "1")}
    variants = {name: _variant(keys) for name, keys in VARIANTS.items()}
    groups = [
        Group("infinite", "pool-infinite", waves),
        Group("reflecting", "pool-reflecting", waves),
        Group("layers", "pool", waves, {"length": lengths, "variant": variants}),
    ]
    if not quick:
        single = {**settings, "wavemaker.wave.cycles": 1, "wavemaker.wave.ramp": 0.0}
        ten = {**single, "gauges": [*({"kind": "level", "x": 0.3 + 0.6 * k} for k in range(10)), gauges[-1]]}
        some = {name: variants[name] for name in IMPULSES}
        two = {name: lengths[name] for name in ("1/2", "1")}
        compared = {"infinite": "impulse-infinite"}
        groups += [
            Group("impulse-infinite", "pool-infinite", ten),
            Group("impulse-reflecting", "pool-reflecting", ten, references=compared),
            Group("impulse", "pool", ten, {"length": two, "variant": some}, references=compared),
        ]
    title = "Absorbing layers in the wave pool (Molteni et al., Figs. 8-20, and their open question)"
    return Study("absorbing-2d", title, tuple(groups), METRICS, {"infinite": "infinite"}, report)


def _layer_of(share):
    length = share * WAVELENGTH
    far = round(POOL + length, 6)
    return {
        "domain.size": [far, 1.5],
        "fluid.blocks": [{"low": [0.0, 0.0], "high": [far, 1.0]}],
        "damping": [{"side": "right", "length": length}],
    }


def _variant(keys):
    return {f"damping.0.{key}": value for key, value in keys.items()}


def report(table, folder):
    """Return the report's lines, figure by figure: what the paper says and what our numbers say."""
    lines = ["## Continuous waves"]
    runs = {row["row"]: table.results(row["row"]) for row in table.select()}
    layers = {(row["length"], row["variant"]): row for row in table.select(group="layers")}
    if "infinite" in runs:
        _levels(lines, folder, runs, "fig-08", {"infinite": "infinite"})
        lines += ["Paper, Fig. 8: the waves propagate without disturbances. " + _heights(runs["infinite"])]
    if "reflecting" in runs:
        _particles(lines, folder, runs["reflecting"], "fig-09", "Figs. 9, 14: velocities in the reflecting pool at the end")
        _levels(lines, folder, runs, "fig-10", {"reflecting": "reflecting"})
        lines += ["Paper, Fig. 10: the oscillations are larger and increase with time. " + _growth(table, runs)]
    for key in (("1", "M0"), ("1", "matched")):
        if key in layers and "infinite" in runs:
            name = layers[key]["row"]
            _levels(lines, folder, runs, f"fig-11-{key[1]}", {"infinite": "infinite", f"layer, {key[1]}": name})
            difference = layers[key]["level-difference"]
            lines += [
                f"Paper, Fig. 11 (M0): very similar to the infinite case. Here {key[1]} differs by {difference:.1%} (L2)."
            ]
    _energies(lines, folder, runs, layers)
    _lengths(lines, folder, table, layers)
    _cost(lines, folder, table, layers)
    lines += _verdict(table, layers)
    if table.select(group="impulse"):
        _impulses(lines, folder, table, runs)
    columns = ["row", *METRICS[:-1], "particles", "evaluations", "cpu", "damping"]
    lines += ["", "## Table", "", *table.markdown(columns, [row for row in table.rows if "impulse" not in row["group"]])]
    if table.select(group="impulse"):
        columns = ["row", "level-difference", "energy-difference", "residual-energy", "particles", "cpu"]
        lines += ["", *table.markdown(columns, [row for row in table.rows if "impulse" in row["group"]])]
    return lines


def _levels(lines, folder, runs, name, chosen, places=PAPER_PLACES):
    """Draw the levels of some runs over each other, as the paper's figures have them."""
    drawing, ax = viz.figure()
    styles = [{"lw": 1.0}, {"lw": 1.0, "ls": "--", "color": "0.15"}]
    for style, (label, run) in zip(styles, chosen.items(), strict=False):
        t, levels, x, _ = runs[run].levels()
        picked = [k for k, place in enumerate(x) if np.isclose(places, place).any()]
        viz.levels(ax, t, levels[picked].T, [f"x = {x[k]:g} m" for k in picked], style={**style, "label": label})
    figure(lines, folder, name, f"{name.replace('fig-', 'Fig. ')}: levels, {' and '.join(chosen)}", drawing)


def _particles(lines, folder, run, name, caption):
    last = run.snapshot()
    speed = np.linalg.norm(last["velocity"], axis=1)
    drawing, ax = viz.figure(size=(7.2, 2.6))
    viz.particles(ax, last["position"][:, :2], speed, "speed [m/s]", still_level=run.level, vectors=last["velocity"][:, :2])
    figure(lines, folder, name, caption, drawing)


def _heights(run):
    t, levels, x, _ = run.levels()
    late = t >= t[-1] - 2.000001 * PERIOD
    heights = [np.ptp(level[late]) for level in levels]
    told = ", ".join(f"{100 * height:.1f}" for height in heights)
    return f"Heights over the last two periods at x = {', '.join(f'{place:g}' for place in x)} m: {told} cm (theory: 9.56 cm)."


def _kinetic(run):
    record = run.table("energy-pool")
    return record["time [s]"], record["kinetic energy [J]"]


def _growth(table, runs):
    t, energy = _kinetic(runs["reflecting"])
    means = [energy[(t >= k * PERIOD) & (t < (k + 1) * PERIOD)].mean() for k in (2, 4, 6, 8) if (k + 1) * PERIOD <= t[-1]]
    told = ", ".join(f"{mean:.0f}" for mean in means)
    return f"Mean kinetic energy of periods 3, 5, 7, ...: {told} J."


def _energies(lines, folder, runs, layers):
    if "infinite" not in runs:
        return
    longest = {key[1]: runs[row["row"]] for key, row in layers.items() if key[0] == "1"}
    shown = {
        "infinite": runs["infinite"],
        **{name: longest[name] for name in ("M0", "VxVy", "Vx", "matched") if name in longest},
    }
    if "reflecting" in runs:
        drawing, ax = viz.figure()
        viz.energy(ax, None, {name: _kinetic(run) for name, run in {"reflecting": runs["reflecting"], **shown}.items()})
        figure(lines, folder, "fig-12", "Fig. 12: kinetic energy of the pool, layers of one wavelength", drawing)
    drawing, ax = viz.figure()
    viz.energy(ax, None, {name: _kinetic(run) for name, run in shown.items()})
    figure(lines, folder, "fig-13", "Fig. 13: the same without resonance", drawing)
    told = ", ".join(
        f"{key[1]} {row['energy-difference']:.1%} (largest {row['energy-excess']:.1%})"
        for key, row in layers.items()
        if key[0] == "1"
    )
    lines += [
        "Paper, Figs. 12 and 13: growth in resonance, steady with a layer; every switch does better than M0, V_x best "
        f"(by eye). Difference from the infinite pool after start-up, RMS, one wavelength: {told}."
    ]


def _lengths(lines, folder, table, layers):
    """Draw each metric against the length of the layer."""
    lines += ["", "## Variants against length of the layer"]
    for metric, label in (
        ("reflection", "reflection coefficient [-]"),
        ("level-difference", "level difference from infinite [-]"),
        ("energy-difference", "kinetic energy difference, RMS [-]"),
    ):
        curves = {}
        for variant in VARIANTS:
            points = [(LENGTHS[key[0]], row[metric]) for key, row in layers.items() if key[1] == variant]
            if points:
                curves[variant] = tuple(np.array(sorted(points)).T)
        drawing, ax = viz.figure(size=(7.2, 4.4))
        bars = {"2 %": 0.02, "5 %": 0.05} if metric == "reflection" else None
        viz.against(ax, None, curves, "length of the layer [wavelengths]", label, bars=bars)
        figure(lines, folder, metric, f"{metric} against length of the layer", drawing)


def _cost(lines, folder, table, layers):
    bare = table.select(group="reflecting")
    points = [(f"{key[0]}", row["cpu"], row["reflection"], key[1]) for key, row in layers.items()]
    drawing, ax = viz.figure(size=(7.2, 4.8))
    viz.error_against_cost(ax, points, ylabel="reflection coefficient [-]")
    figure(
        lines, folder, "reflection-cost", "Reflection against CPU time of the whole run; labels: wavelengths of layer", drawing
    )
    if bare:
        cost = bare[0]["cpu"] / bare[0]["evaluations"]
        shares = [row["damping"] / row["wall"] for row in layers.values()]
        lines += [
            f"The layer itself takes {np.mean(shares):.1%} of a run (largest {max(shares):.1%}); the water in it costs as much "
            f"as any other, {1e6 * cost:.2f} microseconds per particle and step."
        ]


def _verdict(table, layers):
    """Return which variant wins at each length, by how much and at what cost."""
    lines = ["", "### Which variant wins", ""]
    floor = table.select(group="infinite")
    if floor:
        lines += [
            f"The infinite pool reads {floor[0]['reflection']:.2%}: what gauges, decay and dispersion make of no reflection.",
            "",
        ]
    for length in LENGTHS:
        ranked = sorted((row["reflection"], key[1], row["cpu"]) for key, row in layers.items() if key[0] == length)
        if not ranked:
            continue
        bar = f"; bar {BARS[length]:.0%}" if length in BARS else ""
        value, name, cost = ranked[0]
        told = f"- {length} wavelength: **{name} {value:.2%}** ({cost:.0f} CPU s{bar})"
        for value, name, cost in [entry for entry in ranked if entry[1] not in OURS][:1]:
            told += f"; best of the paper's: {name} {value:.1%} ({cost:.0f} CPU s)"
        lines += [told + "; all: " + ", ".join(f"{name} {value:.1%}" for value, name, _ in ranked)]
    return lines


def _impulses(lines, folder, table, runs):
    lines += ["", "## A single oscillation of the palette"]
    rows = {(row["length"], row["variant"]): row for row in table.select(group="impulse")}
    every = tuple(0.3 + 0.6 * k for k in range(10))
    for number, label, name in (
        ("15", "reflecting", "impulse-reflecting"),
        ("16", "M0", rows.get(("1", "M0"), {}).get("row")),
        ("17", "VxVy", rows.get(("1", "VxVy"), {}).get("row")),
        ("17-matched", "matched", rows.get(("1", "matched"), {}).get("row")),
    ):
        if name in runs and "impulse-infinite" in runs:
            chosen = {"infinite": "impulse-infinite", label: name}
            _levels(lines, folder, runs, f"fig-{number}", chosen, every)
            difference = next(row["level-difference"] for row in table.rows if row["row"] == name)
            lines += [f"{label}: levels differ from the infinite pool by {difference:.1%} (L2)."]
    lines += ["", "Paper, Figs. 15-17: oscillations stay in the reflecting pool; M0 shows a small bump at 5 to 6 s, VxVy none."]
    for number, length in (("18", "1"), ("19", "1/2")):
        chosen = {key[1]: _kinetic(runs[row["row"]]) for key, row in rows.items() if key[0] == length}
        if chosen and "impulse-infinite" in runs:
            drawing, axes = viz.figure(1, 2, size=(9.0, 3.6))
            viz.energy(axes[0], None, {"infinite": _kinetic(runs["impulse-infinite"]), **chosen})
            late = {name: (t[t > 5], e[t > 5]) for name, (t, e) in chosen.items()}
            viz.energy(axes[1], None, late)
            axes[1].set_yscale("log")
            figure(lines, folder, f"fig-{number}", f"Fig. {number}: kinetic energy, layer of {length} wavelength", drawing)
            told = ", ".join(f"{key[1]} {row['energy-difference']:.1%}" for key, row in rows.items() if key[0] == length)
            lines += [f"RMS difference from the infinite pool over the peak: {told}."]
    lines += [
        "",
        "Paper, Figs. 18-20: the switches lower the residual oscillations of M0; f1 improves on M0, but not over the switch.",
    ]
