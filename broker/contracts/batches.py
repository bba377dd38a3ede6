"""Batches: many matches asked for as one job, and what is known of each of them."""

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.job_kinds import JobState
from broker.contracts.parameters import MatchParameters
from broker.contracts.problems import Problem
from broker.contracts.result_document import ResultDocument
from broker.contracts.summaries import MatchSummary

MOST_TARGETS: Final = 1000
"""Greatest number of targets of a batch: its description is some megabyte of JSON."""


class BatchMatch(BaseModel):
    """One match of a batch."""

    model_config = ConfigDict(frozen=True)

    target: str = Field(description="Id of the target.")
    target_name: str | None = Field(
        description="Name of the target, of the request or as stored; null in batches of earlier"
        " versions."
    )
    job: str = Field(
        description="Id of the job of this match: its result, files and transfers are those of any"
        " other match."
    )
    state: JobState = Field(description="State of the match.")
    fraction: float = Field(ge=0, le=1, description="Share of the match that is done.")
    error: Problem | None = Field(description="Why it failed.")
    summary: MatchSummary | None = Field(
        description="The answer in brief, of a match that has succeeded and is still kept."
    )


class BatchResult(ResultDocument):
    """Matches of one source with many targets, when all have ended."""

    kind: Literal["batch"] = Field(default="batch", description="Kind of the job.")
    source: str = Field(description="Id of the source, a shape or a prototype.")
    source_name: str | None = Field(
        description="Name of the source, of the request or as stored; null in batches of earlier"
        " versions."
    )
    parameters: MatchParameters = Field(description="The parameters in force.")
    matches: tuple[BatchMatch, ...] = Field(description="The matches, in the order of the targets.")
    succeeded: int = Field(description="Number of matches that have succeeded.")
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(description='"total", the seconds from the start.')
