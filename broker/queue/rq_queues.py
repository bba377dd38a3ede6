"""The queue in RQ. Jobs name the function that runs them, so the API need not import it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from redis import Redis
from redis.client import Pipeline
from rq import Retry
from rq.exceptions import NoSuchJobError
from rq.job import Callback, Job
from rq.serializers import JSONSerializer

from broker.contracts import DEFAULT_TENANT, JobKind, JobRecord
from broker.queue.fair_queue import FairQueue, Share
from broker.queue.new_jobs import batch_match_id, time_slice_id
from broker.queue.settings import JOBS, LANE_OF, QUEUES, QueueSettings
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
    """The queue in which jobs wait for workers, and those of older versions.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        Timeouts of jobs.
    tenant
        Whose jobs are queued.
    """

    client: Redis
    settings: QueueSettings
    tenant: str = DEFAULT_TENANT

    def enqueue(self, record: JobRecord, pipe: Pipeline | None = None) -> None:
        """Queue a job that has a record, as part of a transaction if one is given."""
        self.current.enqueue_call(
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
                "tenant": self.tenant,
                **self._share(record.kind).meta(),
            },
            pipeline=pipe,
        )

    def withdraw(self, job_id: str) -> None:
        """Remove a cancelled job from its queue, unless a worker has taken it."""
        try:
            job = Job.fetch(job_id, connection=self.client, serializer=JSONSerializer)
        except NoSuchJobError:
            return
        self._named(job.origin).withdraw(job)

    def position(self, record: JobRecord) -> int | None:
        """Return the number of jobs before a queued one; None once it has started."""
        return self.positions([record])[0]

    def positions(self, records: Sequence[JobRecord]) -> list[int | None]:
        """Return the positions of several jobs, in one round trip."""
        queues = self.all()
        with self.client.pipeline(transaction=False) as pipe:
            for queue in queues:
                pipe.llen(queue.key)
                for record in records:
                    pipe.lpos(queue.key, _first_queued(record))
            replies = iter(pipe.execute())
        found: list[int | None] = [None] * len(records)
        served_before = 0
        for _ in queues:
            length = next(replies)
            for number in range(len(records)):
                place = next(replies)
                if found[number] is None and place is not None:
                    found[number] = served_before + int(place)
            served_before += length
        return found

    def waiting(self) -> int:
        """Return the number of jobs that wait in all queues."""
        return sum(waits for waits, _ in depths(self.all()).values())

    @property
    def current(self) -> FairQueue:
        """The queue that jobs are put in."""
        return self._named(JOBS)

    def all(self) -> list[FairQueue]:
        """Return all queues, in the order they are served."""
        return [self._named(name) for name in QUEUES]

    def _share(self, kind: JobKind) -> Share:
        lane = LANE_OF[kind]
        return Share(f"{self.tenant}/{lane.name}", lane.cost, lane.lead)

    def _named(self, name: str) -> FairQueue:
        return FairQueue(name, connection=self.client, serializer=JSONSerializer)


def tenant_of(job: Job) -> str:
    """Return the tenant of a job of RQ; those of versions without tenants are the default one's."""
    return str(job.get_meta(refresh=False).get("tenant", DEFAULT_TENANT))


def _first_queued(record: JobRecord) -> str:
    """Return the id of the job that is queued first, for those that are not queued themselves."""
    if record.kind is JobKind.DISSIMILARITIES:
        return time_slice_id(record, 1)
    return batch_match_id(record.id, 0) if record.kind is JobKind.BATCH else record.id
