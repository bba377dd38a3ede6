"""No job is lost: finding those whose process is gone, and giving them to another one.

RQ notices a killed work horse at once (its worker tells us), and a killed worker by its missing
heartbeats, but only minutes later. Here heartbeats are looked at directly; and a job that our own
record says is on its way while RQ knows nothing of it (a worker died between taking it from the
queue and saying so) is queued again.
"""

import time
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Final, Self
from uuid import uuid4

from redis.exceptions import RedisError
from rq import Worker
from rq.command import send_stop_job_command
from rq.exceptions import InvalidJobOperation, NoSuchJobError
from rq.executions import Execution
from rq.job import Job
from rq.queue import Queue
from rq.serializers import JSONSerializer
from rq.utils import now

from broker.contracts import (
    DissimilaritiesPayload,
    JobKind,
    JobRecord,
    JobState,
    Problem,
    PrototypeValidationPayload,
    TurnPayload,
    ValidationPayload,
)
from broker.queue import JobQueue
from broker.store import Store, keys, scripts, text
from broker.telemetry import logger

LOSSES_AFTER_KILL: Final = 1
"""How often a job is begun again whose own process was killed: most likely it was to blame."""

LOSSES_WITH_WORKER: Final = 3
"""How often a job is begun again whose worker is gone: most likely the machine was to blame."""

_LOCK_MS: Final = 15_000

log = logger("isomatch.recovery")


def lost_process(record: JobRecord | None, how: str) -> Problem:
    """Return the problem of a job whose process is gone for good."""
    detail = f"The process that computed this was killed, again and again ({how})."
    if record is not None and record.kind is JobKind.VALIDATION:
        return Problem.of("unusable-mesh", "Not a usable mesh", 422, f"{detail} Is it too large?")
    if record is not None and record.kind is JobKind.PROTOTYPE_VALIDATION:
        title = "Not a usable prototype"
        return Problem.of("unusable-prototype", title, 422, f"{detail} Is it too large?")
    return Problem.of("worker-lost", "The computation was killed", 500, detail)


def give_back(store: Store, job: Job, how: str, losses_allowed: int) -> None:
    """Decide whether a job whose process is gone is begun again, and tell RQ so.

    Parameters
    ----------
    store
        Where the jobs' records are.
    job
        The job as RQ is about to repeat or to fail it.
    how
        How the process ended, in words.
    losses_allowed
        How many losses a job may have had.
    """
    record = store.jobs.readable(job.id)
    state = store.jobs.lose(job.id, losses_allowed, lost_process(record, how))
    _clean_up(store, record, state, how)
    job.retries_left = 1 if state is JobState.QUEUED else 0
    log.warning("job lost its process", job_id=job.id, how=how, state=state)


@dataclass(frozen=True)
class Patience:
    """After how long what counts as lost.

    Parameters
    ----------
    silence
        A worker without a heartbeat for so long counts as dead.
    unseen
        A job that RQ knows nothing of for so long counts as lost.
    leaving
        A cancelled job that has not left by itself after so long is killed.
    """

    silence: timedelta
    unseen: timedelta
    leaving: timedelta = timedelta(seconds=10)

    @classmethod
    def of(cls, heartbeat: float) -> Self:
        """Return what is usual where a heartbeat is due every so many seconds."""
        return cls(
            silence=4 * timedelta(seconds=heartbeat), unseen=2 * timedelta(seconds=heartbeat)
        )


def recover(store: Store, queue: JobQueue, patience: Patience | None = None) -> None:
    """Look once for jobs that are lost and for cancelled ones that do not leave.

    To be done again and again, about as often as heartbeats are due.
    """
    patience = patience or Patience.of(queue.settings.heartbeat)
    token = uuid4().hex
    if not store.client.set(keys.RECOVERY, token, nx=True, px=_LOCK_MS):
        return
    try:
        for rq_queue in queue.queues():
            _release_dead_executions(store, rq_queue, patience.silence)
        _requeue_lost(store, queue, patience.unseen)
        _kill_overdue(store, patience.leaving)
    finally:
        store.client.eval(scripts.RELEASE, 1, keys.RECOVERY, token)


def forget_workers(store: Store) -> None:
    """Forget all workers, where it is known that none is alive: their jobs count as abandoned."""
    for name in Worker.all_keys(connection=store.client):
        store.client.delete(name)
        store.client.srem(Worker.redis_workers_keys, name)


def _release_dead_executions(store: Store, queue: Queue, silence: timedelta) -> None:
    registry = queue.started_job_registry
    for job_id, execution_id in registry.get_job_and_execution_ids(cleanup=False):
        if not _alive(store, job_id, execution_id, silence):
            # What RQ's own maintenance looks at is the time until which a heartbeat is good.
            store.client.zadd(registry.key, {f"{job_id}:{execution_id}": 1}, xx=True)

    def abandoned(job: Job, *_: object) -> None:
        give_back(store, job, "its worker is gone", LOSSES_WITH_WORKER)

    registry.cleanup(exception_handlers=[abandoned])


def _alive(store: Store, job_id: str, execution_id: str, silence: timedelta) -> bool:
    try:
        execution = Execution.fetch(execution_id, job_id, connection=store.client)
    except ValueError:
        return False
    if execution.worker_name:
        worker = f"rq:worker:{execution.worker_name}"
        if not store.client.exists(worker) or store.client.hexists(worker, "death"):
            return False
    return bool(now() - execution.last_heartbeat < silence)


def _requeue_lost(store: Store, queue: JobQueue, unseen: timedelta) -> None:
    known: set[str] = set()
    for rq_queue in queue.queues():
        known.update(rq_queue.get_job_ids())
        started = rq_queue.started_job_registry.get_job_and_execution_ids(cleanup=False)
        known.update(job_id for job_id, _ in started)
    noted = store.client.hgetall(keys.SUSPECTS).items()
    seen = {text(job_id): float(when) for job_id, when in noted}
    suspects: set[str] = set()
    for record in store.jobs.active():
        if record.id in known or _has_turns(store, record):
            continue
        suspects.add(record.id)
        first = seen.get(record.id)
        if first is None:
            store.client.hset(keys.SUSPECTS, record.id, str(time.time()))
        elif time.time() - first > unseen.total_seconds():
            reason = lost_process(record, "its worker is gone")
            state = store.jobs.lose(record.id, LOSSES_WITH_WORKER, reason)
            log.warning("job was lost", job_id=record.id, state=state)
            _clean_up(store, record, state, "its worker is gone")
            if state is JobState.QUEUED:
                queue.resume(record)
            suspects.discard(record.id)
    cleared = set(seen) - suspects
    if cleared:
        store.client.hdel(keys.SUSPECTS, *cleared)


def _kill_overdue(store: Store, leaving: timedelta) -> None:
    for record in store.jobs.active():
        if record.state is not JobState.RUNNING:
            continue
        asked = store.jobs.cancel_requested(record.id)
        if asked is None or datetime.now(UTC) - asked < leaving:
            continue
        log.warning("killing a cancelled job that does not leave", job_id=record.id)
        try:
            send_stop_job_command(store.client, record.id, serializer=JSONSerializer)
        except (NoSuchJobError, InvalidJobOperation, RedisError) as error:
            log.warning("could not kill it", job_id=record.id, error=str(error))


def _has_turns(store: Store, record: JobRecord) -> bool:
    return record.kind is JobKind.DISSIMILARITIES and bool(store.parts.turns(record.id))


def _clean_up(store: Store, record: JobRecord | None, state: JobState | None, how: str) -> None:
    if record is None or state is None or not state.ended:
        return
    match record.payload:
        case ValidationPayload() as payload:
            store.shapes.reject(payload.upload, payload.file_type, record.id)
        case PrototypeValidationPayload() as payload:
            store.prototypes.reject(payload.upload, payload.file_type, record.id)
        case DissimilaritiesPayload():
            store.parts.forget(record.id)
        case TurnPayload(job=job) if state is JobState.FAILED:
            # What it was at has cost every process that tried.
            store.jobs.fail(job, job, lost_process(store.jobs.readable(job), how))
            store.parts.forget(job)
