"""Whatever is given as a scene is run or refused in words: no traceback, no hang, no memory, no file outside, no code.

Several thousand inputs, the same in every run. With ``PARSPH_FUZZ=20`` there are twenty times as many, and others every time.
"""

import ast
import contextlib
import io
import json
import os
import resource
import signal
from pathlib import Path

import odd_scenes
import pytest
from helpers import parsph as command_line
from helpers import tank
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import parsph
from parsph.errors import SceneError
from parsph.memory import memory_here
from parsph.parallel import Communicator
from parsph.scene.build import build, cuts_of
from parsph.scene.check_waves import doubts_of
from parsph.scene.limits import memory_of, particle_count, refuse_too_large
from parsph.scene.load import load_scene, scene_text
from parsph.scene.plan import costs, print_plan

TIMES = int(os.environ.get("PARSPH_FUZZ", "0"))
INPUTS = {"damaged": 600, "made up": 700, "text": 400, "settings": 500}
CPU_SECONDS, MEMORY = 60, 1 << 30  # that one input may take, the memory beside what the process has already
LONGEST_MESSAGE = 100_000  # characters, of a hundred faults
SMALL = 3000  # particles of scenes that are built too
NO_DEADLINE = {"deadline": None, "suppress_health_check": list(HealthCheck), "database": None}


class Unbounded(BaseException):
    """An input takes too long; nothing may catch it."""


@contextlib.contextmanager
def bounded():
    """What is done inside takes no more than `CPU_SECONDS` and `MEMORY`."""

    def late(*_):
        raise Unbounded(f"more than {CPU_SECONDS} s of CPU time")

    usual, (soft, hard) = signal.signal(signal.SIGPROF, late), resource.getrlimit(resource.RLIMIT_AS)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, hard))
    signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, usual)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def outcome(source, overrides=None):
    """Take a scene through all that comes before a run; return "refused", "planned" or "built"."""
    try:
        scene = load_scene(source, overrides)
    except SceneError as error:
        refusal = error
    else:
        refusal = None
    if refusal:
        assert 10 < len(str(refusal)) < LONGEST_MESSAGE
        assert all(fault.what for fault in getattr(refusal, "faults", [refusal]))
        return "refused"
    assert all(isinstance(doubt, str) and doubt for doubt in doubts_of(scene))
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        print_plan(scene, "odd")
    assert scene.title in printed.getvalue()
    assert load_scene(json.loads(scene_text(scene))) == scene
    if costs(scene)["particles"] > SMALL or memory_of(scene) > MEMORY / 4:
        return "planned"
    with contextlib.suppress(SceneError):  # there may be fewer columns than ranks
        assert len(cuts_of(scene, 3)) == 4
    build(scene)
    return "built"


def through(name, strategy, *check):
    """Take as many inputs as `INPUTS` says through `outcome`; all are tried, and some of each outcome."""
    seen = []

    @settings(
        max_examples=INPUTS[name] * max(TIMES, 1),
        derandomize=not TIMES,
        phases=[Phase.generate] if not TIMES else [Phase.generate, Phase.shrink],
        **NO_DEADLINE,
    )
    @given(strategy)
    def trial(arguments):
        with bounded():
            seen.append(outcome(*arguments))

    trial()
    counts = {kind: seen.count(kind) for kind in ("refused", "planned", "built")}
    print(f"{len(seen)} inputs: {counts}")
    assert len(seen) >= INPUTS[name]
    assert all(counts[kind] > 0 for kind in ("refused", "built")), counts


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    """Nothing appears there: scenes that are not run write nothing."""
    (tmp_path / "cwd").mkdir()
    monkeypatch.chdir(tmp_path / "cwd")
    yield
    assert not list((tmp_path / "cwd").iterdir())


def test_there_are_enough_inputs():
    assert sum(INPUTS.values()) >= 2000


def test_damaged_scenes():
    through("damaged", st.tuples(odd_scenes.damaged()))


def test_scenes_made_up_from_the_schema():
    through("made up", st.tuples(odd_scenes.made_up()))


def test_damaged_files(tmp_path):
    path = tmp_path / "odd.toml"

    def written(data):
        path.write_bytes(data)
        return (path,)

    through("text", odd_scenes.damaged_text().map(written))


def test_settings():
    through("settings", odd_scenes.scene_and_settings())


# --- too large -------------------------------------------------------------------------------------------------------

LONG_WAVES = {"kind": "irregular", "height": 0.01, "period": 1.0}
# name: (overrides of the small tank, where, what is wrong, the cure)
TOO_LARGE = {
    "particles": ({"numerics.dx": 1e-9}, "fluid.blocks.0", "4e+16 particles, more than 2e9", "a larger numerics.dx"),
    "particles of many blocks": (
        {
            "numerics.dx": 1e-6,
            "domain.size": [0.2, 0.2],
            "fluid.blocks": [{"low": [0.04 * k, 0.0], "high": [0.04 * k + 0.03, 0.03]} for k in range(5)],
        },
        "fluid.blocks",
        "4.5e+09 particles",
        "smaller blocks",
    ),
    "cells": ({"domain.size": [1e9, 1e9]}, "domain.size", "cells, more than 1e9", "a smaller domain.size"),
    "cells that a body may need": (
        {"bodies": [{"wall": "right", "mass": 1e3, "stops": [-0.1, 1e12]}]},
        "domain.size",
        "cells, more than 1e9",
        "a smaller domain.size",
    ),
    "walls": (
        {"walls.treatment": "ghosts", "numerics.dx": 1e-4, "domain.size": [200.0, 0.3]},
        "walls.treatment",
        "2.01e+06 particle spacings",
        "numerics.dx of at least",
    ),
    "points": ({"walls.polygons": [{"points": [[0.1, 0.1]] * 1900}] * 3}, "walls.polygons", "5,700 points", "at most 5,000"),
    "points of one wall": (
        {"walls.polygons": [{"points": [[0.1, 0.1]] * 2100}]},
        "walls.polygons.0.points",
        "at most 2000",
        "",
    ),
    "gauges": ({"gauges": [{"kind": "energy"}] * 501}, "gauges", "at most 500", ""),
    "steps": ({"time.end": 1e9}, "time.end", "steps of 0.000", "at most"),
    "steps of the settling": ({"time.settle": 1e9}, "time.settle", "steps of 0.000", "at most"),
    "steps by a tiny one": ({"time.dt": 1e-12, "time.end": 1.0}, "time.end", "1e+12 steps", "at most 0.01 s"),
    "snapshots": ({"output.snapshots.every": 1e-12}, "output.snapshots.every", "1e+10 files", "at least 1e-08 s"),
    "rows": (
        {"gauges": [{"kind": "energy", "every": 1e-12}], "time.end": 1.0},
        "gauges.0.every",
        "1e+12 rows",
        "at least 1e-10 s",
    ),
    "readings": (
        {"gauges": [{"kind": "pressure", "point": [0.1, 0.1], "extent": [0.0, 100.0]}]},
        "gauges.0.extent",
        "100 m are too long",
        "10,000 readings",
    ),
    "waves": (
        {"wavemaker": {"kind": "piston", "wave": {"kind": "regular", "height": 1e-3, "period": 0.2}}, "time.end": 1e9},
        "wavemaker.wave",
        "5e+09 waves",
        "a time.end of at most",
    ),
    "components": (
        {"wavemaker": {"kind": "piston", "wave": LONG_WAVES}, "time.end": 1e5},
        "wavemaker.wave.duration",
        "2e+05 waves",
        "after which they repeat",
    ),
    "components of a focus": (
        {
            "wavemaker": {"kind": "piston", "wave": {"kind": "focused", "crest": 0.01, "period": 1, "place": 0.1, "time": 1e5}},
            "time.end": 1e5,
        },
        "wavemaker.wave.time",
        "6e+05 waves",
        "an earlier focus",
    ),
    "a number": ({"domain.gravity": 1e13}, "domain.gravity", "less than or equal to 1000000000000", "gravity"),
    "a tiny number": ({"numerics.dx": 1e-13}, "numerics.dx", "at least 1e-12", "spacing"),
    "a text": ({"title": "x" * 201}, "title", "at most 200 characters", "one line"),
    "lines": ({"title": "one\ntwo"}, "title", "one line", "one line"),
}


@pytest.mark.parametrize("name", TOO_LARGE)
def test_what_is_too_large_is_refused(name):
    overrides, where, what, cure = TOO_LARGE[name]
    with bounded(), pytest.raises(SceneError) as caught:
        load_scene(tank(), overrides)
    faults = [fault for fault in caught.value.faults if fault.where == where]
    assert faults, str(caught.value)
    assert what in faults[0].what
    assert cure in faults[0].cure
    assert faults[0].cure


def test_so_many_faults_are_not_all_told():
    with pytest.raises(SceneError, match=r"the scene: has 150 faults more") as caught:
        load_scene(tank(gauges=[{"kind": "level", "x": -1.0}] * 250))
    assert len(caught.value.faults) == 101


BED = {"points": [[0.0, 0.3], [0.0, 0.0], [0.2, 0.0], [0.2, 0.3]]}


@pytest.mark.parametrize("walls", [{"left": {}, "right": {}, "bottom": {}}, {"polygons": [BED]}], ids=["mirrors", "polygon"])
def test_particles_are_counted_without_being_placed(walls):
    """4e8 of them: their positions alone would be 6.4 GB."""
    with bounded():
        scene = load_scene(tank(walls=walls), {"numerics.dx": 1e-5})
        assert costs(scene)["particles"] == particle_count(scene) == pytest.approx(4e8, rel=1e-9)
        assert memory_of(scene) > 4e8 * 100


class Cluster(Communicator):
    """So many machines with two ranks each."""

    def __init__(self, machines):
        self.size, self.machines = 2 * machines, machines

    def allgather(self, item):
        return [0, 1] * self.machines


def test_a_scene_that_memory_does_not_hold_is_refused_by_run_and_told_by_check(command, monkeypatch):
    monkeypatch.setattr(parsph.scene.limits, "memory_here", lambda: 6e8)
    scene = load_scene(tank(), {"numerics.dx": 1e-4})
    machines = int(memory_of(scene) // 6e8) + 1
    assert machines == 2
    with pytest.raises(
        SceneError, match=rf"numerics.dx: about 4e\+06 particles .* need .* MB of memory; .*600 MB.*or {machines} such machines"
    ):
        refuse_too_large(scene, Communicator())
    with pytest.raises(SceneError, match="1 machine"):
        refuse_too_large(scene, Cluster(1))
    refuse_too_large(scene, Cluster(machines))
    refuse_too_large(load_scene(tank()), Communicator())
    assert [doubt for doubt in doubts_of(scene) if "4e+06 particles" in doubt]
    assert not doubts_of(load_scene(tank()))
    code, out, err = command("run", "seiche", "--set", "numerics.dx=1e-4")
    assert (code, out) == (2, "")
    assert err.startswith("error: numerics.dx: about 4e+06 particles")
    code, out, _ = command("check", "seiche", "--set", "numerics.dx=1e-4")
    assert code == 0
    assert "note: numerics.dx: about 4e+06 particles" in out


def test_this_machine_has_memory():
    assert 1e8 < memory_here() < 1e15


def test_intervals_shorter_than_steps_are_told():
    scene = load_scene(tank(gauges=[{"kind": "energy", "every": 1e-6}, {"kind": "energy", "every": 1e-3}]))
    assert len(doubts_of(scene)) == 1
    assert doubts_of(scene)[0].startswith("gauges.0.every: 1e-06 s is less than a tenth of a step")


# What was found by chance, in campaigns much longer than these tests: overrides of the small tank, part of the message.
FOUND = {
    "a bulging edge of no length": (
        {
            "walls": {
                "polygons": [
                    {"points": [[0, 0.3], [0, 0], [0, 0], [0.2, 0]], "bulge": {"edge": 1, "amplitude": 0.1, "period": 1}}
                ]
            }
        },
        "walls.polygons.0.points.1: equals the next point",
    ),
    "points that differ by nothing": ({"walls.polygons": [{"points": [[0.1, 0.0], [0.1, 5e-324]]}]}, "equals the next point"),
    "a domain of no height": ({"walls.treatment": "deficiency", "domain.size": [0.2, 5e-324]}, "domain.size.1: must be > 0 m"),
    "no water": ({"fluid.level": 5e-324}, "fluid.level: 4.94066e-324 m of water are none"),
    "a wall inside another": (
        {
            "domain.size": [1.0, 1.0],
            "walls": {
                "polygons": [
                    {"points": [[0.4, 0.4], [0.9, 0.4], [0.9, 0.9], [0.4, 0.9]], "fluid": "outside"},
                    {"points": [[0.6, 0.6], [0.7, 0.6], [0.7, 0.7], [0.6, 0.7]], "fluid": "outside"},
                ]
            },
        },
        "walls.polygons.1: lies inside other walls",
    ),
    "a kind that is a list": ({"wavemaker": {"wave": {"kind": [0.0] * 20_000}}}, " ... "),
    "weak gravity": ({"domain.gravity": 1e-300}, "domain.gravity: input should be at least 1e-12"),
}


@pytest.mark.parametrize("name", FOUND)
def test_what_was_found(name):
    overrides, text = FOUND[name]
    with bounded(), pytest.raises(SceneError) as caught:
        load_scene(tank(), overrides)
    assert text in str(caught.value)
    assert len(str(caught.value)) < 2000


# --- files -----------------------------------------------------------------------------------------------------------


def nothing_readable(folder):
    """Return {name: path} of what is no scene and may never end, or be endless."""
    os.mkfifo(folder / "pipe.toml")
    os.truncate(os.open(folder / "huge.toml", os.O_CREAT | os.O_WRONLY), 1 << 40)  # takes no room on the disk
    (folder / "folder.toml").mkdir()
    (folder / "loop.toml").symlink_to(folder / "loop.toml")
    (folder / "binary.toml").write_bytes(bytes(range(256)))
    names = ("pipe.toml", "huge.toml", "folder.toml", "loop.toml", "binary.toml", "missing.toml", "x" * 300, "x" * 5000)
    return {name[:12]: str(folder / name) for name in names} | {
        path: path for path in ("/dev/zero", "/dev/null", "/", "a\0b", ".")
    }


@pytest.mark.timeout(60)
def test_files_that_are_none(tmp_path):
    for name, path in nothing_readable(tmp_path).items():
        with bounded(), pytest.raises(SceneError) as caught:
            load_scene(path)
        assert caught.value.cure, name
        with bounded(), pytest.raises(SceneError):
            load_scene(tank(base=path))
        if "\0" in path:
            continue
        source = tmp_path / "above.toml"
        source.write_text(f"base = {json.dumps(path)}")
        with bounded(), pytest.raises(SceneError) as caught:
            load_scene(source)
        assert caught.value.cure, name
        wave = {"kind": "series", "file": path, "unit": "m"}
        with bounded(), pytest.raises(SceneError) as caught:
            load_scene(tank(wavemaker={"kind": "piston", "wave": wave}))
        assert all(fault.where.startswith("wavemaker.wave.file") for fault in caught.value.faults), name
        assert all(fault.cure for fault in caught.value.faults), name


RECORDS = {
    "huge times": "1e300 0\n2e300 0\n" * 8,
    "tiny steps": "".join(f"{k}e-320 {k}\n" for k in range(9)),
    "numbers beyond all": "1e999 1\n" * 9,
    "not numbers": "nan 1\n" * 9,
    "a long line": "0 " * 200_000,
    "code": "__import__('os').system('touch evaluated') 1\n" * 9,
    "a long start": "".join(f"{k * 1e-6} {k * 1e-6}\n" for k in range(9)),
}


@pytest.mark.parametrize("name", RECORDS)
def test_records_that_are_none(tmp_path, name):
    path = tmp_path / "record.txt"
    path.write_text(RECORDS[name])
    wave = {"kind": "series", "file": str(path), "unit": "m", "start": 1e12 if name == "a long start" else None}
    with bounded(), pytest.raises(SceneError, match=r"wavemaker\.wave\.file: .*record.txt") as caught:
        load_scene(tank(wavemaker={"kind": "piston", "wave": wave}))
    assert len(str(caught.value)) < 1000


def test_chains_of_bases(tmp_path):
    for number in range(30):
        (tmp_path / f"{number}.toml").write_text(f'base = "{number + 1}.toml"\ntitle = "{number}"')
    (tmp_path / "30.toml").write_text('base = "pool"')
    assert load_scene(tmp_path / "15.toml").title == "15"
    with pytest.raises(SceneError, match="more than 20 scenes build on each other"):
        load_scene(tmp_path / "5.toml")
    (tmp_path / "30.toml").write_text('base = "../' + tmp_path.name + '/20.toml"')
    with pytest.raises(SceneError, match="is its own base"):
        load_scene(tmp_path / "20.toml")
    for number in range(100):  # links make names that differ for ever
        (tmp_path / f"link-{number}.toml").symlink_to(tmp_path / "link.toml")
    (tmp_path / "link.toml").write_text('base = "sub/link.toml"')
    (tmp_path / "sub").symlink_to(tmp_path)
    with pytest.raises(SceneError, match="more than 20 scenes"):
        load_scene(tmp_path / "link.toml")


DEEP = {
    "lists.toml": "title = " + "[" * 50_000,
    "tables.toml": "a." * 50_000 + "a = 1",
    "inline.toml": "a = { " + "a." * 50_000 + "a = 1 }",
    "lists.json": "[" * 50_000,
    "tables.json": '{"a":' * 50_000,
    "digits.toml": "title = " + "9" * 50_000,
    "digits.json": '{"title": ' + "9" * 50_000 + "}",
    "empty.json": "",
    "number.json": "3",
    "surrogate.json": '{"title": "\\ud800"}',
    "nan.json": '{"time": {"end": NaN}}',
    "many.toml": "".join(f"key-{k} = {k}\n" for k in range(100_000)),
    "gauges.toml": "[[gauges]]\n" * 100_000,
}


@pytest.mark.parametrize("name", DEEP)
def test_deep_and_long_files(tmp_path, name):
    (tmp_path / name).write_text(DEEP[name])
    with bounded(), pytest.raises(SceneError) as caught:
        load_scene(tmp_path / name)
    assert len(str(caught.value)) < LONGEST_MESSAGE
    (tmp_path / "above.toml").write_text(f'base = "{name}"\n' + "a." * 3000 + "a = 2")
    with bounded(), pytest.raises(SceneError):
        load_scene(tmp_path / "above.toml")


# --- names -----------------------------------------------------------------------------------------------------------

NO_NAMES = (
    "../x",
    "/tmp/x",
    "a/b",
    "..",
    ".",
    ".x",
    "con",
    "NUL.csv",
    "a\\b",
    "C:x",
    "x\0y",
    "x\ny",
    "x" * 101,
    "水" * 90,
    " x",
    "x.",
    "*",
)


@pytest.mark.parametrize("name", NO_NAMES)
def test_names_of_gauges_are_names_of_files(name):
    with pytest.raises(SceneError, match=r"^gauges\.0\.name: "):
        load_scene(tank(gauges=[{"kind": "energy", "name": name}]))


def test_names_that_differ_in_capitals_alone_are_one():
    with pytest.raises(SceneError, match=r"gauges\.1\.name: 'wall' is taken; some file systems tell no capitals"):
        load_scene(tank(gauges=[{"kind": "energy", "name": "Wall"}, {"kind": "energy", "name": "wall"}]))
    assert load_scene(tank(gauges=[{"kind": "energy", "name": "x = 3,5 m (left)"}, {"kind": "energy", "name": "水位"}]))


def test_a_run_writes_into_its_folder_alone(tmp_path, command):
    """Whatever title, walls and gauges are called, and whatever the scene's file is called."""
    source = tmp_path / "..-odd [x] 水.toml"
    keys = {"title": "[/bold] :smile: {0}", "base": "seiche"}
    text = "\n".join(f"{key} = {json.dumps(value)}" for key, value in keys.items() if key != "walls")
    source.write_text(text + "\n[time]\nend = 0.0\n[[gauges]]\nkind = 'energy'\nname = '[red] x'\n")
    out = tmp_path / "out"
    code, printed, err = command("run", source, "--out", out)
    assert (code, err) == (0, "")
    assert keys["title"] in printed
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([source.name, "cwd", "out"])
    assert (out / "gauges" / "[red] x.csv").exists()


def test_names_in_brackets_are_printed_as_they_are(command, tmp_path):
    source = tmp_path / "brackets.toml"
    points = json.dumps(BED["points"])
    source.write_text(
        "title = '[/bold]'\n[domain]\nsize = [0.2, 0.3]\n[fluid]\nblocks = [{ low = [0, 0], high = [0.2, 0.2] }]\n"
        f"[numerics]\ndx = 0.01\n[time]\nend = 0\n[[walls.polygons]]\nname = '[/red]'\npoints = {points}\n"
    )
    code, printed, err = command("plan", source)
    assert (code, err) == (0, "")
    assert "[/bold]" in printed
    assert "[/red]" in printed


# --- settings --------------------------------------------------------------------------------------------------------

# setting of the seiche: part of the message
SETTINGS = {
    "": "not of the form key=value",
    "a": "not of the form key=value",
    "=1": "not of the form key=value",
    " =1": "not of the form key=value",
    "a.b.c.d=1": "a: unknown key",
    "time.end.x=1": "time.end is not a section",
    "time=1": "time: input should be a valid dictionary",
    "gauges.99.x=1": "'99' is not an item of the list",
    "gauges.-1.x=1": "'-1' is not an item of the list",
    "gauges.x=1": "'x' is not an item of the list",
    "gauges." + "9" * 5000 + ".x=1": "is not an item of the list",
    "damping.0.length=1": "damping: input should be a valid list",
    "fluid.blocks.0.low.7=1": "'7' is not an item of the list",
    "time.end=": "valid number",
    "time.end=1 2": "valid number",
    "time.end=[1": "valid number",
    "time.end=" + "9" * 5000: "time.end: input should be",
    "time.end=" + "[" * 50_000: "time.end: input should be a valid number",
    "time.end=1\nx = 2": "valid number",
    "time.end=nan": "finite",
    "time.end=__import__('os').system('touch evaluated')": "valid number",
    ".=1": "'': unknown key",
    "x." * 50_000 + "x=1": "sections deep",
    "y" * 50_000 + "=1": "unknown key",
}


@pytest.mark.parametrize("number", range(len(SETTINGS)))
def test_settings_that_are_none(number):
    setting, text = list(SETTINGS.items())[number]
    with bounded(), pytest.raises(SceneError) as caught:
        load_scene("seiche", [setting])
    assert text in str(caught.value)
    assert len(str(caught.value)) < 1000
    assert all(fault.cure for fault in getattr(caught.value, "faults", [caught.value]))


def test_what_a_user_types_ends_with_2(tmp_path, command):
    for arguments in (("run", "seiche", "--set", "numerics.dx=1e-9"), ("plan", "seiche", "--set", "a"), ("show", tmp_path)):
        code, printed, err = command(*arguments)
        assert (code, printed) == (2, "")
        assert err.startswith("error: ")
    done = command_line("check", "/dev/zero", cwd=tmp_path)  # in a process of its own too
    assert done.returncode == 2
    assert done.stderr == "error: /dev/zero: is not a regular file; a TOML file\n"


# --- code ------------------------------------------------------------------------------------------------------------

PACKAGE = Path(parsph.__file__).parent
EVALUATING = {
    "eval",
    "exec",
    "compile",
    "__import__",
    "import_module",
    "system",
    "popen",
    "Popen",
    "check_output",
    "check_call",
}
LIBRARIES = {"pickle", "marshal", "shelve", "yaml", "dill", "joblib", "cloudpickle", "code", "runpy", "ctypes"}
# Built-in studies are imported by their names, which are listed; rows of a study, and faults that are injected, are runs of
# this program.
KNOWN = {
    "study/declare.py": {"import_module"},
    "study/runner.py": {"Popen"},
    "verify/injection.py": {"runpy"},
    "verify/robustness.py": {"Popen"},
}


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_nothing_is_evaluated(path):
    """No module evaluates text, unpickles, or starts processes; a scene's strings are compared and printed, and name files."""
    tree, found = ast.parse(path.read_text(encoding="utf-8")), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            found |= {name} & EVALUATING
        elif isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names} & LIBRARIES
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found |= {node.module.split(".")[0]} & LIBRARIES
    assert not found - KNOWN.get(path.relative_to(PACKAGE).as_posix(), set())
