"""The job scripts with stand-ins for parsph, its launcher and the queue. tests/slurm.sh tries them with the real ones."""

import os
import shutil
import signal
import subprocess
import time

import pytest
from helpers import ROOT, python

SCRIPTS = sorted(ROOT.glob("jobs/*.sh")) + sorted(ROOT.glob("tests/*.sh"))
MOST = 100  # goes, jobs or requeues in a chain

# Tells its arguments, begins a run as parsph does, and ends with the next code of the file `codes`, whose last one stays.
PYTHON = """
shift 2
echo "parsph $*" >> told
if [ "$1" = run ]; then mkdir -p "$4" && touch "$4/scene.json"; fi
code=$(head -n 1 codes)
if [ "$(wc -l < codes)" -gt 1 ]; then sed -i 1d codes; fi
exit "$code"
"""
# Runs until SIGTERM, as a run that then writes a checkpoint.
PATIENT_PYTHON = """
trap 'echo stopped >> told; exit 85' TERM
mkdir -p runs/a && touch runs/a/scene.json
echo started >> told
while true; do sleep 0.05; done
"""
MPIRUN = """
echo "mpirun $1 $2" >> told
shift 2
exec "$@"
"""
QSTAT = """
echo "Job Id: $2"
echo "    Resource_List.select = 1:ncpus=2:mpiprocs=2"
echo "    Resource_List.walltime = 01:30:00"
"""
# Runs what is submitted, in the environment of the job that submits it less what it does not name.
QSUB = """
[ "$1" = -v ] || exit 1
echo "qsub $3 with $2" >> told
for name in SCENE OUT JOB PARSPH_PYTHON; do
    case ",$2," in *,$name,*) ;; *) unset $name ;; esac
done
exec bash "$3"
"""
# The state of the job is that of the file `job`; a job that is requeued begins again.
SCONTROL = """
echo "scontrol $*" >> told
case $1 in
    show) cat job ;;
    requeue) [ -e disabled ] && exit 1; exit 0 ;;
esac
"""


@pytest.fixture
def place(tmp_path):
    """A folder with stand-ins in `bin`, the first on the path."""
    (tmp_path / "bin").mkdir()
    programs = {"python": PYTHON, "mpirun": MPIRUN, "qstat": QSTAT, "qsub": QSUB, "scontrol": SCONTROL}
    for name, text in programs.items():
        program(tmp_path, name, text)
    (tmp_path / "jobs").symlink_to(ROOT / "jobs")
    (tmp_path / "job").write_text("JobState=RUNNING\n PreemptEligibleTime=2026-01-01T00:00:00 PreemptTime=None\n")
    return tmp_path


def program(place, name, text):
    path = place / "bin" / name
    path.write_text(f"#!/bin/bash\n{text}")
    path.chmod(0o755)


def environment(place, **variables):
    path = f"{place / 'bin'}:{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PARSPH_PYTHON": str(place / "bin/python"), **variables}


def call(place, script, *arguments, codes=(0,), **variables):
    """Run a script with a parsph that ends with `codes`; return its exit code, what it printed, what the stand-ins told."""
    (place / "codes").write_text("".join(f"{code}\n" for code in codes))
    (place / "told").write_text("")
    command = ["bash", f"jobs/{script}", *arguments]
    done = subprocess.run(
        command, cwd=place, env=environment(place, **variables), capture_output=True, text=True, timeout=60, check=False
    )
    return done.returncode, done.stdout + done.stderr, (place / "told").read_text().splitlines()


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_scripts_are_sound(script):
    subprocess.run(["bash", "-n", str(script)], check=True)
    assert os.access(script, os.X_OK) == script.read_text().startswith("#!")
    if shutil.which("shellcheck"):
        found = subprocess.run(["shellcheck", "--severity=warning", str(script)], capture_output=True, text=True, check=False)
        assert found.returncode == 0, found.stdout


def test_local_goes_on_until_finished(place):
    code, _, told = call(place, "local.sh", "pool", "runs/a", "--set", "time.end=10", codes=(85, 85, 0), RANKS="3")
    assert code == 0
    first, *others = [line for line in told if line.startswith("parsph")]
    assert first == "parsph run pool --out runs/a --set time.end=10"
    assert others == ["parsph resume runs/a"] * 2
    assert told.count("mpirun -n 3") == 3


def test_local_called_again_goes_on(place):
    call(place, "local.sh", "pool", "runs/a", codes=(1,))
    _, _, told = call(place, "local.sh", "pool", "runs/a")
    assert told[1:] == ["parsph resume runs/a"]


@pytest.mark.parametrize("code", [1, 2, 130])
def test_local_stops_at_a_failure(place, code):
    got, _, told = call(place, "local.sh", "pool", "runs/a", codes=(85, code, 0))
    assert got == code
    assert len(told) == 4


def test_local_does_not_go_on_for_ever(place):
    code, printed, told = call(place, "local.sh", "pool", "runs/a", codes=(85,))
    assert code == 85
    assert len(told) == 2 * MOST
    assert "not finished yet" in printed


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP], ids=lambda number: number.name)
def test_local_passes_on_the_end_and_waits_for_the_checkpoint(place, number):
    program(place, "python", PATIENT_PYTHON)
    command = ["bash", "jobs/local.sh", "pool", "runs/a"]
    process = subprocess.Popen(command, cwd=place, env=environment(place), stdout=subprocess.PIPE, text=True)
    told = place / "told"
    deadline = time.monotonic() + 30
    while not (told.exists() and "started" in told.read_text()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.send_signal(number)
    printed, _ = process.communicate(timeout=30)
    assert process.returncode == 85
    assert told.read_text().splitlines()[1:] == ["started", "stopped"]
    assert "not finished yet" in printed


def test_local_without_a_folder_says_what_it_wants(place):
    code, printed, told = call(place, "local.sh", "pool")
    assert code == 2
    assert "SCENE FOLDER" in printed
    assert not told


def pbs(place, codes, **variables):
    """Run jobs/pbs.sh as a job on two cores of one node."""
    (place / "nodes").write_text("node1\nnode1\n")
    queue = {"PBS_O_WORKDIR": str(place), "PBS_NODEFILE": str(place / "nodes"), "PBS_JOBID": "7.server"}
    return call(place, "pbs.sh", codes=codes, **queue, **variables)


def test_pbs_submits_the_next_job_until_finished(place):
    code, _, told = pbs(place, (85, 85, 0), SCENE="seiche", OUT="runs/a")
    assert code == 0
    submission = "qsub jobs/pbs.sh with SCENE,OUT,JOB,PARSPH_PYTHON"
    go = ["mpirun -n 2", "parsph resume runs/a --walltime 01:30:00"]
    first = ["mpirun -n 2", "parsph run seiche --out runs/a --walltime 01:30:00"]
    assert told == [*first, submission, *go, submission, *go]


def test_pbs_stops_at_a_failure(place):
    code, _, told = pbs(place, (85, 1, 0))
    assert code == 1
    assert sum(line.startswith("parsph") for line in told) == 2


def test_pbs_does_not_go_on_for_ever(place):
    code, printed, told = pbs(place, (85,), JOB=str(MOST - 1))
    assert code == 85
    assert sum(line.startswith("parsph") for line in told) == 2
    assert f"not finished after {MOST} jobs" in printed


def slurm(place, script, *arguments, codes, restarts=None, **variables):
    """Run a Slurm script as the job 7 with four ranks, or as its task 3."""
    restarted = {} if restarts is None else {"SLURM_RESTART_COUNT": str(restarts)}
    job = {"SLURM_JOB_ID": "9", "SLURM_NTASKS": "4", "SLURM_ARRAY_JOB_ID": "7", "SLURM_ARRAY_TASK_ID": "3"}
    return call(place, script, *arguments, codes=codes, **job, **restarted, **variables)


SLURM = [("slurm.sh", ("pool", "runs/a"), "9"), ("slurm-study.sh", ("walls", "--out", "studies/a"), "7_3")]
either_slurm = pytest.mark.parametrize(("script", "arguments", "number"), SLURM, ids=[row[0] for row in SLURM])


@either_slurm
def test_slurm_requeues_what_is_not_finished(place, script, arguments, number):
    _, _, told = slurm(place, script, *arguments, codes=(85,), restarts=MOST - 1)
    assert told[0] == "mpirun -n 4"
    assert told[2:] == [f"scontrol requeue {number}"]


@either_slurm
@pytest.mark.parametrize("code", [0, 1, 2, 15])
def test_slurm_requeues_nothing_else(place, script, arguments, number, code):
    got, _, told = slurm(place, script, *arguments, codes=(code,))
    assert got == code
    assert not [line for line in told if "requeue" in line]


@either_slurm
def test_slurm_does_not_requeue_for_ever(place, script, arguments, number):
    code, printed, told = slurm(place, script, *arguments, codes=(85,), restarts=MOST)
    assert code == 85
    assert f"requeued {MOST} times" in printed
    assert not [line for line in told if "requeue" in line]


@either_slurm
def test_slurm_requeues_what_was_preempted_before_it_could_write_a_checkpoint(place, script, arguments, number):
    (place / "job").write_text("JobState=RUNNING\n PreemptTime=2026-01-01T00:00:00\n")
    _, _, told = slurm(place, script, *arguments, codes=(15,))
    assert told[-1] == f"scontrol requeue {number}"
    code, _, told = slurm(place, script, *arguments, codes=(1,))
    assert code == 1
    assert len(told) == 2


@either_slurm
def test_slurm_that_may_not_requeue_fails(place, script, arguments, number):
    (place / "disabled").touch()
    code, _, _ = slurm(place, script, *arguments, codes=(85,))
    assert code == 1


def test_slurm_goes_on_in_its_folder(place):
    _, _, told = slurm(place, "slurm.sh", "pool", "runs/a", "--set", "time.end=9", codes=(85,))
    assert told[1] == "parsph run pool --out runs/a --set time.end=9"
    _, _, told = slurm(place, "slurm.sh", "pool", "runs/a", "--set", "time.end=9", codes=(0,), restarts=1)
    assert told[1] == "parsph resume runs/a"


def test_slurm_study_names_the_row(place):
    _, _, told = slurm(place, "slurm-study.sh", "walls", "--out", "studies/a", codes=(0,))
    assert told[1] == "parsph study walls --out studies/a --row 3"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1], ids=lambda number: number.name)
def test_a_signal_that_no_run_waits_for_does_not_kill_it_halfway(tmp_path, number):
    """As when a job is preempted while its ranks begin, or warned as its run has ended: exit code 85, and the next go sees."""
    stopping = "import os, sys; from parsph import __main__, cli; cli.main = lambda: os.kill(os.getpid(), int(sys.argv[1]))"
    result = python("-c", f"{stopping}; __main__.main()", int(number), cwd=tmp_path)
    assert result.returncode == 85, result.stderr
