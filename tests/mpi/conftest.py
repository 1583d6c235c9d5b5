"""For ``mpirun -n N python -m pytest -x tests/mpi``: all ranks run the same tests in step, rank 0 talks.

A failure on any rank prints its report and ends the whole job, since the others would wait for that rank for ever.
"""

import os
import sys
import time

import pytest

from parsph import parallel

COMMUNICATOR = parallel.start()
LONGEST_TEST = 120  # seconds


@pytest.hookimpl(trylast=True)
def pytest_configure(config):
    if COMMUNICATOR.rank > 0:
        reporter = config.pluginmanager.get_plugin("terminalreporter")
        reporter._tw._file = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - open as long as the session


def pytest_collection_modifyitems(items):
    for item in items:
        if "mpi" in item.path.parts:
            # "thread" ends the process; a signal would wait for the MPI call that hangs
            method = "thread" if COMMUNICATOR.size > 1 else "signal"
            item.add_marker(pytest.mark.timeout(LONGEST_TEST, method=method))


def pytest_runtest_logreport(report):
    if report.failed and COMMUNICATOR.size > 1:
        print(f"rank {COMMUNICATOR.rank}: {report.nodeid}\n{report.longreprtext}", file=sys.stderr, flush=True)
        time.sleep(1)  # other ranks that failed may say so too
        COMMUNICATOR.abort(1)


def pytest_sessionfinish(exitstatus):
    if exitstatus and COMMUNICATOR.size > 1:  # also a failed collection on one rank alone
        COMMUNICATOR.abort(int(exitstatus))


@pytest.fixture(autouse=True)
def _in_step():
    """No rank begins the next test before all have ended this one."""
    yield
    COMMUNICATOR.barrier()


@pytest.fixture
def communicator():
    """All ranks of the job."""
    return COMMUNICATOR


@pytest.fixture
def tmp_path(tmp_path_factory):
    """One folder for all ranks."""
    return COMMUNICATOR.broadcast(tmp_path_factory.mktemp("mpi") if COMMUNICATOR.rank == 0 else None)
