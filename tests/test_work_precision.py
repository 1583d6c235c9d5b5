"""The study work-precision: its metrics on runs whose errors are known, its rows, its report; all runs are pretended."""

import json
import math
import re

import numpy as np
import pytest
from test_basin_studies import LATTICE, pretended, value

from parsph.flows import StretchingDrop
from parsph.scene.load import load_scene, scene_text
from parsph.scene.presets import PRESETS
from parsph.study.builtin import work_precision
from parsph.study.declare import load_study
from parsph.study.report import write_report
from parsph.study.runner import workspace
from parsph.study.table import StudyTable, read_rows
from parsph.waves import regular_wave, solitary_on_wall

DROP = StretchingDrop((1.2, 1.2), (3.2, 3.2), 1.0, 1000.0)


def table(header, *columns):
    return [header, *(",".join(f"{number:.9g}" for number in row) for row in zip(*columns, strict=True))]


# --- metrics ----------------------------------------------------------------------------------------------------------------


def disc(count=1000):
    """Points that fill the unit circle evenly, a sunflower, with just the second moments of the circle."""
    k = np.arange(count)
    r, angle = np.sqrt((k + 0.5) / count), k * math.pi * (3 - math.sqrt(5))
    points = np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)
    return points / (2 * np.sqrt((points**2).mean(axis=0)))


def test_half_axes_off_by_a_hundredth_are(tmp_path):
    _, *axes = DROP.at(0.75)
    position = DROP.middle + disc() * axes * (1.005, 0.99)
    text = scene_text(load_scene("elliptical-drop", {"numerics.dx": 0.2, "gauges": []}))
    found = pretended(tmp_path, text, [(0.75, position, 0 * position)], {})
    assert value("axes-error", found) == pytest.approx(-1.0, abs=0.02)


def test_energy_is_over_that_of_the_beginning(tmp_path):
    header = "time [s],mass [kg],kinetic energy [J],potential energy [J],compressible energy [J]"
    energy = table(header, [0.0, 1.0], [1.0, 1.0], [8.0, 7.0], [1.5, 1.5], [0.5, 1.3])
    text = scene_text(load_scene("square-patch", {"numerics.dx": 0.2, "gauges": [{"kind": "energy"}]}))
    assert value("energy-change", pretended(tmp_path, text, (), {}, {"energy-00": energy})) == pytest.approx(-2.0)


@pytest.mark.parametrize(("height", "stretch", "late"), [(1.0, 1.0, 0.7), (0.95, 1.0, 0.0), (1.0, 1.02, 0.0)])
def test_waves_are_compared_with_the_steady_one_asked_for(tmp_path, height, stretch, late):
    """A phase that all gauges share is no error; a lower wave is, and one of another length as well."""
    case = work_precision.CASES["waves"]
    scene = load_scene(case.scene, {**case.settings, "numerics.dx": 0.1})
    wave, t = regular_wave(0.05, 0.5, 9.81, period=scene.wave_period), np.arange(0.0, scene.time.end, 0.02)
    places = [gauge.x for gauge in scene.gauges]
    tables = {
        f"level-{n:02d}": table("time [s],level [m]", t, 0.5 + height * wave.elevation(x / stretch, t - late))
        for n, x in enumerate(places)
    }
    error = value("wave-error", pretended(tmp_path, scene_text(scene), (), {}, tables))
    turns = np.exp(1j * wave.wavenumber * np.array(places) * (1 - 1 / stretch))
    expected = 100 * math.sqrt(np.mean(np.abs(height * turns * np.exp(-1j * np.angle(turns.sum())) - 1) ** 2))
    assert error == pytest.approx(expected, abs=0.02)
    assert (expected > 3.0) == (height != 1.0 or stretch != 1.0)


def test_run_up_is_over_that_of_potential_flow(tmp_path):
    top = 0.25 + 0.98 * 0.25 * solitary_on_wall(0.2).runup
    record = table("time [s],run-up z [m],shoreline x [m],distance [m]", [0.0, 1.0], [0.25, top], [5.5, 5.5], [0.0, 0.0])
    case = work_precision.CASES["solitary"]
    text = scene_text(load_scene(case.scene, {**case.settings, "numerics.dx": 0.05}))
    assert value("runup-error", pretended(tmp_path, text, (), {}, {"runup-00": record})) == pytest.approx(-2.0)


def test_other_runs_have_no_such_numbers(tmp_path):
    found = pretended(tmp_path, scene_text(load_scene("still", {"gauges": []})), [(0.0, LATTICE, 0 * LATTICE)], {})
    for name in ("axes-error", "wave-error", "runup-error"):
        assert math.isnan(value(name, found))


# --- the study --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("quick", "count"), [(True, 3 * 18), (False, 3 * 18 + 12 * 13)])
def test_rows_are_counted_and_load(quick, count):
    study = load_study("work-precision", quick)
    scenes = study.scenes()
    assert len(study.rows) == len(scenes) == count
    assert {scene.numerics.preset for scene in scenes.values()} == set(PRESETS)


def test_changes_are_one_at_a_time():
    """All but one or two keys of `numerics` are those of the standard preset; flows without a depth change their c0 itself."""
    scenes = load_study("work-precision").scenes()
    for name, scene in scenes.items():
        group, _, per = name.partition("_")[0], *name.rpartition("_")[1:]
        if not group.endswith("-changes"):
            continue
        standard = scenes[f"{group.removesuffix('-changes')}_standard_{per}"].numerics.model_dump()
        changed = {key for key, number in scene.numerics.model_dump().items() if number != standard[key]}
        assert 1 <= len(changed) <= 2, (name, changed)
    speeds = [scenes[f"drop-changes_{change}_25"].c0 / 15.0 for change in ("c0-1.5", "1.5-c0")]
    assert speeds == pytest.approx([2 / 3, 1.5])


def test_presets_and_changes_are_reported(tmp_path, monkeypatch):
    """Errors of a drop: 4 % over the square of the resolution for draft, half of that for standard, and one row failed."""
    monkeypatch.setattr(work_precision, "CASES", {"drop": work_precision.CASES["drop"]})
    monkeypatch.setattr(work_precision, "METRICS", ("axes-error", "work"))
    study = load_study("work-precision")
    place = workspace(study, tmp_path / "out", False)
    _, *axes = DROP.at(0.75)
    for row in study.rows:
        folder, text = place.run_folder(row), place.scene(row).read_text()
        if row.labels["numerics"] == "accurate" and row.labels["per"] == "100":
            pretended(folder, text)
            place.fail(row, "no time is named", 1)
            continue
        fine = int(row.labels["per"]) / 25
        error = 0.04 / fine**2 * (1.0 if row.labels["numerics"] == "draft" else 0.5)
        position = DROP.middle + disc() * axes * (1.0, 1.0 + error)
        pretended(folder, text, [(0.75, position, 0 * position)], {"cpu [s]": 3.0 * fine**3})
    found = StudyTable(study, place)
    text = write_report(study, found).read_text(encoding="utf-8")
    found.write()
    assert "| Stretching drop | 25 | +3.99 %, 3 s | +1.99 %, 3 s | +1.99 %, 3 s |" in text
    assert "| Stretching drop | 100 | +0.24 %, 192 s | +0.115 %, 192 s | none |" in text
    assert re.search(r"\| Stretching drop \| 25 \| 0\.(5|49)\d* \| 1 \| 0\.2[45]\d* \| 8 \|", text)
    assert "| h/dx 2.5 | 1, 1 |" in text
    assert set(re.findall(r"figures/(.*)\.png", text)) == {"drop-work", "drop-wall"}
    rows = [{name: number if isinstance(number, str) else float(number) for name, number in row.items()} for row in found.rows]
    assert json.dumps(read_rows(tmp_path / "out" / "results.csv"), sort_keys=True) == json.dumps(rows, sort_keys=True)
