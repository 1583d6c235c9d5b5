"""Slabs on ranks: who owns which columns, and what moves between them."""

from .domain import Domain
from .slabs import Slab, balanced_cuts, imbalance, most_ranks

__all__ = ["Domain", "Slab", "balanced_cuts", "imbalance", "most_ranks"]
