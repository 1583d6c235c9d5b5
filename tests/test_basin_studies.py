"""The studies of basins and walls and their metrics; most of their runs are pretended."""

import json
import math
import re

import h5py
import numpy as np
import pytest

from parsph.analysis import oscillation
from parsph.errors import SceneError
from parsph.io.results import Results
from parsph.scene.load import load_scene, scene_text
from parsph.study.builtin import deficiency
from parsph.study.declare import load_study
from parsph.study.metrics import METRICS
from parsph.study.report import write_report
from parsph.study.runner import workspace
from parsph.study.table import StudyTable
from parsph.waves import Seiche

THEORY = Seiche(0.2, 0.2, 0.005, 9.81)
PERIOD = 2 * math.pi / THEORY.frequency
SUMMARY = {
    "particles": 100,
    "steps": 50,
    "evaluations": 5000,
    "ranks": 1,
    "wall [s]": 4.0,
    "cpu [s]": 3.0,
    "phases [s]": {"sweep": [2.0, 2.0, 2.0], "markers": [1.0, 1.0, 1.0]},
}
LATTICE = np.stack(np.meshgrid(0.01 + 0.02 * np.arange(10), 0.01 + 0.02 * np.arange(10)), axis=-1).reshape(-1, 2)


def in_space(vectors):
    return np.concatenate([vectors, np.zeros((len(vectors), 1))], axis=1)


def pretended(folder, text, shots=(), summary=None, tables=None):
    """Return the results of a run with this scene.json and snapshots, (time, position, velocity) each."""
    (folder / "snapshots").mkdir(parents=True, exist_ok=True)
    (folder / "gauges").mkdir(exist_ok=True)
    (folder / "scene.json").write_text(text)
    if summary is not None:
        (folder / "summary.json").write_text(json.dumps({**SUMMARY, **summary}))
    for name, lines in (tables or {}).items():
        (folder / "gauges" / f"{name}.csv").write_text("\n".join(lines) + "\n")
    for number, (time, position, velocity) in enumerate(shots):
        with h5py.File(folder / "snapshots" / f"{number:06d}.vtkhdf", "w") as file:
            root = file.create_group("VTKHDF")
            root["Points"] = in_space(position)
            count = len(position)
            fields = {"id": np.arange(count), "velocity": in_space(velocity), "density": np.full(count, 1000.0)}
            for name, values in {**fields, "pressure": np.zeros(count)}.items():
                root[f"PointData/{name}"] = values
            file.create_group("parsph").attrs["time [s]"] = time
    return Results(folder)


def seiche_text(**overrides):
    return scene_text(load_scene("seiche", {"numerics.dx": 0.02, "time.end": 2 * PERIOD, "gauges": [], **overrides}))


def waves(frequency=THEORY.frequency, rate=0.0, sink=0.0, periods=2, amplitude=1.0):
    """Snapshots of a standing wave, 20 a period; its lowest row has sunk by `sink` [m] at the end."""
    shots = []
    for t in np.arange(0.0, periods * PERIOD + 1e-9, PERIOD / 20):
        share = amplitude * math.exp(-rate * t) * math.cos(frequency * t)
        position = LATTICE.copy()
        position[:10, 1] -= sink * (t > 0)
        shots.append((t, position, share * THEORY.velocity(position)))
    return shots


def value(name, results):
    return METRICS[name].measure(results, {})


# --- the oscillation -------------------------------------------------------------------------------------------------------


def test_an_oscillation_is_recovered():
    t = np.linspace(0.0, 3.0, 200)
    found = oscillation(t, 0.9 * np.exp(-0.3 * t) * np.cos(12.1 * t + 0.2), 12.39)
    assert (found.amplitude, found.rate, found.frequency, found.phase) == pytest.approx((0.9, 0.3, 12.1, 0.2), rel=1e-6)
    assert found.loss == pytest.approx(1 - math.exp(-0.3 * 2 * math.pi / 12.1))


def test_less_than_a_period_is_no_oscillation():
    t = np.linspace(0.0, 0.3, 20)
    with pytest.raises(SceneError, match="shorter than a period"):
        oscillation(t, np.cos(12.39 * t), 12.39)


def test_the_mode_is_all_there_at_the_beginning():
    assert THEORY.share(LATTICE, THEORY.velocity(LATTICE)) == pytest.approx(1.0)
    assert THEORY.share(LATTICE, -0.3 * THEORY.velocity(LATTICE)) == pytest.approx(-0.3)


# --- metrics ----------------------------------------------------------------------------------------------------------------


def test_a_wave_has_its_frequency_loss_and_error(tmp_path):
    found = pretended(tmp_path, seiche_text(), waves(0.99 * THEORY.frequency, 0.05), {})
    assert value("frequency-error", found) == pytest.approx(-1.0, abs=1e-4)
    assert value("loss-per-period", found) == pytest.approx(100 * (1 - math.exp(-0.05 * PERIOD / 0.99)), rel=1e-3)
    assert 1.0 < value("velocity-error", found) < 20.0


def test_velocities_off_by_a_tenth_are_off_by_a_tenth(tmp_path):
    assert value("velocity-error", pretended(tmp_path, seiche_text(), waves(amplitude=0.9), {})) == pytest.approx(10.0)


def test_runs_without_a_seiche_have_no_such_numbers(tmp_path):
    shots = [(0.0, LATTICE, 0.0 * LATTICE), (2.0, LATTICE, 0.0 * LATTICE)]
    found = pretended(tmp_path, scene_text(load_scene("still", {"gauges": []})), shots, {})
    for name in ("frequency-error", "loss-per-period", "velocity-error"):
        assert math.isnan(value(name, found))


def test_the_lowest_row_is_that_of_the_beginning(tmp_path):
    found = pretended(tmp_path, seiche_text(), waves(sink=0.004), {})
    assert value("lowest-row", found) == pytest.approx(0.3)


def test_particles_behind_walls_are_counted(tmp_path):
    """Three in the second snapshot, one in the last; one that stands in the line of a wall is not behind it."""
    shots = waves(periods=0.15)
    shots[1][1][:3, 0] = -0.001
    shots[-1][1][7] = 0.1, -0.002
    shots[-1][1][8] = 0.2, 0.1
    found = pretended(tmp_path / "a", seiche_text(), shots, {})
    assert len(shots) == 4
    assert value("penetrations", found) == 3
    assert value("leaks", found) == 1
    found = pretended(tmp_path / "b", seiche_text(), shots, {"walls": {"exchanged": {"left": 5, "bottom": 12}}})
    assert value("penetrations", found) == 17


def test_speed_at_rest_is_over_that_of_sound(tmp_path):
    text = scene_text(load_scene("tank-ellipse"))
    table = ["time [s],mass [kg],kinetic energy [J]", "0.0,5000.0,0.0", "0.5,5000.0,10.0"]
    found = pretended(tmp_path, text, (), {}, {"energy-00": table})
    assert value("rest-speed", found) == pytest.approx(math.sqrt(2 * 10.0 / 5000.0))  # c0 is 1 m/s


def test_markers_are_part_of_what_walls_cost(tmp_path):
    assert value("wall-cost", pretended(tmp_path, seiche_text(), (), {})) == pytest.approx(0.25)


# --- declared -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "quick", "count"),
    [
        ("seiche", True, 27),
        ("seiche", False, 55),
        ("deficiency", True, 28),
        ("deficiency", False, 29),
        ("wall-treatments", True, 38),
        ("wall-treatments", False, 86),
    ],
)
def test_rows_are_counted_and_load(name, quick, count):
    study = load_study(name, quick)
    assert len(study.rows) == count
    assert len({row.name for row in study.rows}) == count
    scenes = study.scenes()
    assert set(scenes) == {row.name for row in study.rows}
    assert not set(study.axes) & {"row", "group", "status", "reached", "cpu", "wall", *study.metrics}


def test_groups_have_metrics_of_their_own():
    study = load_study("wall-treatments", True)
    by_group = {row.group: study.metrics_of(row) for row in study.rows}
    assert "plateau-error" in by_group["dam"]
    assert "probe-error" not in by_group["dam"]
    assert all("leaks" in metrics for metrics in by_group.values())
    walls = load_study("walls", True)
    assert all(walls.metrics_of(row) == walls.metrics for row in walls.rows)


# --- reports -----------------------------------------------------------------------------------------------------------


def reported(name, folder, fill):
    """Return the report of a quick study whose rows `fill`(row, folder, scene.json) pretends."""
    study = load_study(name, True)
    place = workspace(study, folder / "out", False)
    for row in study.rows:
        fill(place, row, place.scene(row).read_text())
    text = write_report(study, StudyTable(study, place)).read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^\]]*\]\(figures/([^)]+)\.png\)", text)
    assert sorted(pictures) == sorted(path.stem for path in (folder / "out" / "figures").glob("*.png"))
    return text, pictures


def test_the_seiche_is_reported_with_rows_that_failed(tmp_path):
    """Corrected kernels fail after three snapshots; the strip sinks, and the mirrors of the paper count exchanges."""

    def fill(place, row, text):
        folder = place.run_folder(row)
        if "corrected" in row.group:
            pretended(folder, text, waves(periods=0.1))
            place.fail(row, "particle 3 crossed the bottom wall at t = 0.061 s: position", 1)
        else:
            wave = {"sink": 0.005 * (row.labels["walls"] == "strip"), "amplitude": 0.95}
            pretended(folder, text, waves(**wave, periods=2.5 if row.group.startswith("paper") else 1.1), {})

    text, pictures = reported("seiche", tmp_path, fill)
    assert pictures[:4] == ["fig-3", "fig-4-3d", "fig-4-4d", "fig-4-5d"]
    assert {"fig-5-0.02", "fig-5-0.01", "velocity-cost", "frequency-cost", "loss-cost", "amplitudes"} < set(pictures)
    assert "| failed | 0.061 |" in text
    assert "Within 0.6 % of frequency and 1.5 % of loss per period: " in text


def test_wall_treatments_tell_how_far_rows_got(tmp_path):
    energy = ["time [s],mass [kg],kinetic energy [J],potential energy [J],compressible energy [J]"]
    energy += ["0.0,100.0,0.0,10.0,0.0", "1.0,100.0,0.1,9.0,0.0"]
    pressure = ["time [s],pressure [Pa]", *(f"{t:.3f},{3000 * (t > 0.5)}" for t in np.arange(0.0, 3.0, 0.02))]

    def fill(place, row, text):
        folder, keys = place.run_folder(row), json.loads(text)
        names = {gauge["name"] or f"energy-{number:02d}": gauge["kind"] for number, gauge in enumerate(keys["gauges"])}
        tables = {name: energy if kind == "energy" else pressure for name, kind in names.items()}
        corner = 2.0, 1.0
        shots = waves(periods=3) if row.group == "seiche" else [(1.0, LATTICE + np.array(corner) - 0.1, 0.0 * LATTICE)]
        if row.labels["walls"] == "strip":
            pretended(folder, text, shots[:3])
            place.fail(row, "no time is named", 1)
        else:
            pretended(folder, text, shots, {}, tables)

    text, pictures = reported("wall-treatments", tmp_path, fill)
    assert set(pictures) == {"still-cost", "seiche-cost", "dam-cost", "ellipse-cost"}
    assert text.count("Failed, and the time reached: strip at dx") == 4
    assert "strip at dx = 0.03 m: 1 s" in text
    assert text.count("Accelerations at the beginning") == 2


COARSE = {
    "column-1d": {},
    "column": {"numerics.dx": 0.25, "numerics.h_over_dx": 1.5},
    "tank-rectangle": {"numerics.dx": 0.2, "numerics.h_over_dx": 1.5},
    "tank-ellipse": {"numerics.dx": 0.15, "numerics.h_over_dx": 1.5},
    "bulging-wall": {"numerics.dx": 0.025},
}


def test_the_deficiency_is_reported(tmp_path, monkeypatch):
    """Its accelerations are worked out on coarse scenes."""
    real = deficiency.residual_accelerations
    monkeypatch.setattr(deficiency, "load_scene", lambda name, keys=None: load_scene(name, {**(keys or {}), **COARSE[name]}))

    def coarse(scene, keys=None):
        return real(scene, {**(keys or {}), **COARSE[scene]} if isinstance(scene, str) else keys)

    monkeypatch.setattr(deficiency, "residual_accelerations", coarse)
    energy = ["time [s],kinetic energy [J],potential energy [J],compressible energy [J]", "0.0,0.0,9.0,0.0", "1.0,0.1,9.0,0.0"]

    def fill(place, row, text):
        table = {} if row.group in COARSE and row.group != "bulging-wall" else {"energy-00": energy}
        pretended(place.run_folder(row), text, [(1.0, LATTICE + 0.15, 0.0 * LATTICE)], {}, table)

    text, pictures = reported("deficiency", tmp_path, fill)
    figures = ["fig-3", "fig-4", "fig-5", "fig-6", "fig-7", "fig-7-strengths", "fig-8", "fig-8-strengths"]
    assert pictures == [*figures, "still-energy", "bulging-wall"]
    assert re.search(r"the strengths of jones2010 have \d+ dips", text)
    assert "| tank-ellipse | strip |" in text


def test_weights_of_markers_are_shares():
    """With alike normals they add up to 1, and beyond the reach of all markers they are 0."""
    markers = np.array([[-0.25, 0.0], [0.0, 0.0], [0.25, 0.0]])
    shares = deficiency._shares(np.array([[0.1, 0.3], [0.0, 0.6], [3.0, 0.0]]), markers, np.array([[0.0, 1.0]] * 3))
    np.testing.assert_allclose(shares.sum(axis=1), [1.0, 1.0, 0.0])
    assert shares[0, 1] > shares[0, 0]
    assert shares[1, 0] == pytest.approx(shares[1, 2])
