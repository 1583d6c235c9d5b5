"""How fast: the neighbour loop, a whole step, and a textbook loop beside them, on one core.

The particles are jittered by 0.2 dx: a perfect lattice flatters loops with a branch on the cut-off. All three are measured
in turns in one run, and the fastest of several repeats of processor time counts, so that ratios hold on a busy machine.
"""

import json
import math
import time
from functools import partial

import numpy as np
from rich.table import Table

from .jit import jit, processor
from .parallel import Communicator
from .progress import console
from .scene.build import build
from .scene.load import load_scene
from .scene.plan import costs
from .walls import INTERPOLATORS

H_OVER_DX = (1.3, 1.7, 2.0)
PRECISIONS = ("float64", "float32")
DAM_BREAK = {  # the terms and walls of that scene
    "numerics.diffusion": "antuono",
    "numerics.spray": "pressureless",
    "numerics.alpha": 0.02,
    "walls.treatment": "ghosts",
}
ROWS = (*(("wave", h) for h in H_OVER_DX), *(("dam break", h) for h in (1.3, 2.0)))
JITTER, SEED = 0.2, 1
BLOCK = 1 << 16  # particles


@jit
def plain_loop(position, velocity, density, pressure, mass, starts, shape, h, numbers, gravity, acceleration, rate):
    """A textbook cell-list loop: Wendland C2 in 2D, pressure, artificial viscosity, density diffusion, a branch on r < 2h.

    Kept to be measured against only.
    """
    alpha_h_c0, delta_h_c0, rho0_over_c2 = numbers
    norm = 7.0 / (4.0 * math.pi * h**4)
    for cx in range(1, shape[0] - 1):
        for cy in range(1, shape[1] - 1):
            cell = cx * shape[1] + cy
            for i in range(starts[cell], starts[cell + 1]):
                ax, ay, drho = 0.0, 0.0, 0.0
                for nx in range(cx - 1, cx + 2):
                    for ny in range(cy - 1, cy + 2):
                        other = nx * shape[1] + ny
                        for j in range(starts[other], starts[other + 1]):
                            dx = position[i, 0] - position[j, 0]
                            dy = position[i, 1] - position[j, 1]
                            r = math.sqrt(dx * dx + dy * dy)
                            if r < 2.0 * h:
                                t = 1.0 - 0.5 * r / h
                                slope = -5.0 * norm * t * t * t
                                vr = (velocity[i, 0] - velocity[j, 0]) * dx + (velocity[i, 1] - velocity[j, 1]) * dy
                                pair = pressure[i] / density[i] ** 2 + pressure[j] / density[j] ** 2
                                if vr < 0.0:
                                    mean = 0.5 * (density[i] + density[j])
                                    pair -= alpha_h_c0 * vr / (r * r + 0.01 * h * h) / mean
                                ax -= mass[j] * slope * pair * dx
                                ay -= mass[j] * slope * pair * dy
                                excess = density[i] - density[j] - rho0_over_c2 * gravity * dy
                                drho += mass[j] * slope * (vr + 2.0 * delta_h_c0 * excess / density[j])
                acceleration[i, 0], acceleration[i, 1], rate[i] = ax, ay + gravity, drho


def bench_scene(particles, h_over_dx, precision, squares=1):
    """Return a tank of so many squares in a row, each with about so many particles, all terms of a wave run on."""
    side = max(8, round(math.sqrt(particles)))
    dx, length = 1.0 / side, float(squares)
    return load_scene(
        {
            "domain": {"size": [length, 1.2]},
            "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [length, 1.0]}]},
            "walls": {"left": {}, "right": {}, "bottom": {}},
            "numerics": {
                "dx": dx,
                "h_over_dx": h_over_dx,
                "precision": precision,
                "viscosity": "monaghan",
                "diffusion": "fourtakas",
                "density_range": [0.1, 10.0],
            },
            "time": {"end": 1.0, "cfl": 0.1},
        }
    )


def jittered(scene, communicator=None, speed=0.02):
    """Return the simulation of a scene with its particles displaced and moving at random, at `speed` over c0, ready to step."""
    simulation = build(scene, communicator or Communicator())
    p, generator = simulation.particles, np.random.default_rng(SEED)
    rows, dim = slice(p.first, p.last), scene.dim
    of_all = costs(scene)["particles"], p.tags[rows], dim  # the same for all numbers of ranks
    p.shared[rows, :dim] += drawn(partial(generator.uniform, -JITTER, JITTER), *of_all) * scene.numerics.dx
    p.shared[rows, dim : 2 * dim] = drawn(partial(generator.normal, 0.0, speed * scene.c0), *of_all)
    simulation.prepare()
    return simulation


def drawn(draw, count, numbers, dim):
    """Return the rows `numbers` of a random table of shape (count, dim), of which a bounded part is in memory at a time."""
    found = np.empty((len(numbers), dim))
    for first in range(0, count, BLOCK):
        block = draw((min(BLOCK, count - first), dim))
        mine = (numbers >= first) & (numbers < first + len(block))
        found[mine] = block[numbers[mine] - first]
    return found


def measure(particles, terms, h_over_dx, precision, repeats):
    """Return one row of results, for the terms of a "wave" or a "dam break": evaluations/s of `sweep`, `step` and `plain`."""
    scene = bench_scene(particles, h_over_dx, precision)
    if terms == "dam break":
        scene = load_scene(scene.model_dump(), DAM_BREAK)
    simulation = jittered(scene)
    p, domain = simulation.particles, simulation.domain
    count, dim = len(p.fluid), scene.dim
    dt = simulation.first_step()
    numbers = scene.numerics.alpha * scene.h * scene.c0, scene.numerics.delta * scene.h * scene.c0
    times = {"plain": [], "sweep": [], "step": []}
    for _ in range(repeats + 1):  # the first round compiles
        shared = p.shared[: p.last]
        columns = [
            np.ascontiguousarray(shared[:, columns])
            for columns in (slice(0, dim), slice(dim, 2 * dim), 2 * dim, 2 * dim + 1, 2 * dim + 2)
        ]
        starts = domain.starts[domain.grid.stride :]
        acceleration, rate = np.empty((p.last, dim)), np.empty(p.last)
        tasks = {
            "plain": lambda columns=columns, starts=starts, acceleration=acceleration, rate=rate: plain_loop(
                *columns,
                starts,
                domain.grid.shape,
                scene.h,
                (*numbers, scene.fluid.rho0 / scene.c0**2),
                scene.gravity[1],
                acceleration,
                rate,
            ),
            "sweep": lambda: simulation.sweep(p, domain.starts, domain.slab, 1, domain.slab.columns + 1),
            "step": lambda: simulation.step(dt),
        }
        for name, task in tasks.items():
            begin = time.process_time()
            task()
            times[name].append(time.process_time() - begin)
    rates = {name: count / min(seconds[1:]) for name, seconds in times.items()}
    return {
        **rates,
        "particles": count,
        "terms": terms,
        "h_over_dx": h_over_dx,
        "precision": precision,
        "sweep_over_plain": rates["sweep"] / rates["plain"],
        "step_over_sweep": rates["step"] / rates["sweep"],
        "step_over_plain": rates["step"] / rates["plain"],
        "bytes_per_particle": p.nbytes / count,
    }


def fixed_cost(steps=2000):
    """Return the time of a step with next to no particles [s]: what does not grow with them."""
    simulation = jittered(bench_scene(1, 2.0, "float64"))
    dt = 1e-3 * simulation.first_step()
    best = math.inf
    for _ in range(5):
        begin = time.process_time()
        for _ in range(steps // 5):
            simulation.step(dt)
        best = min(best, (time.process_time() - begin) / (steps // 5))
    return best


def phase_cost(scene, phase, start=20, steps=300):
    """Return the share of a step that a phase takes [-], after so many steps to `start`."""
    simulation = build(scene, Communicator())
    simulation.prepare()
    for _ in range(start):
        simulation.advance()
    shares = []
    for _ in range(5):
        before, begin = simulation.timers.seconds[phase], time.perf_counter()
        for _ in range(steps // 5):
            simulation.advance()
        shares.append((simulation.timers.seconds[phase] - before) / (time.perf_counter() - begin))
    return float(np.median(shares))


def costs_of_terms(particles=40_000, repeats=7):
    """Return {name: time of a step over that of a plain one}: renormalised gradients, divergence, tensile control and shifting.

    Plain is pressure, viscosity and diffusion without gradients; all are stepped in turns.
    """
    variants = {
        "plain": {},
        "renormalised gradients": {"numerics.diffusion": "antuono"},
        "renormalised divergence": {"numerics.density": "renormalised", "numerics.integrator": "adams-bashforth"},
        "tensile control and shifting": {"numerics.tensile_control": "sun", "numerics.shifting": "lind"},
    }
    keys = bench_scene(particles, 1.5, "float64").model_dump()
    simulations = {name: jittered(load_scene(keys, overrides)) for name, overrides in variants.items()}
    times = {name: [] for name in variants}
    for _ in range(repeats + 1):
        for name, simulation in simulations.items():
            dt, begin = simulation.first_step(), time.process_time()
            simulation.step(dt)
            times[name].append(time.process_time() - begin)
    best = {name: min(seconds[1:]) for name, seconds in times.items()}
    return {name: best[name] / best["plain"] for name in variants if name != "plain"}


def bench(json_file=None, particles=100_000, repeats=7):
    """Measure, print and, if asked, write the table of speeds."""
    rows = [measure(particles, *row, precision, repeats) for precision in PRECISIONS for row in ROWS]
    table = Table(title=f"{rows[0]['particles']:,} particles, 2D, Wendland C2, one core; million evaluations per second")
    columns = "terms", "h/dx", "pairs", "plain", "sweep", "step", "sweep/plain", "step/sweep", "step/plain", "bytes/particle"
    for name in columns:
        table.add_column(name, justify="right")
    for row in rows:
        speeds = [f"{row[name] / 1e6:.2f}" for name in ("plain", "sweep", "step")]
        ratios = [f"{row[name]:.2f}" for name in ("sweep_over_plain", "step_over_sweep", "step_over_plain")]
        shape = row["terms"], str(row["h_over_dx"]), row["precision"]
        table.add_row(*shape, *speeds, *ratios, f"{row['bytes_per_particle']:.0f}")
    out = console()
    out.print(table)
    machine = processor()
    out.print(f"on {machine}")
    cost = fixed_cost()
    out.print(f"fixed cost of a step: {1e6 * cost:.0f} microseconds")
    share = phase_cost(load_scene("pool", {"gauges": []}), "damping")
    out.print(f"absorbing layer of the pool, half of its particles in it: {share:.1%} of a step")
    ratios = costs_of_terms()
    for name, ratio in ratios.items():
        out.print(f"a step with {name}: {ratio:.2f} times a plain one")
    walls = {}
    for name in INTERPOLATORS:
        scene = load_scene("dam-break-small", {"gauges": [], "walls.interpolation": name})
        walls[name] = phase_cost(scene, "ghosts", steps=50)
        out.print(f"fixed ghosts of the small dam break at its beginning, {name}: {walls[name]:.1%} of a step")
    if json_file:
        rows.append(
            {
                "processor": machine,
                "fixed cost of a step [s]": cost,
                "layer over step": share,
                "ghosts over step": walls,
                **ratios,
            }
        )
        json_file.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return rows
