"""Faults, injected into a run: `main` does what ``parsph run SCENE ...`` does until, after `STEP` steps, something goes wrong.
Each function below replaces a part of the program by one that fails.
"""

import os
import resource
import runpy
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from ..io import checkpoints, polydata
from ..io.tables import Table
from ..parallel import python_command
from ..simulation import Simulation

STEP = 60
SMALL = 1 << 26  # bytes: a file system that may be filled up
FAULTS = {}


def fault(*codes):
    """Register a function as the fault of its name, after which a run ends with one of `codes`; none: anything but 0."""

    def register(function):
        FAULTS[function.__name__.replace("_", "-")] = function, codes
        return function

    return register


def wrapped(owner, name, around):
    """Replace a function by ``around(usual, *arguments)``."""
    usual = getattr(owner, name)
    setattr(owner, name, lambda *arguments, **options: around(usual, *arguments, **options))


def after_step(action, step=STEP):
    """Call ``action(simulation)`` after a step of this number, and maybe later ones."""

    def around(usual, simulation, dt):
        usual(simulation, dt)
        if simulation.steps >= step:
            action(simulation)

    wrapped(Simulation, "step", around)


def on_rank(rank, action, step=STEP):
    """Call ``action(simulation)`` on one rank, negative ones counted from the last, after the step of this number."""

    def only(simulation):
        communicator = simulation.communicator
        if simulation.steps == step and communicator.rank == rank % communicator.size:
            action(simulation)

    after_step(only, step)


def folder_of(simulation):
    """Return the folder of a run."""
    return next(observer.folder for observer in simulation.observers if hasattr(observer, "written"))


class Late:
    """Whether the run is past `STEP`."""

    def __init__(self):
        self.now = False
        after_step(lambda simulation: setattr(self, "now", True))

    def __bool__(self):
        return self.now


def in_write(part, action):
    """Call `action` when a particle file in the folder `part` is half written."""
    late = Late()

    def around(usual, dataset, *arguments):
        usual(dataset, *arguments)
        if late and Path(dataset.file.filename).parent.name == part:
            dataset.file.flush()
            action()

    wrapped(polydata, "_fill", around)


def before_rename(name, action):
    """Call `action` when a file that ends with `name` is written, and not yet called so."""
    late = Late()

    def around(usual, source, target):
        if late and str(target).endswith(name):
            action()
        usual(source, target)

    wrapped(os, "replace", around)


def kill():
    """End this process as a machine does that dies."""
    os.kill(os.getpid(), signal.SIGKILL)


def fill_up():
    """Leave no room: fill a small file system, elsewhere forbid this process files longer than the present ones."""
    folder = Path(sys.argv[sys.argv.index("--out") + 1]) if "--out" in sys.argv else Path(sys.argv[2])
    space = os.statvfs(folder)
    if space.f_frsize * space.f_blocks > SMALL:
        resource.setrlimit(resource.RLIMIT_FSIZE, (512, resource.RLIM_INFINITY))
        return
    with open(folder.parent / "filler", "ab", buffering=0) as filler:
        try:
            for size in (1 << 16, 1 << 10, 1):
                while filler.write(bytes(size)) == size:
                    pass
        except OSError:
            pass


# --- ranks and machines that die -----------------------------------------------------------------------------------


@fault()
def killed_in_a_step():
    """The last rank dies in mid-step, while the others wait for its halo."""

    def around(usual, simulation):
        if simulation.steps == STEP and simulation.communicator.rank == simulation.communicator.size - 1:
            kill()
        usual(simulation)

    wrapped(Simulation, "_finish_halo", around)


@fault()
def launcher_killed():
    """`mpirun` dies, of which the ranks are the grandchildren."""

    def behead(_):
        parent = Path(f"/proc/{os.getppid()}/stat").read_text(encoding="ascii")
        os.kill(int(parent.rpartition(")")[2].split()[1]), signal.SIGKILL)

    on_rank(0, behead)


@fault()
def killed_in_a_snapshot():
    """The rank that writes dies with half a snapshot written."""
    in_write("snapshots", kill)


@fault()
def killed_in_a_checkpoint():
    """The rank that writes dies with half a checkpoint written."""
    in_write("checkpoints", kill)


@fault()
def killed_before_a_checkpoint_has_its_name():
    """The rank that writes dies when all is written."""
    before_rename(".vtkhdf", kill)


@fault()
def killed_in_a_row_of_a_gauge():
    """The rank that writes dies with half a row of a table written."""
    late = Late()

    def around(usual, table, values):
        if late:
            table._file.write(b"0.12345,0.6")
            kill()
        usual(table, values)

    wrapped(Table, "add", around)


@fault()
def killed_before_the_summary():
    """The rank that writes dies when the run is over, and nothing says so."""
    before_rename("summary.json", kill)


# --- disks ---------------------------------------------------------------------------------------------------------


def full_at(owner, name):
    """Let there be no room any more when a function is called."""
    late = Late()

    def around(usual, *arguments, **options):
        if late:
            fill_up()
        return usual(*arguments, **options)

    wrapped(owner, name, around)


@fault(1)
def full_disk_in_a_snapshot():
    """There is no room for a snapshot."""
    from ..io import snapshots

    full_at(snapshots, "write_snapshot")


@fault(1)
def full_disk_in_a_gauge():
    """There is no room for a row of a table."""
    full_at(Table, "add")


@fault(1)
def full_disk_in_a_checkpoint():
    """There is no room for a checkpoint."""
    full_at(checkpoints, "write_checkpoint")


@fault(1)
def folder_gone():
    """The output folder is moved away, as when a file system is unmounted."""

    def away(simulation):
        folder = folder_of(simulation)
        shutil.move(folder, folder.with_name("gone"))

    on_rank(0, away)


# --- signals, clocks, numbers, others ------------------------------------------------------------------------------


@fault(85)
def asked_to_end_in_a_snapshot():
    """SIGTERM comes while a snapshot is written."""
    in_write("snapshots", lambda: os.kill(os.getpid(), signal.SIGTERM))


@fault(85)
def asked_to_end_in_a_checkpoint():
    """SIGUSR1 comes while a checkpoint is written."""
    in_write("checkpoints", lambda: os.kill(os.getpid(), signal.SIGUSR1))


@fault(0)
def clock_set():
    """The clock is set by a year forth and back while a limit of wall time is watched."""
    late, usual = Late(), time.time
    time.time = lambda: usual() + (3e7 if late and int(usual() * 100) % 2 else 0.0)


@fault(1)
def not_a_number():
    """A particle of the last rank gets a velocity that is not a number."""

    def spoil(simulation):
        p = simulation.particles
        p.view("velocity")[p.fluid[len(p.fluid) // 2]] = np.nan

    on_rank(-1, spoil)


@fault(0)
def second_job():
    """Another job tries to go on in the same folder, and is refused."""

    def other(simulation):
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("PMI", "MPI", "HYD"))}
        command = python_command("-m", "parsph", "resume", folder_of(simulation))
        found = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        if found.returncode != 2 or "is in use" not in found.stderr:
            raise RuntimeError(f"the second job ended with {found.returncode}: {found.stderr}")

    on_rank(0, other)


def main():
    """Inject the fault that the command line names first, and be ``parsph`` with the rest."""
    FAULTS[sys.argv.pop(1)][0]()
    _be_parsph()


def signalled():
    """Have a rank send itself a signal after a step, and be ``parsph``; the command line begins with step, rank and signal."""
    step, rank, number = (int(sys.argv.pop(1)) for _ in range(3))
    on_rank(rank, lambda simulation: os.kill(os.getpid(), number), step)
    _be_parsph()


def _be_parsph():
    checkpoints.LOOK, checkpoints.LARGEST_SHARE = 0.0, 1.0  # after every step, as often as the scene says
    runpy.run_module("parsph", run_name="__main__", alter_sys=True)
