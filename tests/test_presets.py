"""Presets: what they fill in, what they replace, and what the study of them reports."""

import json

import pytest

from parsph.errors import SceneError, SceneFaults
from parsph.scene.load import load_scene, scene_text
from parsph.scene.presets import GOVERNED, PRESETS

TANK = {
    "domain": {"size": [1.0, 0.8]},
    "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [1.0, 0.5]}]},
    "walls": {"left": {}, "right": {}, "bottom": {}},
    "numerics": {"dx": 0.05},
    "time": {"end": 1.0},
}


def tank(**numerics):
    return TANK | {"numerics": TANK["numerics"] | numerics}


def governed(scene):
    """The keys of a scene that presets say."""
    return {key: value for key, value in scene.numerics.model_dump().items() if key in GOVERNED}


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_says_all_that_presets_govern(name):
    assert set(PRESETS[name]) == set(GOVERNED)
    assert governed(load_scene(tank(preset=name))) == PRESETS[name]


def test_presets_differ():
    assert len({json.dumps(preset, sort_keys=True) for preset in PRESETS.values()}) == len(PRESETS)


def test_keys_beside_a_preset_win():
    scene = load_scene(tank(preset="standard", h_over_dx=1.7, alpha=0.01))
    assert governed(scene) == PRESETS["standard"] | {"h_over_dx": 1.7}
    assert scene.numerics.alpha == 0.01


def test_a_preset_on_top_of_a_scene_replaces_that_scene_s_keys():
    """The seiche has a diffusion and an h/dx of its own."""
    plain = load_scene("seiche")
    scene = load_scene("seiche", {"numerics.preset": "draft"})
    assert governed(scene) == PRESETS["draft"] != governed(plain)
    assert scene.numerics.dx == plain.numerics.dx


@pytest.mark.parametrize(
    "settings", [["numerics.delta=0.05", "numerics.preset=draft"], ["numerics.preset=draft", "numerics.delta=0.05"]]
)
def test_settings_beside_a_preset_win_in_any_order(settings):
    assert governed(load_scene("seiche", settings)) == PRESETS["draft"] | {"delta": 0.05}


def test_a_file_s_preset_replaces_what_its_base_says(tmp_path):
    path = tmp_path / "quick.toml"
    path.write_text('base = "seiche"\n[numerics]\npreset = "accurate"\ndx = 0.02\n')
    scene = load_scene(path)
    assert governed(scene) == PRESETS["accurate"]
    assert scene.numerics.dx == 0.02


def test_a_scene_on_top_of_one_with_a_preset_keeps_it(tmp_path):
    (tmp_path / "one.toml").write_text('base = "seiche"\n[numerics]\npreset = "draft"\n')
    (tmp_path / "two.toml").write_text('base = "one.toml"\n[numerics]\nh_over_dx = 1.6\n')
    assert governed(load_scene(tmp_path / "two.toml")) == PRESETS["draft"] | {"h_over_dx": 1.6}


def test_the_whole_scene_loads_again_as_the_same(tmp_path):
    """With all keys beside the preset; another preset on top replaces them."""
    scene = load_scene("seiche", {"numerics.preset": "draft", "numerics.delta": 0.05})
    path = tmp_path / "scene.json"
    path.write_text(scene_text(scene))
    assert load_scene(path) == scene
    assert governed(load_scene(path, {"numerics.preset": "standard"})) == PRESETS["standard"]


def test_no_preset_leaves_the_defaults():
    assert load_scene(tank()).numerics.preset is None
    assert governed(load_scene("seiche", {"numerics.preset": "standard"})) != governed(load_scene("seiche"))


@pytest.mark.parametrize("value", ["fast", 3, ["draft"]])
def test_other_presets_are_refused(value):
    with pytest.raises(SceneFaults, match=r"numerics\.preset.*'draft', 'standard' or 'accurate'"):
        load_scene(tank(preset=value))


def test_shallow_water_has_no_preset():
    with pytest.raises(SceneError, match=r"numerics\.preset: is not for shallow water"):
        load_scene("swe-pulse", {"numerics.preset": "draft"})
