"""A job as it changes, as server-sent events."""

import asyncio
import contextlib
import hashlib
from collections.abc import AsyncIterator
from typing import Final

from fastapi.sse import format_sse_event
from redis.exceptions import RedisError
from starlette.concurrency import run_in_threadpool

from broker.store import NewerRecord
from broker.telemetry import logger
from service.job_schema import Job
from service.state import FIRST_POLL, LONGEST_POLL, Service

EVENT: Final = "job"
RETRY_MS: Final = 1000
"""Milliseconds after which a client whose stream ended comes back."""

log = logger("isomatch.api")


def present_job(service: Service, job_id: str) -> Job | None:
    """Return a job as it is now, or None if there is no such job (any more)."""
    record = service.store.jobs.get(job_id)
    return None if record is None else Job.of(record, service.queue)


def event_id(job: Job) -> str:
    """Return the id of the event that tells of a job as it is: equal jobs, equal ids."""
    return hashlib.sha256(job.model_dump_json().encode()).hexdigest()[:16]


async def events(service: Service, job: Job, last: str | None) -> AsyncIterator[bytes]:
    """Tell of a job, and of each change until it has ended, the stream is old, or we stop.

    What a client has been told already, as it says by the id of the last event it got, is not
    told again. Each event has the whole job, so none is missed by who comes late.

    Parameters
    ----------
    service
        Where the job is.
    job
        The job as it was when the stream was asked for.
    last
        Id of the last event the client knows.
    """
    clock = asyncio.get_running_loop().time
    settings = service.settings
    end = clock() + settings.events_lifetime
    beat = clock() + settings.events_heartbeat
    pause = FIRST_POLL
    while True:
        name = event_id(job)
        if name != last:
            last, pause = name, FIRST_POLL
            beat = clock() + settings.events_heartbeat
            yield format_sse_event(
                event=EVENT, data_str=job.model_dump_json(), id=name, retry=RETRY_MS
            )
        elif clock() >= beat:
            beat = clock() + settings.events_heartbeat
            yield format_sse_event(comment="still there")
        if job.state.ended or clock() >= end or service.closing.is_set():
            return
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(pause):
                await service.closing.wait()
        pause = min(pause * 1.5, LONGEST_POLL)
        try:
            present = await run_in_threadpool(present_job, service, job.id)
        except (RedisError, NewerRecord) as error:
            # The client comes back, and is told then what it is if that lasts.
            log.warning("a stream of events cannot go on", error=str(error))
            return
        if present is None:
            return
        job = present
