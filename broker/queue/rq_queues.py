"""The queues of RQ. Jobs name the function that runs them, so the API need not import it."""

from dataclasses import dataclass
from typing import Final

from redis import Redis
from redis.client import Pipeline
from rq import Queue, Retry
from rq.exceptions import InvalidJobOperation, NoSuchJobError
from rq.job import Callback, Job
from rq.serializers import JSONSerializer

from broker.contracts import JobKind, JobRecord
from broker.queue.new_jobs import batch_match_id, time_slice_id
from broker.queue.settings import QUEUE_OF, QUEUES, QueueSettings
from broker.queue.workers import depths

_ENTRY_POINT: Final = "worker.jobs.run"
_STOPPED: Final = "worker.jobs.stopped"
# Queued jobs contain these two paths: they stay, so that API and workers of two versions work
# together during an upgrade.

_RQ_RESULT_TTL: Final = 300
"""Seconds RQ keeps its own record of a job that has succeeded; ours is another."""

_RQ_FAILURE_TTL: Final = 86400
"""Seconds RQ keeps its own record of a job that has failed."""

_RQ_RETRIES: Final = 10
"""More than any job gets: our own record decides on retries."""


@dataclass(frozen=True)
class RqQueues:
    """The queues in which jobs wait for workers.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        Timeouts of jobs.
    """

    client: Redis
    settings: QueueSettings

    def enqueue(self, record: JobRecord, pipe: Pipeline | None = None) -> None:
        """Queue a job that has a record, as part of a transaction if one is given."""
        self.of(record.kind).enqueue_call(
            _ENTRY_POINT,
            args=(record.id,),
            job_id=record.id,
            timeout=self.settings.timeout(record.kind),
            result_ttl=_RQ_RESULT_TTL,
            failure_ttl=_RQ_FAILURE_TTL,
            retry=Retry(max=_RQ_RETRIES),
            on_stopped=Callback(_STOPPED),
            description=f"{record.kind.value} {record.id}",
            meta={
                "kind": record.kind.value,
                "request_id": record.request_id,
                "caller": record.caller,
            },
            pipeline=pipe,
        )

    def withdraw(self, job_id: str) -> None:
        """Remove a cancelled job from its queue."""
        try:
            job = Job.fetch(job_id, connection=self.client, serializer=JSONSerializer)
            job.delete()
        except (NoSuchJobError, InvalidJobOperation):
            return

    def position(self, record: JobRecord) -> int | None:
        """Return the number of jobs before a queued one; None once it has started."""
        queue = self.of(record.kind)
        place = queue.get_job_position(_first_queued(record))
        if place is None:
            return None
        served_before = QUEUES[: QUEUES.index(queue.name)]
        return int(place) + sum(self._named(name).count for name in served_before)

    def waiting(self) -> int:
        """Return the number of jobs that wait in all queues."""
        return sum(waits for waits, _ in depths(self.all()).values())

    def of(self, kind: JobKind) -> Queue:
        """Return the queue of a kind of jobs."""
        return self._named(QUEUE_OF[kind])

    def all(self) -> list[Queue]:
        """Return all queues, in the order they are served."""
        return [self._named(name) for name in QUEUES]

    def _named(self, name: str) -> Queue:
        return Queue(name, connection=self.client, serializer=JSONSerializer)


def _first_queued(record: JobRecord) -> str:
    """Return the id of the job that is queued first, for those that are not queued themselves."""
    if record.kind is JobKind.DISSIMILARITIES:
        return time_slice_id(record, 1)
    return batch_match_id(record.id, 0) if record.kind is JobKind.BATCH else record.id
