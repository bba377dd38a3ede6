"""Jobs of the asynchronous client."""

import os
from collections.abc import AsyncGenerator
from contextlib import aclosing
from typing import TYPE_CHECKING, Any, Generic, Self, cast

from typing_extensions import TypeVar

from isomatch._clients.drawables import with_drawables
from isomatch._clients.recorded_job import RecordedJob
from isomatch._http import AsyncTransport, delete, fetch, wait_given
from isomatch._models import JobRecord
from isomatch._operations import jobs, registrations, results
from isomatch._operations.batches import EndedMatches
from isomatch._operations.request_parts import path_to
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
    """A job on the service: a match, a batch of them, a comparison of a collection, and so on.

    The attributes are those of the service's last answer; :meth:`refresh` updates them. Besides
    the errors they list, methods raise :class:`~isomatch.ConnectionFailed` and
    :class:`~isomatch.ProblemError`.

    A cancelled task leaves the job running; :meth:`cancel` cancels the job.
    """

    def __init__(self, transport: AsyncTransport, record: JobRecord) -> None:
        super().__init__(record)
        self._transport = transport

    async def refresh(self) -> Self:
        """Update the job from the service, and return it."""
        self._remember(await self._transport.run(jobs.get_job(self.id)))
        return self

    async def wait(self, timeout: float | None = None) -> Self:
        """Wait until the job has succeeded, failed or been cancelled, and return it.

        Raises
        ------
        WaitTimeout
            The job did not end within `timeout` seconds.
        TypeError, ValueError
            `timeout` is no number, or negative.
        """
        limit = wait_given(timeout)
        if not self.finished:
            await self._transport.run(jobs.wait_for_job(self.id, limit, self._remember))
        return self

    async def events(self) -> AsyncGenerator[JobRecord]:
        """Yield the record of the job, at once and at each change, until the job has ended.

        The job itself is updated, too. A broken connection is resumed where it broke.
        """
        following = jobs.follow_job(self.id, self._transport.retries)
        async with aclosing(self._transport.stream(following)) as records:
            async for record in records:
                self._remember(record)
                yield record

    async def result(self, *, progress: bool = False, timeout: float | None = None) -> ResultT:
        """Wait until the job has ended, and return its result.

        Parameters
        ----------
        progress
            Show a progress bar on the standard error.
        timeout
            Seconds to wait; None for no limit.

        Raises
        ------
        JobFailed
            The job failed; the problem document gives the reason.
        JobCancelled
            The job was cancelled.
        WaitTimeout
            The job did not end within `timeout` seconds; it continues.
        TypeError, ValueError
            `timeout` is no number, or negative.
        """
        limit = wait_given(timeout)
        if not self.finished:
            wait = jobs.watch_job if progress else jobs.wait_for_job
            await self._transport.run(wait(self.id, limit, self._remember))
        found = await self._transport.run(results.get_result(self._record))
        return cast(ResultT, with_drawables(found, self._transport))

    async def plot(self, *, alternative: int | None = None) -> "Figure":
        """Draw the result of a job that has ended with plotly: see :meth:`isomatch.Match.plot`.

        Parameters
        ----------
        alternative
            Solution of a match, as for :meth:`isomatch.Match.plot`.

        Raises
        ------
        MissingExtra
            plotly is not installed.
        Conflict, JobFailed, JobCancelled
            There is no result (yet).
        ValueError
            There is no such alternative.
        """
        return await self._transport.run(results.plot_result(self._record, alternative))

    async def delete_result(self) -> None:
        """Delete the result of a job that has ended, with those of a batch's matches.

        The job itself stays.

        Raises
        ------
        Conflict
            There is no result (yet).
        Gone
            It has expired, or was deleted before.
        """
        await self._transport.run(delete(path_to("jobs", self.id, "result")))

    async def cancel(self) -> Self:
        """Cancel the job if it is queued or running, and return it."""
        self._remember(await self._transport.run(jobs.cancel_job(self.id)))
        return self

    async def picture(self, *, alternative: int | None = None, view: View | None = None) -> bytes:
        """Return the picture of the result, a PNG file.

        Parameters
        ----------
        alternative
            Solution of a match: 0, the default, for its own pairs, j for ``alternatives[j - 1]``. A
            refinement or dense map is drawn only with the solution that it belongs to.
        view
            Side of a match's source from which both shapes are seen, ``"front"``, ``"back"``,
            ``"left"``, ``"right"``, ``"top"`` or ``"bottom"``; by default the front.

        Raises
        ------
        Conflict
            There is no result (yet).
        InvalidRequest
            There is no such alternative.
        """
        return await self._transport.run(results.get_picture(self.id, alternative, view))

    async def save_picture(
        self,
        path: str | os.PathLike[str],
        *,
        alternative: int | None = None,
        view: View | None = None,
    ) -> None:
        """Write the picture of the result, see :meth:`picture`, to a PNG file.

        Raises
        ------
        Conflict
            There is no result (yet).
        OSError, ValueError
            The file cannot be written, or its name has another ending than ``.png``.
        """
        await self._transport.run(results.save_picture(self.id, path, alternative, view))

    async def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file, in the format that its name ends in.

        ``.json``, or no ending, is the document, ``.npz`` the arrays, ``.png`` the picture. Of a
        match ``.csv`` has the pairs of matched points alone; ``.json`` and ``.npz`` have the map of
        all vertices, too, if there is one, of which ``.ply`` and ``.obj`` show the target in the
        colours of the source, and ``.glb`` both. Of dissimilarities ``.csv`` has the matrix. Of a
        transfer ``.csv`` has the values, and ``.ply``, ``.obj`` and ``.glb`` the shape with them;
        of a texture or texture coordinates ``.zip`` has OBJ with the images. Of a registration
        ``.ply``, ``.obj`` and ``.glb`` have the mean shape.

        Raises
        ------
        Conflict
            There is no result (yet), or none of this format.
        JobFailed, JobCancelled
            The job ended without a result.
        InvalidRequest, Unprocessable
            The format cannot hold these values; the message gives the reason.
        OSError, ValueError
            The file cannot be written, or its name has another ending.
        """
        await self._transport.run(results.save(self._record, path))

    async def save_arrays(self, path: str | os.PathLike[str]) -> None:
        """Write the arrays of the result to a NumPy file, ``.npz``.

        In full precision, but for the barycentric coordinates of dense maps, of four decimals.

        Raises
        ------
        Conflict
            There is no result (yet), or it has no arrays.
        OSError, ValueError
            The file cannot be written, or its name has another ending.
        """
        await self._transport.run(results.save_arrays(self.id, path))

    async def save_registered(self, path: str | os.PathLike[str], specimen: int = 0) -> None:
        """Write a registered template, the source of a dense match or a registration's template.

        Parameters
        ----------
        path
            A PLY, OBJ or GLB file. Vertex i is vertex i of the source's or the template's file, in
            the coordinates of the target or the specimen.
        specimen
            Place of the specimen among those of the registration.

        Raises
        ------
        Conflict
            There is no result (yet), the match is not dense, or the template was not registered to
            this specimen.
        InvalidRequest
            There is no such specimen.
        OSError, ValueError
            The file cannot be written, or its name has another ending.
        """
        await self._transport.run(registrations.save_registered(self.id, path, specimen))

    async def partial(self) -> PartialDissimilarities:
        """Return the dissimilarities computed so far.

        Raises
        ------
        Conflict
            The job failed, or does not compare a collection.
        """
        return await self._transport.run(
            fetch(PartialDissimilarities, path_to("dissimilarities", self.id))
        )

    async def matches(self) -> BatchProgress:
        """Return the matches of a batch as they are now.

        Raises
        ------
        Conflict
            The job is not a batch.
        """
        return await self._transport.run(fetch(BatchProgress, path_to("batches", self.id)))

    async def ended_matches(self) -> AsyncGenerator["AsyncJob[Match]"]:
        """Yield the job of each match of a batch as soon as it has ended, until all have.

        Raises
        ------
        Conflict
            The job is not a batch.

        Examples
        --------
        >>> batch = await client.match_many(template, scans, dense=True)
        >>> async for job in batch.ended_matches():
        ...     if job.state == "succeeded":
        ...         match = await job.result()
        ...         await job.save(f"{match.target_name}.ply")
        """
        ended = EndedMatches()
        async with aclosing(self.events()) as changes:
            async for _ in changes:
                for match in ended.new(await self.matches()):
                    record = await self._transport.run(jobs.get_job(match))
                    yield AsyncJob(self._transport, record)
        # A cancelled batch has ended before those of its matches that were running.
        for match in ended.others(await self.matches()):
            record = await self._transport.run(jobs.get_job(match))
            yield await AsyncJob(self._transport, record).wait()
