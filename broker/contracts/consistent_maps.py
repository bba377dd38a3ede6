"""Consistent maps: maps between all shapes of a collection, improved by one another."""

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.result_document import ResultDocument
from broker.contracts.results import Confidence

MOST_MAPPED_SHAPES: Final = 16
"""Greatest number of shapes of a collection: they have 120 pairs, matched by one worker."""

MOST_MAPPED_VERTICES: Final = 8_000_000
"""Greatest number of vertices of all maps of a collection: each is kept in 8 bytes."""


class CollectionShape(BaseModel):
    """One shape of a collection."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    shape: str = Field(description="Id of the shape.")
    name: str | None = Field(description="Its name.")
    cycle_error_before: FiniteFloat | None = Field(
        description="Mean cycle error of the triples that the shape is in, by the pairwise maps;"
        " null if it is in none."
    )
    cycle_error: FiniteFloat | None = Field(description="The same by the maps of the result.")
    fits: bool = Field(
        description="Whether it was mapped, and at least half of its maps agree with the others."
    )
    reason: str | None = Field(description="Why it does not fit; null if it does.")


class CollectionPair(BaseModel):
    """The map of one pair of shapes, and its inverse; measures are null if there is none."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    source: str = Field(description="Id of the source.")
    source_name: str | None = Field(description="Its name.")
    target: str = Field(description="Id of the target.")
    target_name: str | None = Field(description="Its name.")
    mapped: bool = Field(description="Whether there is a map.")
    confidence_before: Confidence | None = Field(description="Confidence of the pairwise match.")
    confidence: Confidence | None = Field(
        description="Confidence of the map of the result: that of the pairwise match, or of the"
        " composition that replaced it."
    )
    cycle_error_before: FiniteFloat | None = Field(
        description="Cycle error of the pairwise map: median over the third shapes, of two"
        " middle ones the lesser; null if no third shape is mapped to both."
    )
    cycle_error: FiniteFloat | None = Field(description="The same by the maps of the result.")
    through: tuple[str, ...] = Field(
        description="Ids of the shapes through which the map was found, in order from source to"
        " target; empty if the pairwise map was kept. A map between two of them may itself have"
        " been found through other shapes before."
    )
    fits: bool = Field(
        description="Whether there is a map that is probably right and agrees with the others."
    )
    reason: str | None = Field(description="Why it does not fit; null if it does.")


class ConsistentMapsResult(ResultDocument):
    """Maps between all shapes of a collection that agree with one another.

    Cycle errors are mean distances in space, over the square root of the target's area, between
    the images of samples by the map of a pair, and by way of a third shape.
    """

    kind: Literal["consistent_maps"] = Field(
        default="consistent_maps", description="Kind of the job."
    )
    shapes: tuple[CollectionShape, ...] = Field(
        description="The shapes, in the order in which they were given."
    )
    pairs: tuple[CollectionPair, ...] = Field(
        description="All pairs (0, 1), (0, 2), ..., (1, 2), ... of the shapes."
    )
    cycle_error_before: FiniteFloat | None = Field(
        description="Mean cycle error of all triples by the pairwise maps; null if there is no"
        " triple."
    )
    cycle_error: FiniteFloat | None = Field(description="The same by the maps of the result.")
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(description='Seconds by stage, and "total".')
