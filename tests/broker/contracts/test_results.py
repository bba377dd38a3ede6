"""Results of matches as they are stored: confidence, images, and what older versions left out."""

import json
from typing import Any

import pytest
from pydantic import ValidationError

from broker.contracts import Confidence, DenseCorrespondence, MatchResult
from service.http.openapi.examples import EXAMPLES

EXAMPLE: dict[str, Any] = EXAMPLES["answers"]["get_result"]["200"]["match"]


def test_the_example_of_the_document_is_a_result() -> None:
    assert MatchResult.model_validate_json(json.dumps(EXAMPLE)).confidence == Confidence(
        probability=0.97, reasons=()
    )


def test_results_of_older_versions_are_read() -> None:
    old = {name: value for name, value in EXAMPLE.items() if name != "confidence"}
    old["dense"] = {"hypothesis": 0, "source": [0, 1], "target": [5, 5]}
    found = MatchResult.model_validate_json(json.dumps(old))
    assert found.confidence is None
    assert found.dense == DenseCorrespondence(hypothesis=0, source=(0, 1), target=(5, 5))
    assert (found.dense.faces, found.dense.barycentric) == ((), ())


@pytest.mark.parametrize(("probability", "doubtful"), [(0.0, True), (0.5, True), (0.51, False)])
def test_an_answer_that_is_not_likely_is_in_doubt(probability: float, doubtful: bool) -> None:
    assert Confidence(probability=probability, reasons=()).in_doubt is doubtful


@pytest.mark.parametrize("probability", [-0.1, 1.1, float("nan")])
def test_a_probability_is_between_0_and_1(probability: float) -> None:
    with pytest.raises(ValidationError):
        Confidence(probability=probability, reasons=())
