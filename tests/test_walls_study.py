"""The study `walls`, its metrics and the measured records; most of its runs are pretended, the real ones have 200 particles."""

import itertools
import json
import math
import re

import numpy as np
import pytest

from parsph.errors import SceneError
from parsph.io.results import Results
from parsph.io.tables import Table
from parsph.measured import measured, measured_names
from parsph.run import run
from parsph.scene.load import load_scene, scene_text
from parsph.study.declare import load_study
from parsph.study.metrics import METRICS, arrival, plateau_of
from parsph.study.report import write_report
from parsph.study.runner import workspace
from parsph.study.table import StudyTable
from parsph.walls import INTERPOLATORS

WALLS = [*INTERPOLATORS, "mirror"]
HEAD = 1000.0 * 9.81 * 0.3  # rho0 g H of the still tank [Pa]
EXACT = {"P0": 1.0, "P1": 2 / 3, "P2": 1 / 3, "P3": 1 / 6}  # of it
ENERGIES = ("kinetic energy [J]", "potential energy [J]", "compressible energy [J]")
SUMMARY = {
    "particles": 500,
    "steps": 100,
    "evaluations": 50500,
    "ranks": 1,
    "wall [s]": 10.0,
    "cpu [s]": 5.0,
    "phases [s]": {
        "sweep": [3.0, 4.0, 5.0],
        "ghosts": [0.5, 1.5, 2.5],
        "barrier": [0.5, 0.5, 0.5],
        "gauges": [1.0, 1.0, 1.0],
        "snapshots": [0.75, 0.75, 0.75],
        "log": [0.25, 0.25, 0.25],
    },
}


def text_of(name, overrides=None):
    """Return what a run of this scene would write as scene.json."""
    return scene_text(load_scene(name, overrides))


def pretended(folder, text, tables, **summary):
    """Return the results of a finished run with this scene.json and these gauge tables ({name: {header: values}})."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.json").write_text(text)
    (folder / "summary.json").write_text(json.dumps({**SUMMARY, **summary}))
    for name, columns in tables.items():
        table = Table(folder / "gauges" / f"{name}.csv", list(columns))
        for row in zip(*columns.values(), strict=True):
            table.add(row)
        table.close()
    return Results(folder)


def pressures(t, values):
    """Return the table of a pressure gauge, of values over `HEAD`."""
    return {"time [s]": t, "pressure [Pa]": HEAD * (values + 0.0 * t)}


def energies(kinetic, potential, compressible):
    columns = [np.array(values, float) for values in (kinetic, potential, compressible)]
    return {"time [s]": 0.1 * np.arange(len(kinetic)), **dict(zip(ENERGIES, columns, strict=True))}


def value(name, results):
    return METRICS[name].measure(results, {})


# --- declared -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("quick", "still", "dam"),
    [(False, ("0.02", "0.01", "0.005"), ("0.0156", "0.0078")), (True, ("0.02", "0.01"), ("0.02",))],
)
def test_rows_are_all_walls_at_all_spacings(quick, still, dam):
    study = load_study("walls", quick)
    spacings = {"still": still, "dam": dam}
    rows = [f"{group}_{wall}_{dx}" for group in spacings for wall, dx in itertools.product(WALLS, spacings[group])]
    assert [row.name for row in study.rows] == rows
    scenes = study.scenes()
    ends = {"still": 4.0 if quick else 35.0, "dam": 1.5 if quick else 2.5}
    for row in study.rows:
        scene, wall = scenes[row.name], row.labels["walls"]
        assert scene.numerics.dx == float(row.labels["dx"])
        assert scene.time.end == scene.snapshot_interval == ends[row.group]
        (force,) = [gauge for gauge in scene.gauges if gauge.kind == "force"]
        if wall == "mirror":
            assert not scene.walls.polygons
            assert force.wall == "right"
            assert scene.walls.left and scene.walls.right and scene.walls.bottom and not scene.walls.top  # noqa: PT018
        else:
            assert scene.walls.interpolation == wall
            assert force.wall in scene.wall_names
        base = load_scene(row.base)
        assert [gauge.kind for gauge in scene.gauges] == [gauge.kind for gauge in base.gauges]
        assert scene.numerics.model_dump(exclude={"dx"}) == base.numerics.model_dump(exclude={"dx"})


def test_no_axis_is_called_like_another_column():
    study = load_study("walls")
    assert not set(study.axes) & {"row", "group", "status", "cpu", "wall", *study.metrics}


def test_columns_of_the_study_are_metrics_with_a_description():
    for name in load_study("walls").metrics:
        assert METRICS[name].description.endswith(".")


# --- metrics --------------------------------------------------------------------------------------------------------------


def test_probes_are_compared_with_still_water(tmp_path):
    """2 % at P0 and -1 % at P3 once settled, 3 % at P1 in the first second, and something between that does not count."""
    scene = text_of("still-tank", {"time.end": 12.0})
    t = np.linspace(0.0, 12.0, 121)
    early, settled = t < 1.001, t > 4.999
    off = {"P0": 0.02 * settled, "P1": 0.03 * early, "P2": 0.5 * (~early & ~settled), "P3": -0.01 * settled}
    results = pretended(tmp_path, scene, {name: pressures(t, EXACT[name] + off[name]) for name in EXACT})
    assert value("probe-error", results) == pytest.approx(math.sqrt((4.0 + 1.0) / 4))
    assert value("probe-error-largest", results) == pytest.approx(2.0)
    assert value("probe-error-early", results) == pytest.approx(math.sqrt(9.0 / 4))


def test_short_runs_count_from_half_of_them_on(tmp_path):
    scene = text_of("still-tank", {"time.end": 4.0})
    t = np.linspace(0.0, 4.0, 41)
    tables = {name: pressures(t, exact + np.where(t > 1.999, 0.01, 0.1)) for name, exact in EXACT.items()}
    results = pretended(tmp_path, scene, tables)
    assert value("probe-error", results) == pytest.approx(1.0)
    assert value("probe-error-largest", results) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("kinetic", "potential", "compressible", "growth"),
    [
        ([0, 3, 2, 1], [100, 97, 96, 95], [0, 0, 0, 0], 0.0),  # it only falls
        ([0, 1, 1, 1], [100, 95, 98, 96], [4, 3, 2, 2], 0.02),  # 104, 99, 101, 99
        ([0, 1, 2, 1], [100, 95, 93, 96], [0, 0, 3, 4], 0.05),  # 100, 96, 98, 101: over several samples
    ],
)
def test_energy_grows_from_any_sample_to_any_later_one(tmp_path, kinetic, potential, compressible, growth):
    scene = text_of("still-tank")
    results = pretended(tmp_path, scene, {"energy-04": energies(kinetic, potential, compressible)})
    assert value("energy-growth", results) == pytest.approx(growth)
    assert value("rest-energy", results) == pytest.approx(kinetic[-1] / potential[-1])


def test_costs_are_those_of_steps_alone(tmp_path):
    """8 of 10 s are steps, of which 2 on walls; half of the wall time is CPU time; 50,000 particles times steps."""
    results = pretended(tmp_path / "ghosts", text_of("still-tank"), {})
    assert value("wall-cost", results) == pytest.approx(0.25)
    assert value("step-cost", results) == pytest.approx(4.0 / 50000 * 1e6)
    phases = {name: SUMMARY["phases [s]"][name] for name in ("sweep", "gauges", "snapshots", "log")}
    results = pretended(tmp_path / "mirror", text_of("still-tank"), {}, **{"phases [s]": phases})
    assert value("wall-cost", results) == 0.0
    assert value("step-cost", results) == pytest.approx(80.0)


def test_polygon_walls_tell_contacts_and_other_methods(tmp_path):
    scene = text_of("still-tank", {"walls.interpolation": "mls2"})
    told = {"ghosts": 120, "methods per evaluation": {"dry": 20.0, "mls2": 90.0, "mls1": 8.0, "normalised": 2.0}, "stopped": 7}
    results = pretended(tmp_path / "told", scene, {}, walls=told)
    assert value("stopped", results) == 7
    assert value("fallbacks", results) == pytest.approx(0.1)
    results = pretended(tmp_path / "dry", scene, {}, walls={**told, "methods per evaluation": {"dry": 120.0}})
    assert value("fallbacks", results) == 0.0
    results = pretended(tmp_path / "untold", scene, {})
    assert value("stopped", results) == value("fallbacks", results) == 0.0


def test_the_plateau_begins_after_the_arrival(tmp_path):
    """The front arrives at 1 s; 0.5 up to 1.6 s and 0.7 from then on, a fifth of the stretch from 1.2 to 1.7 s."""
    scene = text_of("dam-break-small")
    t = np.arange(0.0, 2.4999, 0.002)
    p = np.where(t < 0.999, 0.05, np.where(t < 1.199, 3.0, np.where(t < 1.599, 0.5, 0.7)))
    results = pretended(tmp_path, scene, {"P1": pressures(t, 2.0 * p)})  # twice as deep as the still tank
    assert arrival(t, p) == pytest.approx(1.0)
    assert value("plateau", results) == pytest.approx((0.4 * 0.5 + 0.1 * 0.7) / 0.5, abs=2e-3)
    assert plateau_of(t[t < 1.599], p[t < 1.599], 1.0) == pytest.approx(0.5)
    assert math.isnan(plateau_of(t[t < 1.199], p[t < 1.199], 1.0))
    assert math.isnan(arrival(t, 0.0 * p))
    for name in ("probe-error", "probe-error-early", "probe-error-largest"):
        assert math.isnan(value(name, results))  # no gauge begins in the water


def test_still_water_has_no_plateau(tmp_path):
    t = np.linspace(0.0, 2.0, 201)
    results = pretended(tmp_path, text_of("still-tank"), {name: pressures(t, exact) for name, exact in EXACT.items()})
    assert math.isnan(value("plateau", results))


@pytest.mark.parametrize("metric", ["probe-error", "plateau"])
def test_pressures_need_gauges(metric):
    with pytest.raises(SceneError, match=f"metric {metric}: needs a gauge of pressure"):
        METRICS[metric].check(load_scene("still-tank", {"gauges": [{"kind": "energy"}]}))


# --- runs -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wall", ["hydrostatic", "mirror"])
def test_a_row_that_really_runs_has_its_numbers(tmp_path, wall):
    row = next(row for row in load_study("walls", True).rows if row.name == f"still_{wall}_0.02")
    smaller = {"numerics.dx": 0.03, "numerics.diffusion": "fourtakas", "time.end": 0.05}  # there is less of it to compile
    finished = run(row.base, {**row.overrides, **smaller}, tmp_path / "out")
    results = Results(finished.folder)
    assert results.summary["particles"] == 200
    assert 0 < value("probe-error", results) <= value("probe-error-largest", results) < 2.0
    assert 0 < value("probe-error-early", results) < 2.0
    assert 0 < value("rest-energy", results) < 1e-3
    assert 0 <= value("energy-growth", results) < 1e-3
    assert (0 < value("wall-cost", results) < 1) if wall == "hydrostatic" else (value("wall-cost", results) == 0)
    assert 0 < value("step-cost", results) < 1e6 * results.summary["cpu [s]"] / 200
    assert value("stopped", results) >= 0
    assert 0 <= value("fallbacks", results) <= 1


def of_still_water(row, k):
    """Tables of a still row: the k-th wall is wrong by k + 1 times 0.1 % at dx = 0.02, half as much at 0.01."""
    t = np.linspace(0.0, 4.0, 81)
    error = 1e-3 * (k + 1) * float(row.labels["dx"]) / 0.02
    tables = {name: pressures(t, exact + error * np.sign(np.sin(9 * t + 1))) for name, exact in EXACT.items()}
    return {**tables, "energy-04": energies([0.0, 1e-7 * 4**k], [1.0, 1.0], [0.0, 0.0])}


def of_dam_break(k):
    """Tables of a dam-break row: the k-th wall is late by 0.01 k s and stays at 0.56 + 0.01 k."""
    t = np.arange(0.0, 2.5, 0.01)
    level = np.where(t > 0.6 + 0.01 * k, 0.56 + 0.01 * k, 0.0)
    return {"P1": pressures(t, 2.0 * level), "energy-02": energies([0.0, 1.0], [10.0, 9.5], [0.0, 0.0])}


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """The folder of a study whose rows are pretended, but one that failed, and the report's text.

    The k-th wall needs 2 + k CPU s: 0.8 of that, and of the time of steps, walls take a quarter.
    """
    study = load_study("walls", True)
    place = workspace(study, tmp_path_factory.mktemp("walls") / "out", False)
    for row in study.rows:
        k = WALLS.index(row.labels["walls"])
        if row.name == "dam_mirror_0.02":
            place.fail(row, "particle 3 crossed the bottom wall", 1)
            continue
        tables = of_still_water(row, k) if row.group == "still" else of_dam_break(k)
        pretended(place.run_folder(row), place.scene(row).read_text(), tables, **{"cpu [s]": 2.0 + k})
    text = write_report(study, StudyTable(study, place)).read_text(encoding="utf-8")
    return place.folder, text


def test_the_report_has_its_tables_and_figures(told):
    folder, text = told
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)
    names = ["fig-3", "error-dx", "error-cost", "fig-4", "fig-7", "fig-9"]
    assert pictures == [f"figures/{name}.png" for name in names]
    assert sorted(path.stem for path in folder.glob("figures/*.png")) == sorted(names)
    for wall in WALLS:
        for dx in ("0.02", "0.01"):
            assert f"| {wall} | {dx} | finished |" in text
    assert "| mirror | 0.02 | failed |" in text
    assert "Not finished: mirror at dx = 0.02 m." in text
    assert "`dam_mirror_0.02`: particle 3 crossed the bottom wall" in text
    assert "## Not measured" not in text


def test_the_report_ranks_what_was_measured(told):
    """Errors and costs rise in the order of the walls, plateaus move away from the measured one."""
    _, text = told
    ranked = ", ".join(f"{wall} {0.05 * (k + 1):.3g} %" for k, wall in enumerate(WALLS))
    assert f"- dx = 0.01 m: {ranked}; within 0.5 %: {', '.join(WALLS)}." in text
    assert f"within 0.5 %: {', '.join(WALLS[:5])}. In the first second" in text  # at dx = 0.02 m
    assert f"within 1e-06: {', '.join(WALLS[:2])}." in text
    ratios = ", ".join(f"{wall} {(k + 1) / 3:.2f}" for k, wall in enumerate(WALLS))
    assert f"Errors over that of mls2: {ratios}." in text
    speeds = ", ".join(f"{wall} {4 / (2 + k):.2f}" for k, wall in enumerate(WALLS))
    assert f"Speed-up over mls2 at dx = 0.01 m, the fastest first: {speeds}; of the work at walls alone: {speeds}." in text
    plateaus = re.search(r"difference from the measured one, the smallest first: (.*)\.", text).group(1)
    assert re.findall(r"([a-z]+\d?) [\d.]+%", plateaus) == WALLS[:-1]
    late = re.search(r"before it\): (.*?)\. Plateau", text).group(1)
    seconds = [float(x) for x in re.findall(r"([+-]\d\.\d+) s", late)]
    np.testing.assert_allclose(np.diff(seconds), 0.01, atol=1.1e-3)


# --- measured -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "columns", "count", "first"),
    [
        ("buchner_p1", ["t_star", "p_star"], 86, (0.055, 0.0)),
        ("koshizuka_oka_exp", ["T", "x_over_L"], 9, (0.0, 1.0)),
        ("martin_moyce_n2_2_a2.25in", ["T", "Z"], 15, (0.832, 1.217)),
        ("martin_moyce_n2_2_a1.125in", ["T", "Z"], 10, (0.849, 1.245)),
    ],
)
def test_measured_records_are_read(name, columns, count, first):
    record = measured(name)
    assert list(record) == columns
    assert tuple(values[0] for values in record.values()) == first
    for values in record.values():
        assert values.shape == (count,)
        assert np.isfinite(values).all()
    assert (np.diff(record[columns[0]]) > 0).all()


def test_a_record_that_is_not_there():
    assert len(measured_names()) == 4
    with pytest.raises(SceneError, match=r"no measured record 'buchner'; did you mean 'buchner_p1'.*koshizuka_oka_exp"):
        measured("buchner")
