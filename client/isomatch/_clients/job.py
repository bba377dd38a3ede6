"""A job on the service, and what can be done with it."""

import os
from collections.abc import Generator
from typing import TYPE_CHECKING, Any, Generic, Self, cast

from typing_extensions import TypeVar

from isomatch import _operations as operations
from isomatch._clients.recorded_job import RecordedJob
from isomatch._http import BlockingTransport
from isomatch._models import JobRecord
from isomatch._results import DrawableSource, PartialDissimilarities, Result

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

ResultT = TypeVar("ResultT", bound=Result, default=Any)


class Job(RecordedJob, Generic[ResultT]):
    """A job on the service, with a result of a kind: a match, or dissimilarities.

    The attributes say what the service said last; :meth:`refresh` asks again. Methods raise
    :class:`~isomatch.ConnectionFailed` and :class:`~isomatch.ProblemError` besides what they name.
    """

    def __init__(self, transport: BlockingTransport, record: JobRecord) -> None:
        super().__init__(record)
        self._transport = transport

    def refresh(self) -> Self:
        """Ask the service how the job is, and return the job."""
        self._remember(self._transport.run(operations.get_job(self.id)))
        return self

    def wait(self, timeout: float | None = None) -> Self:
        """Wait until the job has ended, in whatever way, and return it.

        Raises
        ------
        WaitTimeout
            It did not end within `timeout` seconds.
        """
        if not self.finished:
            self._transport.run(operations.wait_for_job(self.id, timeout, self._remember))
        return self

    def events(self) -> Generator[JobRecord]:
        """Go through what the service tells of the job as it changes, until it has ended.

        Yields the job's record, at once and after each change; the job itself is up to date then
        too. A connection that breaks is taken up again where it broke.
        """
        for record in self._transport.stream(
            operations.follow_job(self.id, self._transport.retries)
        ):
            self._remember(record)
            yield record

    def result(self, progress: bool = False, timeout: float | None = None) -> ResultT:
        """Wait for the job's end and return its result.

        Parameters
        ----------
        progress
            Draw a progress bar on the standard error meanwhile.
        timeout
            Seconds to wait; None for as long as it takes.

        Raises
        ------
        JobFailed
            It failed; the problem document says why.
        JobCancelled
            It was cancelled.
        WaitTimeout
            It did not end within `timeout` seconds; it goes on.
        """
        if not self.finished:
            wait = operations.watch_job if progress else operations.wait_for_job
            self._transport.run(wait(self.id, timeout, self._remember))
        found = self._transport.run(operations.get_result(self._record))
        found._drawables = DrawableSource(
            lambda wanted: self._transport.run(operations.get_drawable(wanted))
        )
        return cast(ResultT, found)

    def plot(self, *, alternative: int | None = None) -> "Figure":
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
        return self._transport.run(operations.plot_result(self._record, alternative))

    def cancel(self) -> Self:
        """Cancel the job, whether it is queued or running, and return it.

        A job that has ended stays as it is.
        """
        self._remember(self._transport.run(operations.cancel_job(self.id)))
        return self

    def picture(self, *, alternative: int | None = None) -> bytes:
        """Return the picture of the result, a PNG file.

        Parameters
        ----------
        alternative
            Of a match, which answer is drawn: 0 for its own pairs, j for ``alternatives[j - 1]``.

        Raises
        ------
        Conflict
            There is no result (yet).
        InvalidRequest
            There is no such alternative.
        """
        return self._transport.run(operations.get_picture(self.id, alternative))

    def save_picture(self, path: str | os.PathLike[str], *, alternative: int | None = None) -> None:
        """Write the picture of the result to a PNG file; as :meth:`picture`.

        Raises
        ------
        Conflict
            There is no result (yet).
        OSError
            The file cannot be written.
        """
        self._transport.run(operations.save_picture(self.id, path, alternative))

    def save_arrays(self, path: str | os.PathLike[str]) -> None:
        """Write the result's arrays, in full precision, to a NumPy file, ``.npz``.

        Raises
        ------
        Conflict
            There is no result (yet), or none that has arrays.
        OSError
            The file cannot be written.
        """
        self._transport.run(operations.save_arrays(self.id, path))

    def partial(self) -> PartialDissimilarities:
        """Return the dissimilarities that are known so far.

        Raises
        ------
        Conflict
            The job failed, or compares no collection.
        """
        return self._transport.run(operations.get_partial(self.id))
