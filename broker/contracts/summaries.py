"""Summaries: what a job that has succeeded says of its result without the result."""

from typing import TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.results import Confidence, Distortion


class MatchSummary(BaseModel):
    """A match in brief."""

    model_config = ConfigDict(frozen=True)

    confidence: Confidence | None = Field(
        description="How probably the answer is right; null where surfaces were not registered."
    )
    distortion: Distortion
    energy: FiniteFloat = Field(description="Energy of the labelling problem, (5) of the paper.")
    gap: FiniteFloat | None = Field(
        default=None,
        description="Relative difference of `energy` and its lower bound; null in summaries of"
        " earlier versions.",
    )
    certified: bool = Field(
        description="Whether no better correspondence exists among the candidates."
    )
    dense: bool = Field(description="Whether the match has a map of all vertices.")
    warnings: tuple[str, ...] = Field(
        default=(),
        description="What should be known about the answer; empty in summaries of earlier"
        " versions.",
    )


class PrototypeSummary(BaseModel):
    """A learned prototype in brief."""

    model_config = ConfigDict(frozen=True)

    prototype: str = Field(description="Id of the prototype.")


Summary: TypeAlias = MatchSummary | PrototypeSummary
"""A result in brief, of kinds that have one."""
