"""The terms of the equations of motion: pair formulas, one family a file, and their registry.

A formula gets numbers of one pair and returns a number; the loops are in `parsph.sweep`. Sums over neighbours b of a
particle a share ``F = (1/r) dW/dr``, so ``grad_a W_ab = F r_ab`` with ``r_ab = r_a - r_b``, and ``v_ab = v_a - v_b``.
"none" is a term: a family that a scene does not name is not compiled, stored or swept.
"""

from dataclasses import dataclass

from ..formula import NONE, Formula
from .correction import CORRECTIONS
from .density import DENSITIES, SMOOTHED_CONTINUITY
from .diffusion import DIFFUSIONS
from .filter import FILTERS
from .momentum import MOMENTUM
from .shifting import SHIFTINGS
from .spray import SPRAYS
from .tensile import TENSILE_CONTROLS
from .viscosity import VISCOSITIES
from .xsph import XSPH


@dataclass(frozen=True)
class Terms:
    """The terms of one scene.

    Attributes
    ----------
    density, viscosity, diffusion, smoothing, tensile, shifting, spray, correction : Formula
    """

    density: Formula = DENSITIES["continuity"]
    viscosity: Formula = NONE
    diffusion: Formula = NONE
    smoothing: Formula = NONE
    tensile: Formula = NONE
    shifting: Formula = NONE
    spray: Formula = NONE
    correction: Formula = NONE

    @property
    def families(self):
        """Pairs (family, term) of all families, named or not."""
        return (
            ("density", self.density),
            ("momentum", MOMENTUM),
            ("viscosity", self.viscosity),
            ("density diffusion", self.diffusion),
            ("velocity smoothing", self.smoothing),
            ("tensile control", self.tensile),
            ("particle shifting", self.shifting),
            ("spray", self.spray),
            ("kernel correction", self.correction),
        )

    @property
    def codes(self):
        """What the compiled sweep knows the terms by."""
        return tuple(term.code for family, term in self.families if family != "momentum")


__all__ = [
    "CORRECTIONS",
    "DENSITIES",
    "DIFFUSIONS",
    "FILTERS",
    "MOMENTUM",
    "NONE",
    "SHIFTINGS",
    "SMOOTHED_CONTINUITY",
    "SPRAYS",
    "TENSILE_CONTROLS",
    "VISCOSITIES",
    "XSPH",
    "Terms",
]
