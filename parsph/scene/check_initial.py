"""What the fluid can begin with: the keys of its initial flow, and the scene that such a flow needs."""

import math

import numpy as np

from ..errors import SceneError
from ..flows import FLOWS
from .initial import flow_of
from .solids import fillings_of

KEYS = {name: flow.key for name, flow in FLOWS.items()}  # what each exact flow needs
UNITS = {"rate": "1/s", "speed": "m/s"}
LEAST_SOUND = 5.0  # speeds of the flow: densities then differ by up to 4 %
ROUND = 0.01  # how far the area of an ellipse may be off


def initial_faults(scene):
    """Return what is wrong with the flow that the blocks begin with, a list of SceneError."""
    faults = []
    for number, block in enumerate(scene.fluid.blocks):
        where = f"fluid.blocks.{number}"
        own = _keys(block, where) or _weightless(scene, block, where)
        if not own and block.initial in KEYS:
            own = {"rotation": _rotation, "stretching": _stretching, "vortices": _vortices}[block.initial](scene, number, where)
        faults += own or _sound(scene, block, where)
        if block.initial == "seiche" and "x" in scene.domain.periodic:
            why = "x is periodic, and its wave stands between two walls"
            faults.append(SceneError("cannot begin so", f"{where}.initial", why, '"still"'))
    return faults


def fastest(scene, block):
    """Return a bound of the speed [m/s] that a block begins with, waves apart."""
    flow = flow_of(scene, block)
    return (flow.fastest if flow else 0.0) + math.hypot(*(block.velocity or [0.0]))


def _keys(block, where):
    """Keys that are missing, or belong to another flow."""
    needed = KEYS.get(block.initial)
    faults = []
    for key, unit in UNITS.items():
        value = getattr(block, key)
        if key == needed and not value:
            why, cure = f"initial is {block.initial}", f"a number [{unit}]"
            faults.append(SceneError("is missing" if value is None else "must not be 0", f"{where}.{key}", why, cure))
        if key != needed and value is not None:
            kinds = " or ".join(f'"{kind}"' for kind, of_kind in KEYS.items() if of_kind == key)
            why, cure = f"initial is {block.initial}", f"initial = {kinds}, or leave it out"
            faults.append(SceneError("has no meaning here", f"{where}.{key}", why, cure))
    return faults


def _weightless(scene, block, where):
    """Exact flows are those of a plane without weight."""
    if block.initial not in KEYS:
        return []
    if scene.dim != 2:
        cure = '"still"' if scene.dim == 3 else '"still" or, in shallow water, "pulse"'
        return [SceneError(f"{block.initial} needs two dimensions", f"{where}.initial", cure=cure)]
    if scene.domain.gravity != 0:
        why = "it is an exact flow of a fluid without weight"
        return [SceneError("must be 0", "domain.gravity", f"{where}.initial is {block.initial}; {why}", "0")]
    return []


def _rotation(scene, number, where):
    block = scene.fluid.blocks[number]
    if block.points is not None:
        why, cure = "the pressure in it is known for rectangles", "low and high, or another initial flow"
        return [SceneError("rotation needs a rectangle", f"{where}.initial", why, cure)]
    return []


def _stretching(scene, number, where):
    block = scene.fluid.blocks[number]
    ellipse = 0.25 * math.pi * np.prod(np.subtract(block.high, block.low))
    if block.points is None or abs(fillings_of(scene)[number].area.area / ellipse - 1) > ROUND:
        cure = "ellipse = { center = [x, y], axes = [a, b] } in place of low and high"
        return [SceneError("stretching needs an ellipse", f"{where}.initial", "no other shape stays what it is", cure)]
    return []


def _vortices(scene, number, where):
    block, size = scene.fluid.blocks[number], scene.domain.size
    fills = block.points is None and np.allclose([*block.low, *block.high], [0.0, 0.0, *size], rtol=1e-9, atol=0)
    if set(scene.domain.periodic) != {"x", "up"}:
        why = f"{where}.initial is vortices, which repeat in both directions"
        return [SceneError("must be both", "domain.periodic", why, '["x", "up"]')]
    if not fills or not math.isclose(*size):
        why, cure = "they repeat in a square", f"low = [0.0, 0.0], high = [{size[0]:g}, {size[0]:g}] and domain.size the same"
        return [SceneError("vortices need the whole of a square domain", where, why, cure)]
    return []


def _sound(scene, block, where):
    """A flow that its sound does not outrun is not that of a liquid."""
    speed = fastest(scene, block)
    if scene.shallow or speed == 0 or scene.c0 >= LEAST_SOUND * speed:
        return []
    key = KEYS.get(block.initial, "velocity")
    return [
        SceneError(
            f"{scene.c0:.4g} m/s is too slow for a flow of {speed:.4g} m/s",
            where="numerics.c0",
            why=f"{where}.{key} would compress the fluid by more than {50 / LEAST_SOUND**2:.0f} %",
            cure=f"at least {10 * speed:.4g} m/s, ten times the fastest flow",
        )
    ]
