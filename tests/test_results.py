"""Finished runs: read again, measured for studies, and looked at by ``parsph analyse`` and ``parsph plot``."""

import json
import math
import shutil
import sys

import h5py
import numpy as np
import pytest
from helpers import parsph
from helpers import tank as tank_keys

from parsph import analysis, viz, waves
from parsph.errors import SceneError
from parsph.examine import one_number, plot
from parsph.io.results import Results
from parsph.io.tables import Table, read_table
from parsph.run import run
from parsph.scene.load import load_scene, scene_text
from parsph.study.metrics import METRICS

DEPTH, PERIOD, GRAVITY = 0.2, 0.8, 9.81
K = waves.wavenumber(2 * math.pi / PERIOD, DEPTH, GRAVITY)
LENGTH = 2 * math.pi / K  # 0.93 m
PLACES = {"level-00": 0.2, "a": 0.5, "b": 0.5 + LENGTH / 2, "level-03": 0.5 + LENGTH / 4}

TANK = {
    "domain": {"size": [1.6, 0.4], "gravity": GRAVITY},
    "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [1.6, DEPTH]}]},
    "walls": {"left": {}, "right": {}, "bottom": {}},
    "wavemaker": {"wave": {"kind": "oscillation", "angle": 3.0, "period": PERIOD}},
    "damping": [{"side": "right", "length": 0.4}, {"side": "left", "length": 0.1}],
    "gauges": [
        {"kind": "level", "x": PLACES["level-00"]},
        {"kind": "level", "x": PLACES["a"], "name": "a"},
        {"kind": "level", "x": PLACES["b"], "name": "b"},
        {"kind": "level", "x": PLACES["level-03"]},
        {"kind": "energy", "name": "all", "every": 0.01},
    ],
    "numerics": {"dx": 0.04, "c0_factor": 10.0, "viscosity": "monaghan"},
    "time": {"end": 0.1},
    "output": {"snapshots": {"every": 0.05}},
}
SHALLOW = {"numerics.dx": 4.0, "numerics.h_over_dx": 2.0, "time.end": 80.0, "output.snapshots.every": 80.0}
REFLECTED, INCIDENT = 0.2, 0.01


@pytest.fixture(scope="module")
def tank(tmp_path_factory):
    """The folder of a run of 200 particles, a tenth of a second long."""
    folder = tmp_path_factory.mktemp("tank")
    (folder / "tank.json").write_text(scene_text(load_scene(TANK)))
    return run(folder / "tank.json", (), folder / "out").folder


@pytest.fixture(scope="module")
def humps(tmp_path_factory):
    """The folders of three runs of shallow water: with a layer, with a wall, without end."""
    folder = tmp_path_factory.mktemp("humps")
    names = {"layer": "swe-pulse", "reflecting": "swe-pulse-reflecting", "infinite": "swe-pulse-infinite"}
    return {name: run(scene, [f"{k}={v}" for k, v in SHALLOW.items()], folder / name).folder for name, scene in names.items()}


def pretended(folder, keys, tables):
    """Make the folder of a run that never was: a scene and {gauge: {header: values}}."""
    folder.mkdir(parents=True)
    (folder / "scene.json").write_text(scene_text(load_scene(keys)))
    for name, columns in tables.items():
        file = Table(folder / "gauges" / f"{name}.csv", list(columns))
        for row in zip(*columns.values(), strict=True):
            file.add(row)
        file.close()
    return folder


@pytest.fixture(scope="module")
def wavy(tmp_path_factory):
    """Ten periods of a wave and its known reflection; noise before the last four, and always at the first gauge."""
    t = np.arange(0, 10 * PERIOD + 1e-9, 0.02)
    noise = np.random.default_rng(3).normal(0, 0.01, t.size)
    tables, turn = {}, 2 * np.pi * t / PERIOD
    for name, x in PLACES.items():
        level = DEPTH + INCIDENT * (np.cos(turn - K * x) + REFLECTED * np.cos(turn + K * x + 1.0))
        noisy = (name == "level-00") | (t < t[-1] - 4.01 * PERIOD)
        tables[name] = {"time [s]": t, "level [m]": np.where(noisy, DEPTH + noise, level)}
    return pretended(tmp_path_factory.mktemp("wavy") / "run", {**TANK, "time": {"end": 8.0}}, tables)


# --- read again -----------------------------------------------------------------------------------------------------------


def test_gauges_have_their_tables(tank):
    results = Results(tank)
    assert list(results.gauges("level")) == list(PLACES)
    assert {name: gauge["x"] for name, gauge in results.gauges("level").items()} == PLACES
    assert list(results.gauges("energy")) == ["all"]
    assert results.gauges("pressure") == {}
    np.testing.assert_allclose(results.table("all")["time [s]"], np.arange(11) / 100, atol=1e-12)
    with pytest.raises(SceneError, match=r"no gauge 'c'; one of: a, all, b, level-00, level-03"):
        results.table("c")


def test_levels_of_all_or_chosen_gauges(tank):
    results = Results(tank)
    t, levels, x, names = results.levels()
    assert names == list(PLACES)
    assert list(x) == list(PLACES.values())
    assert levels.shape == (4, t.size) == (4, 6)
    for name, level in zip(names, levels, strict=True):
        np.testing.assert_array_equal(level, read_table(tank / "gauges" / f"{name}.csv")["level [m]"])
    _, chosen, x, names = results.levels(["level-03", "a"])
    assert names == ["level-03", "a"]
    assert list(x) == [PLACES["level-03"], PLACES["a"]]
    np.testing.assert_array_equal(chosen, levels[[3, 1]])


def test_levels_that_are_not_there_or_do_not_fit(tank, tmp_path):
    results = Results(tank)
    for name in ("c", "all"):
        with pytest.raises(SceneError, match=rf"no level gauge '{name}'; one of: level-00, a, b, level-03"):
            results.levels(["a", name])
    none = pretended(tmp_path / "none", {**TANK, "gauges": []}, {})
    with pytest.raises(SceneError, match="no level gauges"):
        Results(none).levels()
    with pytest.raises(SceneError, match="none in this scene"):
        Results(none).levels(["a"])
    for name, times in (("fewer", [0.0, 0.1]), ("others", [0.0, 0.1, 0.21])):
        tables = {gauge: {"time [s]": [0.0, 0.1, 0.2], "level [m]": [1.0, 2.0, 3.0]} for gauge in PLACES}
        tables["b"] = {"time [s]": times, "level [m]": times}
        odd = Results(pretended(tmp_path / name, TANK, tables))
        with pytest.raises(SceneError, match="different times"):
            odd.levels()
        assert odd.levels(["a", "level-03"])[1].shape == (2, 3)


def test_snapshots_come_in_the_order_of_time_and_of_id(tank, tmp_path):
    folder = shutil.copytree(tank, tmp_path / "run")
    last = folder / "snapshots" / "00002.vtkhdf"
    (folder / "snapshots" / "00003.partial").write_text("half a file")
    straight = Results(folder).snapshot()
    with h5py.File(last, "r+") as file:  # as another number of ranks might have left them
        root = file["VTKHDF"]
        order = np.random.default_rng(1).permutation(len(root["Points"]))
        for dataset in (root["Points"], *root["PointData"].values()):
            dataset[:] = dataset[:][order]
        assert not (np.diff(root["PointData/id"]) > 0).all()
    results = Results(folder)
    assert [results.snapshot(number)["time"] for number in (0, 1, 2, -1)] == pytest.approx([0.0, 0.05, 0.1, 0.1], abs=1e-12)
    found = results.snapshot()
    assert (np.diff(found["id"]) > 0).all()
    assert found["position"].shape == found["velocity"].shape == (200, 3)
    for name, values in straight.items():
        np.testing.assert_array_equal(found[name], values)
    for number in (3, -4):
        with pytest.raises(SceneError, match=f"no snapshot {number}; 3 are there"):
            results.snapshot(number)
    assert {"pressure": "Pa", "density": "kg/m^3", "velocity": "m/s"}.items() <= results.units.items()


def test_the_profile_is_the_last_state_of_shallow_water(humps):
    results = Results(humps["infinite"])
    line, last = results.profile(), results.snapshot()
    assert {name: values.shape for name, values in line.items()} == dict.fromkeys(
        ("id", "position", "velocity", "density", "mass"), (250,)
    )
    np.testing.assert_array_equal(line["position"], last["position"][:, 0])
    assert (np.diff(line["position"]) > 0).all()
    assert np.sum(line["mass"]) == pytest.approx(1000.0 + 0.01 * 18.0 * math.sqrt(math.pi), rel=1e-9)
    assert results.units["density"] == "m"
    assert results.summary["time [s]"] == last["time"] == 80.0


def test_a_layer_has_its_ends(tank):
    results = Results(tank)
    assert [results.layer(zone) for zone in results.scene["damping"]] == [pytest.approx((1.2, 1.6)), (0.0, 0.1)]


@pytest.mark.parametrize(
    ("source", "overrides"),
    [
        ("pool", {}),
        ("pool", {"fluid.level": 0.9}),
        ("still", {"fluid.blocks.0.low": [0.0, 0.1]}),
        ("swe-pulse", {}),
        ("swe-dam-break", {}),
        ("swe-dam-break", {"fluid.level": 0.5}),
    ],
)
def test_level_and_depth_are_those_of_the_scene(tmp_path, source, overrides):
    scene = load_scene(source, overrides)
    (tmp_path / "scene.json").write_text(scene_text(scene))
    results = Results(tmp_path)
    assert (results.level, results.depth) == (scene.level, scene.depth)
    assert results.summary is None
    with pytest.raises(SceneError, match="no snapshot -1; 0 are there"):
        results.snapshot()


@pytest.mark.parametrize("content", [None, "{", "\xff\xfe"])
def test_what_is_no_run_is_refused(tmp_path, content):
    if content:
        (tmp_path / "scene.json").write_bytes(content.encode("latin-1"))
    with pytest.raises(SceneError, match="is not the folder of a run"):
        Results(tmp_path)
    with pytest.raises(SceneError, match="is not the folder of a run"):
        Results(tmp_path / "nowhere")


# --- measured for studies -------------------------------------------------------------------------------------------------


def test_reflection_of_a_row_leaves_out_start_up_and_near_field(wavy):
    results = Results(wavy)
    assert METRICS["reflection"].measure(results, {}) == pytest.approx(REFLECTED, rel=1e-6)
    assert METRICS["incident"].measure(results, {}) == pytest.approx(INCIDENT, rel=1e-6)


def test_level_difference_is_relative_to_the_waves_of_the_infinite_run(wavy, tmp_path):
    higher = shutil.copytree(wavy, tmp_path / "run")
    for name in PLACES:
        columns = read_table(wavy / "gauges" / f"{name}.csv")
        table = Table(higher / "gauges" / f"{name}.csv", list(columns))
        mean = np.average(columns["level [m]"], weights=np.gradient(columns["time [s]"]))
        for t, level in zip(*columns.values(), strict=True):
            table.add((t, mean + 1.25 * (level - mean)))
        table.close()
    results, infinite = Results(higher), {"infinite": Results(wavy)}
    assert METRICS["level-difference"].measure(results, infinite) == pytest.approx(0.25, rel=1e-9)
    assert METRICS["level-difference"].measure(infinite["infinite"], infinite) == 0.0


def energies(folder, kinetic, cycles=None):
    keys = {**TANK, "wavemaker": {"wave": {**TANK["wavemaker"]["wave"], "cycles": cycles}}, "time": {"end": 8.0}}
    t = np.arange(len(kinetic)) * 0.1
    return Results(pretended(folder, keys, {"all": {"time [s]": t, "kinetic energy [J]": kinetic}}))


def test_energies_are_compared_after_start_up(tmp_path):
    """Waves: after four periods, 3.2 s, over the mean there. One oscillation: all of the run, over the peak."""
    late = np.arange(81) * 0.1 > 4 * PERIOD
    far = np.where(late, 10.0, 3.0)
    off = np.where(late, np.where(np.arange(81) % 2, 1.0, -1.0), 50.0)
    off[60] = -4.0
    rms = math.sqrt((late.sum() - 1 + 16) / late.sum())
    results, infinite = energies(tmp_path / "a", far + off), {"infinite": energies(tmp_path / "b", far)}
    assert METRICS["energy-difference"].measure(results, infinite) == pytest.approx(rms / 10)
    assert METRICS["energy-excess"].measure(results, infinite) == pytest.approx(0.4)
    assert METRICS["residual-energy"].measure(results, {}) == pytest.approx(9.0 / 53.0)
    results = energies(tmp_path / "c", far + off, 1)
    infinite = {"infinite": energies(tmp_path / "d", far, 1)}
    assert METRICS["energy-excess"].measure(results, infinite) == pytest.approx(5.0)
    assert METRICS["energy-difference"].measure(results, infinite) == pytest.approx(math.sqrt(np.mean(off**2)) / 10)


def test_reflection_ratio_is_1_for_a_wall_and_0_for_no_end(humps):
    runs = {name: Results(folder) for name, folder in humps.items()}
    measured = {name: METRICS["reflection-ratio"].measure(results, runs) for name, results in runs.items()}
    assert measured["reflecting"] == 1.0
    assert measured["infinite"] == 0.0
    assert 0 < measured["layer"] < 0.1


def test_every_metric_is_described():
    named = {
        "reflection",
        "incident",
        "wave-error",
        "runup-error",
        "axes-error",
        "energy-change",
        "level-difference",
        "energy-difference",
        "energy-excess",
        "residual-energy",
        "reflection-ratio",
        "probe-error",
        "probe-error-early",
        "probe-error-largest",
        "rest-energy",
        "rest-speed",
        "energy-growth",
        "plateau",
        "plateau-error",
        "frequency-error",
        "loss-per-period",
        "velocity-error",
        "penetrations",
        "lowest-row",
        "leaks",
        "wall-cost",
        "step-cost",
        "work",
        "stopped",
        "fallbacks",
    }
    assert METRICS.keys() == named
    for name, metric in METRICS.items():
        assert metric.name == name
        assert metric.description.endswith(".")
        assert metric.unit in ("", "-", "m", "%", "µs", "CPU s", "dx")


# --- looked at --------------------------------------------------------------------------------------------------------------


def rows_of(command, *arguments, folder):
    """Return the rows that a command writes, having seen them printed."""
    code, out, err = command("analyse", *arguments, "--json", folder / "rows.json")
    assert code == 0, err
    rows = json.loads((folder / "rows.json").read_text())
    for name in rows[0]:
        assert name in out
    assert len(rows) <= len(out.splitlines()) - 4
    return rows


def test_analyse_waves_by_a_process_of_its_own(wavy, tmp_path):
    arguments = ("--gauge", "b", "--gauge", "a", "--start", 8 - 3.9 * PERIOD, "--json", "w.json")
    result = parsph("analyse", "waves", wavy, *arguments, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    rows = json.loads((tmp_path / "w.json").read_text())
    assert [row["gauge"] for row in rows] == ["b", "a"]
    assert [row["x [m]"] for row in rows] == [PLACES["b"], PLACES["a"]]
    for row in rows:
        x = row["x [m]"]
        amplitude = INCIDENT * (np.exp(-1j * K * x) + REFLECTED * np.exp(1j * (K * x + 1.0)))
        assert row["mean level [m]"] == pytest.approx(DEPTH, abs=1e-5)
        assert row["wave height [m]"] == pytest.approx(2 * abs(amplitude), rel=0.01)
        assert row["period [s]"] == pytest.approx(PERIOD, rel=1e-3)
        assert abs(np.angle(np.exp(1j * row["phase [rad]"]) / amplitude)) < 0.05
        assert row["waves"] in (2, 3)
        assert f"{row['wave height [m]']:.5g}" in result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["w.json"]


def test_analyse_reflection(wavy, tmp_path, command):
    far = [part for name in ("a", "b", "level-03") for part in ("--gauge", name)]
    (row,) = rows_of(command, "reflection", wavy, *far, folder=tmp_path)
    assert row["gauges"] == 3
    assert row["reflection coefficient"] == pytest.approx(REFLECTED, rel=1e-6)
    assert row["incident [m]"] == pytest.approx(INCIDENT, rel=1e-6)
    assert row["reflected [m]"] == pytest.approx(REFLECTED * INCIDENT, rel=1e-6)
    assert row["wavelength [m]"] == pytest.approx(LENGTH, rel=1e-9)
    assert row["period [s]"] == PERIOD
    assert row["misfit"] < 1e-6
    (two,) = rows_of(command, "reflection", wavy, *far[:2], *far[4:], "--period", PERIOD, folder=tmp_path)
    assert two["gauges"] == 2
    assert two["reflection coefficient"] == pytest.approx(REFLECTED, rel=1e-6)
    (early,) = rows_of(command, "reflection", wavy, *far, "--periods", 9, folder=tmp_path)
    assert abs(early["reflection coefficient"] - REFLECTED) > 1e-3  # with the noise before the last four
    (noisy,) = rows_of(command, "reflection", wavy, folder=tmp_path)
    assert noisy["gauges"] == 4
    assert noisy["misfit"] > 0.1


def test_analyse_reflection_of_a_spectrum(wavy, tmp_path, command):
    """Of the last four periods less a sample, which repeat: one line of the spectrum has all of the waves."""
    far = [part for name in ("a", "b", "level-03") for part in ("--gauge", name)]
    start = ["--start", 8 - 4 * PERIOD + 0.01]
    *lines, total = rows_of(command, "reflection", wavy, *far, *start, "--spectrum", 1.0, 1.5, folder=tmp_path)
    assert total["frequency [Hz]"] == "all"
    assert total["reflection coefficient"] == pytest.approx(REFLECTED, rel=0.02)
    assert total["incident [m]"] == pytest.approx(INCIDENT, rel=0.01)
    highest = max(lines, key=lambda line: line["incident [m]"])
    assert highest["frequency [Hz]"] == pytest.approx(1 / PERIOD, rel=0.01)
    assert math.hypot(*(line["incident [m]"] for line in lines)) == pytest.approx(total["incident [m]"])


@pytest.fixture(scope="module")
def long_tank(tmp_path_factory):
    """Six gauges, the last in the absorbing layer, along waves that decay, with bound and free second harmonics."""
    t, free = np.arange(0, 12 * PERIOD + 1e-9, 0.02), waves.wavenumber(4 * math.pi / PERIOD, DEPTH, GRAVITY)
    places, turn = [0.8, 0.95, 1.25, 1.6, 1.9, 2.9], 2 * np.pi * t / PERIOD
    gauges = [{"kind": "level", "x": x} for x in places]
    keys = {**TANK, "domain": {"size": [3.2, 0.4], "gravity": GRAVITY}, "gauges": gauges, "time": {"end": 12 * PERIOD}}
    keys["fluid"] = {"blocks": [{"low": [0.0, 0.0], "high": [3.2, DEPTH]}]}
    tables = {}
    for number, x in enumerate(places):
        first = INCIDENT * np.exp(-RATE * x) * (0.1 if x > 2.8 else 1.0) * np.cos(turn - K * x)
        second = 1e-3 * np.cos(2 * (turn - K * x) + 0.4) + 5e-4 * np.cos(2 * turn - free * x + 1.0)
        tables[f"level-{number:02d}"] = {"time [s]": t, "level [m]": DEPTH + first + second}
    return pretended(tmp_path_factory.mktemp("long") / "run", keys, tables)


RATE = 0.05  # [1/m]


def tables_of(command, *arguments, folder):
    """Return {name: rows} that a command writes, having seen them printed."""
    code, out, err = command("analyse", *arguments, "--json", folder / "tables.json")
    assert code == 0, err
    tables = json.loads((folder / "tables.json").read_text())
    for name, rows in tables.items():
        assert name in out
        assert all(header.split()[0] in out for header in rows[0])
    return tables, out


def test_analyse_harmonics(long_tank, tmp_path, command):
    tables, out = tables_of(command, "harmonics", long_tank, folder=tmp_path)
    assert list(tables) == ["harmonics", "second harmonic", "decay of the first harmonic"]
    rows = tables["harmonics"]
    assert [row["gauge"] for row in rows] == [f"level-{k:02d}" for k in range(6)]
    assert [row.get("where") for row in rows] == [None] * 5 + ["absorbing layer"]
    for row in rows[:5]:
        assert row["a_1 [m]"] == pytest.approx(INCIDENT * math.exp(-RATE * row["x [m]"]), rel=1e-6)
        assert row["a_3 [m]"] < 1e-8
    (second,) = tables["second harmonic"]
    assert second["gauges"] == 5
    assert [second[f"{part} [m]"] for part in ("bound", "free", "reflected free")] == pytest.approx([1e-3, 5e-4, 0], abs=1e-8)
    (decay,) = tables["decay of the first harmonic"]
    assert decay["decay [1/m]"] == pytest.approx(RATE, rel=1e-5)
    assert decay["wavelength [m]"] == pytest.approx(LENGTH)
    assert decay["decay [% a wavelength]"] == pytest.approx(100 * (1 - math.exp(-RATE * LENGTH)), rel=1e-5)
    scene = load_scene(Results(long_tank).scene)
    nu = waves.viscosity_of_alpha(0.02, scene.h, scene.c0, 2)
    assert decay["viscosity [m^2/s]"] == pytest.approx(nu)
    assert decay["expected [1/m]"] == pytest.approx(analysis.expected_decay(PERIOD, DEPTH, GRAVITY, nu))
    picture = long_tank / "figures" / "harmonics.png"
    assert str(picture) in out
    assert picture.read_bytes().startswith(PNG)


def test_analyse_harmonics_of_few_gauges_says_what_is_missing(long_tank, tmp_path, command):
    two = [part for name in ("level-01", "level-00") for part in ("--gauge", name)]
    tables, out = tables_of(command, "harmonics", long_tank, *two, "--count", 1, "--period", PERIOD, folder=tmp_path)
    assert list(tables) == ["harmonics"]
    assert [row["gauge"] for row in tables["harmonics"]] == ["level-00", "level-01"]  # along the tank
    assert "a_2 [m]" not in tables["harmonics"][0]
    assert "no second harmonic: gauges: of 2 gauge(s) and 1 harmonic(s)" in " ".join(out.split())
    assert "no decay of the first harmonic: gauges: positions have shape (2,)" in " ".join(out.split())


@pytest.mark.parametrize(
    ("numerics", "nu"), [({"viscosity": "none"}, 0.0), ({"viscosity": "newtonian", "nu": 1e-3, "integrator": "verlet"}, 1e-3)]
)
def test_the_expected_decay_is_that_of_the_viscosity_in_use(long_tank, tmp_path, command, numerics, nu):
    folder = shutil.copytree(long_tank, tmp_path / "run")
    keys = Results(folder).scene
    keys["numerics"] |= numerics
    (folder / "scene.json").write_text(json.dumps(keys))
    tables, _ = tables_of(command, "harmonics", folder, folder=tmp_path)
    (decay,) = tables["decay of the first harmonic"]
    assert decay["viscosity [m^2/s]"] == nu
    assert decay["expected [1/m]"] == pytest.approx(analysis.expected_decay(PERIOD, DEPTH, GRAVITY, nu))


def test_analyse_spectrum(wavy, tmp_path, command, monkeypatch):
    chosen = ["--gauge", "b", "--gauge", "a", "--start", 8 - 3.99 * PERIOD]
    rows = rows_of(command, "spectrum", wavy, *chosen, "--band", 0.5, 3.0, folder=tmp_path)
    assert [row["gauge"] for row in rows] == ["b", "a"]
    for row in rows:
        height = 2 * INCIDENT * abs(np.exp(-1j * K * row["x [m]"]) + REFLECTED * np.exp(1j * (K * row["x [m]"] + 1.0)))
        assert row["H_1/3 [m]"] == pytest.approx(height, rel=0.02)
        assert row["H_m0 [m]"] == pytest.approx(math.sqrt(2) * height, rel=0.1)
        assert row["T_p [s]"] == pytest.approx(PERIOD, rel=0.05)
        assert row["T_z [s]"] == pytest.approx(PERIOD, rel=0.01)
        assert row["waves"] == 3
        assert "H_1/10 [m]" not in row
    picture = wavy / "figures" / "spectrum.png"
    assert picture.read_bytes().startswith(PNG)
    picture.unlink()
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    code, out, err = command("analyse", "spectrum", wavy, *chosen)
    assert code == 0, err
    assert "no spectrum.png: plots: matplotlib is not installed" in " ".join(out.split())
    assert not picture.exists()
    picture.parent.rmdir()


def test_analyse_ratio(humps, tmp_path, command):
    folders = [humps[name] for name in ("layer", "reflecting", "infinite")]
    (row,) = rows_of(command, "ratio", *folders, folder=tmp_path)
    runs = {name: Results(folder) for name, folder in humps.items()}
    assert row == {"time [s]": 80.0, "reflection ratio": METRICS["reflection-ratio"].measure(runs["layer"], runs)}


def test_analyse_energy_is_that_of_the_gauge_and_regions_add_up(tank, humps, tmp_path, command):
    rows = rows_of(command, "energy", tank, folder=tmp_path)
    gauge = Results(tank).table("all")
    assert [row["time [s]"] for row in rows] == pytest.approx([0, 0.05, 0.1], abs=1e-12)
    expected = gauge["kinetic energy [J]"][[0, 5, 10]]
    np.testing.assert_allclose([row["kinetic energy [J]"] for row in rows], expected, rtol=1e-12)
    assert expected[-1] > 0
    left = rows_of(command, "energy", tank, "--low", "-1,-1", "--high", "0.5,1", folder=tmp_path)
    right = rows_of(command, "energy", tank, "--low", "0.5,-1", folder=tmp_path)
    parts = [[row["kinetic energy [J]"] for row in part] for part in (left, right)]
    assert min(parts[0][-1], parts[1][-1]) > 0
    np.testing.assert_allclose(np.sum(parts, axis=0), expected, rtol=1e-12)
    line = rows_of(command, "energy", humps["infinite"], "--low", "500", folder=tmp_path)
    assert line[0]["kinetic energy [J]"] < 1e-6 < line[-1]["kinetic energy [J]"]  # the hump is there at the end


def test_plot_draws_every_field_of_a_snapshot(tmp_path, command):
    """Numbers, vectors, tensors; and a speed that is the length of the velocity."""
    keys = {**TANK, "gauges": [], "output": {"snapshots": {"every": 0.05, "moments": True}}}
    (tmp_path / "tank.json").write_text(scene_text(load_scene(keys)))
    folder = run(tmp_path / "tank.json", (), tmp_path / "out").folder
    fields = [name for name in Results(folder).snapshot() if name != "time"]
    assert {"gradient_moment1", "gradient_moment0", "kernel_moment1", "kernel_moment0", "velocity", "position"} <= set(fields)
    pictures = {}
    for field in (*fields, "speed"):
        code, _, err = command("plot", folder, "--field", field)
        assert code == 0, err
        pictures[field] = (folder / "figures" / f"{field}.png").read_bytes()
    assert all(picture.startswith(PNG) for picture in pictures.values())
    assert len(set(pictures.values())) == len(pictures)


def test_what_colours_a_particle_is_one_number():
    numbers, vectors = np.array([1.0, -2.0]), np.array([[3.0, 4.0, 0.0], [0.0, 0.0, -1.0]])
    assert one_number(numbers, "density", 2)[0] is numbers
    found, label = one_number(vectors, "velocity", 2)
    assert (list(found), label) == ([5.0, 1.0], "|velocity|")
    assert one_number(vectors, "speed", 2)[1] == "speed"
    flat, off = np.diag([1.0, 1.0, 0.0]).ravel(), np.array([1.0, 3.0, 0, 4.0, 1.0, 0, 0, 0, 0])
    found, label = one_number(np.array([flat, off, np.eye(3).ravel()]), "gradient_moment1", 2)
    assert (list(found), label) == ([0.0, 5.0, 1.0], "|gradient_moment1 - 1|")
    assert list(one_number(np.eye(3).reshape(1, 9), "gradient_moment1", 3)[0]) == [0.0]


PNG = b"\x89PNG\r\n\x1a\n"


def test_plot_draws_particles_levels_and_energies(tank, humps, tmp_path, command):
    code, out, err = command("plot", tank, "--out", tmp_path / "here")
    assert code == 0, err
    pictures = [tmp_path / "here" / f"{name}.png" for name in ("pressure", "levels", "all")]
    assert out.split() == [str(path) for path in pictures]
    assert sorted((tmp_path / "here").iterdir()) == sorted(pictures)
    before = pictures[0].read_bytes()
    code, out, err = command("plot", tank, "--out", tmp_path / "here", "--snapshot", "0")
    assert code == 0, err
    assert pictures[0].read_bytes() != before
    for path in pictures:
        assert path.read_bytes().startswith(PNG)
    for field in ("speed", "density"):
        code, out, err = command("plot", humps["layer"], "--field", field)
        assert code == 0, err
        picture = humps["layer"] / "figures" / f"{field}.png"
        assert out.split() == [str(picture)]
        assert picture.read_bytes().startswith(PNG)


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_a_flow_without_weight_has_no_still_water_level(tmp_path, monkeypatch, gravity):
    keys = tank_keys(domain={"size": [0.2, 0.3], "gravity": gravity}, time={"end": 0.0})
    keys["numerics"]["c0"], keys["output"] = 20.0, {"snapshots": {"every": 1.0}}
    run(keys, (), tmp_path / "run")
    levels, draw = [], viz.particles
    monkeypatch.setattr(viz, "particles", lambda *arguments, **more: levels.append(arguments[4]) or draw(*arguments, **more))
    plot(tmp_path / "run")
    assert levels == [0.2 if gravity else None]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["analyse", "waves", "{wavy}", "--gauge", "c"], "no level gauge 'c'; one of: level-00, a, b"),
        (["analyse", "waves", "{wavy}", "--start", "9"], "--start: 9 s is after the end of the record; less than 8 s"),
        (["analyse", "waves", "{still}"], "no whole wave is in it"),
        (["analyse", "waves", "{empty}"], "is not the folder of a run"),
        (["analyse", "reflection", "{wavy}", "--gauge", "all"], "no level gauge 'all'"),
        (["analyse", "reflection", "{wavy}", "--gauge", "a", "--gauge", "b"], "(nearly) a multiple of half a wavelength"),
        (["analyse", "reflection", "{wavy}", "--gauge", "a"], "does not suit 1 gauge"),
        (["analyse", "reflection", "{wavy}", "--start", "7.5"], "shorter than a period"),
        (["analyse", "reflection", "{wavy}", "--spectrum", "2", "1"], "make no range"),
        (["analyse", "reflection", "{wavy}", "--periods", "0"], "--periods"),
        (["analyse", "reflection", "{still}"], "--period: is missing; the scene has no wavemaker"),
        (["analyse", "reflection", "{still}", "--period", "0"], "period"),
        (["analyse", "spectrum", "{wavy}", "--start", "7"], "gauge a, record: 0 whole wave(s) in 1 s"),
        (["analyse", "spectrum", "{still}"], "gauge level-00, record: 0 whole wave(s) in 3.98 s"),
        (["analyse", "spectrum", "{wavy}", "--band", "2", "1"], "frequencies: low = 2 Hz and high = 1 Hz make no range"),
        (["analyse", "spectrum", "{wavy}", "--segments", "100"], "do not make 100 segments"),
        (["analyse", "spectrum", "{wavy}", "--json", "nowhere/rows.json"], "nowhere"),
        (["analyse", "spectrum", "{empty}"], "is not the folder of a run"),
        (
            ["analyse", "harmonics", "{still}"],
            "--period: is missing; the scene has no wavemaker that makes waves of one period; the period",
        ),
        (["analyse", "harmonics", "{wavy}", "--period", "9"], "shorter than a period of 9 s"),
        (["analyse", "harmonics", "{wavy}", "--count", "40"], "81 unknowns in each period"),
        (["analyse", "harmonics", "{wavy}", "--json", "nowhere/rows.json"], "nowhere"),
        (["analyse", "harmonics", "{wavy}", "--gauge", "c"], "no level gauge 'c'"),
        (["analyse", "ratio", "{tank}", "{tank}", "{tank}"], "is no shallow water"),
        (["analyse", "ratio", "{hump}", "{hump}", "{hump}"], "the reflecting run equals the infinite one"),
        (["analyse", "energy", "{tank}", "--high", "1"], "--high: '1' is not 2 numbers; as 0,0"),
        (["analyse", "energy", "{tank}", "--low", "a,b"], "--low: 'a,b' is not 2 numbers"),
        (["analyse", "energy", "{hump}", "--low", "1,2"], "--low: '1,2' is not 1 numbers"),
        (["analyse", "energy", "{empty}"], "is not the folder of a run"),
        (["analyse", "nonsense"], "nonsense"),
        (["analyse", "waves", "{wavy}", "--json", "nowhere/rows.json"], "nowhere"),
        (["plot", "{tank}", "--field", "colour"], "--field: no field 'colour' of particles; one of: "),
        (["plot", "{tank}", "--field", "time"], "no field 'time' of particles"),
        (["plot", "{tank}", "--field", "kernel_moment0"], "no field 'kernel_moment0' of particles"),
        (["plot", "{tank}", "--snapshot", "3"], "no snapshot 3; 3 are there"),
        (["plot", "{wavy}"], "no snapshot -1; 0 are there"),
        (["plot", "{empty}"], "is not the folder of a run"),
        (["plot", "{tank}", "--out", "file"], "file"),
    ],
)
def test_bad_questions_end_with_2_and_write_nothing(tank, wavy, humps, tmp_path, monkeypatch, command, arguments, text):
    t = np.arange(0, 4, 0.02)
    keys = {**TANK, "wavemaker": None, "gauges": [{"kind": "level", "x": x} for x in (0.5, 0.6, 0.8)]}
    level = {"time [s]": t, "level [m]": np.full_like(t, DEPTH)}
    still = pretended(tmp_path / "still", keys, {f"level-{k:02d}": level for k in range(3)})
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("a file, no folder")
    folders = {"tank": tank, "wavy": wavy, "hump": humps["infinite"], "still": still, "empty": tmp_path / "empty"}
    monkeypatch.chdir(tmp_path)
    before = {folder: sorted(folder.rglob("*")) for folder in (tmp_path, tank, wavy)}
    code, _, err = command(*(argument.format(**folders) for argument in arguments))
    assert "Traceback" not in err
    assert code == 2, err
    assert text in err
    assert {folder: sorted(folder.rglob("*")) for folder in (tmp_path, tank, wavy)} == before


def test_ratio_is_of_runs_that_end_at_one_time(humps, tmp_path, command):
    """Else the energies of two different moments would be compared."""
    later = run("swe-pulse", [*(f"{k}={v}" for k, v in SHALLOW.items()), "time.end=90.0"], tmp_path / "later").folder
    code, _, err = command("analyse", "ratio", later, humps["reflecting"], humps["infinite"])
    assert code == 2, "no error"
    assert "time" in err
