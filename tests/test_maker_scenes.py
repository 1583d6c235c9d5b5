"""Scenes with wavemakers and bodies: every fault says where, what, why and the cure; check, plan and show know all waves."""

import json
import math

import pytest
from helpers import tank

from parsph.errors import SceneError
from parsph.scene.build import build, movers_of
from parsph.scene.check_waves import doubts_of
from parsph.scene.load import load_scene, scene_text
from parsph.scene.movers import maker_of
from parsph.scene.solids import motions_of
from parsph.waves import breaking_height, dispersion, highest_wave, tuned_absorption

DEPTH = 0.5
OSCILLATION = {"kind": "oscillation", "stroke": 0.05, "period": 1.0}
REGULAR = {"kind": "regular", "height": 0.05, "period": 1.2}
IRREGULAR = {"kind": "irregular", "height": 0.04, "period": 1.2}
TABLE = {"kind": "irregular", "spectrum": "table", "frequencies": [0.5, 0.8, 1.2], "densities": [0.0, 0.001, 0.0]}
FOCUSED = {"kind": "focused", "crest": 0.05, "period": 1.2, "place": 3.0, "time": 7.0}
SOLITARY = {"kind": "solitary", "height": 0.1}
PADDLE = {"name": "paddle", "points": [[0.2, 0.9], [0.2, 0.0]]}
BOX = {"name": "box", "points": [[4.0, 0.0], [4.4, 0.0], [4.4, 0.7], [4.0, 0.7]], "fluid": "outside"}
RAISED = {**BOX, "points": [[x, z + 0.1] for x, z in BOX["points"]]}
BODY = {"wall": "right", "mass": 50.0, "stops": [-0.1, 0.2]}


def flume(wave=None, kind="piston", **sections):
    """Return the keys of a tank 6 m long with 0.5 m of water; with a wavemaker where a wave is given."""
    block = {"low": [0.0, 0.0], "high": [6.0, DEPTH]}
    keys = tank(
        domain={"size": [6.0, 1.0]},
        fluid={"blocks": [block]},
        numerics={"dx": 0.02, "viscosity": "monaghan", "diffusion": "fourtakas"},
        time={"end": 6.0},
    )
    maker = {"wavemaker": {"kind": kind, "wave": wave}} if wave else {}
    return {**keys, **maker, **sections}


def maker(wave, kind="piston", **keys):
    return {"wavemaker": {"kind": kind, "wave": wave, **keys}}


def polygons(*walls, **sides):
    """Return the walls of the flume with a piece of line in place of the left one."""
    return {"walls": {"right": {}, "bottom": {}, "polygons": list(walls), **sides}}


def at_paddle(**keys):
    """Sections of the flume whose water begins at a polygon wall, the paddle, at x = 0.2 m."""
    return {"fluid": {"blocks": [{"low": [0.2, 0.0], "high": [6.0, DEPTH]}]}, **polygons(PADDLE), **keys}


def highest(period):
    return breaking_height(DEPTH, dispersion(DEPTH, 9.81, period=period).wavelength)


WAVES = {
    "oscillation": OSCILLATION,
    "regular": REGULAR,
    "regular of a frequency": {"kind": "regular", "height": 0.05, "frequency": 0.8},
    "regular of a wavelength": {"kind": "regular", "height": 0.05, "wavelength": 2.0, "order": 1},
    "irregular": IRREGULAR,
    "irregular, pierson-moskowitz": {**IRREGULAR, "spectrum": "pierson-moskowitz"},
    "irregular, table": TABLE,
    "focused": FOCUSED,
    "solitary": SOLITARY,
}
# name: (sections put over the flume, where, what, why, cure)
FAULTS = {
    # --- waves
    "regular beyond breaking": (
        maker({**REGULAR, "height": 0.4}),
        "wavemaker.wave.height",
        "0.4 m is beyond breaking",
        "waves of 1.2 s (2.05 m) on 0.5 m of water break (Miche 1944)",
        f"at most {highest(1.2):.3g} m",
    ),
    "regular of no period": (
        maker({"kind": "regular", "height": 0.05}),
        "wavemaker.wave",
        "exactly one of period, frequency and wavelength, but got none",
        "depth and gravity fix",
        "one of them",
    ),
    "regular of two": (
        maker({**REGULAR, "wavelength": 2.0}),
        "wavemaker.wave",
        "got period and wavelength",
        "depth and gravity fix",
        "one of them",
    ),
    "oscillation of nothing": (
        maker({"kind": "oscillation", "period": 1.0}),
        "wavemaker.wave",
        "one of angle and stroke",
        "",
        "angle [degrees], or stroke [m]",
    ),
    "oscillation of both": (
        maker({**OSCILLATION, "angle": 3.0}, "flap"),
        "wavemaker.wave",
        "one of angle and stroke",
        "",
        "angle [degrees], or stroke [m]",
    ),
    "angle of a piston": (
        maker({"kind": "oscillation", "angle": 3.0, "period": 1.0}),
        "wavemaker.wave.angle",
        "a piston has no angle",
        "",
        "stroke [m]",
    ),
    "angle in the file of a piston": (
        maker({"kind": "series", "file": "x", "unit": "deg"}),
        "wavemaker.wave.unit",
        "a piston has no angle",
        "",
        "unit of length",
    ),
    "irregular beyond breaking": (
        maker({**IRREGULAR, "height": 0.2}),
        "wavemaker.wave.height",
        "Hs = 0.2 m is beyond breaking",
        f"1.86 Hs, and waves of Tp break at {highest(1.2):.3g} m",
        f"at most {highest(1.2) / 1.86:.3g} m",
    ),
    "irregular of no height": (
        maker({"kind": "irregular", "period": 1.2}),
        "wavemaker.wave.height",
        "is missing",
        "",
        "significant wave height [m]",
    ),
    "irregular of no period": (
        maker({"kind": "irregular", "height": 0.05}),
        "wavemaker.wave.period",
        "is missing",
        "",
        "peak period Tp [s]",
    ),
    "period of a table": (maker({**TABLE, "period": 1.0}), "wavemaker.wave.period", "has no meaning here", "", "leave it out"),
    "table without densities": (
        maker({**TABLE, "densities": None}),
        "wavemaker.wave.densities",
        "is missing",
        "",
        "a list",
    ),
    "frequencies of no table": (
        maker({**IRREGULAR, "frequencies": [0.5, 1.0]}),
        "wavemaker.wave.frequencies",
        "is for spectrum table",
        "",
        'spectrum = "table"',
    ),
    "table of two lengths": (
        maker({**TABLE, "densities": [0.1, 0.2]}),
        "wavemaker.wave.frequencies, densities",
        "is no spectrum",
        "",
        "as many densities as increasing frequencies",
    ),
    "table that goes back": (
        maker({**TABLE, "frequencies": [0.5, 1.2, 0.8]}),
        "wavemaker.wave.frequencies, densities",
        "is no spectrum",
        "",
        "increasing",
    ),
    "table of zeros": (
        maker({**TABLE, "densities": [0.0, 0.0, 0.0]}),
        "wavemaker.wave.frequencies, densities",
        "is no spectrum",
        "",
        "not all of them 0",
    ),
    "table beyond breaking": (
        maker({**TABLE, "densities": [0.0, 0.05, 0.0]}),
        "wavemaker.wave.densities",
        "beyond breaking",
        "1.86 Hs",
        "at most",
    ),
    "focused beyond breaking": (
        maker({**FOCUSED, "crest": 0.2}),
        "wavemaker.wave.crest",
        "0.2 m is beyond breaking",
        "crests have 0.6",
        f"at most {0.6 * highest(1.2):.3g} m",
    ),
    "focused too early": (
        maker({**FOCUSED, "time": 2.0}),
        "wavemaker.wave.time",
        "2 s is too early",
        "its energy needs",
        f"at least {3.0 / dispersion(DEPTH, 9.81, period=1.2).group_speed:.3g} s",
    ),
    "solitary with a flap": (maker(SOLITARY, "flap"), "wavemaker.kind", "needs a piston", "more than at the bed", "piston"),
    "solitary beyond breaking": (
        maker({**SOLITARY, "height": 0.45}),
        "wavemaker.wave.height",
        "0.45 m is beyond breaking",
        "solitary waves on 0.5 m of water break at 0.8332 depths",
        "at most 0.417 m",
    ),
    "solitary beyond its table": (
        maker({**SOLITARY, "height": 0.41}),
        "wavemaker.wave.height",
        "of the depth",
        "tabulated",
        "at most",
    ),
    # --- plate
    "stroke too long": (
        maker({**OSCILLATION, "stroke": 3.2}),
        "wavemaker.wave.stroke",
        "stroke too long",
        "the plate swings 1.6 m at the domain's top, in 6 m of water",
        "at most 1.5 m, a quarter",
    ),
    "stroke too long before a layer": (
        {**maker({**OSCILLATION, "stroke": 0.5}), "damping": [{"side": "left", "length": 0.8}]},
        "wavemaker.wave.stroke",
        "stroke too long",
        "in 0.8 m of water",
        "at most 0.2 m",
    ),
    "flap beyond 45 degrees": (
        maker({**OSCILLATION, "stroke": 0.5}, "flap", hinge=0.3),
        "wavemaker.wave.stroke",
        "beyond the flap's reach",
        "would lean by 51.3 degrees",
        "at most 45 degrees",
    ),
    "hinge above the water": (
        maker(REGULAR, "flap", hinge=0.6),
        "wavemaker.hinge",
        "not under water",
        "",
        "below 0.5 m; 0 m is the bed",
    ),
    "hinge at the level": (maker(REGULAR, "flap", hinge=0.5), "wavemaker.hinge", "not under water", "", "below 0.5 m"),
    "hinge of a piston": (maker(REGULAR, hinge=0.1), "wavemaker.hinge", "a piston has no hinge", "", "or leave it out"),
    "plate without its wall": (
        {**maker(REGULAR), "walls": {"right": {}, "bottom": {}}},
        "walls.left",
        "is missing",
        "slip is taken from it",
        "left = {}",
    ),
    "wall that is not there": (
        {**maker(REGULAR, wall="padle"), **at_paddle()},
        "wavemaker.wall",
        "no wall 'padle' that can move",
        "",
        "did you mean 'paddle'? one of: left, paddle",
    ),
    "right wall": (maker(REGULAR, wall="right"), "wavemaker.wall", "no wall 'right' that can move", "", "one of: left"),
    "polygon wall with a motion of its own": (
        {**maker(REGULAR, wall="paddle"), **at_paddle(**polygons({**PADDLE, "motion": {"way": [0.01, 0.0], "period": 1.0}}))},
        "wavemaker.wall",
        "'paddle' cannot be moved",
        "a motion of its own",
        "leave out the motion or bulge of 'paddle'",
    ),
    "hinge inside a polygon wall": (
        {**maker(REGULAR, "flap", wall="paddle", hinge=0.2), **at_paddle()},
        "wavemaker.hinge",
        "0.2 m is inside the wall",
        "turns as a whole, and this one begins at 0 m",
        "at most 0 m",
    ),
    "no gravity": (
        {**maker(REGULAR), "domain": {"size": [6.0, 1.0], "gravity": 0.0}},
        "wavemaker",
        "has no water to move",
        "depth under gravity",
        "domain.gravity > 0",
    ),
    # --- absorption
    "absorption of an angle": (
        maker({"kind": "oscillation", "angle": 3.0, "period": 1.0}, "flap", absorption={}),
        "wavemaker.wave.angle",
        "does not go with absorption",
        "still-water level",
        "stroke [m]",
    ),
    "absorption of unknown waves": (
        maker({**OSCILLATION, "cycles": 2}, absorption={}),
        "wavemaker.absorption",
        "needs waves that are known",
        "the level that the plate's own waves should have is not known",
        "regular, irregular",
    ),
    "absorption behind the tank": (
        maker(REGULAR, absorption={"distance": 7.0}),
        "wavemaker.absorption.distance",
        "its gauge stands at 7 m",
        "behind the tank",
        "at most 6 m",
    ),
    "absorption within the support of the plate": (
        maker(REGULAR, absorption={"distance": 0.05}),
        "wavemaker.absorption.distance",
        "0.05 m is too near",
        "no water for its sums",
        "at least 0.08 m",
    ),
    # --- bodies
    "body that is not there": (
        {"bodies": [{**BODY, "wall": "rigth"}]},
        "bodies.0.wall",
        "no wall 'rigth' that can move",
        "",
        "did you mean 'right'? one of: left, right",
    ),
    "body of a bed": ({"bodies": [{**BODY, "wall": "bottom"}]}, "bodies.0.wall", "no wall 'bottom'", "", "one of: left, right"),
    "two bodies on one wall": (
        {"bodies": [BODY, BODY]},
        "bodies.1.wall",
        "'right' is moved already",
        "",
        "another wall",
    ),
    "body on the wavemaker's wall": (
        {**maker(REGULAR), "bodies": [{**BODY, "wall": "left"}]},
        "bodies.0.wall",
        "'left' is moved already",
        "",
        "another wall",
    ),
    "body with a motion of its own": (
        {
            "bodies": [{**BODY, "wall": "box"}],
            "walls": {"left": {}, "right": {}, "bottom": {}, "polygons": [{**BOX, "motion": {"period": 1.0}}]},
        },
        "bodies.0.wall",
        "'box' cannot be moved",
        "a motion of its own",
        "leave out the motion",
    ),
    "body too light": (
        {"bodies": [{**BODY, "mass": 4.0}]},
        "bodies.0.mass",
        "4 kg/m is too light",
        "unstable",
        "at least 10 kg/m, rho0 dx depth",
    ),
    "body of no direction": (
        {"bodies": [{**BODY, "direction": [0.0, 0.0]}]},
        "bodies.0.direction",
        "has no length",
        "",
        "as [1.0, 0.0]",
    ),
    "side that rises": (
        {"bodies": [{**BODY, "direction": [1.0, 0.5]}]},
        "bodies.0.direction",
        "is not along x",
        "upright",
        "[1.0, 0.0]",
    ),
    "stops beside the beginning": ({"bodies": [{**BODY, "stops": [0.1, 0.2]}]}, "bodies.0.stops", "must hold 0", "", "at 0"),
    "stops of no way": ({"bodies": [{**BODY, "stops": [0.0, 0.0]}]}, "bodies.0.stops", "must hold 0", "", "begins at 0"),
    "stops the wrong way round": ({"bodies": [{**BODY, "stops": [0.2, -0.1]}]}, "bodies.0.stops", "must hold 0", "", "least"),
    "threshold below 1": (
        {"bodies": [{**BODY, "threshold": 0.5}]},
        "bodies.0.threshold",
        "greater than or equal to 1",
        "",
        "still water",
    ),
    "gauge of no body": (
        {"bodies": [BODY], "gauges": [{"kind": "body", "wall": "left"}]},
        "gauges.0.wall",
        "no body 'left'",
        "",
        "one of: right",
    ),
    "wall that slides and is moved": (
        {"bodies": [BODY], "walls": {"left": {}, "right": {"slip": "no", "velocity": [0.0, 1.0]}, "bottom": {}}},
        "walls.right.velocity",
        "moved already",
        "",
        "leave it out",
    ),
    "body that leaves the domain": (
        {
            "bodies": [{"wall": "box", "mass": 50.0, "stops": [-0.1, 2.0]}],
            "walls": {"left": {}, "right": {}, "bottom": {}, "polygons": [BOX]},
        },
        "walls.polygons.0.points.1",
        "leaves the domain",
        "it swings to (6.4, 0) m",
        "domain.size",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_says_where_what_why_and_the_cure(name):
    sections, where, what, why, cure = FAULTS[name]
    with pytest.raises(SceneError) as caught:
        load_scene(flume(**sections))
    faults = [fault for fault in caught.value.faults if fault.where == where]
    assert faults, f"nothing about {where}: {caught.value}"
    assert any(what in f.what and why in f.why and cure in f.cure for f in faults), [(f.what, f.why, f.cure) for f in faults]
    assert all(fault.cure for fault in caught.value.faults)
    assert caught.value.exit_code == 2


def test_bodies_are_for_two_dimensions():
    keys = tank(
        domain={"size": [0.2, 0.2, 0.3]},
        fluid={"blocks": [{"low": [0.0, 0.0, 0.0], "high": [0.2, 0.2, 0.2]}]},
        bodies=[BODY],
    )
    with pytest.raises(SceneError, match=r"bodies\.0: bodies are for 2D"):
        load_scene(keys)


RECORD = "\n".join(f"{0.02 * k:.2f} {10 * math.sin(0.1 * k):.4f}" for k in range(200))
GOOD = {
    **{f"{name}, piston": maker(wave) for name, wave in WAVES.items()},
    **{f"{name}, flap": maker(wave, "flap") for name, wave in WAVES.items() if wave["kind"] != "solitary"},
    "flap by its angle": maker({"kind": "oscillation", "angle": 5.0, "period": 1.0, "cycles": 2}, "flap"),
    "flap above a sill": maker(REGULAR, "flap", hinge=0.1),
    "flap below the bed": maker(REGULAR, "flap", hinge=-0.3),
    "absorbing": maker(IRREGULAR, absorption={"distance": 0.1, "reach": 0.2}),
    "ghosts": {**maker(REGULAR), "walls": {"left": {}, "right": {}, "bottom": {}, "treatment": "ghosts"}},
    "ghosts, flap above a sill": {
        **maker(REGULAR, "flap", hinge=0.1),
        "walls": {"left": {}, "right": {}, "bottom": {}, "treatment": "ghosts"},
    },
    "polygon wall": {**maker(REGULAR, wall="paddle"), **at_paddle()},
    "right wall of a body": {"bodies": [{**BODY, "threshold": 1.5, "friction": 3.0, "stiffness": 10.0, "damping": 2.0}]},
    "box of a body": {
        "bodies": [{"wall": "box", "mass": 50.0, "stops": [-0.1, 0.3]}],
        "walls": {"left": {}, "right": {}, "bottom": {}, "polygons": [RAISED]},
    },
}  # fmt: skip


@pytest.mark.parametrize("name", GOOD)
def test_a_good_scene_has_no_fault_and_its_text_is_the_scene(name):
    scene = load_scene(flume(**GOOD[name]))
    assert load_scene(json.loads(scene_text(scene))) == scene
    if scene.wavemaker:
        motion = maker_of(scene).motion
        assert motions_of(scene)[scene.wavemaker.wall].reach(DEPTH) == motion.reach(DEPTH)


def test_a_wave_at_its_limit_is_no_fault():
    """The largest height that the message names, but for its three digits; second order ends at the highest steady wave."""
    steady = highest_wave(dispersion(DEPTH, 9.81, period=1.2).wavelength, DEPTH)
    with pytest.raises(SceneError, match=r"steady waves .* have at most"):
        load_scene(flume({**REGULAR, "height": 1.01 * steady}))
    for keys in (
        {**REGULAR, "height": 0.98 * steady},
        {**REGULAR, "height": 0.999 * highest(1.2), "order": 1},
        {**IRREGULAR, "height": 0.999 * highest(1.2) / 1.86},
        {**FOCUSED, "crest": 0.999 * 0.6 * highest(1.2)},
    ):
        assert load_scene(flume(keys)).wavemaker


@pytest.mark.parametrize("name", ["absorbing", "right wall of a body"])
def test_what_is_left_out_follows_from_depth_and_gravity(name):
    scene = load_scene(flume(**GOOD[name]))
    maker = maker_of(scene)
    (mover,) = movers_of(scene, maker, motions_of(scene, maker))
    unit = math.sqrt(DEPTH / 9.81)
    if name == "absorbing":
        gain, lag = tuned_absorption(scene.wave_period, DEPTH, 9.81, distance=0.1)
        assert (mover.gain, mover.lag, mover.centering) == pytest.approx((gain, lag, 60 * unit))
        assert (mover.distance, mover.largest) == pytest.approx((0.1, 4.905))
        assert mover.signal.extent == (-0.2, 0.2)
    else:
        push = 0.5 * 1000 * 9.81 * DEPTH**2
        assert mover.preload == pytest.approx(push, rel=1e-9)
        assert mover.resistance == pytest.approx(0.5 * push, rel=1e-9)


def test_an_absorbing_flap_is_tuned_to_the_waves_and_its_hinge():
    for hinge in (0.0, 0.1, -0.5):
        scene = load_scene(flume(**maker(REGULAR, "flap", hinge=hinge, absorption={})))
        made = maker_of(scene)
        (mover,) = movers_of(scene, made, motions_of(scene, made))
        gain, lag = tuned_absorption(1.2, DEPTH, 9.81, hinge / DEPTH, mover.distance)
        assert (mover.gain, mover.lag) == pytest.approx((gain, lag))


def test_an_absorbing_plate_without_a_period_is_tuned_to_long_waves():
    scene = load_scene(flume(**maker(SOLITARY, absorption={})))
    made = maker_of(scene)
    (mover,) = movers_of(scene, made, motions_of(scene, made))
    assert mover.gain == pytest.approx(math.sqrt(9.81 / DEPTH), rel=0.03)


def test_the_domain_has_room_for_the_plate_and_for_bodies():
    """Grid and box go as far as they do."""
    sections = {**maker({**OSCILLATION, "stroke": 0.3}), "bodies": [BODY]}
    domain = build(load_scene(flume(**sections))).domain
    assert domain.box[0][0] == pytest.approx(-0.15 - 0.02)
    assert domain.box[1][0] == pytest.approx(6.2 + 0.02)
    assert domain.grid.low[0] <= -0.15


# --- what a user types -------------------------------------------------------------------------------------------------

PLANS = {
    "oscillation": (maker(OSCILLATION), "piston, oscillation, from -0.025 to 0.025 m", ""),
    "regular": (maker(REGULAR), "piston, regular, from", "Biesel (1951); second order: Schaeffer (1996)"),
    "first order": (maker({**REGULAR, "order": 1}), "piston, regular, from", "Biesel (1951)"),
    "irregular": (maker(IRREGULAR, "flap", hinge=0.1), "flap hinged 0.1 m above the bed, irregular", "random phases"),
    "focused": (maker(FOCUSED, "flap", hinge=-0.2), "flap hinged -0.2 m above the bed, focused", "Tromans et al. (1991)"),
    "solitary": (maker(SOLITARY), "piston, solitary, from 0 to", "Goring (1978)"),
    "series": (maker({"kind": "series", "file": "record.txt", "unit": "mm"}), "piston, series, from", ""),
    "absorbing": (maker(REGULAR, absorption={}), "absorbs what comes back", "Biesel"),
}


@pytest.mark.parametrize("name", PLANS)
def test_check_plan_and_show_know_every_wave(command, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "400")  # no row of the plan is broken
    (tmp_path / "record.txt").write_text(RECORD)
    sections, text, source = PLANS[name]
    (tmp_path / "scene.json").write_text(json.dumps(flume(**sections)))
    assert command("check", "scene.json")[::2] == (0, "")
    code, out, _ = command("plan", "scene.json")
    assert code == 0
    (row,) = [line for line in out.splitlines() if "wavemaker" in line]
    assert text in row
    assert source in row
    assert "m at the still-water level" in row
    code, out, _ = command("show", "scene.json")
    assert code == 0
    assert load_scene(json.loads(out)) == load_scene("scene.json")


def test_plan_tells_of_bodies(command, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    (tmp_path / "scene.json").write_text(json.dumps(flume(**GOOD["right wall of a body"])))
    code, out, _ = command("plan", tmp_path / "scene.json")
    assert code == 0
    words = " ".join(out.split())
    for text in ("body right", "50 kg/m", "spring 10 N/m^2", "damper 2 N s/m^2", "friction 3 N/m", "1.5 times the force"):
        assert text in words


def test_check_prints_the_limit_of_a_wave(command, tmp_path):
    (tmp_path / "scene.json").write_text(json.dumps(flume(**FAULTS["regular beyond breaking"][0])))
    code, _, err = command("check", tmp_path / "scene.json")
    assert code == 2
    assert "error: wavemaker.wave.height: 0.4 m is beyond breaking" in err
    assert f"at most {highest(1.2):.3g} m" in err


def test_the_schema_takes_every_wave_with_and_without_its_base():
    jsonschema = pytest.importorskip("jsonschema")
    from parsph.scene.load import json_schema

    validator = jsonschema.Draft202012Validator(json.loads(json_schema()))
    for sections in GOOD.values():
        assert not list(validator.iter_errors(flume(**sections)))
    assert not list(validator.iter_errors({"base": "pool", "wavemaker": {"wave": {"cycles": 3}}}))
    assert list(validator.iter_errors({"base": "pool", "wavemaker": {"wave": {"cycels": 3}}}))


def doubts(**sections):
    return doubts_of(load_scene(flume(**sections)))


def test_doubtful_waves_and_bodies_are_told_with_what_would_be_right(command, tmp_path):
    """Too low for the particles, too long for second order, free to creep; waves and bodies that are well have no doubts."""
    assert not doubts(**maker(REGULAR))
    low = doubts(**maker({**REGULAR, "height": 0.01}))
    assert len(low) == 1
    assert "numerics.dx of at most 0.0067 m" in low[0]
    wave = {"kind": "regular", "height": 0.06, "wavelength": 8.0}
    (long,) = doubts(**maker(wave))
    depth = load_scene(flume(**maker(wave))).depth
    assert f"at most {8 * math.pi**2 / 3 * depth**3 / 8.0**2:.3g} m" in long
    body = {"wall": "right", "mass": 500.0, "stops": [-0.1, 0.1]}
    (free,) = doubts(bodies=[body])
    assert free.startswith("bodies.0: nothing holds it")
    assert not doubts(bodies=[{**body, "threshold": 1.1}])
    (tmp_path / "scene.json").write_text(json.dumps(flume(bodies=[body])))
    code, out, _ = command("check", tmp_path / "scene.json")
    assert code == 0
    assert f"note: {free}" in " ".join(out.split())
