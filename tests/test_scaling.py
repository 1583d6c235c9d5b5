"""Scaling as a user types it: `parsph plan --ranks` and `parsph bench --scaling`."""

import csv
import json
import os
import re

import numpy as np
import pytest
from helpers import parsph, settings, tank, why_no_mpi

from parsph.parallel import Communicator
from parsph.particles import FIRST_FIXED, FIRST_GHOST, Layout
from parsph.scaling import FORMS, ranks_of, scaling
from parsph.scene.build import build
from parsph.scene.forecast import census, forecast
from parsph.scene.load import load_scene

needs_mpi = pytest.mark.skipif(bool(why_no_mpi()), reason=why_no_mpi() or "mpi is there")


def test_plan_tells_what_ranks_need_up_to_the_largest_number(tmp_path):
    result = parsph("plan", "pool", "--ranks", "4096", *settings(numerics__dx=0.1), cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    most = int(re.search(r"at most (\d+) ranks", result.stdout)[1])
    shown = [int(number) for number in re.findall(r"^│ +([\d,]+) │ +[\d.]+ │ +[\d.]+ │", result.stdout, re.MULTILINE)]
    assert shown == [1, 2, 4, 8, 16, most][: len(shown)]
    assert shown[-1] == most < 4096
    scene = load_scene("pool", {"numerics.dx": 0.1})
    size = Layout(scene.dim, scene.features).bytes_per_particle()
    assert re.search(rf"^│ all .*│ {size} +│", result.stdout, re.MULTILINE)
    assert result.stdout.count("assumed: ") > 4


def test_plan_without_ranks_is_as_short_as_before(tmp_path):
    assert "assumed" not in parsph("plan", "pool", cwd=tmp_path).stdout


@pytest.mark.parametrize(
    ("features", "size"),
    [({"diffusion": "antuono"}, 256), ({"integrator": "midpoint"}, 240), ({"diffusion": "fourtakas"}, 208)],
)
def test_memory_of_a_particle_is_told_by_field(tmp_path, features, size):
    """The parts make up the whole, what a pass beside the sweep keeps included."""
    keys = settings(**{f"numerics__{name}": value for name, value in features.items()}, time__cfl=0.3)
    result = parsph("plan", "seiche", "--ranks", "1", *keys, cwd=tmp_path)
    table = result.stdout[result.stdout.index("memory of a particle") :]
    rows = re.findall(r"^│ (.+?) +│.*│ +(\d+) +│$", table, re.MULTILINE)
    *parts, (name, whole) = [(name, int(number)) for name, number in rows]
    assert (name, whole) == ("all", size)
    assert sum(number for _, number in parts) == whole
    assert all(number > 0 for _, number in parts)


BASIN = {
    "domain": {"size": [0.3, 0.2, 0.2]},
    "fluid": {"blocks": [{"low": [0.0, 0.0, 0.0], "high": [0.3, 0.2, 0.1]}]},
    "walls": {"left": {}, "right": {}, "front": {}, "back": {}, "bottom": {}},
    "numerics": {"dx": 0.02, "diffusion": "fourtakas", "viscosity": "monaghan"},
    "time": {"end": 0.1},
}


ENDLESS = {**BASIN, "domain": {"size": [0.3, 0.2, 0.2], "periodic": ["x", "y"]}, "walls": {"bottom": {}}}


@pytest.mark.parametrize("source", [BASIN, ENDLESS, "pool", "couette", "swe-dam-break", "wedge-tank"])
def test_census_counts_what_a_scene_begins_with(source):
    """Mirrors with corners, also in 3D; periodic borders, lines of one dimension, walls of ghosts that meet."""
    scene = load_scene(source)
    found, domain = census(scene), build(scene, Communicator()).domain
    domain.arrange(-scene.time.settle)
    rows, p = np.diff(domain.column_bounds()), domain.particles
    np.testing.assert_array_equal(found.rows, rows)
    np.testing.assert_array_equal(found.cost, domain.column_costs())
    columns = np.repeat(np.arange(len(rows)), rows)
    for count, tags in ((found.fluid, p.tags < FIRST_GHOST), (found.ghosts, p.tags >= FIRST_FIXED)):
        np.testing.assert_array_equal(count, np.bincount(columns[tags[p.first : p.last]], minlength=len(rows)))
    assert found.fluid.sum() < found.rows.sum()


def test_more_ranks_wait_for_the_same_halo_and_share_the_rest():
    """In a long tank: time falls, messages and bytes of an inner rank stay, and the efficiency falls with them."""
    keys = tank(domain={"size": [40.0, 0.3]}, fluid={"blocks": [{"low": [0.0, 0.0], "high": [40.0, 0.2]}]})
    scene = load_scene(keys)
    found = census(scene)
    alone, four, forty = (forecast(scene, ranks, found, step=1.0) for ranks in (1, 4, 40))
    assert alone.step == pytest.approx(1.0)
    assert alone.messages == alone.bytes == (0, 0)
    assert four.messages[1] == forty.messages[1] == 6
    assert forty.bytes[1] == pytest.approx(four.bytes[1], rel=0.25)  # a column holds four or five lines of particles
    assert 1.0 < forty.imbalance < 1.1
    assert alone.step / 40 < forty.step < alone.step / 30
    assert forty.memory < 0.05 * alone.memory


@pytest.mark.parametrize("text", ["1,two", "0", "1,,2", "-1"])
def test_ranks_that_are_none_are_refused(tmp_path, text):
    result = parsph("bench", "--scaling", f"--ranks={text}", cwd=tmp_path)
    assert result.returncode == 2
    assert "--ranks" in result.stderr
    assert "as 1,2,4" in result.stderr
    assert "Traceback" not in result.stderr
    assert not list(tmp_path.iterdir())


def test_ranks_are_a_list():
    assert ranks_of("1, 2,4") == [1, 2, 4]
    assert ranks_of(None) is None


def test_more_ranks_than_columns_are_told_before_anything_runs(tmp_path):
    result = parsph("bench", "--scaling", "--ranks", "1,500", "--particles", "1000", cwd=tmp_path)
    assert result.returncode == 2
    assert "too many ranks: 500" in result.stderr
    assert not list(tmp_path.iterdir())


@needs_mpi
def test_scaling_starts_its_ranks_itself(tmp_path):
    result = parsph("bench", "--scaling", cwd=tmp_path, ranks=2)
    assert result.returncode == 2
    assert result.stderr.count("starts its ranks itself") == 1


@needs_mpi
def test_scaling_measures_what_is_forecast_and_writes_table_and_plot(tmp_path, monkeypatch, capsys):
    """With two cores three ranks count messages and bytes, but no time; all is to be read in a narrow terminal."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    rows = scaling([2, 3], particles=2000, repeats=1, out=tmp_path / "out")
    assert [(row["kind"], row["ranks"]) for row in rows] == [(kind, n) for kind in ("strong", "weak") for n in (1, 2, 3)]
    for row in rows:
        assert row["messages"] == row["expected messages"]
        assert row["bytes"] == pytest.approx(row["expected bytes"], rel=0.15)
        assert row["memory"] == pytest.approx(row["expected memory"], rel=0.15)
        assert (row["messages"] > 0) == (row["ranks"] > 1)
        assert (row["s/step"] is None) == (row["ranks"] == 3)
        assert row["efficiency"] == (1.0 if row["ranks"] == 1 else row["efficiency"])
    assert rows[0]["particles"] == rows[1]["particles"] == rows[2]["particles"]
    assert rows[5]["particles"] == 3 * rows[3]["particles"]
    with open(tmp_path / "out" / "scaling.csv", newline="", encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == list(FORMS)
    assert [float(row["bytes"]) for row in table] == [row["bytes"] for row in rows]
    told = json.loads((tmp_path / "out" / "scaling.json").read_text(encoding="utf-8"))
    assert told["rows"] == rows
    assert all(len(job["turns"]) == 1 for job in told["jobs"])
    assert (tmp_path / "out" / "scaling.png").stat().st_size > 10_000
    shown = capsys.readouterr().out
    assert "…" not in shown, "something is cut off"
    assert "-: no time, since the ranks are oversubscribed" in shown
