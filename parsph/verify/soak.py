"""A long run of a small pool with all that it writes: memory that grows with the steps would show."""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np

from ..memory import resident_memory
from ..parallel import python_command
from ..run import run
from ..scene.limits import step_of
from ..scene.load import load_scene
from .injection import after_step
from .registry import case
from .robustness import ended

POOL = {"numerics.dx": 0.25, "output.checkpoints.every": 2.0, "output.log.every": 10.0}
STEPS = {False: 100_000, True: 10_000}  # by `quick`
EARLY = 0.05  # of the steps, after which everything that is needed has been there once
LOOKS = 1000
LONGEST = 3600  # s


@case
def soak(quick):
    """The pool for 100,000 steps, in a process of its own, with its gauges, snapshots, series, checkpoints and log."""
    yield from grown(STEPS[quick], ranks=1)


def grown(steps, ranks):
    """Yield how much the memory of the rank with the largest growth has grown after the first twentieth of a run."""
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work) / "run"
        for out, count in ((folder.with_name("before"), LOOKS), (folder, steps)):  # a compiler would leave room to grow into
            command = python_command("-c", "from parsph.verify.soak import main; main()", out, count, ranks=ranks)
            code, said = ended(command, LONGEST)
            if code != 0:
                raise RuntimeError(f"the run ended with {code}:\n{said[-2000:]}")
        memories = [np.array(json.loads(path.read_text())) for path in folder.glob("memory-*.json")]
        snapshots = len(list((folder / "snapshots").iterdir()))
    early = int(EARLY * LOOKS)
    yield "steps, at least", steps, "", None
    yield "snapshots", snapshots, "", None
    yield "resident memory after a twentieth", max(memory[early] for memory in memories) / 1e6, "MB", None
    yield "largest after that, over it, less 1", max(memory[early:].max() / memory[early] - 1 for memory in memories), "", 0.02


def main():
    """Run the pool in the folder and for the steps that the command line names, and leave what each rank's memory was."""
    folder, steps = Path(sys.argv[1]), int(sys.argv[2])
    memory = np.zeros(LOOKS)

    def look(simulation):
        if simulation.steps % (steps // LOOKS) == 0 and simulation.steps < steps:
            memory[simulation.steps // (steps // LOOKS)] = resident_memory()

    after_step(look, 1)
    end = steps * step_of(load_scene("pool", POOL))  # steps are a little shorter than the first one
    finished = run("pool", POOL | {"time.end": end}, folder)
    (folder / f"memory-{finished.simulation.communicator.rank}.json").write_text(json.dumps(memory.tolist()), encoding="utf-8")
