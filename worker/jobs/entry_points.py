"""The functions that RQ calls by name, each in a process of its own, forked from a warm worker."""

import signal
from functools import cache
from types import FrameType

import structlog
from redis import Redis
from rq import get_current_job
from rq.job import Job

from broker.processes import limit_memory
from broker.queue import JobQueue, tenant_of
from broker.store import Store
from broker.tracing import exporting
from broker.upkeep import LOSSES_AFTER_KILL, handle_lost_process
from worker.jobs.failures import JobTimedOut
from worker.jobs.runner import BLOB_PATIENCE, Runner
from worker.settings import WorkerSettings


@cache
def worker_settings() -> WorkerSettings:
    """Return the settings of this worker, read once, before it forks."""
    return WorkerSettings()


def run(job_id: str) -> None:
    """Run one job, in the process that RQ forked for it."""
    settings = worker_settings()
    limit_memory(settings.job_memory_mb)
    # RQ has set the alarm, and restores the handler.
    signal.signal(signal.SIGALRM, _time_out)
    job = get_current_job()
    assert job is not None
    assert job.worker_name is not None
    meta, tenant = job.get_meta(refresh=False), tenant_of(job)
    told = {name: meta.get(name) for name in ("kind", "request_id", "caller")}
    structlog.contextvars.bind_contextvars(job_id=job_id, tenant=tenant, **told)
    store = Store.over(job.connection, settings, settings.worker_patience).of(tenant)
    with exporting("worker"):
        queue, patience = JobQueue(store, settings), min(BLOB_PATIENCE, settings.worker_patience)
        # A worker runs one process at a time, and its name is never given to another.
        Runner(queue, job.worker_name, settings, patience).run(job_id)


def _time_out(number: int, frame: FrameType | None) -> None:
    raise JobTimedOut


def stopped(job: Job, connection: Redis) -> None:
    """Record that a cancelled job was killed because it did not stop; RQ's callback."""
    settings = worker_settings()
    # RQ calls it in the process that forks jobs.
    store = Store.over(connection, settings, settings.worker_patience, forks=True)
    with exporting("worker"):
        # Whichever runs it: it was cancelled.
        handle_lost_process(store, job, "stopped", LOSSES_AFTER_KILL, worker=None)
