"""What happens beside the step: the base of everything with a schedule, and the signals that may end a run."""

import math
import signal
import threading
import time

from .errors import Unfinished
from .schedule import Schedule

ONE_PRESS = 1.0  # s in which Ctrl-C may come twice, from the terminal and from mpirun


class Observer:
    """Something that looks at the simulation from time to time.

    Parameters
    ----------
    every : float or None
        Interval [s]; steps are shortened to land on its multiples. None: never due.
    """

    phase = "output"
    settles = False  # whether it also looks while the water settles, before t = 0

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
        """Called once before the first step, also of a run that goes on (`simulation.steps` is not 0 then)."""

    def observe(self, simulation):
        """Called when due."""

    def finish(self, simulation):
        """Called once after the last step."""

    def close(self):
        """Called once at the end, also of a run that failed, when other ranks may be gone."""


class Signals:
    """Notes what asks a run to end - Ctrl-C, SIGTERM, SIGUSR1 - inside a ``with`` block, so that it hits no file half written
    and no callback that swallows it.

    Before `waiting` is set, and at a second Ctrl-C, it does not wait. What is ignored, as Ctrl-C by jobs in the background,
    stays so.

    Attributes
    ----------
    received : int or None
        The signal.
    waiting : bool
        Whether somebody looks at `received` from time to time.
    """

    WATCHED = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)

    def __init__(self):
        self.received, self.waiting = None, False
        self._usual, self._when = {}, -math.inf

    def __enter__(self):
        if threading.current_thread() is threading.main_thread():
            for number in self.WATCHED:
                if signal.getsignal(number) not in (signal.SIG_IGN, None):
                    self._usual[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_):
        for number, usual in self._usual.items():
            signal.signal(number, usual)

    def _note(self, number, frame):
        interrupted = number == signal.SIGINT
        again = interrupted and self.received == number and time.monotonic() - self._when > ONE_PRESS
        if interrupted and (again or not self.waiting):
            raise KeyboardInterrupt
        if not self.waiting:
            raise SystemExit(Unfinished.exit_code)
        self.received, self._when = number, time.monotonic()
