"""Values taken from requests: nothing is converted, and nothing unknown is accepted."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Final, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    ValidationError,
    field_validator,
    model_validator,
)
from pydantic_core import (
    CoreSchema,
    InitErrorDetails,
    PydanticCustomError,
    PydanticKnownError,
    core_schema,
)

MOST_FIELDS: Final = 64
"""Most fields of an object in a request: each unknown one is reported, which takes time."""


def integral(value: Any) -> Any:
    """Return 8 for 8.0: an integer to JSON schema, and some languages write all numbers so."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


class BoundedModel(BaseModel):
    """A value of a bounded number of fields, which do not contradict one another."""

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """What is wrong with fields given the others: their names, and messages."""
        yield from ()

    _integral = field_validator("*", mode="before")(integral)

    @model_validator(mode="before")
    @classmethod
    def _few_fields(cls, value: Any) -> Any:
        if isinstance(value, dict) and len(value) > MOST_FIELDS:
            raise ValueError(f"Input should have at most {MOST_FIELDS} fields, not {len(value)}")
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        # All at once: a validator of a field is not told of other fields that were refused.
        wrong = [
            InitErrorDetails(
                type=PydanticCustomError("contradiction", "{message}", {"message": message}),
                loc=(name,),
                input=getattr(self, name),
            )
            for name, message in self.contradictions()
        ]
        if wrong:
            raise ValidationError.from_exception_data(type(self).__name__, wrong)
        return self


class StrictModel(BoundedModel):
    """A frozen value of declared fields, finite numbers and exact types only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


@dataclass(frozen=True)
class Items:
    """Bounds of a list that a request gives: an annotation of a tuple.

    Every invalid item is reported. Pydantic counts only the valid ones, so that a list of invalid
    ones would have no bound: the length is checked first. The errors of 6000 items take some 40 ms,
    in which nobody else is answered.

    Parameters
    ----------
    least, most
        Bounds of its length.
    fail_fast
        Report only the first invalid item: of lists that have more, also within other lists.
    """

    least: int
    most: int
    fail_fast: bool = False

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return the schema of such a tuple."""
        # A JSON array arrives as a list, which is not strictly a tuple.
        bounds = Field(
            min_length=self.least or None,
            max_length=self.most,
            strict=False,
            fail_fast=self.fail_fast,
        )
        schema = handler.generate_schema(Annotated[source, bounds])
        return core_schema.no_info_before_validator_function(self._bounded, schema)

    def _bounded(self, given: Any) -> Any:
        if isinstance(given, list | tuple) and len(given) > self.most:
            lengths = {"max_length": self.most, "actual_length": len(given)}
            raise PydanticKnownError("too_long", {"field_type": "Tuple", **lengths})
        return given


@dataclass(frozen=True)
class Topic:
    """Heading under which a parameter is documented: an annotation of its field.

    Parameters
    ----------
    name
        The heading; "" for parameters that most users look for first.
    """

    name: str
