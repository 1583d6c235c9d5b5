"""Runs that are stopped and go on: the same bits as without, on any number of ranks, whatever became of the newest checkpoint.

Scenes and code are those of `test_mpi`; tests of many kinds of scenes are in ``mpi/test_restart_slabs.py``.
"""

import json
import os
import shutil
import signal

import numpy as np
import pytest
from helpers import parsph, python, settings, why_no_mpi
from test_mpi import LONG, assert_same_bits, results, run

from parsph.errors import RunError
from parsph.io import checkpoints
from parsph.io.checkpoints import Checkpoint, Damaged, latest, write_checkpoint
from parsph.io.folder import Claim
from parsph.observers import Signals
from parsph.parallel import Communicator
from parsph.particles import Layout, Particles
from parsph.run import run as run_scene
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.verify.robustness import SIGNALLED

with_mpi = pytest.mark.skipif(bool(why_no_mpi()), reason=why_no_mpi() or "mpi is there")


def stopped(folder, step, number, *arguments, ranks=None, rank=0):
    """Run until a rank gets a signal after a step; return what was printed and the exit code."""
    return python("-c", SIGNALLED, step, rank, int(number), *arguments, cwd=folder.parent, ranks=ranks, timeout=240)


def resumed(folder, *arguments, ranks=None):
    result = parsph("resume", folder, *arguments, cwd=folder.parent, ranks=ranks, timeout=240)
    assert result.returncode == 0, result.stderr
    return result


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The pool that nothing stops, on one rank; its folder."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    run(folder, *LONG)
    return folder


@pytest.fixture(scope="module")
def once_stopped(tmp_path_factory):
    """The same, stopped by SIGTERM after 120 steps; to be copied."""
    folder = tmp_path_factory.mktemp("stopped") / "run"
    result = stopped(folder, 120, signal.SIGTERM, "run", "pool", *LONG, "--out", folder)
    assert result.returncode == 85, result.stderr
    assert "parsph resume" in " ".join(result.stderr.split())
    assert "a signal asked it to end" in " ".join(result.stderr.split())
    return folder


@pytest.fixture
def copied(once_stopped, tmp_path):
    """A copy of the stopped run, to do with as one likes."""
    return shutil.copytree(once_stopped, tmp_path / "run")


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text())


@with_mpi
def test_a_chain_of_ranks_gives_the_same_bits(whole, copied):
    """One rank, two, three: SIGTERM, then the warning signal of a queue at one rank alone, then to the end."""
    assert len(list((copied / "checkpoints").iterdir())) == 1
    assert not (copied / "summary.json").exists()
    result = stopped(copied, 210, signal.SIGUSR1, "resume", copied, ranks=2, rank=1)
    assert result.returncode == 85, result.stderr
    assert result.stderr.count("parsph") >= 1
    assert " ".join(result.stderr.split()).count("stopped at t =") == 1, "one rank speaks for all"
    assert "goes on at t =" in result.stdout
    resumed(copied, ranks=3)
    assert_same_bits(results(copied), results(whole))
    told, other = summary_of(copied), summary_of(whole)
    assert (told["parts"], other["parts"]) == (3, 1)
    assert told["steps"] == other["steps"]
    assert told["evaluations"] == other["evaluations"]
    assert told["communication"]["messages"]["mean"] > 0


def test_an_interrupted_run_goes_on(whole, tmp_path):
    """Ctrl-C writes a checkpoint, too; resumed twice after the same one, gauge rows come once."""
    folder = tmp_path / "run"
    result = stopped(folder, 150, signal.SIGINT, "run", "pool", *LONG, "--out", folder)
    assert result.returncode == 130, result.stderr
    shutil.copytree(folder / "checkpoints", tmp_path / "kept")
    stopped(folder, 200, signal.SIGINT, "resume", folder)
    shutil.rmtree(folder / "checkpoints")
    shutil.copytree(tmp_path / "kept", folder / "checkpoints")  # as if the second part had been killed
    resumed(folder)
    assert_same_bits(results(folder), results(whole))


@with_mpi
def test_wall_time_ends_a_run_with_a_checkpoint(whole, tmp_path):
    """Shorter than what a checkpoint may take: the run still makes a step, so that a chain of jobs gets on."""
    folder = tmp_path / "run"
    for arguments in (("run", "pool", *LONG, "--out", folder), ("resume", folder)):
        result = parsph(*arguments, "--walltime", "0:00:02", cwd=tmp_path, ranks=2, timeout=240)
        assert result.returncode == 85, result.stderr
        assert "wall time" in result.stderr
    resumed(folder, "--walltime", "1-00:00:00")
    assert_same_bits(results(folder), results(whole))


def test_checkpoints_at_intervals_change_no_bit(whole, tmp_path):
    """Also where the run is not stopped; the last two are kept, and one of the end."""
    folder = tmp_path / "run"
    every = settings(output__checkpoints__every=0.05)
    found = run(folder, *LONG, *every)
    assert_same_bits(found, results(whole))
    paths = sorted((folder / "checkpoints").iterdir())
    assert len(paths) == 2
    assert int(paths[-1].stem) == summary_of(folder)["steps"]
    assert 0 < int(paths[0].stem) < summary_of(folder)["steps"]


def test_no_checkpoints_where_the_scene_wants_none(tmp_path):
    run(tmp_path / "run", *LONG, *settings(output__checkpoints__every=0, time__end=0.01))
    assert not list((tmp_path / "run" / "checkpoints").iterdir())


def test_a_finished_run_goes_on_to_a_later_end(whole, tmp_path):
    """The intervals of its files stay, as does what it left; the end falls on one of them."""
    folder = tmp_path / "run"
    run(folder, *LONG, *settings(time__end=0.2))
    result = resumed(folder)
    assert "has finished at t = 0.2 s" in result.stdout
    assert "time per phase of part 2," in resumed(folder, *settings(time__end=0.3)).stdout
    assert_same_bits(results(folder), results(whole))
    assert summary_of(folder)["time [s]"] == json.loads((folder / "scene.json").read_text())["time"]["end"] == 0.3


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--set", "numerics.alpha=0.1"), "--set numerics.alpha: cannot change"),
        (("--set", "time.end=0.01"), "cannot end at 0.01 s"),
        (("--set", "time.end=-1"), "time.end"),
        (("--walltime", "soon"), "hours:minutes:seconds"),
    ],
)
def test_what_cannot_change_ends_with_2_and_changes_nothing(copied, command, arguments, told):
    before = {path: path.read_bytes() for path in copied.rglob("*") if path.is_file()}
    code, _, err = command("resume", copied, *arguments)
    assert code == 2
    assert told in err
    assert before == {path: path.read_bytes() for path in copied.rglob("*") if path.is_file()}


def test_a_folder_of_no_run_ends_with_2(tmp_path, command):
    code, _, err = command("resume", tmp_path)
    assert code == 2
    assert "is not the folder of a run" in err


# --- damage --------------------------------------------------------------------------------------------------------


def damage(path, how):
    data = bytearray(path.read_bytes())
    if how == "cut":
        data = data[: len(data) // 2]
    elif how == "empty":
        data = b""
    elif how == "other":
        data = b"not a checkpoint"
    else:  # one bit of a number
        data[len(data) // 3] ^= 4
    path.write_bytes(data)


@pytest.mark.parametrize("how", ["cut", "empty", "other", "flipped"])
def test_a_damaged_checkpoint_is_told_of_and_the_one_before_it_used(whole, copied, how):
    stopped(copied, 180, signal.SIGUSR1, "resume", copied)
    first, second = sorted((copied / "checkpoints").iterdir())
    damage(second, how)
    result = resumed(copied)
    assert f"{second.name} is damaged and is not used" in " ".join(result.stderr.split())
    assert f"from {first}" in result.stdout
    assert_same_bits(results(copied), results(whole))


@with_mpi
def test_without_a_checkpoint_that_is_whole_a_run_begins_anew(whole, copied):
    (copied / "checkpoints" / "000000999.partial").write_bytes(b"half")  # as a killed run leaves it
    for path in (copied / "checkpoints").glob("*.vtkhdf"):
        damage(path, "flipped")
    result = resumed(copied, ranks=2)
    assert "is damaged" in result.stderr
    assert "goes on" not in result.stdout
    assert_same_bits(results(copied), results(whole))


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A checkpoint of a few hundred particles, and what it holds."""
    scene = load_scene("pool", {"numerics.dx": 0.25})
    simulation = build(scene, Communicator())
    simulation.prepare()
    for _ in range(3):
        simulation.advance()
    path = tmp_path_factory.mktemp("small") / "checkpoints" / "000000003.vtkhdf"
    path.parent.mkdir()
    write_checkpoint(path, simulation, "{}", {})
    return scene, path, contents(scene, path)


def contents(scene, path):
    """Return what a run would go on from, to the bit."""
    checkpoint = Checkpoint(path)
    checkpoint.examine(Communicator())
    simulation = build(scene, Communicator(), checkpoint=checkpoint)
    checkpoint.restore(simulation)
    p = simulation.particles
    fields = [p.field(field.name, p.fluid).tobytes() for field in p.layout.fields if field.lasting]
    return p.tags[p.fluid].tobytes(), *fields, json.dumps(simulation.memory())


def test_any_flipped_bit_is_found_or_does_no_harm(small, tmp_path):
    """At places all over the file, headers and gaps included."""
    scene, path, whole_contents = small
    data, rng, found = path.read_bytes(), np.random.default_rng(5), 0
    copy = tmp_path / path.name
    for place in rng.integers(0, len(data), 150):
        broken = bytearray(data)
        broken[place] ^= 1 << int(rng.integers(8))
        copy.write_bytes(broken)
        try:
            assert contents(scene, copy) == whole_contents, f"byte {place} of {len(data)}"
        except Damaged:
            found += 1
    assert found > 50


def test_a_rank_may_get_nothing_of_a_checkpoint(small):
    """The columns of which are empty; the first ones are beside the domain."""
    scene, path, _ = small
    checkpoint, particles = Checkpoint(path), Particles(Layout(scene.dim, scene.features))
    columns = len(checkpoint.counts)
    assert checkpoint.counts[0] == 0
    checkpoint.fill(particles, 0, 1)
    assert particles.last == 0
    checkpoint.fill(particles, 1, columns)
    assert particles.last == checkpoint.counts.sum() > 0


def test_what_is_not_a_number_is_not_kept(small, tmp_path):
    """A run that has gone wrong leaves the checkpoint before it."""
    simulation = build(small[0], Communicator())
    simulation.prepare()
    simulation.particles.acceleration[simulation.particles.fluid[7]] = np.nan
    with pytest.raises(RunError, match="particle 7: acceleration is not a number"):
        write_checkpoint(tmp_path / "1.vtkhdf", simulation, "{}", {})
    assert not list(tmp_path.iterdir())


def test_a_checkpoint_is_a_particle_file_that_viewers_read(small):
    """The same layout as snapshots."""
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(small[1]))
    reader.Update()
    output = reader.GetOutput()
    assert output.GetNumberOfPoints() == len(np.frombuffer(small[2][0], np.int64))
    assert output.GetPointData().HasArray("acceleration")
    assert np.isfinite(vtk_to_numpy(output.GetPoints().GetData())).all()


def test_nobody_but_the_newest_is_examined(small):
    """Checksums of old ones cost nothing."""
    checkpoint, damages = latest(small[1].parent.parent, Communicator())
    assert checkpoint.path == small[1]
    assert damages == []


# --- looking at the clock ------------------------------------------------------------------------------------------


def test_looks_are_far_apart_where_steps_are_short(monkeypatch, tmp_path):
    """Agreeing every step would cost a message each; the clock that is watched cannot be set."""
    now, looks = [0.0], []
    monkeypatch.setattr(checkpoints.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(checkpoints.time, "time", lambda: pytest.fail("the wall clock may jump"))
    writer = checkpoints.Checkpoints(tmp_path, "{}", 900.0, None, 0.0, Signals(), dict)
    simulation = build(load_scene("pool", {"numerics.dx": 0.25}), Communicator())
    writer.begin(simulation)
    monkeypatch.setattr(simulation.communicator, "minimum", lambda value: looks.append(now[0]) or value)
    for _ in range(4000):
        now[0] += 0.001
        assert not writer.due(0.0)
    assert 8 <= len(looks) <= 25
    now[0] += 900.0
    assert sum(writer.due(0.0) for _ in range(2000)) >= 1


def test_signals_are_as_before_after_a_run(tmp_path):
    usual = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)}
    keys = json.loads(load_scene("pool", {"numerics.dx": 0.25, "time.end": 0.005}).model_dump_json())
    assert run_scene(keys, out=tmp_path / "run").simulation.steps > 0
    assert usual == {number: signal.getsignal(number) for number in usual}


# --- one job a folder ----------------------------------------------------------------------------------------------


def test_two_jobs_on_a_folder_are_one_too_many(copied, command):
    """The second refuses, whether it would go on or begin anew; when the first is gone it may."""
    before = {path: path.read_bytes() for path in copied.rglob("*") if path.is_file() and path.name != ".lock"}
    claim = Claim(copied)
    for arguments in (("resume", copied), ("run", "pool", *LONG, "--out", copied, "--overwrite")):
        code, _, err = command(*arguments)
        assert code == 2
        assert "is in use" in err
        assert f"process {os.getpid()}" in err
    assert before == {path: path.read_bytes() for path in before}
    claim.release()
    resumed(copied)


def test_the_size_of_a_checkpoint_is_known_before(small):
    """What `parsph plan --ranks` prints is what is written, but for headers and alignment."""
    scene, path, whole_contents = small
    size = checkpoints.bytes_on_disk(Layout(scene.dim, scene.features)) * len(np.frombuffer(whole_contents[0], np.int64))
    assert size < path.stat().st_size < size + 40_000
