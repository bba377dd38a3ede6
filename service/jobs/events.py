"""The changes of a job as server-sent events."""

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Final

from fastapi.sse import format_sse_event
from redis.exceptions import RedisError

from broker.store import NewerRecord
from broker.telemetry import logger
from service.dependencies import CHECK_INTERVAL, Service
from service.jobs.followed import Event, Name
from service.jobs.schemas import Job
from service.watcher import Watcher

EVENT: Final = "job"
RETRY_MS: Final = 1000
"""Milliseconds after which a client whose stream ended reconnects."""

log = logger("isomatch.api")


def present_event(service: Service, job_id: str) -> Event | None:
    """Return the present state of a job, or None if it does not exist or has expired."""
    record = service.queue.job(job_id)
    return None if record is None else Event.of(Job.of(record, service.queue))


async def events(
    service: Service,
    followed: Watcher[Name, Event | None],
    name: Name,
    event: Event,
    last: str | None,
    admitted: Callable[[], bool],
) -> AsyncIterator[bytes]:
    """Yield the state of a job and its changes, until the job, the stream or the service ends.

    Each event has the whole job, so a client that connects late misses nothing. The event that
    the client received last is not repeated.

    Parameters
    ----------
    service
        The service that runs the job.
    followed
        The jobs whose changes are streamed.
    name
        Tenant and id of the job.
    event
        The state of the job when the stream was requested.
    last
        Id of the last event that the client received.
    admitted
        Tells whether the API key of the request is still accepted; the stream ends when it is not.
    """
    clock = asyncio.get_running_loop().time
    settings = service.settings
    end = clock() + settings.events_lifetime
    present: Event | None = event
    while present is not None:
        if present.id != last:
            yield format_sse_event(
                event=EVENT, data_str=present.data, id=present.id, retry=RETRY_MS
            )
        if present.last:
            return
        last = present.id
        beat = clock() + settings.events_heartbeat
        with followed.change(name, present) as change:
            while not change.done():
                if clock() >= end or not admitted():
                    return
                if clock() >= beat:
                    beat = clock() + settings.events_heartbeat
                    yield format_sse_event(comment="still there")
                due = min(CHECK_INTERVAL, beat - clock(), end - clock())
                await asyncio.wait([change], timeout=max(due, 0.0))
            if change.cancelled() or not admitted():
                return
            try:
                present = change.result()
            except (RedisError, NewerRecord) as error:
                # The client reconnects, and is answered with the error if it persists.
                log.warning("event stream ended early", error=str(error))
                return
