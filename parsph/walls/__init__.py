"""Boundary treatments."""

from .mirror import MirrorWall, wall_images

__all__ = ["MirrorWall", "wall_images"]
