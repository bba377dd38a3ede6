"""Problem documents of failed jobs."""

import pytest

from broker.contracts import (
    AttributesValidationPayload,
    ConsistentMapsPayload,
    JobRecord,
    MatchParameters,
    MatchPayload,
    Payload,
    TransferPayload,
    ValidationPayload,
)
from tests.worker.records import CREATED
from worker.jobs.failures import JobTimedOut
from worker.jobs.problems import problem_of


@pytest.mark.parametrize(
    ("payload", "advice"),
    [
        (ValidationPayload(shape="a", file_type="laz", name="a"), "send a smaller or simpler one"),
        (
            AttributesValidationPayload(attributes="a", file_type="csv", name="a"),
            "send a smaller or simpler one",
        ),
        (
            MatchPayload(source="a", target="b", parameters=MatchParameters()),
            "try fewer points or a time_limit",
        ),
        (
            ConsistentMapsPayload(shapes=("a", "b"), parameters=MatchParameters()),
            "give fewer shapes, or simplify them",
        ),
        (
            TransferPayload(
                match="m",
                source="a",
                target="b",
                attributes=None,
                what="colors",
                direction="source_to_target",
            ),
            "simplify the shapes",
        ),
    ],
)
def test_advice_when_time_ran_out_fits_the_request(payload: Payload, advice: str) -> None:
    record = JobRecord(id="job", payload=payload, created=CREATED)
    problem = problem_of(JobTimedOut(), record)
    assert problem.detail.endswith(f"; {advice}.")
