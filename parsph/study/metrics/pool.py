"""Waves: what becomes of them, what comes back, what they do to a wall, and how far a run is from one without an end."""

import math

import numpy as np

from ... import analysis
from ...errors import SceneError
from ...scene.load import load_scene
from ...waves import regular_wave, solitary_on_wall
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


@metric("wave-error", "%", needs="waves")
def wave_error(results, references):
    """Regular waves: first harmonics along the tank off those of the steady wave asked for, RMS in its own, last four periods.

    Height and wavelength count, the phase of the whole does not. Gauges are two depths from wavemaker and layer, and more.
    """
    scene = load_scene(results.scene)
    asked = scene.wavemaker and scene.wavemaker.wave
    if not asked or asked.kind != "regular":
        return math.nan
    wave = regular_wave(asked.height, scene.depth, scene.domain.gravity, period=scene.wave_period)
    t, levels, x, _ = results.levels()
    layers = [results.layer(zone)[0] for zone in results.scene["damping"] if zone["side"] == "right"]
    first, last = FAR * scene.depth, min([scene.domain.size[0], *layers]) - FAR * scene.depth
    far = (x >= first) & (x <= last)
    found = analysis.harmonics_along(t, levels[far], x[far], wave.period, periods=PERIODS)[:, 0]
    found *= np.exp(1j * wave.wavenumber * x[far]) / wave.elevations[0]  # a steady wave: the same number everywhere
    return 100.0 * math.sqrt(np.mean(np.abs(found - np.exp(1j * np.angle(found.sum()))) ** 2))


@metric("runup-error", "%", needs="runup")
def runup_error(results, references):
    """Solitary wave: largest run-up on a vertical wall over that of potential flow (`waves.solitary_on_wall`), minus 1."""
    scene = load_scene(results.scene)
    wave = scene.wavemaker and scene.wavemaker.wave
    if not wave or wave.kind != "solitary":
        return math.nan
    record = results.table(next(iter(results.gauges("runup"))))
    theory = solitary_on_wall(wave.height / scene.depth).runup * scene.depth
    return 100.0 * ((record["run-up z [m]"].max() - scene.level) / theory - 1.0)


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
