"""Validation cases against theory: case, metric, value, bar, pass.

Every bar is an upper limit on the absolute value. What a case cost is a row without a bar.
"""

import json
import math
import time

import numpy as np
from rich.table import Table

from .errors import SceneError
from .parallel import Communicator
from .progress import console
from .run import mean_height
from .scene.build import build
from .scene.load import load_scene
from .waves import Seiche, flap_height

CASES = {}


def case(function):
    """Register `function` as the case of its name; it takes `quick` and yields (metric, value, unit, bar)."""
    CASES[function.__name__] = function
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
    yield "bed pressure, RMS error after 2 s", 100 * _rms(bed[late, 1] / weight - 1), "% of rho g H", 0.5
    lowest = simulation.field("position")[:, 1].min() / scene.numerics.dx
    yield "lowest row off dx/2", lowest - 0.5, "dx", 0.05
    yield "kinetic over potential energy at the end", energy[-1, 2] / energy[-1, 3], "", 1e-6


def _rms(values):
    return math.sqrt(np.mean(np.square(values)))


@case
def pool(quick):
    """The pool with its layer, 25 s (quick: 12 s): heights at x = 2 ... 4 m against Biesel's flap, 0.0956 m.

    Growth: the mean height of the last third of the record after start-up over that of its first third, minus 1.
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
                early, late = (t > 6.0) & (t < 6.0 + 2 * period), t > t[-1] - 2 * period
                growth = mean_height(t[late], level[late], period) / mean_height(t[early], level[early], period)
                yield f"growth of height, {x}", 100 * (growth - 1), "%", 5.0
