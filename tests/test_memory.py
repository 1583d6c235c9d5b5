"""Memory and time of long runs: what does not grow, and what is told of output."""

import math

import pytest
from helpers import python

from parsph.memory import resident_memory
from parsph.run import output_notes
from parsph.verify import soak


@pytest.mark.skipif(math.isnan(resident_memory()), reason="this system does not tell")
def test_resident_memory_of_a_long_run_is_flat():
    """10,000 steps here, 100,000 in ``parsph verify soak``."""
    rows = {metric: (value, bar) for metric, value, _, bar in soak.soak(quick=True)}
    growth, bar = rows["largest after that, over it, less 1"]
    assert growth <= bar == 0.02
    assert rows["snapshots"][0] > 50


KEEP = """
from parsph.memory import resident_memory
before = resident_memory()
kept = bytearray(b"1") * 50_000_000
print(resident_memory() - before)
"""


def test_resident_memory_grows_with_what_is_kept(tmp_path):
    """Else the finding above would be none. A process of its own has nothing left over from before that it could use."""
    result = python("-c", KEEP, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert int(result.stdout) > 0.9 * 50_000_000


def test_output_that_takes_its_time_is_told_of_with_a_cure():
    phases = {"sweep": (60.0, 70.0, 80.0), "snapshots": (1.0, 20.0, 40.0), "gauges": (9.0, 9.0, 9.0), "log": (1.0, 1.0, 1.0)}
    assert output_notes(phases) == [
        "note: snapshots take 20% of the time; a longer output.snapshots.every would save most of that"
    ]
    assert not output_notes({**phases, "snapshots": (9.0, 9.0, 9.0)}), "less than a tenth"
    assert not output_notes({"sweep": (1.0, 1.0, 1.0), "snapshots": (9.0, 9.0, 9.0)}), "seconds"
