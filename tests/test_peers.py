"""parsph beside PySPH: what the comparison works out, what it does without PySPH, and a small one where there is PySPH."""

import csv
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

from against_pysph import DROPS, SKIPPED, STRETCHED, at_cost, axis_errors, equal_cost, main, pysph_in  # noqa: E402

PYTHON = os.environ.get("PYTHON_WITH_PYSPH", sys.executable)


def test_an_error_at_a_cost_is_read_off_the_straight_line_of_a_power_law():
    costs, errors = [8.0, 1.0, 64.0], [0.25, 1.0, 0.0625]  # cost^(-2/3), in no order
    for cost in (1.0, 3.0, 8.0, 50.0, 64.0):
        assert at_cost(cost, costs, errors) == pytest.approx(cost ** (-2 / 3), rel=1e-12)


@pytest.mark.parametrize("cost", [0.99, 64.1])
def test_nothing_is_said_of_costs_that_were_not_measured(cost):
    assert math.isnan(at_cost(cost, [1.0, 64.0], [1.0, 0.1]))


def test_pysph_is_compared_with_parsphs_own_method_alone():
    rows = [
        {"series": series, "per radius": 20, "cost": cost, "error": error}
        for series, cost, error in (
            ("parsph", 1.0, 1e-2),
            ("parsph", 100.0, 1e-4),
            ("parsph, PySPH's method", 10.0, 0.5),
            ("PySPH", 10.0, 0.1),
        )
    ]
    (row,) = equal_cost(rows)
    assert row["series"] == "PySPH"
    assert row["parsph's error"] == pytest.approx(1e-3)


def test_a_drop_that_stretches_as_theory_has_no_error_whatever_it_was_filled_with():
    short, long = 0.51791, 1.93085  # at A t = 0.75, Monaghan (1994)
    start = 1.003, 0.998
    assert axis_errors(start, (start[0] * short, start[1] * long)) == pytest.approx([0, 0], abs=1e-5)
    assert axis_errors(start, (start[0] * short * 1.02, start[1] * long * 0.99)) == pytest.approx([0.02, -0.01], abs=1e-5)


@pytest.fixture
def bare_python(tmp_path):
    """An interpreter without anything installed."""
    path = tmp_path / "bare-python"
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" -S -E "$@"\n', encoding="utf-8")
    path.chmod(0o755)
    return path


def test_without_pysph_nothing_is_measured_and_a_line_says_so(bare_python, tmp_path, capsys):
    assert main(["--python", str(bare_python), "--out", str(tmp_path / "out")]) == SKIPPED == 77
    told = capsys.readouterr().out.splitlines()
    assert len(told) == 1
    assert told[0].startswith(f"not measured: pysph is not installed in {bare_python}")
    assert not (tmp_path / "out").exists()


def test_what_is_no_interpreter_is_refused_in_words(tmp_path):
    script, missing = BENCHMARKS / "against_pysph.py", tmp_path / "nothing"
    environment = os.environ | {"PYTHONPATH": str(BENCHMARKS.parent)}
    done = subprocess.run(
        [sys.executable, script, "--python", missing], capture_output=True, text=True, env=environment, cwd=tmp_path
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert f"--python {missing}: cannot be run" in " ".join(done.stderr.split())


@pytest.mark.timeout(1200)
@pytest.mark.skipif(pysph_in(PYTHON) is None, reason="pysph is not installed here; PYTHON_WITH_PYSPH names another interpreter")
def test_both_codes_run_the_same_flows(tmp_path):
    """A quick comparison: as many particles of the fluid, fronts near each other, evaluations as the integrators have them."""
    out = tmp_path / "out"
    assert main(["--quick", "--python", PYTHON, "--out", str(out)]) == 0
    found = json.loads((out / "peers.json").read_text(encoding="utf-8"))
    rows = {row["quantity"]: row for row in found["rows"]}
    fluid = rows["dam break: particles of the fluid"]
    assert fluid["parsph"] == fluid["PySPH"] == 21 * 41
    front = rows["developed: front at its beginning"]
    assert front["parsph"] == pytest.approx(front["PySPH"], abs=0.05)  # a spacing
    evaluations = rows["developed: evaluations in a window"]
    assert evaluations["parsph"] == pytest.approx(evaluations["PySPH"], rel=0.1)
    drops = {(row["series"], row["per radius"]): row for row in found["drop"]}
    assert {series for series, _ in drops} == set(DROPS)
    assert all(0 < row["error"] < 0.05 for row in drops.values())
    # the same method at the same resolution: the codes must agree far better than either with theory
    ours, theirs = drops["parsph, PySPH's method", 20], drops["PySPH", 20]
    assert ours["error"] == pytest.approx(theirs["error"], rel=0.15)
    assert ours["evaluations"] == pytest.approx(theirs["evaluations"], rel=0.15)
    with open(out / "peers.csv", newline="", encoding="utf-8") as file:
        assert [line["quantity"] for line in csv.DictReader(file)] == [row["quantity"] for row in found["rows"]]
    assert STRETCHED * 100.0 == 0.75
