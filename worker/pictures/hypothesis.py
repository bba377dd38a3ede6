"""The answer of a match to draw: the chosen one, or an alternative."""

import textwrap
from dataclasses import dataclass
from typing import Final, TypeVar

from broker.contracts import (
    Confidence,
    Correspondence,
    DenseCorrespondence,
    FieldProblem,
    MatchResult,
    Refinement,
)

PartT = TypeVar("PartT", Refinement, DenseCorrespondence)

_WIDTH: Final = 140
"""Characters that fit in a line below the title."""

_LINES: Final = 2
"""Lines of the confidence and the reasons for doubt."""


class NoAlternative(Exception):
    """A match has fewer alternatives.

    Parameters
    ----------
    asked
        Number of the requested one.
    count
        Number of alternatives.
    """

    def __init__(self, asked: int, count: int) -> None:
        there = f"it has {count}, numbered from 1" if count else "it has none"
        super().__init__(f"The match has no alternative {asked}: {there}; 0 is the match itself.")
        self.field = FieldProblem(field="query.alternative", message=there)


@dataclass(frozen=True)
class Hypothesis:
    """The match or an alternative to draw, with the caption of the picture.

    Parameters
    ----------
    correspondences
        Its pairs.
    refinement, dense
        Its refined points and its dense map, if it has them.
    title, subtitle
        The caption; the second of three lines at most.
    """

    correspondences: tuple[Correspondence, ...]
    refinement: Refinement | None
    dense: DenseCorrespondence | None
    title: str
    subtitle: str


def hypothesis_of(result: MatchResult, alternative: int | None) -> Hypothesis:
    """Return the answer of a match to draw.

    Parameters
    ----------
    result
        The match.
    alternative
        0 or None for the match itself, j for the j-th of its alternatives, either with a refinement
        and a dense map only if these belong to it.

    Raises
    ------
    NoAlternative
        There are fewer alternatives.
    """
    alternative = alternative or 0
    count = len(result.alternatives)
    if alternative > count:
        raise NoAlternative(alternative, count)
    refinement, dense = _own(result.refinement, alternative), _own(result.dense, alternative)
    if alternative == 0:
        captions = _captions(result.model_copy(update={"refinement": refinement}))
        return Hypothesis(result.correspondences, refinement, dense, *captions)
    other = result.alternatives[alternative - 1]
    kind = "" if other.relation is None else f", {other.relation.replace('_', ' ')}"
    title = f"alternative {alternative} of {count}{kind}: {len(other.correspondences)}"
    title += " corresponding points" + ("" if refinement is None else ", refined between vertices")
    return Hypothesis(
        other.correspondences,
        refinement,
        dense,
        title,
        f"energy {other.energy:.4g}, that of the match {result.energy:.4g}   ·   "
        f"greatest distortion {other.distortion.linf:.3g}",
    )


def _own(part: PartT | None, alternative: int) -> PartT | None:
    return part if part is not None and part.hypothesis == alternative else None


def _captions(result: MatchResult) -> tuple[str, str]:
    count, alone = len(result.correspondences), len(result.unmatched)
    title = f"{count} corresponding points" + (f", {alone} unmatched" if alone else "")
    if result.refinement is not None:
        title += ", refined between vertices"
    proof = "no better correspondence among this answer's candidates"
    if not result.certified:
        proof = f"within {100.0 * result.gap:.2g} % of the best among this answer's candidates"
    figures = (
        f"energy {result.energy:.4g}   ·   lower bound {result.lower_bound:.4g}   ·   {proof}"
        f"   ·   greatest distortion {result.distortion.linf:.3g}"
    )
    if result.confidence is None:
        return title, figures
    return title, "\n".join([*confidence_lines(result.confidence), figures])


def confidence_lines(confidence: Confidence) -> list[str]:
    """Return the confidence in two lines at most: ``in doubt, confidence 31 %: the mirror ...``.

    The percentage is never 0 or 100: no calibration is as sure as that.
    """
    said = f"confidence {min(max(round(100.0 * confidence.probability), 1), 99)} %"
    if confidence.in_doubt:
        said = f"in doubt, {said}"
    if confidence.reasons:
        said += f": {'; '.join(confidence.reasons)}"
    return textwrap.wrap(said, _WIDTH, max_lines=_LINES, placeholder=" …")
