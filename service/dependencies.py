"""Dependencies of the endpoints: the service's state, and the id and caller of a request."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated, Final, Self, cast

from anyio import CapacityLimiter
from fastapi import Depends, Request
from prometheus_client import CollectorRegistry
from starlette.concurrency import run_in_threadpool

from broker.contracts import DEFAULT_TENANT, JobRecord, RequestOrigin
from broker.queue import JobQueue
from broker.store import Store
from service.settings import Settings
from service.watcher import Watcher

CHECK_INTERVAL: Final = 1.0
"""Seconds between two looks at whether the client of a waiting request is still there."""

UPLOADS_AT_ONCE: Final = 4
"""Uploads that are stored at a time; others wait in temporary files. One takes some 30 MB while it
is sent to object storage."""

DOCUMENTS_AT_ONCE: Final = 2
"""Large documents prepared at a time. The dissimilarities of 2000 shapes take seconds of CPU and
some 40 MB."""


SCRAPES_AT_ONCE: Final = 2
"""Scrapes of Prometheus that are answered at a time."""


@dataclass(frozen=True)
class Service:
    """The state of the application that endpoints work with.

    Parameters
    ----------
    settings
        The settings in force.
    queue
        The queue of the workers, for jobs of the tenant who asks.
    ends
        Whether jobs have ended, by the tenant, the id and the batch of each.
    closing
        Set when the server stops, so that waiting requests are answered.
    metrics
        Metrics for Prometheus.
    uploading
        Held while an upload is stored.
    preparing
        Held while a large document is prepared.
    scraping
        Limits the threads that collect metrics.
    """

    settings: Settings
    queue: JobQueue
    ends: Watcher[tuple[str, str, str | None], bool]
    closing: asyncio.Event = field(default_factory=asyncio.Event)
    metrics: CollectorRegistry = field(default_factory=CollectorRegistry)
    uploading: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(UPLOADS_AT_ONCE))
    preparing: asyncio.Semaphore = field(
        default_factory=lambda: asyncio.Semaphore(DOCUMENTS_AT_ONCE)
    )
    scraping: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(SCRAPES_AT_ONCE))

    @property
    def store(self) -> Store:
        """Shapes, prototypes, jobs and results of the tenant who asks."""
        return self.queue.store

    def of(self, tenant: str) -> Self:
        """Return the service as a tenant sees it."""
        return replace(self, queue=self.queue.of(tenant))

    async def wait_for(self, job_id: str, seconds: float, request: Request) -> JobRecord | None:
        """Wait until a job has ended, at most `seconds`, and return its state then.

        The wait also ends when the server stops or the client disconnects.
        """
        record = await run_in_threadpool(self.queue.job, job_id)
        if record is None or record.state.ended or seconds == 0:
            return record
        clock = asyncio.get_running_loop().time
        deadline = clock() + seconds
        watched = self.store.keys.tenant, job_id, record.batch
        with self.ends.change(watched, False) as end:
            while not (end.done() or clock() >= deadline or await request.is_disconnected()):
                await asyncio.wait([end], timeout=min(CHECK_INTERVAL, deadline - clock()))
            if end.done() and not end.cancelled():
                end.result()  # raises what prevented that the store was read
        return await run_in_threadpool(self.queue.job, job_id)


# Asynchronous, as others run in threads: a body is to be parsed without waiting in between.
async def _service(request: Request) -> Service:
    return cast(Service, request.state.service).of(_tenant(request))


def _tenant(request: Request) -> str:
    return cast(str, getattr(request.state, "tenant", DEFAULT_TENANT))


async def _request_id(request: Request) -> str:
    return cast(str, request.state.request_id)


async def _admitted(request: Request) -> Callable[[], bool]:
    return cast(Callable[[], bool], request.state.admitted)


async def _caller(request: Request) -> str | None:
    return cast("str | None", getattr(request.state, "caller", None))


ServiceOf = Annotated[Service, Depends(_service)]
RequestId = Annotated[str, Depends(_request_id)]
Caller = Annotated[str | None, Depends(_caller)]
"""Name of the API key of a request; None if none are configured."""
Admitted = Annotated[Callable[[], bool], Depends(_admitted)]
"""Tells whether the API key of a request is still accepted."""


@dataclass(frozen=True)
class CallContext:
    """A request, its caller, and the service that answers it."""

    service: ServiceOf
    request: Request
    request_id: RequestId
    caller: Caller

    @property
    def origin(self) -> RequestOrigin:
        """The request as the jobs that it submits name it."""
        return RequestOrigin(self.request_id, self.caller)


CallContextOf = Annotated[CallContext, Depends()]
