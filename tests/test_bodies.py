"""Walls that the flow moves, and wavemakers that take up waves: against exact motions, with forces and levels made up."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import tank

import parsph.bodies
from parsph.bodies import Absorber, MovableWall
from parsph.parallel import Communicator
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.wavemakers import Slide, Yielding

SIMULATION = SimpleNamespace(communicator=Communicator())
DT = 1e-4
MASS, STIFFNESS, DAMPING = 10.0, 1000.0, 20.0


@pytest.fixture
def moved(monkeypatch):
    """Let a force(time, way) move a body; return times, ways, speeds, works, and the body."""

    def move(force, end, stops=(-1.0, 1.0), direction=(1.0, 0.0), start=0.0, **numbers):
        keys = {"stiffness": 0.0, "damping": 0.0, "friction": 0.0, "resistance": 0.0, "preload": 0.0, **numbers}
        signal = Yielding(stops)
        body = MovableWall("wall", signal, Slide(signal, direction), (), MASS, *keys.values(), start)

        def made_up(simulation, motion, time):
            return np.array([*(force(time, signal.at(time)[0]) * np.array(direction)), 0.0])

        monkeypatch.setattr(parsph.bodies, "force_on", made_up)
        rows = []
        for time in np.arange(1, round(end / DT) + 1) * DT:
            body.advance(SIMULATION, time)
            rows.append((time, signal.way, signal.speed, body.work))
        return *np.array(rows).T, body

    return move


def test_a_body_on_spring_and_damper_is_a_damped_oscillator(moved):
    """``x = F/k (1 - exp(-g t) (cos wt + g/w sin wt))``, g = c/2m, w^2 = k/m - g^2."""
    t, way, speed, _, _ = moved(lambda *_: 70.0, 1.5, stiffness=STIFFNESS, damping=DAMPING, preload=20.0)
    decay = DAMPING / (2 * MASS)
    w = math.sqrt(STIFFNESS / MASS - decay**2)
    exact = 0.05 * (1 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))
    np.testing.assert_allclose(way, exact, atol=0.005 * 0.05)
    np.testing.assert_allclose(speed, np.gradient(exact, t), atol=0.01 * 0.05 * w)


def test_the_force_along_the_way_counts(moved):
    """Along a slope, and towards -x."""
    for direction in ((0.8, 0.6), (-1.0, 0.0)):
        _, way, _, _, body = moved(lambda *_: 70.0, 0.1, direction=direction)
        assert way[-1] == pytest.approx(0.5 * 7.0 * 0.1**2, rel=0.01)
        assert body.force == pytest.approx(70.0)


def test_the_work_of_the_force_is_found_in_the_energies(moved):
    """Kinetic, of the spring, and what damper and friction took."""
    _, way, speed, work, _ = moved(
        lambda t, _: 70.0 * math.sin(8 * t) ** 2, 1.5, stiffness=STIFFNESS, damping=DAMPING, friction=5.0
    )
    taken = np.concatenate([[0.0], np.cumsum(DAMPING * speed[1:] ** 2 * DT + 5.0 * np.abs(np.diff(way)))])
    energy = 0.5 * MASS * speed**2 + 0.5 * STIFFNESS * way**2 + taken
    assert work.max() > 1.0
    np.testing.assert_allclose(work, energy, atol=0.01 * work.max())


def test_a_body_rests_until_its_threshold_then_goes_with_all_of_the_force(moved):
    """It is not at rest by a balance that rounding may lose, but to the bit."""
    t, way, speed, _, body = moved(lambda t, _: 100.0 + 50.0 * t, 1.2, preload=100.0, resistance=30.0)
    begins = 0.6
    assert (way[t < begins - DT] == 0.0).all()
    assert (speed[t < begins - DT] == 0.0).all()
    later = t - begins
    exact = np.where(later > 0, (30.0 * later**2 / 2 + 50.0 * later**3 / 6) / MASS, 0.0)
    np.testing.assert_allclose(way, exact, atol=0.005 * exact.max())
    assert not body.resting


def test_a_body_sticks_where_it_comes_to_a_halt_below_its_threshold(moved):
    """Pushed for 0.2 s, then held back."""
    _, way, speed, _, body = moved(lambda t, _: 150.0 if t < 0.2 else 80.0, 2.0, preload=100.0, resistance=30.0)
    halt = int(np.flatnonzero(speed > 0)[-1]) + 1
    assert way[halt] > 0.1
    assert (speed[halt + 1 :] == 0.0).all()
    assert (way[halt + 1 :] == way[-1]).all()
    assert body.resting


def test_friction_holds_a_body_and_brakes_it(moved):
    """Less than it does nothing; from a speed v a body slides on by ``m v^2/2f``."""
    _, way, _, _, _ = moved(lambda *_: 4.9, 0.2, friction=5.0)
    assert (way == 0.0).all()
    _, way, _, _, _ = moved(lambda t, _: 105.0 if t < 0.1 else 0.0, 3.0, friction=20.0)
    assert way[-1] == pytest.approx(0.5 * 8.5 * 0.1**2 + MASS * 0.85**2 / (2 * 20.0), rel=0.01)


def test_a_stop_takes_all_speed_and_lets_go_when_the_force_turns(moved):
    t, way, speed, work, body = moved(lambda t, _: 70.0 if t < 0.5 else -70.0, 0.6, stops=(-0.01, 0.05))
    there = t > math.sqrt(2 * 0.05 / 7.0) + 2 * DT
    held = there & (t < 0.5 - DT)
    assert (way[held] == 0.05).all()
    assert (speed[held] == 0.0).all()
    assert way.max() <= 0.05
    assert work[held][-1] == pytest.approx(70.0 * 0.05, rel=0.01)
    assert way[-1] == pytest.approx(0.05 - 0.5 * 7.0 * 0.1**2, rel=0.01)
    assert not body.resting
    _, way, _, _, body = moved(lambda *_: -70.0, 0.3, stops=(-0.01, 0.05))
    assert way[-1] == -0.01
    assert body.resting


def test_a_body_is_held_until_its_start(moved):
    t, way, _, _, _ = moved(lambda *_: 70.0, 0.3, start=0.2)
    assert (way[t < 0.2] == 0.0).all()
    assert way[-1] == pytest.approx(0.5 * 7.0 * 0.1**2, rel=0.01)


def test_ways_and_speeds_of_a_body_have_no_jumps_but_at_stops(moved):
    _, way, speed, _, _ = moved(lambda t, _: 90.0 * math.sin(20 * t), 1.0, stiffness=STIFFNESS, friction=8.0)
    assert np.abs(np.diff(way)).max() < 1.01 * np.abs(speed).max() * DT
    assert np.abs(np.diff(speed)).max() < 1.01 * (98.0 + STIFFNESS * np.abs(way).max()) / MASS * DT


def test_a_body_in_still_water_stays_exactly_where_it_is():
    """Hundreds of steps: what rounding and the compression of the water do to its force is below the threshold."""
    body = {"wall": "right", "mass": 20.0, "stops": [-0.05, 0.05], "threshold": 1.2}
    scene = load_scene(tank(bodies=[body], gauges=[{"kind": "body", "wall": "right"}], time={"end": 0.4}))
    simulation = build(scene)
    simulation.run()
    (mover,) = simulation.movers
    record = simulation.observers[0].record()
    assert simulation.steps > 200
    assert mover.signal.way == 0.0
    assert mover.resting
    assert (record[:, 2:] == 0.0).all()
    np.testing.assert_allclose(record[:, 1], mover.preload, rtol=0.05)  # from the beginning on


# --- absorption --------------------------------------------------------------------------------------------------------

LEVEL = 0.6
GAIN = math.sqrt(9.81 / 0.5)


def absorber(gain=GAIN, centering=1e9, largest=50.0, reach=0.2, expected=None, lag=0.02):
    signal = Yielding((-reach, reach))
    known = expected or SimpleNamespace(at=lambda time, x: 0.0)
    return Absorber(signal, Slide(signal), known, 0.1, 0.04, LEVEL, gain, lag, centering, largest)


@pytest.fixture
def absorbed(monkeypatch):
    """Let an absorber meet a level(time) over still water; return times, ways, speeds and accelerations."""

    def absorb(plate, level, end):
        asked, now = [], [0.0]

        class Gauge:
            def __init__(self, name, every, place, sides, folder=None):
                asked.append(place[0])

            def measure(self, simulation):
                return (LEVEL + level(now[0]),)

        monkeypatch.setattr(parsph.bodies, "LevelGauge", Gauge)
        rows = []
        for now[0] in np.arange(1, round(end / 1e-3) + 1) * 1e-3:
            plate.advance(SIMULATION, now[0])
            rows.append((now[0], plate.signal.way, plate.signal.speed, plate.signal.acceleration))
        t, way, speed, pull = np.array(rows).T
        np.testing.assert_allclose(asked, 0.1 + way + 0.04, atol=1e-12)  # the gauge goes with the plate
        return t, way, speed, pull

    return absorb


def test_a_plate_goes_back_before_a_wave_as_its_water_does_within_its_lag(absorbed):
    """``X' = -G eta``."""
    t, _, speed, _ = absorbed(absorber(), lambda time: 0.01, 0.1)
    exact = -0.01 * GAIN * (1 - np.exp(-(t - 1e-3) / 0.02))
    np.testing.assert_allclose(speed, exact, atol=0.04 * abs(exact).max())
    assert speed[-1] == pytest.approx(-0.01 * GAIN, rel=0.01)


def test_a_mean_level_moves_a_plate_for_a_while_alone(absorbed):
    """What stays of the level is taken for its mean after a while, and the plate comes back."""
    _, way, _, _ = absorbed(absorber(centering=0.3), lambda time: 0.01, 4.5)
    assert way.min() == pytest.approx(-GAIN * 0.01 * 0.3 / math.e, rel=0.1)  # of -G eta t exp(-t/T), at t = T
    assert abs(way[-1]) < 0.01 * abs(way).max()


def test_what_the_plate_makes_itself_is_no_wave_to_absorb(absorbed):
    seen = []

    def expected(time, x):
        seen.append(x)
        return 0.02 * math.sin(5 * time)

    plate = absorber(expected=SimpleNamespace(at=expected))
    _, way, speed, _ = absorbed(plate, lambda time: 0.02 * math.sin(5 * time), 0.5)
    assert np.abs(way).max() < 1e-14
    assert np.abs(speed).max() < 1e-12
    assert seen == pytest.approx([0.04] * len(seen))


def test_an_absorbing_plate_stays_within_its_limits(absorbed):
    """Of acceleration, and of reach: it slows down before."""
    for sign in (1, -1):
        _, way, speed, pull = absorbed(absorber(largest=2.0, reach=0.05), lambda time, sign=sign: 0.1 * sign, 2.0)
        assert np.abs(pull).max() == pytest.approx(2.0)
        assert np.abs(way).max() <= 0.05
        assert way[-1] == pytest.approx(-0.05 * sign, rel=0.05)
        assert abs(speed[-1]) < 0.01
    _, way, _, _ = absorbed(absorber(reach=0.05), lambda time: -0.1 if time < 1.0 else 0.05, 1.2)
    assert way.max() <= 0.05
    assert way[-1] < 0.03  # it comes back at once


def test_a_plate_drifts_back_to_its_course(absorbed):
    t, way, _, _ = absorbed(absorber(centering=0.5), lambda time: 0.02 if time < 0.3 else 0.0, 2.3)
    away = way[np.searchsorted(t, 0.4)]
    assert away < -0.005
    mean = 0.02 * (1 - math.exp(-0.3 / 0.5)) * math.exp(-0.1 / 0.5)  # it has taken a part of the level for its mean
    exact = (away + GAIN * mean * (t - 0.4)) * np.exp(-(t - 0.4) / 0.5)
    np.testing.assert_allclose(way[t > 0.4], exact[t > 0.4], atol=0.1 * np.abs(way).max())
    assert abs(way[-1]) < 0.15 * np.abs(way).max()
