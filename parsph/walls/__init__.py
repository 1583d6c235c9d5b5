"""Boundary treatments."""

from .barrier import Barrier, Lines
from .deficiency import WEIGHTS
from .ghosts import FixedGhosts
from .interpolation import INTERPOLATORS
from .markers import Line, Markers
from .mirror import MirrorWall, wall_images
from .periodic import PeriodicBorder, translated_images
from .repulsion import REPULSIONS
from .strip import Strip
from .treatments import TREATMENTS

__all__ = [
    "INTERPOLATORS",
    "REPULSIONS",
    "TREATMENTS",
    "WEIGHTS",
    "Barrier",
    "FixedGhosts",
    "Line",
    "Lines",
    "Markers",
    "MirrorWall",
    "PeriodicBorder",
    "Strip",
    "translated_images",
    "wall_images",
]
