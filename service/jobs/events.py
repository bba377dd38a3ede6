"""The changes of a job as server-sent events."""

import asyncio
import contextlib
import hashlib
from collections.abc import AsyncIterator, Callable
from typing import Final

from fastapi.sse import format_sse_event
from redis.exceptions import RedisError
from starlette.concurrency import run_in_threadpool

from broker.store import NewerRecord
from broker.telemetry import logger
from service.dependencies import FIRST_POLL, LONGEST_POLL, Service
from service.jobs.schemas import Job

EVENT: Final = "job"
RETRY_MS: Final = 1000
"""Milliseconds after which a client whose stream ended reconnects."""

log = logger("isomatch.api")


def present_job(service: Service, job_id: str) -> Job | None:
    """Return the present state of a job, or None if it does not exist or has expired."""
    record = service.queue.job(job_id)
    return None if record is None else Job.of(record, service.queue)


def event_id(job: Job) -> str:
    """Return the id of the event for a state of a job, a digest of that state."""
    return hashlib.sha256(job.model_dump_json().encode()).hexdigest()[:16]


async def events(
    service: Service, job: Job, last: str | None, admitted: Callable[[], bool]
) -> AsyncIterator[bytes]:
    """Yield the state of a job and its changes, until the job, the stream or the service ends.

    Each event has the whole job, so a client that connects late misses nothing. The event that
    the client received last is not repeated.

    Parameters
    ----------
    service
        The service that runs the job.
    job
        The state of the job when the stream was requested.
    last
        Id of the last event that the client received.
    admitted
        Tells whether the API key of the request is still accepted; the stream ends when it is not.
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
        if not admitted():
            return
        try:
            present = await run_in_threadpool(present_job, service, job.id)
        except (RedisError, NewerRecord) as error:
            # The client reconnects, and is answered with the error if it persists.
            log.warning("event stream ended early", error=str(error))
            return
        if present is None:
            return
        job = present
