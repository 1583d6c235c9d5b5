"""Analysis of gauge records and snapshots, after a run or without one: waves, spectra, reflection, decay, differences.

Amplitudes are complex: ``a`` stands for ``Re[a exp(i w t)]``, t as in the record. Incident waves run towards larger x.
"""

from .along import Decay, SecondHarmonic, decay_along, expected_decay, harmonics_along, second_harmonic
from .books import Books, energy_books
from .crossings import WaveSummary, mean_height, wave_summary, waves_of
from .differences import energy_difference, kinetic_energy, level_difference, reflection_ratio
from .oscillations import Oscillation, oscillation
from .records import harmonics
from .separation import ReflectionSpectrum, Separation, check_gauges, reflection, reflection_spectrum, separate
from .spectra import Spectrum, WaveStatistics, spectrum, statistics

__all__ = [
    "Books",
    "Decay",
    "Oscillation",
    "ReflectionSpectrum",
    "SecondHarmonic",
    "Separation",
    "Spectrum",
    "WaveStatistics",
    "WaveSummary",
    "check_gauges",
    "decay_along",
    "energy_books",
    "energy_difference",
    "expected_decay",
    "harmonics",
    "harmonics_along",
    "kinetic_energy",
    "level_difference",
    "mean_height",
    "oscillation",
    "reflection",
    "reflection_ratio",
    "reflection_spectrum",
    "second_harmonic",
    "separate",
    "spectrum",
    "statistics",
    "wave_summary",
    "waves_of",
]
