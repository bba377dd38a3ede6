"""Requests to compare a collection of shapes, and the dissimilarities known while it runs."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, field_validator

from broker.contracts import MOST_SHAPES, DissimilarityParameters, Items, JobState
from service.jobs import JobRequest
from service.names import NamedId, ShapeName, one_for_each, showable

Label = Annotated[str, Field(min_length=1, max_length=100), AfterValidator(showable)]

_ONE = "9b74c9897bac770ffc029102a200c5de"
_OTHER = "37b51d194a7513e45b56f6524f2d51f2"
_THIRD = "8c7dd922ad47494fc02c388e12c00eac"


class DissimilaritiesRequest(DissimilarityParameters, JobRequest):
    """A collection of shapes, and how to compare them."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"shapes": [_ONE, _OTHER, _THIRD], "labels": ["cat", "cat", "dog"]},
                {
                    "shapes": [_ONE, _OTHER, _THIRD],
                    "points": 8,
                    "metric": {"name": "diffusion", "time": 0.02},
                    "objective": "linf",
                },
            ]
        }
    )

    shapes: Annotated[tuple[NamedId, ...], Items(2, MOST_SHAPES)] = Field(
        description="Ids of the shapes, each once; all are compared with all.",
    )
    labels: Annotated[tuple[Label, ...], Items(0, MOST_SHAPES)] | None = Field(
        default=None,
        description="Class of each shape, in the order of `shapes`: retrieval is scored by them,"
        " and the heat map ordered.",
    )

    names: Annotated[tuple[ShapeName | None, ...], Items(0, MOST_SHAPES)] | None = Field(
        default=None,
        description="Names of the shapes in the result, in the order of `shapes`; null for those"
        " they are stored under.",
    )

    _labelled = field_validator("labels")(one_for_each("label", "shape"))

    _named = field_validator("names")(one_for_each("name", "shape"))


class PartialDissimilarities(BaseModel):
    """Dissimilarities known so far."""

    model_config = ConfigDict(frozen=True)

    job: str = Field(description="Id of the job that computes them.")
    state: JobState = Field(description="State of that job.")
    shapes: tuple[str, ...] = Field(description="Ids of the shapes, K of them.")
    names: tuple[str | None, ...] | None = Field(
        description="Names that the request gave the shapes, if it did; null for those they are"
        " stored under."
    )
    labels: tuple[str, ...] | None = Field(description="Labels of the shapes, if any were given.")
    pairs: int = Field(description="Number of pairs of shapes.")
    pairs_done: int = Field(description="Number of pairs whose dissimilarity is known.")
    matrix: tuple[tuple[float | None, ...], ...] = Field(
        description="K rows of K dissimilarities; null for pairs not compared yet."
    )
