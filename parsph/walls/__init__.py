"""Boundary treatments."""

from .barrier import Barrier, Lines
from .ghosts import FixedGhosts
from .interpolation import INTERPOLATORS
from .mirror import MirrorWall, wall_images
from .periodic import PeriodicBorder, translated_images

__all__ = [
    "INTERPOLATORS",
    "Barrier",
    "FixedGhosts",
    "Lines",
    "MirrorWall",
    "PeriodicBorder",
    "translated_images",
    "wall_images",
]
