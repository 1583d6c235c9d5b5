"""Viscous flows in a channel without ends, against theory at every time."""

import numpy as np

from ..parallel import Communicator
from ..scene.build import build
from ..scene.load import load_scene
from .registry import case

TERMS = 200  # of the series
SAMPLED = 20  # steps
DISORDER = 0.1  # spacings
EARLIEST = 0.02  # L^2/nu: before, the layer at a wall that starts with a jerk is thinner than three smoothing lengths


def poiseuille_profile(x, time, width, nu, gravity):
    """Return the velocity [m/s] at `x` [m] between walls at 0 and `width` [m], from rest at t = 0, driven by `gravity` [m/s^2].

    ``v = g x (L - x)/(2 nu) - sum over odd n of 4 g L^2/(nu (pi n)^3) sin(pi n x/L) exp(-(pi n)^2 nu t/L^2)``,
    Morris et al. (1997) eq. (36). `time` [s] may be infinite.
    """
    n = np.pi * np.arange(1, 2 * TERMS, 2)[:, None]
    series = 4 * gravity * width**2 / (nu * n**3) * np.sin(n * x / width) * np.exp(-(n**2) * nu * time / width**2)
    return gravity * x * (width - x) / (2 * nu) - series.sum(axis=0)


def couette_profile(x, time, width, nu, speed):
    """Return the velocity [m/s] at `x` [m] between a wall at rest at 0 and one that slides with `speed` [m/s] at `width` [m].

    ``v = V x/L + sum over n of 2 V/(pi n) (-1)^n sin(pi n x/L) exp(-(pi n)^2 nu t/L^2)``, Morris et al. (1997) eq. (35).
    """
    n = np.arange(1, TERMS)[:, None]
    wave = np.pi * n
    series = 2 * speed / wave * (-1.0) ** n * np.sin(wave * x / width) * np.exp(-(wave**2) * nu * time / width**2)
    return speed * x / width + series.sum(axis=0)


@case
def poiseuille(quick):
    """Flow between walls at rest, driven by gravity, Re = 1, 40 particles across, against g x (L - x)/(2 nu).

    Not quick: 20 too, and 40 that begin in disorder. Errors are the largest of any particle.
    """

    def theory(scene, x, time):
        return -poiseuille_profile(x, time, scene.domain.size[0], scene.numerics.nu, scene.domain.gravity)

    yield from _profiles("poiseuille", theory, quick)


@case
def couette(quick):
    """Flow between a wall at rest and one that slides, Re = 1, 40 particles across, against V x/L; as `poiseuille`."""

    def theory(scene, x, time):
        return couette_profile(x, time, scene.domain.size[0], scene.numerics.nu, scene.walls.right.velocity[-1])

    yield from _profiles("couette", theory, quick)


def _profiles(name, theory, quick):
    others = () if quick else ((20, 0.0, None), (40, DISORDER, None))
    for across, disorder, bar in ((40, 0.0, 1.0), *others):
        scene = channel(name, across)
        simulation = build(scene, Communicator())
        shake(simulation, disorder * scene.numerics.dx)
        largest = np.abs(theory(scene, np.linspace(0, scene.domain.size[0], 101), np.inf)).max()
        earliest = EARLIEST * scene.domain.size[0] ** 2 / scene.numerics.nu
        transient = 0.0
        simulation.prepare()
        while simulation.time < simulation.end:
            simulation.advance()
            if simulation.time > earliest and (simulation.steps % SAMPLED == 0 or simulation.time == simulation.end):
                across_flow, along = simulation.field("velocity").T
                x = simulation.field("position")[:, 0]
                steady = np.abs(along - theory(scene, x, np.inf)).max()
                transient = max(transient, np.abs(along - theory(scene, x, simulation.time)).max())
        what = f"{across} across" + ", disordered" * (disorder > 0)
        yield f"profile error, steady, {what}", 100 * steady / largest, "% of the largest velocity", bar
        yield f"profile error, transient, {what}", 100 * transient / largest, "% of the largest velocity", None
        yield f"velocity across the flow, {what}", 100 * np.abs(across_flow).max() / largest, "% of the largest velocity", bar


def shake(simulation, distance):
    """Move all particles by up to `distance` [m] along each axis, always in the same way."""
    p = simulation.particles
    places = p.fluid, p.layout.columns("position")[1]
    p.shared[places] += np.random.default_rng(1).uniform(-distance, distance, p.shared[places].shape)


def channel(name, across):
    """Return a built-in channel with so many particles from wall to wall, as high as the periodic vertical needs."""
    scene = load_scene(name)
    width, height = scene.domain.size
    dx = width / across
    rows = max(round(height / dx), int(2 * scene.kernel.support * scene.numerics.h_over_dx) + 1)
    blocks = [{**scene.fluid.blocks[0].model_dump(exclude_unset=True), "high": [width, rows * dx]}]
    return load_scene(name, {"numerics.dx": dx, "domain.size": [width, rows * dx], "fluid.blocks": blocks})
