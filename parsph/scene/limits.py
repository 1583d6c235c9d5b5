"""How large a scene may be: what is too large is refused in words, before it costs time or memory.

Everything here is worked out from the scene's numbers; nothing grows with the particles.
"""

import math

from ..errors import SceneError
from ..memory import memory_here
from ..particles import Layout
from ..progress import size_text
from ..stepping import time_step_limit
from .schema import SIDES

MOST_PARTICLES = 2**31 - 2  # rows of a rank are numbered by int32
MOST_CELLS = 2**30
MOST_WALL, MOST_WALL_POINTS = 1e6, 5000  # particle spacings along all walls that are lines, and their vertices
MOST_RAYS = 2e8  # from spacings to vertices: seconds of checks
MOST_STEPS = 1e10  # ten days of steps without particles
MOST_SNAPSHOTS = 1e6
MOST_READINGS = 10_000  # points that one pressure gauge averages over
GROWTH = 1.15  # arrays have more room than particles
BYTES_PER_CELL = 17


def box_count(block, dx):
    """Return how many particles at the spacing `dx` [m] fill the box around a block."""
    return math.prod(max(high - low, 0.0) / dx for low, high in zip(block.low, block.high, strict=True))


def particle_count(scene):
    """Return about how many particles a scene has, from the areas of its blocks; what stands in them is not taken off."""
    dx, count = scene.numerics.dx, 0.0
    for block in scene.fluid.blocks:
        count += abs(_area(block.points)) / dx**2 if block.points else box_count(block, dx)
    return count


def _area(points):
    """Return the area of a polygon, positive where its vertices run counter-clockwise."""
    following = [*points[1:], points[0]]
    return 0.5 * sum(x * z_next - x_next * z for (x, z), (x_next, z_next) in zip(points, following, strict=True))


def cell_count(scene):
    """Return about how many cells the grid has."""
    extents = list(scene.domain.size)
    extents[0] += sum(max(map(abs, body.stops)) for body in scene.bodies if body.wall in SIDES)
    return math.prod(extent / scene.reach + 4 for extent in extents)


def memory_of(scene):
    """Return the bytes of memory that a scene needs at least, on all ranks together."""
    row = GROWTH * Layout(scene.dim, scene.features).bytes_per_particle()
    return row * particle_count(scene) + BYTES_PER_CELL * cell_count(scene)


def size_faults(scene):
    """Return what is too large in a scene whose vectors have as many components as it has dimensions, a list of SceneError."""
    faults, dx = [], scene.numerics.dx
    counts = [box_count(block, dx) for block in scene.fluid.blocks]
    for number, count in enumerate(counts):
        if count > MOST_PARTICLES:
            cure = f"a larger numerics.dx than {dx} m, or a smaller block"
            what = f"holds {count:.3g} particles, more than 2e9"
            faults.append(SceneError(what, where=f"fluid.blocks.{number}", cure=cure))
    if not faults and sum(counts) > MOST_PARTICLES:
        cure = f"a larger numerics.dx than {dx} m, or smaller blocks"
        faults.append(SceneError(f"hold {sum(counts):.3g} particles, more than 2e9", where="fluid.blocks", cure=cure))
    cells = cell_count(scene)
    if cells > MOST_CELLS:
        cure = "a smaller domain.size or a larger numerics.dx"
        what = f"the domain has {cells:.3g} cells, more than 1e9"
        faults.append(SceneError(what, where="domain.size", cure=cure))
    return faults + _wall_faults(scene)


def _wall_faults(scene):
    """What is too large in the walls that are lines."""
    spacings = sum(_length(wall.points, wall.fluid in ("inside", "outside")) for wall in scene.lines) / scene.numerics.dx
    points = sum(len(wall.points) for wall in scene.lines)
    where = "walls.polygons" if scene.walls.polygons else "walls.treatment"
    if points > MOST_WALL_POINTS:
        return [SceneError(f"{points:,} points in all", where=where, cure=f"at most {MOST_WALL_POINTS:,}")]
    if spacings > MOST_WALL or spacings * points > MOST_RAYS:
        most = min(MOST_WALL, MOST_RAYS / points)
        what = f"the walls are {spacings:.3g} particle spacings long, more than {most:.3g}"
        cure = f"a numerics.dx of at least {spacings / most * scene.numerics.dx:.3g} m, mirror walls, or lines of fewer points"
        return [SceneError(what, where=where, cure=cure)]
    return []


def _length(points, closed):
    following = [*points[1:], points[0]] if closed else points[1:]
    return sum(math.dist(a, b) for a, b in zip(points, following, strict=False))


def step_of(scene):
    """Return the time step [s] that a scene begins with."""
    nu = scene.numerics.nu or 0.0
    return scene.time.dt or time_step_limit(scene.h, scene.c0, abs(scene.gravity[-1]), scene.cfl, nu=nu)


def _intervals(scene):
    """Return {key: interval [s]} of what is written as a run goes on."""
    intervals = {f"gauges.{number}.every": gauge.every for number, gauge in enumerate(scene.gauges)}
    return intervals | {"output.snapshots.every": scene.snapshot_interval} if scene.snapshot_interval else intervals


def time_faults(scene):
    """Return what would take, or write, more than can be meant, in a scene whose sound speed is right, a list of SceneError."""
    end, step, faults = scene.time.end, step_of(scene), []
    if end + scene.time.settle > MOST_STEPS * step:
        what = f"takes {(end + scene.time.settle) / step:.3g} steps of {step:.3g} s, more than {MOST_STEPS:g}"
        cure = f"at most {MOST_STEPS * step:.3g} s"
        faults.append(SceneError(what, where="time.end" if end > scene.time.settle else "time.settle", cure=cure))
        return faults
    for key, every in _intervals(scene).items():
        most = MOST_SNAPSHOTS if key == "output.snapshots.every" else MOST_STEPS
        if end > most * every:
            what = f"every {every:g} s makes {end / every:.3g} {'files' if most == MOST_SNAPSHOTS else 'rows'} up to {end:g} s"
            faults.append(SceneError(f"{what}, more than {most:g}", where=key, cure=f"at least {end / most:.3g} s"))
    return faults


def size_doubts(scene):
    """Return what is no fault of a scene's size, and may still not be wanted: lines of text."""
    doubts, needed, here, step = [], memory_of(scene), memory_here(), step_of(scene)
    if needed > here:
        doubts.append(
            f"numerics.dx: about {particle_count(scene):.3g} particles need {size_text(needed)} of memory; this machine has "
            f"{size_text(here)}; a larger dx, or {math.ceil(needed / here)} such machines"
        )
    for key, every in _intervals(scene).items():
        if scene.time.end > every and every < 0.1 * step:
            doubts.append(f"{key}: {every:g} s is less than a tenth of a step, {step:.3g} s, and steps are shortened to it")
    return doubts


def refuse_too_large(scene, communicator):
    """Refuse a scene that does not fit into the memory of the machines of a job; collective.

    Raises
    ------
    SceneError
        With what it needs, what there is, and what would fit.
    """
    machines = communicator.allgather(communicator.node_rank).count(0)
    needed, here = memory_of(scene), communicator.minimum(memory_here())
    if needed > machines * here:
        what = f"about {particle_count(scene):.3g} particles at {scene.numerics.dx:g} m need {size_text(needed)} of memory"
        why = f"{machines} machine(s) with {size_text(here)} run it"
        cure = f"a larger dx, or {math.ceil(needed / here)} such machines"
        raise SceneError(what, where="numerics.dx", why=why, cure=cure)
