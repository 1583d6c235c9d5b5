"""What a scene will model, what not, and what it will cost."""

import math

import numpy as np
from rich.table import Table
from rich.text import Text

from ..moments import MOMENTS
from ..particles import Layout
from ..progress import console, duration, size_text
from ..states import EQUATIONS
from ..stepping import INTEGRATORS
from ..terms import FILTERS
from ..walls import INTERPOLATORS, TREATMENTS
from .build import borders_of, state_of, terms_of, walls_of
from .limits import step_of
from .movers import describe_maker
from .schema import GAUGE_KINDS
from .solids import fillings_of, markers_of, motions_of, outlines_of
from .zones import describe_zone

# Time of one pair candidate with its share of the step [s], float64, measured in `verify pool` on a 2.4 GHz AVX2 core.
SECONDS_PER_CANDIDATE = 2.8e-9
GRADIENTS = 1.4  # of the same with renormalised gradients
DIVERGENCE = 1.2  # of the same with a renormalised divergence
STRAIN_RATES = 1.7  # of the same with newtonian viscosity
CORRECTION_PASS = 2.5  # of the same with a corrected kernel, its pass included
SECONDS_PER_GHOST = 2.0e-7  # hydrostatic interpolation, half of the ghosts dry
SECONDS_PER_STEP = 1.0e-4  # what a step costs without particles, measured by `bench`
BYTES_PER_SNAPSHOT_PARTICLE = {"float64": 89, "float32": 49}
MOMENT_NUMBERS = 16  # of a particle in snapshots with moments


def costs(scene):
    """Return {quantity: number}: particles, bytes, steps, evaluations, core seconds, disk bytes of a scene."""
    layout = Layout(scene.dim, scene.features)
    particles = sum(filling.about for filling in fillings_of(scene))
    step = step_of(scene)
    steps = math.ceil((scene.time.end + scene.time.settle) / step)
    evaluations = particles * steps * INTEGRATORS[scene.numerics.integrator].evaluations
    candidates = (3 * scene.reach / scene.numerics.dx) ** scene.dim
    precision = 0.72 if scene.numerics.precision == "float32" else 1.0
    passes = GRADIENTS if scene.numerics.diffusion == "antuono" else 1.0
    passes *= DIVERGENCE if scene.numerics.density == "renormalised" else 1.0
    passes *= STRAIN_RATES if scene.numerics.viscosity == "newtonian" else 1.0
    passes *= CORRECTION_PASS if scene.numerics.kernel_correction != "none" else 1.0
    length = sum(math.dist(*edge) for wall in outlines_of(scene, motions_of(scene)) for edge in wall.edges)
    ghosts = length * scene.reach / scene.numerics.dx**2
    saved = scene.output.snapshots
    size = BYTES_PER_SNAPSHOT_PARTICLE[saved.precision]
    size += MOMENT_NUMBERS * np.dtype(saved.precision).itemsize if saved.moments else 0
    snapshots = 1 + int(scene.time.end / scene.snapshot_interval) if scene.snapshot_interval else 0
    return {
        "particles": particles,
        "bytes": particles * layout.bytes_per_particle(),
        "step": step,
        "steps": steps,
        "evaluations": evaluations,
        "core seconds": evaluations * candidates * SECONDS_PER_CANDIDATE * precision * passes
        + steps * (SECONDS_PER_STEP + ghosts * SECONDS_PER_GHOST),
        "snapshots": snapshots,
        "disk": snapshots * particles * size,
    }


def print_plan(scene, name):
    """Print the plan of a scene."""
    out = console()
    out.print(f"{name}: {scene.title}")
    table = Table("modelled", "as", "source", show_lines=False)
    omitted = []
    for family, term in terms_of(scene).families:
        if term.code:
            table.add_row(family, Text(term.equation, style="not bold"), term.source)
        else:
            omitted.append(family)
    state, n = state_of(scene), scene.numerics
    equation, _, source = EQUATIONS[state.name].partition("   ")
    table.add_row("state", equation, source.strip("[]"))
    table.add_row(
        "kernel",
        f"{scene.kernel.name}, h/dx = {n.h_over_dx:g}, support {scene.kernel.support:g} h",
        scene.kernel.source,
    )
    equation, _, source = INTEGRATORS[n.integrator].equation.partition("   ")
    table.add_row("time", equation, source.strip("[]"))
    for wall in walls_of(scene):
        treatment = TREATMENTS["mirror-plain" if wall.law == "plain" else "mirror"]
        slides = f", slides with ({', '.join(f'{v:g}' for v in wall.velocity)}) m/s" if wall.velocity else ""
        table.add_row(f"{wall.name} wall", f"{treatment.description}, {wall.slip} slip{slides}", treatment.source)
    if scene.walls.exchange:
        table.add_row("exchange", "fluid behind a mirror wall changes places with its image", "Szmidt (2013)")
    for axis, border in zip(scene.periodic, borders_of(scene), strict=True):
        table.add_row("periodic", f"{axis}, every {border.period:g} m", "")
    treatment = scene.treatment
    if scene.lines and treatment.family == "ghosts":
        each = INTERPOLATORS[scene.walls.interpolation]
        table.add_row("mirror points", f"{each.name}: {each.equation}", each.source)
    markers = markers_of(scene)
    if markers:
        each = markers.weights
        if each:
            table.add_row("deficiency", f"{each.name}: {each.equation}", each.source)
        law = markers.repulsion
        if law.code:
            strength = markers.push * scene.walls.markers_per_dx ** (scene.dim - 1)
            reach = f"K = {strength:.3g} m^2/s^2, R = {markers.push_reach:.3g} m"
            table.add_row("repulsion", f"{law.name}: {law.equation}; {reach}", law.source)
        table.add_row("markers", f"{markers.count:,}, {markers.spacing:.3g} m apart", "")
    for wall, name in zip(scene.lines, scene.wall_names, strict=True):
        parts = [treatment.description, f"{len(wall.points)} points", f"fluid {wall.fluid}"]
        parts += [f"{wall.slip} slip"] * (treatment.family == "ghosts") + ["moves"] * (wall.motion is not None)
        parts += ["bulges"] * (wall.bulge is not None)
        table.add_row(f"wall {name}", ", ".join(parts), treatment.source)
    if n.reinitialise != "none":
        law = FILTERS[n.reinitialise]
        table.add_row("densities anew", f"{law.equation}, every {n.reinitialise_every} steps", law.source)
    if scene.output.snapshots.moments:
        names = ", ".join(moment.name for moment in MOMENTS)
        table.add_row("in snapshots", f"moments of the plain kernel: {names}", "Szmidt (2013) eqs. (23), (24)")
    if scene.time.settle:
        table.add_row("settling", f"{scene.time.settle:g} s before t = 0, velocities decaying", "")
    if scene.wavemaker:
        table.add_row("wavemaker", *describe_maker(scene))
    for body in scene.bodies:
        parts = [f"{body.mass:g} kg/m"] + [f"spring {body.stiffness:g} N/m^2"] * (body.stiffness > 0)
        parts += [f"damper {body.damping:g} N s/m^2"] * (body.damping > 0) + [f"friction {body.friction:g} N/m"] * (
            body.friction > 0
        )
        parts += [f"moves from {body.threshold:g} times the force of still water on"] * (body.threshold > 1)
        table.add_row(f"body {body.wall}", ", ".join(parts), "Huang et al. section 4.4")
    for zone in scene.relaxation:
        table.add_row(f"{zone.side} relaxation", *describe_zone(scene, zone))
    for zone in scene.damping:
        what = "velocity" if zone.density == "none" else f"velocity and density ({zone.density})"
        parts = [f"{zone.length:g} m", zone.profile, f"damps {what}"]
        parts += [f"switch {zone.switch}"] * (zone.switch != "none") + [f"force times {zone.killing}"] * (
            zone.killing != "none"
        )
        table.add_row(f"{zone.side} layer", ", ".join(parts), "Molteni et al. eqs. (2.3), (2.4), section 2")
    for kind in GAUGE_KINDS:
        count = sum(gauge.kind == kind for gauge in scene.gauges)
        if count:
            table.add_row("gauges", f"{count} x {kind}", "")
    out.print(table)
    if scene.wavemaker is None:
        omitted.append("wavemaker")
    if not scene.damping:
        omitted.append("absorbing layer")
    if not scene.relaxation:
        omitted.append("relaxation zone")
    out.print(f"not modelled, not stored, not swept: {', '.join(omitted) or 'nothing'}")
    fields = Layout(scene.dim, scene.features).fields
    cost = costs(scene)
    out.print(f"fields: {', '.join(f'{field.name} [{state.unit(field)}]' for field in fields)}")
    out.print(
        f"{cost['particles']:,} particles, {size_text(cost['bytes'])} of memory; {cost['steps']:,} steps of "
        f"{cost['step']:.3g} s, {cost['evaluations']:.3g} evaluations; "
        f"{cost['snapshots']} snapshots, {size_text(cost['disk'])} on disk"
    )
    out.print(
        f"expected: {duration(cost['core seconds'])} on one core, at {SECONDS_PER_CANDIDATE * 1e9:g} ns per pair candidate "
        f"({n.precision} pairs; a 2.4 GHz core with AVX2 - measure yours with parsph bench)"
    )
