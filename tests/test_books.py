"""Energy books: gauges of power, what they add up to, and the command that prints them."""

import json

import numpy as np
import pytest
from helpers import tank

from parsph import cli
from parsph.analysis import energy_books
from parsph.errors import SceneError
from parsph.examine import books
from parsph.parallel import Communicator
from parsph.run import run
from parsph.scene.build import build
from parsph.scene.load import load_scene

GAUGES = [{"kind": "energy", "every": 0.002}, {"kind": "power", "every": 0.002}]
STEPPED = {"blocks": [{"low": [0.0, 0.0], "high": [0.1, 0.2]}, {"low": [0.1, 0.0], "high": [0.2, 0.1]}]}


def falling(**numerics):
    """Return the keys of a column of water that falls into a lower one."""
    return tank(fluid=STEPPED, numerics={"dx": 0.01, **numerics}, time={"end": 0.06, "cfl": 0.2}, gauges=GAUGES)


@pytest.mark.parametrize(
    ("numerics", "takers"),
    [
        ({}, ()),
        ({"viscosity": "monaghan", "alpha": 0.2, "diffusion": "fourtakas"}, ("viscosity", "diffusion")),
        ({"diffusion": "antuono"}, ("diffusion",)),
        ({"shifting": "lind", "diffusion": "fourtakas"}, ("diffusion", "rest")),
    ],
    ids=["plain", "viscosity and diffusion", "antuono", "shifting"],
)
def test_books_close_and_say_what_took_the_energy(numerics, takers):
    """All that terms take, which is much, leaves less open than a hundredth of it, and of what kinetic energy there was."""
    simulation = build(load_scene(falling(**numerics)), Communicator())
    simulation.run()
    energy, power = (gauge.record() for gauge in simulation.observers)
    found, moved = energy_books(energy, power), np.ptp(energy[:, 2])
    assert np.abs(found.open).max() < 1e-3 * moved
    for name in ("viscosity", "diffusion", "rest"):
        share = np.abs(getattr(found, name)).max() / moved
        assert (share > 0.005) == (name in takers), (name, share)
    assert found.viscosity[-1] <= 1e-12 * moved


@pytest.mark.parametrize("numerics", [{"diffusion": "antuono"}, {"kernel_correction": "linear"}], ids=str)
def test_power_is_that_of_the_rates_at_hand(numerics):
    """Of an evaluation at the present positions: with gradients and coefficients of the same order of particles."""
    wave = {"blocks": [{"low": [0.0, 0.0], "high": [0.2, 0.2], "initial": "seiche", "amplitude": 0.01}]}
    simulation = build(load_scene({**falling(**numerics), "fluid": wave}), Communicator())
    simulation.prepare()
    for _ in range(40):
        simulation.advance()
    measured = simulation.observers[1].measure(simulation)
    simulation.evaluate(simulation.time)
    p, rows = simulation.particles, simulation.particles.fluid
    velocity, mass, density, pressure = (p.field(name, rows) for name in ("velocity", "mass", "density", "pressure"))
    pull = p.acceleration[rows] - simulation.sweep.gravity
    parts = mass * (velocity * pull).sum(axis=1), mass * pressure / density**2 * p.density_rate[rows]
    assert sum(measured) == pytest.approx(sum(map(np.sum, parts)), abs=1e-9 * sum(np.abs(part).sum() for part in parts))


@pytest.mark.parametrize("numerics", [{"diffusion": "antuono"}, {"kernel_correction": "linear"}], ids=str)
def test_a_gauge_of_power_changes_nothing_of_the_run(numerics):
    fields, counts = [], []
    for gauges in (GAUGES[:1], GAUGES):
        simulation = build(load_scene({**falling(**numerics), "gauges": gauges}), Communicator())
        simulation.run()
        fields.append(np.column_stack([simulation.field(name) for name in ("id", "position", "velocity", "density")]))
        counts.append(simulation.correction and simulation.correction.plain)
    np.testing.assert_array_equal(*fields)
    assert counts[0] == counts[1]


def test_books_are_the_integrals_of_power():
    t = np.linspace(0.0, 2.0, 41)
    power = np.stack([t, -(t**2), np.full_like(t, 0.5), np.sin(t)], axis=1)
    energy = np.stack([t, 0 * t + 1, t, 2 * t, 3 * t], axis=1)[:36:5]  # another interval, and it ends sooner
    found = energy_books(energy, power)
    t = found.time
    assert t[-1] == 1.75
    np.testing.assert_allclose(found.change, 6 * t, atol=1e-12)
    np.testing.assert_allclose(found.viscosity, -(t**3) / 3, atol=1e-3)
    np.testing.assert_allclose(found.diffusion, 0.5 * t, atol=1e-12)
    np.testing.assert_allclose(found.rest, 1 - np.cos(t), atol=1e-3)
    np.testing.assert_allclose(found.open, found.change - found.viscosity - found.diffusion - found.rest, atol=1e-12)


@pytest.mark.parametrize(("samples", "late"), [(1, 0.0), (5, 10.0)])
def test_records_without_a_common_time_are_refused(samples, late):
    energy = np.zeros((5, 5))
    energy[:, 0] = np.arange(5)
    power = np.zeros((samples, 4))
    power[:, 0] = np.arange(samples) + late
    with pytest.raises(SceneError, match="too few samples"):
        energy_books(energy, power)


@pytest.mark.parametrize(
    ("sections", "key"),
    [
        ({"walls": {"left": {}, "right": {}, "bottom": {}, "treatment": "deficiency"}}, "walls.treatment"),
        ({"numerics": {"dx": 0.01, "density": "summation", "density_range": [0.4, 2.0]}}, "numerics.density"),
        ({"numerics": {"dx": 0.01, "xsph": 0.5, "xsph_continuity": True}}, "numerics.xsph_continuity"),
    ],
)
def test_what_a_gauge_of_power_cannot_account_for_is_refused(sections, key):
    with pytest.raises(SceneError, match=rf"gauges\.1\.kind: does not go with {key} of this scene"):
        load_scene({**falling(), **sections})


def test_the_command_prints_the_books_of_a_run(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    run(falling(), (), tmp_path / "run")
    with pytest.raises(SystemExit) as end:
        cli.main(["analyse", "books", str(tmp_path / "run"), "--json", str(tmp_path / "books.json")])
    assert not end.value.code
    rows = {row["entry"]: row["J"] for row in json.loads((tmp_path / "books.json").read_text())}
    printed = capsys.readouterr().out
    assert all(entry in printed for entry in rows)
    change = sum(rows[f"change of {part} energy"] for part in ("kinetic", "potential", "compressible"))
    given = rows["given by viscosity"] + rows["given by diffusion"] + rows["given by all else, walls included"]
    assert change - given == pytest.approx(rows["not accounted for"], rel=1e-6, abs=1e-9)
    assert 0 < rows["change of kinetic energy"] < -rows["change of potential energy"] * 1.5


@pytest.mark.parametrize(("gauges", "kind"), [(GAUGES[:1], "power"), (GAUGES[1:], "energy")])
def test_a_run_without_the_gauges_is_told_what_it_needs(tmp_path, gauges, kind):
    run({**falling(), "time": {"end": 0.0}, "gauges": gauges}, (), tmp_path / "run")
    with pytest.raises(SceneError, match=f'the run had no gauge with kind = "{kind}"'):
        books(tmp_path / "run")
