"""Context and result of a running job: its record, and the services that a job function uses."""

from dataclasses import dataclass

from broker.contracts import JobRecord, Summary
from broker.queue import JobQueue
from broker.store import Store
from broker.webhooks import WebhookSettings
from worker.jobs.progress import Reporter


@dataclass(frozen=True)
class JobResult:
    """What a job is to end with, as it is stored.

    Parameters
    ----------
    document
        The result document, JSON; None for kinds that have none.
    arrays
        The same as arrays, npz.
    summary
        The result in brief, of kinds that have that.
    """

    document: bytes | None = None
    arrays: bytes | None = None
    summary: Summary | None = None


@dataclass(frozen=True)
class JobContext:
    """Context of a running job.

    Parameters
    ----------
    record
        The job.
    runner
        Id by which this run holds jobs and locks.
    queue
        Submission of further jobs, and the store.
    reporter
        Progress and cancellation of the job.
    webhooks
        Settings of webhook deliveries.
    """

    record: JobRecord
    runner: str
    queue: JobQueue
    reporter: Reporter
    webhooks: WebhookSettings

    @property
    def store(self) -> Store:
        """The store."""
        return self.queue.store
