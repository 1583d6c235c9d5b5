"""Studies: declared, run, interrupted, gone on with, reported. Their rows are humps on shallow water, 130 particles each."""

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import parsph, start, why_no_mpi

from parsph.errors import SceneError, SceneFaults
from parsph.io.tables import read_table
from parsph.study import command as study_command
from parsph.study.declare import builtin_names, load_study
from parsph.study.metrics import METRICS

needs_mpi = pytest.mark.skipif(bool(why_no_mpi()), reason=why_no_mpi() or "-")

# Five rows; the depth of the last leaves its range at once.
HUMP = """
title = "a hump, and layers of two lengths"
base = "swe-pulse"
metrics = ["reflection-ratio", "energy-difference", "residual-energy"]
references = { infinite = "infinite", reflecting = "reflecting" }

[settings]
"numerics.dx" = 4.0
"numerics.h_over_dx" = 2.0
"time.end" = 80.0
"output.snapshots.every" = 80.0
gauges = [{ kind = "energy", every = 4.0 }]

[[groups]]
name = "infinite"
base = "swe-pulse-infinite"

[[groups]]
name = "reflecting"
base = "swe-pulse-reflecting"

[[groups]]
name = "layers"
[groups.axes.length]
20 = { "domain.size" = [520.0], "fluid.blocks.0.high" = [520.0], "damping.0.length" = 20.0 }
50 = {}

[[groups]]
name = "narrow"
settings = { "numerics.density_range" = [0.9999, 1.1] }
"""
ROWS = ["infinite", "reflecting", "layers_20", "layers_50", "narrow"]
GOOD = ROWS[:-1]
TIMES = ("cpu", "wall", "damping")
BUILTIN = ["absorbing-1d", "absorbing-2d", "deficiency", "seiche", "wall-treatments", "walls", "work-precision"]


@pytest.fixture
def place(tmp_path, monkeypatch):
    """An empty folder, the present one, with hump.toml in it."""
    (tmp_path / "hump.toml").write_text(HUMP)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The folder that the study leaves when nothing disturbs it, and the process."""
    folder = tmp_path_factory.mktemp("hump")
    (folder / "hump.toml").write_text(HUMP)
    result = parsph("study", "hump.toml", "--out", "out", cwd=folder)
    return folder / "out", result


def declared(folder, text, quick=False):
    path = folder / "mine.toml"
    path.write_text(text)
    return load_study(path, quick)


def refused(folder, text):
    """What is said against a study and its scenes."""
    with pytest.raises(SceneError) as error:
        declared(folder, text).scenes()
    return str(error.value)


def stamps(folder):
    """Which file each path is, and when it was written."""
    paths = [path for path in folder.rglob("*") if path.is_file()]
    return {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in paths}


def summaries(folder):
    return {path.parent.name for path in folder.glob("rows/*/summary.json")}


def table(folder):
    """Return {column: array} of results.h5."""
    with h5py.File(folder / "results.h5") as file:
        return {name: data.asstr()[:] if data.dtype == object else data[:] for name, data in file.items()}


def assert_same_table(folder, other, but=TIMES):
    mine, theirs = table(folder), table(other)
    assert mine.keys() == theirs.keys()
    for name in mine.keys() - set(but):
        np.testing.assert_array_equal(mine[name], theirs[name], err_msg=name)


# --- declared -----------------------------------------------------------------------------------------------------------


def test_rows_are_all_combinations_of_labels_in_order(tmp_path):
    text = """
    metrics = []
    base = "still"
    [[groups]]
    name = "alone"
    [[groups]]
    name = "grid"
    base = "seiche"
    [groups.axes.size]
    "1/2" = { "a" = 1 }
    "1" = { "a" = 2 }
    [groups.axes.way]
    "up & down" = { "b" = 1 }
    left = { "b" = 2 }
    right = { "b" = 3 }
    """
    study = declared(tmp_path, text)
    alone, *rows = study.rows
    assert (alone.name, alone.base, alone.labels, alone.overrides) == ("alone", "still", {}, {})
    assert [(row.overrides["a"], row.overrides["b"]) for row in rows] == [(a, b) for a in (1, 2) for b in (1, 2, 3)]
    assert rows[0].labels == {"size": "1/2", "way": "up & down"}
    assert {(row.group, row.base) for row in rows} == {("grid", "seiche")}
    assert (study.name, study.title, study.axes) == ("mine", "mine", ["size", "way"])
    assert [row.name for row in rows[:2]] == ["grid_1-2_up-down", "grid_1-2_left"]


def test_names_are_folders_of_their_own(tmp_path):
    """Labels and groups that only differ in what a file name cannot have, or none at all: told apart, or refused."""
    shared = 'metrics = []\nbase = "still"\n'
    one = '[[groups]]\nname = "a"\n[groups.axes.l]\n"1/2" = {}\n"1-2" = { "time.end" = 5.0 }\n'
    two = '[[groups]]\nname = "a"\n[groups.axes.l]\nb_c = {}\n[[groups]]\nname = "a_b"\n[groups.axes.l]\nc = {}\n'
    for text in (one, two, '[[groups]]\nname = ".."\n', '[[groups]]\nname = ""\n', '[[groups]]\nname = "a/../b"\n'):
        try:
            names = [row.name for row in declared(tmp_path, shared + text).rows]
        except SceneError:
            continue
        assert len(set(names)) == len(names), names
        assert all(name.strip(".") and Path(name).name == name for name in names), names


@pytest.mark.parametrize("quick", [False, True])
def test_the_nearer_setting_wins(tmp_path, quick):
    """Study, quick, group, first axis, second axis, --set: each may change what those before it say, and leaves the rest."""
    text = """
    metrics = []
    settings = { "study" = 1, "quick" = 1, "group" = 1, "first" = 1, "second" = 1, "set" = 1 }
    quick = { "quick" = 2, "group" = 2, "first" = 2, "second" = 2, "set" = 2 }
    [[groups]]
    name = "x"
    settings = { "group" = 3, "first" = 3, "second" = 3, "set" = 3 }
    [groups.axes]
    one.label = { "first" = 4, "second" = 4, "set" = 4 }
    two.label = { "second" = 5, "set" = 5 }
    """
    study = declared(tmp_path, text, quick)
    overrides = {"study": 1, "quick": 2 if quick else 1, "group": 3, "first": 4, "second": 5, "set": 5}
    assert study.rows[0].overrides == overrides
    assert study.overridden({"set": 6}).rows[0].overrides == {**overrides, "set": 6}


def test_keys_may_be_dotted_with_or_without_quotes(tmp_path):
    text = """
    metrics = []
    base = "still"
    settings.numerics.dx = 0.02
    settings.time.end = 3
    [quick]
    "numerics.dx" = 0.03
    [[groups]]
    name = "x"
    settings = { output.snapshots.every = 2.0, "time.end" = 4 }
    [groups.axes.a.b]
    numerics.alpha = 0.5
    walls.top.slip = "no"
    """
    dx = {False: 0.02, True: 0.03}
    for quick in (False, True):
        scene = declared(tmp_path, text, quick).scenes()["x_b"]
        assert (scene.numerics.dx, scene.time.end, scene.numerics.alpha) == (dx[quick], 4.0, 0.5)
        assert (scene.output.snapshots.every, scene.numerics.diffusion) == (2.0, "fourtakas")
        assert scene.walls.top.slip == "no"


def test_a_section_without_keys_is_one(tmp_path):
    """A wall needs no keys."""
    text = 'metrics = []\nbase = "still"\n[[groups]]\nname = "x"\nsettings = { "walls.top" = {} }\n'
    assert declared(tmp_path, text).scenes()["x"].walls.top is not None


def test_references_share_labels(tmp_path):
    text = """
    metrics = []
    references = { infinite = "far" }
    [[groups]]
    name = "far"
    axes = { width = { 9 = {}, 18 = {} } }
    [[groups]]
    name = "own"
    axes = { width = { 18 = {}, 9 = {} } }
    [[groups]]
    name = "both"
    axes = { length = { 1 = {}, 2 = {} }, width = { 18 = {}, 9 = {}, 27 = {} } }
    [[groups]]
    name = "none"
    axes = { length = { 1 = {}, 2 = {} } }
    [[groups]]
    name = "other"
    axes = { width = { 9 = {}, 18 = {} } }
    references = { infinite = "own", reflecting = "far" }
    """
    study = declared(tmp_path, text)
    found = {row.name: getattr(study.reference(row, "infinite"), "name", None) for row in study.rows}
    assert found == {
        "far_9": None,
        "far_18": None,
        "own_18": None,  # as others are compared with it
        "own_9": None,
        "both_1_18": "far_18",
        "both_1_9": "far_9",
        "both_1_27": None,
        "both_2_18": "far_18",
        "both_2_9": "far_9",
        "both_2_27": None,
        "none_1": "far_9",
        "none_2": "far_9",
        "other_9": "own_9",
        "other_18": "own_18",
    }
    roles = [study.reference(row, "reflecting") for row in study.rows]
    assert [row.name for row in roles if row] == ["far_9", "far_18"]


@pytest.mark.parametrize("quick", [True, False])
@pytest.mark.parametrize("name", builtin_names())
def test_builtin_studies_compare_what_can_be_compared(name, quick):
    study = load_study(name, quick)
    names = [row.name for row in study.rows]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[\w.-]+", name) for name in names)
    scenes = study.scenes()
    assert list(scenes) == names
    roles = {role for metric in study.metrics for role in METRICS[metric].roles}
    compared = {group for holder in (study, *study.groups) for group in holder.references.values()}
    for row in (row for row in study.rows if row.group not in compared):
        scene = scenes[row.name]
        for role in roles:
            other = scenes[study.reference(row, role).name]
            own = {"alpha"} if "reflecting" in row.group else set()  # of the pool in resonance, see its scene
            assert other.numerics.model_dump(exclude=own) == scene.numerics.model_dump(exclude=own)
            assert (other.domain.gravity, other.time) == (scene.domain.gravity, scene.time)
            assert (other.gauges, other.wavemaker, other.output) == (scene.gauges, scene.wavemaker, scene.output)
            apart = {"low", "high"}
            blocks = [[block.model_dump(exclude=apart) for block in s.fluid.blocks] for s in (scene, other)]
            assert blocks[0] == blocks[1], row.name
        assert not roles or scene.damping or "reflecting" in row.group


def test_quick_is_the_smaller_size():
    for name in builtin_names():
        quick, full = (load_study(name, quick).rows for quick in (True, False))
        assert 1 < len(quick) < len(full)


@pytest.mark.parametrize(
    ("head", "groups", "texts"),
    [
        ('metrics = ["reflektion"]', '[[groups]]\nname = "a"', ["metrics.0", "unknown metric", "did you mean 'reflection'"]),
        (
            'metrics = ["incident", "level-difference"]',
            '[[groups]]\nname = "a"',
            ["metrics.1: 'level-difference' compares with infinite", "[references] infinite"],
        ),
        (
            'metrics = ["reflection-ratio"]\nreferences = { infinite = "a" }',
            '[[groups]]\nname = "a"',
            ["compares with reflecting"],
        ),
        (
            'metrics = []\nreferences = { infinite = "b" }',
            '[[groups]]\nname = "a"',
            ["references.infinite: no group 'b'; one of: a"],
        ),
        ("metrics = []", '[[groups]]\nname = "a"\nreferences = { far = "b" }', ["groups.0.references.far: no group 'b'"]),
        ("metrics = []", '[[groups]]\nname = "a"\n[[groups]]\nname = "a"', ["groups: two groups are called 'a'"]),
        ("metrics = []\nmetric = 3", '[[groups]]\nname = "a"', ["metric: unknown key", "did you mean 'metrics'"]),
        ("metrics = []", '[[groups]]\nname = "a"\naxis = {}', ["groups.0.axis: unknown key", "did you mean 'axes'"]),
        ("", '[[groups]]\nname = "a"', ["metrics: is missing"]),
        ("metrics = []", "", ["groups: is missing"]),
        ("metrics = []", "[[groups]]", ["groups.0.name: is missing"]),
        ("metrics = []\ngroups = []", "", ["groups: "]),
        ("metrics = [", "", ["mine.toml: not valid TOML"]),
        ("metrics = []", '[[groups]]\nname = "a"\nbase = "pol"', ["row a: no scene 'pol'", "did you mean 'pool'"]),
    ],
)
def test_a_wrong_declaration_is_refused_with_the_place(tmp_path, head, groups, texts):
    message = refused(tmp_path, f"{head}\n{groups}\n")
    assert len(message.splitlines()) == 1, message
    for text in texts:
        assert text in message


def test_all_faults_of_a_declaration_come_at_once(tmp_path):
    head = 'metrics = ["nonsense", "reflection-ratio"]\nreferences = { far = "b" }\n'
    message = refused(tmp_path, head + '[[groups]]\nname = "a"\n[[groups]]\nname = "a"\n')
    assert len(message.splitlines()) == 4


def test_no_such_study(tmp_path):
    with pytest.raises(SceneError, match=r"did you mean 'absorbing-1d'.*absorbing-2d"):
        load_study("absorbing1d")
    (tmp_path / "picture.toml").write_bytes(b"\xff\xd8\xff")
    with pytest.raises(SceneError, match="cannot be read"):
        load_study(tmp_path / "picture.toml")


def test_faults_of_scenes_name_row_and_key_and_how_many_share_them(tmp_path):
    text = """
    metrics = []
    base = "swe-pulse"
    [[groups]]
    name = "good"
    [[groups]]
    name = "bad"
    axes = { dx = { 1 = {}, 2 = {}, 3 = { "domain.gravity" = -1.0 } } }
    settings = { "time.ende" = 4.0 }
    """
    with pytest.raises(SceneFaults) as error:
        declared(tmp_path, text).scenes()
    shared, own = error.value.faults
    assert str(shared).startswith("row bad_1 and 2 more: time.ende: unknown key; did you mean 'end'")
    assert str(own).startswith("row bad_3: domain.gravity: ")


LEVELS = 'gauges = [{{ kind = "level", x = {} }}, {{ kind = "level", x = {} }}, {{ kind = "level", x = {} }}]'


@pytest.mark.parametrize(
    ("metric", "base", "settings", "text"),
    [
        ("reflection", "pool", LEVELS.format(1.0, 2.0, 3.0), "three gauges, not 2"),  # the first is in the near field
        ("incident", "pool", LEVELS.format(2.0, 5.0305, 8.061), "multiples of half a wavelength apart"),
        ("reflection", "still", "", "metric reflection: needs a wavemaker"),
        ("reflection", "pool", LEVELS.format(2.0, 3.0, 4.0) + '\n"time.end" = 8.9', "time.end of at least 8.95 s"),
        ("level-difference", "still", "", "needs a gauge of level"),
        ("energy-excess", "pool", LEVELS.format(2.0, 3.0, 4.0), "needs a gauge of energy"),
        ("residual-energy", "pool", "gauges = []", "needs a gauge of energy"),
        ("reflection-ratio", "pool", "", "metric reflection-ratio: is for shallow water"),
        ("reflection", "pool", LEVELS.format(2.0, 3.0, 4.0) + '\n"time.end" = 9.0', ""),
        ("reflection-ratio", "swe-pulse", "", ""),
        ("energy-excess", "still", "", ""),
    ],
)
def test_metrics_demand_of_a_scene_what_they_measure(tmp_path, metric, base, settings, text):
    """Of all rows but those that others are compared with."""
    roles = 'references = { infinite = "far", reflecting = "far" }\n'
    groups = (
        f'[[groups]]\nname = "far"\nbase = "seiche"\n[groups.settings]\ngauges = []\n[[groups]]\nname = "a"\nbase = "{base}"\n'
    )
    text_of = f'metrics = ["{metric}"]\n{roles}{groups}[groups.settings]\n{settings}\n'
    if not text:
        assert len(declared(tmp_path, text_of).scenes()) == 2
        return
    message = refused(tmp_path, text_of)
    assert message.startswith("row a: ")
    assert text in message


# --- run ----------------------------------------------------------------------------------------------------------------


def test_a_study_ends_with_0_though_a_row_failed(finished):
    folder, result = finished
    assert result.returncode == 0, result.stderr
    assert "hump: 5 rows, 0 finished" in result.stdout
    for row in ROWS:
        assert len(re.findall(rf"^\[\d/5\] {row}: ", result.stdout, re.MULTILINE)) == 1
    assert "4 of 5 rows finished; 1 failed" in result.stdout
    assert {path.name for path in folder.iterdir()} == {
        "results.csv",
        "results.h5",
        "report.md",
        "figures",
        "scenes",
        "rows",
        "logs",
        "failed",
    }
    assert summaries(folder) == set(GOOD)
    assert {path.stem for path in folder.glob("scenes/*")} == {path.stem for path in folder.glob("logs/*")} == set(ROWS)


def test_the_tables_agree_and_every_finished_row_has_its_numbers(finished):
    folder, _ = finished
    columns = table(folder)
    assert list(columns["row"]) == ROWS
    assert list(columns["group"]) == ["infinite", "reflecting", "layers", "layers", "narrow"]
    assert list(columns["length"]) == ["", "", "20", "50", ""]
    assert list(columns["status"]) == ["finished"] * 4 + ["failed"]
    with open(folder / "results.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert {"cpu [s]", "particles", "reflection-ratio"} <= set(header)
    assert {name.split(" [")[0] for name in header} == set(columns)
    for name, values in zip(header, zip(*rows, strict=True), strict=True):
        stored = columns[name.split(" [")[0]]
        text = stored.dtype == object
        np.testing.assert_array_equal(np.array(values, dtype=None if text else float), stored, err_msg=name)
    for name in ("residual-energy", "particles", "steps", "evaluations", "cpu", "wall", "ranks"):
        assert (columns[name][:-1] > 0).all(), name
        assert np.isnan(columns[name][-1]), name
    assert list(columns["particles"][:-1]) == [250, 125, 130, 138]
    assert (columns["evaluations"][:-1] >= columns["particles"][:-1] * columns["steps"][:-1]).all()
    assert list(np.isfinite(columns["reflection-ratio"])) == [False, False, True, True, False]
    assert list(np.isfinite(columns["energy-difference"])) == [False, True, True, True, False]
    assert 0 < columns["reflection-ratio"][3] < columns["reflection-ratio"][2] < 0.5  # the longer layer is the better


def test_metrics_are_those_of_the_analysis(finished, command, tmp_path):
    folder, _ = finished
    runs = [folder / "rows" / name for name in ("layers_50", "reflecting", "infinite")]
    code, _, _ = command("analyse", "ratio", *runs, "--json", tmp_path / "r.json")
    assert code == 0
    (row,) = json.loads((tmp_path / "r.json").read_text())
    assert row == {"time [s]": 80.0, "reflection ratio": table(folder)["reflection-ratio"][3]}
    energy = read_table(runs[0] / "gauges" / "energy-00.csv")["kinetic energy [J]"]
    assert table(folder)["residual-energy"][3] == energy[-1] / energy.max()


def test_the_report_has_its_pictures_and_all_rows(finished):
    folder, _ = finished
    report = (folder / "report.md").read_text()
    assert report.startswith("# a hump, and layers of two lengths\n")
    assert "4 of 5 rows finished" in report
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", report)
    assert sorted(pictures) == sorted(str(path.relative_to(folder)) for path in folder.glob("figures/*"))
    assert len(set(pictures)) == 6  # each metric against cost and along the length
    for picture in pictures:
        assert (folder / picture).read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    for row in ROWS:
        assert re.search(rf"^\| {row} \|", report, re.MULTILINE)


def test_a_failed_row_is_recorded_with_its_reason(finished):
    folder, result = finished
    assert [path.name for path in (folder / "failed").iterdir()] == ["narrow.json"]
    failure = json.loads((folder / "failed" / "narrow.json").read_text())
    assert (failure["row"], failure["exit code"]) == ("narrow", 1)
    assert re.search(r"particle \d+ .* outside the range .*density_range", failure["why"])
    assert f"- `narrow`: {failure['why']}" in (folder / "report.md").read_text()
    assert f"narrow: FAILED: {failure['why']}" in result.stdout


@pytest.mark.parametrize("where", ["out", "file"])
def test_when_all_rows_fail_it_ends_with_1_and_the_whole_reason(place, command, where):
    """A row that cannot write where it should says so in the first line of its log, over several lines."""
    only = HUMP[: HUMP.index("[[groups]]")].replace("references", "# ").replace('"reflection-ratio", "energy-difference", ', "")
    if where == "out":
        only = only.replace("[settings]", '[settings]\n"numerics.density_range" = [0.9999, 1.1]')
    (place / "only.toml").write_text(only + '[[groups]]\nname = "a"\n')
    if where == "file":
        (place / "out" / "rows").mkdir(parents=True)
        (place / "out" / "rows" / "a").write_text("no folder")
    code, _, err = command("study", "only.toml", "--out", place / "out", *["--resume"] * (where == "file"))
    assert code == 1, err
    reason = "density_range" if where == "out" else "--out: cannot write to"
    assert "all rows failed" in err
    assert reason in err
    assert reason in json.loads((place / "out" / "failed" / "a.json").read_text())["why"]
    assert "Traceback" not in err
    assert list(table(place / "out")["status"]) == ["failed"]


def test_resume_runs_failed_and_missing_rows_alone(finished, place, command):
    folder = shutil.copytree(finished[0], place / "out")
    shutil.rmtree(folder / "rows" / "layers_20")
    for part in ("figures", "report.md", "results.csv", "results.h5"):
        shutil.rmtree(folder / part) if (folder / part).is_dir() else (folder / part).unlink()
    (folder / "failed" / "layers_20.json").write_text('{"row": "layers_20", "exit code": 1, "why": "the disk was full"}')
    kept = [name for name in GOOD if name != "layers_20"]
    before = {name: stamps(folder / "rows" / name) for name in kept}
    log = stamps(folder / "logs")
    code, out, err = command("study", "hump.toml", "--resume", "--out", "out")
    assert code == 0, err
    assert "5 rows, 3 finished" in out
    assert {name: stamps(folder / "rows" / name) for name in kept} == before
    changed = {path.stem for path, stamp in stamps(folder / "logs").items() if stamp != log[path]}
    assert changed == {"layers_20", "narrow"}
    assert [path.stem for path in (folder / "failed").iterdir()] == ["narrow"]
    assert_same_table(folder, finished[0])
    assert (folder / "report.md").exists()


def left_running(folder):
    """Command lines of processes that work in a folder."""
    lines = subprocess.run(["ps", "-ww", "-eo", "args"], capture_output=True, text=True, check=True).stdout.splitlines()
    return [line for line in lines if str(folder) in line and "parsph run" in line]


def in_mid_study(folder, done, since):
    """Whether more rows have finished than those that are `done`, and another one, begun after `since`, has not."""
    begun = {path.parent.name for path in folder.glob("rows/*/scene.json") if path.stat().st_mtime > since}
    return summaries(folder) > done and begun - summaries(folder)


def test_interrupted_studies_go_on_where_they_were(finished, place, command):
    """Ctrl-C twice: once the study's process alone has it, once its rows have it too, as from a terminal."""
    out = place / "out"
    arguments = ["-m", "parsph", "study", "hump.toml", "--out", out]
    done = set()
    for jobs in (1, 2):
        since = time.time()
        if jobs == 1:
            process = start(*arguments, "--jobs", jobs, cwd=place)
        else:
            pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
            words = [sys.executable, *map(str, arguments), "--jobs", str(jobs), "--resume"]
            process = subprocess.Popen(words, cwd=place, stdin=subprocess.DEVNULL, **pipes)
        deadline = time.monotonic() + 60
        while not in_mid_study(out, done, since) and time.monotonic() < deadline:
            assert process.poll() is None, process.communicate()
            time.sleep(0.01)
        (os.kill if jobs == 1 else os.killpg)(process.pid, signal.SIGINT)
        printed, err = process.communicate(timeout=30)
        assert process.returncode == 130, err
        assert "Traceback" not in err
        assert f"--resume--out{out}" in "".join(err.split()), err
        assert not left_running(place)
        assert done < summaries(out) < set(GOOD)
        done = summaries(out)
        assert jobs > 1 or len(done) == 1, "the row that ran was stopped"
        assert not (out / "report.md").exists()
        status = dict(zip(table(out)["row"], table(out)["status"], strict=True))
        assert {name for name in ROWS if status[name] == "finished"} == done
        assert {name for name in GOOD if status[name] == "failed"} == set(), "interrupted is not failed"
    before = {name: stamps(out / "rows" / name) for name in done}
    code, printed, err = command("study", "hump.toml", "--resume", "--out", out)
    assert code == 0, err
    assert f"5 rows, {len(done)} finished" in printed
    assert {name: stamps(out / "rows" / name) for name in done} == before
    assert_same_table(out, finished[0])


def test_a_folder_that_is_not_empty_is_left_alone(finished, place, command):
    shutil.copytree(finished[0], place / "out")
    (place / "other").mkdir()
    (place / "other" / "letter.txt").write_text("Dear")
    (place / "file").write_text("a file")
    before = stamps(place)
    for folder in ("out", "other", "file"):
        code, _, err = command("study", "hump.toml", "--out", folder)
        assert code == 2
        assert "error: --out: " in err
    assert stamps(place) == before
    assert "--resume" in command("study", "hump.toml", "--out", "out")[2]


def test_a_file_in_place_of_the_folder_is_bad_input(place, command):
    (place / "file").write_text("a file")
    for more in (["--resume"], ["--row", "0"]):
        code, _, err = command("study", "hump.toml", "--out", "file", *more)
        assert code == 2
        assert "error: --out: " in err


@pytest.mark.parametrize(
    ("old", "new", "more", "row"),
    [("", "", ["--set", "time.end=81"], "infinite"), ("50 = {}", '50 = { "damping.0.v_ref" = 2.0 }', [], "layers_50")],
)
def test_other_settings_do_not_mix_with_finished_rows(finished, place, command, old, new, more, row):
    """Neither of the command line nor of the study itself."""
    (place / "hump.toml").write_text(HUMP.replace(old, new))
    shutil.copytree(finished[0], place / "out")
    before = stamps(place)
    code, _, err = command("study", "hump.toml", "--resume", "--out", "out", *more)
    assert code == 2
    assert f"row {row} is declared otherwise" in err
    assert stamps(place) == before


def test_resume_needs_the_folder(place, command):
    code, _, err = command("study", "hump.toml", "--resume")
    assert code == 2
    assert "--out DIR" in err
    assert [path.name for path in place.iterdir()] == ["hump.toml"]


def test_rows_one_by_one_make_the_same_table(finished, place, command):
    """As tasks of a job array: by number or name, any of them twice, in any order."""
    for row in ("2", "0", "layers_50", "reflecting"):
        code, out, err = command("study", "hump.toml", "--out", "out", "--row", row)
        assert code == 0, err
    assert summaries(place / "out") == set(GOOD)
    assert not (place / "out" / "results.csv").exists()
    before = stamps(place / "out" / "rows")
    code, out, _ = command("study", "hump.toml", "--out", "out", "--row", "layers_20")
    assert code == 0
    assert "finished already" in out
    assert stamps(place / "out" / "rows") == before
    code, out, err = command("study", "hump.toml", "--out", "out", "--row", "4")
    assert code == 1
    assert "density_range" in err
    assert "density_range" in json.loads((place / "out" / "failed" / "narrow.json").read_text())["why"]
    code, out, err = command("study", "hump.toml", "--out", "out", "--resume")
    assert code == 0, err
    assert "5 rows, 4 finished" in out
    assert_same_table(place / "out", finished[0])


@pytest.mark.parametrize("row", ["5", "-1", "nonsense", "²"])
def test_a_wrong_row_is_bad_input(place, command, row):
    code, _, err = command("study", "hump.toml", "--out", "out", f"--row={row}")
    assert code == 2
    assert f"no row '{row}'; 0 to 4" in err
    assert [path.name for path in place.iterdir()] == ["hump.toml"]


def test_a_row_needs_the_folder_of_its_study(place, command):
    code, _, err = command("study", "hump.toml", "--row", "0")
    assert code == 2
    assert "--out DIR" in err


@pytest.mark.parametrize(("metric", "gauge"), [("level-difference", '"level", x = 400.0'), ("energy-difference", '"energy"')])
def test_a_metric_that_cannot_be_measured_is_no_end_of_the_others(place, command, metric, gauge):
    """A row that is longer than what it is compared with: no number there, all others in the table."""
    text = f"""
    base = "swe-pulse"
    metrics = ["{metric}"]
    references = {{ infinite = "infinite" }}
    [settings]
    "numerics.dx" = 4.0
    "time.end" = 4.0
    gauges = [{{ kind = {gauge}, every = 1.0 }}]
    [[groups]]
    name = "infinite"
    base = "swe-pulse-infinite"
    [[groups]]
    name = "longer"
    settings = {{ "time.end" = 8.0 }}
    [[groups]]
    name = "same"
    """
    (place / "mine.toml").write_text(text)
    for row in range(3):
        assert command("study", "mine.toml", "--out", "out", "--row", row)[0] == 0
    code, _, err = command("study", "mine.toml", "--out", "out", "--resume")
    assert "Traceback" not in err
    assert list(np.isnan(table(place / "out")[metric])) == [True, True, False]
    assert code == 0, err
    assert f"`longer`, {metric}: " in (place / "out" / "report.md").read_text()


# --- ranks --------------------------------------------------------------------------------------------------------------


@needs_mpi
def test_two_ranks_give_the_metrics_of_one(finished, place, command):
    """Rows that fail say why without what the launcher adds."""
    folder = shutil.copytree(finished[0], place / "out")
    shutil.rmtree(folder / "rows" / "layers_50")
    code, _, err = command("study", "hump.toml", "--resume", "--out", "out", "--ranks", "2")
    assert code == 0, err
    assert list(table(folder)["ranks"][:-1]) == [1, 1, 1, 2]
    assert_same_table(folder, finished[0], (*TIMES, "ranks"))
    failures = [json.loads((where / "failed" / "narrow.json").read_text()) for where in (folder, finished[0])]
    assert failures[0] == failures[1]


@needs_mpi
def test_ranks_are_those_of_rows(finished, place):
    """Under mpirun a study would be run by every rank; a row may be, and says when it fails."""
    code = parsph("study", "hump.toml", "--out", "out", cwd=place, ranks=2)
    assert code.returncode == 2
    assert "--ranks 2" in " ".join(code.stderr.split())
    assert [path.name for path in place.iterdir()] == ["hump.toml"]
    result = parsph("study", "hump.toml", "--out", "out", "--row", "layers_50", cwd=place, ranks=2)
    assert result.returncode == 0, result.stderr
    row = "rows/layers_50"
    assert json.loads((place / "out" / row / "summary.json").read_text())["ranks"] == 2
    assert (place / "out" / row / "gauges" / "energy-00.csv").read_text() == (
        finished[0] / row / "gauges" / "energy-00.csv"
    ).read_text()


@needs_mpi
def test_a_row_that_fails_on_another_rank_is_recorded(place):
    result = parsph("study", "hump.toml", "--out", "out", "--row", "narrow", cwd=place, ranks=2)
    assert result.returncode == 1
    assert "density_range" in json.loads((place / "out" / "failed" / "narrow.json").read_text())["why"]


# --- beside the run -----------------------------------------------------------------------------------------------------


def test_without_matplotlib_nothing_is_run(place, command, monkeypatch):
    monkeypatch.setattr(study_command, "find_spec", lambda name: None)
    code, _, err = command("study", "hump.toml", "--out", "out")
    assert code == 2
    assert "matplotlib is not installed" in err
    assert "pip install" in err
    assert [path.name for path in place.iterdir()] == ["hump.toml"]


def test_studies_and_rows_are_listed(place, command):
    code, out, _ = command("study")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()] == builtin_names() == BUILTIN
    code, out, _ = command("study", "hump.toml", "--list")
    assert code == 0
    rows = re.findall(r"^ *(\d+)  (\S+) +([\d,]+) particles", out, re.MULTILINE)
    assert rows == [
        (str(k), name, n) for k, (name, n) in enumerate(zip(ROWS, ["250", "125", "130", "138", "138"], strict=True))
    ]
    assert "reflection-ratio, energy-difference" in out
    code, out, _ = command("study", "hump.toml", "--list", "--set", "numerics.dx=2")
    assert "500 particles" in out
    full, quick = (command("study", "absorbing-2d", "--list", *more)[1] for more in ([], ["--quick"]))
    assert len(full.splitlines()) > len(quick.splitlines()) > 20
    assert [path.name for path in place.iterdir()] == ["hump.toml"]


def test_bad_studies_end_with_2_and_write_nothing(place, command):
    (place / "bad.toml").write_text(HUMP.replace('"time.end"', '"time.ende"'))
    before = stamps(place)
    for arguments, text in (
        (["bad.toml"], "row infinite and 4 more: time.ende: unknown key"),
        (["nothing.toml"], "no study 'nothing.toml'"),
        (["hump.toml", "--set", "time.end"], "key=value"),
        (["hump.toml", "--jobs", "0"], "--jobs"),
    ):
        code, _, err = command("study", *arguments)
        assert code == 2
        assert text in err
        assert "Traceback" not in err
    assert stamps(place) == before


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('metrics = []\n[[groups]]\nname = "../a"\n', "groups.0.name"),
        ("metrics = []\nsettings." + ".".join("a" * 50) + " = 1\n", "a key of more than 20 parts"),
        ("metrics = []\nsettings = " + "{ a = " * 500 + "1" + " }" * 500, "nested too deeply"),
        ("metrics = []\n" + "".join(f"key{k} = 1\n" for k in range(300)), "the study: has 201 faults more"),
        ("#" * 3_000_000, "holds 3 MB"),
    ],
    ids=["name", "long key", "deep", "many faults", "large"],
)
def test_odd_studies_are_told_in_words(place, command, text, told):
    (place / "odd.toml").write_text(text)
    before = stamps(place)
    code, _, err = command("study", "odd.toml")
    assert code == 2
    assert told in err
    assert "Traceback" not in err
    assert stamps(place) == before


def test_a_study_of_very_many_rows_is_refused_before_they_are_made(place, command):
    axes = "".join(
        f"[groups.axes.x{axis}]\n" + "".join(f'{k} = {{ "time.end" = {k + 1}.0 }}\n' for k in range(10)) for axis in range(12)
    )
    (place / "many.toml").write_text(f'metrics = []\n[[groups]]\nname = "a"\n{axes}')
    code, _, err = command("study", "many.toml")
    assert code == 2
    assert "groups: 1,000,000,000,000 rows, more than 10,000" in err


def test_folders_are_numbered(place, command):
    """As those of runs are: studies/<name>-<NNN>, the next free number."""
    (place / "mine.toml").write_text(
        'metrics = []\nbase = "swe-pulse"\n[[groups]]\nname = "a"\n[groups.settings]\n"numerics.dx" = 4.0\n"time.end" = 0.0\n'
    )
    (place / "studies" / "mine-001").mkdir(parents=True)
    code, _, err = command("study", "mine.toml")
    assert code == 0, err
    assert summaries(place / "studies" / "mine-002") == {"a"}
    assert (place / "studies" / "mine-002" / "report.md").exists()
    assert not list((place / "studies" / "mine-001").iterdir())
