"""What walls can be made of: one registry for the schema, the plan and the messages."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Treatment:
    """A way in which walls act on the fluid.

    Attributes
    ----------
    name : str
        What a scene calls it.
    family : str
        "mirror", "ghosts" or "markers": what carries it.
    description, source : str
        For `parsph plan`.
    corrects : bool
        Whether markers correct the boundary deficiency.
    solves : bool
        Whether normal velocities of ghosts are solved for.
    """

    name: str
    family: str
    description: str
    source: str
    corrects: bool = False
    solves: bool = False


TREATMENTS = {
    each.name: each
    for each in (
        Treatment("mirror", "mirror", "mirror particles, pressure raised by rho g . dx", "Szmidt (2013) Figs. 1, 2"),
        Treatment("mirror-plain", "mirror", "mirror particles, equal pressure", "Szmidt (2013) Figs. 1, 2"),
        Treatment(
            "ghosts", "ghosts", "fixed ghosts with interpolated mirror points", "Marrone et al. (2011); Huang et al. (2019)"
        ),
        Treatment(
            "strip", "ghosts", "one row of ghosts whose normal velocities are solved for", "Szmidt (2013) eq. (32)", solves=True
        ),
        Treatment(
            "deficiency",
            "markers",
            "markers: correction of the boundary deficiency, and repulsion",
            "Jones et al. (2010) eqs. (7), (8)",
            corrects=True,
        ),
        Treatment("repulsion", "markers", "markers: repulsion alone", "Monaghan & Kajtar (2009); Monaghan (1994)"),
    )
}
