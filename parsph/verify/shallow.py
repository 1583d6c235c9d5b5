"""Shallow water in one dimension."""

import itertools

import numpy as np

from ..analysis import reflection_ratio
from ..waves import DamBreak, layer_reflection
from .registry import case
from .runs import run_scene


@case
def swe_pulse(quick):
    """A hump on shallow water and hyperbolic layers of 10 to 200 m: reflection ratio, Molteni et al. eq. (2.7), over theory."""
    runs = {name: _profile(f"swe-pulse-{name}", {}) for name in ("infinite", "reflecting")}
    ratios = {}
    for length in (20, 50) if quick else (10, 20, 50, 100, 200):
        far = 500.0 + length
        overrides = {"domain.size": [far], "fluid.blocks.0.high": [far], "damping.0.length": float(length)}
        scene, line = _profile("swe-pulse", overrides)
        window = 0.0, runs["reflecting"][0].domain.size[0]
        gravity = scene.domain.gravity
        ratios[length] = reflection_ratio(line, runs["reflecting"][1], runs["infinite"][1], gravity, window)
        zone = scene.damping[0]
        theory = layer_reflection(scene.c0 / length, length, scene.c0, zone.profile, softening=zone.softening)
        yield f"reflection ratio, L = {length} m", ratios[length], "", None
        bar = 1.5 if length in (20, 50) else None
        yield (
            f"factor off theory ({theory:.2e}), L = {length} m",
            max(ratios[length] / theory, theory / ratios[length]),
            "",
            bar,
        )
    values = list(ratios.values())
    yield "monotone in L: largest ratio to the next shorter layer", max(b / a for a, b in itertools.pairwise(values)), "", 1.0


def _profile(source, overrides):
    """Run a 1D scene; return it and its last state as {field: array}."""
    scene, simulation = run_scene(source, overrides)
    fields = {name: simulation.field(name) for name in ("id", "position", "velocity", "density", "mass")}
    return scene, {name: values[:, 0] if values.ndim == 2 else values for name, values in fields.items()}


@case
def swe_dam_break(quick):
    """Dams of 1 m break over wet (r = 0.5, 0.1) and dry ground, 1000 (dry: 500) particles, against Stoker and Ritter.

    L1: sum of |h - exact| over sum of exact, on the interval that the waves have reached. The bore is where the depth falls
    through the mean of its two sides.
    """
    for right in (0.5, 0.1, 0.0):
        if right:
            overrides = {"fluid.blocks.1.depth": right}
        scene, line = _profile("swe-dam-break", overrides) if right else _profile("swe-dam-break-dry", {})
        exact = DamBreak(1.0, right, scene.domain.gravity)
        order, t = np.argsort(line["position"]), scene.time.end
        x, depth = line["position"][order] - 500.0, line["density"][order]
        place = np.linspace(-1.1 * scene.c0, 1.1 * exact.bore, 2001) * t
        place = place[np.abs(place) < 500.0]
        truth = exact.depth(place, t)
        error = np.abs(np.interp(place, x, depth, right=0.0) - truth).sum() / truth.sum()
        ground = f"r = {right:g}" if right else "dry"
        yield f"depth, L1 error, {ground}", 100 * error, "%", 1.0
        if right:
            middle = 0.5 * (right + exact.depth(np.array([0.999 * exact.bore * t]), t)[0])
            last = np.flatnonzero((depth[:-1] > middle) & (depth[1:] <= middle))[-1]
            front = np.interp(-middle, -depth[last : last + 2], x[last : last + 2])
            yield f"bore, place, {ground}", 100 * (front / (exact.bore * t) - 1), "%", 1.0
