"""The stability map: the largest CFL with which two small cases stay stable, for each choice of numerics.

Both cases are 256 particles of water, 1 m deep.

- Calm: still water between mirrors whose particles begin with random velocities. It is stable when the kinetic energy never
  exceeds that of the beginning: sound that grows slowly shows here, and not in a violent second.
- Violent: a column as wide as high collapses in a closed box of fixed ghosts, twice as wide and high, and sloshes. It is
  stable when no density leaves its range and kinetic, potential and compressible energy together never rise, over any
  earlier value, by more than a share of the first. Where water hits walls they rise by a hundredth with any time step.

What is stable with a CFL is taken to be so with smaller ones, so that the largest is found by bisection.
"""

import csv
import io
import math
import multiprocessing
import os
import signal
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib.util import find_spec
from itertools import product
from pathlib import Path

import numpy as np
from rich.table import Table

from . import __version__, parallel, viz
from .errors import Interrupted, RunError, SceneError
from .io.folder import output_folder, write_whole
from .io.gauges import EnergyGauge
from .parallel import Communicator
from .progress import console, duration
from .scene.build import build
from .scene.load import load_scene
from .scene.stability import Cell, read_map

DIFFUSIONS = (("none", 0.0), ("fourtakas", 0.02), ("fourtakas", 0.1), ("antuono", 0.1), ("molteni", 0.1))
SCHEMES = {  # integrator and density, and with which diffusions
    ("verlet", "continuity"): DIFFUSIONS,
    ("adams-bashforth", "continuity"): DIFFUSIONS,
    ("adams-bashforth", "renormalised"): DIFFUSIONS[1:3],
    ("midpoint", "continuity"): DIFFUSIONS,
}
ALPHAS, H_OVER_DX = (0.0, 0.02, 0.1), (1.3, 1.5, 2.0, 2.5)
C0_FACTOR = 20.0  # with 10 limits are the same or up to 0.05 higher

STEP, MOST_STEPS = 0.025, 60  # of the CFL numbers that are tried, and how many there are
LEGAL_CFL = 0.1  # scenes may not have all that are tried
GRAVITY, SPACINGS = 9.81, 16  # m/s^2, and particles per depth
NOISE, CALM_STEPS = 1e-3, 1000  # standard deviation of the random velocities over c0; at most so many steps
DENSITY_RANGE = [0.5, 2.0]
DURATION, MOST_RISE = 6.0, 0.02  # over sqrt(depth/g); of the energy at the beginning
LOOK_EVERY = 10  # steps

TABLE = "stability.csv"
HEAD = """\
# Largest stable CFL, dt = CFL min(h/(c0 + |v|), sqrt(h/|a|)), of wendland-c2 in 2D; 0 where {step} is not stable.
# Measured by `parsph stability` of parsph {version}: {spacings} particles per depth, c0 = {c0_factor:g} sqrt(g depth).
# case: what sets the limit, a violent flow or noise in a calm one. Without diffusion or viscosity delta or alpha is 0.
"""


def cells_of(quick=False):
    """Return the cells of the map; `quick`: three of one kind of scene."""
    if quick:
        return [Cell(*scheme, "fourtakas", 0.1, 0.02, 1.5) for scheme in SCHEMES if scheme[1] == "continuity"]
    return [
        Cell(*scheme, *diffusion, alpha, h_over_dx)
        for alpha, diffusion, (scheme, diffusions), h_over_dx in product(ALPHAS, DIFFUSIONS, SCHEMES.items(), H_OVER_DX)
        if diffusion in diffusions
    ]


def largest_stable(stable, most):
    """Return the largest k, ``1 <= k <= most``, with ``stable(k)``, 0 without one.

    It is tried from above in strides that double, then by bisection, since what is unstable ends early.
    """
    lowest_bad, stride = most + 1, 1
    while (good := max(lowest_bad - stride, 0)) and not stable(good):
        lowest_bad, stride = good, 2 * stride
    while lowest_bad - good > 1:
        middle = (good + lowest_bad) // 2
        good, lowest_bad = (middle, lowest_bad) if stable(middle) else (good, middle)
    return good


def limit_of(cell):
    """Return the largest CFL with which both cases are stable, and the case that sets it, "calm" or "violent".

    Parameters
    ----------
    cell : Cell

    Returns
    -------
    tuple of (float, str)
        The CFL is 0 where the smallest that is tried, `STEP`, is unstable, and at most ``STEP * MOST_STEPS``.
    """
    calm = largest_stable(lambda k: stays_calm(cell, k * STEP), MOST_STEPS)
    both = largest_stable(lambda k: stays_sound(cell, k * STEP), calm)
    return round(both * STEP, 3), "calm" if both == calm else "violent"


def stays_calm(cell, cfl):
    """Return whether the noise in still water does not grow."""
    try:
        first, *later = (kinetic for kinetic, _ in _energies(_still_water(cell), cfl, CALM_STEPS))
    except RunError:
        return False
    return max(later) <= first


def stays_sound(cell, cfl):
    """Return whether a column falls and sloshes without energy that comes from nowhere."""
    first, least = None, math.inf
    try:
        for _, total in _energies(_column(cell), cfl):
            first, least = first or total, min(least, total)
            if total > least + MOST_RISE * first:
                return False
    except RunError:
        return False
    return True


def _still_water(cell):
    simulation = _simulation(cell, 1.0, {"left": {}, "right": {}, "bottom": {}, "exchange": True})
    p = simulation.particles
    noise = np.random.default_rng(1).normal(0.0, NOISE * simulation.sweep.c0, (len(p.fluid), 2))
    p.shared[p.first : p.last, p.layout.columns("velocity")[1]] = noise
    return simulation


def _column(cell):
    box = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
    return _simulation(cell, 2.0, {"polygons": [{"points": box, "fluid": "inside"}]})


def _simulation(cell, width, walls):
    keys = {
        "domain": {"size": [width, 2.0], "gravity": GRAVITY},
        "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}]},
        "walls": walls,
        "numerics": {
            **cell._asdict(),
            "dx": 1.0 / SPACINGS,
            "c0_factor": C0_FACTOR,
            "viscosity": "monaghan" if cell.alpha else "none",
            "spray": "pressureless",
            "density_range": DENSITY_RANGE,
        },
        "time": {"end": DURATION / math.sqrt(GRAVITY), "cfl": LEGAL_CFL},
    }
    return build(load_scene(keys), Communicator())


def _energies(simulation, cfl, steps=math.inf):
    """Step to the end, or so many steps; yield kinetic and total energy [J] at the beginning and every `LOOK_EVERY` steps."""
    simulation.cfl = cfl
    gauge = EnergyGauge("energy", None, (-math.inf,) * 2, (math.inf,) * 2)
    simulation.prepare()
    while simulation.time < simulation.end and simulation.steps < steps:
        if simulation.steps % LOOK_EVERY == 0:
            _, kinetic, potential, compressible, *_ = gauge.measure(simulation)
            yield kinetic, kinetic + potential + compressible
        simulation.advance()


def stability(quick=False, jobs=None, resume=False, out=None):
    """Measure the map, print it, and write a table and a plot of it.

    Parameters
    ----------
    quick : bool
        Three cells alone.
    jobs : int, optional
        So many cells at a time; default: as many as there are cores for.
    resume : bool
        Whether `out` may hold cells that were measured before; they are kept.
    out : path, optional
        Folder; default ``stability/map-<NNN>``.

    Returns
    -------
    dict
        {`Cell`: (largest stable CFL, the case that sets it)}

    Raises
    ------
    SceneError
        When it is started on several ranks, or the folder cannot be used.
    Interrupted
        What is finished is kept then.
    """
    if parallel.launched_ranks() > 1:
        raise SceneError("stability starts its processes itself", where="mpirun", cure="parsph stability, without mpirun")
    folder = _folder(resume, out)
    table, cells = folder / TABLE, cells_of(quick)
    found = read_map(table.read_text(encoding="utf-8").splitlines()) if table.exists() else {}
    todo, begin, shown = [cell for cell in cells if cell not in found], time.perf_counter(), console()
    with ProcessPoolExecutor(
        jobs or len(os.sched_getaffinity(0)), multiprocessing.get_context("spawn"), _leave_to_parent
    ) as pool:
        try:
            started = {pool.submit(limit_of, cell): cell for cell in todo}
            for number, done in enumerate(as_completed(started), 1):
                cell = started[done]
                found[cell] = done.result()
                write_whole(table, table_text(found))
                left = (time.perf_counter() - begin) / number * (len(todo) - number)
                cfl, case = found[cell]
                shown.print(f"[{len(found)}/{len(cells)}] {told(cell)}: {cfl:.3f}, {case}; eta {duration(left)}")
        except BaseException as error:
            pool.shutdown(cancel_futures=True)
            if isinstance(error, KeyboardInterrupt):
                cure = f"go on with --resume --out {folder}"
                raise Interrupted("interrupted", str(folder), "finished cells are kept", cure) from None
            raise
    _print(found)
    _draw(found, folder)
    shown.print(f"table and plot: {folder}")
    return found


def _folder(resume, out):
    if not resume:
        return output_folder("map", out, parent="stability")
    if out is None or not (Path(out) / TABLE).exists():
        raise SceneError("there is nothing to go on with", where="--resume", cure=f"--out FOLDER with a {TABLE}")
    return Path(out)


def _leave_to_parent():
    """Let a process finish its cell: what the keyboard interrupts is its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def told(cell):
    """Return a cell in words."""
    diffusion = f"{cell.diffusion} {cell.delta:g}" if cell.delta else "no diffusion"
    return f"{cell.integrator}, {cell.density}, {diffusion}, alpha {cell.alpha:g}, h/dx {cell.h_over_dx:g}"


def table_text(found):
    """Return the map as the text of a table, which `read_map` reads."""
    text = io.StringIO()
    text.write(HEAD.format(version=__version__, step=STEP, spacings=SPACINGS, c0_factor=C0_FACTOR))
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow([*Cell._fields, "cfl", "case"])
    rows.writerows([*cell, f"{cfl:.3f}", case] for cell, (cfl, case) in sorted(found.items()))
    return text.getvalue()


def condensed(found):
    """Return {(integrator, density): {diffusion with its strength: {h/dx: limits}}}, limits of all viscosities."""
    schemes = {}
    for cell, (cfl, _) in found.items():
        rows = schemes.setdefault((cell.integrator, cell.density), {})
        diffusion = f"{cell.diffusion} {cell.delta:g}" if cell.delta else "none"
        rows.setdefault(diffusion, {}).setdefault(cell.h_over_dx, []).append(cfl)
    return schemes


def tabulated(found):
    """Return {(integrator, density): rows}, dicts of text: smallest and largest limit of all viscosities at each h/dx."""
    columns, tables = sorted({cell.h_over_dx for cell in found}), {}
    for scheme, rows in condensed(found).items():
        for diffusion, limits in rows.items():
            ends = {h: sorted({min(limits[h]), max(limits[h])}) if h in limits else () for h in columns}
            told = {f"h/dx {h:g}": "-".join(f"{end:.3g}" for end in ends[h]) for h in columns}
            tables.setdefault(scheme, []).append({"diffusion": diffusion, **told})
    return tables


def _print(found):
    for scheme, rows in tabulated(found).items():
        title = f"{', '.join(scheme)}: largest stable CFL, of all viscosities"
        table = Table(*rows[0], title=title, title_justify="left", pad_edge=False)
        for row in rows:
            table.add_row(*row.values())
        console().print(table)


def _draw(found, folder):
    if find_spec("matplotlib") is None:
        console().print("no plot: matplotlib is not installed (pip install 'parsph[plots]')")
        return
    schemes = condensed(found)
    drawing, axes = viz.figure(rows=(len(schemes) + 1) // 2, columns=2)
    for ax, (scheme, rows) in zip(axes.flat, schemes.items(), strict=False):
        curves = {
            diffusion: list(zip(*sorted((h, min(values)) for h, values in limits.items()), strict=True))
            for diffusion, limits in rows.items()
        }
        viz.against(ax, None, curves, "h/dx [-]", "CFL [-]", log_y=False)
        ax.set_title(", ".join(scheme), fontsize=viz.SMALL)
    for ax in axes.flat[len(schemes) :]:
        ax.set_axis_off()
    viz.save(drawing, folder / "stability.png")
