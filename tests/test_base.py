"""Scenes that build on another one."""

import json
import re
import tomllib

import pytest
from helpers import tank

from parsph.errors import SceneError
from parsph.run import run
from parsph.scene.load import BUILTIN, builtin_names, json_schema, load_scene, scene_text
from parsph.scene.schema import Damping

SCENE = """
title = "a tank"
[domain]
size = [0.2, 0.3]
[fluid]
blocks = [{ low = [0.0, 0.0], high = [0.2, 0.2] }]
[walls]
left = { slip = "no" }
right = {}
bottom = {}
[wavemaker.wave]
kind = "oscillation"
angle = 5.0
period = 2.0
[[damping]]
length = 0.05
switch = "vx"
[numerics]
dx = 0.01
[time]
end = 1.0
[output.snapshots]
every = 0.1
[[gauges]]
kind = "level"
x = 0.1
[[gauges]]
kind = "level"
x = 0.15
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a whole scene, ``tank.toml``, and another one to be in."""
    (tmp_path / "scenes").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "scenes" / "tank.toml").write_text(SCENE)
    monkeypatch.chdir(tmp_path / "elsewhere")
    return tmp_path / "scenes"


def write(folder, name, text):
    """Write a scene and return its path."""
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    return path


# --- merging -------------------------------------------------------------------------------------------------------


def test_a_scene_of_nothing_but_a_base_is_that_base(folder):
    """The file is looked for beside the scene, wherever the command is given."""
    base = load_scene(folder / "tank.toml")
    assert load_scene(write(folder, "mine.toml", 'base = "tank.toml"')) == base
    assert load_scene({"base": "pool"}) == load_scene("pool")
    assert load_scene(write(folder, "pool.toml", 'base = "pool"')) == load_scene("pool")


def test_sections_are_merged_and_values_replaced(folder):
    """At any depth; what is not named stays."""
    path = write(
        folder,
        "mine.toml",
        'base = "tank.toml"\ntitle = "mine"\n[wavemaker.wave]\nperiod = 3.0\n[walls.left]\nslip = "free"\n'
        "[walls.top]\n[output.log]\nevery = 0.5\n[numerics]\nalpha = 0.5",
    )
    base, mine = load_scene(folder / "tank.toml"), load_scene(path)
    assert (mine.title, base.title) == ("mine", "a tank")
    assert (mine.wavemaker.wave.angle, mine.wavemaker.wave.period) == (5.0, 3.0)
    assert mine.walls.left.slip == "free"
    assert mine.walls.top is not None
    assert mine.walls.right == base.walls.right
    assert (mine.output.log.every, mine.output.snapshots.every) == (0.5, 0.1)
    assert (mine.numerics.alpha, mine.numerics.dx) == (0.5, 0.01)
    for section in ("domain", "fluid", "damping", "gauges", "time"):
        assert getattr(mine, section) == getattr(base, section)


def test_lists_are_replaced_whole(folder):
    """Their items have no names to merge by: a layer is then that of the scene, with defaults for the rest."""
    path = write(folder, "mine.toml", 'base = "tank.toml"\ngauges = [{ kind = "level", x = 0.05 }]\n[[damping]]\nlength = 0.1')
    mine = load_scene(path)
    assert [gauge.x for gauge in mine.gauges] == [0.05]
    assert mine.damping == [Damping(length=0.1)]
    assert load_scene({"base": str(folder / "tank.toml"), "gauges": [], "damping": []}).damping == []


def test_a_chain_of_bases_in_several_folders(folder):
    """Each file is relative to the one that names it; the scene nearest to the user wins."""
    write(folder, "low/a.toml", 'base = "../tank.toml"\n[time]\nend = 2.0\ncfl = 0.3\n[numerics]\nalpha = 0.1\ndelta = 0.2')
    write(folder, "b.toml", 'base = "low/a.toml"\n[time]\nend = 3.0\n[numerics]\nalpha = 0.2')
    c = load_scene(write(folder, "c.toml", 'base = "b.toml"\n[time]\nend = 4.0'))
    assert (c.time.end, c.time.cfl) == (4.0, 0.3)
    assert (c.numerics.alpha, c.numerics.delta, c.numerics.dx) == (0.2, 0.2, 0.01)
    assert c.wavemaker.wave.angle == 5.0


def test_a_base_may_be_used_twice_in_a_chain_of_different_scenes(folder):
    """Two scenes on one base are no cycle."""
    for name in ("a.toml", "b.toml"):
        write(folder, name, 'base = "tank.toml"')
    assert load_scene(folder / "a.toml") == load_scene(folder / "b.toml")


def test_overrides_come_on_top(folder):
    path = write(folder, "mine.toml", 'base = "tank.toml"\n[time]\nend = 2.0')
    assert load_scene(path, ["time.end=5", "gauges.1.x=0.02"]).time.end == 5
    assert load_scene(path, {"gauges.1.x": 0.02}).gauges[1].x == 0.02
    assert load_scene(path, {"gauges.1.x": 0.02}).gauges[0].x == 0.1
    assert load_scene(path, {"wavemaker.wave.period": 1.5}).wavemaker.wave.period == 1.5


def test_keys_that_are_given_stay_as_they_are():
    keys = {"base": "pool", "time": {"end": 1.0}}
    load_scene(keys, {"time.end": 2.0})
    assert keys == {"base": "pool", "time": {"end": 1.0}}
    assert load_scene("pool").time.end == 25.0


def test_faults_of_a_merged_scene_are_told(folder):
    path = write(folder, "mine.toml", 'base = "tank.toml"\n[numerics]\ndxx = 1\n[time]\ndt = 1.0')
    with pytest.raises(SceneError, match=r"numerics\.dxx: unknown key"):
        load_scene(path)
    with pytest.raises(SceneError, match="left: is missing"):
        load_scene({"base": "pool", "walls": {"left": None}})


@pytest.mark.parametrize("name", [name for name in builtin_names() if "-" in name])
def test_builtin_scenes_on_a_base_keep_what_they_do_not_name(name):
    keys = tomllib.loads((BUILTIN / f"{name}.toml").read_text())
    scene = load_scene(name)
    assert scene.title == keys["title"]
    if "base" in keys:
        base = load_scene(keys["base"])
        assert scene.title != base.title
        kept = {"domain", "fluid", "walls", "wavemaker", "damping", "gauges", "numerics", "time", "output"} - set(keys)
        assert len(kept) >= 2
        for section in kept:
            assert getattr(scene, section) == getattr(base, section), section


def test_pools_differ_in_their_ends_alone():
    """The reflecting and the infinite one have no layer; the impulse is a single oscillation, ten gauges."""
    pool = load_scene("pool")
    for name, length in (("pool-reflecting", 6.061), ("pool-infinite", 42.427)):
        other = load_scene(name)
        assert other.damping == []
        assert other.domain.size == [length, 1.5]
        assert other.fluid.blocks[0].high == [length, 1.0]
        assert (other.wavemaker, other.gauges, other.time) == (pool.wavemaker, pool.gauges, pool.time)
    impulse = load_scene("pool-impulse")
    assert (impulse.wavemaker.wave.cycles, impulse.wavemaker.wave.ramp) == (1, 0.0)
    wave = pool.wavemaker.wave
    assert (impulse.wavemaker.wave.angle, impulse.wavemaker.wave.period) == (wave.angle, wave.period)
    assert [gauge.kind for gauge in impulse.gauges] == ["level"] * 10 + ["energy"]
    assert impulse.damping == pool.damping


# --- what is no base -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("names", [["a.toml"], ["a.toml", "b.toml"], ["a.toml", "b.toml", "c.toml"]])
def test_a_cycle_is_told_with_its_way(folder, names):
    for name, base in zip(names, [*names[1:], names[0]], strict=True):
        write(folder, name, f'base = "{base}"')
    with pytest.raises(SceneError, match="is its own base") as caught:
        load_scene(folder / "a.toml")
    way = str(caught.value).split("; ")[1].split(" -> ")
    assert [step.rsplit("/")[-1] for step in way] == [*names, "a.toml"]
    assert caught.value.cure


def test_a_cycle_is_found_however_the_scene_is_called(folder, monkeypatch):
    monkeypatch.chdir(folder)
    write(folder, "a.toml", 'base = "b.toml"')
    write(folder, "b.toml", 'base = "a.toml"')
    for source in ("a.toml", "./a.toml", folder / "a.toml", {"base": "a.toml"}):
        with pytest.raises(SceneError, match="is its own base"):
            load_scene(source)


def test_a_cycle_through_another_folder_is_found(folder):
    write(folder, "a.toml", 'base = "low/b.toml"')
    write(folder, "low/b.toml", 'base = "../a.toml"')
    with pytest.raises(SceneError, match="is its own base"):
        load_scene(folder / "a.toml")


def test_an_unknown_base_names_the_near_and_all_others(folder):
    path = write(folder, "mine.toml", 'base = "poool"')
    with pytest.raises(SceneError, match=r"no scene '.*poool'.*built-in scenes: .*pool, .*seiche"):
        load_scene(path)
    with pytest.raises(SceneError, match="did you mean 'pool'"):
        load_scene({"base": "poool"})
    with pytest.raises(SceneError, match=r"no scene '.*scenes/no\.toml'"):
        load_scene(write(folder, "mine.toml", 'base = "no.toml"'))


@pytest.mark.parametrize("base", ["3", "true", '["pool"]', '{ name = "pool" }'])
def test_a_base_is_a_name(folder, base):
    path = write(folder, "mine.toml", f"base = {base}")
    with pytest.raises(SceneError, match="base must be a name, not ") as caught:
        load_scene(path)
    assert caught.value.where == str(path)
    assert 'base = "pool"' in caught.value.cure


def test_a_base_that_is_no_scene_says_which_file(folder):
    write(folder, "bad.toml", "[time\nend = 3")
    with pytest.raises(SceneError, match=r"bad\.toml: not valid TOML"):
        load_scene(write(folder, "mine.toml", 'base = "bad.toml"'))


def test_a_base_cannot_be_set_afterwards():
    with pytest.raises(SceneError, match="base: unknown key"):
        load_scene("pool", {"base": "seiche"})


# --- the scene.json of a run ---------------------------------------------------------------------------------------


def test_the_json_of_a_run_is_the_same_scene(tmp_path):
    """Defaults filled in, so that it needs neither its base nor the file that it came from."""
    path = write(tmp_path, "mine.toml", 'base = "seiche"\n[numerics]\ndx = 0.02\n[time]\nend = 0.01')
    run(path, ["numerics.alpha=0.3"], out=tmp_path / "run")
    assert load_scene(tmp_path / "run" / "scene.json") == load_scene(path, {"numerics.alpha": 0.3})
    assert load_scene(str(tmp_path / "run" / "scene.json"), {"time.end": 0.02}).time.end == 0.02
    assert "base" not in json.loads((tmp_path / "run" / "scene.json").read_text())


def test_the_json_of_a_run_can_be_a_base(tmp_path):
    """Where it holds null, nothing is replaced but that."""
    (tmp_path / "scene.json").write_text(scene_text(load_scene(tank())))
    path = write(
        tmp_path,
        "mine.toml",
        'base = "scene.json"\n[wavemaker.wave]\nkind = "oscillation"\nangle = 2.0\nperiod = 1.0\n[walls.top]\n',
    )
    mine = load_scene(path)
    assert mine.wavemaker.wave.period == 1.0
    assert mine.walls.top is not None
    assert mine.numerics == load_scene(tank()).numerics


@pytest.mark.parametrize(
    ("text", "message"),
    [("{", "scene.json: not valid JSON"), ("[1]", "scene.json: holds no sections"), ("3", "holds no sections")],
)
def test_json_that_is_no_scene(tmp_path, text, message):
    with pytest.raises(SceneError, match=re.escape(message)) as caught:
        load_scene(write(tmp_path, "scene.json", text))
    assert caught.value.cure


# --- the JSON Schema -----------------------------------------------------------------------------------------------


def complaints(keys):
    """Return what the JSON Schema, as an editor would apply it, says against `keys`."""
    jsonschema = pytest.importorskip("jsonschema")
    return [error.message for error in jsonschema.Draft202012Validator(json.loads(json_schema())).iter_errors(keys)]


@pytest.mark.parametrize("name", builtin_names())
def test_the_schema_accepts_the_builtin_scenes_as_they_are_written(name):
    assert not complaints(tomllib.loads((BUILTIN / f"{name}.toml").read_text()))


def test_the_schema_accepts_a_scene_with_a_base_and_with_its_defaults():
    assert not complaints({"base": "pool"})
    assert not complaints({"base": "pool", "title": "mine", "damping": []})
    assert not complaints(json.loads(scene_text(load_scene("pool"))))


@pytest.mark.parametrize(
    "keys",
    [{"base": 3}, {"basis": "pool"}, {"base": "pool", "title": 3}, {"time": {"end": "soon"}}, {"time": {"end": 1, "x": 1}}],
)
def test_the_schema_still_finds_what_is_wrong(keys):
    assert complaints(keys)
