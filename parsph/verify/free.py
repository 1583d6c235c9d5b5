"""Hard cases without weight: suction that tears, a drop that stretches, drops that collide, a jet that is turned, vortices."""

import math

import numpy as np

from ..io.gauges import EnergyGauge, ForceGauge, PressureGauge
from ..scene.initial import flow_of
from .hard import energy_rows, missing, momentum_of, momentum_row, record_of, survived
from .registry import case


@case
def patch(quick):
    """A square that turns about its middle, up to t omega = 4 (quick: 1, half the resolution): suction, and arms thrown out.

    Pressure in its middle against Colagrossi's series: at t = 0, and the mean up to t omega = 0.2, which sound has passed by
    twice. Shifting adds to the angular momentum.
    """
    scene, simulation = survived("square-patch", {"numerics.dx": 0.02, "time.end": 1.0} if quick else {})
    flow = flow_of(scene, scene.fluid.blocks[0])
    t, pressure = record_of(simulation, PressureGauge).T
    theory = float(flow.pressure([flow.middle])[0])
    yield "pressure in the middle, t = 0", 100 * (pressure[0] / theory - 1), "%", 2.0
    early = pressure[t * flow.rate <= 0.2]
    yield "pressure in the middle, mean up to t omega = 0.2", 100 * (early.mean() / theory - 1), "%", None
    yield from missing(simulation)
    yield from energy_rows(simulation)
    yield from momentum_row(simulation)
    spin = simulation.field("mass").sum() * flow.extents[0] ** 2 / 6 * flow.rate
    yield "angular momentum, change", 100 * (momentum_of(simulation)[1] / spin - 1), "%", None


@case
def drop(quick):
    """A round drop that stretches to A t = 0.75, 25, 50 and 100 particles per radius (quick: 25): half axes, Monaghan (1994).

    The half axes are those of the ellipse with the second moments of the particles, twice the root of the mean square; for the
    long one that of its outermost particle too, half a spacing further. At 100 per radius what is left is that the drop begins
    compressed by 0.1 % of its area, by the pressure in it.
    """
    errors = {}
    for per_radius in (25,) if quick else (25, 50, 100):
        scene, simulation = survived("elliptical-drop", {"numerics.dx": 1.0 / per_radius})
        flow = flow_of(scene, scene.fluid.blocks[0])
        _, *theory = flow.at(simulation.end)
        position = simulation.field("position")
        axes = flow.half_axes(position)
        tip = np.abs(position[:, 1] - flow.middle[1]).max() + 0.5 * scene.numerics.dx
        size, bar = f"{per_radius} per radius", 1.0 if per_radius == 50 or quick else None
        errors[per_radius] = np.abs(axes / theory - 1).max()
        yield f"short half axis, {size}", 100 * (axes[0] / theory[0] - 1), "%", bar
        yield f"long half axis, {size}", 100 * (axes[1] / theory[1] - 1), "%", bar
        yield f"long half axis to its tip, {size}", 100 * (tip / theory[1] - 1), "%", bar
        yield from missing(simulation)
        if per_radius == 50 or quick:
            yield from energy_rows(simulation)
            yield from momentum_row(simulation)
    if not quick:
        yield "order of convergence of the half axes", math.log2(errors[25] / errors[50]), "25 to 50", None
        yield "order of convergence of the half axes", math.log2(errors[50] / errors[100]), "50 to 100", None


@case
def drops(quick):
    """Two drops collide head on (quick: half the resolution): jets of five times their speed at right angles."""
    _, simulation = survived("colliding-drops", {"numerics.dx": 0.04} if quick else {})
    yield from missing(simulation)
    yield from energy_rows(simulation)
    yield from momentum_row(simulation)


@case
def jet(quick):
    """A jet is turned by a corner (quick: the same, as ten particles across it are too few): force on the plate across it, and
    momentum along that plate, from the time when the jet stands until it ends: both rho U^2 times its thickness.
    """
    scene, simulation = survived("jet-corner")
    block = scene.fluid.blocks[0]
    theory = scene.fluid.rho0 * block.velocity[0] ** 2 * (block.high[1] - block.low[1])
    t, force, *_ = record_of(simulation, ForceGauge).T
    late = t >= 0.5 * scene.time.end
    yield "force on the plate, mean", 100 * (force[late].mean() / theory - 1), "%", 3.0
    energy = record_of(simulation, EnergyGauge)
    late = energy[:, 0] >= 0.5 * scene.time.end
    rate = np.polyfit(energy[late, 0], energy[late, -1], 1)[0]
    yield "rate of momentum along the plate", 100 * (rate / theory - 1), "%", 5.0
    yield from missing(simulation)
    yield from energy_rows(simulation)


@case
def taylor_green(quick):
    """Taylor-Green vortices, Re = 100, 50 and 100 particles per edge (quick: 50): rate at which the kinetic energy decays up to
    t = 2 L/U, when 4 % of it are left, and the largest error of any particle's velocity at the end.
    """
    for per_edge in (50,) if quick else (50, 100):
        scene, simulation = survived("taylor-green", {"numerics.dx": 1.0 / per_edge})
        flow = flow_of(scene, scene.fluid.blocks[0])
        t, _, kinetic, *_ = record_of(simulation, EnergyGauge).T
        rate = -0.5 * np.polyfit(t, np.log(kinetic), 1)[0]
        exact = flow.velocity(simulation.field("position"), simulation.time)
        off = np.linalg.norm(simulation.field("velocity") - exact, axis=1).max() / np.linalg.norm(exact, axis=1).max()
        size = f"{per_edge} per edge"
        yield f"decay rate, {size}", 100 * (rate / flow.decay - 1), "%", 5.0
        yield f"velocity at the end, {size}", 100 * off, "% of the largest", None
        yield from missing(simulation)
        yield from energy_rows(simulation)
