"""The client for asynchronous programs: the way in."""

import os
from collections.abc import AsyncIterator, Iterable
from functools import partial
from types import TracebackType
from typing import Unpack

import httpx2

from isomatch import _operations as operations
from isomatch._clients.async_job import AsyncJob
from isomatch._clients.client import Client
from isomatch._clients.documented_as import documented_as
from isomatch._http import AsyncTransport, address, key
from isomatch._models import (
    DissimilarityParameters,
    JobState,
    MatchParameters,
    PrototypeParameters,
    Shape,
    Structures,
)
from isomatch._results import (
    Dissimilarities,
    Geometry,
    LearnedPrototype,
    Match,
    Prototype,
    PrototypePoints,
)
from isomatch._upload import MeshSource
from isomatch._webhooks import Webhook


class AsyncClient:
    """A connection to an isomatch service, as :class:`isomatch.Client`, for asynchronous programs.

    What blocks there is awaited here, and what is gone through with ``for`` with ``async for``;
    everything else is the same, the parameters too. Tasks may share one. A task that is cancelled
    leaves no connection behind; jobs on the service go on unless they are cancelled themselves.

    Examples
    --------
    >>> async with AsyncClient() as client:
    ...     cat, lion = await asyncio.gather(client.upload("cat.off"), client.upload("lion.off"))
    ...     job = await client.match(cat, lion, points=32)
    ...     match = await job.result(progress=True)
    """

    def __init__(
        self,
        base_url: str | None = None,
        *,
        api_key: str | None = None,
        timeout: float | None = 60.0,
        retries: int = 3,
        transport: httpx2.AsyncBaseTransport | None = None,
    ) -> None:
        self.base_url = address(base_url)
        self._transport = AsyncTransport(self.base_url, timeout, retries, transport, key(api_key))

    async def __aenter__(self) -> "AsyncClient":
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        await self.close()

    def __repr__(self) -> str:
        return f"<AsyncClient {self.base_url}>"

    @documented_as(Client.close)
    async def close(self) -> None:
        await self._transport.close()

    @documented_as(Client.upload)
    async def upload(
        self,
        shape: MeshSource,
        name: str | None = None,
        *,
        file_type: str | None = None,
        timeout: float | None = 600.0,
    ) -> Shape:
        return await self._transport.run(operations.upload(shape, name, file_type, timeout))

    @documented_as(Client.shape)
    async def shape(self, shape_id: str) -> Shape:
        return await self._transport.run(operations.get_shape(shape_id))

    @documented_as(Client.shapes)
    def shapes(self) -> AsyncIterator[Shape]:
        return self._transport.pages(operations.list_shapes)

    @documented_as(Client.mesh)
    async def mesh(self, shape: Shape | str) -> bytes:
        return await self._transport.run(operations.get_mesh(shape))

    @documented_as(Client.geometry)
    async def geometry(self, shape: Shape | str) -> Geometry:
        return await self._transport.run(operations.get_geometry(shape))

    @documented_as(Client.delete_shape)
    async def delete_shape(self, shape: Shape | str) -> None:
        await self._transport.run(operations.delete_shape(shape))

    @documented_as(Client.structures)
    async def structures(self) -> Structures:
        return await self._transport.run(operations.list_structures())

    @documented_as(Client.match)
    async def match(
        self,
        source: Shape | Prototype | str,
        target: Shape | str,
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[MatchParameters],
    ) -> AsyncJob[Match]:
        start = operations.start_match(source, target, parameters, webhook, idempotency_key)
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.dissimilarities)
    async def dissimilarities(
        self,
        shapes: Iterable[Shape | str],
        labels: Iterable[str] | None = None,
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[DissimilarityParameters],
    ) -> AsyncJob[Dissimilarities]:
        start = operations.start_dissimilarities(
            shapes, labels, parameters, webhook, idempotency_key
        )
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.learn_prototype)
    async def learn_prototype(
        self,
        shapes: Iterable[Shape | str],
        correspondences: Iterable[Iterable[int]] | None = None,
        *,
        name: str | None = None,
        reference: Shape | str | None = None,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[PrototypeParameters],
    ) -> AsyncJob[LearnedPrototype]:
        start = operations.start_prototype(
            shapes, correspondences, name, reference, parameters, webhook, idempotency_key
        )
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.prototype)
    async def prototype(self, prototype_id: str) -> Prototype:
        return await self._transport.run(operations.get_prototype(prototype_id))

    @documented_as(Client.prototypes)
    def prototypes(self, name: str | None = None) -> AsyncIterator[Prototype]:
        return self._transport.pages(partial(operations.list_prototypes, name=name))

    @documented_as(Client.download_prototype)
    async def download_prototype(
        self, prototype: Prototype | str, path: str | os.PathLike[str]
    ) -> None:
        await self._transport.run(operations.download_prototype(prototype, path))

    @documented_as(Client.prototype_points)
    async def prototype_points(self, prototype: Prototype | str) -> PrototypePoints:
        return await self._transport.run(operations.get_prototype_points(prototype))

    @documented_as(Client.upload_prototype)
    async def upload_prototype(
        self,
        archive: operations.ArchiveSource,
        name: str | None = None,
        *,
        timeout: float | None = 600.0,
    ) -> Prototype:
        return await self._transport.run(operations.upload_prototype(archive, name, timeout))

    @documented_as(Client.delete_prototype)
    async def delete_prototype(self, prototype: Prototype | str) -> None:
        await self._transport.run(operations.delete_prototype(prototype))

    @documented_as(Client.job)
    async def job(self, job_id: str) -> AsyncJob:
        return AsyncJob(self._transport, await self._transport.run(operations.get_job(job_id)))

    @documented_as(Client.jobs)
    def jobs(
        self,
        state: JobState | None = None,
        *,
        kind: str | None = None,
        of: str | Shape | Prototype | None = None,
    ) -> AsyncIterator[AsyncJob]:
        listing = partial(operations.list_jobs, state=state, kind=kind, of=of)
        records = self._transport.pages(listing)
        return (AsyncJob(self._transport, record) async for record in records)
