"""Plots for papers and logs: data and a matplotlib ``ax`` in, drawn artists out; no solver and no pyplot.

matplotlib is optional (``pip install 'parsph[plots]'``) and only `figure` imports it; no function touches its global settings,
so figures may be drawn in threads and without a display.

>>> figure, ax = viz.figure()  # doctest: +SKIP
>>> viz.energy(ax, t, {"kinetic": kinetic, "potential": potential})  # doctest: +SKIP
>>> viz.save(figure, "plots/energy.png")  # doctest: +SKIP
"""

import itertools
import math
from pathlib import Path

import numpy as np

from .errors import SceneError

# Okabe & Ito's palette, which colour-blind readers can tell apart; its yellow is left out, too pale for a thin line on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = "os^Dv<>P"  # one more than colours, so that pairs repeat late
DASHES = ("-", "--", "-.", ":")
GREY = "0.45"
SMALL, LINE, POINT = 8, 1.1, 5  # [pt]: font, line width, marker diameter
DECADES = 4  # of a logarithmic colour scale: what is smaller is as good as nothing
FEW = 0.002  # of all values, at either end, which may be left out of a colour scale
ARROWS = 300  # more than this many arrows hide each other
# Where a label may stand beside its point [pt], the best first: right of and above a point it is clear of the Pareto front.
PLACES = ((4, 4), (-4, -4), (-4, 4), (4, -4), (-5, 0), (0, -6), (0, 6), (5, 0), (4, 12), (-4, -12), (-4, 12), (4, -12))


def figure(rows=1, columns=1, size=None, share_x=False):
    """Return (Figure, axes); axes as `matplotlib.figure.Figure.subplots` gives them: one, or an array of them.

    Parameters
    ----------
    rows, columns : int
    size : (float, float), optional
        Width and height [inch]; by default as wide as a page's text (two columns) or most of it.
    share_x : bool
        Whether the panels of a column share their x axis, which only the lowest then labels.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        why = "plots are drawn with it, and parsph itself works without"
        raise SceneError("matplotlib is not installed", where="plots", why=why, cure="pip install 'parsph[plots]'") from error
    made = Figure(figsize=size or (5.5 if columns == 1 else 7.2, 0.6 + 2.6 * rows), layout="constrained")
    return made, made.subplots(rows, columns, sharex="col" if share_x else False)


def save(figure, path):
    """Write a figure as PNG, 150 dots per inch, trimmed; make missing folders; return the path (ending added if missing)."""
    path = Path(path)
    path = path if path.suffix.lower() == ".png" else path.with_name(f"{path.name}.png")
    path.parent.mkdir(parents=True, exist_ok=True)
    if figure.get_layout_engine() is None:
        figure.set_layout_engine("constrained")
    _settle(figure)
    figure.savefig(path, format="png", dpi=150, bbox_inches="tight", pad_inches=0.05)
    return path


def limits_of(values, few=FEW):
    """Return the smallest and the largest value, unless few values make most of the range: then `few` are off at either end.

    A splash has single particles under many times the pressure of all others, which then would have one colour.
    """
    if not len(values):
        return 0.0, 1.0
    low, inner_low, inner_high, high = np.quantile(values, [0, few, 1 - few, 1])
    return (inner_low, inner_high) if high - low > 2 * (inner_high - inner_low) > 0 else (low, high)


def particles(
    ax, position, values, label, still_level=None, layer=None, size=None, limits=None, vectors=None, log=False, unit="m/s"
):
    """Draw 2D particles coloured by a field; return (cloud, colour bar, arrows or None).

    Parameters
    ----------
    position : (n, 2) array
        [m]
    values : (n,) array
        The field; a particle where it is not finite is left out.
    label : str
        Name and unit of the field, such as ``"p [Pa]"``.
    still_level : float, optional
        Height of the still water [m], a dashed line.
    layer : (float, float), optional
        Range of x [m] of an absorbing layer, shaded.
    size : float, optional
        Area of a marker [pt^2], as in ``ax.scatter``; by default markers just cover the water, and `save` keeps it so.
    limits : (float, float), optional
        The values at the ends of the colour bar, by default the smallest and the largest, but without few far-off values
        (`limits_of`); pointed ends show values beyond.
    vectors : (n, 2) array, optional
        Velocities [m/s], thin arrows; of very many particles one in each cell of a square grid gets one.
    log : bool
        Whether the colour scale is logarithmic, over at most `DECADES`; smaller values have its lowest colour.
    unit : str
        Of the vectors, for others than velocities.
    """
    position, values = np.asarray(position, dtype=float), np.asarray(values, dtype=float)
    good = np.isfinite(values) & np.isfinite(position).all(axis=1)
    position, values = position[good], values[good]
    ends = limits_of(values, few=0.0)
    low, high = limits or (ends if log else limits_of(values))
    log = log and high > 0
    if log:
        low = max(low, high / 10**DECADES)
    extend = ("neither", "min", "max", "both")[int(ends[0] < low) + 2 * int(ends[1] > high)]
    # Thousands of vector circles would make a PDF of the caller's slow to show: they become a bitmap in it.
    style = {"cmap": "viridis", "vmin": low, "vmax": high, "linewidths": 0, "rasterized": True, "zorder": 2}
    if log:
        style["norm"], values = "log", np.maximum(values, low)
    cloud = ax.scatter(*position.T, s=size or POINT**2, c=values, **style)
    _frame(ax, "x [m]", "z [m]")
    ax.grid(False)  # it would lie behind the water
    if layer is not None:
        ax.axvspan(*layer, color="0.91", linewidth=0, zorder=0)
        for x in layer:  # the shade is behind the water, where only its ends can be seen
            ax.axvline(x, color="black", linewidth=0.6, linestyle=":", zorder=3)
    if still_level is not None:
        ax.axhline(still_level, color="black", linewidth=0.8, linestyle="--", zorder=3)
    ax.set_aspect("equal", adjustable="box")
    spacing = _spacing(position)
    ax.margins(max(0.01, 0.7 * spacing / max(np.ptp(position[:, 0]), spacing)) if spacing else 0.01, 0.06)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    ratio = (right - left) / (top - bottom)
    long = ratio > 2.5  # a bar beside a long tank would be too low to read
    bounds = (0, 1 + 0.02 * ratio, 0.6, 0.012 * ratio) if long else (1.02, 0, 0.025, 1)
    # In an inset, unlike in axes of its own, the bar keeps to the box that the equal scales leave of the panel.
    options = {"orientation": "horizontal", "ticklocation": "top"} if long else {}
    bar = ax.figure.colorbar(cloud, cax=ax.inset_axes(bounds), extend=extend, **options)
    bar.set_label(label, fontsize=SMALL + 1)
    bar.ax.tick_params(labelsize=SMALL, width=0.6)
    bar.outline.set_linewidth(0.6)
    arrows = None
    if vectors is not None and len(position):
        height = 1 + 0.02 * ratio if long else 1.02
        arrows = _arrows(ax, position, np.asarray(vectors, dtype=float)[good], spacing, height, unit)
    if size is None and spacing:
        cloud.spacing = spacing
        _settle(ax.figure)
    return cloud, bar, arrows


def walls(ax, lines):
    """Draw walls, each an array of points, shape (n, 2) [m], over particles."""
    for points in lines:
        ax.plot(*points.T, color="0.25", lw=1.2, solid_joinstyle="miter", zorder=3)
    return ax


def levels(ax, t, levels, names, offset=None, style=None, still=None):
    """Draw level records one above the other, the first lowest and true to the axis; return the lines, one a gauge.

    A second call draws another run over the first: gauges are known by name and keep their places.

    Parameters
    ----------
    t : (n,) array
        [s]
    levels : (n, gauges) array
        [m]
    names : sequence of str
        One a gauge, written at the right end of its line.
    offset : float, optional
        Shift from one gauge to the next [m]; by default no two overlap. The first call's stays.
    style : dict, optional
        Properties of the lines, such as ``{"label": "2 ranks", "linestyle": "--"}``.
    still : float or (gauges,) array, optional
        Levels of the still water [m], thin grey lines; by default each gauge's first. The first call's stay.
    """
    levels = np.asarray(levels, dtype=float)
    levels = levels[:, None] if levels.ndim == 1 else levels
    places = {line.gauge: line for line in ax.lines if hasattr(line, "gauge")}  # on the artists, as ``ax.clear`` forgets them
    run = sum(getattr(line, "record", None) == names[0] for line in ax.lines)
    finite = [column[np.isfinite(column)] for column in levels.T]
    if still is None:
        known = [column[0] for column in finite if len(column)]
        still = [column[0] if len(column) else np.mean(known or [0.0]) for column in finite]
    if places:
        offset = next(iter(places.values())).offset
    elif offset is None:
        ranges = [np.ptp(column) for column in finite if len(column)]
        overlaps = [a.max() - b.min() for a, b in itertools.pairwise(finite) if len(a) and len(b)]
        offset = _round_up(1.05 * max([0.0, *ranges, *overlaps]))
    style, lines = dict(style or {}), []
    label = style.pop("label", None)
    for name, column, rest in zip(names, levels.T, np.broadcast_to(still, len(names)), strict=True):
        if name not in places:
            places[name] = line = ax.axhline(rest + len(places) * offset, color="0.75", linewidth=0.6, zorder=1)
            line.gauge, line.offset, line.shift = name, offset, (len(places) - 1) * offset
            beside = {"transform": ax.get_yaxis_transform(), "va": "center", "fontsize": SMALL}
            ax.text(1.01, line.get_ydata()[0], name, **beside)
        look = {"color": COLOURS[run % len(COLOURS)], "linewidth": LINE, "label": None if lines else label}
        lines += ax.plot(t, column + places[name].shift, **look)
        lines[-1].set(**style)  # not an argument of `plot`, which takes no "lw" beside our "linewidth"
        lines[-1].record = name
    _frame(ax, "t [s]", "level [m]" if len(places) == 1 else f"level [m], shifted by {offset:g} m a gauge")
    ax.grid(False, axis="y")  # each gauge has its own zero, the grey line
    ax.margins(x=0)
    _legend(ax)
    return lines


def energy(ax, t, curves):
    """Draw energies against time; return the lines by name.

    Parameters
    ----------
    t : (n,) array or None
        Common times [s]; None when every curve has its own.
    curves : dict of str to (n,) array or (t, energy)
        [J]
    """
    return profile(ax, t, curves, "t [s]", "energy [J]")


def profile(ax, x, curves, xlabel, ylabel):
    """Draw lines, such as a pulse or a dam break; return them by name.

    Parameters
    ----------
    x : (n,) array or None
        Common abscissa; None when every curve has its own.
    curves : dict of str to (n,) array or (x, y)
    xlabel, ylabel : str
        With units.
    """
    lines = {}
    for k, (name, curve) in enumerate(curves.items()):
        dashes = DASHES[k // len(COLOURS) % len(DASHES)]  # colours first, then the same ones dashed
        (lines[name],) = ax.plot(*_pair(x, curve), dashes, color=COLOURS[k % len(COLOURS)], linewidth=LINE, label=name)
    _frame(ax, xlabel, ylabel)
    ax.margins(x=0)
    _legend(ax)
    return lines


def against(ax, x, curves, xlabel, ylabel, log_y=True, theory=None, bars=None):
    """Draw measured points, such as reflection against the layer's length; return all lines by name.

    Points that are not finite are left out.

    Parameters
    ----------
    x : (n,) array or None
        Common abscissa; None when every curve has its own.
    curves : dict of str to (n,) array or (x, y)
    xlabel, ylabel : str
        With units.
    log_y : bool
    theory : dict of str to (n,) array or (x, y), optional
        Thin dashed lines, black and grey.
    bars : dict of str to float, optional
        Levels to compare with: dotted lines, their names at the right end.
    """
    lines = {}
    for k, (name, curve) in enumerate((theory or {}).items()):
        look = {"color": ("black", GREY, "0.65")[k % 3], "linestyle": DASHES[1 + k // 3 % 2], "linewidth": 0.9, "zorder": 1.5}
        (lines[name],) = ax.plot(*_finite(x, curve), label=name, **look)
    for k, (name, curve) in enumerate(curves.items()):
        look = {"color": COLOURS[k % len(COLOURS)], "linewidth": 0.4, "marker": MARKERS[k % len(MARKERS)], "markersize": POINT}
        (lines[name],) = ax.plot(*_finite(x, curve), label=name, markeredgewidth=0, **look)
    for name, value in (bars or {}).items():
        lines[name] = ax.axhline(value, color=GREY, linewidth=0.9, linestyle=":", zorder=1)
        beside = {"transform": ax.get_yaxis_transform(), "va": "center", "fontsize": SMALL, "color": "0.3"}
        ax.text(1.01, value, name, **beside)
    _frame(ax, xlabel, ylabel)
    if log_y:
        ax.set_yscale("log")
        _plain(ax.yaxis)
    _legend(ax)
    return lines


def spectra(ax, curves, target=None):
    """Draw variance densities against frequency; return the `ax`.

    Parameters
    ----------
    curves : dict of str to (frequency, density)
        [Hz], [m^2/Hz]; arrays of shape (n,).
    target : (frequency, density), optional
        What was asked for, a dashed black line.
    """
    if target is not None:
        ax.plot(*_finite(None, target), color="black", linestyle="--", linewidth=0.9, label="target", zorder=3)
    profile(ax, None, curves, "f [Hz]", "S [m$^2$/Hz]")
    drawn = [_pair(None, curve) for curve in ([*curves.values()] if target is None else [*curves.values(), target])]
    highest = max(density.max() for _, density in drawn)
    ends = [frequency[density > 1e-3 * highest].max(initial=0.0) for frequency, density in drawn]
    ax.set_xlim(0, 1.05 * max(ends) or None)  # what lies beyond is as good as nothing
    ax.set_ylim(bottom=0)
    return ax


def harmonics(ax, x, amplitudes, layers=()):
    """Draw amplitudes of harmonics along the tank, on a logarithmic axis; return the `ax`.

    Parameters
    ----------
    x : (gauges,) array
        [m]
    amplitudes : (gauges, count) array
        Of the first harmonic and on [m]; those `DECADES` below the largest are left out, as good as nothing.
    layers : sequence of (float, float)
        Ranges of x [m] of absorbing layers, shaded.
    """
    amplitudes = np.asarray(amplitudes, dtype=float)
    shown = np.where(amplitudes > amplitudes.max() / 10**DECADES, amplitudes, np.nan)
    _shade(ax, layers)
    against(ax, x, {f"harmonic {n}": a for n, a in enumerate(shown.T, start=1)}, "x [m]", "amplitude [m]")
    return ax


def decay(ax, x, amplitudes, decays=None, layers=()):
    """Draw the amplitude of regular waves along the tank with curves to compare it with; return the `ax`.

    Parameters
    ----------
    x, amplitudes : (gauges,) arrays
        [m]
    decays : dict of str to (x, amplitude), optional
        Dashed lines.
    layers
        As `harmonics`.
    """
    _shade(ax, layers)
    against(ax, x, {"harmonic 1": amplitudes}, "x [m]", "amplitude [m]", log_y=False, theory=decays)
    return ax


def _shade(ax, layers):
    """Shade absorbing layers, each (low, high) x [m]."""
    for layer in layers:
        ax.axvspan(*layer, color="0.91", linewidth=0, zorder=0)


def pareto(cost, error):
    """Return the rows, cheapest first, of the points that no other beats: none is as cheap and as good and better in one.

    Parameters
    ----------
    cost, error : (n,) arrays
        The smaller the better; rows that are not finite do not count, and of equal points the first does.
    """
    cost, error = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    rows, best = [], math.inf
    for row in np.lexsort((error, cost)):
        if np.isfinite(cost[row]) and error[row] < best:
            rows.append(int(row))
            best = error[row]
    return rows


def error_against_cost(ax, rows, xlabel="cost [CPU s]", ylabel="error [-]"):
    """Draw what accuracy costs, on logarithmic axes, with the Pareto front; return (points by group, front).

    Parameters
    ----------
    rows : list of (label, cost, error, group)
        Rows whose numbers are not finite and positive are left out.
    xlabel, ylabel : str
        With units.
    """
    rows = [row for row in rows if all(math.isfinite(value) and value > 0 for value in row[1:3])]
    points = {}
    for k, group in enumerate(dict.fromkeys(row[3] for row in rows)):
        own = np.array([row[1:3] for row in rows if row[3] == group], dtype=float)
        look = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)], "linewidths": 0, "zorder": 3}
        points[group] = ax.scatter(*own.T, s=1.4 * POINT**2, label=group, **look)
    costs, errors = np.array([row[1:3] for row in rows], dtype=float).reshape(-1, 2).T
    best = pareto(costs, errors)
    step = {"drawstyle": "steps-post", "color": GREY, "linewidth": 0.8, "zorder": 1.5}
    (front,) = ax.plot(costs[best], errors[best], label="Pareto front", **step)
    _frame(ax, xlabel, ylabel)
    if rows:  # nothing has no logarithm
        ax.set(xscale="log", yscale="log")
        _plain(ax.xaxis)
        _plain(ax.yaxis)
    ax.margins(0.12)
    _legend(ax)
    for label, cost, error, _ in rows:
        text = ax.annotate(label, (cost, error), PLACES[0], textcoords="offset points", fontsize=SMALL - 1, color="0.2")
        text.beside = True
    _settle(ax.figure)
    return points, front


def _frame(ax, xlabel, ylabel):
    """Label the axes and give them the common look."""
    # Of panels that share an axis only the lowest has numbers there, so only it gets a label.
    ax.set_xlabel(xlabel if ax.xaxis.get_tick_params().get("labelbottom", True) else "", fontsize=SMALL + 1)
    ax.set_ylabel(ylabel, fontsize=SMALL + 1)
    ax.tick_params(which="both", labelsize=SMALL, width=0.6, color="0.3")
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_linewidth(0.6)
    ax.set_axisbelow(True)
    ax.grid(True, color="0.92", linewidth=0.6)


def _plain(axis):
    """Let a logarithmic axis say 0.02 for 2 x 10^-2, and no more numbers than have room."""

    def say(value, _):
        low, high = sorted(axis.get_view_interval())
        shown = "1" if high > 100 * low else "125" if high > 5 * low else "123456789"
        if f"{value:e}"[0] not in shown:
            return ""
        return f"{value:g}" if 1e-4 <= value < 1e5 else f"$10^{{{math.log10(value):.0f}}}$" if shown == "1" else f"{value:.0e}"

    axis.set_major_formatter(say)
    axis.set_minor_formatter(say)


def _legend(ax):
    """Put the legend above the panel, the one place where it covers no data."""
    labels = ax.get_legend_handles_labels()[1]
    if labels:
        width = ax.get_window_extent().width * 72 / ax.figure.dpi
        widths = [0.55 * SMALL * len(label) + 36 for label in labels]  # a letter is half as wide as high, about
        columns = len(labels) if sum(widths) < width else max(1, int(width / max(widths)))
        look = {"loc": "lower left", "bbox_to_anchor": (0, 1), "frameon": False, "borderpad": 0.3, "borderaxespad": 0.2}
        ax.legend(ncols=columns, fontsize=SMALL, handlelength=2.2, columnspacing=1.5, **look)


def _pair(x, curve):
    """Return (x, y) of a curve that may bring its own abscissa."""
    own = len(curve) == 2 and np.ndim(curve[0]) == 1
    return tuple(np.asarray(values, dtype=float) for values in (curve if own else (x, curve)))


def _finite(x, curve):
    """Return (x, y) of a curve without the points that are not finite."""
    x, y = _pair(x, curve)
    good = np.isfinite(x) & np.isfinite(y)
    return x[good], y[good]


def _round_up(value):
    """Return the next larger number of one figure or so, such as 0.15 for 0.13; 1 for 0."""
    power = 10.0 ** math.floor(math.log10(value)) if value > 0 else 1.0
    return next(float(f"{m * power:.3g}") for m in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if m * power >= value)


def _spacing(position):
    """Return the median distance [m] of a particle, (n, 2), from its nearest neighbour; 0 without one."""
    from scipy.spatial import cKDTree  # slow to import, and only particles need it

    some = position[:: 1 + len(position) // 20000]  # a median needs no more
    return float(np.median(cKDTree(position).query(some, k=2)[0][:, 1])) if len(position) > 1 else 0.0


def _arrows(ax, position, vectors, spacing, height, unit):
    """Draw velocities, and their scale at `height` (in panel heights); return the arrows."""
    cell = (spacing or 1.0) * math.ceil(math.sqrt(len(position) / ARROWS))
    chosen = np.arange(len(position))
    if len(position) > ARROWS:
        chosen = np.unique(np.floor((position - position.min(axis=0)) / cell).astype(int), axis=0, return_index=True)[1]
    longest = np.linalg.norm(vectors[chosen], axis=1).max()
    look = {"angles": "xy", "scale_units": "xy", "units": "inches", "width": 0.01, "headwidth": 4, "headlength": 5, "zorder": 4}
    scale = longest / (1.4 * cell) if longest > 0 else 1.0
    arrows = ax.quiver(*position[chosen].T, *vectors[chosen].T, scale=scale, color="black", clip_on=False, **look)
    arrows.set_in_layout(False)  # unclipped, for the arrows at the surface; the layout would take them for far larger
    said = {"transform": ax.transAxes, "ha": "right", "va": "bottom", "fontsize": SMALL}
    ax.text(1, height, f"longest arrow {longest:.2g} {unit}", **said).above = True
    return arrows


def _settle(figure):
    """Fit what is measured in points to the panels: markers without gaps, labels beside points, titles above legends."""
    figure.draw_without_rendering()  # this lays the panels out; before, nobody knows how many points a metre has
    for ax in figure.axes:
        for cloud in ax.collections:
            if hasattr(cloud, "spacing"):
                (x0, _), (x1, _) = ax.transData.transform([(0, 0), (cloud.spacing, 0)])
                cloud.set_sizes([max(0.5, 1.15 * (x1 - x0) * 72 / figure.dpi) ** 2])
        texts = [text for text in ax.texts if hasattr(text, "beside")]
        if texts:
            _spread(ax, texts)
        above = [text for text in ax.texts if hasattr(text, "above")] + ([ax.get_legend()] if ax.get_legend() else [])
        if above and ax.get_title():
            top = max(artist.get_window_extent().y1 for artist in above) - ax.get_window_extent().y1
            look = {"fontsize": ax.title.get_fontsize(), "fontweight": ax.title.get_fontweight(), "color": ax.title.get_color()}
            ax.set_title(ax.get_title(), pad=top * 72 / figure.dpi + 3, **look)  # without its look it would lose it


def _spread(ax, texts):
    """Give each label the first place beside its point where it covers the fewest points and labels."""
    reach = 0.5 * POINT * ax.figure.dpi / 72
    points = ax.transData.transform([text.xy for text in texts])
    taken = [*np.hstack([points - reach, points + reach])]
    panel = ax.get_window_extent().extents

    def put(text, place):
        dx, dy = place
        across, up = ("left", "center", "right")[1 - np.sign(dx)], ("bottom", "center", "top")[1 - np.sign(dy)]
        text.set(position=place, ha=across, va=up)
        return text.get_window_extent().extents + reach / 3 * np.array([-1, -1, 1, 1])

    def cover(box):
        a = np.array(taken)
        outside = (box[:2] < panel[:2]).any() or (box[2:] > panel[2:]).any()
        hits = ((a[:, :2] < box[2:]) & (box[:2] < a[:, 2:])).all(axis=1)
        return hits[: len(points)].sum() + 3 * hits[len(points) :].sum() + 0.5 * outside  # text on text is the worst to read

    for text in texts:
        best = min(PLACES, key=lambda place, text=text: cover(put(text, place)))
        taken.append(put(text, best))
