"""The whole service on one machine: private Redis, workers and API, started and stopped together.

If ``ISOMATCH_REDIS_URL`` names a Redis, only the API runs, with ``ISOMATCH_WORKERS`` workers. It
waits for that Redis, and answers calls with 503 until then.
"""

import asyncio
import contextlib
import fcntl
import os
import signal
import socket
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Final

import uvicorn
from redis.exceptions import RedisError

from broker.blobs import BlobError
from broker.queue import JobQueue
from broker.store import Store
from broker.telemetry import logger
from broker.upkeep import migrate, unregister_workers
from service.app import create_app
from service.settings import Settings
from service.standalone.embedded import EmbeddedServer, EmbeddedServerError
from service.standalone.pool import WorkerPool
from service.standalone.private_directories import close_to_others

TEND_INTERVAL: Final = 0.2
"""Seconds between two checks of the child processes."""

KEEP_ALIVE_SECONDS: Final = 75
"""Seconds after which idle connections are closed: later than clients and proxies give them up, so
that no request is sent to one that is just being closed. HTTPX keeps them for 5 s, as long as
Uvicorn does by default, and many proxies for 60 s."""

MOST_EARLY_DEATHS: Final = 4
"""Workers in a row that may die before one is ready; then the start is given up."""

log = logger("isomatch.service")


class StartError(Exception):
    """The service cannot start; the message is for the user."""


class _Server(uvicorn.Server):
    """Uvicorn without signal handlers; `serve` handles signals for all processes."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Install no handlers."""
        yield


async def serve(settings: Settings) -> None:
    """Run the service until SIGINT or SIGTERM.

    Raises
    ------
    StartError
        It cannot start.
    """
    stop = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    with listening(settings.host, settings.port) as listener:
        async with _redis(settings) as (settings, redis):
            store = Store.open(settings, settings.redis_patience, pause=0.2)
            try:
                if redis is not None:
                    # The server is private: workers registered in it are from an earlier run.
                    unregister_workers(store)
                    await asyncio.to_thread(_migrate, store)
                await _run(settings, listener, JobQueue(store, settings), redis, stop)
            finally:
                store.close()


async def _run(
    settings: Settings,
    listener: socket.socket,
    queue: JobQueue,
    redis: EmbeddedServer | None,
    stop: asyncio.Event,
) -> None:
    assert settings.redis_url is not None
    assert settings.blob_url is not None
    closing = asyncio.Event()
    config = uvicorn.Config(
        create_app(settings, closing),
        log_config=None,
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=settings.drain_seconds,
        timeout_keep_alive=KEEP_ALIVE_SECONDS,
    )
    server = _Server(config)
    pool = WorkerPool(settings.worker_count, settings.redis_url, settings.blob_url)
    pool.start()
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    stopping = asyncio.create_task(stop.wait())
    tending = asyncio.create_task(_tend(pool, redis))
    try:
        ready = asyncio.create_task(_ready(settings, server, queue, pool))
        await asyncio.wait({ready, serving, stopping}, return_when=asyncio.FIRST_COMPLETED)
        if ready.done():
            ready.result()
            print(f"isomatch listens on {_url(listener)}", flush=True)
        else:
            ready.cancel()
        await asyncio.wait({serving, stopping, tending}, return_when=asyncio.FIRST_COMPLETED)
        if tending.done():
            tending.result()
        if serving.done() and not stopping.done():
            serving.result()
            raise StartError("the server ended by itself; the log above has the cause")
    finally:
        log.info("stopping")
        tending.cancel()
        stopping.cancel()
        closing.set()
        server.should_exit = True
        await asyncio.wait({serving}, timeout=settings.drain_seconds + 1)
        await asyncio.to_thread(pool.stop)


async def _tend(pool: WorkerPool, redis: EmbeddedServer | None) -> None:
    # Runs on the main thread: children are killed when the thread that started them ends.
    while True:
        await asyncio.sleep(TEND_INTERVAL)
        if redis is not None and not redis.alive():
            log.error("the private Redis server died; starting it again")
            try:
                redis.start()
            except EmbeddedServerError as error:
                raise StartError(str(error)) from error
        pool.tend()


async def _ready(
    settings: Settings, server: uvicorn.Server, queue: JobQueue, pool: WorkerPool
) -> None:
    """Wait for the server and, while Redis answers, for its workers."""
    try:
        while (
            not server.started
            or (alive := await asyncio.to_thread(queue.workers)) < settings.worker_count
        ):
            if pool.early_deaths >= MOST_EARLY_DEATHS:
                raise StartError(
                    "the workers die as soon as they start; the log above has the cause"
                )
            await asyncio.sleep(0.05)
    except RedisError as error:
        log.warning(
            "Redis does not answer yet, and will be waited for (ISOMATCH_REDIS_URL)",
            error=str(error),
        )
        return
    if alive == 0:
        log.warning("no worker is running; `python -m worker` starts one")


@contextlib.asynccontextmanager
async def _redis(settings: Settings) -> AsyncIterator[tuple[Settings, EmbeddedServer | None]]:
    if settings.redis_url is not None:
        if settings.blob_url is None:
            raise StartError(
                "ISOMATCH_BLOB_URL is not set: with ISOMATCH_REDIS_URL, API and workers need one"
                " place for meshes and results, file:///DIRECTORY or s3://BUCKET/PREFIX"
            )
        yield settings, None
        return
    with _locked(settings.data_dir):
        blobs = settings.data_dir.resolve() / "blobs"
        close_to_others(blobs)
        redis = EmbeddedServer(settings.data_dir / "redis")
        try:
            try:
                redis.start()
            except EmbeddedServerError as error:
                raise StartError(str(error)) from error
            found = {
                "redis_url": redis.url,
                "blob_url": settings.blob_url or blobs.as_uri(),
                "workers": settings.worker_count,
            }
            yield settings.model_copy(update=found), redis
        finally:
            redis.stop()


def _migrate(store: Store) -> None:
    # Nobody else uses this store yet, and there is no other moment for it.
    try:
        moved = migrate(store)
    except BlobError as error:
        raise StartError(f"cannot use the blob store: {error}") from error
    if moved.values:
        log.info("moved what an earlier version kept in Redis", values=moved.values)


@contextlib.contextmanager
def _locked(directory: Path) -> Iterator[None]:
    try:
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        lock = (directory / "lock").open("a+")
    except OSError as error:
        raise StartError(f"cannot write to the data directory {directory}: {error}") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            lock.seek(0)
            owner = lock.read().strip()
            raise StartError(
                f"the data directory {directory} is in use by another isomatch"
                f" (process {owner}); stop it, or set ISOMATCH_DATA_DIR"
            ) from error
        lock.truncate(0)
        lock.write(str(os.getpid()))
        lock.flush()
        yield


@contextlib.contextmanager
def listening(host: str, port: int) -> Iterator[socket.socket]:
    """Bind a listening socket.

    Raises
    ------
    StartError
        The address is in use, or does not belong to this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # asyncio disables Nagle's algorithm, which delays answers by 40 ms, only if the socket names
    # its protocol.
    with socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, port))
        except OSError as error:
            raise StartError(
                f"cannot listen on {host} port {port}: {error.strerror};"
                " ISOMATCH_HOST and ISOMATCH_PORT, or --host and --port, choose another address"
            ) from error
        yield listener


def _url(listener: socket.socket) -> str:
    host, port = listener.getsockname()[:2]
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"
