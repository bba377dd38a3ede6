"""A job on the service, and what can be done with it."""

import os
import time
from collections.abc import Generator
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import Any, Generic, Self, cast

import httpx2
from typing_extensions import TypeVar

from isomatch import _operations as operations
from isomatch._dissimilarities import PartialDissimilarities
from isomatch._errors import ConnectionFailed
from isomatch._events import EventReader
from isomatch._exchange import RETRY_PAUSES, describe
from isomatch._models import JobRecord, JobState, JobWebhook, Progress
from isomatch._problem import Problem
from isomatch._progress import ProgressBar
from isomatch._result import Result
from isomatch._transport import BlockingTransport

ResultT = TypeVar("ResultT", bound=Result, default=Any)


class Job(Generic[ResultT]):
    """A job on the service, with a result of a kind: a match, or dissimilarities.

    The attributes say what the service said last; :meth:`refresh` asks again. Methods raise
    :class:`~isomatch.ConnectionFailed` and :class:`~isomatch.ProblemError` besides what they name.
    """

    def __init__(self, transport: BlockingTransport, record: JobRecord) -> None:
        self._transport = transport
        self._record = record

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.state}>"

    @property
    def record(self) -> JobRecord:
        """Everything the service said last, as one value."""
        return self._record

    @property
    def id(self) -> str:
        """The job's id."""
        return self._record.id

    @property
    def kind(self) -> str:
        """What the job does, such as ``"match"``."""
        return self._record.kind

    @property
    def state(self) -> JobState:
        """One of queued, running, succeeded, failed, cancelled."""
        return self._record.state

    @property
    def finished(self) -> bool:
        """Whether the job has ended, in whatever way."""
        return self._record.finished

    @property
    def progress(self) -> Progress:
        """How far it is."""
        return self._record.progress

    @property
    def position(self) -> int | None:
        """Place in the queue; None once it runs."""
        return self._record.position

    @property
    def created(self) -> datetime:
        """When it was queued."""
        return self._record.created

    @property
    def started(self) -> datetime | None:
        """When it began to run."""
        return self._record.started

    @property
    def ended(self) -> datetime | None:
        """When it ended."""
        return self._record.ended

    @property
    def caller(self) -> str | None:
        """Name of the API key it was asked for with; None where the service asks for none."""
        return self._record.caller

    @property
    def webhook(self) -> JobWebhook | None:
        """Whom its end is told to, and how that went; None for nobody."""
        return self._record.webhook

    @property
    def error(self) -> Problem | None:
        """Why it failed."""
        return self._record.error

    def refresh(self) -> Self:
        """Ask the service how the job is, and return the job."""
        self._record = self._transport.run(operations.get_job(self.id))
        return self

    def wait(self, timeout: float | None = None) -> Self:
        """Wait until the job has ended, in whatever way, and return it.

        Raises
        ------
        WaitTimeout
            It did not end within `timeout` seconds.
        """
        if not self.finished:
            self._record = self._transport.run(operations.wait_for_job(self.id, timeout))
        return self

    def follow(self) -> Generator[Self]:
        """Go through the job as it changes, as the service tells of it, until it has ended.

        Yields the job itself, at once and after each change; a connection that breaks is taken
        up again where it broke.
        """
        last, failures = None, 0
        while True:
            call, reader = operations.follow_job(self.id, last), EventReader()
            try:
                with closing(self._transport.lines(call)) as lines:
                    for event in filter(None, map(reader.feed, lines)):
                        last, failures = event.id, 0
                        self._record = operations.record_of(event.data, call)
                        yield self
                        if self.finished:
                            return
            except httpx2.TransportError as error:
                failures += 1
                if failures > len(RETRY_PAUSES):
                    raise ConnectionFailed(describe(error, call)) from error
            if self.finished:
                return
            time.sleep(RETRY_PAUSES[max(failures - 1, 0)])

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
            It did not end within `timeout` seconds.
        """
        if progress and not self.finished:
            with ProgressBar() as bar:
                waiting = operations.wait_for_job(self.id, timeout, bar.update)
                self._record = self._transport.run(waiting)
        else:
            self.wait(timeout)
        return cast(ResultT, self._transport.run(operations.get_result(self._record)))

    def cancel(self) -> Self:
        """Cancel the job, whether it is queued or running, and return it.

        A job that has ended stays as it is.
        """
        self._record = self._transport.run(operations.cancel_job(self.id))
        return self

    def picture(self) -> bytes:
        """Return the picture of the result, a PNG file.

        Raises
        ------
        Conflict
            There is no result (yet).
        """
        return self._transport.run(operations.get_picture(self.id))

    def save_picture(self, path: str | os.PathLike[str]) -> None:
        """Write the picture of the result to a PNG file.

        Raises
        ------
        Conflict
            There is no result (yet).
        OSError
            The file cannot be written.
        """
        Path(path).write_bytes(self.picture())

    def save_arrays(self, path: str | os.PathLike[str]) -> None:
        """Write dissimilarities in full precision to a NumPy file, ``.npz``.

        Raises
        ------
        Conflict
            There is no result (yet), or it is a match.
        OSError
            The file cannot be written.
        """
        Path(path).write_bytes(self._transport.run(operations.get_arrays(self.id)))

    def partial(self) -> PartialDissimilarities:
        """Return the dissimilarities that are known so far.

        Raises
        ------
        Conflict
            The job failed, or compares no collection.
        """
        return self._transport.run(operations.get_partial(self.id))
