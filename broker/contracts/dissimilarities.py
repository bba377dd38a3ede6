"""Comparing a collection of shapes: limits, stages and result."""

from typing import ClassVar, Final, Literal

from pydantic import Field, FiniteFloat

from broker.contracts.parameters import DissimilarityParameters
from broker.contracts.result_document import ResultDocument

MOST_SHAPES: Final = 2000
"""Greatest number of shapes in a comparison: its matrix is some forty megabytes of JSON."""

STRUCTURES, PAIRS, RESULT = "structures", "pairs", "result"
STAGES: Final = (STRUCTURES, PAIRS, RESULT)
"""Stages of the job: signatures of the shapes, ranges of pairs, and the result, which is one part.
"""

NEIGHBOURS: Final = 10
"""Number of nearest neighbours listed for each shape."""


class DissimilarityResult(ResultDocument):
    """Dissimilarities of all pairs of a collection, each minimal, with lower bounds."""

    ADDED: ClassVar = frozenset({"names"})

    kind: Literal["dissimilarities"] = Field(
        default="dissimilarities", description="Kind of the job."
    )
    shapes: tuple[str, ...] = Field(description="Ids of the shapes, K of them, as they were given.")
    names: tuple[str, ...] | None = Field(
        default=None, description="Their names; null in results of earlier versions."
    )
    labels: tuple[str, ...] | None = Field(description="Their labels, if any were given.")
    parameters: DissimilarityParameters = Field(description="The parameters in force.")
    matrix: tuple[tuple[FiniteFloat, ...], ...] = Field(
        description="Dissimilarities, K rows of K: symmetric, 0 on the diagonal."
    )
    lower_bounds: tuple[FiniteFloat, ...] = Field(
        description="Lower bound of the distortion of each pair of shapes, for the pairs (0, 1),"
        " (0, 2), ..., (1, 2), ...: the upper triangle of `matrix`, row by row."
    )
    certified: bool = Field(description="Whether every dissimilarity is proven to be the least.")
    uncertified: tuple[tuple[int, int], ...] = Field(
        description="Pairs of shapes, by their places, of which that is not proven."
    )
    nearest: tuple[tuple[int, ...], ...] = Field(
        description=f"Places of the nearest other shapes of each, at most {NEIGHBOURS}, the least"
        " dissimilar first."
    )
    mean_average_precision: FiniteFloat | None = Field(
        description="Mean over the shapes of their average precision: each shape ranks all others"
        " by dissimilarity, and those of its label should come first. Null without labels, or"
        " where no two shapes have the same."
    )
    precision_at_1: FiniteFloat | None = Field(
        description="Share of the shapes whose nearest other shape has the same label; null"
        " likewise."
    )
    average_precisions: tuple[FiniteFloat | None, ...] | None = Field(
        description="Average precision of each shape; null for one that is alone with its label."
    )
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(
        description='Seconds of all workers by stage, and "total", the seconds from the start.'
    )
