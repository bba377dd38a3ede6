"""What an asynchronous client does with prototypes."""

import os
from collections.abc import AsyncIterator, Iterable
from functools import partial
from typing import Unpack

from isomatch._clients.async_job import AsyncJob
from isomatch._clients.prototype_client import PrototypeClient
from isomatch._clients.twins import documented_as
from isomatch._http import AsyncTransport
from isomatch._models import PrototypeParameters, Shape
from isomatch._operations import ArchiveSource, drawing
from isomatch._operations import prototype as operations
from isomatch._results import LearnedPrototype, Prototype, PrototypePoints
from isomatch._webhooks import Webhook


class AsyncPrototypeClient:
    """The part of :class:`isomatch.AsyncClient` that is about prototypes."""

    _transport: AsyncTransport

    @documented_as(PrototypeClient.learn_prototype)
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

    @documented_as(PrototypeClient.prototype)
    async def prototype(self, prototype_id: str) -> Prototype:
        return await self._transport.run(operations.get_prototype(prototype_id))

    @documented_as(PrototypeClient.prototypes)
    def prototypes(self, name: str | None = None) -> AsyncIterator[Prototype]:
        return self._transport.pages(partial(operations.list_prototypes, name=name))

    @documented_as(PrototypeClient.download_prototype)
    async def download_prototype(
        self, prototype: Prototype | str, path: str | os.PathLike[str]
    ) -> None:
        await self._transport.run(operations.download_prototype(prototype, path))

    @documented_as(PrototypeClient.prototype_points)
    async def prototype_points(self, prototype: Prototype | str) -> PrototypePoints:
        return await self._transport.run(drawing.get_points(prototype))

    @documented_as(PrototypeClient.upload_prototype)
    async def upload_prototype(
        self, archive: ArchiveSource, name: str | None = None, *, timeout: float | None = 600.0
    ) -> Prototype:
        return await self._transport.run(operations.upload_prototype(archive, name, timeout))

    @documented_as(PrototypeClient.delete_prototype)
    async def delete_prototype(self, prototype: Prototype | str) -> None:
        await self._transport.run(operations.delete_prototype(prototype))
