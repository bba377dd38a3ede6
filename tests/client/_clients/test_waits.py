"""Waits for jobs: their arguments."""

from typing import Any

import httpx2
import isomatch
import pytest
from isomatch._models import JobRecord

from tests.client._http.test_connection import JOB, Broken, client_of


def test_the_timeout_of_a_result_is_not_taken_for_its_progress() -> None:
    with client_of(Broken(0, httpx2.ReadError, JOB)) as client:
        record = JobRecord.model_validate(JOB)
        jobs: list[Any] = [
            isomatch.Job(client._transport, record),
            isomatch.LandmarkJob(client._transport, [], "", [record]),
        ]
        for job in jobs:
            with pytest.raises(TypeError, match="positional"):
                job.result(60)
