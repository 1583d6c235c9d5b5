"""From a scene's polygons to walls, ghosts and blocks of fluid; the only place of scenes that needs shapely."""

import math

import numpy as np

from ..errors import SceneError
from ..io.gauges import ascents
from ..parallel import Communicator
from ..walls import REPULSIONS, WEIGHTS, Barrier, FixedGhosts, Line, Lines, Markers, Strip
from ..walls.mirror import SLIPS
from ..wavemakers import Bulge, Swing
from .lattice import Filling, Lattice
from .movers import body_motions, maker_of
from .schema import SIDES

SAMPLES = 0.1  # spacings between the points of a wall that are looked at for run-up


def motions_of(scene, maker=None):
    """Return {wall: motion} of all walls that move.

    Parameters
    ----------
    scene : Scene
    maker : Maker, optional
        Whose motion the wavemaker's wall has; default: one of its own.
    """
    motions = {
        name: _swing(wall) if wall.motion is not None else _bulge(scene, wall)
        for name, wall in zip(scene.wall_names, scene.lines, strict=True)
        if wall.motion is not None or wall.bulge is not None
    }
    maker = maker or maker_of(scene)
    if maker:
        motions[scene.wavemaker.wall] = maker.motion
    return motions | body_motions(scene)


def _swing(wall):
    motion = wall.motion
    center = tuple(motion.center or wall.points[0])
    return Swing(tuple(motion.way), math.radians(motion.angle), center, motion.period, motion.ramp)


def _bulge(scene, wall):
    from ..geometry import Outline

    ends = [tuple(wall.points[k % len(wall.points)]) for k in (wall.bulge.edge, wall.bulge.edge + 1)]
    edges = Outline("", tuple(map(tuple, wall.points)), wall.fluid).edges.tolist()
    if [list(end) for end in ends] not in edges:  # the fluid is at the left of it the other way round
        ends.reverse()
    bulge, thickness = wall.bulge, scene.reach + scene.numerics.dx
    return Bulge(*ends, bulge.amplitude, bulge.period, bulge.ramp, thickness)


def outlines_of(scene, motions):
    """Return the `Outline` of each wall that is a line; bed and lid go on where the walls at their ends go, but for a bed that
    ends at the sill of a flap.
    """
    if not scene.lines:
        return []
    from ..geometry import Outline

    outlines, height = [], scene.domain.size[-1]
    ways = [motions[side].reach(height) if side in scene.moved_sides else (0.0, 0.0) for side in ("left", "right")]
    low, high = -min(ways[0][0], 0.0), max(ways[1][1], 0.0)
    for name, wall in zip(scene.wall_names, scene.lines, strict=True):
        points = np.array(wall.points, float)
        if name in ("bottom", "top"):
            stays = name == "bottom" and scene.sill is not None
            points[:, 0] += np.where(points[:, 0] == 0.0, 0.0 if stays else -low, high)
        outlines.append(Outline(name, tuple(map(tuple, points.tolist())), wall.fluid))
    return outlines


def boundaries_of(scene, motions=None):
    """Return pairs (`Boundary`, motion or None): the walls that stand still together, then each that moves."""
    if not scene.lines:
        return []
    from ..geometry import Boundary

    motions = motions_of(scene) if motions is None else motions
    outlines, moving = outlines_of(scene, motions), [motions.get(name) for name in scene.wall_names]
    groups = [{number: outlines[number] for number, motion in enumerate(moving) if motion is None}]
    groups += [{number: outlines[number]} for number, motion in enumerate(moving) if motion is not None]
    boundaries = []
    for group in filter(None, groups):
        motion = moving[min(group)]
        beside = [outline for n, outline in enumerate(outlines) if n not in group]
        boundaries.append((Boundary(group, scene.numerics.dx, scene.reach, beside, motion is not None), motion))
    return boundaries


def still_force(scene, surface, direction):
    """Return the force of still water on a wall, `surface` as midpoints, normals, lengths, along a direction [N/m]."""
    points, normals, lengths = surface
    weight = scene.fluid.rho0 * scene.domain.gravity
    height = lengths * np.abs(normals[:, 0])
    top = np.clip(scene.level - points[:, 1] + 0.5 * height, 0.0, None)  # under water, at the lower end of each piece
    bottom = np.clip(scene.level - points[:, 1] - 0.5 * height, 0.0, None)
    covered = np.divide(top - bottom, height, out=(top > 0).astype(float), where=height > 0)
    push = -weight * 0.5 * (top + bottom) * covered * lengths
    return float(push @ (normals @ np.array(direction)))


def ghosts_of(scene, state, motions):
    """Return the `FixedGhosts` and the `Barrier` of a scene, both None when no walls are of ghosts."""
    boundaries = boundaries_of(scene, motions)
    if not boundaries or scene.treatment.family != "ghosts":
        return None, None
    slips = [SLIPS[wall.slip] for wall in scene.lines]
    made = Strip if scene.treatment.solves else FixedGhosts
    tables = [(boundary.ghosts(1 if scene.treatment.solves else None), slips, motion) for boundary, motion in boundaries]
    ghosts = made(tables, scene.walls.interpolation, scene.kernel, scene.h, scene.rho0, scene.gravity, state)
    lines = [Lines(*boundary.lines(isinstance(motion, Bulge)), motion) for boundary, motion in boundaries]
    return ghosts, Barrier(lines, scene.numerics.dx)


def markers_of(scene, motions=None):
    """Return the `Markers` of a scene, None when no walls are of markers."""
    if scene.mirrors or scene.treatment.family != "markers":
        return None
    spacing = scene.numerics.dx / scene.walls.markers_per_dx
    if scene.dim == 1:
        ends = {"left": (0.0, 1.0), "right": (scene.domain.size[0], -1.0)}
        lines = [Line(np.array([[ends[side][0]]]), np.array([[ends[side][1]]]), np.ones(1)) for side in scene.sides]
    else:
        lines = []
        for boundary, motion in boundaries_of(scene, motions):
            pieces = [boundary.elements(number, spacing) for number in boundary.outlines]
            lines.append(Line(*(np.concatenate(parts) for parts in zip(*pieces, strict=True)), motion))
    if not lines:
        return None
    corrects = scene.treatment.corrects
    push = scene.walls.push or (scene.domain.gravity * scene.depth if scene.dim > 1 else 0.0) or (scene.c0 / 20.0) ** 2
    return Markers(
        lines,
        WEIGHTS[scene.walls.weights] if corrects else None,
        REPULSIONS[scene.walls.repulsion],
        scene.kernel,
        scene.h,
        scene.numerics.dx,
        spacing,
        push / scene.walls.markers_per_dx ** (scene.dim - 1),
        scene.walls.push_reach or (0.5 if corrects else 1.0) * scene.numerics.dx,
        scene.gravity,
        scene.c0,
    )


def surface_of(scene, name, length=None):
    """Return the surface of a wall at rest in pieces of about a `length` [m], by default dx, from end to end.

    Returns
    -------
    tuple of ndarray
        Midpoints [m], normals into the fluid, lengths [m], shapes (n, 2), (n, 2), (n,).
    """
    if name in scene.wall_names:
        number = scene.wall_names.index(name)
        for boundary, _ in boundaries_of(scene):
            if number in boundary.outlines:
                return boundary.elements(number, length)
    size = scene.domain.size
    axis, direction = SIDES[name][0] % 2, SIDES[name][1]
    across = 1 - axis
    begin = scene.sill or 0.0 if name == "left" else 0.0  # what lies below a flap's hinge is another wall
    extent = size[across] - begin
    count = max(1, round(extent / (length or scene.numerics.dx)))
    points, normals = np.zeros((count, 2)), np.zeros((count, 2))
    points[:, across] = begin + (np.arange(count) + 0.5) * extent / count
    points[:, axis] = 0.0 if direction > 0 else size[axis]
    normals[:, axis] = direction
    return points, normals, np.full(count, extent / count)


def ascents_of(scene, name):
    """Return the ways up a wall, one for each place where still water meets it (`parsph.io.gauges.ascents`)."""
    return ascents(*surface_of(scene, name, SAMPLES * scene.numerics.dx), scene.level)


def ascent_of(scene, gauge):
    """Return the way up a wall that a gauge of run-up means."""
    found = ascents_of(scene, gauge.wall)
    return found[0] if gauge.x is None else min(found, key=lambda ascent: abs(ascent.x - gauge.x))


def fillings_of(scene, communicator=None):
    """Return the `Lattice` of each block, or its `Filling` where it is a polygon or has walls in it; the ranks of a
    `communicator` share the counting in those.
    """
    lattices = [Lattice.of(block, scene.numerics.dx) for block in scene.fluid.blocks]
    if not scene.lines and not any(block.points for block in scene.fluid.blocks):
        return lattices
    boundaries = tuple(boundary for boundary, _ in boundaries_of(scene))
    communicator = communicator or Communicator()
    blocks = zip(scene.fluid.blocks, lattices, strict=True)
    return [_filling(block, lattice, boundaries, scene.numerics.dx, communicator) for block, lattice in blocks]


def _filling(block, lattice, boundaries, dx, communicator):
    from ..geometry import without

    shape = _shape(block)
    area = without(shape, boundaries)
    if block.points is None and shape.area - area.area < 1e-3 * dx**2:
        return lattice
    return Filling(lattice, area, boundaries, communicator)


def _shape(block):
    from ..geometry import polygon

    (left, bottom), (right, top) = block.low, block.high
    return polygon(block.points or [(left, bottom), (right, bottom), (right, top), (left, top)])


def polygon_faults(scene):
    """Return the faults of polygons in a scene that has not two dimensions, a list of SceneError."""
    if scene.dim == 2:
        return []
    places = [f"fluid.blocks.{number}.points" for number, block in enumerate(scene.fluid.blocks) if block.points]
    faults = [SceneError("polygons are for 2D", where=place, cure="low and high") for place in places]
    if scene.walls.polygons:
        faults.append(SceneError("polygons are for 2D", where="walls.polygons", cure="sides of the domain"))
    return faults


def wall_faults(scene):
    """Return what is wrong with the polygon walls and with the fluid beside them, a list of SceneError."""
    polygons = [number for number, block in enumerate(scene.fluid.blocks) if block.points]
    if not scene.lines and not polygons:
        return []
    from ..geometry import Outline, outline_faults

    size, names, faults, motions = scene.domain.size, scene.wall_names, [], motions_of(scene)
    for number, outline in enumerate(outlines_of(scene, motions)):
        where = scene.line_key(number)
        if outline.name not in SIDES:  # sides go where the domain goes
            faults += outline_faults(outline, where, size) or _excursion(scene, number, outline, motions.get(outline.name))
        faults += _near_mirror(scene, number, outline)
        of_side = number >= len(scene.walls.polygons)
        if names.index(outline.name) != number or (outline.name in SIDES and not of_side):
            faults.append(SceneError(f"{outline.name!r} is taken", where=f"{where}.name", cure="a name of its own"))
    for number in polygons:
        block = scene.fluid.blocks[number]
        where = f"fluid.blocks.{number}"
        faults += outline_faults(Outline("", tuple(map(tuple, block.points)), "inside"), where, size)
        if [block.low, block.high] != [np.min(block.points, axis=0).tolist(), np.max(block.points, axis=0).tolist()]:
            faults.append(SceneError("is given beside points", where=f"{where}.low, high", cure="one of the two"))
    if faults:
        return faults
    boundaries = boundaries_of(scene)
    where = {number: scene.line_key(number) for number in range(len(names))}
    for boundary, _ in boundaries:
        faults += boundary.faults(where)
    return faults or _wrong_side(scene, boundaries)


def _excursion(scene, number, outline, motion):
    """Faults of a moving wall that leaves the domain."""
    size = np.array(scene.domain.size)
    if motion is None:
        return []
    points = np.array(outline.points, float)
    if isinstance(motion, Bulge):
        points = np.vstack([points, np.mean([motion.start, motion.end], axis=0)])
    for extreme in motion.extremes():
        moved = extreme.place(points)
        for vertex in np.flatnonzero(((moved < 0) | (moved > size)).any(axis=1)):
            place = ", ".join(f"{x:.4g}" for x in moved[vertex])
            why = f"it swings to ({place}) m"
            cure = "a shorter swing, or a larger domain.size"
            bulges = vertex == len(outline.points)
            where = f"{scene.line_key(number)}.{'bulge.amplitude' if bulges else f'points.{vertex}'}"
            return [SceneError("leaves the domain", where=where, why=why, cure=cure)]
    return []


def _at_mirror(scene, point):
    """Whether a point lies on a side of the domain that is a mirror wall."""
    if not scene.mirrors:
        return False
    (x, y), (right, top), walls = point, scene.domain.size, scene.walls
    sides = (walls.left and x == 0, walls.right and x == right, walls.bottom and y == 0, walls.top and y == top)
    return any(sides)


def _near_mirror(scene, number, outline):
    """Faults of an obstacle that the images of a mirror wall would run into."""
    if outline.fluid != "outside":
        return []
    if not scene.mirrors:
        return []
    points, (right, top), walls = np.array(outline.points, float), scene.domain.size, scene.walls
    gaps = {"left": points[:, 0], "right": right - points[:, 0], "bottom": points[:, 1], "top": top - points[:, 1]}
    for side, gap in gaps.items():
        if getattr(walls, side) is not None and gap.min() < scene.reach:
            why = f"the {side} wall mirrors the fluid, which would land in the obstacle"
            cure = f"at least {scene.reach:.4g} m away from it, or polygon walls in place of the mirror"
            where = f"walls.polygons.{number}.points.{int(gap.argmin())}"
            return [SceneError("an obstacle at a mirror wall", where=where, why=why, cure=cure)]
    return []


def _wrong_side(scene, boundaries):
    """Faults of fluid behind walls, and of open walls that end in the fluid."""
    faults, dx = [], scene.numerics.dx
    shapes = [_shape(block) for block in scene.fluid.blocks]
    for number, shape in enumerate(shapes):
        for other in range(number):
            if (scene.fluid.blocks[number].points or scene.fluid.blocks[other].points) and shape.intersection(
                shapes[other]
            ).area > 0.5 * dx**2:
                where = f"fluid.blocks.{number}"
                faults.append(SceneError(f"overlaps block {other}", where=where, cure="blocks may touch, not overlap"))
    for boundary, _ in boundaries:
        for number, outline in boundary.outlines.items():
            at = scene.line_key(number)
            for other, shape in enumerate(shapes):
                area, place = boundary.behind(number, shape)
                if area > 1e-6 * dx**2:
                    vertex = outline.nearest_vertex(place)
                    why = f"{area:.4g} m^2 of it lie behind {outline.name!r}, near its point {vertex}"
                    cure = f'another block, or another `fluid` than "{outline.fluid}" at {at}'
                    faults.append(SceneError("fluid on the wrong side", where=f"fluid.blocks.{other}", why=why, cure=cure))
            for vertex in boundary.ends_in(number, shapes):
                if _at_mirror(scene, outline.points[vertex]):
                    continue
                why = "the fluid flows round its end"
                cure = "end it above the water or at another wall, or close it: an obstacle is a polygon"
                faults.append(SceneError("an open wall ends in the fluid", f"{at}.points.{vertex}", why, cure))
    return faults
