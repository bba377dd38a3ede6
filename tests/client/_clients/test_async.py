"""The async client: with the running service, and with connections that break."""

import asyncio
import re
from collections.abc import AsyncIterator
from pathlib import Path

import httpx2
import isomatch
import numpy as np
import pytest
import trio
from isomatch._http import retries

from tests.client._http.test_events import JOB, event
from tests.client.shapes import LASTING, blob_meshes


def test_a_match_from_end_to_end(url: str, blobs: tuple[Path, Path], tmp_path: Path) -> None:
    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            source, target = await asyncio.gather(*map(client.upload, blobs))
            assert source.id in [shape.id async for shape in client.shapes()]
            assert await client.shape(source.id) == source
            assert await client.mesh(source) == blobs[0].read_bytes()
            job = await client.match(source, target, points=12)
            told = [(event.state, event.progress.fraction) async for event in job.events()]
            assert told[-1] == ("succeeded", 1.0)
            assert job.finished
            match = await job.result()
            assert match.pairs.shape == (12, 2)
            await job.save_picture(tmp_path / "match.png")
            assert (await (await client.job(job.id)).result()) == match
            assert job.id in [other.id async for other in client.jobs("succeeded")]
            assert "geodesic" in [metric.name for metric in (await client.structures()).metrics]
            with pytest.raises(isomatch.NotFound):
                await client.shape("0" * 32)
            with pytest.raises(isomatch.InvalidRequest):
                await client.match(source, target, points=2)

    asyncio.run(program())
    assert (tmp_path / "match.png").read_bytes().startswith(b"\x89PNG")


def test_concurrent_tasks(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = blob_meshes()[0]

    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            scaled = [(mesh.vertices * scale, mesh.faces) for scale in (1.5, 2.0, 3.0)]
            shapes = await asyncio.gather(*map(client.upload, scaled))
            assert len({shape.id for shape in shapes}) == 3

            async def matched(other: isomatch.Shape, points: int) -> isomatch.Match:
                job = await client.match(shapes[0], other, points=points, orientation=False)
                return await job.result(progress=points == 6)

            wanted = [(shape, points) for shape in shapes for points in (6, 7)]
            found = await asyncio.gather(*(matched(*one) for one in wanted))
            assert [len(match.pairs) for match in found] == [6, 7] * 3
            assert [match.target for match in found] == [shape.id for shape, _ in wanted]

            job = await client.dissimilarities(shapes, points=4, eigenpairs=30)
            result = await job.result()
            assert result.matrix == pytest.approx(np.zeros((3, 3)), abs=1e-6)
            assert (await job.partial()).pairs_done == 3

    asyncio.run(program())
    assert re.search(r"100%  match \w+: succeeded", capsys.readouterr().err)


def test_a_cancelled_task_leaves_the_job_running(url: str, blobs: tuple[Path, Path]) -> None:
    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            source, target = await asyncio.gather(*map(client.upload, blobs))
            job = await client.match(source, target, **LASTING)

            async def follow() -> None:
                async for _ in job.events():
                    pass

            for waiting in (job.wait, job.result, follow):
                task = asyncio.create_task(waiting())
                await asyncio.sleep(0.3)
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
            assert len(asyncio.all_tasks()) == 1
            assert not (await job.refresh()).finished
            with pytest.raises(isomatch.WaitTimeout):
                await job.wait(timeout=0.0)
            await job.cancel()
            await job.wait(timeout=240)
            with pytest.raises(isomatch.JobCancelled):
                await job.result()

    asyncio.run(program())


def test_trio(url: str, blobs: tuple[Path, Path]) -> None:
    async def program() -> int:
        async with isomatch.AsyncClient(url) as client:
            return (await client.upload(blobs[0])).vertices

    assert trio.run(program) == 642


class Breaking(httpx2.AsyncByteStream):
    """A stream that breaks off."""

    def __init__(self, *chunks: bytes) -> None:
        self.chunks = chunks
        self.closed = False

    async def __aiter__(self) -> AsyncIterator[bytes]:
        for chunk in self.chunks:
            yield chunk
        raise httpx2.ReadError("broken", request=httpx2.Request("GET", "http://service.test"))

    async def aclose(self) -> None:
        self.closed = True


def test_a_broken_stream_is_resumed_and_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retries, "FIRST_PAUSE", 0.01)
    streams = [
        Breaking(event("a"), event("b", state="running")),
        Breaking(),
        Breaking(event("c", state="running"), event("d", state="succeeded")),
    ]
    left = list(streams)
    seen = []

    def answer(request: httpx2.Request) -> httpx2.Response:
        if not request.url.path.endswith("/events"):
            return httpx2.Response(200, json=JOB)
        seen.append(request.headers.get("last-event-id"))
        headers = {"content-type": "text/event-stream"}
        return httpx2.Response(200, headers=headers, stream=left.pop(0))

    async def program() -> list[str]:
        transport = httpx2.MockTransport(answer)
        async with isomatch.AsyncClient("http://service.test", transport=transport) as client:
            job = await client.job("1")
            return [told.state async for told in job.events()]

    assert asyncio.run(program()) == ["queued", "running", "running", "succeeded"]
    assert seen == [None, "b", "b"]
    assert all(stream.closed for stream in streams)


def test_failed_requests_are_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retries, "FIRST_PAUSE", 0.01)
    requests = []

    def answer(request: httpx2.Request) -> httpx2.Response:
        requests.append(request)
        if len(requests) == 1:
            raise httpx2.ReadError("broken", request=request)
        if len(requests) == 2:
            return httpx2.Response(503, headers={"retry-after": "0"})
        return httpx2.Response(200, json=JOB)

    async def program() -> str:
        transport = httpx2.MockTransport(answer)
        async with isomatch.AsyncClient("http://service.test", transport=transport) as client:
            return (await client.match("a", "b")).id

    assert asyncio.run(program()) == "1"
    assert len({request.headers["idempotency-key"] for request in requests}) == 1
    assert len(requests) == 3
