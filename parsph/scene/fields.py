"""What all sections of a scene are made of: numbers within what can be meant, and text of one line."""

from datetime import timedelta
from typing import Annotated

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError, WithJsonSchema
from pydantic_core import PydanticCustomError

LARGEST, SMALLEST = 1e12, 1e-12  # beyond them a number, in whatever SI unit, is a slip, and squares and cubes overflow
LONGEST_TEXT, LONGEST_PATH = 200, 4096  # characters

_TIMEDELTA = TypeAdapter(timedelta)


def _not_tiny(value):
    if 0 < value < SMALLEST:
        raise PydanticCustomError("too_small", f"input should be at least {SMALLEST:g}")
    return value


def _one_line(text):
    if not text.isprintable():
        raise PydanticCustomError("not_printable", "input should be one line of printable characters")
    return text


def _seconds(duration):
    """Return a duration, seconds or a text as queues write it, "12:00:00" or "1-12:00:00", in seconds."""
    if not isinstance(duration, str) or duration.replace(".", "", 1).isdecimal():
        return duration
    try:
        return _TIMEDELTA.validate_python(duration.replace("-", " days, ", 1)).total_seconds()
    except ValidationError:
        message = "should be seconds, or hours:minutes:seconds as 12:00:00, with days 1-12:00:00"
        raise PydanticCustomError("duration", message) from None


Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0, le=LARGEST), AfterValidator(_not_tiny)]
Positive = Annotated[float, Field(gt=0, le=LARGEST), AfterValidator(_not_tiny)]
_DURATION_SCHEMA = WithJsonSchema({"anyOf": [{"type": "number", "minimum": 0}, {"type": "string"}]})
Duration = Annotated[NotNegative, BeforeValidator(_seconds), _DURATION_SCHEMA]  # of the clock
Count = Annotated[int, Field(ge=1, le=10**9)]
Point = Annotated[list[Number], Field(min_length=2, max_length=2)]
Vector = Annotated[list[Number], Field(min_length=1, max_length=3)]
Text = Annotated[str, Field(max_length=LONGEST_TEXT), AfterValidator(_one_line)]
FilePath = Annotated[str, Field(min_length=1, max_length=LONGEST_PATH), AfterValidator(_one_line)]


class Section(BaseModel):
    """Base of all sections: unknown keys are errors, numbers are finite."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)
