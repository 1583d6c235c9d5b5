"""What happens beside the step: the base of everything with a schedule."""

import math
import signal
import threading

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


class InterruptGuard(Observer):
    """Lets Ctrl-C wait for the end of the step, so that it hits no file half written and no callback that swallows it.

    A second Ctrl-C does not wait. Where interrupts are ignored (jobs in the background) they stay so.
    """

    def __init__(self):
        super().__init__()
        self._usual, self._asked = None, False

    def begin(self, simulation):
        usual = signal.getsignal(signal.SIGINT)
        if threading.current_thread() is threading.main_thread() and usual not in (signal.SIG_IGN, None):
            self._usual = usual
            signal.signal(signal.SIGINT, self._note)

    def _note(self, number, frame):
        self._asked = True
        self.close()

    def due(self, time):
        if self._asked:
            raise KeyboardInterrupt
        return False

    def close(self):
        """Give interrupts their usual meaning again."""
        if self._usual is not None:
            signal.signal(signal.SIGINT, self._usual)
            self._usual = None
