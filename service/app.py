"""The ASGI application."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Final

from fastapi import FastAPI
from fastapi_offline import FastAPIOffline
from prometheus_client import CollectorRegistry
from redis.exceptions import RedisError
from starlette.concurrency import run_in_threadpool

from broker.queue import JobQueue
from broker.store import Store
from broker.telemetry import logger
from broker.upkeep import Sweep, recover
from broker.webhooks import INTERVAL as WEBHOOK_INTERVAL
from broker.webhooks import dispatch
from service import health, webhooks
from service.dissimilarities import endpoints as dissimilarities
from service.http import Authentication, BodyLimit, HeadLikeGet, RequestContext, error_handlers
from service.http.openapi import document
from service.jobs import endpoints as jobs
from service.jobs import results
from service.matches import endpoints as matches
from service.metrics import MeasureRequests, RequestTimes, StoreCollector
from service.metrics import endpoints as metrics
from service.page import endpoints as page
from service.prototypes import archives
from service.prototypes import endpoints as prototypes
from service.settings import Settings
from service.shapes import endpoints as shapes
from service.shapes import files
from service.state import Service, State
from service.structures import endpoints as structures

BODY_LIMIT: Final = 1024**2
"""Bytes of a request that is not an upload."""

REDIS_TIMEOUT: Final = 30.0
"""Seconds after which a Redis that is there and does not answer, hung or cut off, is given up. Less
would be too little for large uploads, of which several are written at a time."""

log = logger("isomatch.api")


def create_app(settings: Settings, closing: asyncio.Event | None = None) -> FastAPI:
    """Return the application.

    Parameters
    ----------
    settings
        The settings in force; `redis_url` must be set by the time the application starts.
    closing
        Set by the server when it is to stop, so that long polls end.
    """
    registry = CollectorRegistry()
    app = FastAPIOffline(
        title="isomatch",
        version="1",
        lifespan=_lifespan(settings, closing or asyncio.Event(), registry),
        redirect_slashes=False,
    )
    error_handlers.install(app)
    app.add_middleware(HeadLikeGet, routes=app.router.routes)
    app.add_middleware(Authentication, keys=settings.api_keys)
    app.add_middleware(
        BodyLimit,
        limit=BODY_LIMIT,
        upload_limit=settings.max_upload_bytes,
        upload_paths=(shapes.PATH, archives.PATH),
        patience=settings.body_patience,
    )
    app.add_middleware(RequestContext)
    app.add_middleware(MeasureRequests, times=RequestTimes(registry))
    app.webhooks.include_router(webhooks.router)
    for part in (
        shapes,
        files,
        structures,
        matches,
        dissimilarities,
        archives,
        prototypes,
        jobs,
        results,
        health,
        metrics,
        page,
    ):
        app.include_router(part.router)

    def openapi() -> dict[str, Any]:
        app.openapi_schema = app.openapi_schema or document(app)
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]
    return app


def _lifespan(
    settings: Settings, closing: asyncio.Event, registry: CollectorRegistry
) -> Callable[[FastAPI], AbstractAsyncContextManager[State]]:
    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[State]:
        store = Store.open(settings, settings.redis_patience, pause=0.2, timeout=REDIS_TIMEOUT)
        service = Service(settings, store, JobQueue(store, settings), closing, registry)
        registry.register(StoreCollector(service.queue))
        tasks = [
            asyncio.create_task(_regularly(settings.heartbeat, _recovery(service))),
            asyncio.create_task(_regularly(WEBHOOK_INTERVAL, _webhooks(service))),
        ]
        try:
            yield {"service": service}
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            store.close()

    return lifespan


def _recovery(service: Service) -> Callable[[], None]:
    sweep = Sweep(service.store)

    def recover_and_sweep() -> None:
        recover(service.queue)
        sweep.step()

    return recover_and_sweep


def _webhooks(service: Service) -> Callable[[], None]:
    return lambda: dispatch(service.queue, service.settings)


async def _regularly(interval: float, chore: Callable[[], None]) -> None:
    while True:
        try:
            await run_in_threadpool(chore)
        except RedisError as error:
            log.warning("a chore has to wait for the store", error=str(error))
        except Exception:
            log.exception("a chore failed")
        await asyncio.sleep(interval)
