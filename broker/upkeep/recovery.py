"""Recovery of lost jobs: those whose process died are queued again, or fail.

RQ notices a killed work horse at once, and a killed worker by its missing heartbeats, but only
minutes later. Here heartbeats are read directly. A job that is active in our own records but
unknown to RQ (a worker died between taking it from the queue and registering it) is queued again.
"""

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Final, Self
from uuid import uuid4

from redis.exceptions import RedisError
from rq import Worker
from rq.command import send_stop_job_command
from rq.exceptions import InvalidJobOperation, NoSuchJobError
from rq.job import Job
from rq.queue import Queue
from rq.serializers import JSONSerializer

from broker.blobs import BlobError
from broker.contracts import (
    UNUSABLE,
    DissimilaritiesPayload,
    JobKind,
    JobRecord,
    JobState,
    Problem,
    ProblemType,
    TimeSlicePayload,
    UploadPayload,
)
from broker.queue import JobQueue, tenant_of
from broker.store import ActiveJob, Keys, NewerRecord, Store, renewed, server_time, text
from broker.telemetry import logger
from broker.tracing import past_span

LOSSES_AFTER_KILL: Final = 1
"""Losses, of any kind, up to which a job is queued again when its own process was killed.

Most likely it was because of the job.
"""

LOSSES_WITH_WORKER: Final = 3
"""Losses, of any kind, up to which a job is queued again when its worker died.

Most likely it was because of the machine.
"""

LOCK_SECONDS: Final = 15.0
"""Seconds after which the lock of a process that died during recovery expires."""

_EXECUTION: Final = "worker_name", "created_at", "last_heartbeat"
"""Fields of RQ's record of an execution."""

_LOST_SPAN: Final = "lost_span"
"""Field of a job's hash: ``traceparent`` of its first attempt that was lost."""

log = logger("isomatch.recovery")


def lost_process(record: JobRecord | None, how: str) -> Problem:
    """Return the problem of a job whose process died too often."""
    detail = f"The process that computed this was killed repeatedly ({how})."
    if record is not None and record.kind in UNUSABLE:
        return Problem.of(UNUSABLE[record.kind], f"{detail} Is it too large?")
    return Problem.of(ProblemType.WORKER_LOST, detail)


def store_away() -> Problem:
    """Return the problem of a job whose data could not be read or stored for too long."""
    detail = "The store of meshes and results could not be reached for too long; ask again."
    return Problem.of(ProblemType.STORE_AWAY, detail)


def handle_lost_process(
    store: Store,
    job: Job,
    how: str,
    losses_allowed: int,
    worker: str | None,
    reason: Problem | None = None,
) -> None:
    """Queue a job again, as the next one, whose process died, or fail it, here and in RQ.

    A job that another worker runs by now is left to it.

    Parameters
    ----------
    store
        The store, of any tenant.
    job
        The job, which RQ is about to repeat or to fail.
    how
        How the process ended, in words.
    losses_allowed
        Losses, this one among them, up to which the job is queued again.
    worker
        Name of the worker whose process it was; None for whichever holds the job.
    reason
        Why it fails if it is not; by default that its process was killed.
    """
    store = store.of(tenant_of(job))
    record = store.jobs.readable(job.id)
    problem = reason or lost_process(record, how)
    state = store.jobs.lose(job.id, losses_allowed, problem, worker, _execution_of(job))
    job.retries_left = 1 if state is JobState.QUEUED else 0
    # A job whose process was killed has waited already. One that the store failed waits again.
    job.enqueue_at_front_on_retry = reason is None
    log.warning("job lost its process", job_id=job.id, how=how, state=state)
    if state is not JobState.RUNNING:
        _trace_loss(store, record, state, how)
        _clean_up(store, record, state, how)


def _execution_of(job: Job) -> str | None:
    """Return the execution that RQ still registers for a job: until it has queued it again."""
    registered = job.started_job_registry.get_job_and_execution_ids(cleanup=False)
    return next((execution for job_id, execution in registered if job_id == job.id), None)


@dataclass(frozen=True)
class RecoveryTimeouts:
    """Timeouts after which jobs are recovered.

    Parameters
    ----------
    heartbeat
        A worker without a heartbeat for so long counts as dead.
    unknown
        A job that RQ does not know for so long counts as lost.
    cancellation
        A job that has not stopped so long after its cancellation is killed.
    """

    heartbeat: timedelta
    unknown: timedelta
    cancellation: timedelta = timedelta(seconds=10)

    @classmethod
    def of(cls, seconds: float) -> Self:
        """Return the timeouts for a heartbeat every so many seconds."""
        due = timedelta(seconds=seconds)
        return cls(heartbeat=4 * due, unknown=2 * due)


def recover(queue: JobQueue, timeouts: RecoveryTimeouts | None = None) -> None:
    """Recover lost jobs and kill cancelled ones that do not stop, in one pass.

    One process at a time does the work. It must not be one whose clock is wrong
    (:func:`clock_is_right`): to that one, all workers would be dead.
    """
    store = queue.store
    timeouts = timeouts or RecoveryTimeouts.of(queue.settings.heartbeat)
    token = uuid4().hex
    if not store.client.set(Keys.RECOVERY, token, nx=True, px=int(LOCK_SECONDS * 1000)):
        return
    with renewed(store.client, Keys.RECOVERY, token, LOCK_SECONDS) as lost:
        for rq_queue in queue.rq.all():
            _release_dead_executions(store, rq_queue, timeouts.heartbeat)
        known = _known_to_rq(queue)
        present = store.of_each(lambda pipe, keys: pipe.exists(keys.active_jobs, keys.unseen_jobs))
        for tenant, exists in present.items():
            if exists:
                _Pass(queue.of(tenant), known, timeouts, lost).recover()


def clock_is_right(queue: JobQueue) -> bool:
    """Return whether the clocks of this machine and of Redis differ by less than a heartbeat."""
    before = time.time()
    there = server_time(queue.store.client)
    skew = max(before - there, there - time.time())
    if skew > queue.settings.heartbeat:
        log.error(
            "the clocks of this machine and of Redis differ: no job is recovered", seconds=skew
        )
    return skew <= queue.settings.heartbeat


def unregister_workers(store: Store) -> None:
    """Remove all workers from RQ's records when none can be alive; their jobs count as lost."""
    for name in Worker.all_keys(connection=store.client):
        store.client.delete(name)
        store.client.srem(Worker.redis_workers_keys, name)


def _release_dead_executions(store: Store, queue: Queue, timeout: timedelta) -> None:
    registry = queue.started_job_registry
    registered = registry.get_job_and_execution_ids(cleanup=False)
    dead = _dead(store, [f"{job_id}:{execution}" for job_id, execution in registered], timeout)
    if dead:
        # RQ's own cleanup compares this score, the end of the heartbeat's validity, with now.
        store.client.zadd(registry.key, dict.fromkeys(dead, 1), xx=True)

    def abandoned(job: Job, *_: object) -> None:
        # Other jobs of the queue would wait for one whose handler always fails.
        job.retries_left = 0
        with _logged(job.id):
            handle_lost_process(
                store, job, "its worker is gone", LOSSES_WITH_WORKER, job.worker_name
            )

    with _logged(queue.name):
        registry.cleanup(exception_handlers=[abandoned])


def _dead(store: Store, executions: Sequence[str], timeout: timedelta) -> list[str]:
    """Return the executions that are over, or whose worker is gone."""
    with store.client.pipeline(transaction=False) as pipe:
        for execution in executions:
            pipe.hmget(f"rq:execution:{execution}", _EXECUTION)
        found = list(zip(executions, pipe.execute(), strict=True))
        names = list({text(name) for _, (name, *_) in found if name})
        for name in names:
            pipe.exists(f"{Worker.redis_worker_namespace_prefix}{name}")
            pipe.hexists(f"{Worker.redis_worker_namespace_prefix}{name}", "death")
        replies = pipe.execute()
    states = zip(names, replies[::2], replies[1::2], strict=True)
    gone = {name for name, exists, has_died in states if not exists or has_died}
    oldest = time.time() - timeout.total_seconds()
    return [
        execution
        for execution, (name, created, heartbeat) in found
        # Expired, or half so: a heartbeat that comes late makes the hash anew, without its rest.
        if created is None
        or heartbeat is None
        or float(heartbeat) <= oldest
        or (name and text(name) in gone)
    ]


@dataclass(frozen=True)
class _Pass:
    """One pass over the jobs of a tenant that have not ended, until the lock is lost."""

    queue: JobQueue
    known: set[str]
    timeouts: RecoveryTimeouts
    lost: threading.Event

    def recover(self) -> None:
        store = self.queue.store
        stored = store.client.hgetall(store.keys.unseen_jobs).items()
        first_noticed = {text(job_id): float(when) for job_id, when in stored}
        unknown: set[str] = set()
        for job in store.jobs.active():
            if self.lost.is_set():
                return
            with _logged(job.id):
                if self._requeue_lost(job, first_noticed.get(job.id)):
                    unknown.add(job.id)
                self._cancel_with_batch(job)
                _kill_overdue(store, job, self.timeouts.cancellation)
        cleared = set(first_noticed) - unknown
        if cleared:
            store.client.hdel(store.keys.unseen_jobs, *cleared)

    def _cancel_with_batch(self, job: ActiveJob) -> None:
        """Cancel a match if the process that cancelled its batch died before."""
        if (
            job.kind is JobKind.MATCH
            and job.cancelled is None
            and self.queue.batches.is_cancelled(job.id)
        ):
            self.queue.cancel(job.id)

    def _requeue_lost(self, job: ActiveJob, since: float | None) -> bool:
        """Queue a job again that RQ has not known for long; true if it has not for less long."""
        store = self.queue.store
        if job.kind is JobKind.BATCH:
            # Its matches are recovered themselves; it goes on when one has ended.
            self.queue.batches.advance(job.id)
            return False
        if job.id in self.known or _has_time_slices(store, job):
            return False
        record = store.jobs.readable(job.id)
        if record is None:
            return False
        if since is None:
            store.client.hset(store.keys.unseen_jobs, record.id, str(time.time()))
        elif time.time() - since > self.timeouts.unknown.total_seconds():
            reason = lost_process(record, "its worker is gone")
            loss = f"unknown since {since}"
            state = store.jobs.lose(record.id, LOSSES_WITH_WORKER, reason, loss=loss)
            log.warning("job was lost", job_id=record.id, state=state)
            _trace_loss(store, record, state, "its worker is gone")
            _clean_up(store, record, state, "its worker is gone")
            if state is JobState.QUEUED:
                self.queue.resume(record)
            return False
        return True


@contextmanager
def _logged(job_id: str) -> Iterator[None]:
    """Log why a job, or the jobs of a queue, cannot be recovered; others are nevertheless."""
    try:
        yield
    except BlobError as error:
        log.warning("a job waits for the blob store", job_id=job_id, error=str(error))
    except (NewerRecord, ValueError, KeyError) as error:
        # Damaged, or of a newer version. The error's text may quote a record, which holds secrets.
        log.error("a job cannot be recovered", job_id=job_id, error=type(error).__name__)


def _known_to_rq(queue: JobQueue) -> set[str]:
    known: set[str] = set()
    for rq_queue in queue.rq.all():
        known.update(rq_queue.get_job_ids())
        started = rq_queue.started_job_registry.get_job_and_execution_ids(cleanup=False)
        known.update(job_id for job_id, _ in started)
    return known


def _kill_overdue(store: Store, job: ActiveJob, timeout: timedelta) -> None:
    if job.state is not JobState.RUNNING or job.cancelled is None:
        return
    if datetime.now(UTC) - job.cancelled < timeout:
        return
    log.warning("killing a cancelled job that does not stop", job_id=job.id)
    try:
        send_stop_job_command(store.client, job.id, serializer=JSONSerializer)
    except (NoSuchJobError, InvalidJobOperation, RedisError) as error:
        log.warning("could not kill the cancelled job", job_id=job.id, error=str(error))


def _has_time_slices(store: Store, job: ActiveJob) -> bool:
    return job.kind is JobKind.DISSIMILARITIES and bool(store.chunks.time_slices(job.id))


def _trace_loss(store: Store, record: JobRecord | None, state: JobState | None, how: str) -> None:
    """Record the span that a lost process could not; the next attempt links to the first one."""
    if record is None or record.started is None:
        return
    lost = past_span(
        f"{record.kind.value} lost",
        record.traceparent,
        record.started,
        datetime.now(UTC),
        error=how,
        job_id=record.id,
    )
    if lost is not None and state is JobState.QUEUED:
        store.client.hsetnx(store.keys.job(record.id), _LOST_SPAN, lost)


def first_loss(store: Store, job_id: str) -> str | None:
    """Return the span of the first lost attempt of a job, as ``traceparent``."""
    lost = store.client.hget(store.keys.job(job_id), _LOST_SPAN)
    return None if lost is None else text(lost)


def _clean_up(store: Store, record: JobRecord | None, state: JobState | None, how: str) -> None:
    if record is None or state is None or not state.ended:
        return
    match record.payload:
        case payload if isinstance(payload, UploadPayload):
            store.uploads.reject(payload.upload, payload.file_type, record.id)
        case DissimilaritiesPayload():
            store.chunks.delete(record.id)
        case TimeSlicePayload(job=job) if state is JobState.FAILED:
            # The same chunk has killed every process that claimed it.
            store.jobs.fail(job, job, lost_process(store.jobs.readable(job), how))
            store.chunks.delete(job)
