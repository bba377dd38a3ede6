"""Requests to match one source with many targets, and the matches known while they run."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, field_validator

from broker.contracts import MOST_TARGETS, BatchMatch, Items, JobState
from service.matches import SourceRequest
from service.names import NamedId, ShapeName, one_for_each


class BatchRequest(SourceRequest):
    """One source and its targets, and how to match them."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "source": "9b74c9897bac770ffc029102a200c5de",
                    "targets": [
                        "37b51d194a7513e45b56f6524f2d51f2",
                        "8c7dd922ad47494fc02c388e12c00eac",
                    ],
                    "points": 32,
                    "dense": True,
                }
            ]
        }
    )

    targets: Annotated[tuple[NamedId, ...], Items(1, MOST_TARGETS)] = Field(
        description="Ids of the target shapes; the source is matched with each of them.",
    )
    target_names: Annotated[tuple[ShapeName | None, ...], Items(0, MOST_TARGETS)] | None = Field(
        default=None,
        description="Names of the targets in the results, in the order of `targets`; null for those"
        " they are stored under.",
    )

    _named = field_validator("target_names")(one_for_each("name", "target"))


class BatchProgress(BaseModel):
    """The matches of a batch as they are now."""

    model_config = ConfigDict(frozen=True)

    job: str = Field(description="Id of the job of the batch.")
    state: JobState = Field(description="State of that job.")
    source: str = Field(description="Id of the source, a shape or a prototype.")
    source_name: str | None = Field(
        description="Name of the source, of the request or as stored; null in batches of earlier"
        " versions."
    )
    ended: int = Field(description="Number of matches that have ended.")
    matches: tuple[BatchMatch, ...] = Field(description="The matches, in the order of the targets.")
