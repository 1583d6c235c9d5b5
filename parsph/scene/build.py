"""From a scene to a simulation: geometry, walls, particles, observers."""

import math

import numpy as np

from .. import parallel
from ..bodies import Absorber, MovableWall
from ..columns import Grid
from ..damping import DampingZone
from ..domain import Domain, balanced_cuts
from ..domain.domain import end_columns
from ..io.gauges import BodyGauge, DepthGauge, EnergyGauge, ForceGauge, LevelGauge, PowerGauge, PressureGauge, RunupGauge
from ..io.snapshots import SnapshotWriter
from ..io.tables import table_name
from ..moments import Correction, Moments
from ..particles import Layout, Particles
from ..reinitialisation import DensityFilter
from ..simulation import Simulation
from ..states import State
from ..stepping import INTEGRATORS
from ..sweep import Sweep
from ..terms import (
    CORRECTIONS,
    DENSITIES,
    DIFFUSIONS,
    FILTERS,
    NONE,
    SHIFTINGS,
    SMOOTHED_CONTINUITY,
    SPRAYS,
    TENSILE_CONTROLS,
    VISCOSITIES,
    XSPH,
    Terms,
)
from ..walls import MirrorWall, PeriodicBorder
from ..waves import dispersion, tuned_absorption
from .initial import fill
from .load import scene_text
from .movers import maker_of, place_of, relative_hinge, speed_of_waves
from .schema import ENDS, SIDES, SILL
from .solids import ascent_of, fillings_of, ghosts_of, markers_of, motions_of, still_force, surface_of
from .zones import relaxation_of

LONG = 0.3  # kd of the waves that absorption is tuned to where there is no period
SHORTEST_LAG = 0.02  # of an absorbing plate behind its gauge, over sqrt(d/g)
CENTERING = 60.0  # time within which an absorbing plate drifts back, over sqrt(d/g)


def build(scene, communicator=None, folder=None, checkpoint=None):
    """Return the `Simulation` of a scene, ready to run.

    Parameters
    ----------
    scene : Scene
        From `load_scene`.
    communicator : Communicator, optional
        Default: all ranks of the job.
    folder : Path, optional
        Where snapshots and gauge tables go; without one nothing is written, gauges keep their records in memory.
    checkpoint : Checkpoint, optional
        Where the particles come from in place of the scene's blocks; the rest of it is restored when all observers are there.

    Raises
    ------
    SceneError
        When there are too many ranks for the columns.
    """
    communicator = communicator or parallel.start()
    state = state_of(scene)
    maker = maker_of(scene)
    motions = motions_of(scene, maker)
    walls = walls_of(scene, motions)
    grid, box = grid_of(scene, motions)
    reach = scene.reach
    fillings = fillings_of(scene, communicator)
    counts = checkpoint.counts if checkpoint else sum(filling.column_counts(grid) for filling in fillings)
    cuts = _cuts(scene, counts, communicator.size)
    mine = cuts[communicator.rank], cuts[communicator.rank + 1]
    particles = Particles(Layout(scene.dim, scene.features))
    if checkpoint:
        checkpoint.fill(particles, *mine)
    else:
        fill(particles, scene, state, grid, fillings, *mine)
    n, terms = scene.numerics, terms_of(scene)
    particles.summed = n.density == "summation"
    if terms.correction is not NONE:
        particles.correction = np.zeros((len(particles.tags), Correction.width(scene.dim)))
    wetted = scene.domain.size[-1]
    lines = *ghosts_of(scene, state, motions), markers_of(scene, motions)
    domain = Domain(
        grid,
        particles,
        walls,
        reach,
        box,
        scene.gravity,
        state,
        wetted,
        communicator,
        cuts,
        *lines,
        exchanging=scene.walls.exchange,
        borders=borders_of(scene),
    )
    sweep = Sweep(
        scene.kernel,
        terms,
        scene.dim,
        scene.h,
        scene.rho0,
        scene.c0,
        scene.gravity,
        n.alpha,
        n.delta,
        n.xsph,
        n.shift,
        n.precision == "float32",
        n.h_over_dx,
        n.h_growth,
        1.0 if n.state == "linear" else n.gamma,
        n.nu or 0.0,
    )
    simulation = Simulation(
        domain,
        sweep,
        state,
        INTEGRATORS[n.integrator](),
        [_zone(scene, zone) for zone in scene.damping] + [relaxation_of(scene, zone, state) for zone in scene.relaxation],
        scene.time.end,
        scene.time.dt,
        scene.cfl,
        scene.density_range,
        DensityFilter(sweep, FILTERS[n.reinitialise], n.reinitialise_every) if n.reinitialise != "none" else None,
        scene.time.settle,
        Correction(sweep) if terms.correction is not NONE else None,
    )
    simulation.movers += movers_of(scene, maker, motions)
    simulation.observers += gauges_of(scene, folder, motions, simulation.movers)
    if folder is not None and scene.snapshot_interval:
        snapshots = scene.output.snapshots
        moments = Moments(sweep) if snapshots.moments else None
        simulation.observers.append(
            SnapshotWriter(folder, scene.snapshot_interval, scene_text(scene), snapshots.precision, moments)
        )
    return simulation


def cuts_of(scene, ranks, communicator=None):
    """Return the column cuts that a scene begins with on so many ranks; those of a `communicator` share the counting.

    Raises
    ------
    SceneError
        When there are too many ranks for the columns.
    """
    grid, _ = grid_of(scene)
    counts = sum(filling.column_counts(grid) for filling in fillings_of(scene, communicator))
    return _cuts(scene, counts, ranks)


def _cuts(scene, counts, ranks):
    _, ends = columns_of(scene)
    return balanced_cuts(counts, ranks, *ends)


def columns_of(scene):
    """Return the grid, and how many columns at its left and right end one rank must own together."""
    motions = motions_of(scene)
    grid, _ = grid_of(scene, motions)
    bands = [wall.band(scene.reach, scene.domain.size[-1]) for wall in walls_of(scene, motions)]
    bands += [band for border in borders_of(scene) for band in border.bands(scene.reach, scene.dim)]
    return grid, end_columns(grid, bands)


def state_of(scene):
    """Return the equation of state."""
    return State(scene.numerics.state, scene.rho0, scene.c0, scene.numerics.gamma)


def terms_of(scene):
    """Return the terms that the scene names."""
    n = scene.numerics
    return Terms(
        SMOOTHED_CONTINUITY if n.xsph_continuity else DENSITIES[n.density],
        VISCOSITIES[n.viscosity],
        DIFFUSIONS[n.diffusion],
        XSPH if n.xsph else NONE,
        TENSILE_CONTROLS[n.tensile_control],
        SHIFTINGS[n.shifting],
        SPRAYS[n.spray],
        CORRECTIONS[n.kernel_correction],
    )


def walls_of(scene, motions=None):
    """Return the mirror walls, side walls first; `motions` are those of `motions_of`."""
    motions = motions_of(scene) if motions is None else motions
    walls, size, sill = [], scene.domain.size, scene.sill
    law = "plain" if scene.walls.treatment == "mirror-plain" else "hydrostatic"
    for bit, (side, (axis, direction)) in enumerate(SIDES.items()):
        wall = getattr(scene.walls, side)
        if wall is None or not scene.mirrors:
            continue
        point, normal = [0.0] * scene.dim, [0.0] * scene.dim
        point[axis] = 0.0 if direction > 0 else size[axis]
        normal[axis] = float(direction)
        rest = tuple(point), tuple(normal), law, wall.slip
        velocity, span = tuple(wall.velocity or ()), (-math.inf, math.inf)
        if side == "left" and sill is not None:
            walls.append(MirrorWall(SILL, *rest, 1 << len(SIDES), span=(-math.inf, sill)))
            span = sill, math.inf
        walls.append(MirrorWall(side, *rest, 1 << bit, motions.get(side), velocity, span))
    return walls


def movers_of(scene, maker, motions):
    """Return what decides on the ways of walls as the run goes on."""
    movers = []
    for body in scene.bodies:
        motion, surface = motions[body.wall], surface_of(scene, body.wall)
        still = still_force(scene, surface, motion.direction)
        preload = still if body.preload is None else body.preload
        numbers = body.mass, body.stiffness, body.damping, body.friction, (body.threshold - 1.0) * abs(still), preload
        movers.append(MovableWall(body.wall, motion.signal, motion, surface, *numbers, body.start))
    if maker and maker.added:
        keys, gravity, depth = scene.wavemaker.absorption, scene.domain.gravity, scene.depth
        distance = keys.distance or scene.reach
        period = scene.wave_period or dispersion(depth, gravity, wavelength=2 * math.pi * depth / LONG).period
        gain, lag = tuned_absorption(period, depth, gravity, relative_hinge(scene), distance)
        centering = keys.centering or CENTERING * math.sqrt(depth / gravity)
        plate = maker.added, maker.motion, maker.expected, place_of(scene), distance, scene.level
        lag = keys.filter or max(lag, SHORTEST_LAG * math.sqrt(depth / gravity))
        movers.append(Absorber(*plate, gain, lag, centering, keys.acceleration or 0.5 * gravity))
    return movers


def borders_of(scene):
    """Return the periodic borders, that of x first; their bits are those of the sides that are not there."""
    bits = {side: 1 << bit for bit, side in enumerate(SIDES)}
    return [
        PeriodicBorder(axis, 0.0, float(scene.domain.size[axis]), tuple(bits[side] for side in ENDS[name]))
        for name, axis in scene.periodic.items()
    ]


def grid_of(scene, motions=None):
    """Return the grid and the box, (low, high) [m], that no particle may leave; `motions` are those of `motions_of`.

    Ghosts and markers stop the fluid by forces: a particle that hits them hard may be a little beyond before it comes back.
    """
    margin = scene.numerics.dx if scene.lines or not scene.mirrors else 0.0
    motions = motions_of(scene) if motions is None else motions
    low, high = [-margin] * scene.dim, [extent + margin for extent in map(float, scene.domain.size)]
    for side in scene.moved_sides:  # a spacing is added, since a particle may be anywhere at a plate at its farthest
        least, largest = motions[side].reach(scene.domain.size[-1])
        if side == "left":
            low[0] += min(least, 0.0) - scene.numerics.dx
        else:
            high[0] += max(largest, 0.0) + scene.numerics.dx
    box = tuple(low), tuple(high)
    return Grid.around(*box, scene.reach), box


def gauges_of(scene, folder, motions, movers):
    """Return the gauges, with their tables in `folder`."""
    gauges, size = [], scene.domain.size
    open_low, open_high = (-math.inf,) * scene.dim, (math.inf,) * scene.dim
    low, high = list(open_low), list(open_high)
    for side, (axis, direction) in SIDES.items():
        if getattr(scene.walls, side) is not None and side not in scene.moved_sides:
            (low if direction > 0 else high)[axis] = 0.0 if direction > 0 else size[axis]
    for number, gauge in enumerate(scene.gauges):
        head = table_name(gauge.name, gauge.kind, number), gauge.every
        if gauge.kind == "level" and scene.shallow:
            gauges.append(DepthGauge(*head, gauge.x, folder))
        elif gauge.kind == "level":
            place = (gauge.x,) if gauge.y is None else (gauge.x, gauge.y)
            gauges.append(LevelGauge(*head, place, (low, high), folder))
        elif gauge.kind == "pressure":
            gauges.append(PressureGauge(*head, _along(gauge, 0.5 * scene.numerics.dx), motions.get(gauge.wall), folder))
        elif gauge.kind == "force":
            gauges.append(ForceGauge(*head, *surface_of(scene, gauge.wall), motions.get(gauge.wall), gauge.about, folder))
        elif gauge.kind == "runup":
            gauges.append(RunupGauge(*head, ascent_of(scene, gauge), motions.get(gauge.wall), folder))
        elif gauge.kind == "body":
            body = next(mover for mover in movers if isinstance(mover, MovableWall) and mover.name == gauge.wall)
            gauges.append(BodyGauge(*head, body, folder))
        elif gauge.kind == "power":
            gauges.append(PowerGauge(*head, folder))
        else:
            gauges.append(EnergyGauge(*head, gauge.low or open_low, gauge.high or open_high, folder))
    return gauges


def _along(gauge, spacing):
    """Return the points [m] at which a pressure gauge reads, shape (n, dim), at most `spacing` [m] apart."""
    if gauge.extent is None:
        return np.array([gauge.point], float)
    extent = np.array(gauge.extent, float)
    count = max(1, math.ceil(np.linalg.norm(extent) / spacing))
    return np.array(gauge.point) + ((np.arange(count) + 0.5) / count - 0.5)[:, None] * extent


def _zone(scene, zone):
    left = zone.side == "left"
    state = state_of(scene)
    return DampingZone(
        start=zone.length if left else scene.domain.size[0] - zone.length,
        direction=-1 if left else 1,
        length=zone.length,
        sigma0=zone.sigma0 or (zone.v_ref or scene.c0) / zone.length,
        state=state.constants,
        profile=zone.profile,
        softening=zone.softening or 0.5 * scene.h,
        exponent=zone.exponent,
        switch=zone.switch,
        killing=zone.killing,
        density_factor=_density_factor(scene, zone),
        level=scene.level,
        weight=scene.fluid.rho0 * abs(scene.gravity[-1]),
        surface_pressure=float(state.pressure(scene.level)) if scene.shallow else 0.0,
    )


def _density_factor(scene, zone):
    """Return how much harder than the velocity a layer damps the density.

    A surface elevation eta decays with the volume that is lost below it. Damping the density by sigma_rho loses
    ``sigma_rho (c/c0)^2 eta`` of it, c the phase speed: matched when that is ``sigma eta``.
    """
    if zone.density != "matched" or scene.shallow:
        return 0.0 if zone.density == "none" else 1.0
    return (scene.c0 / speed_of_waves(scene, scene.wave_period)) ** 2
