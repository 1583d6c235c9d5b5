"""What a named formula says of itself: a term of the equations, an interpolator, a law of walls."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Formula:
    """A formula that a scene can name.

    Attributes
    ----------
    name : str
        What a scene calls it.
    code : int
        What the compiled code knows it by; 0 is "none".
    equation, source : str
        For `parsph plan`.
    """

    name: str
    code: int
    equation: str = ""
    source: str = ""


NONE = Formula("none", 0)
