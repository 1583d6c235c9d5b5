"""What all sections of a scene are made of."""

from datetime import timedelta
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError, WithJsonSchema

Point = Annotated[list[float], Field(min_length=2, max_length=2)]
Vector = Annotated[list[float], Field(min_length=1, max_length=3)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_TIMEDELTA = TypeAdapter(timedelta)


def _seconds(duration):
    """Return a duration, seconds or a text as queues write it, "12:00:00" or "1-12:00:00", in seconds."""
    if not isinstance(duration, str):
        return duration
    try:
        return _TIMEDELTA.validate_python(duration.replace("-", " days, ", 1)).total_seconds()
    except ValidationError:
        raise ValueError("should be seconds, or hours:minutes:seconds as 12:00:00, with days 1-12:00:00") from None


_DURATION_SCHEMA = WithJsonSchema({"anyOf": [{"type": "number", "minimum": 0}, {"type": "string"}]})
Duration = Annotated[NotNegative, BeforeValidator(_seconds), _DURATION_SCHEMA]  # of the clock


class Section(BaseModel):
    """Base of all sections: unknown keys are errors, numbers are finite."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)
