"""The only MPI start-up and abort hook; serial runs need no MPI library.

Communication goes through a `Communicator`, so the rest of the code never asks whether MPI is there.
"""

import os
import shutil
import sys
import time
import traceback
from collections import Counter
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from .errors import ParsphError, SceneError

# What launchers (MPICH/Hydra, Open MPI, PMIx, Intel MPI, Slurm's srun with PMI) tell the processes they start.
_LAUNCHER_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")
FORWARDING = 0.5  # s that the launcher has to pass on the last words of a rank before it hears that the job ends


class Communicator:
    """One rank alone: every collective is the identity.

    Attributes
    ----------
    collectives : Counter
        How often each collective was called, by its name in MPI; a rank alone calls none.
    """

    size, rank, node_rank = 1, 0, 0
    mpi = None

    def __init__(self):
        self.collectives = Counter()

    def barrier(self):
        """Wait for all ranks."""

    def gather(self, item):
        """Return the list of every rank's `item` on rank 0, None elsewhere."""
        return [item]

    def allgather(self, item):
        """Return the list of every rank's `item` on all ranks."""
        return [item]

    def broadcast(self, item):
        """Return rank 0's `item` on all ranks."""
        return item

    def minimum(self, value):
        """Return the smallest `value` of all ranks; of an array, element by element."""
        return value

    def send(self, array, rank):
        """Send a contiguous `array` to `rank`, as soon as that is there to receive it."""
        raise RuntimeError("one rank has nobody to send to")

    def receive(self, array, rank):
        """Fill a contiguous `array` with what `rank` sends."""
        raise RuntimeError("one rank has nobody to receive from")

    def stack(self, array):
        """Return every rank's rows on rank 0, in rank order; an array without rows elsewhere."""
        return array

    def on_root(self, action):
        """Run ``action()`` on rank 0 and return its result on all ranks; its error is raised on all ranks."""
        outcome = None
        if self.rank == 0:
            try:
                outcome = action()
            except (ParsphError, OSError) as error:
                outcome = error
        outcome = self.broadcast(outcome)
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    def abort(self, code):
        """End the whole job with exit `code`."""
        os._exit(code)


class MpiCommunicator(Communicator):
    """All ranks of an MPI job."""

    def __init__(self, mpi):
        super().__init__()
        self.mpi = mpi
        self.comm = mpi.COMM_WORLD
        self.size, self.rank = self.comm.Get_size(), self.comm.Get_rank()
        self.node_rank = self.comm.Split_type(mpi.COMM_TYPE_SHARED).Get_rank()

    def barrier(self):
        self.collectives["Barrier"] += 1
        self.comm.Barrier()

    def gather(self, item):
        self.collectives["Gather"] += 1
        return self.comm.gather(item)

    def allgather(self, item):
        self.collectives["Allgather"] += 1
        return self.comm.allgather(item)

    def broadcast(self, item):
        self.collectives["Bcast"] += 1
        return self.comm.bcast(item)

    def minimum(self, value):
        self.collectives["Allreduce"] += 1
        result = np.array(value, float)
        self.comm.Allreduce(self.mpi.IN_PLACE, result, self.mpi.MIN)
        return result if result.ndim else float(result)

    def send(self, array, rank):
        self.comm.Ssend(array, rank, tag=9)  # what is sent ahead would pile up in the receiver's memory

    def receive(self, array, rank):
        self.comm.Recv(array, rank, tag=9)

    def stack(self, array):
        self.collectives["Gather"] += 1
        parts = self.comm.gather(array)
        return np.concatenate(parts) if self.rank == 0 else array[:0]

    def abort(self, code):
        sys.stdout.flush()
        sys.__stderr__.flush()
        time.sleep(FORWARDING)
        self.comm.Abort(code)


def launched_ranks():
    """Return the number of ranks a launcher announces in the environment, 1 without one."""
    sizes = [os.environ.get(name, "") for name in _LAUNCHER_SIZES]
    if os.environ.get("PMIX_RANK") or os.environ.get("SLURM_STEP_ID"):
        sizes.append(os.environ.get("SLURM_STEP_NUM_TASKS", ""))
    return max([int(size) for size in sizes if size.isdigit()], default=1)


def python_command(*arguments, ranks=1):
    """Return the command that runs this interpreter with `arguments`, as "-m", "parsph", in a process of its own or on ranks.

    The launcher is the one beside the interpreter, else the one on the path.

    Raises
    ------
    SceneError
        When several ranks are wanted and there is no launcher.
    """
    command = [sys.executable, *map(str, arguments)]
    if ranks == 1:
        return command
    beside = Path(sys.executable).parent / "mpirun"
    launcher = str(beside) if beside.exists() else shutil.which("mpirun")
    if launcher is None:
        raise SceneError("no mpirun", where="--ranks", cure="pip install 'parsph[mpi]', or one rank")
    return [launcher, "-n", str(ranks), *command]


def start():
    """Return the communicator of this process: MPI where a launcher started it, else one rank alone.

    Raises
    ------
    SceneError
        When several ranks were launched and no mpi4py is there to connect them.
    """
    ranks = launched_ranks()
    if ranks == 1 and "mpi4py.MPI" not in sys.modules:
        return Communicator()
    if find_spec("mpi4py") is None:
        raise SceneError(
            f"{ranks} ranks were launched, but mpi4py is not installed",
            where="mpirun",
            why="without it every rank would run the whole scene alone",
            cure="install the extra: pip install 'parsph[mpi]'",
        )
    from mpi4py import MPI

    return MpiCommunicator(MPI) if MPI.COMM_WORLD.Get_size() > 1 else Communicator()


def end_job_on_error(communicator):
    """Let any uncaught exception on any rank end the whole job at once, with its traceback."""
    if communicator.size == 1:
        return

    def hook(kind, error, trace):
        sys.__stderr__.write(f"rank {communicator.rank}:\n" + "".join(traceback.format_exception(kind, error, trace)))
        sys.__stderr__.flush()
        communicator.abort(1)

    sys.excepthook = hook
