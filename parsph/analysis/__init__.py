"""Analysis of gauge records and snapshots, after a run or without one: waves, reflection, differences between runs.

Amplitudes are complex: ``a`` stands for ``Re[a exp(i w t)]``, t as in the record. Incident waves run towards larger x.
"""

from .crossings import WaveSummary, mean_height, wave_summary, waves_of
from .differences import energy_difference, kinetic_energy, level_difference, reflection_ratio
from .oscillations import Oscillation, oscillation
from .records import harmonics
from .separation import ReflectionSpectrum, Separation, check_gauges, reflection, reflection_spectrum, separate

__all__ = [
    "Oscillation",
    "ReflectionSpectrum",
    "Separation",
    "WaveSummary",
    "check_gauges",
    "energy_difference",
    "harmonics",
    "kinetic_energy",
    "level_difference",
    "mean_height",
    "oscillation",
    "reflection",
    "reflection_ratio",
    "reflection_spectrum",
    "separate",
    "wave_summary",
    "waves_of",
]
