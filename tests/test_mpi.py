"""What a user types on several ranks: the same bits on any number of them, and an end to the whole job when one fails."""

import itertools
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import DROP, MPIRUN, ROOT, parsph, python, settings, why_no_mpi

pytestmark = pytest.mark.skipif(bool(why_no_mpi()), reason=why_no_mpi() or "mpi is there")

POOL = {"numerics__dx": 0.1, "output__log__every": 1.0}
LONG = settings(**POOL, time__end=0.3, output__snapshots__every=0.1)
BRIEF = settings(**POOL, time__end=0.04, output__snapshots__every=0.02)


ROUND = "test_periodic_slabs.py::test_what_flows_round_is_the_same_on_all_ranks_to_the_bit"


@pytest.mark.parametrize(("ranks", "part"), [(2, ""), (3, ""), (5, ROUND)])
def test_suite_on_ranks(ranks, part):
    """On one rank they run among all other tests."""
    tests = f"tests/mpi/{part}"
    command = [MPIRUN, "-n", str(ranks), sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", tests]
    result = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=400, stdin=subprocess.DEVNULL, env=os.environ
    )
    assert result.returncode == 0, result.stdout[-6000:] + result.stderr[-6000:]
    assert " passed" in result.stdout
    assert len(re.findall(r"\d+ passed", result.stdout)) == 1, "ranks above 0 are to be quiet"


def results(folder):
    """Return {file and dataset: contents} of a run's snapshots and tables, and the number of steps of each snapshot."""
    found = {path.name: path.read_bytes() for path in (folder / "gauges").iterdir()}
    for path in sorted((folder / "snapshots").glob("*.vtkhdf")):
        with h5py.File(path) as file:
            root, meta = file["VTKHDF"], file["parsph"].attrs
            found[f"{path.name} Points"] = root["Points"][:]
            found.update({f"{path.name} {name}": array[:] for name, array in root["PointData"].items()})
            found[f"{path.name} clock"] = np.array([meta["time [s]"], meta["step"]])
    return found


def assert_same_bits(one, other):
    assert one.keys() == other.keys()
    for name, contents in one.items():
        if isinstance(contents, bytes):
            assert contents == other[name], name
        else:
            assert contents.dtype == other[name].dtype
            assert contents.tobytes() == other[name].tobytes(), f"{name}: {np.sum(contents != other[name])} differ"


def run(folder, *arguments, ranks=None, scene="pool"):
    result = parsph("run", scene, *arguments, "--out", folder, cwd=folder.parent, ranks=ranks, timeout=240)
    assert result.returncode == 0, result.stderr
    return results(folder)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The pool without mpirun."""
    return run(tmp_path_factory.mktemp("alone") / "run", *LONG)


@pytest.mark.parametrize("ranks", [1, 2, 3, 5])
def test_results_are_the_same_to_the_bit(alone, tmp_path, ranks):
    """Snapshots, gauge tables and steps; long enough for the cuts between the ranks to move (every 200 steps)."""
    assert alone["00003.vtkhdf clock"][1] > 200
    assert len([name for name in alone if name.endswith(".csv")]) == 6
    assert_same_bits(run(tmp_path / "run", *LONG, ranks=ranks), alone)


VARIANTS = {
    "xsph": {"numerics__xsph": 0.5},
    "midpoint": {"numerics__integrator": "midpoint"},
    "float32, renormalised divergence": {
        "numerics__precision": "float32",
        "numerics__density": "renormalised",
        "numerics__integrator": "adams-bashforth",
    },
    "fixed dt": {"time__dt": 0.0009},
    "gaussian, molteni, no slip, density layer": {
        "numerics__kernel": "gaussian",
        "numerics__h_over_dx": 1.333,
        "numerics__diffusion": "molteni",
        "walls__bottom__slip": "no",
        "damping__0__density": "plain",
    },
    "layers at both ends, matched, fx-vx, f1": {
        "wavemaker__wave__ramp": 0.0,
        "damping": '[{ side = "left", length = 0.9, sigma0 = 2.0, density = "matched", switch = "fx-vx" }, '
        '{ length = 11.2, density = "matched", switch = "fx-vx", killing = "f1" }]',
    },
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_variants_are_the_same_to_the_bit(tmp_path, variant):
    arguments = (*BRIEF, *settings(**VARIANTS[variant]))
    one = run(tmp_path / "one", *arguments)
    assert_same_bits(run(tmp_path / "three", *arguments, ranks=3), one)


@pytest.mark.parametrize(
    ("scene", "ranks", "overrides"),
    [
        ("swe-dam-break", 3, {"time__end": 30.0, "output__snapshots__every": 10.0}),
        ("swe-pulse", 2, {"time__end": 4.0, "output__snapshots__every": 2.0, "fluid__blocks__0__center": 490.0}),
    ],
)
def test_shallow_water_is_the_same_to_the_bit(tmp_path, scene, ranks, overrides):
    """Summed densities with a growing h; a pulse that a layer takes up, with its mass."""
    gauges = '[{ kind = "level", x = 505.0, every = 0.5 }, { kind = "energy", every = 1.0 }]'
    arguments = settings(**overrides, gauges=gauges)
    one = run(tmp_path / "one", *arguments, scene=scene)
    assert len([name for name in one if name.endswith(" mass")]) >= 3
    assert_same_bits(run(tmp_path / "many", *arguments, ranks=ranks, scene=scene), one)


def test_only_one_rank_talks(tmp_path):
    """Each line comes once, whatever the number of ranks."""
    for arguments in (("list",), ("check", "pool"), ("plan", "seiche"), ("--version",)):
        single = parsph(*arguments, cwd=tmp_path)
        assert parsph(*arguments, cwd=tmp_path, ranks=2).stdout == single.stdout


def test_ranks_info_names_each_rank_and_its_columns(tmp_path):
    result = parsph("run", "pool", *BRIEF, "--ranks-info", cwd=tmp_path, ranks=3)
    assert result.returncode == 0, result.stderr
    spans = [tuple(map(int, span)) for span in re.findall(r"rank \d: .*columns (\d+):(\d+)", result.stdout)]
    assert len(spans) == 3
    assert all(a[1] == b[0] for a, b in itertools.pairwise(spans))
    assert result.stdout.count("time per phase") == 1


def test_summary_tells_what_ranks_sent_and_how_they_shared(tmp_path):
    """Three messages to the one neighbour in an evaluation, one line at the end; one rank alone has nothing to tell."""
    for ranks in (None, 2):
        result = parsph("run", "pool", *LONG, "--out", f"on-{ranks}", cwd=tmp_path, ranks=ranks)
        assert result.returncode == 0, result.stderr
        summary = json.loads((tmp_path / f"on-{ranks}" / "summary.json").read_text())
        assert result.stdout.count("per step and rank") == (ranks is not None)
        assert ("communication" in summary) == ("imbalance" in summary) == (ranks is not None)
    told, imbalance = summary["communication"], summary["imbalance"]
    assert 3.0 <= told["messages"]["mean"] <= told["messages"]["largest"] < 4.0  # gauges look at a present of their own
    assert told["bytes"]["largest"] >= told["bytes"]["mean"] > 0
    assert 1.0 <= told["collectives"]["Allreduce"] < 1.1
    assert 1.0 <= imbalance["mean"] <= imbalance["largest"]


# --- failures ------------------------------------------------------------------------------------------------------


def test_too_many_ranks_end_with_2_and_the_cure(tmp_path):
    result = parsph("run", "seiche", cwd=tmp_path, ranks=8)
    assert result.returncode == 2, result.stderr
    text = " ".join(result.stderr.split())
    assert text.count("too many ranks: 8") == 1
    assert re.search(r"use at most \d ranks, or a finer resolution", text)
    assert "Traceback" not in text
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("arguments", [["run", "pool", "--set", "time.ende=1"], ["run", "pool", "--nonsense"], ["runn"]])
def test_bad_input_is_told_once_and_ends_with_2(tmp_path, arguments):
    result = parsph(*arguments, cwd=tmp_path, ranks=2)
    assert result.returncode == 2, result.stderr
    assert "Traceback" not in result.stderr
    assert result.stderr.count("time.ende") + result.stderr.count("No such") == 1
    assert not list(tmp_path.iterdir())


def test_unwritable_output_ends_all_ranks_with_2(tmp_path):
    (tmp_path / "file").touch()
    result = parsph("run", "pool", *BRIEF, "--out", "file/below", cwd=tmp_path, ranks=2)
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("cannot write") == 1


def test_a_run_that_fails_on_one_rank_ends_the_job_with_1(tmp_path):
    """Only the last rank has the block of water that falls; the others may wait for it in an exchange."""
    (tmp_path / "drop.toml").write_text(DROP)
    result = parsph("run", "drop.toml", "--out", "mine", cwd=tmp_path, ranks=3, timeout=60)
    assert result.returncode == 1, result.stderr
    assert re.search(r"error: particle \d+ .*density", " ".join(result.stderr.split()))
    assert "Traceback" not in result.stderr
    assert len(list((tmp_path / "mine" / "snapshots").glob("*.vtkhdf"))) >= 3


HOOKED = """
from parsph import parallel
communicator = parallel.start()
parallel.end_job_on_error(communicator)
if communicator.rank == 1:
    raise RuntimeError("injected")
communicator.barrier()
"""

INSIDE = """
import parsph.simulation
from parsph.cli import main
step = parsph.simulation.Simulation.step
def fails(self, dt):
    if self.communicator.rank == 1 and self.steps == 3:
        raise {error}("injected")
    step(self, dt)
parsph.simulation.Simulation.step = fails
main(["run", "pool", *{arguments}])
"""


@pytest.mark.parametrize(
    "script",
    [HOOKED, *(INSIDE.format(error=error, arguments=BRIEF) for error in ("RuntimeError", "OSError", "MemoryError"))],
    ids=["hook alone", "RuntimeError in a run", "OSError in a run", "MemoryError in a run"],
)
def test_any_exception_on_one_rank_ends_the_whole_job(tmp_path, script):
    """With its traceback, and never a hang: the other ranks wait for that one in their next exchange."""
    path = Path(tmp_path / "script.py")
    path.write_text(script)
    result = python(path, cwd=tmp_path, ranks=3, timeout=40)
    assert result.returncode != 0
    assert "rank 1:" in result.stderr
    assert "Traceback" in result.stderr
    assert "injected" in result.stderr


def test_output_is_measured(tmp_path):
    """On the ranks that mpirun starts; nothing is left but what is asked for."""
    options = "--output", "--particles", 1000, "--repeats", 1, "--json", "rows.json"
    result = parsph("bench", *options, cwd=tmp_path, ranks=2, timeout=240)
    assert result.returncode == 0, result.stderr
    rows = json.loads((tmp_path / "rows.json").read_text())
    assert [row["file"] for row in rows] == ["snapshot, float64", "snapshot, float32", "checkpoint"]
    assert {row["writer"] for row in rows} == {"collective" if h5py.get_config().mpi else "gather"}
    for row in rows:
        assert row["ranks"] == 2
        assert row["bytes"] > 40 * row["particles"] > 0
        assert min(row["seconds"], row["steps"]) > 0
    assert [path.name for path in tmp_path.iterdir()] == ["rows.json"]
