"""Wall treatments: plain and hydrostatic mirrors, the solved strip, markers with and without correction."""

import math

import numpy as np

from ..parallel import Communicator
from ..residuals import WallPieces, largest, residual_accelerations, root_mean_square
from ..scene.build import build
from ..scene.load import load_scene
from ..study.metrics import rms
from ..waves import Seiche
from .registry import case
from .runs import run_scene


@case
def strip(quick):
    """Szmidt's walls: eq. (32) at wall points of a basin, a polygon and a curve; the lowest row of a seiche after 5 periods
    (quick: 2) at plain and at hydrostatic mirrors; mirrors and strip after 2 periods (quick: 1), Gaussian, h = 4d/3.

    In corners: RMS of the velocity off eq. (43) within 3 h of both walls, over that further than 3 h from all walls.
    """
    shapes = {
        "basin": ("seiche", {}),
        "polygon": ("wedge-tank", {}),
        "curve": ("tank-ellipse", {"numerics.dx": 0.1}),
    }
    for name, (source, overrides) in shapes.items():
        keys = {"walls.treatment": "strip", "numerics.h_over_dx": 1.33, "numerics.density_range": [0.1, 10.0], "gauges": []}
        worst = _normal_velocity(load_scene(source, {**keys, **overrides}))
        yield f"normal velocity at wall points, largest, {name}", worst, "of the fluid's", 1e-10
    for treatment in ("mirror", "mirror-plain"):
        keys = {"walls.treatment": treatment, "walls.exchange": True, "gauges": [], **({"time.end": 1.0} if quick else {})}
        scene, simulation = run_scene("seiche", keys)
        row = np.sort(simulation.field("position")[:, 1])[: round(0.2 / scene.numerics.dx)].mean() / scene.numerics.dx
        if treatment == "mirror":
            yield "seiche, mirror: lowest row off dx/2", row - 0.5, "dx", 0.05
        else:
            yield "seiche, mirror-plain: height of the lowest row, which begins at dx/2", row, "dx", 0.4
        exchanged = sum(wall.exchanged for wall in simulation.domain.walls)
        yield f"seiche, {treatment}: exchanges with images", exchanged, "", None
    ratios = {}
    for treatment in ("mirror", "strip"):
        errors = _seiche_errors(treatment, 1 if quick else 2)
        for place, error in errors.items():
            yield f"seiche, {treatment}: velocity off theory, {place}", 100 * error, "% of its largest", None
        ratios[treatment] = errors["corners"]
    yield "seiche: error in corners, mirror over strip", ratios["mirror"] / ratios["strip"], "", 1.0


def _normal_velocity(scene):
    """Return the largest normal velocity that is interpolated at wall points in the water, fluid stirred, over the fluid's."""
    simulation = build(scene, Communicator())
    p, generator = simulation.particles, np.random.default_rng(1)
    owned = slice(p.first, p.last)
    p.shared[owned, 2:4] = generator.normal(0.0, 1.0, (p.last - p.first, 2))
    simulation.evaluate(0.0)
    ghosts, rows = simulation.domain.ghosts, slice(p.first, p.last)
    x, v = p.field("position", rows), p.field("velocity", rows)
    volume, h = p.field("mass", rows) / p.field("density", rows), simulation.sweep.h
    standing = np.zeros(ghosts.count, bool)
    standing[ghosts.share.standing] = True
    points, worst = 0.5 * (ghosts.position + ghosts.mirror), 0.0
    for k in np.flatnonzero(standing):
        reach = np.linalg.norm(ghosts.position - points[k], axis=1) < simulation.sweep.kernel.support * h
        if standing[reach].all():  # beyond the end of an open wall some ghosts have no place in the grid
            weight = volume * simulation.sweep.kernel.value(np.linalg.norm(x - points[k], axis=1), h, 2)
            worst = max(worst, abs(float(weight @ (v @ ghosts.direction[k]))))
    return worst / np.abs(v).max()


def _seiche_errors(treatment, periods):
    """Return {place: RMS of the velocity off the theory over its largest} at the end, when the theory's is at its largest."""
    keys = {"numerics.kernel": "gaussian", "numerics.h_over_dx": 4 / 3, "walls.treatment": treatment, "gauges": []}
    scene = load_scene("seiche", keys)
    theory = Seiche(0.2, 0.2, scene.fluid.blocks[0].amplitude, scene.domain.gravity)
    end = periods * 2 * math.pi / theory.frequency
    _, simulation = run_scene(scene.model_dump(), {"time.end": end})
    x, v = simulation.field("position"), simulation.field("velocity")
    mode = theory.velocity(x)
    off = np.linalg.norm(v - (v * mode).sum() / (mode**2).sum() * mode, axis=1) / np.linalg.norm(mode, axis=1).max()
    side, bed = np.minimum(x[:, 0], 0.2 - x[:, 0]), x[:, 1]
    wide = 3 * scene.h
    corner, inside = (side < wide) & (bed < wide), (side > wide) & (bed > wide)
    return {"corners": rms(off[corner]), "inside": rms(off[inside])}


@case
def deficiency(quick):
    """Markers: what is left of accelerations of fluid at rest, Jones et al. Figs. 3, 5, 7, 8; still water, 10 s (quick: 2 s).

    Residual: RMS over particles within the support radius of a wall, over the same without walls. Kinetic energy: mean of the
    last third over that of the first.
    """
    for source, name, bar in (
        ("column-1d", "1D", 0.1),
        ("column", "water column", None),
        ("tank-rectangle", "rectangle", 0.1),
        ("tank-ellipse", "ellipse", 0.2),
    ):
        left = {}
        for weights in ("moments", "jones2010"):
            found = residual_accelerations(source, {"walls.repulsion": "none", "walls.weights": weights})
            for place, rows in found.places.items():
                if rows.any():
                    before, after = found.before[rows], found.after[rows]
                    left[place, weights] = root_mean_square(after) / root_mean_square(before)
                    limit = bar if weights == "moments" and place == "walls" else None
                    yield f"{name}: residual at {place}, {weights}", left[place, weights], "of that without", limit
                    yield f"{name}: largest at {place}, {weights}", largest(after) / largest(before), "of that without", None
        if ("corners", "moments") in left:
            gain = left["corners", "moments"] / left["corners", "jones2010"]
            yield f"{name}: residual at corners, moments over jones2010", gain, "", 0.5
    for treatment in ("deficiency", "repulsion"):
        scene, simulation = run_scene("still", {"walls.treatment": treatment, "time.end": 2.0 if quick else 10.0})
        corrected = treatment == "deficiency"
        lost = int((WallPieces(scene, simulation.time).distances(simulation.field("position")) < 0).sum())
        yield f"still water, {treatment}: particles lost", lost, "", 0.0 if corrected else None
        energy = next(gauge.record() for gauge in simulation.observers if "kinetic energy [J]" in gauge.columns)
        kinetic = energy[:, 2] / energy[:, 3]
        third = len(kinetic) // 3
        decay = kinetic[-third:].mean() / kinetic[:third].mean()
        yield f"still water, {treatment}: kinetic energy, last over first third", decay, "", 1.0 if corrected else None
        yield f"still water, {treatment}: kinetic over potential energy, largest", kinetic.max(), "", None
        yield f"still water, {treatment}: kinetic over potential energy at the end", kinetic[-third:].mean(), "", None
