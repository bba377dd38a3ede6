"""Jobs of the asynchronous client."""

import os
from collections.abc import AsyncGenerator
from contextlib import aclosing
from typing import TYPE_CHECKING, Any, Generic, Self, cast

from typing_extensions import TypeVar

from isomatch._clients.documented_as import documented_as
from isomatch._clients.job import Job
from isomatch._clients.recorded_job import RecordedJob
from isomatch._http import AsyncTransport, wait_given
from isomatch._models import JobRecord
from isomatch._operations import batches, jobs, registrations, results
from isomatch._operations.batches import EndedMatches
from isomatch._operations.results import View
from isomatch._results import (
    BatchProgress,
    Match,
    PartialDissimilarities,
    Result,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

ResultT = TypeVar("ResultT", bound=Result, default=Any)


class AsyncJob(RecordedJob, Generic[ResultT]):
    """A job on the service; its methods are those of :class:`isomatch.Job`, awaited.

    A cancelled task leaves the job running; :meth:`cancel` cancels the job.
    """

    def __init__(self, transport: AsyncTransport, record: JobRecord) -> None:
        super().__init__(record)
        self._transport = transport

    @documented_as(Job.refresh)
    async def refresh(self) -> Self:
        self._remember(await self._transport.run(jobs.get_job(self.id)))
        return self

    @documented_as(Job.wait)
    async def wait(self, timeout: float | None = None) -> Self:
        limit = wait_given(timeout)
        if not self.finished:
            await self._transport.run(jobs.wait_for_job(self.id, limit, self._remember))
        return self

    @documented_as(Job.events)
    async def events(self) -> AsyncGenerator[JobRecord]:
        following = jobs.follow_job(self.id, self._transport.retries)
        async with aclosing(self._transport.stream(following)) as records:
            async for record in records:
                self._remember(record)
                yield record

    @documented_as(Job.result)
    async def result(self, progress: bool = False, timeout: float | None = None) -> ResultT:
        limit = wait_given(timeout)
        if not self.finished:
            wait = jobs.watch_job if progress else jobs.wait_for_job
            await self._transport.run(wait(self.id, limit, self._remember))
        return cast(ResultT, await self._transport.run(results.get_result(self._record)))

    @documented_as(Job.plot)
    async def plot(self, *, alternative: int | None = None) -> "Figure":
        return await self._transport.run(results.plot_result(self._record, alternative))

    @documented_as(Job.delete_result)
    async def delete_result(self) -> None:
        await self._transport.run(results.delete_result(self.id))

    @documented_as(Job.cancel)
    async def cancel(self) -> Self:
        self._remember(await self._transport.run(jobs.cancel_job(self.id)))
        return self

    @documented_as(Job.picture)
    async def picture(self, *, alternative: int | None = None, view: View | None = None) -> bytes:
        return await self._transport.run(results.get_picture(self.id, alternative, view))

    @documented_as(Job.save_picture)
    async def save_picture(
        self,
        path: str | os.PathLike[str],
        *,
        alternative: int | None = None,
        view: View | None = None,
    ) -> None:
        await self._transport.run(results.save_picture(self.id, path, alternative, view))

    @documented_as(Job.save)
    async def save(self, path: str | os.PathLike[str]) -> None:
        await self._transport.run(results.save(self._record, path))

    @documented_as(Job.save_arrays)
    async def save_arrays(self, path: str | os.PathLike[str]) -> None:
        await self._transport.run(results.save_arrays(self.id, path))

    @documented_as(Job.save_registered)
    async def save_registered(self, path: str | os.PathLike[str], specimen: int = 0) -> None:
        await self._transport.run(registrations.save_registered(self.id, path, specimen))

    @documented_as(Job.partial)
    async def partial(self) -> PartialDissimilarities:
        return await self._transport.run(results.get_partial(self.id))

    @documented_as(Job.matches)
    async def matches(self) -> BatchProgress:
        return await self._transport.run(batches.get_batch(self.id))

    @documented_as(Job.ended_matches)
    async def ended_matches(self) -> AsyncGenerator["AsyncJob[Match]"]:
        ended = EndedMatches()
        async with aclosing(self.events()) as changes:
            async for _ in changes:
                for match in ended.new(await self.matches()):
                    record = await self._transport.run(jobs.get_job(match))
                    yield AsyncJob(self._transport, record)
        for match in ended.others(await self.matches()):
            record = await self._transport.run(jobs.get_job(match))
            yield await AsyncJob(self._transport, record).wait()
