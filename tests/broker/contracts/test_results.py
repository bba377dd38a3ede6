"""Results of matches as they are stored: confidence, images, and what older versions left out."""

import json
from typing import Any

import pytest
from pydantic import ValidationError

from broker.contracts import Confidence, DenseCorrespondence, JobKind, MatchResult
from broker.contracts.result_document import ResultDocument
from service.http.openapi.examples import EXAMPLES

EXAMPLE: dict[str, Any] = EXAMPLES["answers"]["get_result"]["200"]["match"]


def test_the_example_of_the_document_is_a_result() -> None:
    assert MatchResult.model_validate_json(json.dumps(EXAMPLE)).confidence == Confidence(
        probability=0.97, reasons=()
    )


def test_results_of_older_versions_are_read() -> None:
    late = MatchResult.ADDED | {"kind", "job"}
    old = {name: value for name, value in EXAMPLE.items() if name not in late}
    old["dense"] = {"hypothesis": 0, "source": [0, 1], "target": [5, 5]}
    found = MatchResult.model_validate_json(json.dumps(old))
    assert (found.kind, found.job) == ("match", None)
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


def test_results_are_told_apart_by_the_kinds_of_jobs() -> None:
    schemas = [one.model_json_schema() for one in ResultDocument.__subclasses__()]
    kinds = {schema["properties"]["kind"]["const"] for schema in schemas}
    assert kinds == {one.value for one in JobKind if one.has_result}
    for schema in schemas:
        assert not {"kind", "job"} & set(schema["required"])


def test_fields_that_every_stored_result_has_are_required() -> None:
    required = MatchResult.model_json_schema()["required"]
    assert {"version", "source_kind", "dense"} <= set(required)
    assert not MatchResult.ADDED & set(required)
    assert set(MatchResult.model_fields) >= MatchResult.ADDED
