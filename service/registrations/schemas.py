"""Requests to register a template to specimens."""

from typing import Annotated

from pydantic import ConfigDict, Field, field_validator

from broker.contracts import MOST_SPECIMENS, Items
from service.jobs import JobRequest
from service.names import NamedId, ShapeName, one_for_each

_TEMPLATE = "9b74c9897bac770ffc029102a200c5de"
_ONE = "37b51d194a7513e45b56f6524f2d51f2"
_OTHER = "8c7dd922ad47494fc02c388e12c00eac"


class RegistrationRequest(JobRequest):
    """A template, and the specimens that it is registered to."""

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"template": _TEMPLATE, "shapes": [_ONE, _OTHER]},
                {"template": _TEMPLATE, "shapes": [_ONE, _OTHER], "scale": True},
            ]
        },
    )

    template: NamedId = Field(description="Id of the shape whose vertices and triangles are taken.")
    template_name: ShapeName | None = Field(
        default=None,
        description="Name of the template in the result, such as that of this upload of its file;"
        " null for the name it is stored under.",
    )
    shapes: Annotated[tuple[NamedId, ...], Items(1, MOST_SPECIMENS)] = Field(
        description="Ids of the specimens, each once.",
    )
    names: Annotated[tuple[ShapeName | None, ...], Items(0, MOST_SPECIMENS)] | None = Field(
        default=None,
        description="Names of the specimens in the result, in the order of `shapes`; null for those"
        " they are stored under.",
    )
    scale: bool = Field(
        default=False,
        description="Scale the specimens to a common size before their mean is taken, so that size"
        " does not count. The registered templates keep the sizes of the specimens.",
    )
    largest_component: bool = Field(
        default=False,
        description="Take the largest component of a shape that has several, instead of the whole.",
    )

    _named = field_validator("names")(one_for_each("name", "shape"))
