"""The physics of a scene's keys: what fits together, with limits and units."""

import math

import numpy as np

from ..errors import SceneError, did_you_mean
from ..files import FORBIDDEN, LONGEST_NAME, is_file_name
from ..io.tables import table_name
from ..stepping import INTEGRATORS, VISCOUS_LIMIT, time_step_limit
from ..walls import REPULSIONS, TREATMENTS
from .check_initial import initial_faults
from .check_waves import body_faults, maker_faults
from .fields import SMALLEST
from .limits import MOST_READINGS, size_faults, time_faults
from .schema import ENDS, SIDES
from .solids import ascents_of, fillings_of, polygon_faults, wall_faults
from .zones import relaxation_faults

_ONLY_SHALLOW = 'numerics.state = "shallow", or leave it out'
STRIP_H_OVER_DX = 1.7


def faults_of(scene):
    """Return the faults of a scene whose keys are of the right type, a list of SceneError."""
    faults = _shapes(scene) or _shallow(scene) or size_faults(scene) or _treatment(scene) or _endless(scene)
    faults = faults or maker_faults(scene) + body_faults(scene) or relaxation_faults(scene) or wall_faults(scene)
    rest = _numerics, _terms, _geometry, _sliding, _periodic, _damping, _gauges
    return faults or [fault for part in rest for fault in part(scene)] or initial_faults(scene) or time_faults(scene)


def _vector(where, values, dim):
    if values is not None and len(values) != dim:
        return [SceneError(f"has {len(values)} components", where=where, cure=f"this scene has {dim}, as domain.size says")]
    return []


def _shapes(scene):
    """Numbers of components."""
    faults = polygon_faults(scene)
    if faults:
        return faults
    for d, size in enumerate(scene.domain.size):
        if size < SMALLEST:
            faults.append(SceneError(f"must be > 0 m, not {size}", where=f"domain.size.{d}", cure="an extent > 0 m"))
    for number, block in enumerate(scene.fluid.blocks):
        faults += _vector(f"fluid.blocks.{number}.low", block.low, scene.dim)
        faults += _vector(f"fluid.blocks.{number}.high", block.high, scene.dim)
        faults += _vector(f"fluid.blocks.{number}.velocity", block.velocity, scene.dim)
    for number, gauge in enumerate(scene.gauges):
        for key in ("point", "extent", "low", "high"):
            faults += _vector(f"gauges.{number}.{key}", getattr(gauge, key, None), scene.dim)
        if gauge.kind == "level" and ((scene.dim == 1 and not scene.shallow) or (gauge.y is None) != (scene.dim < 3)):
            cure = "give x and y in 3D, x alone in 2D; in 1D shallow water alone has a level"
            faults.append(SceneError("wrong number of coordinates", where=f"gauges.{number}", cure=cure))
    for side, (axis, _) in SIDES.items():
        missing = (axis == 1 and scene.dim < 3) or (axis == -1 and scene.dim < 2)
        if getattr(scene.walls, side) is not None and missing:
            faults.append(SceneError(f"there is no such side in {scene.dim}D", where=f"walls.{side}", cure="leave it out"))
    if not faults and not scene.shallow and 0 < scene.depth < SMALLEST:
        cure = f"a level of at least {SMALLEST:g} m over the lowest point of the fluid"
        faults.append(SceneError(f"{scene.depth:g} m of water are none", where="fluid.level", cure=cure))
    return faults


def _treatment(scene):
    """What walls of this treatment cannot be, or lack."""
    walls, faults, where = scene.walls, [], "walls.treatment"
    treatment = TREATMENTS[walls.treatment] if walls.treatment else None
    for number, wall in enumerate(walls.polygons):
        at, edges = f"walls.polygons.{number}", len(wall.points) - (wall.fluid in ("left", "right"))
        if treatment and treatment.family == "mirror":
            why, cure = "mirrors are the straight sides of the domain", '"ghosts", "strip", "deficiency" or "repulsion"'
            faults.append(SceneError("cannot be mirrors", where=at, why=why, cure=cure))
        if wall.bulge and wall.motion:
            faults.append(SceneError("given beside motion", where=f"{at}.bulge", cure="one of the two"))
        if wall.bulge and wall.bulge.edge >= edges:
            cure = f"0 to {edges - 1}"
            faults.append(SceneError(f"there is no edge {wall.bulge.edge}", where=f"{at}.bulge.edge", cure=cure))
    if treatment is None or treatment.family == "mirror":
        return faults
    dims = (1, 2) if treatment.family == "markers" else (2,)
    if scene.dim not in dims or scene.shallow:
        cure = "mirror" if scene.dim != 2 else "leave it out"
        kinds = "shallow water" if scene.shallow else f"{scene.dim}D"
        faults.append(SceneError(f"{treatment.name!r} is not for {kinds}", where=where, cure=cure))
    if walls.exchange:
        why, cure = "there are no images to change places with", "false, or mirror walls"
        faults.append(SceneError("is for mirror walls", where="walls.exchange", why=why, cure=cure))
    if not scene.sides and not walls.polygons:
        faults.append(SceneError("there are no walls", where=where, cure="[walls] left = {}, ..., or polygons"))
    if treatment.family == "markers":
        if walls.repulsion == "none" and not treatment.corrects:
            laws = " or ".join(f'"{name}"' for name in REPULSIONS if name != "none")
            faults.append(SceneError("nothing holds the fluid", where="walls.repulsion", cure=laws))
        if walls.push_reach and walls.push_reach > scene.reach:
            why, cure = "particles feel each other no further", f"at most {scene.reach:.4g} m"
            faults.append(SceneError(f"{walls.push_reach:g} m is too far", where="walls.push_reach", why=why, cure=cure))
    if treatment.solves and scene.numerics.h_over_dx > STRIP_H_OVER_DX:
        why = "the velocities of ghosts so near to each other, compared with h, cannot be told apart at the wall"
        cure = f"at most {STRIP_H_OVER_DX:g}"
        faults.append(SceneError(f"{scene.numerics.h_over_dx:g} is too large for a strip", "numerics.h_over_dx", why, cure))
    return faults


def _shallow(scene):
    """What shallow water needs, and what nothing else can have."""
    n, faults = scene.numerics, []
    for number, block in enumerate(scene.fluid.blocks):
        if scene.shallow and block.pressure is not None:
            why = "the depth decides it"
            faults.append(SceneError("has no pressure", where=f"fluid.blocks.{number}.pressure", why=why, cure="leave it out"))
    if not scene.shallow:
        for number, block in enumerate(scene.fluid.blocks):
            keys = [key for key in ("depth", "center", "width") if getattr(block, key) is not None]
            for key in keys + ["initial"] * (block.initial == "pulse"):
                faults.append(SceneError("is for shallow water", where=f"fluid.blocks.{number}.{key}", cure=_ONLY_SHALLOW))
        if n.density == "summation" and n.density_range is None:
            why = "outside shallow water the sum falls off at a free surface, and at sides without walls"
            cure = 'how far densities may fall in numerics.density_range, as [0.4, 1.3]; or "continuity"'
            faults.append(SceneError("does not fit the usual range", where="numerics.density", why=why, cure=cure))
        if n.h_growth > 1:
            faults.append(SceneError("is for shallow water", where="numerics.h_growth", cure="1, or leave it out"))
        return faults
    if scene.dim != 1:
        why = "the depth is the density: the vertical is no dimension of the scene"
        return [SceneError("shallow water needs one dimension", where="domain.size", why=why, cure="size = [length]")]
    if scene.domain.gravity == 0:
        faults.append(SceneError("shallow water needs gravity", where="domain.gravity", cure="9.81"))
    if n.c0 is not None:
        why = "waves run with sqrt(g depth)"
        faults.append(SceneError("shallow water has no sound speed", where="numerics.c0", why=why, cure="leave it out"))
    if n.preset is not None:
        why = "presets were measured where water has a surface, and their terms need one"
        faults.append(SceneError("is not for shallow water", where="numerics.preset", why=why, cure="leave it out"))
    for number, block in enumerate(scene.fluid.blocks):
        where = f"fluid.blocks.{number}"
        if block.depth is None:
            faults.append(SceneError("is missing", where=f"{where}.depth", cure="still-water depth of this block [m]"))
        missing = [key for key in ("center", "width") if getattr(block, key) is None]
        if block.initial == "pulse" and missing:
            faults.append(SceneError(f"a pulse needs {' and '.join(missing)}", where=where, cure="both in m"))
        if block.initial == "seiche":
            faults.append(SceneError("a seiche needs 2D", where=f"{where}.initial", cure='"still" or "pulse"'))
    if n.h_growth > 1 and not (n.viscosity == "monaghan" and n.alpha >= 0.5 and n.integrator == "verlet"):
        why = "h follows the density of the evaluation before, which grows noise unless the flow is viscous"
        cure = 'viscosity = "monaghan" with alpha >= 0.5 and integrator = "verlet", or h_growth = 1'
        faults.append(SceneError("a growing h is unstable here", where="numerics.h_growth", why=why, cure=cure))
    where = {
        "numerics.kernel_correction": n.kernel_correction != "none",
        "output.snapshots.moments": scene.output.snapshots.moments,
    }
    for key in [key for key, named in where.items() if named and n.h_growth > 1]:
        why = "moments are those of one smoothing length"
        faults.append(SceneError("has no meaning with a growing h", where=key, why=why, cure="h_growth = 1, or leave it out"))
    if n.diffusion == "fourtakas" and n.density != "summation":
        why = "there is no hydrostatic part"
        faults.append(SceneError("has no meaning here", where="numerics.diffusion", why=why, cure='"molteni" or "none"'))
    return faults


def _numerics(scene):
    n, faults = scene.numerics, []
    low, high = scene.kernel.h_over_dx
    if not low <= n.h_over_dx <= high:
        faults.append(
            SceneError(
                f"{n.h_over_dx} is out of range",
                where="numerics.h_over_dx",
                why=f"the sums of the {n.kernel} kernel need neighbours enough, and no more than resolve the flow",
                cure=f"{low} to {high}",
            )
        )
    weightless = scene.domain.gravity == 0 or scene.dim == 1 or scene.depth <= 0 or scene.endless_vertical
    if not scene.shallow and n.c0 is None and weightless:
        faults.append(
            SceneError(
                "is missing",
                where="numerics.c0",
                why="there is no depth under gravity to derive it from",
                cure="ten times the fastest flow [m/s]",
            )
        )
        return faults
    if not 0 <= scene.density_range[0] < 1 < scene.density_range[1]:
        faults.append(SceneError("must hold 1 and not begin below 0", where="numerics.density_range", cure="as [0.7, 1.3]"))
    integrator = INTEGRATORS[n.integrator]
    gravity = abs(scene.gravity[-1])
    limit = time_step_limit(scene.h, scene.c0, gravity, integrator.largest_cfl, nu=n.nu or 0.0)
    reason = f"the {n.integrator} integrator is stable up to cfl {integrator.largest_cfl}, dt = cfl h/c0"
    viscous = f" and nu = {n.nu:.4g} m^2/s, dt = {VISCOUS_LIMIT} h^2/nu" if n.nu else ""
    if scene.time.dt is not None and scene.time.dt > limit:
        cure = f"at most {limit:.3g} s for h = {scene.h:.4g} m, c0 = {scene.c0:.4g} m/s{viscous}; or leave it out"
        faults.append(SceneError(f"{scene.time.dt:g} s is unstable", where="time.dt", why=reason, cure=cure))
    if scene.cfl > integrator.largest_cfl:
        cure = f"at most {integrator.largest_cfl}; {integrator.cfl} is the default"
        faults.append(SceneError(f"{scene.cfl:g} is unstable", where="time.cfl", why=reason, cure=cure))
    if scene.dim > 1 and not scene.endless_vertical and scene.domain.gravity * scene.depth > 0.25 * scene.c0**2:
        faults.append(
            SceneError(
                f"{scene.c0:.4g} m/s is too slow for {scene.depth:.4g} m of water",
                where="numerics.c0",
                why="the water at the bed would be compressed by more than a tenth",
                cure=f"at least {10 * math.sqrt(scene.domain.gravity * scene.depth):.4g} m/s, ten times sqrt(g depth)",
            )
        )
    return faults


def _terms(scene):
    """Terms that need others, or exclude them."""
    n, faults = scene.numerics, []
    if n.viscosity == "newtonian" and n.nu is None:
        faults.append(
            SceneError("is missing", where="numerics.nu", why="viscosity is newtonian", cure="1e-6 for water [m^2/s]")
        )
    if n.viscosity == "newtonian" and (scene.lines or not scene.mirrors):
        why = "ghosts and markers carry no strain rate"
        cure = "mirror walls, or another viscosity"
        faults.append(SceneError("needs mirror walls", where="numerics.viscosity", why=why, cure=cure))
    if n.viscosity == "newtonian" and scene.shallow:
        why = "a sum over the horizontal knows no stress over the depth"
        faults.append(
            SceneError("is no term of shallow water", where="numerics.viscosity", why=why, cure='"monaghan" or "none"')
        )
    if n.viscosity == "newtonian" and n.kernel_correction != "none":
        why, cure = "its stress is summed with the plain kernel", '"none", or another viscosity'
        faults.append(SceneError("does not go with newtonian viscosity", "numerics.kernel_correction", why, cure))
    if n.viscosity != "newtonian" and n.nu is not None:
        cure = 'viscosity = "newtonian", or leave it out'
        faults.append(SceneError("has no meaning here", where="numerics.nu", why=f"viscosity is {n.viscosity}", cure=cure))
    if n.density == "summation":
        for key in ("diffusion", "spray"):
            if getattr(n, key) != "none":
                cure = f'{key} = "none", or density = "continuity"'
                why = "densities are summed"
                faults.append(SceneError("has nothing to act on", where=f"numerics.{key}", why=why, cure=cure))
    if n.density == "renormalised":
        if n.kernel_correction != "none" or scene.shallow:
            why = "there is no free surface in the plan" if scene.shallow else "kernel_correction does that, and more"
            faults.append(SceneError("has no meaning here", where="numerics.density", why=why, cure='"continuity"'))
        elif n.integrator != "adams-bashforth":
            why = f"sound of short waves at the surface is faster with it, and {n.integrator} lets it grow in still water"
            cure = 'integrator = "adams-bashforth", or density = "continuity"'
            faults.append(SceneError("is unstable here", where="numerics.density", why=why, cure=cure))
    if n.xsph_continuity:
        for key, fits, cure in (
            ("xsph", n.xsph > 0, "an xsph > 0, or xsph_continuity = false"),
            ("density", n.density == "continuity", '"continuity", or xsph_continuity = false'),
            ("shifting", n.shifting == "none", '"none", or xsph_continuity = false'),
        ):
            if not fits:
                why = "the continuity equation shall have the smoothed velocity, and that alone"
                faults.append(SceneError("does not go with xsph_continuity", where=f"numerics.{key}", why=why, cure=cure))
    return faults


def _sliding(scene):
    """Mirror walls that slide in their planes."""
    faults = []
    for side, (axis, _) in SIDES.items():
        wall, where = getattr(scene.walls, side), f"walls.{side}.velocity"
        if wall is None or wall.velocity is None:
            continue
        if not scene.mirrors:
            cure = 'walls.treatment = "mirror", or leave it out'
            faults.append(SceneError("is for mirror walls", where=where, cure=cure))
        wrong = _vector(where, wall.velocity, scene.dim)
        if wrong:
            faults += wrong
        elif wall.velocity[axis] != 0:
            cure = f"0 as component {axis % scene.dim}"
            faults.append(SceneError("moves the wall out of its plane", where=where, why="the domain stays", cure=cure))
        elif wall.slip != "no":
            faults.append(SceneError("is felt by nothing", where=where, why="the slip is free", cure='slip = "no"'))
        if side in scene.moved_sides:
            faults.append(SceneError("this wall is moved already", where=where, cure="leave it out"))
    return faults


def _endless(scene):
    """Axes that cannot be periodic, and what a horizontal without ends excludes."""
    where, names = "domain.periodic", scene.domain.periodic
    missing = [name for name, least in (("y", 3), ("up", 2)) if name in names and scene.dim < least]
    if missing:
        return [SceneError(f"there is no {missing[0]} in {scene.dim}D", where=where, cure="leave it out")]
    faults = []
    if len(set(names)) < len(names):
        once = ", ".join(f'"{name}"' for name in scene.periodic)
        faults.append(SceneError("names an axis twice", where=where, cure=f"[{once}]"))
    for name in scene.periodic:
        faults += _without_ends(scene, name) if name != "up" else []
    for key in ("wavemaker", "relaxation", "damping") if "x" in names else ():
        if getattr(scene, key):
            faults.append(SceneError("there is no end to stand at", where=key, why="x is periodic", cure="leave it out"))
    return faults


def _without_ends(scene, name):
    """What a periodic axis of this name excludes."""
    faults, extent, least = [], scene.domain.size[scene.periodic[name]], 2 * scene.reach
    axis, measure = {"x": ("x", "length"), "y": ("y", "width"), "up": ("the vertical", "height")}[name]
    if extent < least:
        why = "a particle would meet another and its copy"
        cure = f"a {measure} of at least {least:.4g} m, two supports of the kernel"
        faults.append(SceneError(f"{extent:g} m are too few", where="domain.size", why=why, cure=cure))
    for side in ENDS[name]:
        if getattr(scene.walls, side) is not None:
            why = f"{axis} is periodic"
            faults.append(SceneError("there is no such side", where=f"walls.{side}", why=why, cure="leave it out"))
    if scene.lines or not scene.mirrors:
        why, at = "ghosts and markers are not repeated", "walls.polygons" if scene.mirrors else "walls.treatment"
        faults.append(SceneError(f"cannot be where {axis} is periodic", where=at, why=why, cure="mirror walls"))
    return faults


def _periodic(scene):
    """What a vertical without ends excludes."""
    if not scene.endless_vertical:
        return []
    faults = _without_ends(scene, "up")
    if scene.numerics.diffusion in ("fourtakas", "antuono"):
        why = "it takes the hydrostatic density off, which jumps where the vertical begins again"
        faults.append(SceneError("needs a column of water", where="numerics.diffusion", why=why, cure='"molteni" or "none"'))
    for number, block in enumerate(scene.fluid.blocks):
        if block.pressure is None:
            why = "there is no surface that a still-water pressure could begin at"
            at = f"fluid.blocks.{number}.pressure"
            faults.append(SceneError("is missing", where=at, why=why, cure="that of the block [Pa]"))
        if block.initial == "seiche":
            why = "there is no surface for a wave"
            faults.append(SceneError("cannot begin so", where=f"fluid.blocks.{number}.initial", why=why, cure='"still"'))
    for number, gauge in enumerate(scene.gauges):
        if gauge.kind in ("level", "runup"):
            why = "the vertical is periodic"
            faults.append(SceneError("there is no surface", where=f"gauges.{number}", why=why, cure="another gauge"))
    for number, zone in enumerate(scene.damping):
        if zone.density != "none":
            why = "there is no still water to damp towards"
            faults.append(SceneError("needs a surface", where=f"damping.{number}.density", why=why, cure='"none"'))
    return faults


def _geometry(scene):
    faults, size = [], np.array(scene.domain.size)
    for number, (block, filling) in enumerate(zip(scene.fluid.blocks, fillings_of(scene), strict=True)):
        where = f"fluid.blocks.{number}"
        low, high = np.array(block.low), np.array(block.high)
        if (low < 0).any() or (high > size * (1 + 1e-12)).any():
            cure = f"within 0 and {scene.domain.size} m, or enlarge domain.size"
            faults.append(SceneError("lies outside the domain", where=where, cure=cure))
        if filling.about == 0:
            cure = f"high - low of at least dx = {scene.numerics.dx} m in every direction"
            faults.append(SceneError("holds no particles", where=where, cure=cure))
        if block.initial == "seiche" and (scene.dim != 2 or scene.domain.gravity == 0):
            faults.append(SceneError("a seiche needs 2D and gravity", where=f"{where}.initial", cure='"still"'))
        for other in range(number):
            b = scene.fluid.blocks[other]
            if block.points or b.points:
                continue
            if (np.maximum(low, b.low) < np.minimum(high, b.high) - 0.5 * scene.numerics.dx).all():
                faults.append(SceneError(f"overlaps block {other}", where=where, cure="blocks may touch, not overlap"))
    reach = scene.reach
    for a, b, axis in (("left", "right", 0), ("front", "back", 1), ("bottom", "top", -1)):
        if getattr(scene.walls, a) and getattr(scene.walls, b) and scene.domain.size[axis] < reach:
            why = "the images of one would mirror at the other"
            cure = f"at least {reach:.4g} m apart, or a finer numerics.dx"
            faults.append(SceneError("walls nearer than the kernel's support", where=f"walls.{a}, {b}", why=why, cure=cure))
    return faults


def _damping(scene):
    faults, length = [], scene.domain.size[0]
    water = min(block.low[0] for block in scene.fluid.blocks), max(block.high[0] for block in scene.fluid.blocks)
    for number, zone in enumerate(scene.damping):
        where = f"damping.{number}"
        edge = zone.length if zone.side == "left" else length - zone.length
        if zone.length >= length:
            cure = f"less than the domain's {length:g} m"
            faults.append(SceneError(f"{zone.length:g} m is too long", where=f"{where}.length", cure=cure))
        elif not (water[0] < edge if zone.side == "left" else edge < water[1]):
            why = f"it ends at x = {edge:g} m, the water reaches from {water[0]:g} to {water[1]:g} m"
            faults.append(SceneError("the layer lies outside the fluid", where=where, why=why, cure="a longer one, or none"))
        if any(zone.side == other.side for other in scene.damping[:number]):
            faults.append(SceneError(f"a second layer at the {zone.side}", where=f"{where}.side", cure="one per side"))
        if zone.sigma0 is not None and zone.v_ref is not None:
            why = "sigma0 is v_ref / L"
            faults.append(SceneError("given beside v_ref", where=f"{where}.sigma0", why=why, cure="one of the two"))
        if zone.density != "none" and scene.numerics.density == "summation" and not scene.shallow:
            why = "densities are summed"
            faults.append(SceneError("has nothing to act on", where=f"{where}.density", why=why, cure='"none"'))
        if zone.density == "matched" and not scene.shallow and (scene.dim == 1 or scene.domain.gravity * scene.depth <= 0):
            why = "it is matched to the speed of surface waves"
            cure = '"plain" or "none"'
            faults.append(SceneError("needs depth under gravity", where=f"{where}.density", why=why, cure=cure))
        if zone.killing != "none" and zone.side in scene.moved_sides:
            why = "a weakened force does not hold the water at a wall that moves"
            faults.append(SceneError("a moving wall stands there", where=f"{where}.killing", why=why, cure='"none"'))
        if zone.switch == "vx-vy" and scene.dim == 1:
            faults.append(SceneError("there is no vy in 1D", where=f"{where}.switch", cure='"vx", "fx-vx" or "none"'))
    if not faults and sum(zone.length for zone in scene.damping) > length:
        faults.append(SceneError("the layers overlap", where="damping", cure=f"together at most {length:g} m"))
    return faults


def _gauges(scene):
    faults, names, size = [], set(), scene.domain.size
    for number, gauge in enumerate(scene.gauges):
        where = f"gauges.{number}"
        name = table_name(gauge.name, gauge.kind, number)
        if not is_file_name(name):
            cure = f"a plain name of up to {LONGEST_NAME} characters, none of {FORBIDDEN}"
            faults.append(SceneError(f"{name!r} is no file name", where=f"{where}.name", cure=cure))
        elif name.casefold() in names:
            why = "some file systems tell no capitals from small letters"
            faults.append(SceneError(f"{name!r} is taken", where=f"{where}.name", why=why, cure="a name of its own"))
        names.add(name.casefold())
        if gauge.kind == "body":
            bodies = [body.wall for body in scene.bodies]
            if gauge.wall not in bodies:
                cure = f"{did_you_mean(gauge.wall, bodies)}one of: {', '.join(bodies) or 'none in this scene'}"
                faults.append(SceneError(f"no body {gauge.wall!r}", where=f"{where}.wall", cure=cure))
            continue
        if gauge.kind in ("force", "runup") or (gauge.kind == "pressure" and gauge.wall is not None):
            faults += _on_wall(scene, gauge, where)
        if gauge.kind == "force":
            continue
        if gauge.kind == "power":
            faults += _power(scene, where)
            continue
        if gauge.kind == "energy":
            if gauge.low and gauge.high and not all(a < b for a, b in zip(gauge.low, gauge.high, strict=True)):
                faults.append(SceneError("the region is empty", where=where, cure="low < high in every direction"))
            continue
        extent = getattr(gauge, "extent", None)
        if extent and math.hypot(*extent) > 0.5 * MOST_READINGS * scene.numerics.dx:
            cure = f"at most {0.5 * MOST_READINGS * scene.numerics.dx:g} m, {MOST_READINGS:,} readings half a spacing apart"
            faults.append(SceneError(f"{math.hypot(*extent):g} m are too long", where=f"{where}.extent", cure=cure))
        place = gauge.point if gauge.kind == "pressure" else [x for x in (gauge.x, getattr(gauge, "y", None)) if x is not None]
        for x, extent in zip(place, size, strict=False):
            if not 0 <= x <= extent:
                faults.append(SceneError(f"{x:g} m lies outside the domain", where=where, cure=f"0 to {extent:g} m"))
    return faults


def _power(scene, where):
    """What a gauge of power does not account for."""
    n = scene.numerics
    for key, named, why in (
        ("walls.treatment", scene.lines and scene.treatment.family == "markers", "markers act beside the pairs of particles"),
        ("numerics.density", n.density == "summation", "densities are summed, no rate changes them"),
        ("numerics.xsph_continuity", n.xsph_continuity, "its continuity equation has the velocities of the evaluation before"),
    ):
        if named:
            return [SceneError(f"does not go with {key} of this scene", f"{where}.kind", why, "another gauge")]
    return []


def _on_wall(scene, gauge, where):
    """What is wrong with a gauge that names a wall."""
    kind = gauge.kind
    if scene.dim != 2:
        at, cure = ("wall", "leave it out") if kind == "pressure" else ("kind", "another gauge")
        return [SceneError("is for 2D", where=f"{where}.{at}", cure=cure)]
    names, sides = list(scene.wall_names), scene.sides if scene.mirrors else ()
    names += [side for side in sides if kind != "runup" or SIDES[side][0] == 0]
    if gauge.wall not in names:
        cure = f"{did_you_mean(gauge.wall, names)}one of: {', '.join(names) or 'none in this scene'}"
        return [SceneError(f"no wall {gauge.wall!r}", where=f"{where}.wall", cure=cure)]
    return _runup(scene, gauge, where) if kind == "runup" and not scene.endless_vertical else []


def _runup(scene, gauge, where):
    """What is wrong with a gauge of run-up on a wall that is there."""
    places = [ascent.x for ascent in ascents_of(scene, gauge.wall)]
    if not places:
        why = f"no part of {gauge.wall!r} rises from the still-water level, {scene.level:g} m, or above it"
        return [SceneError("nothing to run up", where=f"{where}.wall", why=why, cure="a wall that reaches out of the water")]
    if len(places) > 1 and gauge.x is None:
        why = f"still water meets {gauge.wall!r} at x = {', '.join(f'{x:.4g}' for x in places)} m"
        cure = f"the one that is meant, as x = {places[-1]:.4g}"
        return [SceneError("is missing", where=f"{where}.x", why=why, cure=cure)]
    return []
