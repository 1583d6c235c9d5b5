"""What several tests share: small scenes, particles in order, and processes that may not hang."""

import importlib.util
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np

from parsph.columns import Grid
from parsph.domain import Domain
from parsph.observers import Observer
from parsph.parallel import Communicator
from parsph.particles import FIRST_GHOST, Layout, Particles
from parsph.states import State

ROOT = Path(__file__).parent.parent
# Loops are compiled for each kernel anew: three shapes of formula and of support stand for all, whose formulas have tests.
SOME_KERNELS = ("wendland-c2", "gaussian", "quintic-spline")
MPIRUN = Path(sys.executable).parent / "mpirun"


def why_no_mpi():
    """Return what is missing to start ranks, empty when nothing is."""
    if not MPIRUN.exists():
        return f"no mpirun beside the interpreter ({MPIRUN})"
    return "" if importlib.util.find_spec("mpi4py") else "mpi4py is not installed"


def tank(**sections):
    """Return the keys of a small still tank, 0.2 m x 0.2 m of water; `sections` replace whole sections."""
    keys = {
        "domain": {"size": [0.2, 0.3], "gravity": 9.81},
        "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [0.2, 0.2]}]},
        "walls": {"left": {}, "right": {}, "bottom": {}},
        "numerics": {"dx": 0.01, "diffusion": "fourtakas", "viscosity": "monaghan"},
        "time": {"end": 0.01},
    }
    return {**keys, **sections}


def water(c0=20.0, name="tait"):
    """Return an equation of state of water."""
    return State(name, 1000.0, c0, 7.0)


def domain_of(
    grid,
    fields,
    walls=(),
    gravity=None,
    state=None,
    reach=None,
    box=None,
    cuts=None,
    communicator=None,
    tags=None,
    features=("verlet",),
    **options,
):
    """Return a `Domain` with fluid of the given fields, of which it takes those in its own columns; not arranged.

    Missing fields are at rest, at reference density, and of unit mass. `options` are those of `Domain`.
    """
    communicator = communicator or Communicator()
    dim, count = fields["position"].shape[1], len(fields["position"])
    state, gravity = state or water(), gravity or (0.0,) * dim
    cuts = cuts or (0, grid.columns)
    box = box or (grid.low, tuple(a + n * grid.cell for a, n in zip(grid.low, grid.shape, strict=True)))
    density = fields.get("density", np.full(count, state.rho0))
    full = {
        "velocity": np.zeros((count, dim)),
        "density": density,
        "pressure": state.pressure(density),
        "mass": np.ones(count),
        **fields,
    }
    tags = np.arange(count) if tags is None else tags
    columns = grid.column_of(fields["position"][:, 0])
    mine = (columns >= cuts[communicator.rank]) & (columns < cuts[communicator.rank + 1])
    particles = Particles(Layout(dim, features))
    particles.add(tags[mine], **{name: values[mine] for name, values in full.items()})
    reach = reach or grid.cell
    wetted = box[1][-1]
    return Domain(grid, particles, list(walls), reach, box, gravity, state, wetted, communicator, cuts, **options)


def images_of(domain):
    """Return (rows of the images, their parents' rows) of an arranged domain."""
    p = domain.particles
    tags = p.tags[p.first : p.last]
    ghosts = p.first + np.flatnonzero(tags >= FIRST_GHOST)
    row_of = {int(tag): p.first + k for k, tag in enumerate(tags) if tag < FIRST_GHOST}
    return ghosts, np.array([row_of[int(tag) % FIRST_GHOST] for tag in p.tags[ghosts]], int)


def jittered_lattice(dim, cells, dx, seed=1, jitter=0.2):
    """Return positions of a lattice of `cells` points in each direction, each moved by up to `jitter` dx."""
    rng = np.random.default_rng(seed)
    axes = [dx * (np.arange(n) + 0.5) for n in cells]
    points = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    assert points.shape[1] == dim
    return points + dx * rng.uniform(-jitter, jitter, points.shape)


def grid_around(position, cell):
    """Return a grid that holds all `position`."""
    return Grid.around(tuple(position.min(axis=0) - 1e-6), tuple(position.max(axis=0) + 1e-6), cell)


class Probe(Observer):
    """Keeps ``[time, *look(simulation)]`` whenever it is due."""

    def __init__(self, every, look):
        super().__init__(every)
        self.look, self.seen = look, []

    def observe(self, simulation):
        self.seen.append((simulation.time, self.look(simulation)))


def parsph(*arguments, cwd, ranks=None, timeout=120, environment=None):
    """Run ``python -m parsph`` with `arguments` on one process or on `ranks`."""
    return python("-m", "parsph", *arguments, cwd=cwd, ranks=ranks, timeout=timeout, environment=environment)


def python(*arguments, cwd, ranks=None, timeout=120, environment=None):
    """Run the interpreter with `arguments`, on `ranks` if given; fail if it takes longer than `timeout` seconds."""
    process = start(*arguments, cwd=cwd, ranks=ranks, environment=environment)
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGTERM)  # mpirun takes its ranks down with it
        try:
            out, err = process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            process.kill()
            out = err = "(nothing readable)"
        raise AssertionError(f"still running after {timeout} s: {arguments}\n{out[-2000:]}\n{err[-2000:]}") from None
    return subprocess.CompletedProcess(arguments, process.returncode, out, err)


def start(*arguments, cwd, ranks=None, environment=None):
    """Start the interpreter with `arguments` and return the process."""
    launcher = [str(MPIRUN), "-n", str(ranks)] if ranks else []
    return subprocess.Popen(
        [*launcher, sys.executable, *map(str, arguments)],
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "COLUMNS": "200", **(environment or {})},
    )


def settings(**overrides):
    """Return ``--set key=value`` arguments; ``__`` in a name stands for the dot."""
    return [part for key, value in overrides.items() for part in ("--set", f"{key.replace('__', '.')}={value}")]


# A pond, and a block at the right that falls into it after 0.1 s: the blow of rho c0 v / 2 exceeds the range of density.
DROP = """
[domain]
size = [1.2, 0.5]
[fluid]
blocks = [{ low = [0.0, 0.0], high = [1.2, 0.1] }, { low = [0.9, 0.16], high = [1.2, 0.4] }]
level = 0.1
[walls]
left = {}
right = {}
bottom = {}
[numerics]
dx = 0.02
diffusion = "fourtakas"
viscosity = "monaghan"
density_range = [0.9, 1.012]
[time]
end = 0.3
[output.snapshots]
every = 0.02
[[gauges]]
kind = "level"
x = 0.2
"""
