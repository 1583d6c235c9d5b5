"""Scenes: every fault has a message that says where and what would be right; good scenes survive every round trip."""

import json
import math

import pytest
from helpers import tank

import parsph
from parsph.errors import SceneError
from parsph.scene.build import build, state_of
from parsph.scene.load import builtin_names, json_schema, load_scene, scene_name, scene_text

# name: (overrides of the small tank, where, part of what is wrong, part of the cure, which may not be empty)
FAULTS = {
    "unknown key": ({"numerics.h_over_dxx": 2.0}, "numerics.h_over_dxx", "unknown key", "'h_over_dx'"),
    "unknown section": ({"wavemakr": {}}, "wavemakr", "unknown key", "'wavemaker'"),
    "unknown key without a near one": ({"time.zzz": 1}, "time.zzz", "unknown key", "end, settle, walltime, dt, cfl"),
    "unknown key of a gauge": ({"gauges": [{"kind": "level", "xx": 1.0, "x": 0.1}]}, "gauges.0.xx", "unknown", "x"),
    "unknown key of a wall": ({"walls.left": {"slp": "no"}}, "walls.left.slp", "unknown key", "'slip'"),
    "unknown key of a block": (
        {"fluid.blocks.0.inital": "still"},
        "fluid.blocks.0.inital",
        "unknown key",
        "'initial'",
    ),
    "wrong type": ({"time.end": "soon"}, "time.end", "valid number", "end of the run [s]"),
    "section that is none": ({"domain": 3}, "domain", "dictionary", ""),
    "missing key": ({"wavemaker": {"wave": {"kind": "oscillation"}}}, "wavemaker.wave.period", "is missing", "period [s]"),
    "wave without a kind": ({"wavemaker": {"wave": {"height": 0.1}}}, "wavemaker.wave.kind", "is missing", "irregular"),
    "gauge without a kind": ({"gauges": [{"x": 0.1}]}, "gauges.0.kind", "is missing", "level, pressure"),
    "unknown kind of wave": ({"wavemaker": {"wave": {"kind": "regulr"}}}, "wavemaker.wave", "'regular'", ""),
    "unknown key of a wave": (
        {"wavemaker": {"wave": {"kind": "regular", "heigt": 0.1}}},
        "wavemaker.wave.heigt",
        "unknown key",
        "'height'",
    ),
    "missing section": ({"time": None}, "time", "", ""),
    "not finite": ({"time.end": float("nan")}, "time.end", "finite", "[s]"),
    "negative": ({"time.end": -1.0}, "time.end", "greater than", "[s]"),
    "unknown choice": ({"numerics.kernel": "wendland"}, "numerics.kernel", "wendland-c2", "kernel"),
    "unknown kind of gauge": ({"gauges": [{"kind": "levle", "x": 0.1}]}, "gauges.0", "levle", ""),
    "no size": ({"domain.size": [0.2, 0.0]}, "domain.size.1", "must be > 0 m", ""),
    "no blocks": ({"fluid.blocks": []}, "fluid.blocks", "at least 1", "block"),
    "wrong number of components": ({"fluid.blocks.0.low": [0.0]}, "fluid.blocks.0.low", "1 component", "2"),
    "no particles": ({"fluid.blocks.0.high": [0.004, 0.2]}, "fluid.blocks.0", "no particles", "dx"),
    "block upside down": ({"fluid.blocks.0.high": [-0.2, 0.2]}, "fluid.blocks.0", "no particles", "dx"),
    "fluid outside": ({"fluid.blocks.0.high": [0.2, 0.4]}, "fluid.blocks.0", "outside the domain", "domain.size"),
    "fluid below": ({"fluid.blocks.0.low": [0.0, -0.1]}, "fluid.blocks.0", "outside the domain", "domain.size"),
    "too many particles": ({"numerics.dx": 1e-6}, "fluid.blocks.0", "more than 2e9", "larger"),
    "too many cells": ({"domain.size": [9e4, 9e4]}, "domain.size", "cells", "smaller"),
    "overlapping blocks": (
        {"fluid.blocks": [{"low": [0, 0], "high": [0.2, 0.1]}, {"low": [0, 0.05], "high": [0.2, 0.2]}]},
        "fluid.blocks.1",
        "overlaps block 0",
        "touch",
    ),
    "seiche without gravity": (
        {"fluid.blocks.0.initial": "seiche", "domain.gravity": 0, "numerics.c0": 20},
        "fluid.blocks.0.initial",
        "seiche",
        "",
    ),
    "gauge outside": ({"gauges": [{"kind": "level", "x": 0.7}]}, "gauges.0", "outside the domain", "0 to 0.2 m"),
    "pressure gauge outside": ({"gauges": [{"kind": "pressure", "point": [0.1, -1]}]}, "gauges.0", "outside", "0 to"),
    "gauge with a coordinate too many": (
        {"gauges": [{"kind": "level", "x": 0.1, "y": 0.1}]},
        "gauges.0",
        "number of coordinates",
        "2D",
    ),
    "gauges of one name": (
        {"gauges": [{"kind": "level", "x": 0.1, "name": "a"}, {"kind": "level", "x": 0.1, "name": "a"}]},
        "gauges.1.name",
        "taken",
        "name of its own",
    ),
    "gauge whose name is a path": (
        {"gauges": [{"kind": "level", "x": 0.1, "name": "../a"}]},
        "gauges.0.name",
        "no file name",
        "plain name",
    ),
    "empty region": (
        {"gauges": [{"kind": "energy", "low": [0.1, 0], "high": [0.1, 1]}]},
        "gauges.0",
        "region is empty",
        "low < high",
    ),
    "unstable dt": ({"time.dt": 0.01}, "time.dt", "unstable", "at most"),
    "unstable cfl": ({"time.cfl": 0.9}, "time.cfl", "unstable", "at most 0.5"),
    "h/dx too small": ({"numerics.h_over_dx": 0.5}, "numerics.h_over_dx", "out of range", "1.0 to 4.0"),
    "h/dx too large": ({"numerics.h_over_dx": 8.0}, "numerics.h_over_dx", "out of range", "1.0 to 4.0"),
    "h/dx out of another kernel's range": (
        {"numerics.kernel": "gaussian", "numerics.h_over_dx": 3.0},
        "numerics.h_over_dx",
        "out of range",
        "0.8 to 2.0",
    ),
    "c0 missing": ({"domain.gravity": 0}, "numerics.c0", "is missing", ""),
    "c0 too slow": ({"numerics.c0": 2.0}, "numerics.c0", "too slow", "at least 14"),
    "density range": ({"numerics.density_range": [1.1, 1.2]}, "numerics.density_range", "must hold 1", "[0.7, 1.3]"),
    "walls too near": (
        {"domain.size": [0.03, 0.3], "fluid.blocks.0.high": [0.03, 0.2]},
        "walls.left, right",
        "nearer",
        "at least 0.04 m",
    ),
    "wall that 2D does not have": ({"walls.front": {}}, "walls.front", "no such side", ""),
    "layer too long": ({"damping": [{"length": 0.2}]}, "damping.0.length", "too long", "less than"),
    "two layers at one end": ({"damping": [{"length": 0.05}, {"length": 0.06}]}, "damping.1.side", "second", "one per"),
    "overlapping layers": (
        {"damping": [{"length": 0.15}, {"length": 0.15, "side": "left"}]},
        "damping",
        "overlap",
        "at most 0.2 m",
    ),
    "layer right of the fluid": (
        {"damping": [{"length": 0.05}], "fluid.blocks.0.high": [0.15, 0.2]},
        "damping.0",
        "outside the fluid",
        "a longer one",
    ),
    "layer left of the fluid": (
        {"damping": [{"length": 0.05, "side": "left"}], "fluid.blocks.0.low": [0.05, 0.0]},
        "damping.0",
        "outside the fluid",
        "a longer one",
    ),
    "layer of two strengths": (
        {"damping": [{"length": 0.05, "sigma0": 3.0, "v_ref": 3.0}]},
        "damping.0.sigma0",
        "given beside v_ref",
        "one of the two",
    ),
    "unknown profile": (
        {"damping": [{"length": 0.05, "profile": "cubic"}]},
        "damping.0.profile",
        "'hyperbolic' or 'power'",
        "power",
    ),
    "unknown switch": (
        {"damping": [{"length": 0.05, "switch": "vy"}]},
        "damping.0.switch",
        "'vx', 'vx-vy' or 'fx-vx'",
        "(vx-vy)",
    ),
    "unknown killing": (
        {"damping": [{"length": 0.05, "killing": "f3"}]},
        "damping.0.killing",
        "'f1' or 'f2'",
        "f1 = 1 - depth/L",
    ),
    "density damped or not": (
        {"damping": [{"length": 0.05, "density": True}]},
        "damping.0.density",
        "'none', 'plain' or 'matched'",
        "matched, so hard that",
    ),
    "softening of nothing": ({"damping": [{"length": 0.05, "softening": 0}]}, "damping.0.softening", "greater than 0", "0.5 h"),
    "negative strength": ({"damping": [{"length": 0.05, "sigma0": -1.0}]}, "damping.0.sigma0", "greater than 0", "[1/s]"),
    "exponent too small": (
        {"damping": [{"length": 0.05, "profile": "power", "exponent": 0}]},
        "damping.0.exponent",
        "greater than or equal to 1",
        "m of the power profile",
    ),
    "exponent too large": (
        {"damping": [{"length": 0.05, "profile": "power", "exponent": 21}]},
        "damping.0.exponent",
        "less than or equal to 20",
        "m of the power profile",
    ),
    "depth of a block in 2D": ({"fluid.blocks.0.depth": 0.2}, "fluid.blocks.0.depth", "is for shallow water", '"shallow"'),
    "center of a block in 2D": ({"fluid.blocks.0.center": 0.1}, "fluid.blocks.0.center", "is for shallow water", '"shallow"'),
    "width of a block in 2D": ({"fluid.blocks.0.width": 0.1}, "fluid.blocks.0.width", "is for shallow water", '"shallow"'),
    "pulse in 2D": ({"fluid.blocks.0.initial": "pulse"}, "fluid.blocks.0.initial", "is for shallow water", '"shallow"'),
    "summation in 2D": ({"numerics.density": "summation"}, "numerics.density", "usual range", "density_range"),
    "growing h in 2D": ({"numerics.h_growth": 2.0}, "numerics.h_growth", "is for shallow water", "leave it out"),
    "h that shrinks": ({"numerics.h_growth": 0.5}, "numerics.h_growth", "greater than or equal to 1", "thinning water"),
    "shallow water in 2D": ({"numerics.state": "shallow"}, "domain.size", "needs one dimension", "size = [length]"),
}


def pond(**sections):
    """Return the keys of a good scene of shallow water, 40 m of it; `sections` replace whole sections."""
    keys = {
        "domain": {"size": [40.0]},
        "fluid": {"blocks": [{"low": [0.0], "high": [40.0], "depth": 1.5}]},
        "walls": {"left": {}, "right": {}},
        "numerics": {"state": "shallow", "dx": 0.5},
        "time": {"end": 0.1},
    }
    return {**keys, **sections}


PULSE = {"low": [0.0], "high": [40.0], "depth": 1.5, "initial": "pulse", "amplitude": 0.1}
SHALLOW_FAULTS = {
    "no gravity": ({"domain.gravity": 0}, "domain.gravity", "shallow water needs gravity", "9.81"),
    "sound speed": ({"numerics.c0": 20.0}, "numerics.c0", "no sound speed", "leave it out"),
    "no depth": (
        {"fluid.blocks": [{"low": [0.0], "high": [40.0]}]},
        "fluid.blocks.0.depth",
        "is missing",
        "depth of this block [m]",
    ),
    "no depth of the second": (
        {"fluid.blocks": [{"low": [0.0], "high": [20.0], "depth": 1.0}, {"low": [20.0], "high": [40.0]}]},
        "fluid.blocks.1.depth",
        "is missing",
        "depth of this block [m]",
    ),
    "depth of nothing": ({"fluid.blocks.0.depth": 0.0}, "fluid.blocks.0.depth", "greater than 0", "still-water depth [m]"),
    "pulse of no place": ({"fluid.blocks": [{**PULSE, "width": 3.0}]}, "fluid.blocks.0", "a pulse needs center", "in m"),
    "pulse of no width": ({"fluid.blocks": [{**PULSE, "center": 3.0}]}, "fluid.blocks.0", "a pulse needs width", "in m"),
    "pulse of neither": ({"fluid.blocks": [PULSE]}, "fluid.blocks.0", "a pulse needs center and width", "both in m"),
    "pulse upside down": ({"fluid.blocks": [{**PULSE, "amplitude": -0.1}]}, "fluid.blocks.0.amplitude", "greater than", "[m]"),
    "seiche": ({"fluid.blocks.0.initial": "seiche"}, "fluid.blocks.0.initial", "a seiche needs 2D", '"pulse"'),
    "fourtakas": ({"numerics.diffusion": "fourtakas"}, "numerics.diffusion", "no meaning", '"molteni" or "none"'),
    "wavemaker": (
        {"wavemaker": {"wave": {"kind": "oscillation", "angle": 3.0, "period": 2.0}}},
        "wavemaker.kind",
        "two dimensions",
        "leave it out",
    ),
    "bed": ({"walls.bottom": {}}, "walls.bottom", "no such side in 1D", "leave it out"),
    "switch of a vertical velocity": (
        {"damping": [{"length": 9.0, "switch": "vx-vy"}]},
        "damping.0.switch",
        "there is no vy in 1D",
        '"fx-vx"',
    ),
    "gauge across": ({"gauges": [{"kind": "level", "x": 0.1, "y": 0.1}]}, "gauges.0", "number of coordinates", "shallow water"),
    "unstable dt": ({"time.dt": 0.2}, "time.dt", "unstable", "c0 = 3.836 m/s"),
    "density range": ({"numerics.density_range": [-0.1, 2.0]}, "numerics.density_range", "begin below 0", ""),
    "walls nearer than a grown h": (
        {"numerics.h_growth": 25.0, "numerics.viscosity": "monaghan", "numerics.alpha": 0.5},
        "walls.left, right",
        "nearer",
        "at least 50 m",
    ),
}
ALL_FAULTS = {
    **{name: (tank, *fault) for name, fault in FAULTS.items()},
    **{f"shallow: {name}": (pond, *fault) for name, fault in SHALLOW_FAULTS.items()},
}


@pytest.mark.parametrize("name", ALL_FAULTS)
def test_every_fault_says_where_what_and_the_cure(name):
    good, overrides, where, what, cure = ALL_FAULTS[name]
    with pytest.raises(SceneError) as caught:
        load_scene(good(), overrides)
    faults = [fault for fault in caught.value.faults if fault.where == where]
    assert faults, f"nothing about {where}: {caught.value}"
    assert any(what in fault.what for fault in faults), f"not {what!r}: {caught.value}"
    assert all(fault.cure for fault in faults), f"no cure: {caught.value}"
    assert any(cure in fault.cure for fault in faults), f"no cure with {cure!r}: {[f.cure for f in faults]}"
    assert f"{where}: " in str(caught.value)
    assert caught.value.exit_code == 2


def test_a_good_scene_has_no_fault():
    """The table above would mean little if the tank that it changes were not good itself."""
    assert load_scene(tank()).dim == 2
    assert load_scene(pond()).dim == 1
    assert load_scene(pond(), {"fluid.blocks": [{**PULSE, "center": 3.0, "width": 3.0}]}).shallow
    layer = {"length": 9.0, "sigma0": 1.0, "softening": 0.1, "switch": "fx-vx", "killing": "f2", "density": "plain"}
    assert load_scene(pond(damping=[layer])).damping[0].softening == 0.1


def test_faults_of_shallow_water_are_told_together():
    overrides = {"domain.gravity": 0, "numerics.c0": 3.0, "fluid.blocks.0.initial": "seiche", "numerics.diffusion": "fourtakas"}
    with pytest.raises(SceneError) as caught:
        load_scene(pond(), overrides)
    assert {fault.where for fault in caught.value.faults} == set(overrides)


@pytest.mark.parametrize("name", ["matched without gravity", "matched without depth"])
def test_density_that_cannot_be_matched_is_a_fault(name):
    """There are no long waves to match without gravity, or above the level."""
    overrides = {"domain.gravity": 0} if name == "matched without gravity" else {"fluid.level": -0.1}
    with pytest.raises(SceneError, match=r"damping\.0\.density"):
        build(load_scene(tank(damping=[{"length": 0.05, "density": "matched"}]), {"numerics.c0": 20.0, **overrides}))


def test_diffusion_of_summed_densities_is_a_fault():
    with pytest.raises(SceneError, match=r"numerics\.diffusion"):
        load_scene(pond(), {"numerics.density": "summation", "numerics.diffusion": "molteni"})


@pytest.mark.parametrize("section", ["domain", "fluid", "numerics", "time"])
def test_missing_section_has_a_cure(section):
    keys = tank()
    del keys[section]
    with pytest.raises(SceneError, match=f"{section}: is missing") as caught:
        load_scene(keys)
    assert all(fault.cure for fault in caught.value.faults)


def test_all_wrong_keys_are_told_at_once():
    overrides = {"numerics.dxx": 1, "time.end": "soon", "walls.left": {"lw": 1}, "fluid.blocks.0.low": "here"}
    with pytest.raises(SceneError) as caught:
        load_scene(tank(), overrides)
    assert {fault.where for fault in caught.value.faults} >= {*overrides.keys() - {"walls.left"}, "walls.left.lw"}


def test_all_impossible_values_are_told_at_once():
    """Numerics, geometry, gauges and layers: a fault of one does not hide those of the others."""
    overrides = {
        "time.dt": 0.01,
        "numerics.h_over_dx": 8.0,
        "fluid.blocks.0.high": [0.2, 0.4],
        "gauges": [{"kind": "level", "x": 0.7}],
        "damping": [{"length": 3.0}],
    }
    with pytest.raises(SceneError) as caught:
        load_scene(tank(), overrides)
    found = {fault.where for fault in caught.value.faults}
    assert found >= {"time.dt", "numerics.h_over_dx", "fluid.blocks.0", "gauges.0", "damping.0.length"}


@pytest.mark.parametrize(
    ("overrides", "where", "text"),
    [
        (["time.end"], "--set", "key=value"),
        (["=3"], "--set", "key=value"),
        (["gauges.7.x=1"], "--set gauges.7.x", "not an item"),
        (["fluid.blocks.first.low=1"], "--set fluid.blocks.first.low", "not an item"),
        (["time.end.x=1"], "--set time.end.x", "not a section"),
    ],
)
def test_overrides_that_fit_nowhere(overrides, where, text):
    with pytest.raises(SceneError, match=text) as caught:
        load_scene(tank(gauges=[{"kind": "level", "x": 0.1}]), overrides)
    assert caught.value.where == where
    assert caught.value.cure


def test_overrides_reach_sections_lists_and_what_is_not_there_yet():
    text = [
        "time.end=0.5",
        "numerics.kernel=gaussian",
        "numerics.h_over_dx = 1.3",
        "output.snapshots.every=0.25",
        "gauges.0.x=0.15",
        "fluid.blocks.0.high=[0.2, 0.1]",
        "title=two words, no quotes",
        "walls.top={}",
    ]
    scene = load_scene(tank(gauges=[{"kind": "level", "x": 0.1}]), text)
    assert (scene.time.end, scene.numerics.kernel, scene.numerics.h_over_dx) == (0.5, "gaussian", 1.3)
    assert (scene.output.snapshots.every, scene.gauges[0].x) == (0.25, 0.15)
    assert (scene.fluid.blocks[0].high, scene.title) == ([0.2, 0.1], "two words, no quotes")
    assert scene.walls.top is not None
    assert load_scene(tank(), {"time.end": 0.5}).time.end == 0.5


def test_overrides_do_not_change_the_keys_they_are_given_with():
    keys = tank()
    load_scene(keys, {"fluid.blocks.0.high": [0.2, 0.1]})
    assert keys == tank()


@pytest.mark.parametrize("name", builtin_names())
def test_builtin_scenes_load_and_describe_themselves(name):
    scene = load_scene(name)
    assert scene.title
    assert "\n" not in scene.title


def test_there_are_the_scenes_that_the_commands_name():
    assert {"pool", "seiche", "still", "pool-infinite", "pool-reflecting", "pool-impulse"} <= set(builtin_names())
    assert {"swe-pulse", "swe-pulse-infinite", "swe-pulse-reflecting"} <= set(builtin_names())
    assert {"swe-dam-break", "swe-dam-break-dry"} <= set(builtin_names())
    assert {"still-tank", "dam-break", "dam-break-small", "wedge-tank"} <= set(builtin_names())


@pytest.mark.parametrize("name", builtin_names())
def test_the_text_of_a_scene_is_the_scene(name):
    """Every output file holds this text: it must bring back the same scene, defaults filled in."""
    scene = load_scene(name)
    keys = json.loads(scene_text(scene))
    assert load_scene(keys) == scene
    assert keys["numerics"]["gamma"] == 7.0


def test_unknown_scene_names_the_near_and_all_others(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match=r"did you mean 'seiche'.*pool, .*, seiche, seiche-long, .*, still, ") as caught:
        load_scene("siche")
    assert caught.value.cure.endswith(", ".join(builtin_names()))


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"[time\nend = 3", "not valid TOML"),
        (b"\xff\xfe\x00", "cannot be read"),
        (b"title = 2020-01-01", "title"),  # a date is TOML, but no scene has one
        (b"", "is missing"),
    ],
)
def test_files_that_are_no_scene(tmp_path, content, text):
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=text):
        load_scene(path)


def test_a_file_is_a_scene(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[domain]\nsize = [0.2, 0.3]\n[fluid]\nblocks = [{low = [0, 0], high = [0.2, 0.2]}]\n")
    with path.open("a") as file:
        file.write("[numerics]\ndx = 0.01\n[time]\nend = 1\n[walls]\nleft = {}\nright = {}\nbottom = {}\n")
    assert load_scene(str(path)).time.end == 1
    assert scene_name(path) == "mine"


def properties(schema, path):
    """Return the schema of the dotted key `path`."""
    place = schema
    for part in path.split("."):
        place = place["properties"][part]
        while "$ref" in place:
            place = schema["$defs"][place["$ref"].rsplit("/")[-1]]
    return place


@pytest.mark.parametrize("key", ["time.end", "output.snapshots.every", "numerics.h_over_dx"])
def test_schema_names_the_keys_that_outside_scripts_rely_on(key):
    entry = properties(json.loads(json_schema()), key)
    assert "[" in entry["description"]
    assert load_scene(tank(), {key: 1.5})


def test_every_key_of_the_schema_is_described():
    schema = json.loads(json_schema())
    for name, model in schema["$defs"].items():
        assert model.get("description"), name
        for key, entry in model["properties"].items():
            described = "description" in entry or "$ref" in entry or key in ("kind", "snapshots", "log")
            assert described, f"{name}.{key}"


def test_numbers_that_follow_from_the_keys():
    """c0 = c0_factor sqrt(g depth), h = h_over_dx dx; both may be given."""
    scene = load_scene(tank())
    assert scene.c0 == pytest.approx(20 * (9.81 * 0.2) ** 0.5)
    assert scene.h == pytest.approx(0.02)
    assert load_scene(tank(), {"numerics.c0": 33.0}).c0 == 33.0
    assert load_scene(tank(), {"fluid.level": 0.25}).depth == 0.25


@pytest.mark.parametrize("size", [[1.0], [0.2, 0.3], [0.2, 0.2, 0.3]])
def test_still_water_begins_in_hydrostatic_balance(size):
    """The exact balance of a column compressed by its own weight; in 1D there is no gravity.

    dp/d(depth) = rho g, p = rho0 g (mean density over the scene's rho0) depth at the bed, mass = rho dx^dim.
    """
    dim, level, mean, gravity = len(size), 0.2, 1000.0, 9.81
    high = [*size[:-1], level] if dim > 1 else [0.5]
    keys = {
        "domain": {"size": size},
        "fluid": {"rho0": mean, "blocks": [{"low": [0.0] * dim, "high": high}]},
        "numerics": {"dx": 0.02, "c0": 30.0},
        "time": {"end": 0.0},
    }
    scene = load_scene(keys)
    simulation = build(scene)
    position, density, pressure = (simulation.field(name) for name in ("position", "density", "pressure"))
    assert len(position) == round(math.prod(high) / 0.02**dim)
    assert simulation.field("mass") == pytest.approx(density * 0.02**dim)
    assert sorted(simulation.field("id")) == list(range(len(position)))
    if dim == 1:
        assert scene.rho0 == mean
        assert pressure == pytest.approx(0 * pressure, abs=1e-6)
        assert density == pytest.approx(mean + 0 * density)
        return
    assert scene.rho0 == pytest.approx(mean / (1 + gravity * level / (2 * 30.0**2)))
    assert density.mean() == pytest.approx(mean, rel=1e-4)
    depth = level - position[:, -1]
    assert density == pytest.approx(scene.rho0 * (1 + 6 * gravity * depth / 30.0**2) ** (1 / 6))
    state = state_of(scene)
    above, below = (state.pressure(state.still_density(gravity * (depth + shift))) for shift in (-1e-4, 1e-4))
    assert (below - above) / 2e-4 == pytest.approx(density * gravity, rel=1e-6)
    assert pressure == pytest.approx(state.pressure(density), abs=1e-6)
    bed = state.pressure(state.still_density(gravity * level))
    assert bed == pytest.approx(mean * gravity * level, rel=1e-4)


def test_package_offers_scene_and_build():
    assert parsph.load_scene is load_scene
    assert parsph.build is build
    with pytest.raises(AttributeError, match="nonsense"):
        parsph.nonsense  # noqa: B018


@pytest.mark.parametrize(
    ("written", "seconds"),
    [
        (90, 90.0),
        ("90", 90.0),
        ("1.5", 1.5),
        ("0:01:30", 90.0),
        ("12:00:00", 43200.0),
        ("1-02:00:00", 93600.0),
        ("2-00:00:01.5", 172801.5),
        ("100:00:00", 360000.0),
    ],
)
def test_durations_are_seconds_or_what_queues_write(written, seconds):
    scene = load_scene(tank(), {"time.walltime": written, "output.checkpoints.every": written})
    assert scene.time.walltime == scene.output.checkpoints.every == seconds


@pytest.mark.parametrize("written", ["soon", "", "-1", "-1:00:00", "nan", "1:2:3:4", "1 h", [1], 1e300, -0.5])
def test_durations_that_are_none(written):
    with pytest.raises(SceneError, match=r"time\.walltime"):
        load_scene(tank(), {"time.walltime": written})
