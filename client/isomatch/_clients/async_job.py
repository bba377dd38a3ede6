"""A job on the service, and what can be done with it without blocking."""

import os
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing, closing
from typing import TYPE_CHECKING, Any, Generic, Self, cast

from typing_extensions import TypeVar

from isomatch._clients.job import Job
from isomatch._clients.job_record import RecordedJob
from isomatch._clients.twins import documented_as
from isomatch._http import AsyncTransport
from isomatch._models import JobRecord
from isomatch._operations import drawing
from isomatch._operations import job as job_operations
from isomatch._operations import result as result_operations
from isomatch._results import Drawable, GeometrySource, PartialDissimilarities, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ResultT = TypeVar("ResultT", bound=Result, default=Any)


class AsyncJob(RecordedJob, Generic[ResultT]):
    """A job on the service, as :class:`isomatch.Job`, whose methods are to be awaited.

    A task that is cancelled while it waits leaves the job as it is: :meth:`cancel` cancels it.
    """

    def __init__(self, transport: AsyncTransport, record: JobRecord) -> None:
        super().__init__(record)
        self._transport = transport

    @documented_as(Job.refresh)
    async def refresh(self) -> Self:
        self._remember(await self._transport.run(job_operations.get_job(self.id)))
        return self

    @documented_as(Job.wait)
    async def wait(self, timeout: float | None = None) -> Self:
        if not self.finished:
            await self._transport.run(job_operations.wait_for_job(self.id, timeout, self._remember))
        return self

    @documented_as(Job.events)
    async def events(self) -> AsyncGenerator[JobRecord]:
        following = job_operations.follow_job(self.id, self._transport.retries)
        async with aclosing(self._transport.stream(following)) as records:
            async for record in records:
                self._remember(record)
                yield record

    @documented_as(Job.result)
    async def result(self, progress: bool = False, timeout: float | None = None) -> ResultT:
        if not self.finished:
            wait = job_operations.watch_job if progress else job_operations.wait_for_job
            await self._transport.run(wait(self.id, timeout, self._remember))
        found = await self._transport.run(result_operations.get_result(self._record))
        found._geometries = GeometrySource(_asking(self._transport))
        return cast(ResultT, found)

    @documented_as(Job.plot)
    async def plot(
        self, path: str | os.PathLike[str] | None = None, *, alternative: int | None = None
    ) -> "Figure":
        return await self._transport.run(drawing.plot_result(self._record, path, alternative))

    @documented_as(Job.cancel)
    async def cancel(self) -> Self:
        self._remember(await self._transport.run(job_operations.cancel_job(self.id)))
        return self

    @documented_as(Job.picture)
    async def picture(self, *, alternative: int | None = None) -> bytes:
        return await self._transport.run(result_operations.get_picture(self.id, alternative))

    @documented_as(Job.save_picture)
    async def save_picture(
        self, path: str | os.PathLike[str], *, alternative: int | None = None
    ) -> None:
        await self._transport.run(result_operations.save_picture(self.id, path, alternative))

    @documented_as(Job.save_arrays)
    async def save_arrays(self, path: str | os.PathLike[str]) -> None:
        await self._transport.run(result_operations.save_arrays(self.id, path))

    @documented_as(Job.partial)
    async def partial(self) -> PartialDissimilarities:
        return await self._transport.run(result_operations.get_partial(self.id))


def _asking(transport: AsyncTransport) -> Callable[[str], Drawable] | None:
    """What asks for what is drawn in a method that is not awaited, if anything can."""
    if transport.carried:
        return None

    def ask(wanted: str) -> Drawable:
        with closing(transport.blocking()) as blocking:
            return blocking.run(drawing.get_drawable(wanted))

    return ask
