"""Waves and their absorption: what comes back, and how far a run is from one without an end."""

import numpy as np

from ... import analysis
from ...errors import SceneError
from ...scene.load import load_scene
from .base import FAR, PERIODS, energy_record, metric

START_UP = 4  # periods before waves are compared: front, layer and back again


@metric("reflection", "-", needs="waves")
def reflection(results, references):
    """Reflected over incident amplitude, last four periods, gauges two depths from the wavemaker and more (Mansard & Funke)."""
    return separated(results).coefficient


@metric("incident", "m", needs="waves")
def incident(results, references):
    """Incident amplitude, last four periods, gauges two depths from the wavemaker and more."""
    return separated(results).incident


def separated(results):
    """Return the `Separation` of a run, over its last four periods, from the gauges that are far from the wavemaker."""
    t, levels, x, _ = results.levels()
    depth, gravity = results.depth, results.scene["domain"]["gravity"]
    period = load_scene(results.scene).wave_period
    far = x >= FAR * depth
    return analysis.reflection(t, levels[far], x[far], period, depth, gravity, periods=PERIODS)


@metric("level-difference", "-", roles=("infinite",), needs="levels")
def level_difference(results, references):
    """L2 difference of all levels from the infinite run, over the L2 norm of its waves."""
    t, mine, _, _ = results.levels()
    times, theirs, _, _ = references["infinite"].levels()
    _same_times(t, times)
    return analysis.level_difference(t, mine, theirs)


def _same_times(mine, theirs):
    if not np.array_equal(mine, theirs):
        raise SceneError("the two runs have different times", where="gauges", cure="the same `every` and time.end for both")


@metric("energy-difference", "-", roles=("infinite",), needs="energy")
def energy_difference(results, references):
    """RMS difference of the kinetic energy from the infinite run after start-up, over its mean there."""
    difference, scale = _energies(results, references["infinite"])
    return float(np.sqrt(np.mean(difference**2)) / scale)


@metric("energy-excess", "-", roles=("infinite",), needs="energy")
def energy_excess(results, references):
    """Largest difference of the kinetic energy from the infinite run after start-up, over its mean there."""
    difference, scale = _energies(results, references["infinite"])
    return float(np.abs(difference).max() / scale)


def _energies(results, reference):
    """Return (difference of kinetic energies after start-up [J], mean of the reference [J]); impulses: the whole run, peak."""
    name = next(iter(results.gauges("energy")))
    mine, theirs = results.table(name), reference.table(name)
    t, energy = theirs["time [s]"], theirs["kinetic energy [J]"]
    _same_times(mine["time [s]"], t)
    difference = mine["kinetic energy [J]"] - energy
    scene = load_scene(results.scene)
    if not scene.endless_waves:
        return difference, energy.max()
    late = t > START_UP * scene.wave_period
    return difference[late], energy[late].mean()


@metric("residual-energy", "-", needs="energy")
def residual_energy(results, references):
    """Kinetic energy at the end over its largest: what a single wave leaves behind."""
    energy = energy_record(results)["kinetic energy [J]"]
    return float(energy[-1] / energy.max())


@metric("reflection-ratio", "-", roles=("infinite", "reflecting"), needs="profile")
def reflection_ratio(results, references):
    """Reflection ratio of shallow water, Molteni et al. eqs. (2.7), (2.8), at the end, over the reflecting run's basin."""
    window = 0.0, references["reflecting"].scene["domain"]["size"][0]
    runs = [run.profile() for run in (results, references["reflecting"], references["infinite"])]
    return analysis.reflection_ratio(*runs, results.scene["domain"]["gravity"], window)
