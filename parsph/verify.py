"""Validation cases against theory: case, metric, value, bar, pass.

Every bar is an upper limit on the absolute value. What a case cost is a row without a bar.
"""

import itertools
import json
import math
import time

import numpy as np
from rich.table import Table

from .analysis import mean_height, reflection, reflection_ratio
from .errors import SceneError
from .io.gauges import pressures_at
from .kernels import KERNELS
from .measured import measured
from .parallel import Communicator
from .progress import console
from .scene.build import build
from .scene.load import load_scene
from .scene.solids import boundaries_of
from .study.metrics import arrival, plateau_of, rms
from .walls import INTERPOLATORS
from .walls.interpolation import HYDROSTATIC, room_for, shape_functions
from .waves import DamBreak, Seiche, flap_height, layer_reflection

CASES = {}


def case(function):
    """Register `function` as the case of its name; it takes `quick` and yields (metric, value, unit, bar)."""
    CASES[function.__name__.replace("_", "-")] = function
    return function


def verify(cases=None, quick=False, json_file=None):
    """Run validation cases and print their results.

    Parameters
    ----------
    cases : list of str, optional
        Names; default: all.
    quick : bool
        Shorter runs.
    json_file : Path, optional
        Where to write the rows: objects with the keys case, metric, value, unit, bar, pass.

    Returns
    -------
    bool
        Whether every bar was met.

    Raises
    ------
    SceneError
        When there is no case of a name.
    """
    for name in cases or []:
        if name not in CASES:
            raise SceneError(f"no case {name!r}", where="verify", cure=f"one of {', '.join(CASES)}")
    rows = []
    for name in cases or CASES:
        begin = time.process_time()
        for metric, value, unit, bar in CASES[name](quick):
            rows.append(_row(name, metric, value, unit, bar))
        rows.append(_row(name, "cost", time.process_time() - begin, "CPU s", None))
        console().print(_table([row for row in rows if row["case"] == name]))
    if json_file:
        json_file.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return all(row["pass"] for row in rows)


def _row(name, metric, value, unit, bar):
    met = bar is None or abs(value) <= bar
    return {"case": name, "metric": metric, "value": float(value), "unit": unit, "bar": bar, "pass": bool(met)}


def _table(rows):
    table = Table("case", "metric", "value", "unit", "bar", "pass")
    for row in rows:
        bar = "" if row["bar"] is None else f"<= {row['bar']:g}"
        verdict = "" if row["bar"] is None else ("yes" if row["pass"] else "[bold red]NO")
        table.add_row(row["case"], row["metric"], f"{row['value']:.4g}", row["unit"], bar, verdict)
    return table


@case
def seiche(quick):
    """Standing wave of 0.2 m x 0.2 m, A = 5 mm, 5 periods (quick: 20 per depth alone), against linear theory, Szmidt eq. (41).

    The amplitude is the projection of the particles' velocities on the mode of eq. (43), fitted by A exp(-b t) cos(w t + p).
    """
    from scipy.optimize import curve_fit

    for per_depth, frequency_bar, loss_bar in ((20, 0.6, 1.5), (40, 0.2, 1.0)):
        scene = load_scene("seiche", {"numerics.dx": 0.2 / per_depth, "gauges": []})
        theory = Seiche(0.2, 0.2, scene.fluid.blocks[0].amplitude, scene.domain.gravity)
        period = 2 * math.pi / theory.frequency
        times, amplitudes, outside = _amplitudes(scene, theory, 5 * period)

        def damped(t, a, b, w, phase):
            return a * np.exp(-b * t) * np.cos(w * t + phase)

        fit, _ = curve_fit(damped, times, amplitudes, p0=(1.0, 0.02 / period, theory.frequency, 0.0))
        size = f"{per_depth} per depth"
        yield f"frequency error, {size}", 100 * (fit[2] / theory.frequency - 1), "%", frequency_bar
        yield f"amplitude loss per period, {size}", 100 * (1 - math.exp(-fit[1] * period)), "%", loss_bar
        yield f"particles behind a wall, {size}", outside, "", 0.0
        if quick:
            return


def _amplitudes(scene, theory, end):
    """Run a seiche up to `end` [s].

    Returns
    -------
    tuple of (ndarray, ndarray, int)
        Times [s], amplitudes of the mode in units of the initial one, largest number of particles seen behind a wall.
    """
    simulation = build(scene, Communicator())
    simulation.end = end
    simulation.prepare()
    times, amplitudes, outside = [], [], 0
    while simulation.time < end:
        simulation.advance()
        if simulation.steps % 10 == 0:
            position = simulation.field("position")
            outside = max(outside, int(((position < 0) | (position > [theory.length, np.inf])).any(axis=1).sum()))
            mode = theory.velocity(position)
            times.append(simulation.time)
            amplitudes.append((simulation.field("velocity") * mode).sum() / (mode**2).sum())
    return np.array(times), np.array(amplitudes), outside


@case
def still(quick):
    """Still water, 0.6 m x 0.3 m, 10 s (quick: 3 s): nothing may move, the bed must feel rho g H."""
    scene = load_scene("still", {"time.end": 3.0 if quick else 10.0})
    simulation = build(scene, Communicator())
    simulation.run()
    bed, energy = (gauge.record() for gauge in simulation.observers)
    weight = scene.fluid.rho0 * scene.domain.gravity * scene.depth
    late = bed[:, 0] > 2.0
    yield "bed pressure, RMS error after 2 s", 100 * rms(bed[late, 1] / weight - 1), "% of rho g H", 0.5
    lowest = simulation.field("position")[:, 1].min() / scene.numerics.dx
    yield "lowest row off dx/2", lowest - 0.5, "dx", 0.05
    yield "kinetic over potential energy at the end", energy[-1, 2] / energy[-1, 3], "", 1e-6


@case
def pool_height(quick):
    """The pool with its layer, 25 s (quick: 12 s): heights at x = 2 ... 4 m against Biesel's flap, 0.0956 m.

    Growth: the mean height of the last two periods over that of the first two after start-up, minus 1.
    """
    scene = load_scene("pool", {"time.end": 12.0 if quick else 25.0})
    simulation = build(scene, Communicator())
    simulation.run()
    maker = scene.wavemaker
    period = maker.period
    theory = flap_height(math.radians(maker.amplitude), period, scene.depth, scene.domain.gravity)
    for gauge in simulation.observers:
        if gauge.columns == ("level [m]",) and 2 <= gauge.place[0] <= 4:
            t, level = gauge.record().T
            height = mean_height(t[t > 6.0], level[t > 6.0], period)
            x = f"x = {gauge.place[0]:g} m"
            yield f"wave height error, {x}", 100 * (height / theory - 1), "%", 5.0
            if not quick:
                early = (t > 6.0) & (t < 6.0 + 2.05 * period)  # two whole periods, samples to spare
                growth = mean_height(t, level, period, 2) / mean_height(t[early], level[early], period)
                yield f"growth of height, {x}", 100 * (growth - 1), "%", 5.0


@case
def pool_absorption(quick):
    """The pool with layers of half and of one wavelength (quick: 14 s, twice the spacing): what comes back, Mansard & Funke.

    Kinetic energy of the pool against the infinite one after start-up (4 periods), and its growth in the reflecting one.
    """
    places = (2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0)
    gauges = [{"kind": "level", "x": x} for x in places]
    gauges.append({"kind": "energy", "low": [-1.0, -1.0], "high": [6.061, 10.0], "every": 0.02})
    common = {"gauges": gauges, **({"numerics.dx": 0.1, "time.end": 14.0} if quick else {})}
    half = 6.061 + 3.0305
    shorter = {
        "domain.size": [half, 1.5],
        "fluid.blocks": [{"low": [0.0, 0.0], "high": [half, 1.0]}],
        "damping.0.length": 3.0305,
    }
    energies = {}
    for name, source, overrides, bar in (
        ("half a wavelength", "pool", shorter, 5.0),
        ("one wavelength", "pool", {}, 2.0),
        ("infinite", "pool-infinite", {}, None),
        ("reflecting", "pool-reflecting", {}, None),
    ):
        scene = load_scene(source, {**common, **overrides})
        simulation = build(scene, Communicator())
        simulation.run()
        *levels, energy = (gauge.record() for gauge in simulation.observers)
        period, t = scene.wavemaker.period, levels[0][:, 0]
        energies[name] = energy[energy[:, 0] > 4 * period]
        records = np.array([level[:, 1] for level in levels])
        found = reflection(t, records, places, period, scene.depth, scene.domain.gravity, periods=4)
        yield f"reflection coefficient, {name}", 100 * found.coefficient, "%", bar
    far = energies["infinite"][:, 2]
    for name in ("half a wavelength", "one wavelength"):
        off = np.abs(energies[name][:, 2] - far).max() / far.mean()
        yield f"kinetic energy off the infinite pool, largest, {name}", 100 * off, "%", 3.0 if name.startswith("one") else None
    resonant, count = energies["reflecting"][:, 2], round(period / 0.02)
    yield "resonance: kinetic energy, first over last period", resonant[:count].mean() / resonant[-count:].mean(), "", 0.8


@case
def swe_pulse(quick):
    """A hump on shallow water and hyperbolic layers of 10 to 200 m: reflection ratio, Molteni et al. eq. (2.7), over theory."""
    runs = {name: _profile(f"swe-pulse-{name}", {}) for name in ("infinite", "reflecting")}
    ratios = {}
    for length in (20, 50) if quick else (10, 20, 50, 100, 200):
        far = 500.0 + length
        overrides = {"domain.size": [far], "fluid.blocks.0.high": [far], "damping.0.length": float(length)}
        scene, line = _profile("swe-pulse", overrides)
        window = 0.0, runs["reflecting"][0].domain.size[0]
        gravity = scene.domain.gravity
        ratios[length] = reflection_ratio(line, runs["reflecting"][1], runs["infinite"][1], gravity, window)
        zone = scene.damping[0]
        theory = layer_reflection(scene.c0 / length, length, scene.c0, zone.profile, softening=zone.softening)
        yield f"reflection ratio, L = {length} m", ratios[length], "", None
        bar = 1.5 if length in (20, 50) else None
        yield (
            f"factor off theory ({theory:.2e}), L = {length} m",
            max(ratios[length] / theory, theory / ratios[length]),
            "",
            bar,
        )
    values = list(ratios.values())
    yield "monotone in L: largest ratio to the next shorter layer", max(b / a for a, b in itertools.pairwise(values)), "", 1.0


def _profile(source, overrides):
    """Run a 1D scene; return it and its last state as {field: array}."""
    scene = load_scene(source, overrides)
    simulation = build(scene, Communicator())
    simulation.run()
    fields = {name: simulation.field(name) for name in ("id", "position", "velocity", "density", "mass")}
    return scene, {name: values[:, 0] if values.ndim == 2 else values for name, values in fields.items()}


@case
def swe_dam_break(quick):
    """Dams of 1 m break over wet (r = 0.5, 0.1) and dry ground, 1000 (dry: 500) particles, against Stoker and Ritter.

    L1: sum of |h - exact| over sum of exact, on the interval that the waves have reached. The bore is where the depth falls
    through the mean of its two sides.
    """
    for right in (0.5, 0.1, 0.0):
        if right:
            overrides = {"fluid.blocks.1.depth": right}
        scene, line = _profile("swe-dam-break", overrides) if right else _profile("swe-dam-break-dry", {})
        exact = DamBreak(1.0, right, scene.domain.gravity)
        order, t = np.argsort(line["position"]), scene.time.end
        x, depth = line["position"][order] - 500.0, line["density"][order]
        place = np.linspace(-1.1 * scene.c0, 1.1 * exact.bore, 2001) * t
        place = place[np.abs(place) < 500.0]
        truth = exact.depth(place, t)
        error = np.abs(np.interp(place, x, depth, right=0.0) - truth).sum() / truth.sum()
        ground = f"r = {right:g}" if right else "dry"
        yield f"depth, L1 error, {ground}", 100 * error, "%", 1.0
        if right:
            middle = 0.5 * (right + exact.depth(np.array([0.999 * exact.bore * t]), t)[0])
            last = np.flatnonzero((depth[:-1] > middle) & (depth[1:] <= middle))[-1]
            front = np.interp(-middle, -depth[last : last + 2], x[last : last + 2])
            yield f"bore, place, {ground}", 100 * (front / (exact.bore * t) - 1), "%", 1.0


@case
def interpolators(quick):
    """Interpolation half a spacing in front of a bed, from jittered particles above it, of known fields.

    Lengths in dx, pressures in rho g dx, Wendland C2, h/dx = 1.33. Linear: a hydrostatic field, jitter 0.1; quadratic: with
    0.1 (x^2 + x y - y^2) on top, jitter 0.3. Errors expected of normalised and Shepard are those of Huang et al.'s forms.
    """
    expected = {"normalised": -0.300, "shepard": -0.035}
    for name, method in INTERPOLATORS.items():
        linear = _operator_errors(method.code, 0.1, lambda x, y: -y)
        curved = _operator_errors(method.code, 0.3, lambda x, y: -y + 0.1 * (x * x + x * y - y * y))
        exact = name not in expected
        yield f"linear field, RMS error, {name}", rms(linear), "rho g dx", 1e-10 if exact else None
        if not exact:
            yield f"linear field, mean error off {expected[name]}, {name}", linear.mean() - expected[name], "rho g dx", 0.03
        yield f"quadratic field, RMS error, {name}", rms(curved), "rho g dx", 1e-10 if name == "mls2" else None


def _operator_errors(method, jitter, field, count=400):
    """Return the errors of an interpolator at points half a spacing above the bed y = 0, shape (count,), lengths in dx."""
    kernel, h, generator = KERNELS["wendland-c2"], 1.33, np.random.default_rng(2)
    reach, errors = kernel.support * h, []
    lattice = np.stack(np.meshgrid(np.arange(-4, 5) + 0.5, np.arange(6) + 0.5, indexing="ij"), axis=-1).reshape(-1, 2)
    for _ in range(count):
        particles = lattice + generator.uniform(-jitter, jitter, lattice.shape)
        point = np.array([generator.uniform(-0.5, 0.5), 0.5])
        apart = particles - point
        distance = np.linalg.norm(apart, axis=1)
        near = np.flatnonzero(distance < reach)
        weights = kernel.value(distance[near], h, 2)
        shapes = np.empty(len(near))
        over_reach = np.ascontiguousarray(apart[near].T) / reach
        work = room_for(2, len(near))
        shape_functions(method, kernel.code, over_reach, weights, len(near), kernel.support, work, shapes)
        values = field(*particles[near].T)
        if method == HYDROSTATIC:  # what it takes off and puts back is the hydrostatic difference
            values = values + apart[near, 1]
        errors.append(shapes @ values - field(*point))
    return np.array(errors)


def _behind_walls(scene, simulation):
    """Return how many fluid particles are deeper in a wall that stands still than a hundredth of a spacing."""
    from .geometry import contains

    position, count = simulation.field("position"), 0
    for boundary, motion in boundaries_of(scene):
        if motion is None:
            count += int(contains(boundary.solid.buffer(-0.01 * scene.numerics.dx), position).sum())
    return count


@case
def still_tank(quick):
    """Still water between fixed ghosts, 35 s (quick: 7 s), probes on the left wall, Huang et al. section 4.1."""
    scene = load_scene("still-tank", {"time.end": 7.0 if quick else 35.0})
    simulation = build(scene, Communicator())
    simulation.run()
    weight = scene.fluid.rho0 * scene.domain.gravity
    for gauge in simulation.observers:
        if gauge.columns == ("pressure [Pa]",):
            t, pressure = gauge.record().T
            depth = scene.level - gauge.points[0, 1]
            error = (pressure[t > 5] / weight - depth) / scene.depth
            yield f"pressure at {gauge.name}, RMS error after 5 s", 100 * rms(error), "% of rho g H", 0.5
        elif "kinetic energy [J]" in gauge.columns:
            energy = gauge.record()
            yield "kinetic over potential energy at the end", energy[-1, 2] / energy[-1, 3], "", 1e-6
    yield "particles behind a wall at the end", _behind_walls(scene, simulation), "", 0.0
    yield "ghosts' share of the time", 100 * _share(simulation), "%", None


def _share(simulation):
    """Return the share of the steps' time that the ghosts took."""
    seconds = simulation.timers.seconds
    return seconds["ghosts"] / (sum(seconds.values()) - seconds.get("gauges", 0.0))


@case
def dam_break(quick):
    """The dam break with 12,000 particles to 2.5 s (quick: 3,000 to 1.5 s): impact, energy; and the surge of a column 2:1 high.

    Plateau of P1: mean from 0.2 to 0.7 s after arrival (0.2 rho g H), against Buchner's record in the same window.
    Front: against Martin & Moyce (a = 2.25 in), whose gate takes time, after aligning by the median lag; it ends at the wall.
    """
    coarse = {"numerics.dx": 0.0156, "time.end": 1.5} if quick else {}
    scene = load_scene("dam-break-small", coarse)
    simulation = build(scene, Communicator())
    simulation.run()
    gravity, height = scene.domain.gravity, scene.depth
    pressure, _, energy = (gauge.record() for gauge in simulation.observers)
    unit = math.sqrt(height / gravity)
    record, level = np.stack(list(measured("buchner_p1").values())), scene.fluid.rho0 * gravity * height
    runs = (pressure[:, 0], pressure[:, 1] / level), (record[0] * unit, record[1])
    arrivals = [arrival(*run) for run in runs]
    plateaus = [plateau_of(*run, arrived) for run, arrived in zip(runs, arrivals, strict=True)]
    yield "impact: plateau of P1 off Buchner's", 100 * (plateaus[0] / plateaus[1] - 1), "%", 10.0
    yield "impact: arrival after Buchner's", (arrivals[0] - arrivals[1]) / unit, "sqrt(H/g)", None
    total = energy[:, 2:5].sum(axis=1) / energy[0, 3]
    yield "energy: largest rise between samples, over the initial potential energy", max(np.diff(total).max(), 0.0), "", 1e-4
    yield "energy: lost by the end, over the same", 1 - total[-1], "", None
    yield "particles behind a wall at the end", _behind_walls(scene, simulation), "", 0.0
    yield "ghosts' share of the time", 100 * _share(simulation), "%", 10.0
    raw, aligned, lag = _front_errors(coarse)
    yield "front: RMS off Martin & Moyce, aligned", 100 * rms(aligned), "%", 5.0
    yield "front: lag of Martin & Moyce's", lag, "sqrt(a/2g)", None
    yield "front: RMS off Martin & Moyce, as it is", 100 * rms(raw), "%", None


def _front_errors(overrides):
    """Return relative errors of the front of a column 2:1 high, as it is and aligned in time, and the lag of the data.

    The front is the foremost stretch of 2 dx with four particles: drops ahead of it do not count.
    """
    base = 0.3
    blocks = [{"low": [0.0, 0.0], "high": [base, 2 * base]}]
    scene = load_scene("dam-break-small", {**overrides, "gauges": [], "fluid.blocks": blocks, "time.end": 1.0})
    simulation = build(scene, Communicator())
    simulation.prepare()
    wide, times, fronts = 2 * scene.numerics.dx, [], [0.0]
    while fronts[-1] < scene.domain.size[0] - 2 * wide and simulation.time < scene.time.end:
        simulation.advance()
        if simulation.steps % 20 == 0:
            stretches = np.bincount((simulation.field("position")[:, 0] / wide).astype(int))
            times.append(simulation.time)
            fronts.append((np.flatnonzero(stretches >= 4)[-1] + 1) * wide)
    time, front = np.array(times) * math.sqrt(2 * scene.domain.gravity / base), np.array(fronts[1:]) / base
    data_time, data_front = measured("martin_moyce_n2_2_a2.25in").values()
    inside = data_front < front[-1]
    lag = float(np.median(data_time[inside] - np.interp(data_front[inside], front, time)))

    def errors(shift):
        seen = inside & (data_time - shift < time[-1])
        return np.interp(data_time[seen] - shift, time, front) / data_front[seen] - 1

    return errors(0.0), errors(lag), lag


@case
def wedge_tank(quick):
    """Still water over a notch of 30 degrees and a box, 20 s (quick: 3 s): pressure along bed and box at the end.

    Against rho g depth at each place, one spacing and more from corners; the walls at the sides are left out.
    """
    scene = load_scene("wedge-tank", {"time.end": 3.0 if quick else 20.0})
    simulation = build(scene, Communicator())
    simulation.run()
    boundary = boundaries_of(scene)[0][0]
    vertices = np.array([point for wall in scene.walls.polygons for point in wall.points])
    for number, name in enumerate(scene.wall_names):
        points, _, _ = boundary.elements(number)
        corner = np.linalg.norm(points[:, None] - vertices, axis=2).min(axis=1)
        points = points[(corner > scene.numerics.dx) & (points[:, 0] > 0) & (points[:, 0] < scene.domain.size[0])]
        depth = scene.level - points[:, 1]
        off = pressures_at(simulation, points) / (scene.fluid.rho0 * scene.domain.gravity * depth) - 1
        yield f"pressure along the {name}, largest error", 100 * np.abs(off).max(), "%", 2.0
        yield f"pressure along the {name}, RMS error", 100 * rms(off), "%", None
    energy = next(gauge.record() for gauge in simulation.observers if "kinetic energy [J]" in gauge.columns)
    yield "kinetic over potential energy at the end", energy[-1, 2] / energy[-1, 3], "", None
    yield "particles behind a wall at the end", _behind_walls(scene, simulation), "", 0.0
