"""Runs that stop, on purpose or not, and go on: the same bits, nothing lost, no hang."""

import os
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from ..errors import Unfinished
from ..io.checkpoints import Checkpoint, folder_of, write_checkpoint
from ..io.comparison import contents, differences
from ..io.results import Results
from ..parallel import Communicator, python_command
from ..scene.build import build
from ..scene.load import load_scene
from .injection import FAULTS
from .registry import case

LONGEST = 120  # s that a run of the small pool may take on a busy machine before it counts as hanging
POOL = {"numerics.dx": 0.1, "time.end": 0.1, "output.snapshots.every": 0.02, "output.log.every": 1.0}
FAULTY, SIGNALLED = (f"from parsph.verify.injection import {name}; {name}()" for name in ("main", "signalled"))
MILLION = {"domain.size": [20.0, 6.0], "fluid.blocks.0.high": [20.0, 5.0], "numerics.dx": 0.01}


def pool(folder, **overrides):
    """Return the arguments of ``parsph`` that run the small pool in `folder`."""
    keys = POOL | {key.replace("__", "."): value for key, value in overrides.items()}
    return ["run", "pool", *[part for key, value in keys.items() for part in ("--set", f"{key}={value}")], "--out", str(folder)]


def ended(command, longest=LONGEST):
    """Run a command; return its exit code, None when it was still there after so many seconds, and what it said."""
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, start_new_session=True
    )
    try:
        said, _ = process.communicate(timeout=longest)
        return process.returncode, said
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return None, process.communicate()[0]


def survive(name, folder, whole, ranks=2, later_ranks=3):
    """Run the small pool until a fault, then go on with it; return what was not as it should be, a list of texts.

    Parameters
    ----------
    name : str
        One of `FAULTS`.
    folder : Path
        Of the run, not there yet.
    whole : Path
        Of the same run without a fault.
    ranks, later_ranks : int
        Until the fault, and after it.
    """
    _, codes = FAULTS[name]
    wanted = pool(folder, output__checkpoints__every=0.001, time__walltime=3600)
    code, said = ended(python_command("-c", FAULTY, name, *wanted, ranks=ranks))
    if code is None:
        return ["it hangs"]
    found = []
    if code not in codes and (codes or code == 0):
        found.append(f"it ends with {code}: {said[-500:]}")
    if code in (1, 85) and "error:" not in said:
        found.append(f"it says nothing: {said[-500:]}")
    if folder.with_name("gone").exists():
        shutil.move(folder.with_name("gone"), folder)
    folder.with_name("filler").unlink(missing_ok=True)
    found += lost(folder, whole)
    code, said = ended(python_command("-m", "parsph", "resume", folder, ranks=later_ranks))
    if code != 0:
        return [*found, f"going on ends with {code}: {said[-500:]}"]
    return found + differences(folder, whole)


def lost(folder, whole):
    """Return what of a stopped run cannot be read, or is not what the whole run has."""
    try:
        found, complete = contents(folder), contents(whole)
    except (OSError, KeyError) as error:
        return [f"what is there cannot be read: {error}"]
    bad = []
    for name, recorded in found.items():
        if isinstance(recorded, bytes):
            rows = recorded[: recorded.rfind(b"\n") + 1]
            bad += [f"{name} is not the beginning of the whole one"] * (not complete[name].startswith(rows))
        elif any(values.tobytes() != complete[name][field].tobytes() for field, values in recorded.items()):
            bad.append(f"{name} differs")
    paths = sorted(folder_of(folder).glob("*.vtkhdf"))
    for path in paths:
        Checkpoint(path).examine(Communicator())
    return bad if paths else [*bad, "there is no checkpoint"]


@case
def restart(quick):
    """The pool, stopped by signals, on 1, 2 and then 3 ranks, against one run; a checkpoint of a million particles."""
    with tempfile.TemporaryDirectory() as work:
        whole, chain = Path(work) / "whole", Path(work) / "chain"
        run(pool(whole), 1)
        third = Results(whole).summary["steps"] // 3
        run(pool(chain), 1, third)
        run(["resume", chain], 2, 2 * third)
        run(["resume", chain], 3)
        parts = Results(chain).summary["parts"]
        yield f"parts of {third} steps and what is left", parts, "", None
        yield "snapshots and tables that differ, 1 -> 2 -> 3 ranks", len(differences(chain, whole)), "", 0
        if not quick:
            yield from _million(Path(work) / "million.vtkhdf")


def run(arguments, ranks, until=None):
    """Run ``parsph`` with `arguments`, and end it by a signal after the step `until`; RuntimeError when it does not end so."""
    if until is None:
        command, code = python_command("-m", "parsph", *arguments, ranks=ranks), 0
    else:
        first = until, ranks - 1, int(signal.SIGTERM)
        command, code = python_command("-c", SIGNALLED, *first, *arguments, ranks=ranks), Unfinished.exit_code
    found, said = ended(command)
    if found != code:
        raise RuntimeError(f"parsph {' '.join(map(str, arguments))} ended with {found}, not {code}:\n{said[-2000:]}")


def _million(path):
    scene = load_scene("still", MILLION)
    simulation = build(scene, Communicator())
    simulation.domain.arrange(0.0)
    begin = time.perf_counter()
    write_checkpoint(path, simulation, "{}", {})
    written = time.perf_counter() - begin
    begin = time.perf_counter()
    checkpoint = Checkpoint(path)
    checkpoint.examine(Communicator())
    build(scene, Communicator(), checkpoint=checkpoint)
    read = time.perf_counter() - begin
    count, size = len(simulation.particles.fluid), path.stat().st_size
    yield f"checkpoint of {count:,} particles, {size / 1e6:.0f} MB, on disk", written, "s", 2.0
    yield "the same examined and read", read, "s", None


@case
def faults(quick):
    """Ranks that die, full disks, signals, clocks, numbers that are none: each injected into the pool on two ranks.

    Each run must end with the right exit code and no hang, leave all that it had recorded readable and right, and go on to the
    same bits as a run without a fault.
    """
    with tempfile.TemporaryDirectory() as work:
        whole = Path(work) / "whole"
        run(pool(whole), 1)
        survived = 0
        for name in FAULTS:
            found = survive(name, Path(work) / name / "run", whole)
            survived += not found
            yield ": ".join([f"complaints: {name.replace('-', ' ')}", *found]), len(found), "", 0
        yield f"survived, of {len(FAULTS)}", survived, "", None
