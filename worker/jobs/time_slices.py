"""Time slices of a job that compares a collection: each works for a while, then others may go on.

There is no leader. Each time slice claims chunks until there are none, or until other jobs wait for
the worker; the one that notices that a stage is done opens the next (:mod:`broker.store.chunks`).
"""

import time
from typing import Final

from redis.exceptions import RedisError

from broker.blobs import BlobsAway, NotMigrated
from broker.contracts import (
    RESULT,
    DissimilaritiesPayload,
    TimeSlicePayload,
    subject_of,
)
from broker.store import ClaimStatus
from broker.telemetry import logger
from broker.tracing import span
from broker.upkeep import evict_deleted
from solver.control import Control
from solver.errors import Cancelled
from worker.jobs.comparison import Comparison
from worker.jobs.context import JobContext
from worker.jobs.failures import JobTimedOut
from worker.jobs.problems import problem_of, unreadable
from worker.jobs.progress import Reporter

SLICE_SECONDS: Final = 1.0
"""Seconds after which a time slice ends if another job waits."""

MAX_SLICE_SECONDS: Final = 10.0
"""Seconds after which it ends in any case, so that little is lost with a process."""

log = logger("isomatch.time_slices")


def run_time_slice(payload: TimeSlicePayload, context: JobContext) -> None:
    """Work on a job for a while, and record the job's end if it ends.

    Raises
    ------
    RedisError, BlobsAway, NotMigrated
        The store has not answered for too long; the time slice can be queued again.
    """
    store, job_id = context.store, payload.job
    job = None
    try:
        # A job that is done in time slices is its own runner.
        job = store.jobs.get(job_id) if store.jobs.claim(job_id, job_id) else None
        if job is not None and isinstance(job.payload, DissimilaritiesPayload):
            # The progress of the job is that of its chunks, which the store counts.
            reporter = Reporter(store.jobs, job_id, job_id)
            control = Control(is_cancelled=reporter.control().is_cancelled)
            _work(Comparison(job, job.payload, context, control))
    except (RedisError, BlobsAway, NotMigrated):
        raise
    except Cancelled:
        store.jobs.finish_cancelled(job_id, job_id)
    except (Exception, JobTimedOut) as error:
        problem = unreadable(job_id, error) if job is None else problem_of(error, job)
        # The time slice ends first: one that was given up leaves the job to the run after it. A
        # cancelled job cannot fail: its chunks may be deleted while a time slice reads them.
        held = store.jobs.succeed(context.record.id, context.runner)
        if held and store.jobs.fail(job_id, job_id, problem):
            log.warning("failed", problem=problem.slug, exc_info=problem.status >= 500)
    state = store.jobs.state(job_id)
    if state is None or state.ended:
        store.chunks.delete(job_id)
        if job is not None:
            evict_deleted(store, subject_of(job.payload).named)


def _work(comparison: Comparison) -> None:
    job, context = comparison.job, comparison.context
    chunks, start = context.store.chunks, time.monotonic()
    while True:
        chunk = chunks.claim(job.id, context.record.id, context.runner)
        if chunk.status is ClaimStatus.DONE:
            comparison.open_next_stage(chunk.stage)
        elif chunk.status is not ClaimStatus.CLAIMED:
            return
        elif chunk.stage == RESULT:
            comparison.succeed()
            return
        else:
            began = time.perf_counter()
            with span(chunk.stage):
                result = comparison.compute(chunk)
            chunks.complete(job.id, chunk, result, time.perf_counter() - began)
        worked = time.monotonic() - start
        if worked > MAX_SLICE_SECONDS or (
            worked > SLICE_SECONDS and context.queue.other_jobs_wait(job.id)
        ):
            context.queue.submit_time_slice(job)
            return
