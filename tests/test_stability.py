"""The stability map: bisection, what its cells are, how it is read, and what `parsph check` says by it."""

import math

import pytest
from helpers import parsph, settings, tank, why_no_mpi

from parsph import stability
from parsph.errors import Interrupted
from parsph.scene.load import builtin_names, load_scene
from parsph.scene.stability import Cell, cell_of, largest_cfl, measured_map, read_map, stability_doubts
from parsph.stability import STEP, cells_of, largest_stable, limit_of, stays_calm, stays_sound, table_text
from parsph.stepping import INTEGRATORS

needs_mpi = pytest.mark.skipif(bool(why_no_mpi()), reason=why_no_mpi() or "mpi is there")
VERLET = Cell("verlet", "continuity", "fourtakas", 0.1, 0.02, 2.0)


@pytest.mark.parametrize("limit", range(62))
def test_bisection_finds_the_limit(limit):
    tried = []
    assert largest_stable(lambda k: tried.append(k) or k <= limit, 60) == min(limit, 60)
    assert len(tried) == len(set(tried)) <= 2 * math.log2(60)
    assert min(tried) >= 1
    assert max(tried) <= 60


def test_bisection_tries_nothing_where_nothing_is_left():
    assert largest_stable(lambda k: pytest.fail(f"{k} was tried"), 0) == 0


def test_a_limit_is_that_of_the_case_that_fails_first(monkeypatch):
    limits = {"calm": 0.4, "violent": 0.3}
    monkeypatch.setattr(stability, "stays_calm", lambda _, cfl: cfl < limits["calm"] + 1e-9)
    monkeypatch.setattr(stability, "stays_sound", lambda _, cfl: cfl < limits["violent"] + 1e-9)
    assert limit_of(VERLET) == (pytest.approx(0.3), "violent")
    limits["violent"] = 0.7
    assert limit_of(VERLET) == (pytest.approx(0.4), "calm")
    limits["calm"] = 0.0
    assert limit_of(VERLET) == (0.0, "calm")


def test_noise_grows_with_verlet_where_it_does_not_with_adams_bashforth():
    assert not stays_calm(VERLET, 0.6)
    assert stays_calm(VERLET._replace(integrator="adams-bashforth"), 0.6)


def test_a_column_falls_soundly_well_below_the_limit_and_not_above():
    limit = measured_map()[VERLET][0]
    assert stays_sound(VERLET, limit - 2 * STEP)
    assert not stays_sound(VERLET, limit + 4 * STEP)


# --- the table --------------------------------------------------------------------------------------------------------


def test_the_table_reads_as_it_was_written():
    found = {VERLET: (0.4, "calm"), VERLET._replace(diffusion="none", delta=0.0, alpha=0.0): (0.0, "violent")}
    assert read_map(table_text(found).splitlines()) == found


def test_the_map_that_comes_along_has_every_cell():
    assert set(measured_map()) == set(cells_of())
    assert {cell.integrator for cell in measured_map()} == set(INTEGRATORS)


KNOWN = {
    VERLET._replace(delta=delta, diffusion=diffusion, alpha=alpha, h_over_dx=h): (
        limit - 0.1 * (h < 2) - 0.05 * (alpha < 0.01),
        "calm",
    )
    for diffusion, delta, limit in (
        ("none", 0.0, 0.2),
        ("fourtakas", 0.02, 0.3),
        ("fourtakas", 0.1, 0.5),
        ("antuono", 0.1, 0.4),
    )
    for alpha in (0.0, 0.02)
    for h in (1.5, 2.0)
}


@pytest.mark.parametrize(
    ("changes", "limit"),
    [
        ({}, 0.5),
        ({"h_over_dx": 1.7}, 0.4),
        ({"alpha": 0.01}, 0.45),
        ({"delta": 0.05}, 0.3),
        ({"delta": 0.01}, 0.2),
        ({"delta": 0.05, "alpha": 0.01, "h_over_dx": 1.9}, 0.15),
        ({"diffusion": "antuono"}, 0.4),
        ({"diffusion": "antuono", "delta": 0.05}, 0.2),
        ({"delta": 0.2}, None),
        ({"h_over_dx": 2.1}, None),
        ({"diffusion": "molteni"}, None),
        ({"integrator": "midpoint"}, None),
        ({"density": "renormalised"}, None),
    ],
)
def test_between_cells_the_smallest_of_those_around_counts(changes, limit):
    found = largest_cfl(VERLET._replace(**changes), KNOWN)
    assert found == (limit if limit is None else pytest.approx(limit))


@pytest.mark.parametrize(
    "override",
    [
        {"numerics.kernel": "cubic-spline"},
        {"numerics.kernel_correction": "linear"},
        {"numerics.viscosity": "newtonian", "numerics.nu": 1e-3},
        {"domain.gravity": 0.0, "numerics.c0": 20.0},
    ],
)
def test_what_has_not_been_measured_has_no_cell(override):
    assert cell_of(load_scene(tank(), override)) is None
    assert not stability_doubts(load_scene(tank(), {**override, "time.cfl": 0.5}))


# --- notes ------------------------------------------------------------------------------------------------------------

BARE = {"numerics.diffusion": "none", "numerics.viscosity": "none"}


def test_a_scene_within_the_map_has_no_note():
    assert cell_of(load_scene(tank())) == VERLET
    assert not stability_doubts(load_scene(tank()))


def test_a_scene_outside_the_map_is_told_its_limit_and_what_to_do():
    limit = measured_map()[VERLET._replace(diffusion="none", delta=0.0, alpha=0.0)][0]
    assert 0 < limit < 0.4
    (note,) = stability_doubts(load_scene(tank(), BARE))
    assert note.startswith(f"time.cfl: 0.4, the default, is above {limit:g}, up to which verlet is stable")
    assert f'at most {limit:g}, or numerics.integrator = "adams-bashforth" with up to 0.' in note
    assert note.endswith("or a numerics.diffusion")
    assert not stability_doubts(load_scene(tank(), {**BARE, "time.cfl": limit}))
    (note,) = stability_doubts(load_scene(tank(), {**BARE, "time.cfl": limit + STEP}))
    assert note.startswith(f"time.cfl: {limit + STEP:g} is above")


def test_a_step_of_constant_length_counts_as_its_cfl():
    scene = load_scene(tank(), BARE)
    most = measured_map()[cell_of(scene)][0] * scene.h / scene.c0
    assert not stability_doubts(load_scene(tank(), {**BARE, "time.dt": most}))
    (note,) = stability_doubts(load_scene(tank(), {**BARE, "time.dt": 1.2 * most}))
    assert note.startswith(f"time.dt: {1.2 * most:g} s, a CFL of ")
    assert f"at most {most:.3g} s" in note


@pytest.mark.parametrize("name", builtin_names())
def test_builtin_scenes_lie_within_the_map(name):
    assert not stability_doubts(load_scene(name))


def test_check_prints_the_note(tmp_path):
    done = parsph("check", "still", *settings(numerics__diffusion="none"), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "note: time.cfl: 0.4, the default, is above" in done.stdout
    assert "note" not in parsph("check", "still", cwd=tmp_path).stdout


# --- the command ------------------------------------------------------------------------------------------------------


def test_it_goes_on_where_it_stopped_and_writes_table_and_plot(tmp_path, capsys):
    """Two cells of three are known already, so that one is left."""
    left, *known = cells_of(quick=True)
    table = tmp_path / "stability.csv"
    table.write_text(table_text({cell: (0.1 * number, "calm") for number, cell in enumerate(known, 1)}), encoding="utf-8")
    found = stability.stability(quick=True, jobs=1, resume=True, out=tmp_path)
    assert set(found) == set(cells_of(quick=True))
    assert [found[cell][0] for cell in known] == [0.1, 0.2]
    assert found[left][0] == pytest.approx(measured_map()[left][0], abs=2 * STEP)
    assert read_map(table.read_text(encoding="utf-8").splitlines()) == {
        cell: (pytest.approx(cfl), case) for cell, (cfl, case) in found.items()
    }
    assert (tmp_path / "stability.png").stat().st_size > 10_000
    shown = capsys.readouterr().out
    assert "[3/3] verlet, continuity, fourtakas 0.1, alpha 0.02, h/dx 1.5: " in shown


def test_the_whole_map_is_to_be_read_in_a_narrow_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    (tmp_path / "stability.csv").write_text(table_text(measured_map()), encoding="utf-8")
    assert stability.stability(resume=True, out=tmp_path) == measured_map()
    shown = capsys.readouterr().out
    assert "…" not in shown, "something is cut off"
    *tables, _ = shown.splitlines()
    assert max(map(len, tables)) <= 80
    for scheme in ("verlet, continuity", "adams-bashforth, renormalised", "midpoint, continuity"):
        assert f"{scheme}: largest stable CFL" in shown


def test_an_interruption_says_how_to_go_on(tmp_path, monkeypatch):
    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(stability, "cells_of", lambda _: [])
    monkeypatch.setattr(stability, "as_completed", interrupted)
    with pytest.raises(Interrupted, match=f"go on with --resume --out {tmp_path}"):
        stability.stability(out=tmp_path)


def test_there_must_be_something_to_go_on_with(tmp_path):
    for out in ([], ["--out", "nothing"]):
        done = parsph("stability", "--resume", *out, cwd=tmp_path)
        assert done.returncode == 2
        assert "--resume: there is nothing to go on with" in done.stderr
    assert not list(tmp_path.iterdir())


@needs_mpi
def test_it_starts_its_processes_itself(tmp_path):
    done = parsph("stability", cwd=tmp_path, ranks=2)
    assert done.returncode == 2
    assert done.stderr.count("starts its processes itself") == 1
    assert not list(tmp_path.iterdir())
