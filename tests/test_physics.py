"""Small flows against theory, and runs that must stop."""

import math
import re

import numpy as np
import pytest
from helpers import Probe, tank

from parsph.errors import RunError
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.stepping import INTEGRATORS
from parsph.waves import Seiche


def run(scene, *probes):
    """Run a scene with the given probes; return the simulation."""
    simulation = build(scene)
    simulation.observers += probes
    simulation.run()
    return simulation


def by_id(simulation, name):
    """Return a field in the order of the particles' numbers."""
    return simulation.field(name)[np.argsort(simulation.field("id"))]


# --- still water ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def still():
    """A tank of 0.3 m x 0.2 m after 1.5 s, which is 200 times as long as sound takes to the surface."""
    scene = load_scene("still", {"domain.size": [0.3, 0.3], "fluid.blocks.0.high": [0.3, 0.2], "time.end": 1.5})
    gauges = [
        {"kind": "pressure", "point": [0.15, 0.0], "name": "bed"},
        {"kind": "level", "x": 0.1, "name": "level"},
        {"kind": "energy", "name": "energy"},
    ]
    return run(load_scene(scene.model_dump(), {"gauges": gauges}))


def gauge(simulation, name):
    """Return the record of a gauge as {column: values}."""
    found = next(g for g in simulation.observers if getattr(g, "name", "") == name)
    return dict(zip(("time", *found.columns), found.record().T, strict=True))


def test_lowest_row_of_still_water_stays_at_half_a_spacing(still):
    """With hydrostatic images nothing pulls it to the bed; the plain law lets it sink from 0.50 to 0.24 dx."""
    height = by_id(still, "position")[:, 1].reshape(30, 20)[:, 0]
    np.testing.assert_allclose(height, 0.005, atol=0.05 * 0.01)


def test_still_water_stays_still(still):
    energy = gauge(still, "energy")
    assert energy["kinetic energy [J]"][-1] < 2e-6 * energy["potential energy [J]"][-1]


def test_pressure_at_the_bed_is_hydrostatic(still):
    """rho g H, RMS over the last second."""
    record = gauge(still, "bed")
    late = record["pressure [Pa]"][record["time"] > 0.5]
    assert np.sqrt(np.mean((late / (1000 * 9.81 * 0.2) - 1) ** 2)) < 0.01


def test_level_of_still_water_stays_where_it_is(still):
    level = gauge(still, "level")["level [m]"]
    np.testing.assert_allclose(level, 0.2, atol=0.002)


def test_energy_gauge_begins_with_the_energy_of_the_lattice(still):
    """m g H / 2 per metre of width, up to compressibility."""
    energy = gauge(still, "energy")
    expected = 0.5 * energy["mass [kg]"][0] * 9.81 * 0.2
    assert energy["potential energy [J]"][0] == pytest.approx(expected, rel=2e-3)
    assert energy["mass [kg]"][0] == pytest.approx(60.0, rel=3e-3)
    assert energy["kinetic energy [J]"][0] == 0


# --- the seiche ----------------------------------------------------------------------------------------------------

MODE = Seiche(0.2, 0.2, 0.005, 9.81)


def amplitude(simulation):
    """Projection of the particles' velocities on the mode shape, 1 at t = 0: cos(omega t) in theory."""
    shape = MODE.velocity(simulation.field("position"))
    return float((simulation.field("velocity") * shape).sum() / (shape * shape).sum())


def test_seiche_swings_with_the_frequency_of_linear_theory_and_keeps_its_mass():
    """omega^2 = g k tanh(kd), Szmidt eq. (41): a(t) = cos(omega t) crosses zero at T/4 and 3T/4."""
    period = 2 * math.pi / MODE.frequency
    probe = Probe(period / 80, amplitude)
    simulation = run(load_scene("seiche", {"time.end": period}), probe)
    time, a = (np.array(column, float) for column in zip(*probe.seen, strict=True))
    fall, rise = (np.flatnonzero((a[:-1] > 0) != (a[1:] > 0)))[[0, -1]]
    crossings = [time[k] + (time[k + 1] - time[k]) * a[k] / (a[k] - a[k + 1]) for k in (fall, rise)]
    assert 2 * (crossings[1] - crossings[0]) == pytest.approx(period, rel=0.02)
    assert a[-1] == pytest.approx(1.0, abs=0.06)
    energy = gauge(simulation, "energy-01")
    np.testing.assert_array_equal(energy["mass [kg]"], energy["mass [kg]"][0])
    np.testing.assert_array_equal(by_id(simulation, "id"), np.arange(400))
    level = gauge(simulation, "level-00")["level [m]"] - 0.2
    assert level.max() == pytest.approx(MODE.amplitude, rel=0.15)
    assert level.min() == pytest.approx(-MODE.amplitude, rel=0.15)


def test_both_integrators_agree():
    """Both are of second order: over a twentieth of a period they differ by far less than the flow changes."""
    ends = {}
    for name in ("verlet", "midpoint"):
        simulation = run(load_scene("seiche", {"numerics.integrator": name, "time.end": 0.025}))
        ends[name] = by_id(simulation, "position"), by_id(simulation, "velocity")
    start = by_id(build(load_scene("seiche")), "velocity")
    for (position, other), scale in zip(
        zip(*ends.values(), strict=True), (np.abs(start).max() * 0.025, np.abs(start).max()), strict=True
    ):
        assert np.abs(position - other).max() < 0.02 * scale
    assert np.abs(ends["verlet"][1] - start).max() > 0.04 * np.abs(start).max()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_one_particle_falls_freely(integrator):
    """Without neighbours, x = x0 - g t^2 / 2: both integrators are exact for a constant force, whatever their steps."""
    keys = {
        "domain": {"size": [1.0, 1.0], "gravity": 9.81},
        "fluid": {"blocks": [{"low": [0.5, 0.9], "high": [0.51, 0.91]}]},
        "numerics": {"dx": 0.01, "c0": 20.0, "integrator": integrator},
        "time": {"end": 0.25},
    }
    simulation = run(load_scene(keys))
    assert simulation.field("position")[0] == pytest.approx([0.505, 0.905 - 0.5 * 9.81 * 0.25**2], abs=1e-12)
    assert simulation.field("velocity")[0] == pytest.approx([0.0, -9.81 * 0.25], abs=1e-12)


# --- sound in one dimension ----------------------------------------------------------------------------------------


def test_sound_travels_at_c0_and_comes_back_from_the_wall():
    """A pulse v = c0 (rho - rho0)/rho0 moves to the right; after 2 L/c0 it has met both walls and is where it began."""
    c0, length, dx = 10.0, 1.0, 0.005
    keys = {
        "domain": {"size": [length], "gravity": 0.0},
        "fluid": {"blocks": [{"low": [0.0], "high": [length]}]},
        "walls": {"left": {}, "right": {}},
        "numerics": {"dx": dx, "c0": c0, "state": "linear"},
        "time": {"end": 0.0},
    }
    simulation = build(load_scene(keys))
    p = simulation.particles
    rows = p.fluid
    x = p.field("position", rows)[:, 0]
    swell = 1e-4 * np.exp(-(((x - 0.35) / 0.06) ** 2))
    p.shared[rows, 2] *= 1 + swell
    p.shared[rows, 1] = c0 * swell
    simulation.prepare()

    def place():
        """Weighted by the square: where the pulse is, noise aside."""
        weight = (simulation.field("density") - 1000.0) ** 2
        return float((weight * simulation.field("position")[:, 0]).sum() / weight.sum())

    def advance(end):
        simulation.end = end
        while simulation.time < end:
            simulation.advance()

    assert place() == pytest.approx(0.35, abs=1e-3)
    advance(0.03)
    assert place() == pytest.approx(0.65, abs=0.02 * 0.3)
    assert simulation.field("velocity").max() == pytest.approx(c0 * 1e-4, rel=0.05)
    advance(0.2)
    assert place() == pytest.approx(0.35, abs=0.02 * 2)
    assert simulation.field("velocity").max() == pytest.approx(c0 * 1e-4, rel=0.1)


# --- the pool ------------------------------------------------------------------------------------------------------


def test_water_follows_the_plate():
    """After half a second the plate leans by nearly its amplitude: no particle is behind it, and none has stayed away."""
    simulation = run(load_scene("pool", {"numerics.dx": 0.1, "time.end": 0.5, "wavemaker.wave.ramp": 0.0, "gauges": []}))
    position = simulation.field("position")
    assert len(position) == 121 * 10
    angle = math.radians(5) * math.sin(2 * math.pi * 0.5 / 2.236969878)
    for low in np.arange(0, 0.9, 0.2):
        layer = position[(position[:, 1] >= low) & (position[:, 1] < low + 0.2)]
        assert 0 < (layer[:, 0] - layer[:, 1] * math.tan(angle)).min() < 0.1


# --- runs that must stop -------------------------------------------------------------------------------------------


@pytest.fixture
def begun():
    """A small tank after a few steps."""
    simulation = build(load_scene(tank(time={"end": 1.0})))
    simulation.prepare()
    for _ in range(3):
        simulation.advance()
    return simulation


def spoil(simulation, field, value, number=123):
    """Give `field` of the particle `number` another value, then go on."""
    p = simulation.particles
    row = p.fluid[simulation.field("id") == number]
    part, columns = p.layout.columns(field)
    getattr(p, part)[row, columns] = value
    for _ in range(2):
        simulation.advance()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("velocity", [math.nan, 0.0]),
        ("velocity", [0.0, math.nan]),
        ("velocity", [math.inf, 0.0]),
        ("position", [math.nan, 0.1]),
        ("density", math.nan),
        ("density", 1500.0),
        ("density", 0.0),
        ("density", -1000.0),
        ("velocity", [0.0, -1e4]),
        ("velocity", [-1e4, 0.0]),
        ("velocity", [0.0, 1e5]),
    ],
)
def test_run_stops_with_particle_place_and_time(begun, field, value):
    """NaN, a density out of range, a particle through a wall or out of the domain."""
    with pytest.raises(RunError) as caught:
        spoil(begun, field, value)
    text = str(caught.value)
    assert re.match(r"particle 123 .*\(\S+, \S+\) m", text), text
    times = re.findall(r"t = (\S+) s", text)
    assert times, f"no time: {text}"
    assert float(times[0]) == pytest.approx(begun.time, abs=2 * begun.last_dt)
    assert caught.value.cure
    assert caught.value.exit_code == 1


def test_density_that_leaves_the_range_says_the_range(begun):
    with pytest.raises(RunError, match=r"density 1[45]\d\d.*699.1[0-9]* to 1298.[0-9]* kg/m\^3"):
        spoil(begun, "density", 1500.0)


def test_particle_pushed_through_a_wall_says_so():
    """The box ends where the wall stands, so it is either that is named; a tilted plate has no box."""
    simulation = build(load_scene("pool", {"numerics.dx": 0.1, "gauges": []}))
    simulation.prepare()
    with pytest.raises(RunError, match="particle 3 crossed the left wall"):
        spoil(simulation, "position", [-0.05, 0.35], number=3)
