"""Faults of machines, disks, clocks and numbers, injected into runs on two ranks: see `parsph.verify.injection`."""

import shutil
import subprocess
from pathlib import Path

import pytest
from helpers import why_no_mpi

from parsph.verify import robustness
from parsph.verify.injection import FAULTS, SMALL

pytestmark = pytest.mark.skipif(bool(why_no_mpi()), reason=why_no_mpi() or "mpi is there")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The pool that nothing happens to."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    robustness.run(robustness.pool(folder), 1)
    return folder


@pytest.mark.parametrize("name", FAULTS)
def test_runs_survive(whole, tmp_path, name):
    """The right exit code and no hang; all that was recorded is there and right; going on gives the same bits."""
    assert robustness.survive(name, tmp_path / "run", whole, later_ranks=1) == []


@pytest.fixture
def small_disk(tmp_path):
    """A file system of two megabytes."""
    place = tmp_path / "disk"
    place.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={SMALL >> 5}", "tmpfs", place]
    mounted = subprocess.run(command, capture_output=True, check=False)
    if mounted.returncode:
        pytest.skip(f"a small file system cannot be mounted here: {mounted.stderr.decode()}")
    yield place
    subprocess.run(["umount", "-l", place], check=True)


@pytest.mark.parametrize("name", [name for name in FAULTS if name.startswith("full-disk")])
def test_runs_survive_a_disk_that_is_really_full(whole, small_disk, name):
    assert robustness.survive(name, small_disk / "run", whole, later_ranks=1) == []


def test_a_complaint_is_made_of_what_is_lost(whole, tmp_path):
    """The comparison would see it: a snapshot, a row, a byte."""
    for harm in ("snapshots/00001.vtkhdf", "gauges/level-00.csv"):
        folder = Path(shutil.copytree(whole, tmp_path / harm.replace("/", "-")))
        data = bytearray((folder / harm).read_bytes())
        data[len(data) // 2] ^= 1
        (folder / harm).write_bytes(data)
        assert robustness.lost(folder, whole)
        assert robustness.differences(folder, whole)
        (folder / harm).unlink()
        assert robustness.differences(folder, whole) == [f"{harm}: in one run only"]
