"""From a scene's keys to what moves its walls: by a law, or by the flow."""

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..wavemakers import Flap, Oscillation, Slide, Together, Yielding, generation
from ..wavemakers.series import ANGLES, measured_motion
from ..waves import Jonswap, PiersonMoskowitz, Solitary, Tabulated, components, dispersion, focused, phase_speed, transfer

LARGEST_ACCELERATION = 1.0  # of a plate that follows a record, over g
START_IN_PERIODS = 2.0  # duration of the smooth start of waves
BAND = 0.5, 2.5  # of irregular waves, over the peak frequency
FOCUS_RETURNS = 3.0  # a focused group comes back no sooner than after so many times the time of its focus


@dataclass(frozen=True)
class Maker:
    """A wavemaker's plate: what moves it, and what it is expected to do.

    Attributes
    ----------
    motion : Slide or Flap
    expected : Elevation, SolitaryElevation or None
        Level of its own waves, None where it is not known.
    added : Yielding or None
        What active absorption adds.
    """

    motion: object
    expected: object = None
    added: object = None


def bed_of(scene):
    """Return the height of the bed [m], the lowest point of the fluid."""
    return scene.level - scene.depth


def place_of(scene):
    """Return where the wavemaker's plate meets the still water, x [m]."""
    name = scene.wavemaker.wall
    if name not in scene.wall_names:
        return 0.0
    points = np.array(scene.lines[scene.wall_names.index(name)].points)
    for (x, z), (x_next, z_next) in itertools.pairwise(points):
        if min(z, z_next) <= scene.level <= max(z, z_next) and z != z_next:
            return float(x + (scene.level - z) / (z_next - z) * (x_next - x))
    return float(points[:, 0].mean())


def hinge_of(scene):
    """Return the height of a flap's hinge [m], None for a piston."""
    maker = scene.wavemaker
    if maker.kind == "piston":
        return None
    return bed_of(scene) if maker.hinge is None else maker.hinge


def relative_hinge(scene):
    """Return the height of a flap's hinge above the bed over the depth, None for a piston."""
    hinge = hinge_of(scene)
    return None if hinge is None else (hinge - bed_of(scene)) / scene.depth


def wave_of(scene, section):
    """Return the linear wave (`Dispersion`) of a section with one of period, frequency and wavelength."""
    return dispersion(scene.depth, scene.domain.gravity, section.period, section.frequency, section.wavelength)


def speed_of_waves(scene, period):
    """Return the phase speed of waves of a period [m/s], that of long waves without one."""
    gravity, depth = scene.domain.gravity, scene.depth
    return phase_speed(period, depth, gravity) if period else math.sqrt(gravity * depth)


def ramp_of(section, period):
    """Return the duration of the smooth start [s]."""
    return START_IN_PERIODS * period if section.ramp is None else section.ramp


def maker_of(scene):
    """Return the `Maker` of a scene, None without; each call makes one of its own, since absorption has a state.

    Raises
    ------
    SceneError
        When a file that it names does not hold a motion.
    """
    maker = scene.wavemaker
    if maker is None:
        return None
    hinge = hinge_of(scene)
    at = None if hinge is None else (place_of(scene), hinge)
    if maker.wave.kind == "oscillation" and maker.wave.angle is not None:
        wave = maker.wave
        swing = Oscillation(math.radians(wave.angle), wave.period, wave.ramp, wave.cycles)
        return Maker(Flap(at, swing))
    signal, expected = _signal(scene)
    if maker.wave.kind == "series" and maker.wave.unit in ANGLES:
        return Maker(Flap(at, signal))
    added = None
    if maker.absorption:
        way = maker.absorption.reach or 0.5 * scene.depth
        added = Yielding((-way, way))
        signal = Together((signal, added))
    motion = Slide(signal) if hinge is None else Flap(at, signal, scene.level - hinge)
    return Maker(motion, expected, added)


def _signal(scene):
    """Return the way of the plate at the still-water level, and the level expected in front of it or None."""
    wave, depth, gravity, hinge = scene.wavemaker.wave, scene.depth, scene.domain.gravity, relative_hinge(scene)
    if wave.kind == "oscillation":
        way = 0.5 * wave.stroke
        signal = Oscillation(way, wave.period, wave.ramp, wave.cycles)
        if wave.cycles is not None:
            return signal, None
        one = np.array([way]), np.array([2 * math.pi / wave.period]), np.zeros(1)
        return signal, generation.expected(*one, depth, gravity, hinge, wave.ramp, scene.time.end)
    if wave.kind == "regular":
        regular = wave_of(scene, wave)
        ramp = ramp_of(wave, regular.period)
        return generation.regular(wave.height, regular, depth, gravity, hinge, wave.order, ramp, scene.time.end)
    if wave.kind == "solitary":
        return generation.solitary(Solitary(wave.height, depth, gravity, wave.theory), wave.start)
    if wave.kind == "series":
        return _recorded(scene), None
    rest = ramp_of(wave, scene.wave_period), scene.time.end, getattr(wave, "duration", None) or math.inf
    return generation.linear(*components_of(scene), depth, gravity, hinge, *rest)


def components_of(scene):
    """Return amplitudes [m], angular frequencies [1/s] and phases [rad] of an irregular or focused wave at the plate."""
    wave = scene.wavemaker.wave
    spectrum, band = spectrum_of(wave), band_of(scene)
    if wave.kind == "irregular":
        found = components(spectrum, *band, wave.seed, jitter=wave.duration is None)
    else:
        found = focused(spectrum, wave.crest, *band, wave.place, wave.time, scene.depth, scene.domain.gravity)
    return found.amplitude, 2 * math.pi * found.frequency, -found.phase


def band_of(scene):
    """Return lowest and highest frequency [Hz] of an irregular or focused wave, and the number of its components."""
    wave = scene.wavemaker.wave
    low, high = BAND[0] / scene.wave_period, BAND[1] / scene.wave_period
    if wave.spectrum == "table":
        low, high = max(low, wave.frequencies[0]), min(high, wave.frequencies[-1])
    if wave.kind == "focused":
        return low, high, math.ceil(FOCUS_RETURNS * wave.time * (high - low))
    duration = wave.duration or scene.time.end
    if not wave.duration:
        return low, high, max(1, math.ceil(duration * (high - low)))
    # in the middle of each step there is then a multiple of 1/duration, and the waves repeat exactly
    low, high = (math.floor(low * duration) + 0.5) / duration, (math.ceil(high * duration) - 0.5) / duration
    return low, high, max(1, round(duration * (high - low)))


def spectrum_of(wave):
    """Return the spectrum of an irregular wave or a focused group, whose height has no meaning."""
    if wave.spectrum == "table":
        table = Tabulated(np.array(wave.frequencies), np.array(wave.densities))
        height = getattr(wave, "height", None)
        return table if height is None else Tabulated(table.frequencies, table.densities * (height / table.height) ** 2)
    height = getattr(wave, "height", 1.0)
    return Jonswap(height, wave.period, wave.gamma) if wave.spectrum == "jonswap" else PiersonMoskowitz(height, wave.period)


def _recorded(scene):
    wave = scene.wavemaker.wave
    limit = LARGEST_ACCELERATION * scene.domain.gravity / (scene.depth if wave.unit in ANGLES else 1.0)
    return _read(wave.file, wave.unit, wave.time_unit, limit, wave.start)


@lru_cache
def _read(*arguments):
    """Return the measured motion; a scene asks for it several times."""
    return measured_motion(*arguments)


def body_motions(scene):
    """Return {wall: Slide}, what moves the walls that the flow moves; each call makes new ones, since they have a state."""
    motions = {}
    for body in scene.bodies:
        direction = np.array(body.direction) / np.linalg.norm(body.direction)
        motions[body.wall] = Slide(Yielding(tuple(body.stops)), tuple(direction.tolist()))
    return motions


def expected_height(scene):
    """Return the height [m] of the regular waves that a wavemaker makes by linear theory, None where it makes no such waves."""
    maker = scene.wavemaker
    if maker is None or not scene.endless_waves or maker.wave.kind == "irregular":
        return None
    if maker.wave.kind == "regular":
        return maker.wave.height
    stroke = maker.wave.stroke
    if stroke is None:
        stroke = 2 * (scene.level - hinge_of(scene)) * math.tan(math.radians(maker.wave.angle))
    kd = dispersion(scene.depth, scene.domain.gravity, period=maker.wave.period).kd
    return stroke * transfer(kd, relative_hinge(scene))


def describe_maker(scene):
    """Return what the wavemaker does, and the source of it."""
    maker = scene.wavemaker
    wave, (least, largest) = maker.wave, maker_of(scene).motion.reach(scene.level)
    plate = "piston" if maker.kind == "piston" else f"flap hinged {hinge_of(scene) - bed_of(scene):g} m above the bed"
    way = f"from {least:.3g} to {largest:.3g} m at the still-water level"
    absorbs = ", absorbs what comes back" if maker.absorption else ""
    sources = {
        "oscillation": "",
        "regular": "Biesel (1951)" + "; second order: Schaeffer (1996)" * (getattr(wave, "order", 1) == 2),
        "irregular": "Biesel (1951), random phases",
        "focused": "Tromans et al. (1991)",
        "solitary": "Goring (1978)",
        "series": "",
    }
    return f"{plate}, {wave.kind}, {way}{absorbs}", sources[wave.kind]
