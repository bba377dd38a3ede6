"""The queues of RQ: jobs go in by the name of what runs them, so the API imports none of it."""

from dataclasses import dataclass
from typing import Final

from redis.client import Pipeline
from rq import Queue, Retry
from rq.exceptions import InvalidJobOperation, NoSuchJobError
from rq.job import Callback, Job
from rq.serializers import JSONSerializer

from broker.contracts import JobKind, JobRecord, JobState
from broker.queue.records import turn_id
from broker.queue.settings import QUEUE_OF, QUEUES, QueueSettings
from broker.queue.workforce import depths, worker_states
from broker.store import Store

_ENTRY_POINT: Final = "worker.process.entry_points.run"
_STOPPED: Final = "worker.process.entry_points.stopped"
_RQ_RESULT_TTL: Final = 300
_RQ_FAILURE_TTL: Final = 86400
_RQ_RETRIES: Final = 10
"""More than any job gets: how often one is repeated is decided in our own record."""


@dataclass(frozen=True)
class Channels:
    """The queues, in which jobs that have a record wait for workers.

    Parameters
    ----------
    store
        Where the jobs' records are.
    settings
        How long jobs may take.
    """

    store: Store
    settings: QueueSettings

    def enqueue(self, record: JobRecord, pipe: Pipeline | None = None) -> None:
        """Hand a job that has a record to RQ, as part of a transaction if one is given."""
        self.queue(record.kind).enqueue_call(
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
        """Take a job that was cancelled out of its queue."""
        try:
            job = Job.fetch(job_id, connection=self.store.client, serializer=JSONSerializer)
            job.delete()
        except (NoSuchJobError, InvalidJobOperation):
            return

    def position(self, record: JobRecord) -> int | None:
        """Return how many jobs will be started before a queued one; None once it has begun."""
        queue = self.queue(record.kind)
        in_turns = record.kind is JobKind.DISSIMILARITIES
        place = queue.get_job_position(turn_id(record, 1) if in_turns else record.id)
        if place is None:
            return None
        served_before = QUEUES[: QUEUES.index(queue.name)]
        return int(place) + sum(self._named(name).count for name in served_before)

    def others_wait(self, job_id: str) -> bool:
        """Whether anything is queued beside the turns of a job."""
        queued = sum(waits for waits, _ in depths(self.queues()).values())
        states = self.store.parts.turns(job_id).values() if queued else ()
        return queued > sum(state is JobState.QUEUED for state in states)

    def queue(self, kind: JobKind) -> Queue:
        """Return the queue of a kind of jobs."""
        return self._named(QUEUE_OF[kind])

    def queues(self) -> list[Queue]:
        """Return all queues, in the order they are served."""
        return [self._named(name) for name in QUEUES]

    def workers(self) -> int:
        """Return the number of workers that are alive and ready."""
        return len(worker_states(self.store.client))

    def _named(self, name: str) -> Queue:
        return Queue(name, connection=self.store.client, serializer=JSONSerializer)
