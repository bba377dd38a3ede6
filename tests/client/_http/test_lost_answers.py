"""Deletions whose answers are lost on their way from the running service."""

import asyncio
from collections.abc import Callable

import httpx2
import isomatch
import pytest
from isomatch._http import retries
from isomatch._models import JobRecord

from tests.client._http.test_connection import JOB
from tests.client.shapes import blob_meshes


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retries, "FIRST_PAUSE", 0.01)


class Losing(httpx2.HTTPTransport):
    """A network that loses the first answer to each deletion."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: set[str] = set()

    def handle_request(self, request: httpx2.Request) -> httpx2.Response:
        response = super().handle_request(request)
        if request.method == "DELETE" and request.url.path not in self.asked:
            self.asked.add(request.url.path)
            response.close()
            raise httpx2.ReadError("lost", request=request)
        return response


class AsyncLosing(httpx2.AsyncHTTPTransport):
    """As :class:`Losing`."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: set[str] = set()

    async def handle_async_request(self, request: httpx2.Request) -> httpx2.Response:
        response = await super().handle_async_request(request)
        if request.method == "DELETE" and request.url.path not in self.asked:
            self.asked.add(request.url.path)
            await response.aclose()
            raise httpx2.ReadError("lost", request=request)
        return response


def test_a_repeated_deletion_that_finds_nothing_has_succeeded(url: str) -> None:
    mesh = blob_meshes()[0]
    with isomatch.Client(url, transport=Losing()) as client:
        shape = client.upload((mesh.vertices, mesh.faces[:900]))
        values = client.upload_attributes({"height": mesh.vertices[:, 2]})
        job = client.match(shape, shape, points=6, orientation=False).wait()
        deletions: list[Callable[[], None]] = [
            job.delete_result,
            lambda: client.delete_shape(shape),
            lambda: client.delete_attributes(values),
        ]
        for delete in deletions:
            delete()
            with pytest.raises((isomatch.NotFound, isomatch.Gone)):
                delete()


def test_a_repeated_deletion_of_the_async_client(url: str) -> None:
    mesh = blob_meshes()[0]

    async def program() -> None:
        async with isomatch.AsyncClient(url, transport=AsyncLosing()) as client:
            shape = await client.upload((mesh.vertices, mesh.faces[:901]))
            await client.delete_shape(shape)
            with pytest.raises(isomatch.NotFound):
                await client.delete_shape(shape)

    asyncio.run(program())


def test_a_job_that_does_not_exist_is_not_cancelled_by_asking_twice(url: str) -> None:
    with isomatch.Client(url, transport=Losing()) as client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB))
        with pytest.raises(isomatch.NotFound):
            job.cancel()
