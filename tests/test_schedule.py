"""When things are due, and the steps that land on it."""

import numpy as np
import pytest

from parsph.schedule import Schedule, shortened


def times_of(schedule, dt, end, others=()):
    """Step from 0 to `end` with a wanted step of `dt`; return all times and those at which `schedule` was due."""
    time, times, due = 0.0, [0.0], []
    while True:
        if schedule.due(time):
            due.append(time)
        for other in others:
            other.due(time)
        if time >= end:
            return np.array(times), due
        _, time = shortened(dt, time, min([schedule.next, end, *(other.next for other in others)]))
        times.append(time)


@pytest.mark.parametrize("every", [0.1, 0.02, 1 / 3, 0.0101])
@pytest.mark.parametrize("dt", [0.0037, 0.02, 0.0001])
def test_steps_land_exactly_on_due_times(every, dt):
    times, due = times_of(Schedule(every), dt, 10 * every)
    assert due == [round(k * every, 12) for k in range(len(due))]
    assert len(due) >= 10
    assert set(due) <= set(times)


@pytest.mark.parametrize("every", [0.1, 0.02, 1 / 3])
def test_due_times_do_not_drift(every):
    """After 1e5 intervals a sum of intervals is off by far more than the rounding of a multiple."""
    schedule = Schedule(every)
    for _ in range(100_001):
        assert schedule.due(schedule.next)
    assert schedule.next == round(100_001 * every, 12)
    assert round(sum([every] * 100_001), 12) != schedule.next


@pytest.mark.parametrize("dt", [0.003, 0.0099999, 0.01, 0.0100001, 0.0067, 0.05])
def test_no_step_is_a_sliver_and_none_is_longer_than_wanted(dt):
    """A step is never shorter than half of what is wanted, unless the whole interval is."""
    times, _ = times_of(Schedule(0.01), dt, 1.0)
    steps = np.diff(times)
    assert steps.max() <= dt * (1 + 1e-6)
    assert steps.min() >= 0.49 * min(dt, 0.01)


def test_schedules_that_meet_leave_no_sliver_between_them():
    """6 x 0.05 and 15 x 0.02 differ by one ulp: one step serves both."""
    times, _ = times_of(Schedule(0.02), 0.004, 3.0, others=[Schedule(0.05)])
    assert np.diff(times).min() > 1e-4


@pytest.mark.parametrize(("every", "end", "count"), [(0.1, 0.3, 4), (0.05, 0.3, 7), (0.7, 2.1, 4), (1.1, 3.3, 4)])
def test_the_end_of_a_run_is_due_when_it_is_a_multiple(every, end, count):
    """3 x 0.1 is an ulp above 0.3: the last output may not be lost to that."""
    _, due = times_of(Schedule(every), 0.01, end)
    assert len(due) == count


def test_a_late_look_is_due_once():
    schedule = Schedule(0.1)
    assert schedule.due(0.35)
    assert not schedule.due(0.35)
    assert schedule.next == pytest.approx(0.4)


def test_a_schedule_may_start_late():
    schedule = Schedule(0.5, start=2.0)
    assert not schedule.due(1.9)
    assert schedule.due(2.0)
    assert schedule.next == 2.5
