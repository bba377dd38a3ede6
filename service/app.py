"""The ASGI application."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from functools import partial
from typing import Any, Final, TypedDict

from fastapi import Depends, FastAPI
from fastapi_offline import FastAPIOffline
from prometheus_client import CollectorRegistry, Gauge
from redis.exceptions import RedisError
from starlette.concurrency import run_in_threadpool

from broker.blobs import BlobError
from broker.queue import JobQueue
from broker.store import Store, have_ended, possible_losses
from broker.telemetry import logger
from broker.tracing import exporting
from broker.upkeep import OrphanSweep, Upkeep
from broker.webhooks import INTERVAL as WEBHOOK_INTERVAL
from service import (
    batches,
    consistent_maps,
    dissimilarities,
    jobs,
    matches,
    monitoring,
    page,
    prototypes,
    registrations,
    shapes,
    structures,
    transfers,
)
from service.dependencies import Service
from service.http import (
    Authentication,
    BodyLimit,
    Compression,
    CrossOrigin,
    HeadLikeGet,
    KeyRing,
    RequestContext,
    ResponseHeaders,
    error_handlers,
    known_parameters,
)
from service.http.openapi import document
from service.monitoring import BlobsUp, MeasureRequests, RequestTimes, StoreCollector
from service.release import VERSION
from service.settings import Settings
from service.watcher import Watcher

BODY_LIMIT: Final = 1024**2
"""Most bytes of a body that is not an upload."""

KEYS_INTERVAL: Final = 2.0
"""Seconds between two readings of the API keys in the store."""

REDIS_TIMEOUT: Final = 30.0
"""Seconds after which a Redis that is connected but does not answer is given up; long enough for
several large uploads to be written at a time."""

SCRAPE_TIMEOUT: Final = 2.5
"""Seconds after which metrics are given without the store; Prometheus gives up after 10."""

log = logger("isomatch.api")


def create_app(settings: Settings, closing: asyncio.Event | None = None) -> FastAPI:
    """Return the application.

    Parameters
    ----------
    settings
        The settings in force; `redis_url` must be set by the time the application starts.
    closing
        Set by the server when it stops, so that long polls end.
    """
    registry = CollectorRegistry()
    build = Gauge("isomatch_build_info", "Version of the API.", ("version",), registry=registry)
    build.labels(VERSION).set(1)
    ring = KeyRing(settings.api_keys, settings.auth)
    app = FastAPIOffline(
        title="isomatch",
        version=VERSION,
        lifespan=_lifespan(settings, closing or asyncio.Event(), registry, ring),
        redirect_slashes=False,
        dependencies=[Depends(known_parameters)],
    )
    error_handlers.install(app)
    app.add_middleware(Compression)
    app.add_middleware(HeadLikeGet, routes=app.router.routes)
    app.add_middleware(
        Authentication, keys=ring, hosts=(settings.host.lower(), *settings.allowed_hosts)
    )
    app.add_middleware(
        BodyLimit,
        limit=BODY_LIMIT,
        upload_limit=settings.max_upload_bytes,
        upload_paths=(
            shapes.SHAPES_PATH,
            prototypes.ARCHIVES_PATH,
            transfers.ATTRIBUTES_PATH,
        ),
        patience=settings.body_patience,
    )
    app.add_middleware(RequestContext)
    if settings.cors_origins:
        app.add_middleware(CrossOrigin, keys=ring, origins=settings.cors_origins)
    app.add_middleware(ResponseHeaders)
    app.add_middleware(MeasureRequests, times=RequestTimes(registry))
    app.webhooks.include_router(jobs.webhooks_router)
    packages = (
        shapes,
        structures,
        matches,
        batches,
        transfers,
        dissimilarities,
        registrations,
        consistent_maps,
        prototypes,
        jobs,
        monitoring,
        page,
    )
    for package in packages:
        for router in package.ROUTERS:
            app.include_router(router)

    def openapi() -> dict[str, Any]:
        app.openapi_schema = app.openapi_schema or document(app)
        return app.openapi_schema

    # FastAPI's own way to change the document, which is a method to mypy.
    app.openapi = openapi  # type: ignore[method-assign]
    return app


class _State(TypedDict):
    """State of the application, as its lifespan yields it."""

    service: Service
    followed: Watcher[jobs.Name, jobs.Event | None]


def _lifespan(
    settings: Settings, closing: asyncio.Event, registry: CollectorRegistry, ring: KeyRing
) -> Callable[[FastAPI], AbstractAsyncContextManager[_State]]:
    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[_State]:
        store = Store.open(settings, settings.redis_patience, pause=0.2, timeout=REDIS_TIMEOUT)
        queue = JobQueue(store, settings)
        ends = Watcher(partial(have_ended, store.client))
        followed = Watcher(jobs.FollowedJobs(queue))
        service = Service(settings, queue, ends, closing, registry)
        patience = min(settings.redis_patience, SCRAPE_TIMEOUT)
        scraped = Store.open(settings, patience, pause=0.2, timeout=SCRAPE_TIMEOUT)
        registry.register(StoreCollector(JobQueue(scraped, settings)))
        with suppress(RedisError):
            # Whether keys are needed should be known before the first request.
            await run_in_threadpool(ring.refresh, store.api_keys)
        upkeep = Upkeep(queue, settings)
        tasks = [
            asyncio.create_task(_regularly(interval, task))
            for interval, task in (
                (settings.heartbeat, upkeep.recover),
                (settings.heartbeat, upkeep.sweep),
                # In its own time: many blobs are slow to list, and lost jobs should not wait.
                (settings.heartbeat, BlobsUp(registry).noted(OrphanSweep(store).step)),
                (WEBHOOK_INTERVAL, upkeep.dispatch),
                (KEYS_INTERVAL, partial(ring.refresh, store.api_keys)),
            )
        ]
        warn = partial(_warn_of_losses, store)
        tasks.append(asyncio.create_task(_once(settings.heartbeat, warn)))
        watchers = ends, followed
        tasks += [asyncio.create_task(watcher.run()) for watcher in watchers]
        tasks.append(asyncio.create_task(_close(closing, watchers)))
        try:
            with exporting("api"):
                yield {"service": service, "followed": followed}
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            store.close()
            scraped.close()

    return lifespan


async def _close(closing: asyncio.Event, watchers: Sequence[Watcher[Any, Any]]) -> None:
    await closing.wait()
    for watcher in watchers:
        watcher.close()


def _warn_of_losses(store: Store) -> None:
    for loss in possible_losses(store.client):
        log.warning(loss)


async def _regularly(interval: float, task: Callable[[], object]) -> None:
    while True:
        await _succeeds(task)
        await asyncio.sleep(interval)


async def _once(interval: float, task: Callable[[], object]) -> None:
    while not await _succeeds(task):
        await asyncio.sleep(interval)


async def _succeeds(task: Callable[[], object]) -> bool:
    try:
        await run_in_threadpool(task)
    except RedisError as error:
        log.warning("periodic task postponed: the store cannot be reached", error=str(error))
    except BlobError as error:
        log.warning("periodic task postponed: blobs cannot be swept", error=str(error))
    except Exception:
        log.exception("periodic task failed")
    else:
        return True
    return False
