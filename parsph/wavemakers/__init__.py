"""Wavemakers, and how walls move at all."""

from .motions import Bulge, Flap, Placement, Slide, Swing
from .signals import Harmonics, Oscillation, Sampled, Together, Yielding, oscillation

__all__ = [
    "Bulge",
    "Flap",
    "Harmonics",
    "Oscillation",
    "Placement",
    "Sampled",
    "Slide",
    "Swing",
    "Together",
    "Yielding",
    "oscillation",
]
