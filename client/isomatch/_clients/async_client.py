"""The asynchronous client."""

import os
from collections.abc import AsyncIterator, Iterable, Sequence
from functools import partial
from types import TracebackType
from typing import Final, Unpack
from weakref import WeakKeyDictionary

import anyio
import httpx2

from isomatch._clients.async_job import AsyncJob
from isomatch._clients.async_landmark_job import AsyncLandmarkJob
from isomatch._clients.client import Client
from isomatch._clients.documented_as import documented_as
from isomatch._clients.recorded_job import RecordedJob
from isomatch._http import (
    AsyncTransport,
    api_key_or_default,
    retries_given,
    timeout_given,
    url_or_default,
)
from isomatch._landmarks import LandmarkTemplate, Placements
from isomatch._models import (
    Attributes,
    DissimilarityParameters,
    JobState,
    MatchParameters,
    PrototypeParameters,
    Shape,
    Structures,
)
from isomatch._operations import (
    batches,
    jobs,
    landmarks,
    prototypes,
    registrations,
    shapes,
    transfers,
)
from isomatch._operations.transfers import AttributesSource, Landmark
from isomatch._operations.uploads import UPLOAD_TIMEOUT
from isomatch._results import (
    Batch,
    ConsistentMaps,
    Direction,
    Dissimilarities,
    Element,
    Geometry,
    LearnedPrototype,
    Match,
    Prototype,
    PrototypePoints,
    Registration,
    Transfer,
    TransferKind,
)
from isomatch._upload import FileSource, MeshSource
from isomatch._webhooks import Webhook

WITHDRAWAL: Final = 30.0
"""Seconds for which a task that was cancelled may cancel what it has started."""


class AsyncClient:
    """A connection to an isomatch service for asyncio and trio; safe to share between tasks.

    Methods and parameters are those of :class:`isomatch.Client`; methods that block there are
    awaited here, and iterators are asynchronous. A cancelled task closes its connection; jobs on
    the service continue until they are cancelled themselves.

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
        self.base_url = url_or_default(base_url)
        self._transport = AsyncTransport(
            self.base_url,
            timeout_given(timeout),
            retries_given(retries),
            transport,
            api_key_or_default(api_key),
        )
        self._placed: Placements = WeakKeyDictionary()

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
        timeout: float | None = UPLOAD_TIMEOUT,
    ) -> Shape:
        return await self._transport.run(shapes.upload_shape(shape, name, file_type, timeout))

    @documented_as(Client.shape)
    async def shape(self, shape_id: str) -> Shape:
        return await self._transport.run(shapes.get_shape(shape_id))

    @documented_as(Client.shapes)
    def shapes(self) -> AsyncIterator[Shape]:
        return self._transport.pages(shapes.list_shapes)

    @documented_as(Client.mesh)
    async def mesh(self, shape: Shape | str) -> bytes:
        return await self._transport.run(shapes.get_mesh(shape))

    @documented_as(Client.geometry)
    async def geometry(self, shape: Shape | str) -> Geometry:
        return await self._transport.run(shapes.get_geometry(shape))

    @documented_as(Client.delete_shape)
    async def delete_shape(self, shape: Shape | str) -> None:
        await self._transport.run(shapes.delete_shape(shape))

    @documented_as(Client.structures)
    async def structures(self) -> Structures:
        return await self._transport.run(shapes.list_structures())

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
        start = jobs.start_match(source, target, parameters, webhook, idempotency_key)
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.match_many)
    async def match_many(
        self,
        source: Shape | Prototype | str,
        targets: Iterable[Shape | str],
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[MatchParameters],
    ) -> AsyncJob[Batch]:
        start = batches.start_batch(source, targets, parameters, webhook, idempotency_key)
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.upload_attributes)
    async def upload_attributes(
        self,
        values: AttributesSource,
        name: str | None = None,
        *,
        file_type: str | None = None,
        timeout: float | None = UPLOAD_TIMEOUT,
    ) -> Attributes:
        return await self._transport.run(
            transfers.upload_attributes(values, name, file_type, timeout)
        )

    @documented_as(Client.delete_attributes)
    async def delete_attributes(self, attributes: Attributes | str) -> None:
        await self._transport.run(transfers.delete_attributes(attributes))

    @documented_as(Client.transfer)
    async def transfer(
        self,
        match: RecordedJob | str,
        values: Attributes | AttributesSource | None = None,
        *,
        what: TransferKind,
        direction: Direction = "source_to_target",
        on: Element | None = None,
        names: Iterable[str] = (),
        influences: int | None = None,
        points: Iterable[Landmark] = (),
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncJob[Transfer]:
        start = transfers.start_transfer(
            match,
            values,
            what,
            direction,
            on,
            names,
            influences,
            points,
            webhook,
            idempotency_key,
        )
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.landmarks)
    async def landmarks(
        self,
        templates: Sequence[LandmarkTemplate],
        specimen: Shape | str,
        **parameters: Unpack[MatchParameters],
    ) -> AsyncLandmarkJob:
        keys: list[str] = []
        try:
            start = landmarks.start_landmarks(templates, specimen, parameters, keys)
            records = await self._transport.run(start)
        except BaseException:
            with anyio.move_on_after(WITHDRAWAL, shield=True):
                await self._transport.run(
                    landmarks.withdraw_landmarks(templates, specimen, parameters, keys)
                )
            raise
        return AsyncLandmarkJob(self._transport, templates, specimen, records, self._placed)

    @documented_as(Client.register)
    async def register(
        self,
        template: Shape | str,
        shapes: Iterable[Shape | str],
        *,
        scale: bool = False,
        largest_component: bool = False,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncJob[Registration]:
        start = registrations.start_registration(
            template, shapes, scale, largest_component, webhook, idempotency_key
        )
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.consistent_maps)
    async def consistent_maps(
        self,
        shapes: Iterable[Shape | str],
        *,
        largest_component: bool = False,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncJob[ConsistentMaps]:
        start = jobs.start_consistent_maps(shapes, largest_component, webhook, idempotency_key)
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
        start = jobs.start_dissimilarities(shapes, labels, parameters, webhook, idempotency_key)
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
        start = prototypes.start_prototype(
            shapes, correspondences, name, reference, parameters, webhook, idempotency_key
        )
        return AsyncJob(self._transport, await self._transport.run(start))

    @documented_as(Client.prototype)
    async def prototype(self, prototype_id: str) -> Prototype:
        return await self._transport.run(prototypes.get_prototype(prototype_id))

    @documented_as(Client.prototypes)
    def prototypes(self, name: str | None = None) -> AsyncIterator[Prototype]:
        return self._transport.pages(partial(prototypes.list_prototypes, name=name))

    @documented_as(Client.download_prototype)
    async def download_prototype(
        self, prototype: Prototype | str, path: str | os.PathLike[str]
    ) -> None:
        await self._transport.run(prototypes.download_prototype(prototype, path))

    @documented_as(Client.prototype_points)
    async def prototype_points(self, prototype: Prototype | str) -> PrototypePoints:
        return await self._transport.run(prototypes.get_prototype_points(prototype))

    @documented_as(Client.upload_prototype)
    async def upload_prototype(
        self,
        archive: FileSource,
        name: str | None = None,
        *,
        timeout: float | None = UPLOAD_TIMEOUT,
    ) -> Prototype:
        return await self._transport.run(prototypes.upload_prototype(archive, name, timeout))

    @documented_as(Client.delete_prototype)
    async def delete_prototype(self, prototype: Prototype | str) -> None:
        await self._transport.run(prototypes.delete_prototype(prototype))

    @documented_as(Client.job)
    async def job(self, job_id: str) -> AsyncJob:
        return AsyncJob(self._transport, await self._transport.run(jobs.get_job(job_id)))

    @documented_as(Client.jobs)
    def jobs(
        self,
        state: JobState | None = None,
        *,
        kind: str | None = None,
        of: str | Shape | Prototype | None = None,
    ) -> AsyncIterator[AsyncJob]:
        listing = partial(jobs.list_jobs, state=state, kind=kind, of=of)
        records = self._transport.pages(listing)
        return (AsyncJob(self._transport, record) async for record in records)
