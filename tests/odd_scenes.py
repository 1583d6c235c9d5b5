"""Strategies of odd scenes: built-in ones with damage, and ones made up from the schema, mostly of sensible numbers."""

import copy
import json
import re
import tomllib
import types
import typing
from functools import lru_cache

from hypothesis import strategies as st
from pydantic import BaseModel

from parsph.scene.load import BUILTIN, builtin_names, load_scene, scene_text
from parsph.scene.schema import Block, PolygonWall, Scene

EVIL = (
    "__import__('os').system('touch evaluated')",
    "${IFS}$(touch evaluated)`touch evaluated`",
    "!!python/object/apply:os.system ['touch evaluated']",
    "{0.__class__.__mro__}%n%s{{7*7}}",
)
PATHS = (
    "../x",
    "/tmp/x",
    "a/b",
    "..",
    ".",
    ".hidden",
    "con",
    "NUL.csv",
    "a\\b",
    "C:x",
    "x\0y",
    "x\ny",
    "x" * 300,
    "é" * 150,
    " ",
)
TEXTS = ("", "x", "left", "bottom", "bed", "LEFT", "水", "\u202e", "\x1b[2J", "[/bold]", "[red]", "-1", "1e9", "y" * 20_000)
NUMBERS = (
    *(0, -0.0, 1, -1, 2, 0.5, 1e-3, -1e-3, 1e-9, 1e-12, 1e-17, 5e-324, 1e-300, 1e3, 1e6, 1e9, 1e12, 1e15, 1e100, 1e308),
    *(-1e308, float("inf"), float("-inf"), float("nan"), 2**31, 2**63, 10**30, 10**400, -(10**400), True, False),
)
WRONG = ([], {}, [[]], [{}], {"x": 1}, [1], [0.0, 0.0], [1, 2, 3], [1, "x"], ["x"], None, [[0, 0], [0, 1]], [[0, 0]] * 3)
SENSIBLE = (0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.5, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)
FACTORS = (0.5, 0.8, 0.9, 1.0000001, 1.1, 1.5, 2, 3) * 3 + (-1, 0.1, 10, 1e3, 1e6, 1e9, 1e-3, 1e-6, 1e-9)
ACTS = ("scale",) * 5 + ("borrow",) * 4 + ("choose",) * 2 + ("add", "replace", "delete", "misspell", "move", "double")


def nested(depth):
    """A table so deep that recursion would not get to its end."""
    value = 1
    for level in range(depth):
        value = [value] if level % 2 else {"x": value}
    return value


odd_values = st.one_of(
    *map(st.sampled_from, (NUMBERS, NUMBERS, SENSIBLE, TEXTS, EVIL, PATHS, WRONG)),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from((5, 100)).map(nested),
    st.sampled_from(([0.0] * 20_000, [[0.1, 0.1]] * 3000, ["x"] * 3000, [{}] * 3000, {str(k): k for k in range(3000)})),
)


def places(keys, path=()):
    """All paths into nested tables and lists, into the first items of long ones."""
    inner = keys.items() if isinstance(keys, dict) else enumerate(keys[:30]) if isinstance(keys, list) else ()
    return [place for key, value in inner for place in ((*path, key), *places(value, (*path, key)))]


def at(keys, path):
    """What stands at a path."""
    for part in path:
        keys = keys[part]
    return keys


def coarse_text(name):
    """The text of a built-in scene, with larger particles where there are walls to look at."""
    text = (BUILTIN / f"{name}.toml").read_text(encoding="utf-8")
    if "polygons" not in text and "treatment" not in text:
        return text
    return re.sub(r"^dx = (.*)$", lambda found: f"dx = {2.5 * float(found[1].split()[0]):g}", text, flags=re.MULTILINE)


TEXT_OF = {name: coarse_text(name) for name in builtin_names()}
BASES = {name: tomllib.loads(text) for name, text in TEXT_OF.items()}
VALUES = {}  # by key, of all scenes with their defaults
for _name in BASES:
    _keys = json.loads(scene_text(load_scene(_name)))
    for *_path, _last in places(_keys):
        VALUES.setdefault(_last, []).append(at(_keys, [*_path, _last]))
NAMES = sorted(name for name in VALUES if isinstance(name, str))


@st.composite
def damaged(draw, least=1, most=4):
    """A built-in scene with some keys deleted, misspelt, moved, doubled, or of other values."""
    keys = copy.deepcopy(BASES[draw(st.sampled_from(sorted(BASES)))])
    for _ in range(draw(st.integers(least, most))):
        known = places(keys)
        if not known:
            break
        *path, last = draw(st.sampled_from(known))
        holder = at(keys, path)
        value = holder[last]
        act = draw(st.sampled_from(ACTS))
        if act == "scale" and isinstance(value, int | float) and abs(value) < 1e300:
            holder[last] = value * draw(st.sampled_from(FACTORS))
        elif act in ("borrow", "scale"):
            holder[last] = copy.deepcopy(draw(st.sampled_from(VALUES.get(last, [value]))))
        elif act == "add" and isinstance(holder, dict):
            name = draw(st.sampled_from(NAMES))
            holder[name] = copy.deepcopy(draw(st.sampled_from(VALUES[name])))
        elif act == "delete":
            del holder[last]
        elif act == "misspell" and isinstance(holder, dict):
            holder[draw(st.sampled_from((f"{last}x", str(last)[1:], str(last).upper(), "", *PATHS)))] = holder.pop(last)
        elif act == "move":
            target = at(keys, draw(st.sampled_from(known))[:-1])
            if isinstance(target, dict):
                target[draw(st.sampled_from((str(last), *NAMES)))] = copy.deepcopy(value)
        elif act == "double" and isinstance(value, list) and value:
            value.append(copy.deepcopy(draw(st.sampled_from(value))))
        elif act == "choose":
            holder[last] = draw(st.sampled_from(CHOICES.get(last, [value])))
        else:
            holder[last] = copy.deepcopy(draw(odd_values))
    return keys


# --- from the schema ---------------------------------------------------------------------------------------------------


def choices_of(annotation):
    """All literals in a type annotation."""
    if typing.get_origin(annotation) is typing.Literal:
        return list(typing.get_args(annotation))
    return [choice for part in typing.get_args(annotation) for choice in choices_of(part)]


def models_in(annotation):
    """All models in a type annotation, those in their fields too."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        fields = annotation.model_fields.values()
        return [annotation, *(model for field in fields for model in models_in(field.annotation))]
    return [model for part in typing.get_args(annotation) for model in models_in(part)]


CHOICES = {}  # by key
for _model in models_in(Scene):
    for _key, _field in _model.model_fields.items():
        CHOICES.setdefault(_key, []).extend(choices_of(_field.annotation))
CHOICES = {key: choices for key, choices in CHOICES.items() if choices}
numbers = st.sampled_from(SENSIBLE * 25 + (0.0, -0.1, 1e-6, 1e6) + NUMBERS)
texts = st.sampled_from(("left", "right", "bottom", "box", "bed", "plate", "a", "b") * 30 + PATHS + TEXTS)


BED = {"name": "bed", "points": [[0.0, 1.0], [0.0, 0.0], [3.0, 0.0], [3.0, 1.0]], "fluid": "left"}
BOX = {"name": "box", "points": [[1.2, 0.0], [1.8, 0.0], [1.8, 0.25], [1.2, 0.25]], "fluid": "outside"}
PLATE = {"name": "plate", "points": [[0.5, 1.0], [0.5, 0.0]], "fluid": "left"}
BASIN = {"name": "basin", "points": [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]], "fluid": "inside"}
EGG = {"name": "egg", "ellipse": {"center": [1.5, 0.3], "axes": [0.4, 0.2]}, "points": None, "fluid": "outside"}
BEACH = {"name": "beach", "points": [[0.5, 1.0], [0.5, 0.0], [1.5, 0.0], [3.0, 0.8]], "fluid": "left"}
GOOD_WALLS = (BED, BOX, PLATE, BASIN, EGG, BEACH)
SHALLOW = {"low": [0.0], "high": [40.0], "depth": 1.5}
WEDGE = {"points": [[0.5, 0.5], [0.5, 0.0], [1.5, 0.0], [2.5, 0.5]], "low": [0.5, 0.0], "high": [2.5, 0.5]}
GOOD_BLOCKS = {
    1: ({"low": [0.0], "high": [1.0]}, SHALLOW),
    2: (
        {"low": [0.0, 0.0], "high": [3.0, 0.5]},
        {"low": [0.0, 0.0], "high": [1.0, 0.3]},
        {"low": [1.0, 0.0], "high": [3.0, 0.8]},
        WEDGE,
    ),
    3: ({"low": [0.0, 0.0, 0.0], "high": [0.5, 0.4, 0.4]}, {"low": [0.0, 0.0, 0.0], "high": [0.2, 0.4, 0.6]}),
}


def draws_wild(value):
    """Whether a number stays as it is, whatever its least value."""
    return value != value or abs(value) > 20


def of_type(annotation, dim, metadata=()):
    """Values that a type annotation may mean: of the right type, and mostly of a sensible size."""
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return of_type(parts[0], dim, parts[1:])
    if origin is typing.Literal:
        return st.sampled_from(parts)
    if origin in (typing.Union, types.UnionType):
        return st.one_of([of_type(part, dim) for part in parts if part is not type(None)])
    if origin is list:
        bounds = {type(rule).__name__: rule for meta in metadata for rule in (meta, *getattr(meta, "metadata", ()))}
        least = bounds["MinLen"].min_length if "MinLen" in bounds else 0
        most = min(bounds["MaxLen"].max_length if "MaxLen" in bounds else 4, 6)
        if (least, most) == (1, 3):
            least = most = dim
        return st.lists(of_type(parts[0], dim), min_size=least, max_size=max(least, most))
    if annotation in (PolygonWall, Block):
        good = GOOD_WALLS if annotation is PolygonWall else GOOD_BLOCKS[dim]
        keys = of_model(annotation, dim, 0.15)
        return st.builds(lambda good, keys: keys | good, st.sampled_from((*good * 3, {})), keys)
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return of_model(annotation, dim)
    simple = {bool: st.booleans(), str: texts, int: st.sampled_from((*range(11), *range(11), -1, 10**6, 2**63, 10**30))}
    values = simple.get(annotation, numbers)
    least = next((rule.ge for meta in metadata for rule in (meta, *getattr(meta, "metadata", ())) if hasattr(rule, "ge")), None)
    return values if least is None else values.map(lambda value: value if draws_wild(value) else max(value, least))


@lru_cache
def of_model(model, dim, likely=0.3):
    """Tables that a model may take: all keys that are needed, and some others."""
    fields = model.model_fields.items()
    needed = {key: of_type(field.annotation, dim, field.metadata) for key, field in fields if field.is_required()}
    rest = {key: of_type(field.annotation, dim, field.metadata) for key, field in fields if not field.is_required()}

    chosen = (
        st.lists(st.sampled_from(sorted(rest)), max_size=max(1, round(2 * likely * len(rest))), unique=True)
        if rest
        else st.just([])
    )

    @st.composite
    def table(draw):
        keys = draw(chosen)
        return {key: draw(value) for key, value in needed.items()} | {key: draw(rest[key]) for key in keys}

    return table()


def water(*size, level=0.5, dx=0.05, **more):
    """A small scene that is good in itself."""
    dim = len(size)
    sides = ("left", "right", "bottom")[: 3 if dim > 1 else 2]
    high = [*size[:-1], level] if dim > 1 else [*size]
    keys = {
        "domain": {"size": [*size]},
        "fluid": {"blocks": [{"low": [0.0] * dim, "high": high}]},
        "walls": {side: {} for side in sides},
        "numerics": {"dx": dx, **({} if dim > 1 else {"c0": 30.0})},
        "time": {"end": 0.5},
    }
    return keys | more


WAVES = {"kind": "regular", "height": 0.05, "period": 1.5}
FOCUS = {"kind": "focused", "crest": 0.05, "period": 1.2, "place": 1.5, "time": 6.0}
SWING = {"kind": "oscillation", "angle": 2.0, "period": 1.5}
ZONES = [{"length": 1.0, "height": 0.05, "period": 1.2}, {"side": "right", "length": 1.0, "height": 0.0}]
BODY = {"wall": "right", "mass": 250.0, "stops": [-0.1, 0.5]}
TEMPLATES = (
    water(3.0, 1.0, relaxation=ZONES),
    water(3.0, 1.0, bodies=[BODY]),
    water(3.0, 1.0, wavemaker={"wave": FOCUS, "absorption": {}}),
    water(3.0, 1.0, wavemaker={"wave": SWING}),
    water(3.0, 1.0, wavemaker={"kind": "piston", "wave": {"kind": "solitary", "height": 0.1}}),
    water(3.0, 1.0),
    water(3.0, 1.0, wavemaker={"kind": "piston", "wave": WAVES}),
    water(3.0, 1.0, walls={"polygons": [BED, BOX], "treatment": "ghosts"}),
    water(
        3.0,
        1.0,
        walls={"polygons": [BED, PLATE]},
        wavemaker={
            "wall": "plate",
            "kind": "flap",
            "hinge": -0.5,
            "wave": {"kind": "irregular", "height": 0.05, "period": 1.2},
        },
    ),
    water(3.0, 1.0, walls={"left": {}, "right": {}, "bottom": {}, "treatment": "deficiency"}),
    water(1.0),
    water(0.5, 0.4, 0.6, level=0.4),
    {**water(40.0), "fluid": {"blocks": [SHALLOW]}, "numerics": {"dx": 0.5, "state": "shallow"}},
)


@st.composite
def made_up(draw):
    """A good small scene with sections, or keys of sections, from the schema."""
    keys = copy.deepcopy(draw(st.sampled_from(TEMPLATES)))
    dim = len(keys["domain"]["size"])
    for section in draw(st.lists(st.sampled_from([*Scene.model_fields, "one key", "one key", "list"]), min_size=1, max_size=3)):
        if section == "one key" or (section == "list" and draw(st.booleans())):
            section = draw(st.sampled_from(("numerics", "walls", "fluid", "time", "domain", "output")))
            model = models_in(Scene.model_fields[section].annotation)[0]
            key, field = draw(st.sampled_from(list(model.model_fields.items())))
            keys.setdefault(section, {})[key] = draw(of_type(field.annotation, dim, field.metadata))
            continue
        if section == "list":
            section = draw(st.sampled_from(("gauges", "damping", "relaxation", "bodies")))
        value = draw(of_type(Scene.model_fields[section].annotation, dim, Scene.model_fields[section].metadata))
        if isinstance(value, dict) and section != "wavemaker":
            keys[section] = {**keys.get(section, {}), **value}
        else:
            keys[section] = value
    return keys


# --- text ------------------------------------------------------------------------------------------------------------

TOKENS = (
    *("[", "]", "{", "}", "=", ".", ",", "#", '"', "\n", '"""', "[[", "\x00", "\\u0000", "1e999", "-", "_", "0x", "nan", "inf"),
    *("9" * 5000, "[" * 3000, "a." * 3000, "\n[domain]\n", "\ntitle = 1979-05-27\n", "\r", "\ufeff", "true", "1_0", "\t"),
    *('\nbase = "pool"\n', "\nbase = 1\n", '\nbase = "/dev/zero"\n', '\nbase = "odd.toml"\n', '\nbase = "."\n'),
)


@st.composite
def damaged_text(draw):
    """The bytes of a scene's file, cut, with other bytes in it, or with parts twice."""
    data = TEXT_OF[draw(st.sampled_from(sorted(TEXT_OF)))].encode()
    for _ in range(draw(st.integers(1, 3))):
        first, last = sorted(draw(st.tuples(*[st.integers(0, len(data))] * 2)))
        act = draw(st.sampled_from(("cut", "end", "bytes", "token", "token", "twice", "lines", "digit", "digit", "digit")))
        if act == "cut":
            data = data[:first] + data[min(last, first + 40) :]
        elif act == "end":
            data = data[:last]
        elif act == "bytes":
            data = data[:first] + draw(st.binary(max_size=6)) + data[first:]
        elif act == "token":
            data = data[:first] + draw(st.sampled_from(TOKENS)).encode() + data[first:]
        elif act == "twice":
            data = data[:last] + data[first:]
        elif act == "digit":
            digits = [place for place, byte in enumerate(data) if chr(byte).isdigit()]
            place = draw(st.sampled_from(digits)) if digits else 0
            data = data[:place] + draw(st.sampled_from(DIGITS)).encode() + data[place + 1 :]
        else:
            lines = data.split(b"\n")
            line = draw(st.integers(0, len(lines) - 1))
            lines.insert(draw(st.integers(0, len(lines))), lines.pop(line) if draw(st.booleans()) else lines[line])
            data = b"\n".join(lines)
    return data


DIGITS = ("0", "1", "2", "5", "9", "-1", "1.5", "00", "10", "e", "", "1e3", "1e-9")

# --- settings --------------------------------------------------------------------------------------------------------

PATHS_OF = [place for keys in BASES.values() for place in places(keys)]
keys_to_set = st.one_of(
    st.sampled_from([".".join(map(str, place)) for place in PATHS_OF]),
    st.sampled_from(["numerics.dx", "time.end", "fluid.blocks.0.high.0", "walls.treatment", "gauges.0.x", "numerics.c0"]),
    st.sampled_from(
        ["", " ", ".", "a", "a.b.c.d", "gauges.99.x", "gauges.-1.x", "gauges.٣.x", "gauges.x", "gauges.", "a" * 9999]
    ),
    st.sampled_from(["x." * 9999 + "x", "fluid.blocks.0", "fluid.blocks.0.low.7", "fluid.blocks." + "9" * 5000, "\n", "a\x00"]),
    st.text(max_size=12),
)
values_to_set = st.one_of(
    st.sampled_from([*map(str, SENSIBLE), *TEXTS, *EVIL, *PATHS, *TOKENS]),
    st.sampled_from(
        ["", "[]", "{}", "[0]", "{ x = 1 }", "1\nb = 2", '"x"', "true", "2020-01-01", "1e-9", "1e9", "[[0, 0], [1, 1]]"]
    ),
)
settings_to_set = st.one_of(
    st.builds("{}={}".format, keys_to_set, values_to_set), st.text(max_size=20), st.sampled_from(["", "a", "=1", "=", "=="])
)


@st.composite
def scene_and_settings(draw):
    """The name of a quick scene, and settings for it: its own numbers changed, and odd ones."""
    name = draw(st.sampled_from(("seiche", "swe-pulse", "still", "pool", "couette", "column")))
    leaves = [(place, at(BASES[name], place)) for place in places(BASES[name])]
    leaves = [(place, value) for place, value in leaves if isinstance(value, float)]
    settings = []
    for odd in draw(st.lists(st.sampled_from((False, False, False, True)), min_size=1, max_size=3)):
        place, value = draw(st.sampled_from(leaves))
        changed = f"{'.'.join(map(str, place))}={value * draw(st.sampled_from(FACTORS))}"
        settings.append(draw(settings_to_set) if odd else changed)
    return name, settings
