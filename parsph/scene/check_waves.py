"""The physics of what makes waves and of what they move: whether a wave can be, and whether plate and tank can do it."""

import math

import numpy as np

from ..errors import SceneError, did_you_mean
from ..wavemakers.series import ANGLES
from ..wavemakers.signals import LOOKS
from ..waves import HIGHEST_SOLITARY, MADSEN, breaking_height, dispersion
from .limits import size_doubts
from .movers import band_of, bed_of, hinge_of, maker_of, place_of, spectrum_of, wave_of
from .schema import SIDES
from .stability import stability_doubts

MOST_PERIODS = 1e9  # of waves in a run
MOST_SUMMED = 3e8  # values of components of irregular waves: some seconds
LONGEST_STROKE = 0.25  # of the free length of water
LEAST_RESOLVED = 1.5  # particles per wave height
STILL_H_OVER_DX = 2.5  # largest with which the surface of still water has been seen to stay still, renormalised
ORDERED = 140.0  # sqrt(depth/g), 40 periods of the seiche: so long water was seen to keep its volume, renormalised
HIGHEST_OF_MANY = 1.86  # highest of a thousand irregular waves over Hs, Rayleigh (Longuet-Higgins 1952)


def maker_faults(scene):
    """Return what is wrong with the wavemaker, a list of SceneError."""
    maker = scene.wavemaker
    if maker is None:
        return []
    lacking = no_waves(
        scene, "wavemaker", "a wavemaker", "there is no bed to hinge it at", "has no water to move", "wavemaker.kind"
    )
    faults = lacking or _plate(scene) or _wave(scene)
    if faults:
        return faults
    try:
        plate = maker_of(scene)
    except SceneError as error:
        where = f"wavemaker.wave.{error.where}" if maker.wave.kind != "series" else f"wavemaker.wave.file: {error.where}"
        return [SceneError(error.what, where=where, why=error.why, cure=error.cure)]
    return _absorption(scene, plate) + _stroke(scene, plate)


def no_waves(scene, where, name, periodic, dry, in_1d=None):
    """Return the fault of a scene that can have no surface waves, in a list.

    Parameters
    ----------
    scene : Scene
    where, name : str
        The key of what needs waves, and what it is.
    periodic, dry : str
        What is wrong where the vertical is periodic, and where there is no depth under gravity.
    in_1d : str, optional
        The key in one dimension; default: `where`.
    """
    if scene.dim == 1:
        cure = "leave it out, or domain.size = [x, up]"
        return [SceneError(f"{name} needs two dimensions", where=in_1d or where, cure=cure)]
    if scene.endless_vertical:
        return [SceneError(periodic, where=where, why="the vertical is periodic", cure="leave it out")]
    if scene.domain.gravity == 0 or scene.depth <= 0:
        why = "waves need depth under gravity"
        return [SceneError(dry, where=where, why=why, cure="domain.gravity > 0, and fluid")]
    return []


def doubts_of(scene):
    """Return what is no fault, and may still not be what is wanted: lines of text, each with the valid range."""
    doubts, wave = size_doubts(scene) + stability_doubts(scene), scene.wavemaker.wave if scene.wavemaker else None
    height = getattr(wave, "height", None) or getattr(wave, "crest", None)
    if height and height < LEAST_RESOLVED * scene.numerics.dx:
        least = height / LEAST_RESOLVED
        doubts.append(
            f"wavemaker.wave: waves of {height:g} m are {height / scene.numerics.dx:.2g} particles high and lose height along "
            f"the tank; numerics.dx of at most {least:.2g} m"
        )
    if wave is not None and wave.kind == "regular":
        linear = wave_of(scene, wave)
        limit = MADSEN * scene.depth**3 / linear.wavelength**2
        if wave.height > limit:
            doubts.append(
                f"wavemaker.wave.height: {wave.height:g} m is more than second-order theory describes in waves of "
                f"{linear.wavelength:.3g} m on {scene.depth:g} m of water (a second crest would stand in their troughs); "
                f"at most {limit:.3g} m, or a relaxation zone, whose stream-function waves go further"
            )
    n = scene.numerics
    if n.density == "renormalised":
        if n.kernel == "wendland-c2" and n.h_over_dx > STILL_H_OVER_DX:
            doubts.append(
                f'numerics.h_over_dx: {n.h_over_dx:g} with density = "renormalised" stirs the surface of still water within '
                f"some 20 s; at most {STILL_H_OVER_DX:g}"
            )
        if scene.lines and scene.domain.gravity > 0:
            doubts.append(
                'numerics.density: "renormalised" has been seen to stir the water over slopes of ghosts, in small eddies; '
                '"continuity", or walls that are mirrors'
            )
        weight = 0.0 if scene.endless_vertical else scene.domain.gravity
        refreshed = scene.damping or scene.relaxation  # by waves that run out
        longest = math.inf if refreshed or not weight or scene.depth <= 0 else ORDERED * math.sqrt(scene.depth / weight)
        if scene.time.end > longest:
            doubts.append(
                f'numerics.density: a standing wave on this depth with "renormalised" fell into disorder after {longest:.3g} s '
                'and lost volume, later with some viscosity; "continuity", or a shorter run'
            )
    for number, body in enumerate(scene.bodies):
        if body.threshold == 1 and body.friction == 0 and body.preload is None:
            doubts.append(
                f"bodies.{number}: nothing holds it in still water, whose computed force is off the exact one by some tenths "
                "of a per cent, so it will creep; a threshold of 1.02 or more, or a preload, stops that"
            )
    return doubts


def _plate(scene):
    """Faults of the plate itself."""
    maker, faults = scene.wavemaker, []
    if maker.wall == "left":
        if scene.walls.left is None:
            why = "the plate is that wall: slip is taken from it"
            faults.append(SceneError("is missing", where="walls.left", why=why, cure="[walls] left = {}"))
    else:
        faults += _named(scene, maker.wall, "wavemaker.wall", ["left"])
        if maker.wall in scene.wall_names:
            low = min(z for _, z in scene.lines[scene.wall_names.index(maker.wall)].points)
            if maker.kind == "flap" and maker.hinge is not None and maker.hinge > low:
                why = f"a polygon wall turns as a whole, and this one begins at {low:g} m"
                cure = f"at most {low:g} m, and a wall of its own for what stands still below the hinge"
                faults.append(SceneError(f"{maker.hinge:g} m is inside the wall", "wavemaker.hinge", why, cure))
    if maker.kind == "piston" and maker.hinge is not None:
        faults.append(SceneError("a piston has no hinge", where="wavemaker.hinge", cure='kind = "flap", or leave it out'))
    if maker.kind == "flap" and not hinge_of(scene) < scene.level:
        cure = f"below {scene.level:g} m; {bed_of(scene):g} m is the bed"
        faults.append(SceneError("the hinge is not under water", where="wavemaker.hinge", cure=cure))
    return faults


def _named(scene, wall, where, sides):
    """Faults of the name of a wall that something shall move."""
    names = [*sides, *(name for name in scene.wall_names if name not in SIDES)]
    if wall not in names:
        cure = f"{did_you_mean(wall, names)}one of: {', '.join(names)}"
        return [SceneError(f"no wall {wall!r} that can move", where=where, cure=cure)]
    if wall not in SIDES and scene.dim != 2:
        return [SceneError("polygon walls are for 2D", where=where, cure="a side of the domain")]
    own = scene.lines[scene.wall_names.index(wall)] if wall in scene.wall_names else None
    if own is not None and (own.motion or own.bulge):
        why, cure = "it has a motion of its own", f"leave out the motion or bulge of {wall!r}"
        return [SceneError(f"{wall!r} cannot be moved", where=where, why=why, cure=cure)]
    return []


def _wave(scene):
    """Faults of the wave that is asked for."""
    return _WAVES[scene.wavemaker.wave.kind](scene, scene.wavemaker.wave, "wavemaker.wave")


def _oscillation(scene, wave, where):
    if (wave.angle is None) == (wave.stroke is None):
        return [SceneError("needs one of angle and stroke", where=where, cure="angle [degrees], or stroke [m]")]
    if wave.angle is not None and scene.wavemaker.kind == "piston":
        return [SceneError("a piston has no angle", where=f"{where}.angle", cure="stroke [m]")]
    if wave.angle is not None and scene.wavemaker.absorption:
        why, cure = "absorption is told in ways of the plate at the still-water level", "stroke [m]"
        return [SceneError("does not go with absorption", where=f"{where}.angle", why=why, cure=cure)]
    return []


def _regular(scene, wave, where):
    try:
        linear = wave_of(scene, wave)
    except SceneError as error:
        return [SceneError(error.what, where=where, why=error.why, cure=error.cure)]
    return _endless(scene, linear.period, where) or broken(wave.height, linear, scene.depth, f"{where}.height")


def _endless(scene, period, where):
    """The fault of more waves than can be meant, in a list."""
    if scene.time.end <= MOST_PERIODS * period:
        return []
    what = f"makes {scene.time.end / period:.3g} waves up to {scene.time.end:g} s, more than {MOST_PERIODS:g}"
    return [SceneError(what, where=where, cure=f"a time.end of at most {MOST_PERIODS * period:.3g} s, or longer waves")]


def _too_many(scene, where):
    """The fault of irregular or focused waves of so many components that they take too long to add up, in a list."""
    wave = scene.wavemaker.wave
    _, high, count = band_of(scene)
    until = min(scene.time.end, getattr(wave, "duration", None) or math.inf)
    summed = count * (LOOKS * high * until + 1)
    if summed <= MOST_SUMMED:
        return []
    what = f"consists of {count:.3g} waves, whose largest sum is looked for in {until:g} s"
    if wave.kind == "focused":
        return [SceneError(what, where=f"{where}.time", why="that takes too long", cure="an earlier focus, or a shorter run")]
    cure = f"after which they repeat, at most {until * math.sqrt(MOST_SUMMED / summed):.3g} s"
    return [SceneError(what, where=f"{where}.duration", why="that takes too long", cure=cure)]


def broken(height, linear, depth, where):
    """Return the fault of a regular wave that breaks, in a list."""
    highest = breaking_height(depth, linear.wavelength)
    if height <= highest:
        return []
    why = f"waves of {linear.period:.3g} s ({linear.wavelength:.3g} m) on {depth:g} m of water break (Miche 1944)"
    return [SceneError(f"{height:g} m is beyond breaking", where=where, why=why, cure=f"at most {highest:.3g} m")]


def _irregular(scene, wave, where):
    faults = _spectrum(wave, where)
    if faults:
        return faults
    if wave.height is None and wave.spectrum != "table":
        return [SceneError("is missing", where=f"{where}.height", cure="significant wave height [m]")]
    height, key = (wave.height, "height") if wave.height is not None else (spectrum_of(wave).height, "densities")
    faults = _endless(scene, scene.wave_period, where) or _too_many(scene, where)
    if faults:
        return faults
    peak = _dispersion(scene)
    highest = breaking_height(scene.depth, peak.wavelength)
    if HIGHEST_OF_MANY * height > highest:
        why = f"the highest of a thousand waves is {HIGHEST_OF_MANY} Hs, and waves of Tp break at {highest:.3g} m (Miche 1944)"
        cure = f"at most {highest / HIGHEST_OF_MANY:.3g} m"
        return [SceneError(f"Hs = {height:.3g} m is beyond breaking", where=f"{where}.{key}", why=why, cure=cure)]
    return []


def _focused(scene, wave, where):
    faults = _spectrum(wave, where)
    if faults:
        return faults
    faults = _endless(scene, scene.wave_period, where) or _too_many(scene, where)
    if faults:
        return faults
    peak = _dispersion(scene)
    highest = breaking_height(scene.depth, peak.wavelength)
    if wave.crest > 0.6 * highest:
        why = f"waves of Tp break at {highest:.3g} m (Miche 1944), and crests have 0.6 of a high wave"
        return [SceneError(f"{wave.crest:g} m is beyond breaking", f"{where}.crest", why, f"at most {0.6 * highest:.3g} m")]
    earliest = wave.place / peak.group_speed
    if wave.time < earliest:
        why = f"its energy needs {earliest:.3g} s to {wave.place:g} m (group speed {peak.group_speed:.3g} m/s)"
        return [SceneError(f"{wave.time:g} s is too early", where=f"{where}.time", why=why, cure=f"at least {earliest:.3g} s")]
    return []


def _spectrum(wave, where):
    """Faults of the keys of a spectrum."""
    of_table, faults = wave.spectrum == "table", []
    for key in ("frequencies", "densities"):
        if (getattr(wave, key) is not None) != of_table:
            what, cure = (
                ("is missing", "a list") if of_table else ("is for spectrum table", 'spectrum = "table", or leave it out')
            )
            faults.append(SceneError(what, where=f"{where}.{key}", cure=cure))
    if (wave.period is None) != of_table:
        what, cure = ("has no meaning here", "leave it out") if of_table else ("is missing", "peak period Tp [s]")
        faults.append(SceneError(what, where=f"{where}.period", cure=cure))
    if of_table and not faults:
        steps = np.diff(wave.frequencies)
        fits = len(wave.frequencies) == len(wave.densities) and (steps > 0).all() and any(wave.densities)
        cure = "as many densities as increasing frequencies, not all of them 0"
        faults += [] if fits else [SceneError("is no spectrum", where=f"{where}.frequencies, densities", cure=cure)]
    return faults


def _solitary(scene, wave, where):
    if scene.wavemaker.kind != "piston":
        why, cure = "a flap moves water at the surface more than at the bed, a solitary wave does not", 'kind = "piston"'
        return [SceneError("needs a piston", where="wavemaker.kind", why=why, cure=cure)]
    highest = HIGHEST_SOLITARY * scene.depth
    if wave.height > highest:
        why = f"solitary waves on {scene.depth:g} m of water break at {HIGHEST_SOLITARY} depths"
        return [SceneError(f"{wave.height:g} m is beyond breaking", f"{where}.height", why, f"at most {highest:.3g} m")]
    return []


def _series(scene, wave, where):
    if wave.unit in ANGLES and scene.wavemaker.kind == "piston":
        return [SceneError("a piston has no angle", where=f"{where}.unit", cure="a unit of length, as m")]
    return []


_WAVES = {
    "oscillation": _oscillation,
    "regular": _regular,
    "irregular": _irregular,
    "focused": _focused,
    "solitary": _solitary,
    "series": _series,
}


def _dispersion(scene):
    """The linear wave of the peak period."""
    return dispersion(scene.depth, scene.domain.gravity, period=scene.wave_period)


def _absorption(scene, plate):
    """Faults of active absorption."""
    keys, where = scene.wavemaker.absorption, "wavemaker.absorption"
    if keys is None:
        return []
    if plate.expected is None:
        why = "the level that the plate's own waves should have is not known"
        return [
            SceneError("needs waves that are known", where=where, why=why, cure="regular, irregular, focused or solitary waves")
        ]
    if keys.distance is not None and keys.distance < scene.reach:
        why, cure = "behind the plate there is no water for its sums", f"at least {scene.reach:.4g} m, the support radius"
        return [SceneError(f"{keys.distance:g} m is too near", where=f"{where}.distance", why=why, cure=cure)]
    gap = place_of(scene) + (keys.distance or scene.reach)
    if gap > scene.domain.size[0]:
        cure = f"at most {scene.domain.size[0] - place_of(scene):.3g} m"
        return [
            SceneError(f"its gauge stands at {gap:g} m", where=f"{where}.distance", why="that is behind the tank", cure=cure)
        ]
    return []


def _stroke(scene, plate):
    """Faults of a plate that swings too far."""
    wave = scene.wavemaker.wave
    keys = {"oscillation": "angle" if getattr(wave, "angle", None) else "stroke", "focused": "crest", "series": "file"}
    key = keys.get(wave.kind, "height")
    top = scene.domain.size[-1]
    least, largest = plate.motion.reach(top)
    water = max(block.high[0] for block in scene.fluid.blocks) - place_of(scene)
    free = min([water] + [zone.length for zone in scene.damping if zone.side == "left"])
    span = max(abs(least), abs(largest))
    if scene.wavemaker.kind == "flap":
        lean = math.degrees(math.atan2(span, top - hinge_of(scene)))
        if lean > 45:
            why = f"the flap would lean by {lean:.3g} degrees"
            cure = "at most 45 degrees: lower or longer waves, a deeper hinge, or a piston"
            return [SceneError("is beyond the flap's reach", where=f"wavemaker.wave.{key}", why=why, cure=cure)]
    if span > LONGEST_STROKE * free:
        why = f"the plate swings {span:.3g} m at the domain's top, in {free:.3g} m of water"
        cure = f"at most {LONGEST_STROKE * free:.3g} m, a quarter of the length: lower waves, or a longer tank"
        return [SceneError("stroke too long", where=f"wavemaker.wave.{key}", why=why, cure=cure)]
    return []


def body_faults(scene):
    """Return what is wrong with the bodies, a list of SceneError."""
    faults, taken = [], [scene.wavemaker.wall] if scene.wavemaker else []
    for number, body in enumerate(scene.bodies):
        where = f"bodies.{number}"
        if scene.dim != 2:
            faults.append(SceneError("bodies are for 2D", where=where, cure="leave it out"))
            continue
        named = _named(scene, body.wall, f"{where}.wall", [side for side in ("left", "right") if side in scene.sides])
        faults += named
        if body.wall in taken:
            faults.append(SceneError(f"{body.wall!r} is moved already", where=f"{where}.wall", cure="another wall"))
        taken.append(body.wall)
        if not any(body.direction):
            faults.append(SceneError("has no length", where=f"{where}.direction", cure="as [1.0, 0.0]"))
        elif body.wall in SIDES and body.direction[1] != 0:
            why, cure = "the side of the domain stays upright and long enough", "[1.0, 0.0]"
            faults.append(SceneError("is not along x", where=f"{where}.direction", why=why, cure=cure))
        if not body.stops[0] <= 0 <= body.stops[1] or body.stops[0] == body.stops[1]:
            cure = "least and largest way, as [-0.1, 0.5] [m]; it begins at 0"
            faults.append(SceneError("must hold 0", where=f"{where}.stops", cure=cure))
        added = scene.fluid.rho0 * scene.numerics.dx * scene.depth
        if not named and body.mass < added:
            why = "the water that its acceleration is felt in within a step weighs more, which is unstable"
            cure = f"at least {added:.3g} kg/m, rho0 dx depth; or a finer numerics.dx"
            faults.append(SceneError(f"{body.mass:g} kg/m is too light", where=f"{where}.mass", why=why, cure=cure))
    return faults
