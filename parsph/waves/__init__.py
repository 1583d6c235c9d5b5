"""Theory of water waves: what a wave tank should show, no solver needed.

Linear waves (`linear`), standing waves (`basins`), shallow water (`shallow`), what paddles make (`paddles`) and absorb
(`absorption`), solitary waves (`solitary`), irregular waves (`spectra`), nonlinear regular waves (`regular`), how high waves
can be (`limits`), and a table of all that for one wave (`summary`).
"""

from .absorption import sent_back, tuned_absorption
from .basins import Seiche, Sloshing
from .limits import HIGHEST_SOLITARY, breaking_height, highest_wave, mccowan, miche, regime, second_harmonic, ursell
from .linear import (
    Dispersion,
    angular_frequency,
    decay_in_space,
    decay_in_time,
    dispersion,
    group_speed,
    phase_speed,
    viscosity_of_alpha,
    wavenumber,
)
from .paddles import (
    MADSEN,
    evanescent_wavenumbers,
    flap_height,
    flap_transfer,
    free_second_harmonic,
    madsen_limit,
    near_field,
    near_modes,
    second_order,
    second_order_full,
    transfer,
    velocity_profile,
)
from .regular import REGULAR_THEORIES, RegularWave, regular_wave
from .shallow import DamBreak, layer_reflection, pulse
from .solitary import SOLITARY_THEORIES, Solitary, WallImpact, solitary_on_wall
from .spectra import SPECTRA, Components, Jonswap, PiersonMoskowitz, Tabulated, components, focused
from .summary import describe, describe_solitary

__all__ = [
    "HIGHEST_SOLITARY",
    "MADSEN",
    "REGULAR_THEORIES",
    "SOLITARY_THEORIES",
    "SPECTRA",
    "Components",
    "DamBreak",
    "Dispersion",
    "Jonswap",
    "PiersonMoskowitz",
    "RegularWave",
    "Seiche",
    "Sloshing",
    "Solitary",
    "Tabulated",
    "WallImpact",
    "angular_frequency",
    "breaking_height",
    "components",
    "decay_in_space",
    "decay_in_time",
    "describe",
    "describe_solitary",
    "dispersion",
    "evanescent_wavenumbers",
    "flap_height",
    "flap_transfer",
    "focused",
    "free_second_harmonic",
    "group_speed",
    "highest_wave",
    "layer_reflection",
    "madsen_limit",
    "mccowan",
    "miche",
    "near_field",
    "near_modes",
    "phase_speed",
    "pulse",
    "regime",
    "regular_wave",
    "second_harmonic",
    "second_order",
    "second_order_full",
    "sent_back",
    "solitary_on_wall",
    "transfer",
    "tuned_absorption",
    "ursell",
    "velocity_profile",
    "viscosity_of_alpha",
    "wavenumber",
]
