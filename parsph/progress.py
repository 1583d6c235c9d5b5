"""What is printed while a scene runs, and before and after it.

On a terminal: a progress bar on stderr. In a job log: plain lines, flushed, since users watch job logs.
"""

import math
import os
import sys
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table as RichTable

from .io.gauges import EnergyGauge
from .observers import Observer

LONGEST_IN_HOURS = 4 * 86400  # s; longer durations are told in days


class ProgressLog(Observer):
    """Progress on a terminal, log lines elsewhere; rank 0 prints, all ranks take part in the sums.

    Lines come at intervals of the flow's time, not of the clock, so that all ranks agree on them; they do not shorten steps.

    Parameters
    ----------
    every : float
        Interval of log lines [s of the flow].
    end : float
        End of the run [s].
    """

    phase = "log"

    def __init__(self, every, end):
        super().__init__(every)
        self.end = end
        self.bar = None
        self._energy = None

    @property
    def next(self):
        return float("inf")

    def begin(self, simulation):
        self._clock, self._from = time.perf_counter(), (simulation.time, simulation.evaluations)
        low, high = (-float("inf"),) * simulation.sweep.dim, (float("inf"),) * simulation.sweep.dim
        self._energy = EnergyGauge("log", None, low, high)
        self.total = sum(simulation.communicator.allgather(len(simulation.particles.fluid)))
        if simulation.communicator.rank == 0 and sys.stderr.isatty():
            columns = "t = {task.completed:.3f} of {task.total:g} s", "{task.fields[rate]}"
            self.bar = Progress(
                TextColumn(columns[0]),
                BarColumn(),
                TextColumn(columns[1]),
                TimeRemainingColumn(),
                console=Console(stderr=True),
            )
            self.bar.start()
            self.task = self.bar.add_task("", total=self.end, rate="")

    def due(self, time):
        if self.bar:
            self.bar.update(self.task, completed=time)
        return super().due(time)

    def observe(self, simulation):
        energies = self._energy.measure(simulation)
        if simulation.communicator.rank:
            return
        now, t = time.perf_counter(), simulation.time
        spent, steps = now - self._clock, simulation.steps
        begun, evaluations = self._from
        rate = self.total * (simulation.evaluations - evaluations) / spent if spent > 0 else 0.0
        left = spent * (self.end - t) / (t - begun) if t > begun else float("nan")
        text = f"{rate / 1e6:.2f} M evaluations/s"
        if self.bar:
            self.bar.update(self.task, completed=t, rate=text)
            return
        print(
            f"t = {t:9.4f} s  {100 * t / self.end if self.end else 100:5.1f} %  step {steps:8d}  "
            f"dt {simulation.last_dt:.2e} s  {text}  imbalance {simulation.imbalance.last:.2f}  "
            f"kinetic {energies[1]:.4g} J  eta {duration(left)}",
            flush=True,
        )

    def finish(self, simulation):
        self.close()

    def close(self):
        """Leave the terminal as it was."""
        if self.bar:
            self.bar.stop()
            self.bar = None


def duration(seconds):
    """Return a duration as text, "4.2 s", "1:02:03" or "1,250 days"; "?" where there is no end to it."""
    if not math.isfinite(seconds):
        return "?"
    if seconds > LONGEST_IN_HOURS:
        return f"{seconds / 86400:,.0f} days"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}"


def size_text(count):
    """Return a number of bytes as text."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000 or unit == "TB":
            return f"{count:.3g} {unit}"
        count /= 1000
    return ""


def phase_table(timers, communicator, wall, title):
    """Return the table of time per phase, smallest, mean and largest over ranks, and its share of `wall` [s]."""
    table = RichTable(title=title, title_justify="left")
    for name in ("phase", "min", "mean", "max", "share"):
        table.add_column(name, justify="left" if name == "phase" else "right")
    for phase, (low, mean, high) in sorted(timers.over_ranks(communicator).items(), key=lambda item: -item[1][1]):
        table.add_row(phase, f"{low:.2f}", f"{mean:.2f}", f"{high:.2f}", f"{100 * mean / wall if wall else 0:.0f} %")
    return table


def console():
    """Return a console for stdout that prints text as it is, and does not fold tables and paths in a log.

    Open MPI gives its ranks a terminal of their own even when the job's output is a file.
    """
    plain = {"highlight": False, "markup": False, "emoji": False}  # titles and names may hold brackets and colons
    if sys.stdout.isatty() and "OMPI_COMM_WORLD_SIZE" not in os.environ:
        return Console(**plain)
    width = int(os.environ.get("COLUMNS", "120"))
    return Console(width=width, soft_wrap=True, force_terminal=False, **plain)
