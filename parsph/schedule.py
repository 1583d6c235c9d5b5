"""When things are due: schedules that output falls on exactly."""


def rounded(time):
    """Return `time` to 1e-12 s, so that 6 x 0.05 and 15 x 0.02, or 3 x 1.1 and 3.3, are the same time."""
    return round(time, 12)


class Schedule:
    """Due at ``start + k * every``: multiples, never sums, so that times do not drift.

    Parameters
    ----------
    every : float
        Interval [s].
    start : float
        First time that is due [s].
    """

    def __init__(self, every, start=0.0):
        self.every, self.start, self.count = float(every), float(start), 0

    @property
    def next(self):
        """The next time that is due [s]."""
        return rounded(self.start + self.count * self.every)

    def due(self, time):
        """Return whether something is due at `time`, and if so move on to the next time after it."""
        if time < self.next:
            return False
        while self.next <= time:
            self.count += 1
        return True


def shortened(dt, time, due):
    """Return the step that lets output fall on `due`, at most `dt`, without leaving a sliver of a step behind.

    Parameters
    ----------
    dt, time, due : float
        Wanted step, present time and next time that is due [s].

    Returns
    -------
    tuple of (float, float)
        The step [s] and the time after it [s], exactly `due` where the step reaches it.
    """
    left = due - time
    if left <= dt * (1 + 1e-9):
        return left, due
    if left < 2 * dt:
        return 0.5 * left, time + 0.5 * left
    return dt, time + dt
