"""Waits for jobs: their arguments, and services that do not answer."""

import socket
import time
from collections.abc import Iterator
from typing import Any

import httpx2
import isomatch
import pytest
from isomatch._models import JobRecord

from tests.client._http.test_connection import JOB, Broken, client_of


@pytest.fixture
def silent() -> Iterator[str]:
    """Address of a service that takes connections, and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}"


def test_the_timeout_of_a_wait_holds_on_a_service_that_does_not_answer(silent: str) -> None:
    with isomatch.Client(silent, timeout=2.0) as client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB | {"state": "running"}))
        start = time.monotonic()
        with pytest.raises(isomatch.WaitTimeout, match=r"within 0\.5 s") as late:
            job.result(timeout=0.5)
        assert 0.5 <= time.monotonic() - start < 4.0
    assert late.value.job_id == job.id


def test_the_timeout_of_a_wait_holds_on_a_busy_service() -> None:
    busy = {"retry-after": "20"}
    with client_of(lambda _: httpx2.Response(503, headers=busy)) as client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB | {"state": "running"}))
        start = time.monotonic()
        with pytest.raises(isomatch.IsomatchError):
            job.wait(timeout=0.5)
        assert 0.5 <= time.monotonic() - start < 4.0


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
