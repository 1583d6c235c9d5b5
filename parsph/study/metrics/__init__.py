"""Metrics: one number of a finished row, from its files and those of the rows that it is compared with."""

from . import free, pool  # noqa: F401 - they register their metrics
from .base import COSTS, METRICS, largest, rms
from .basins import amplitudes, mode_of, oscillation_of
from .rest import EARLY, arrival, buchner, impact, plateau_of, probe_errors, probes
from .walls import behind

__all__ = [
    "COSTS",
    "EARLY",
    "METRICS",
    "amplitudes",
    "arrival",
    "behind",
    "buchner",
    "impact",
    "largest",
    "mode_of",
    "oscillation_of",
    "plateau_of",
    "probe_errors",
    "probes",
    "rms",
]
