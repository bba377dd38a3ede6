"""Captions of pictures of matches: what is certified, and how sure the answer is."""

import json
from typing import Any

import pytest

from broker.contracts import Confidence, MatchResult, Refinement
from service.http.openapi.examples import EXAMPLES
from worker.pictures import hypothesis_of

EXAMPLE: dict[str, Any] = EXAMPLES["answers"]["get_result"]["200"]["match"]


def result(**changes: Any) -> MatchResult:
    return MatchResult.model_validate_json(json.dumps(EXAMPLE)).model_copy(update=changes)


@pytest.mark.parametrize(
    ("probability", "reasons", "line"),
    [
        (0.97, (), "confidence 97 %"),
        (1.0, (), "confidence 99 %"),
        (0.8, ("few points",), "confidence 80 %: few points"),
        (0.31, ("few", "noise"), "in doubt, confidence 31 %: few; noise"),
        (0.0, (), "in doubt, confidence 1 %"),
    ],
)
def test_a_caption_tells_the_confidence(
    probability: float, reasons: tuple[str, ...], line: str
) -> None:
    told = result(confidence=Confidence(probability=probability, reasons=reasons))
    assert hypothesis_of(told, None).subtitle.splitlines()[0] == line


def test_the_match_is_not_drawn_with_the_map_of_an_alternative() -> None:
    refinement = Refinement(
        hypothesis=1, stress=0.3, initial_stress=0.4, status="converged", points=()
    )
    told = result(refinement=refinement, dense=None)
    drawn = hypothesis_of(told, None)
    assert drawn.refinement is None
    assert "refined" not in drawn.title
    assert drawn == hypothesis_of(told, 0)


def test_reasons_have_two_lines() -> None:
    reasons = ("the mirror image fits nearly as well",) * 5
    told = result(confidence=Confidence(probability=0.2, reasons=reasons))
    *lines, _ = hypothesis_of(told, 0).subtitle.splitlines()
    assert len(lines) == 2
    assert " ".join(lines) == f"in doubt, confidence 20 %: {'; '.join(reasons)}"


def test_longer_reasons_are_shortened_to_two_lines() -> None:
    reasons = ("the mirror image fits nearly as well",) * 9
    told = result(confidence=Confidence(probability=0.2, reasons=reasons))
    *lines, _ = hypothesis_of(told, 0).subtitle.splitlines()
    assert len(lines) == 2
    assert all(len(line) <= 140 for line in lines)
    assert lines[1].endswith(" …")


def test_a_caption_of_no_confidence_is_of_one_line() -> None:
    (line,) = hypothesis_of(result(confidence=None), None).subtitle.splitlines()
    assert "no better correspondence among this answer's candidates" in line


def test_a_gap_is_to_the_best_of_the_candidates() -> None:
    told = hypothesis_of(result(certified=False, gap=0.031, confidence=None), None).subtitle
    assert "within 3.1 % of the best among this answer's candidates" in told
    assert "optimal" not in told
