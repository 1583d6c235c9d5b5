"""Signals: rates are derivatives, extents hold, nothing moves before it shall."""

import math

import numpy as np
import pytest

from parsph.wavemakers import Harmonics, Oscillation, Sampled, Together, Yielding

STEP = 1e-5
HARMONICS = Harmonics(np.array([0.3, 0.1, 0.05]), np.array([2.0, 4.0, 7.3]), np.array([0.4, -1.0, 2.0]), 1.3, 9.0)
SAMPLED = Sampled(np.array([0.5, 0.9, 1.2, 1.9, 2.4, 3.0]), np.array([0.0, 0.1, 0.3, 0.2, -0.2, 0.1]))
# name: (signal, times at which it begins or ends suddenly, the last time at which it moves)
SIGNALS = {
    "oscillation": (Oscillation(0.1, 1.7), (), 50.0),
    "oscillation with a ramp": (Oscillation(0.1, 1.7, ramp=0.6), (0.6,), 50.0),
    "oscillation with a long ramp": (Oscillation(0.1, 1.7, ramp=5.0), (), 50.0),
    "two cycles": (Oscillation(0.1, 1.7, cycles=2), (3.4,), 3.4),
    "one cycle with a ramp": (Oscillation(0.1, 1.7, ramp=0.6, cycles=1), (0.6, 1.7), 1.7),
    "harmonics": (HARMONICS, (1.3,), 50.0),
    "samples": (SAMPLED, (0.5, 0.9, 1.2, 1.9, 2.4, 3.0), 3.0),
    "together": (Together((HARMONICS, Oscillation(0.2, 0.9, ramp=0.3), SAMPLED)), (0.3, 0.5, 1.3, 3.0), 50.0),
}
TIMES = np.linspace(0.013, 6.3, 191)


@pytest.mark.parametrize("name", SIGNALS)
def test_rates_are_derivatives(name):
    """By central differences, away from sudden changes."""
    signal, sudden, _ = SIGNALS[name]
    times = [time for time in TIMES if all(abs(time - when) > 2 * STEP for when in sudden)]
    assert len(times) > 180
    for time in times:
        before, now, after = (signal.at(t) for t in (time - STEP, time, time + STEP))
        assert now[1] == pytest.approx((after[0] - before[0]) / (2 * STEP), abs=1e-7)
        assert now[2] == pytest.approx((after[1] - before[1]) / (2 * STEP), abs=1e-6)


@pytest.mark.parametrize("name", SIGNALS)
def test_extents_hold_and_are_not_much_too_wide(name):
    signal, _, _ = SIGNALS[name]
    least, largest = signal.extent
    values = [signal.at(time)[0] for time in np.arange(0.0, 9.0, 0.003)]
    assert max(values) <= largest * (1 + 0.02)  # looked for at 20 times per period
    assert min(values) >= least * (1 + 0.02)
    if name != "together":  # they need not be at their ends at the same time
        assert max(values) > 0.8 * largest
        assert min(values) < 0.8 * least


@pytest.mark.parametrize("name", SIGNALS)
def test_before_the_beginning_all_is_at_rest(name):
    """The settling of the water is at negative times."""
    signal, _, end = SIGNALS[name]
    for time in (-3.0, -1e-9, 0.0):
        assert signal.at(time) == (0, 0, 0)
    if end < 50.0:
        for time in (end, end + 1e-9, 77.0):
            assert signal.at(time)[1:] == (0, 0)


def test_an_oscillation_is_a_sine_times_its_ramp():
    """First towards positive values; half of it in the middle of the ramp."""
    sudden, smooth = Oscillation(0.1, 2.0), Oscillation(0.1, 2.0, ramp=1.0)
    assert sudden.at(0.5)[0] == pytest.approx(0.1)
    assert sudden.at(1.5)[0] == pytest.approx(-0.1)
    assert sudden.at(1e-9)[1] == pytest.approx(0.1 * math.pi)
    assert smooth.at(1e-9)[1] == pytest.approx(0, abs=1e-8)
    assert smooth.at(0.5)[0] == pytest.approx(0.5 * sudden.at(0.5)[0])
    assert smooth.at(1.0) == sudden.at(1.0)
    assert smooth.at(7.3) == sudden.at(7.3)


def test_cycles_end_where_they_began_and_stay_there():
    single = Oscillation(0.1, 1.7, cycles=1)
    assert single.at(1.7 - 1e-6)[0] == pytest.approx(0, abs=1e-6)
    assert single.at(1.6) == Oscillation(0.1, 1.7).at(1.6)
    for time in (1.7, 1.9, 50.0):
        assert single.at(time) == (0, 0, 0)


def test_harmonics_are_the_sum_of_their_sines():
    plain = Harmonics(HARMONICS.amplitudes, HARMONICS.frequencies, HARMONICS.phases, 0.0, 9.0)
    for time in (0.2, 1.3, 4.4):
        parts = [a * math.sin(w * time + p) for a, w, p in ((0.3, 2.0, 0.4), (0.1, 4.0, -1.0), (0.05, 7.3, 2.0))]
        assert plain.at(time)[0] == pytest.approx(sum(parts), rel=1e-12)
        ramped = HARMONICS.at(time)[0]
        share = 0.5 * (1 - math.cos(math.pi * min(time / 1.3, 1.0)))
        assert ramped == pytest.approx(share * sum(parts), rel=1e-12)


def test_samples_are_met_and_the_curve_is_smooth_between_them():
    """Values, speeds and accelerations have no jumps but for the acceleration at both ends."""
    for time, value in zip(SAMPLED.times, SAMPLED.values, strict=True):
        assert SAMPLED.at(time)[0] == pytest.approx(value, abs=1e-12)
        before, after = SAMPLED.at(time - 1e-8), SAMPLED.at(time + 1e-8)
        ends = time in (SAMPLED.times[0], SAMPLED.times[-1])
        for k in range(2 if ends else 3):
            assert before[k] == pytest.approx(after[k], abs=1e-5)
    assert SAMPLED.at(99.0) == (0.1, 0, 0)


def test_together_is_the_sum():
    parts = SIGNALS["together"][0].signals
    for time in (0.2, 2.0):
        expected = [sum(part.at(time)[k] for part in parts) for k in range(3)]
        assert SIGNALS["together"][0].at(time) == pytest.approx(expected, rel=1e-12)


def test_what_yields_has_no_jumps_in_way_and_speed_when_it_is_told_to_go_on():
    """Constant accelerations, one after the other: way and speed at each change are those of before."""
    signal, rng = Yielding((-1.0, 1.0)), np.random.default_rng(3)
    time, way, speed = 0.0, 0.0, 0.0
    for dt, pull in zip(rng.uniform(0.01, 0.1, 40), rng.normal(0, 1, 40), strict=True):
        signal.go_on(time, *signal.at(time)[:2], pull)
        assert signal.at(time) == pytest.approx((way, speed, pull), rel=1e-12, abs=1e-15)
        middle = signal.at(time + 0.5 * dt)
        assert middle[1] == pytest.approx(speed + 0.5 * dt * pull)
        time, way, speed = time + dt, way + dt * (speed + 0.5 * dt * pull), speed + dt * pull
        assert signal.at(time) == pytest.approx((way, speed, pull), rel=1e-12)
    assert abs(way) > 0.01


def test_what_yields_rests_until_it_is_told_and_looks_at_no_past():
    signal = Yielding((-1.0, 1.0))
    assert signal.at(-1.0) == signal.at(9.0) == (0, 0, 0)
    signal.go_on(2.0, 0.1, 0.2, 0.3)
    assert signal.at(1.0) == (0.1, 0.2, 0.3)
