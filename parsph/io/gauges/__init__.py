"""Gauges: small records of the flow with a sampling interval of their own.

A gauge gathers the few particles it needs, or sums per column, on rank 0, in the global order of (cell, id): its record
does not depend on the number of ranks.
"""

from .base import Gauge, column_sums, fluid_near, gathered, particles_near, total_of_columns
from .energy import EnergyGauge
from .forces import BodyGauge, ForceGauge, force_on
from .levels import DepthGauge, LevelGauge
from .power import PowerGauge
from .pressures import COVERED, PressureGauge, pressures_at
from .runup import RunupGauge, ascents

__all__ = [
    "COVERED",
    "BodyGauge",
    "DepthGauge",
    "EnergyGauge",
    "ForceGauge",
    "Gauge",
    "LevelGauge",
    "PowerGauge",
    "PressureGauge",
    "RunupGauge",
    "ascents",
    "column_sums",
    "fluid_near",
    "force_on",
    "gathered",
    "particles_near",
    "pressures_at",
    "total_of_columns",
]
