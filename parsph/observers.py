"""What happens beside the step: the base of everything with a schedule."""

import math

from .schedule import Schedule


class Observer:
    """Something that looks at the simulation from time to time.

    Parameters
    ----------
    every : float or None
        Interval [s]; steps are shortened to land on its multiples. None: never due.
    """

    phase = "output"

    def __init__(self, every=None):
        self.schedule = Schedule(every) if every else None

    @property
    def next(self):
        """The next time that a step must land on [s]."""
        return self.schedule.next if self.schedule else math.inf

    def due(self, time):
        """Return whether it is due at `time` [s]."""
        return bool(self.schedule) and self.schedule.due(time)

    def begin(self, simulation):
        """Called once before the first step."""

    def observe(self, simulation):
        """Called when due."""

    def finish(self, simulation):
        """Called once after the last step."""
