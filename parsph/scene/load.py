"""Scenes from TOML: overrides, and errors that say where, what, why and what would be right."""

import copy
import json
import os
import re
import tomllib
from importlib import resources
from pathlib import Path

from pydantic import BaseModel, ValidationError

from ..errors import SceneError, SceneFaults, did_you_mean, shortened, shown
from ..files import read_text
from .check import faults_of
from .makers_schema import WAVE_KINDS
from .presets import without_governed
from .schema import GAUGE_KINDS, Scene

BUILTIN = resources.files(__package__) / "builtin"
PRESET = "numerics.preset"  # on top of a scene it replaces the keys that presets say
MOST_FAULTS = 100  # that are told at once
MOST_BASES = 20  # scenes of which each builds on the next
DEEPEST = 20  # parts of a dotted key
LARGEST_FILE = 2e6  # bytes of a scene
LONGEST_MESSAGE = 400  # characters: the names of all kernels, and no list of the user's
PART_OF_KEY = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""


def builtin_names():
    """Return the names of the built-in scenes."""
    return sorted(entry.name.removesuffix(".toml") for entry in BUILTIN.iterdir() if entry.name.endswith(".toml"))


def load_scene(source="pool", overrides=None):
    """Return the scene that `source` names, with overrides, checked.

    Parameters
    ----------
    source : str, Path or dict
        A built-in scene, a TOML file, the ``scene.json`` of a run, or the keys themselves. A scene with ``base = "other"``
        starts from that scene (built-in, or a file beside it): sections are merged, values and lists replaced.
    overrides : dict or list of str, optional
        ``{"time.end": 1.0}`` or ``["time.end=1.0"]``; list items by number, as ``gauges.0.x``.

    Raises
    ------
    SceneFaults
        With all faults of the scene.
    SceneError
        When there is no such scene, or it is not TOML.
    """
    items = list(overrides.items() if isinstance(overrides, dict) else map(parse_setting, overrides or []))
    try:
        keys = _with_base(source, ())
        if any(key == PRESET for key, _ in items):
            keys = without_governed(keys)
        for key, value in items:
            _override(keys, key, value)
    except RecursionError:
        cure = "tables and lists as parsph show prints them"
        raise SceneError("is nested too deeply", where=scene_name(source), cure=cure) from None
    _locate(keys)  # so that a copy of the scene, as in the folder of a run, means the same file
    scene = validated(Scene, keys, "the scene")
    faults = faults_of(scene)
    if faults:
        raise told_at_once(faults, "the scene")
    return scene


def validated(model, keys, name):
    """Return the `model` (a class of pydantic) of these keys; SceneFaults, with the `name` of all, when they are none."""
    try:
        return model.model_validate(keys)
    except ValidationError as error:
        raise told_at_once(error.errors(include_url=False), name, lambda entry: fault_of(entry, model)) from None


def told_at_once(faults, name, told=lambda fault: fault):
    """Return the SceneFaults of what `name` says, each as `told` makes it, of very many not those that nobody would read."""
    more = len(faults) - MOST_FAULTS
    rest = [SceneError(f"has {more:,} faults more", where=name, cure="mend these first")] if more > 0 else []
    return SceneFaults([*map(told, faults[:MOST_FAULTS]), *rest])


def scene_name(source):
    """Return the name of a scene for folders and titles."""
    return "scene" if isinstance(source, dict) else Path(source).stem


def scene_text(scene):
    """Return the full scene, defaults filled in, as JSON."""
    return scene.model_dump_json(indent=1)


def json_schema():
    """Return the JSON Schema of scenes, for editors; nothing is required, since a scene may have a base."""
    schema = Scene.model_json_schema()
    wave = schema["$defs"]["Wavemaker"]["properties"]["wave"]
    wave["anyOf"] = wave.pop("oneOf")  # without its kind, which the base has, a wave may be one of several
    del wave["discriminator"]
    waves = [entry["$ref"].rsplit("/")[-1] for entry in wave["anyOf"]]
    for section in ("DomainSection", "FluidSection", "Numerics", "TimeSection", "Wavemaker", "Block", "PolygonWall", *waves):
        schema["$defs"][section].pop("required", None)
    schema["properties"]["base"] = {"type": "string", "description": "scene that this one starts from: built-in, or a file"}
    del schema["required"]
    return json.dumps(schema, indent=1)


def _with_base(source, above):
    """Return the keys of a scene merged into those of its base; `above` are the scenes that build on it."""
    keys = copy.deepcopy(source) if isinstance(source, dict) else _read(source)
    if not isinstance(source, dict) and str(source) not in builtin_names():
        _locate(keys, Path(source).parent)
    base = keys.pop("base", None)
    if base is None:
        return keys
    name = "the scene" if isinstance(source, dict) else str(source)
    if not isinstance(base, str):
        raise SceneError(f"base must be a name, not {shown(base)}", where=name, cure='as base = "pool"')
    if base not in builtin_names() and not isinstance(source, dict):
        base = os.path.normpath(Path(source).parent / base)
    chain = (*above, name if name in builtin_names() else os.path.normpath(name))
    if base in chain:
        raise SceneError("is its own base", where=base, why=" -> ".join((*chain, base)), cure="another base")
    if len(chain) > MOST_BASES:
        what = f"more than {MOST_BASES} scenes build on each other"
        raise SceneError(what, where=base, cure="fewer, with all their keys in one file")
    below = _with_base(base, chain)
    named = isinstance(keys.get("numerics"), dict) and keys["numerics"].get("preset") is not None
    return _merged(without_governed(below) if named else below, keys)


def _locate(keys, folder="."):
    """Make the file that a wave is read from absolute; it is named relative to the `folder` of the scene."""
    maker = keys.get("wavemaker")
    wave = maker.get("wave") if isinstance(maker, dict) else None
    if isinstance(wave, dict) and isinstance(wave.get("file"), str):
        wave["file"] = os.path.abspath(os.path.join(folder, wave["file"]))


def _merged(base, keys):
    """Return `base` with `keys` put over it, section by section; a wave of another kind begins anew."""
    both = dict(base)
    for key, value in keys.items():
        inner = isinstance(value, dict) and isinstance(both.get(key), dict)
        anew = inner and key == "wave" and value.get("kind", both[key].get("kind")) != both[key].get("kind")
        both[key] = _merged(both[key], value) if inner and not anew else value
    return both


def _read(source):
    path = Path(source)
    if str(source) in builtin_names():
        return _parsed((BUILTIN / f"{source}.toml").read_text(encoding="utf-8"), source, "TOML")
    if not os.path.exists(path):
        raise SceneError(
            f"no scene {shown(str(source))}",
            why="it is neither a file nor the name of a built-in scene",
            cure=f"{did_you_mean(source, builtin_names())}built-in scenes: {', '.join(builtin_names())}",
        )
    return read_keys(source, "JSON" if path.suffix == ".json" else "TOML")


def read_keys(source, language="TOML"):
    """Return the keys of a file, which need not be a scene; SceneError when it holds none."""
    return _parsed(read_text(Path(source), LARGEST_FILE, "a TOML file"), source, language)


def _toml(text):
    """Return the keys of a text; refuse dotted keys of many parts, for which the parser takes their number squared."""
    too_deep = re.search(rf"""(?<![\w"'-])(?:{PART_OF_KEY}[ \t]*\.[ \t]*){{{DEEPEST}}}""", text)
    if too_deep:
        raise ValueError(f"a key of more than {DEEPEST} parts, {shortened(too_deep[0])}")
    return tomllib.loads(text)


PARSERS = {"TOML": _toml, "JSON": json.loads}


def _parsed(text, source, language):
    try:
        keys = PARSERS[language](text)
    except ValueError as error:  # so are both languages' errors, and that of a number of thousands of digits
        raise SceneError(f"not valid {language}: {error}", where=str(source), cure="mend that place") from None
    if not isinstance(keys, dict):
        raise SceneError("holds no sections", where=str(source), cure="the scene.json of a run, or a TOML file")
    return keys


def parse_setting(setting):
    """Return (key, value) of a ``key=value`` of the command line; values are TOML, or else text."""
    key, equals, text = setting.partition("=")
    if not equals or not key.strip():
        raise SceneError(f"{shown(setting)} is not of the form key=value", where="--set", cure="as --set time.end=5")
    try:
        keys = _toml(f"value = {text}")
    except (ValueError, RecursionError):
        keys = {}
    return key.strip(), keys["value"] if keys.keys() == {"value"} else text.strip()


def _override(keys, key, value):
    """Set the dotted `key`, making sections that are not there yet."""
    *path, last = key.split(".")
    place, where = keys, f"--set {shortened(key)}"
    if len(path) > DEEPEST:
        raise SceneError(f"there is no key {len(path)} sections deep", where=where, cure="see parsph show SCENE")
    for depth, part in enumerate(path):
        place = place.setdefault(part, {}) if isinstance(place, dict) else _item(place, part, where)
        if not isinstance(place, dict | list):
            raise SceneError(
                f"{shortened('.'.join(path[: depth + 1]))} is not a section", where=where, cure="see parsph show SCENE"
            )
    if isinstance(place, list):
        _item(place, last, where)
        last = int(last)
    place[last] = copy.deepcopy(value)  # later overrides may reach into it


def _item(items, number, where):
    if not (number.isdecimal() and len(number) < 9 and int(number) < len(items)):
        cure = f"0 to {len(items) - 1}" if items else "none: the list is empty, so set it as a whole"
        raise SceneError(f"{shown(number)} is not an item of the list", where=where, cure=cure)
    return items[int(number)]


def fault_of(entry, model=Scene):
    """Turn one of pydantic's findings about a `model` into a fault with the nearest valid key or the key's description."""
    kinds = {"gauges": GAUGE_KINDS, "wavemaker": WAVE_KINDS}.get(entry["loc"][0] if entry["loc"] else None, ())
    where = (
        shortened(".".join(str(part) for part in entry["loc"] if part not in kinds)) or "''"
    )  # kinds stand there, but are no keys
    model, field = _resolve(entry["loc"], model)
    if entry["type"] == "extra_forbidden":
        near = did_you_mean(entry["loc"][-1], model.model_fields).strip()
        return SceneError("unknown key", where=where, cure=near or f"valid keys: {', '.join(model.model_fields)}")
    if entry["type"] == "missing":
        return SceneError("is missing", where=where, cure=_cure(field))
    if entry["type"] == "union_tag_not_found":
        return SceneError("is missing", where=f"{where}.kind", cure=f"one of: {', '.join(kinds)}")
    message = shortened(entry["msg"][0].lower() + entry["msg"][1:], LONGEST_MESSAGE)
    given = entry.get("input")
    if not isinstance(given, dict | list):
        message += f", not {shown(given)}"
    return SceneError(message, where=where, cure=_cure(field))


def _cure(field):
    """Return what a key takes: its description, or the keys of the section that it is."""
    if field is None:
        return "see parsph show --schema"
    if field.description:
        return field.description
    models = _models(field.annotation)
    kinds = [kind for model in models if "kind" in model.model_fields for kind in _kinds(model)]
    if len(models) > 1:
        return f"a section with kind = {', '.join(map(repr, kinds))}"
    return f"a section with the keys {', '.join(models[0].model_fields)}" if models else "see parsph show --schema"


def _resolve(location, model):
    """Return the model inside `model` that holds the key at `location`, and its field if it has one."""
    field = None
    for part in location:
        if isinstance(part, int):
            continue
        candidates = _models(field.annotation) if field is not None else [model]
        if not candidates:  # inside a plain table or list: what the field says of itself is all there is to know
            break
        if field is not None and candidates:
            tagged = [m for m in candidates if "kind" in m.model_fields and part in _kinds(m)]
            if tagged:
                model, field = tagged[0], None
                continue
            model = candidates[0]
        field = model.model_fields.get(part)
        if field is None:
            break
    return model, field


def _kinds(model):
    return getattr(model.model_fields["kind"].annotation, "__args__", ())


def _models(annotation):
    """Return all models inside a type annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in getattr(annotation, "__args__", ()) for model in _models(part)]
