"""Where scenes are stable: the map that `parsph stability` has measured, and what `parsph check` makes of it."""

import csv
from functools import cache
from importlib import resources
from typing import NamedTuple

from ..stepping import INTEGRATORS

ROUNDING = 1e-9
MAP = resources.files(__package__) / "data" / "stability.csv"


class Cell(NamedTuple):
    """What the largest stable CFL depends on; without diffusion or viscosity `delta` or `alpha` is 0."""

    integrator: str
    density: str
    diffusion: str
    delta: float
    alpha: float
    h_over_dx: float


NUMBERS = tuple(name for name, kind in Cell.__annotations__.items() if kind is float)


def read_map(lines):
    """Return {`Cell`: (largest stable CFL, the case that sets it)} of the lines of a table, of which those with # are remarks.

    The CFL is 0 where none is stable.
    """
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return {
        Cell(*(float(row[name]) if name in NUMBERS else row[name] for name in Cell._fields)): (float(row["cfl"]), row["case"])
        for row in rows
    }


@cache
def measured_map():
    """Return the map that the package brings along, as `read_map`."""
    return read_map(MAP.read_text(encoding="utf-8").splitlines())


def cell_of(scene):
    """Return the `Cell` of a scene, None where it has what the map says nothing of."""
    n = scene.numerics
    plain = n.kernel == "wendland-c2" and n.kernel_correction == "none" and n.viscosity in ("none", "monaghan")
    if scene.dim != 2 or not plain or scene.domain.periodic or scene.domain.gravity * scene.depth <= 0:
        return None
    return Cell(
        n.integrator,
        n.density,
        n.diffusion if n.delta else "none",
        n.delta if n.diffusion != "none" else 0.0,
        n.alpha if n.viscosity != "none" else 0.0,
        n.h_over_dx,
    )


def largest_cfl(cell, known):
    """Return the largest CFL with which a `Cell` is stable: the smallest of the cells around it in the map `known`.

    None where it lies outside the map.
    """
    kin = [other for other in known if other[:2] == cell[:2] and other.diffusion in (cell.diffusion, "none")]
    around = set(kin)
    for name in NUMBERS:
        value, values = getattr(cell, name), {getattr(other, name) for other in kin}
        low, high = max((v for v in values if v <= value), default=None), min((v for v in values if v >= value), default=None)
        if low is None or high is None:
            return None
        around = {other for other in around if low <= getattr(other, name) <= high}
    return min((known[other][0] for other in around), default=None)


def stability_doubts(scene):
    """Return what the map says against the time step of a scene: a line of text, in a list, or none."""
    cell, n, time = cell_of(scene), scene.numerics, scene.time
    limit = largest_cfl(cell, measured_map()) if cell else None
    cfl = time.dt * scene.c0 / scene.h if time.dt else scene.cfl
    if limit is None or cfl <= limit * (1.0 + ROUNDING):
        return []
    if time.dt:
        asked, most = f"time.dt: {time.dt:g} s, a CFL of {cfl:.3g},", f"at most {limit * scene.h / scene.c0:.3g} s"
    else:
        asked, most = f"time.cfl: {cfl:g}{'' if time.cfl else ', the default,'}", f"at most {limit:g}"
    cures = [most] if limit else []
    other, its_limit = _quickest(cell)
    if other != n.integrator:
        cures.append(f'numerics.integrator = "{other}" with up to {its_limit:g}')
    if not cell.delta:
        cures.append("a numerics.diffusion")
    return [
        f"{asked} is above {limit:g}, up to which {n.integrator} is stable in small flows with this diffusion, viscosity and "
        f"h_over_dx (measured by parsph stability); {', or '.join(cures)}"
    ]


def _quickest(cell):
    """Return the integrator with the longest stable steps per evaluation, and its largest CFL that is legal."""
    limits = {
        name: min(largest_cfl(cell._replace(integrator=name), measured_map()) or 0.0, integrator.largest_cfl)
        for name, integrator in INTEGRATORS.items()
    }
    return max(limits.items(), key=lambda limit: limit[1] / INTEGRATORS[limit[0]].evaluations)
