"""Wavemakers: where the plate is, what motion a wave asks for, what level is expected, and records of motions."""

import math

import numpy as np
import pytest
from helpers import tank

from parsph.errors import SceneError
from parsph.scene.load import load_scene
from parsph.scene.movers import maker_of, place_of
from parsph.wavemakers import Flap, Harmonics, Oscillation, Placement, Slide
from parsph.wavemakers.generation import expected, linear, regular, solitary
from parsph.wavemakers.series import measured_motion
from parsph.waves import Solitary, dispersion, near_field, regular_wave, second_order_full, transfer, wavenumber

DEPTH, G = 0.6, 9.81
TIMES = [0.05, 0.31, 0.7, 0.95, 1.6, 4.2]
WAVY = Oscillation(0.2, 1.3, ramp=0.9)
MOTIONS = {
    "piston": Slide(WAVY),
    "slide along a slope": Slide(WAVY, (0.8, 0.6)),
    "flap by its angle": Flap((0.1, 0.2), WAVY),
    "flap by its way": Flap((0.1, 0.2), WAVY, 0.4),
    "flap hinged below the bed": Flap((0.1, -0.5), WAVY, 1.1),
}


# --- where the plate is ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("time", TIMES)
def test_velocities_and_accelerations_are_the_derivatives_of_places(name, time):
    motion, step = MOTIONS[name], 1e-4
    points = np.random.default_rng(5).uniform(-1, 1, (20, 2))
    before, now, after = (motion.at(t).place(points) for t in (time - step, time, time + step))
    np.testing.assert_allclose(motion.at(time).velocity(now), (after - before) / (2 * step), atol=1e-5)
    np.testing.assert_allclose(motion.at(time).acceleration(now), (after - 2 * now + before) / step**2, atol=1e-4)
    assert np.abs(after - before).max() > 1e-6


def test_a_piston_moves_along_x_alone():
    points = np.random.default_rng(5).uniform(-1, 1, (20, 2))
    way = np.tile([WAVY.at(1.2)[0], 0.0], (20, 1))
    np.testing.assert_allclose(Slide(WAVY).at(1.2).place(points) - points, way, rtol=0, atol=1e-15)


@pytest.mark.parametrize("time", TIMES)
def test_a_flap_with_an_arm_is_where_the_signal_says_at_that_height(time):
    """The plate's line, not the point of it at rest: x - x_hinge = way (z - z_hinge) / arm."""
    flap = MOTIONS["flap by its way"]
    now, (way, rate, _) = flap.at(time), WAVY.at(time)
    plate = now.place(np.array([[0.1, 0.2], [0.1, 0.5], [0.1, 0.9]]))
    np.testing.assert_allclose(plate[0], [0.1, 0.2], atol=1e-15)
    np.testing.assert_allclose(plate[1:, 0] - 0.1, way * (plate[1:, 1] - 0.2) / 0.4, atol=1e-14)
    assert rate == pytest.approx(-now.rate * (1 + (way / 0.4) ** 2) * 0.4)


def test_a_flap_without_an_arm_leans_by_its_signal_towards_positive_x():
    now = Flap((0.0, 0.0), WAVY).at(1.2)
    angle = WAVY.at(1.2)[0]
    assert angle == pytest.approx(-now.angle)
    np.testing.assert_allclose(now.place(np.array([[0.0, 2.0]])), [[2 * math.sin(angle), 2 * math.cos(angle)]])
    assert Flap((0.0, 0.0), WAVY).at(1.3 * 1.25).place(np.array([[0.0, 1.0]]))[0, 0] > 0.1


@pytest.mark.parametrize("name", [name for name in MOTIONS if "slope" not in name])
def test_the_plate_stays_within_its_reach_and_comes_near_to_it(name):
    """At any height, the plate's line; below the hinge there is no plate."""
    motion = MOTIONS[name]
    foot = motion.hinge if isinstance(motion, Flap) else (0.1, 0.0)
    for height in (0.3, 0.6, 1.2):
        least, largest = motion.reach(height)
        ways = []
        for time in np.arange(0.0, 5.0, 0.01):
            low, high = motion.at(time).place(np.array([foot, [foot[0], 3.0]]))
            ways.append(low[0] + (high[0] - low[0]) * (height - low[1]) / (high[1] - low[1]) - foot[0])
        assert least <= min(ways) < 0.99 * least < 0 < 0.99 * largest < max(ways) <= largest
    if isinstance(motion, Flap):
        assert motion.reach(foot[1] - 0.1) == (0, 0)
    extremes = [extreme.place(np.array([[foot[0], 0.9]]))[0, 0] for extreme in motion.extremes()]
    seen = [motion.at(time).place(np.array([[foot[0], 0.9]]))[0, 0] for time in np.arange(0.0, 5.0, 0.01)]
    assert sorted(extremes) == pytest.approx([min(seen), max(seen)], abs=1e-3)
    assert all(isinstance(extreme, Placement) for extreme in motion.extremes())


# --- from the wave to the motion ---------------------------------------------------------------------------------------

HINGES = [None, 0.0, 0.3, -0.5]


@pytest.mark.parametrize("hinge", HINGES)
@pytest.mark.parametrize("period", [0.9, 2.5])
def test_regular_waves_have_the_stroke_of_the_transfer_function_and_the_second_harmonic_of_second_order(hinge, period):
    """Harmonics of the motion over a period, by projection."""
    wave = dispersion(DEPTH, G, period=period)
    motion, _ = regular(0.05, wave, DEPTH, G, hinge, 2, 0.0, 9.0)
    first, elevation = regular(0.05, wave, DEPTH, G, hinge, 1, 0.0, 9.0)
    amplitude = regular_wave(0.05, DEPTH, G, wavelength=wave.wavelength).elevations[0]
    assert 0.95 * 0.025 < amplitude < 0.025
    t = period * (1 + np.arange(64) / 64)
    waves = np.exp(-1j * wave.frequency * np.outer([1, 2, 3], t))
    harmonics = [2j / 64 * waves @ [m.at(s)[0] for s in t] for m in (motion, first)]
    for found, height in zip(harmonics, (2 * amplitude, 0.05), strict=True):
        assert found[0] == pytest.approx(0.5 * height / transfer(wave.kd, hinge), rel=1e-9)
        assert abs(found[2]) < 1e-12
    assert harmonics[0][1] == pytest.approx(second_order_full(2 * amplitude, wave.kd, DEPTH, hinge), rel=1e-9)
    assert abs(harmonics[1][1]) < 1e-12
    assert elevation.at(3.3, 20 * DEPTH) == pytest.approx(0.025 * math.cos(wave.wavenumber * 12.0 - wave.frequency * 3.3))


@pytest.mark.parametrize("hinge", HINGES)
def test_linear_motions_make_the_level_that_is_asked_for(hinge):
    """``sum a cos(w t + p)`` at the plate once the ramp is over, beside the near field; and the same far off, later."""
    a, w, p = np.array([0.01, 0.02, 0.005]), np.array([2.0, 4.1, 7.0]), np.array([0.3, -1.1, 2.0])
    motion, elevation = linear(a, w, p, DEPTH, G, hinge, 1.5, 30.0)
    k = np.array([wavenumber(each, DEPTH, G) for each in w])
    for time in (1.6, 5.2):
        way = motion.amplitudes * np.sin(w * time + p)
        near = np.array([near_field(each * DEPTH, hinge) for each in k]) @ way
        assert elevation.at(time, 0.0) - near == pytest.approx((a * np.cos(w * time + p)).sum(), abs=1e-12)
        far = (a * np.cos(k * 10.0 - w * time - p)).sum()
        assert elevation.at(time, 10.0) == pytest.approx(far, abs=1e-9)
        assert motion.at(time)[0] == pytest.approx(way.sum())
    assert elevation.at(0.0, 0.0) == elevation.at(-1.0, 0.3) == 0
    assert elevation.at(0.75, 10.0) == pytest.approx(0.5 * (a * np.cos(k * 10.0 - w * 0.75 - p)).sum(), abs=1e-9)


@pytest.mark.parametrize("hinge", HINGES)
def test_the_expected_level_of_a_motion_is_far_wave_and_near_field(hinge):
    """Of ``X = A sin wt``: ``A (H/S cos(kx - wt) + E(x) sin wt)``."""
    amplitude, w = 0.03, 5.0
    one = expected(np.array([amplitude]), np.array([w]), np.zeros(1), DEPTH, G, hinge, 0.0, 9.0)
    k = wavenumber(w, DEPTH, G)
    for time, x in ((0.4, 0.0), (1.0, 0.1), (2.3, 0.5)):
        far = transfer(k * DEPTH, hinge) * math.cos(k * x - w * time)
        near = near_field(k * DEPTH, hinge, x / DEPTH) * math.sin(w * time)
        assert one.at(time, x) == pytest.approx(amplitude * (far + near), rel=1e-12)
    assert isinstance(one.motion, Harmonics)


@pytest.mark.parametrize("height", [0.1, 0.3])
def test_the_crest_of_a_solitary_wave_is_at_the_plate_when_that_is_fastest(height):
    """And has the height that is asked for there; the water then goes with ``c H/(d + H)``."""
    wave = Solitary(height, DEPTH, G)
    motion, level = solitary(wave, 0.7)
    assert motion.at(0.7) == (0, 0, 0)
    times = np.arange(0.7, 0.7 + wave.duration, 1e-3)
    speeds = np.array([motion.at(time)[1] for time in times])
    fastest, way = times[speeds.argmax()], motion.at(times[speeds.argmax()])[0]
    assert speeds.max() == pytest.approx(wave.celerity * height / (DEPTH + height), rel=1e-3)
    assert way == pytest.approx(0.5 * wave.stroke, rel=0.01)
    assert level.at(fastest, way) == pytest.approx(height, rel=1e-4)
    assert level.at(level.crest, 0.0) == pytest.approx(height, rel=1e-12)
    assert level.at(level.crest + 2.0, 2.0 * wave.celerity) == pytest.approx(height, rel=1e-12)
    assert level.at(0.7, 0.0) < 2e-3 * height
    assert motion.at(99.0)[0] == pytest.approx(wave.stroke, rel=2e-3)


# --- scenes ------------------------------------------------------------------------------------------------------------


def flume(wave, kind="piston", **keys):
    """Return the keys of a tank 6 m long with 0.6 m of water and a wavemaker."""
    maker = {"kind": kind, "wave": wave, **keys}
    block = {"low": [0.0, 0.0], "high": [6.0, DEPTH]}
    numerics, time = {"dx": 0.03, "viscosity": "monaghan", "diffusion": "fourtakas"}, {"end": 8.0}
    return tank(domain={"size": [6.0, 1.0]}, fluid={"blocks": [block]}, numerics=numerics, time=time, wavemaker=maker)


@pytest.mark.parametrize("kind", ["piston", "flap"])
def test_a_focused_group_focuses_where_and_when_it_shall(kind):
    wave = {"kind": "focused", "crest": 0.04, "period": 1.1, "place": 3.0, "time": 6.0}
    level = maker_of(load_scene(flume(wave, kind))).expected
    assert level.at(6.0, 3.0) == pytest.approx(0.04, rel=1e-6)
    near = [level.at(6.0 + dt, 3.0 + dx) for dt in (-0.1, 0.0, 0.1) for dx in (-0.1, 0.0, 0.1)]
    assert max(near) == near[4]
    assert max(abs(level.at(time, 3.0)) for time in np.arange(0.0, 4.0, 0.02)) < 0.02


def test_irregular_waves_have_their_height_and_repeat_after_their_duration():
    """``Hs = 4 sqrt(m0)`` far from the plate over the whole duration; another seed is another sea."""
    wave = {"kind": "irregular", "height": 0.05, "period": 1.1, "duration": 40.0, "ramp": 0.0}
    level, again = (maker_of(load_scene(flume(wave))).expected for _ in range(2))
    times = 1.0 + np.arange(800) * 0.05
    record = np.array([level.at(time, 10 * DEPTH) for time in times])
    assert 4 * record.std() == pytest.approx(0.05, rel=1e-3)
    assert [level.at(time, 6.0) for time in times[::100] + 40.0] == pytest.approx(record[::100], abs=1e-9)
    assert [again.at(time, 6.0) for time in times[::100]] == list(record[::100])
    other = maker_of(load_scene(flume({**wave, "seed": 2}))).expected
    assert abs(np.corrcoef(record[::4], [other.at(time, 6.0) for time in times[::4]])[0, 1]) < 0.5


def test_irregular_waves_of_a_run_have_a_wave_in_each_step_of_less_than_one_over_its_length():
    wave = {"kind": "irregular", "height": 0.05, "period": 1.1}
    motion = maker_of(load_scene(flume(wave))).motion.signal
    low, high = 0.5 / 1.1, 2.5 / 1.1
    count = math.ceil(8.0 * (high - low))
    steps = (np.sort(motion.frequencies) / (2 * math.pi) - low) / (high - low) * count
    np.testing.assert_array_equal(np.floor(steps), np.arange(count))


def test_a_table_of_densities_is_scaled_to_the_height_that_is_given():
    table = {"kind": "irregular", "spectrum": "table", "frequencies": [0.5, 0.9, 1.0, 1.2, 2.0], "densities": [0, 1, 2, 1, 0]}
    scaled = {**table, "densities": [value * 1e-4 for value in table["densities"]]}
    energy = np.trapezoid(scaled["densities"], table["frequencies"])
    for keys, m0 in ((scaled, energy), ({**scaled, "height": 0.05}, 0.05**2 / 16)):
        level = maker_of(load_scene(flume(keys))).expected
        assert 0.5 * ((level.motion.amplitudes * level.far) ** 2).sum() == pytest.approx(m0, rel=1e-3)
    assert load_scene(flume(scaled)).wave_period == 1.0


def test_a_plate_is_hinged_at_the_bed_unless_told_otherwise_and_moves_at_the_level():
    """The way of an oscillation by stroke is that at the still-water level, for flaps too."""
    wave = {"kind": "oscillation", "stroke": 0.1, "period": 1.0}
    for kind, keys, foot in (("flap", {}, 0.0), ("flap", {"hinge": 0.2}, 0.2), ("flap", {"hinge": -0.4}, -0.4)):
        motion = maker_of(load_scene(flume(wave, kind, **keys))).motion
        assert motion.hinge == (0.0, foot)
        assert motion.reach(DEPTH) == pytest.approx((-0.05, 0.05))
    assert maker_of(load_scene(flume(wave))).motion.reach(0.1) == (-0.05, 0.05)
    assert maker_of(load_scene(tank())) is None


def test_a_sloping_plate_is_where_it_meets_the_still_water():
    paddle = {"name": "paddle", "points": [[0.6, 1.0], [0.4, 0.0]]}
    keys = flume({"kind": "oscillation", "stroke": 0.05, "period": 1.0}, wall="paddle")
    keys |= {"walls": {"right": {}, "bottom": {}, "polygons": [paddle]}}
    keys["fluid"] = {"blocks": [{"points": [[0.4, 0.0], [6.0, 0.0], [6.0, DEPTH], [0.4 + 0.2 * DEPTH, DEPTH]]}]}
    assert place_of(load_scene(keys)) == pytest.approx(0.4 + 0.2 * DEPTH)


# --- records -----------------------------------------------------------------------------------------------------------

SECONDS = 2.0 + 0.02 * np.arange(150)
LIMIT = 3.0


def recorded(time):
    """A way [m] that neither begins nor ends at rest."""
    return 0.05 * np.sin(4.0 * time) + 0.01 * np.cos(7.0 * time)


def lines_of(times, values, separator=" "):
    return [f"{t:.6f}{separator}{v:.8f}" for t, v in zip(times, values, strict=True)]


FILES = {
    "blanks": (lines_of(SECONDS, recorded(SECONDS)), "m", "s"),
    "commas": (lines_of(SECONDS, recorded(SECONDS), ","), "m", "s"),
    "commas and blanks": (lines_of(SECONDS, recorded(SECONDS), " ,\t"), "m", "s"),
    "headings": (["Time(s),Way(m)", *lines_of(SECONDS, recorded(SECONDS), ",")], "m", "s"),
    "comments": (["# a record", "", *lines_of(SECONDS, recorded(SECONDS), "  "), "   # end"], "m", "s"),
    "comments behind samples": ([f"{line} # x" for line in lines_of(SECONDS, recorded(SECONDS))], "m", "s"),
    "cm and ms": (lines_of(1e3 * SECONDS, 1e2 * recorded(SECONDS)), "cm", "ms"),
    "mm and min": (lines_of(SECONDS / 60, 1e3 * recorded(SECONDS)), "mm", "min"),
}
FILES["byte-order mark"] = (["\ufeff" + FILES["blanks"][0][0], *FILES["blanks"][0][1:]], "m", "s")


@pytest.fixture
def record(tmp_path):
    """Write lines to a file and return its path."""

    def write(lines):
        path = tmp_path / "record.txt"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("name", FILES)
def test_a_record_is_given_back_between_a_start_and_an_end_at_rest(record, name):
    """Between samples too, within the error of interpolation; nothing is accelerated harder than the limit."""
    lines, unit, time_unit = FILES[name]
    signal = measured_motion(record(lines), unit, time_unit, LIMIT)
    speed = (recorded(2.02) - recorded(2.0)) / 0.02
    lead = abs(speed) / (0.5 * LIMIT)
    between = SECONDS[5:-5] + 0.007
    found = np.array([signal.at(lead + time - 2.0)[0] for time in between])
    wanted = recorded(between) - recorded(2.0) + 0.5 * speed * lead
    atol = 1e-4 if name == "mm and min" else 2e-6  # times of six digits in minutes
    np.testing.assert_allclose(found, wanted, atol=atol)
    assert signal.at(0.0) == (0, 0, 0)
    assert signal.at(signal.times[-1] + 1.0)[1:] == (0, 0)
    assert signal.times[-1] > lead + 2.98
    times = np.arange(0.0, signal.times[-1], 1e-3)
    assert max(abs(signal.at(time)[2]) for time in times) < LIMIT
    ways = np.array([signal.at(time)[0] for time in times])
    assert np.abs(np.diff(ways)).max() < 0.3e-3


def test_a_start_may_be_as_long_as_one_likes(record):
    path = record(FILES["blanks"][0])
    long, speed = measured_motion(path, "m", "s", LIMIT, 1.5), (recorded(2.02) - recorded(2.0)) / 0.02
    assert long.at(1.5)[1] == pytest.approx(speed, rel=0.03)
    assert long.at(0.75)[1] == pytest.approx(0.5 * speed, rel=0.03)


def test_angles_are_radians_in_the_end(record):
    degrees = measured_motion(record(lines_of(SECONDS, np.degrees(recorded(SECONDS)))), "deg", "s", LIMIT)
    radians = measured_motion(record(lines_of(SECONDS, recorded(SECONDS))), "rad", "s", LIMIT)
    assert degrees.at(1.0) == pytest.approx(radians.at(1.0), rel=1e-4)


# name: (lines or None for no file, where it says that is wrong, why, cure)
BAD = {
    "missing file": (None, "cannot be read", "", "a text file of two columns"),
    "empty file": ([], "holds 0 samples", "", "at least 8"),
    "comments alone": (["# nothing"], "holds 0 samples", "", "at least 8"),
    "headings alone": (["time way"], "holds 0 samples", "", "at least 8"),
    "no numbers": (["a text,", "that is", "no record"], "line 2 is no sample", "'that is'", "two finite numbers"),
    "too few samples": (lines_of(SECONDS[:7], recorded(SECONDS[:7])), "holds 7 samples", "", "at least 8"),
    "three columns": ([f"{line} 1.0" for line in FILES["blanks"][0]], "line 1 is no sample", "2.000000", "two finite numbers"),
    "one column": ([line.split()[1] for line in FILES["blanks"][0]], "line 1 is no sample", "it reads", "two finite numbers"),
    "not a number": ([*FILES["blanks"][0], "5.0 nan"], "line 151 is no sample", "'5.0 nan'", "two finite numbers"),
    "a word": ([*FILES["blanks"][0], "end of file"], "line 151 is no sample", "'end of file'", "two finite numbers"),
    "times that go back": (
        lines_of([*SECONDS[:50], *(SECONDS[50:] - 0.5)], recorded(SECONDS)),
        "times do not increase",
        "sample 51 is at 2.5 s, the one before at 2.98 s",
        "in the order of time",
    ),
    "times that stand": (
        lines_of([*SECONDS[:50], SECONDS[49], *SECONDS[51:]], recorded(SECONDS)),
        "times do not increase",
        "sample 51 is at 2.98 s, the one before at 2.98 s",
        "each time once",
    ),
    "gap": (
        lines_of([*SECONDS[:50], *SECONDS[60:]], recorded(np.array([*SECONDS[:50], *SECONDS[60:]]))),
        "has a gap",
        "nothing is known from 2.98 to 3.2 s, where samples are 0.02 s apart",
        "steps of at most 0.1 s",
    ),
    "jump": (
        lines_of(SECONDS, recorded(SECONDS) + 0.02 * (SECONDS > 3.5)),
        "jumps",
        "at 3.52 s the plate would be accelerated with 51.2 m/s^2",
        "at most 9.81 m/s^2",
    ),
    "wrong unit": (
        lines_of(SECONDS, 1e2 * recorded(SECONDS)),
        "jumps",
        "m/s^2",
        "at most 9.81 m/s^2: another unit than 'm' and 's', or a smoother record",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_record_is_a_fault_of_the_scene(record, tmp_path, name):
    """As `parsph check` prints it: where, with the file's name, what, why and the cure."""
    lines, what, why, cure = BAD[name]
    path = tmp_path / "none.txt" if lines is None else record(lines)
    with pytest.raises(SceneError) as caught:
        load_scene(flume({"kind": "series", "file": str(path), "unit": "m"}))
    (fault,) = caught.value.faults
    assert fault.where == f"wavemaker.wave.file: {path}"
    assert what in fault.what
    assert why in fault.why
    assert cure in fault.cure
    assert str(caught.value).startswith(f"wavemaker.wave.file: {path}: ")


def test_a_record_stands_beside_its_scene(tmp_path, monkeypatch, record):
    """Relative to the file that names it, a base included; its copy in a run's folder means the same file."""
    from parsph.scene.load import scene_text

    record(FILES["blanks"][0])
    keys = flume({"kind": "series", "file": "record.txt", "unit": "m"})
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    plain = load_scene(keys)
    (tmp_path / "base.json").write_text(scene_text(plain).replace(str(tmp_path / "record.txt"), "record.txt"))
    (tmp_path / "mine.toml").write_text('base = "base.json"\n[time]\nend = 2.0\n')
    monkeypatch.chdir(tmp_path / "elsewhere")
    for name in ("base.json", "mine.toml"):
        scene = load_scene(tmp_path / name)
        assert scene.wavemaker.wave == plain.wavemaker.wave
        (tmp_path / "elsewhere" / "scene.json").write_text(scene_text(scene))
        assert load_scene("scene.json") == scene
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene(keys)
