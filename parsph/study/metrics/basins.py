"""Standing waves in a basin: frequency, loss and velocities against linear theory, Szmidt (2013) eqs. (41), (43)."""

import math

import numpy as np

from ...analysis import oscillation
from ...waves import Seiche
from .base import metric
from .walls import behind

LARGEST_LOSS = 99.0  # [% per period]: what is left of such a wave has no frequency


@metric("frequency-error", "%")
def frequency_error(results, references):
    """Seiche: angular frequency of the particles' velocities, projected on the mode, over that of theory, minus 1."""
    found = oscillation_of(results)
    return 100.0 * (found.frequency / mode_of(results)[0].frequency - 1.0) if found else math.nan


@metric("loss-per-period", "%")
def loss_per_period(results, references):
    """Seiche: what a period takes of the amplitude of the mode."""
    found = oscillation_of(results)
    return 100.0 * found.loss if found else math.nan


@metric("velocity-error", "%")
def velocity_error(results, references):
    """Seiche: L2 norm of the velocity minus that of theory at the same places, over that of theory, in all snapshots."""
    mode = mode_of(results)
    if mode is None:
        return math.nan
    theory, low = mode
    wrong = whole = 0.0
    for number in range(len(results.snapshots)):
        shot = results.snapshot(number)
        exact = theory.velocity(shot["position"][:, :2] - low) * math.cos(theory.frequency * shot["time"])
        wrong += ((shot["velocity"][:, :2] - exact) ** 2).sum()
        whole += (exact**2).sum()
    return 100.0 * math.sqrt(wrong / whole)


@metric("penetrations", "")
def penetrations(results, references):
    """How often a particle behind a wall was exchanged for its image; walls without that: most behind them in a snapshot."""
    exchanged = results.summary.get("walls", {}).get("exchanged")
    if exchanged is not None:
        return float(sum(exchanged.values()))
    return float(behind(results, range(len(results.snapshots))))


@metric("lowest-row", "dx")
def lowest_row(results, references):
    """Median height above the bed, at the end, of the particles that begin in the lowest row."""
    bed = min(block["low"][-1] for block in results.scene["fluid"]["blocks"])
    vertical, dx = len(results.scene["domain"]["size"]) - 1, results.scene["numerics"]["dx"]
    first, last = (results.snapshot(number)["position"][:, vertical] - bed for number in (0, -1))
    return float(np.median(last[first < first.min() + 0.5 * dx]) / dx)


def mode_of(results):
    """Return the `Seiche` that a run begins with and the lower left corner of its basin [m]; None of other runs."""
    block = results.scene["fluid"]["blocks"][0]
    if block["initial"] != "seiche":
        return None
    low = np.array(block["low"])
    return Seiche(*(np.array(block["high"]) - low), block["amplitude"], results.scene["domain"]["gravity"]), low


def amplitudes(results):
    """Return times [s] and amplitudes of the mode, 1 at the beginning, in all snapshots of a seiche."""
    theory, low = mode_of(results)
    shots = [results.snapshot(number) for number in range(len(results.snapshots))]
    shares = [theory.share(shot["position"][:, :2] - low, shot["velocity"][:, :2]) for shot in shots]
    return np.array([shot["time"] for shot in shots]), np.array(shares)


def oscillation_of(results):
    """Return the `Oscillation` of a seiche; None of other runs, and where next to nothing is left after a period."""
    mode = mode_of(results)
    if mode is None:
        return None
    found = oscillation(*amplitudes(results), mode[0].frequency)
    return found if 100.0 * found.loss < LARGEST_LOSS else None
