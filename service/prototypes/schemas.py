"""Prototypes as the API shows them, and requests to learn one."""

from typing import Annotated, Final

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    field_validator,
)

from broker.contracts import MOST_EXAMPLES, Items, PrototypeParameters, PrototypeRecord, integral
from service.jobs import JobRequest
from service.names import LONGEST, NamedId, showable

Vertices = Annotated[
    tuple[Annotated[int, Field(ge=0, le=2**31 - 1), BeforeValidator(integral)], ...],
    Items(3, 256, fail_fast=True),
]

DEFAULT_NAME: Final = "prototype"

_ONE = "9b74c9897bac770ffc029102a200c5de"
_OTHER = "37b51d194a7513e45b56f6524f2d51f2"
_THIRD = "8c7dd922ad47494fc02c388e12c00eac"


class Prototype(PrototypeRecord):
    """A prototype of a class of shapes."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True)


class PrototypePage(BaseModel):
    """One page of the prototypes, the newest first."""

    items: tuple[Prototype, ...] = Field(description="The prototypes.")
    next_cursor: str | None = Field(description="Cursor of the next page; null on the last.")


class PrototypeRequest(PrototypeParameters, JobRequest):
    """Examples of a class of shapes, and how to learn a prototype from them."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"shapes": [_ONE, _OTHER, _THIRD], "name": "human", "points": 16},
                {
                    "shapes": [_ONE, _OTHER, _THIRD],
                    "correspondence": "shared_connectivity",
                    "metric": ["commute_time", "geodesic"],
                    "descriptor": "none",
                },
                {
                    "shapes": [_ONE, _OTHER],
                    "correspondences": [[17, 204, 31, 880], [12, 199, 40, 871]],
                    "points": 4,
                    "components": 2,
                },
            ]
        }
    )

    shapes: Annotated[tuple[NamedId, ...], Items(2, MOST_EXAMPLES)] = Field(
        description="Ids of the examples, each once.",
    )
    name: Annotated[str, AfterValidator(showable)] = Field(
        default=DEFAULT_NAME,
        min_length=1,
        max_length=LONGEST,
        description="Name of the prototype. Another one of this name becomes its next version.",
    )
    reference: NamedId | None = Field(
        default=None,
        description="Id of the one of `shapes` that the points are chosen on and the others are"
        " matched to; null for the first.",
    )
    correspondences: Annotated[tuple[Vertices, ...], Items(0, MOST_EXAMPLES)] | None = Field(
        default=None,
        description="Corresponding points: for each of `shapes`, in their order, a list of 0-based"
        " vertex indices in its file, all lists of the same length; null to find them as"
        " `correspondence` says.",
    )

    @field_validator("reference")
    @classmethod
    def _is_an_example(cls, reference: str | None, info: ValidationInfo) -> str | None:
        shapes = info.data.get("shapes")
        if reference is not None and shapes is not None and reference not in shapes:
            raise ValueError("Input should be one of `shapes`")
        return reference

    @field_validator("correspondences")
    @classmethod
    def _correspond(
        cls, given: tuple[tuple[int, ...], ...] | None, info: ValidationInfo
    ) -> tuple[tuple[int, ...], ...] | None:
        shapes = info.data.get("shapes")
        if given is None or shapes is None:
            return given
        if len(given) != len(shapes):
            raise ValueError(
                f"Input should have a list for each shape: {len(shapes)}, not {len(given)}"
            )
        for place, vertices in enumerate(given):
            if len(vertices) != len(given[0]):
                raise ValueError(
                    f"Input should have as many vertices of each shape: the first list has"
                    f" {len(given[0])}, list {place} has {len(vertices)}"
                )
            if len(set(vertices)) < len(vertices):
                raise ValueError(f"Input should have each vertex once; list {place} repeats one")
        return given
