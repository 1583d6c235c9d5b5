"""What a term says of itself."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Term:
    """A term of the equations of motion.

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


NONE = Term("none", 0)
