"""Calls after the client was closed."""

import asyncio
import json

import httpx2
import isomatch
import pytest
from isomatch._models import JobRecord

from service.http.openapi.examples import EXAMPLES
from tests.client._http.test_connection import JOB

ADDRESS = "http://service.test"
RESULT = json.dumps(EXAMPLES["answers"]["get_result"]["200"]["match"])


def answer(_: httpx2.Request) -> httpx2.Response:
    return httpx2.Response(200, text=RESULT)


def test_a_closed_client_is_named() -> None:
    with isomatch.Client(ADDRESS, transport=httpx2.MockTransport(answer)) as client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB))
    for call in (lambda: client.shape("1"), job.refresh, lambda: list(job.events())):
        with pytest.raises(isomatch.ClientClosed, match="is closed; make a new one"):
            call()


def test_a_closed_asynchronous_client_is_named() -> None:
    async def ask() -> None:
        async with isomatch.AsyncClient(ADDRESS, transport=httpx2.MockTransport(answer)) as client:
            pass
        await client.shape("1")

    with pytest.raises(isomatch.ClientClosed, match="is closed; make a new one"):
        asyncio.run(ask())


def test_a_result_of_a_closed_client_says_what_to_draw_it_with() -> None:
    with isomatch.Client(ADDRESS, transport=httpx2.MockTransport(answer)) as client:
        record = JobRecord.model_validate(JOB | {"kind": "match"})
        match = isomatch.Job(client._transport, record).result()
    with pytest.raises(ValueError, match=rf"result\.plot\(client\.geometry\('{match.source}'\)"):
        match.plot()
