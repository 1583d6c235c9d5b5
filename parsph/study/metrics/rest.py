"""Water at rest, and what it does to a wall that it hits."""

import math

import numpy as np

from ...measured import measured
from ...scene.schema import Scene
from .base import energy_record, largest, metric, rms, total_energy

EARLY, SETTLED = 1.0, 5.0  # [s]: the start of still water ends, and its echoes have died away
ARRIVED = 0.2  # of rho0 g H: the front of a dam break is there; Buchner's record has noise of 0.16 before it
PLATEAU = 0.2, 0.7  # [s] after its arrival, up to where the water falls back


@metric("probe-error", "%", needs="pressures")
def probe_error(results, references):
    """Still water: RMS error of all pressure gauges in it, over rho0 g H, after 5 s (half of a run under 10 s)."""
    return rms(_joined(probe_errors(results)))


@metric("probe-error-early", "%", needs="pressures")
def probe_error_early(results, references):
    """Still water: RMS error of all pressure gauges in it, over rho0 g H, in the first second."""
    return rms(_joined(probe_errors(results, early=True)))


@metric("probe-error-largest", "%", needs="pressures")
def probe_error_largest(results, references):
    """Still water: largest error of any pressure gauge in it, over rho0 g H, at the times of probe-error."""
    return largest(_joined(probe_errors(results)))


def probes(results):
    """Return the records of the pressure gauges that stand in the water at the beginning.

    Returns
    -------
    dict of str to tuple
        Gauge to (t [s], p, p of water at rest), pressures over rho0 g H: arrays of shape (samples,), and a float.
    """
    found, blocks = {}, results.scene["fluid"]["blocks"]
    for name, gauge in results.gauges("pressure").items():
        point = gauge["point"]
        corners = (zip(block["low"], point, block["high"], strict=True) for block in blocks)
        if any(all(low <= x <= high for low, x, high in corner) for corner in corners):
            found[name] = *_pressure_record(results, name), (results.level - point[-1]) / results.depth
    return found


def _pressure_record(results, name):
    """Return (t [s], p over rho0 g H) of a pressure gauge."""
    scene, table = results.scene, results.table(name)
    scale = scene["fluid"]["rho0"] * scene["domain"]["gravity"] * results.depth
    return table["time [s]"], table["pressure [Pa]"] / scale


def probe_errors(results, early=False):
    """Return {gauge: errors [% of rho0 g H]} of `probes`: once the water has settled, or in the first second."""
    settled = min(SETTLED, 0.5 * results.scene["time"]["end"])
    begin, end = (0.0, EARLY) if early else (settled, math.inf)
    return {name: 100.0 * (p - exact)[(t >= begin) & (t <= end)] for name, (t, p, exact) in probes(results).items()}


def _joined(errors):
    return np.concatenate([np.zeros(0), *errors.values()])


@metric("rest-energy", "-", needs="energy")
def rest_energy(results, references):
    """Kinetic over potential energy (from height 0) at the end."""
    record = energy_record(results)
    return float(record["kinetic energy [J]"][-1] / record["potential energy [J]"][-1])


@metric("rest-speed", "-", needs="energy")
def rest_speed(results, references):
    """RMS velocity at the end over the sound speed, of a fluid that should be at rest."""
    record, scene = energy_record(results), Scene.model_validate(results.scene)
    return math.sqrt(2.0 * record["kinetic energy [J]"][-1] / record["mass [kg]"][-1]) / scene.c0


@metric("energy-growth", "-", needs="energy")
def energy_growth(results, references):
    """Largest rise of kinetic, potential and compressible energy together, over the potential energy at the beginning."""
    total, potential = total_energy(results), energy_record(results)["potential energy [J]"]
    return float((total - np.minimum.accumulate(total)).max() / potential[0])


@metric("plateau", "-", needs="pressures")
def plateau(results, references):
    """Dam break: mean of p/(rho0 g H) at the gauge P1, which begins dry, from 0.2 to 0.7 s after its arrival there."""
    record = impact(results)
    return math.nan if record is None else plateau_of(*record, arrival(*record))


@metric("plateau-error", "%", needs="pressures")
def plateau_error(results, references):
    """Dam break: the plateau over that of Buchner's record, scaled to the depth, minus 1."""
    t, pressure = buchner(results)
    return 100.0 * (plateau(results, references) / plateau_of(t, pressure, arrival(t, pressure)) - 1.0)


def buchner(results):
    """Return the measured record as (t [s], p / (rho g H)), for the depth of a run."""
    record = measured("buchner_p1")
    return record["t_star"] * math.sqrt(results.depth / results.scene["domain"]["gravity"]), record["p_star"]


def impact(results):
    """Return (t [s], p over rho0 g H) of the gauge P1, None where there is none or it begins in the water."""
    if "P1" not in results.gauges("pressure") or "P1" in probes(results):
        return None
    return _pressure_record(results, "P1")


def arrival(t, pressure):
    """Return when a front arrives [s]: when pressure/(rho0 g H) first exceeds 0.2; NaN where it never does."""
    there = pressure > ARRIVED
    return float(t[there][0]) if there.any() else math.nan


def plateau_of(t, pressure, arrived):
    """Return the mean of a pressure over time from 0.2 to 0.7 s after `arrived`, or to its end; NaN where there is none."""
    inside = (t >= arrived + PLATEAU[0]) & (t <= arrived + PLATEAU[1])
    return float(np.average(pressure[inside], weights=np.gradient(t)[inside])) if inside.any() else math.nan
