"""Where the time goes, and how evenly it is shared."""

import time
from contextlib import contextmanager


class Timers:
    """Wall time per named phase [s]; a phase within another one counts for itself alone."""

    def __init__(self):
        self.seconds = {}
        self._inside = [0.0]

    @contextmanager
    def __call__(self, phase):
        """Count the time inside the ``with`` block towards `phase`."""
        begin = time.perf_counter()
        self._inside.append(0.0)
        try:
            yield
        finally:
            spent = time.perf_counter() - begin
            self.seconds[phase] = self.seconds.get(phase, 0.0) + spent - self._inside.pop()
            self._inside[-1] += spent

    def over_ranks(self, communicator):
        """Return {phase: (smallest, mean, largest)} over all ranks [s], on all ranks."""
        all_seconds = communicator.allgather(self.seconds)
        phases = dict.fromkeys(phase for seconds in all_seconds for phase in seconds)
        table = {}
        for phase in phases:
            times = [seconds.get(phase, 0.0) for seconds in all_seconds]
            table[phase] = min(times), sum(times) / len(times), max(times)
        return table


class Spread:
    """Last, mean and largest of numbers that come one by one.

    Parameters
    ----------
    last : float
        What it is before there is one.
    """

    def __init__(self, last):
        self.last, self.count, self._sum, self.largest = last, 0, 0.0, last

    def add(self, value):
        """Take note of a number."""
        self.largest = max(self.largest, value) if self.count else value
        self.last, self.count, self._sum = value, self.count + 1, self._sum + value

    @property
    def mean(self):
        """The mean so far."""
        if not self.count:
            return self.last
        return min(self._sum / self.count, self.largest)  # rounding may take a mean of equal numbers above them
