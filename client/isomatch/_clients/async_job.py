"""A job on the service, and what can be done with it without blocking."""

import os
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing, closing
from typing import TYPE_CHECKING, Any, Generic, Self, cast

from typing_extensions import TypeVar

from isomatch import _operations as operations
from isomatch._clients.documented_as import documented_as
from isomatch._clients.job import Job
from isomatch._clients.recorded_job import RecordedJob
from isomatch._http import AsyncTransport
from isomatch._models import JobRecord
from isomatch._results import Drawable, DrawableSource, PartialDissimilarities, Result

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

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
        self._remember(await self._transport.run(operations.get_job(self.id)))
        return self

    @documented_as(Job.wait)
    async def wait(self, timeout: float | None = None) -> Self:
        if not self.finished:
            await self._transport.run(operations.wait_for_job(self.id, timeout, self._remember))
        return self

    @documented_as(Job.events)
    async def events(self) -> AsyncGenerator[JobRecord]:
        following = operations.follow_job(self.id, self._transport.retries)
        async with aclosing(self._transport.stream(following)) as records:
            async for record in records:
                self._remember(record)
                yield record

    @documented_as(Job.result)
    async def result(self, progress: bool = False, timeout: float | None = None) -> ResultT:
        if not self.finished:
            wait = operations.watch_job if progress else operations.wait_for_job
            await self._transport.run(wait(self.id, timeout, self._remember))
        found = await self._transport.run(operations.get_result(self._record))
        found._drawables = DrawableSource(_asking(self._transport))
        return cast(ResultT, found)

    @documented_as(Job.plot)
    async def plot(self, *, alternative: int | None = None) -> "Figure":
        return await self._transport.run(operations.plot_result(self._record, alternative))

    @documented_as(Job.cancel)
    async def cancel(self) -> Self:
        self._remember(await self._transport.run(operations.cancel_job(self.id)))
        return self

    @documented_as(Job.picture)
    async def picture(self, *, alternative: int | None = None) -> bytes:
        return await self._transport.run(operations.get_picture(self.id, alternative))

    @documented_as(Job.save_picture)
    async def save_picture(
        self, path: str | os.PathLike[str], *, alternative: int | None = None
    ) -> None:
        await self._transport.run(operations.save_picture(self.id, path, alternative))

    @documented_as(Job.save_arrays)
    async def save_arrays(self, path: str | os.PathLike[str]) -> None:
        await self._transport.run(operations.save_arrays(self.id, path))

    @documented_as(Job.partial)
    async def partial(self) -> PartialDissimilarities:
        return await self._transport.run(operations.get_partial(self.id))


def _asking(transport: AsyncTransport) -> Callable[[str], Drawable] | None:
    """What asks for what is drawn in a method that is not awaited, if anything can."""
    if transport.carried:
        return None

    def ask(wanted: str) -> Drawable:
        with closing(transport.blocking()) as blocking:
            return blocking.run(operations.get_drawable(wanted))

    return ask
