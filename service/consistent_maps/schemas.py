"""Requests for consistent maps of a collection."""

from typing import Annotated

from pydantic import ConfigDict, Field, field_validator

from broker.contracts import MOST_MAPPED_SHAPES, Items
from service.jobs import JobRequest
from service.names import NamedId, ShapeName, one_for_each

_SHAPES = (
    "9b74c9897bac770ffc029102a200c5de",
    "37b51d194a7513e45b56f6524f2d51f2",
    "8c7dd922ad47494fc02c388e12c00eac",
)


class ConsistentMapsRequest(JobRequest):
    """A collection of shapes that are mapped to one another."""

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        json_schema_extra={"examples": [{"shapes": [*_SHAPES]}]},
    )

    shapes: Annotated[tuple[NamedId, ...], Items(2, MOST_MAPPED_SHAPES)] = Field(
        description="Ids of the shapes, each once. Cycle errors, and so improvements, need three.",
    )
    names: Annotated[tuple[ShapeName | None, ...], Items(0, MOST_MAPPED_SHAPES)] | None = Field(
        default=None,
        description="Names of the shapes in the result, in the order of `shapes`; null for those"
        " they are stored under.",
    )
    largest_component: bool = Field(
        default=False,
        description="Take the largest component of a shape that has several, instead of the whole.",
    )

    _named = field_validator("names")(one_for_each("name", "shape"))
