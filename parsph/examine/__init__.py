"""The commands that look at finished runs: folders in, tables and pictures out."""

from .gauges import books, harmonics, reflection, spectrum, waves
from .pictures import one_number, plot
from .snapshots import energy, ratio

__all__ = ["books", "energy", "harmonics", "one_number", "plot", "ratio", "reflection", "spectrum", "waves"]
