"""The command line as a user meets it: a process of its own, an empty folder."""

import json
import math
import re
import signal
import time

import h5py
import numpy as np
import pytest
from helpers import DROP, parsph, python, settings, start, why_no_mpi

from parsph import cli
from parsph import verify as verification
from parsph.errors import SceneError, paragraph
from parsph.io.tables import read_table
from parsph.waves import DamBreak

SHORT = settings(time__end=0.02, numerics__dx=0.1, output__snapshots__every=0.01)


def test_run_writes_a_numbered_folder_and_says_what_it_did(tmp_path):
    for number in ("001", "002"):
        result = parsph("run", "pool", *SHORT, cwd=tmp_path)
        assert result.returncode == 0, result.stderr
        folder = tmp_path / "runs" / f"pool-{number}"
        assert len(list((folder / "snapshots").iterdir())) == 3
        assert {path.name for path in folder.iterdir()} == {
            ".lock",
            "checkpoints",
            "gauges",
            "scene.json",
            "series.vtkhdf",
            "snapshots",
            "summary.json",
        }
    for part in ("1,210 particles", "dx = 0.1 m", "bytes per particle", "1 rank(s)", "time per phase", "steps,"):
        assert part in result.stdout, part
    assert "runs/pool-002" in result.stdout
    assert re.search(r"t =\s+0\.02", result.stdout), "no line at the end"
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["particles"], summary["ranks"], summary["time [s]"]) == (1210, 1, 0.02)
    assert summary["steps"] > 10
    assert summary["files"] >= 10


def test_a_second_process_compiles_nothing(tmp_path):
    """The first may have to; then all of it must come from the disk."""
    outputs = [parsph("run", "pool", *SHORT, cwd=tmp_path).stdout for _ in range(2)]
    assert "compiled" in outputs[0]
    assert "compiled code loaded in" in outputs[1], outputs[1]


def test_no_command_runs_the_pool():
    """Too long to run here: the default of the command is the default of ``run``."""
    called = []
    original, cli.run = cli.run, lambda *arguments, **_: called.append(arguments)
    try:
        cli.app([], standalone_mode=False)
    finally:
        cli.run = original
    assert [arguments[0] for arguments in called] == ["pool"]


def test_list_names_each_builtin_scene_in_a_line(tmp_path):
    result = parsph("list", cwd=tmp_path)
    assert result.returncode == 0
    names = [line.split()[0] for line in result.stdout.splitlines()]
    assert names == sorted(names)
    assert {"pool", "seiche", "still", "still-tank", "dam-break", "wedge-tank"} <= set(names)


def test_plan_says_what_is_modelled_what_is_not_and_what_it_costs(tmp_path):
    result = parsph("plan", "seiche", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    for part in (
        "drho_a/dt = sum_b m_b v_ab . grad_a W_ab",
        "molteni",
        "Szmidt",
        "wendland-c2",
        "bottom wall",
        "400 particles",
        "steps of",
        "evaluations",
        "on disk",
        "core",
        "velocity [m/s]",
    ):
        assert part.lower() in result.stdout.lower(), part
    left_out = result.stdout.split("not modelled")[1].split("fields")[0]
    for part in ("viscosity", "velocity smoothing", "wavemaker", "absorbing layer"):
        assert part in left_out
    assert not list(tmp_path.iterdir())


def test_show_prints_the_full_scene_or_the_schema(tmp_path):
    scene = json.loads(parsph("show", "pool", *settings(time__end=3), cwd=tmp_path).stdout)
    assert (scene["time"]["end"], scene["numerics"]["gamma"]) == (3.0, 7.0)
    schema = json.loads(parsph("show", "--schema", cwd=tmp_path).stdout)
    assert {"numerics", "time", "output"} <= set(schema["properties"])


def test_check_finds_no_fault_in_a_good_scene(tmp_path):
    result = parsph("check", "pool", cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    assert "no faults" in result.stdout


def test_check_prints_all_faults_at_once(tmp_path):
    bad = settings(time__dt=1, numerics__h_over_dx=9, numerics__c0=2)
    result = parsph("check", "pool", *bad, cwd=tmp_path)
    assert result.returncode == 2
    for key in ("time.dt", "numerics.h_over_dx", "numerics.c0"):
        assert f"error: {key}: " in result.stderr


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["run", "pol"], "did you mean 'pool'"),
        (["run", "pool", "--set", "time.ende=3"], "did you mean 'end'"),
        (["run", "pool", "--set", "time.end=soon"], "valid number"),
        (["run", "pool", "--set", "time.dt=1"], "unstable"),
        (["run", "pool", "--set", "gauges.0.x=99"], "outside the domain"),
        (["run", "pool", "--nonsense"], "--nonsense"),
        (["runn"], "runn"),
        (["plan", "nothing.toml"], "no scene"),
        (["run", "pool", "--out", "file/below"], "cannot write"),
        (["run", "pool", "--out", "file"], "exists"),
    ],
)
def test_bad_input_ends_with_2_without_traceback_or_output(tmp_path, arguments, text):
    (tmp_path / "file").write_text("a file, no folder")
    result = parsph(*arguments, cwd=tmp_path)
    assert result.returncode == 2, result.stderr
    assert text in result.stderr
    assert "Traceback" not in result.stderr + result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_output_is_never_overwritten_unasked(tmp_path):
    arguments = ("run", "pool", *SHORT, "--out", "mine")
    assert parsph(*arguments, cwd=tmp_path).returncode == 0
    before = (tmp_path / "mine" / "series.vtkhdf").stat().st_mtime_ns
    refused = parsph(*arguments, cwd=tmp_path)
    assert refused.returncode == 2
    assert "--overwrite" in refused.stderr
    assert (tmp_path / "mine" / "series.vtkhdf").stat().st_mtime_ns == before
    assert parsph(*arguments, "--overwrite", cwd=tmp_path).returncode == 0
    assert (tmp_path / "mine" / "series.vtkhdf").stat().st_mtime_ns > before


def test_failed_run_ends_with_1_and_keeps_the_last_good_snapshot(tmp_path):
    """A block of water falls into a pond: the density leaves the range of the scene."""
    (tmp_path / "drop.toml").write_text(DROP)
    result = parsph("run", "drop.toml", "--out", "mine", cwd=tmp_path)
    assert result.returncode == 1, result.stdout
    assert "Traceback" not in result.stderr
    assert re.search(r"error: particle \d+ .*density.*t = ", " ".join(result.stderr.split()))
    assert_readable(tmp_path / "mine", least=3, particles=480)


def assert_readable(folder, least=1, particles=1210):
    """What has the name of a snapshot is complete, the series holds them all, and the tables have whole rows."""
    paths = sorted((folder / "snapshots").glob("*.vtkhdf"))
    assert len(paths) >= least
    for path in paths:
        with h5py.File(path) as file:
            assert len(file["VTKHDF/Points"]) == particles
    with h5py.File(folder / "series.vtkhdf") as file:
        steps = len(file["VTKHDF/Steps/Values"])
        assert file["VTKHDF/Points"].shape == (steps * particles, 3)
        assert steps == len(paths)
    assert len(read_table(folder / "gauges" / "level-00.csv")["time [s]"]) >= 1


@pytest.mark.parametrize(
    "ranks", [None, pytest.param(2, marks=pytest.mark.skipif(bool(why_no_mpi()), reason=why_no_mpi() or "-"))]
)
def test_interrupt_ends_with_130_and_leaves_readable_files(tmp_path, ranks):
    """Ctrl-C in mid-run, of one rank or of a whole job; meanwhile the log has grown line by line."""
    many = settings(time__end=500, output__snapshots__every=0.01, output__log__every=0.01, numerics__dx=0.1)
    process = start("-m", "parsph", "run", "pool", *many, "--out", "mine", cwd=tmp_path, ranks=ranks)
    deadline = time.monotonic() + 120
    while len(list(tmp_path.glob("mine/snapshots/*.vtkhdf"))) < 3 and time.monotonic() < deadline:
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert re.search(r"^t = +0\.01", out, re.MULTILINE)
    assert_readable(tmp_path / "mine", least=3)


BLOCKED = "import sys; sys.modules['mpi4py'] = None\nfrom parsph.cli import main\nmain(sys.argv[1:])\n"


def test_one_rank_needs_no_mpi_library(tmp_path):
    result = python("-c", BLOCKED, "run", "pool", *SHORT, "--out", "mine", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert_readable(tmp_path / "mine", least=3)


def test_ranks_without_an_mpi_library_end_with_the_cure(tmp_path):
    """Otherwise every rank would run the whole scene, all into the same folder."""
    result = python("-c", BLOCKED, "run", "pool", *SHORT, cwd=tmp_path, environment={"PMI_SIZE": "2"})
    assert result.returncode == 2
    assert "pip install" in result.stderr
    assert not list(tmp_path.iterdir())


def test_bench_writes_its_table(tmp_path):
    result = parsph("bench", "--particles", 1000, "--repeats", 1, "--json", "b.json", cwd=tmp_path, timeout=300)
    assert result.returncode == 0, result.stderr
    *rows, fixed = json.loads((tmp_path / "b.json").read_text())
    assert {row["h_over_dx"] for row in rows} >= {1.3, 1.7, 2.0}
    for row in rows:
        assert {"sweep", "step", "plain", "particles", "h_over_dx", "precision"} <= set(row)
        assert min(row["sweep"], row["step"], row["plain"]) > 0
        assert row["step_over_plain"] == pytest.approx(row["step"] / row["plain"])
    assert {row["precision"] for row in rows} == {"float64", "float32"}
    assert {row["h_over_dx"] for row in rows if row["terms"] == "dam break"} == {1.3, 2.0}
    assert 0 < fixed["fixed cost of a step [s]"] < 0.1
    assert 0 < fixed["layer over step"] < 0.5
    assert (
        f"absorbing layer of the pool, half of its particles in it: {fixed['layer over step']:.1%} of a step" in result.stdout
    )
    assert set(fixed["ghosts over step"]) == {"hydrostatic", "mls1", "mls2", "sfdi", "shepard", "normalised"}
    assert all(0 < share < 1 for share in fixed["ghosts over step"].values())
    assert fixed["renormalised gradients"] > 1
    assert f"on {fixed['processor']}" in " ".join(result.stdout.split())


def test_verify_refuses_an_unknown_case(tmp_path):
    result = parsph("verify", "nonsense", cwd=tmp_path)
    assert result.returncode == 2
    names = ["seiche", "still", "pool-height", "pool-absorption", "poiseuille", "couette", "patch", "drop", "drops", "jet"]
    names += ["taylor-green", "interpolators", "still-tank", "dam-break", "wedge-tank", "kernels", "correction", "long-seiche"]
    names += ["long-still", "restart", "faults", "swe-pulse", "swe-dam-break", "soak", "strip", "deficiency", "sloshing"]
    names += ["breaker", "drop-pool", "active-absorption", "wavemaker", "solitary-wall", "movable-seawall"]
    assert f"one of {', '.join(names)}" in " ".join(result.stderr.split())
    assert "Traceback" not in result.stderr
    assert list(verification.CASES) == names


@pytest.mark.parametrize(
    "bars", [{"swe-dam-break": 5, "swe-pulse": 3}, {"kernels": 24, "correction": 10}, {"drop": 5}], ids=" and ".join
)
def test_quick_cases_meet_their_bars(tmp_path, bars):
    """Those that take seconds; the others are those of a release."""
    result = parsph("verify", *bars, "--quick", "--json", "v.json", cwd=tmp_path, timeout=300)
    assert result.returncode == 0, result.stdout
    rows = json.loads((tmp_path / "v.json").read_text())
    assert all(row["pass"] for row in rows)
    for row in rows:
        assert row["pass"] == (row["bar"] is None or abs(row["value"]) <= row["bar"])
        assert re.search(rf"{row['case']} +│ {re.escape(row['metric'])} +│", result.stdout), row
    assert {case: sum(row["case"] == case and row["bar"] is not None for row in rows) for case in bars} == bars
    assert {row["metric"] for row in rows if row["unit"] == "CPU s"} == {"cost"}


def test_a_missed_bar_ends_with_1(tmp_path, monkeypatch, capsys):
    """However far and on which side it is missed, and whatever came before it."""
    cases = {"good": [("a", -1.0, "%", 1.0), ("b", 7.0, "", None)], "bad": [("c", -1.1, "%", 1.0)]}
    made = {name: (lambda quick, rows=rows: iter(rows)) for name, rows in cases.items()}
    monkeypatch.setattr(verification, "CASES", made)
    for names, code in ((["good"], 0), (["bad"], 1), (["bad", "good"], 1), ([], 1)):
        with pytest.raises(SystemExit) as end:
            cli.main(["verify", *names, "--json", str(tmp_path / "v.json")])
        assert (end.value.code or 0) == code, names
    capsys.readouterr()
    rows = json.loads((tmp_path / "v.json").read_text())
    assert [(row["case"], row["metric"], row["pass"]) for row in rows if row["metric"] != "cost"] == [
        ("good", "a", True),
        ("good", "b", True),
        ("bad", "c", False),
    ]


# Depth and speed behind the bore and the bore's speed, in h_l and sqrt(g h_l), after Stoker (1957).
BORES = [(0.1, 0.39617, 0.74115, 0.99139), (0.5, 0.72692, 0.29481, 0.94439)]


@pytest.mark.parametrize(("ratio", "middle", "speed", "bore"), BORES)
@pytest.mark.parametrize(("left", "gravity"), [(1.0, 1.0), (2.5, 9.81)])
def test_a_dam_over_wet_ground_breaks_as_stoker_says(ratio, middle, speed, bore, left, gravity):
    dam, t = DamBreak(left, ratio * left, gravity), 3.0
    c = math.sqrt(gravity * left)
    assert dam.bore == pytest.approx(bore * c, rel=1e-5)
    place = np.array([-1.01 * c, 0.999 * dam.bore, 1.001 * dam.bore]) * t
    assert dam.depth(place, t) == pytest.approx([left, middle * left, ratio * left], rel=2e-5)
    behind = dam.bore * (1 - ratio / middle)  # the bore takes up water at rest: u_m = S (1 - h_r/h_m)
    assert behind == pytest.approx(speed * c, rel=5e-5)
    assert behind + 2 * math.sqrt(gravity * middle * left) == pytest.approx(2 * c, rel=2e-5)
    x = np.linspace(-2 * c, 2 * c, 400_001) * t
    depth = dam.depth(x, t)
    assert np.trapezoid(depth, x) == pytest.approx(2 * c * t * left * (1 + ratio), rel=1e-5)  # no water is lost
    fan = (x > -c * t) & (depth > 1.0001 * middle * left)
    assert np.allclose(depth[fan], (2 * c - x[fan] / t) ** 2 / (9 * gravity), rtol=1e-12)


@pytest.mark.parametrize(("left", "gravity"), [(1.0, 1.0), (0.4, 9.81)])
def test_a_dam_over_dry_ground_breaks_as_ritter_says(left, gravity):
    dam, t = DamBreak(left, 0.0, gravity), 5.0
    c = math.sqrt(gravity * left)
    assert dam.bore == pytest.approx(2 * c, rel=1e-12)
    steps = np.array([-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.9, 2.0, 2.5])
    expected = left * np.array([9.0, 9.0, 6.25, 4.0, 2.25, 1.0, 0.01, 0.0, 0.0]) / 9
    np.testing.assert_allclose(dam.depth(steps * c * t, t), expected, atol=1e-12)


def test_paths_in_messages_stay_whole():
    """They are copied from there: a line may not end within one, at a hyphen or elsewhere."""
    path = "/scratch/" + "a-long-name-" * 12 + "end/study-001"
    message = paragraph(SceneError("interrupted", where="x", cure=f"go on with --resume --out {path}"))
    assert path in message


def test_version_and_help_answer_without_the_solver(tmp_path):
    """Neither numba nor pydantic is loaded for them."""
    script = "import sys\nfrom parsph.cli import app\ntry: app(sys.argv[1:])\n"
    script += "finally: assert not {'numba', 'pydantic'} & set(sys.modules)\n"
    for option in ("--version", "--help"):
        result = python("-c", script, option, cwd=tmp_path)
        assert result.returncode == 0, result.stderr
        assert "parsph" in result.stdout.lower()


def test_a_scene_file_is_found_from_where_the_user_is(tmp_path):
    (tmp_path / "scenes").mkdir()
    toml = "[domain]\nsize=[0.2,0.3]\n[fluid]\nblocks=[{low=[0,0],high=[0.2,0.2]}]\n[numerics]\ndx=0.02\n[time]\nend=0\n"
    (tmp_path / "scenes" / "mine.toml").write_text(toml)
    result = parsph("check", "scenes/mine.toml", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
