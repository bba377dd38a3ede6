"""Values taken from requests: nothing is converted, and nothing unknown is accepted."""

from dataclasses import dataclass
from typing import Any, Final

from pydantic import BaseModel, ConfigDict, field_validator, model_validator

MOST_FIELDS: Final = 64
"""Most fields of an object in a request: each unknown one is reported, which takes time."""


def integral(value: Any) -> Any:
    """Return 8 for 8.0: an integer to JSON schema, and some languages write all numbers so."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


class BoundedModel(BaseModel):
    """A value of a bounded number of fields."""

    _integral = field_validator("*", mode="before")(integral)

    @model_validator(mode="before")
    @classmethod
    def _few_fields(cls, value: Any) -> Any:
        if isinstance(value, dict) and len(value) > MOST_FIELDS:
            raise ValueError(f"Input should have at most {MOST_FIELDS} fields, not {len(value)}")
        return value


class StrictModel(BoundedModel):
    """A frozen value of declared fields, finite numbers and exact types only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


@dataclass(frozen=True)
class Topic:
    """Heading under which a parameter is documented: an annotation of its field.

    Parameters
    ----------
    name
        The heading; "" for parameters that most users look for first.
    """

    name: str
