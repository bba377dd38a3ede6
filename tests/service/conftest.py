"""The API over real HTTP, with a real server and real workers behind it, once for the session."""

import asyncio
import logging
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import httpx2
import pytest
import structlog
import uvicorn

from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Store, connect, have_ended
from service.app import create_app
from service.dependencies import Service
from service.settings import Settings
from service.standalone import KEEP_ALIVE_SECONDS, EmbeddedServer, WorkerPool
from service.watcher import Watcher
from tests.blobs import blob_url
from tests.waiting import until
from tests.worker.figures import blob_file
from tests.worker.records import shape_record

WORKERS = 2
LIMIT = 2 * 1024**2
"""Bytes of an upload that the tested service takes."""

PATIENCE = 240.0
"""Seconds an upload waits for its validation, where it is a test's whole purpose that it ends."""

DATABASES = cycle(range(1, 16))
"""Numbers of those of a server that the shared workers do not serve, one after the other."""

Json = dict[str, Any]
Upload = Callable[..., Json]


@pytest.fixture(autouse=True, scope="session")
def _quiet() -> None:
    """Keep the API's log out of the tests' output; its threads write between tests."""
    quiet = structlog.make_filtering_bound_logger(logging.CRITICAL)
    structlog.configure(wrapper_class=quiet)


@dataclass(frozen=True)
class Api:
    """A running API.

    Attributes
    ----------
    url
        Where it listens.
    store
        What is behind it.
    """

    url: str
    store: Store


@contextmanager
def running_api(settings: Settings) -> Iterator[Api]:
    """Run an API on a free port of this machine, in a thread."""
    closing = asyncio.Event()
    config = uvicorn.Config(
        create_app(settings, closing),
        host="127.0.0.1",
        port=0,
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=2,
        timeout_keep_alive=KEEP_ALIVE_SECONDS,
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        assert thread.is_alive()
        time.sleep(0.01)
    port = server.servers[0].sockets[0].getsockname()[1]
    store = Store.open(settings, retry_seconds=1)
    try:
        yield Api(f"http://127.0.0.1:{port}", store)
    finally:
        store.close()
        server.should_exit = True
        thread.join()


def service_over(store: Store) -> Service:
    """What the endpoints of an API over this store work with."""
    settings = Settings()
    ends = Watcher(partial(have_ended, store.client))
    return Service(settings, JobQueue(store, settings), ends)


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedServer]:
    embedded = EmbeddedServer(tmp_path_factory.mktemp("redis"))
    embedded.start()
    yield embedded
    embedded.stop()


@pytest.fixture(scope="session")
def settings(server: EmbeddedServer, tmp_path_factory: pytest.TempPathFactory) -> Settings:
    return Settings(
        redis_url=server.url,
        blob_url=blob_url(tmp_path_factory.mktemp("store")),
        max_upload_bytes=LIMIT,
        validation_wait=PATIENCE,
    )


@contextmanager
def served_api(settings: Settings) -> Iterator[Api]:
    """Run an API with workers, which are there when it begins."""
    assert settings.redis_url is not None
    assert settings.blob_url is not None
    pool = WorkerPool(WORKERS, settings.redis_url, settings.blob_url)
    with running_api(settings) as running:
        queue = JobQueue(running.store, settings)
        try:
            pool.start()
            until(lambda: queue.workers() >= WORKERS, 540.0, pause=0.05)
            yield running
        finally:
            pool.stop()


@pytest.fixture(scope="session")
def api(settings: Settings) -> Iterator[Api]:
    with served_api(settings) as running:
        yield running


@pytest.fixture(scope="session")
def http(api: Api) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=api.url, timeout=300.0) as client:
        yield client


@pytest.fixture(scope="session")
def upload(http: httpx2.Client) -> Callable[..., Json]:
    """Upload a file that is a usable mesh, and return the shape."""

    def upload_data(data: bytes, filename: str = "mesh.off") -> Json:
        answer = http.post("/v1/shapes", files={"file": (filename, data)})
        assert answer.status_code in (200, 201), answer.text
        shape: Json = answer.json()
        return shape

    return upload_data


@pytest.fixture(scope="session")
def shapes(upload: Callable[..., Json]) -> tuple[str, str]:
    """Two shapes that are isometric."""
    return upload(blob_file())["id"], upload(blob_file(seed=1))["id"]


def put_shapes(api: Api) -> tuple[str, str]:
    """Put the records of two shapes in the store, for jobs that nobody runs."""
    names = "a" * 32, "b" * 32
    for name in names:
        api.store.client.set(DEFAULT_KEYS.shape(name), shape_record(name).model_dump_json())
    return names


def empty_database(server: EmbeddedServer) -> str:
    """Address of an empty database that nobody else has now."""
    address = f"{server.url}?db={next(DATABASES)}"
    with connect(address, retry_seconds=1) as client:
        client.flushdb()
    return address


@contextmanager
def idle_api(server: EmbeddedServer, **settings: Any) -> Iterator[Api]:
    """Run an API with settings of its own on an empty store that no worker serves."""
    with TemporaryDirectory(prefix="isomatch-") as folder:
        stores = {"redis_url": empty_database(server), "blob_url": blob_url(Path(folder))}
        with running_api(Settings(**(stores | settings))) as api:
            yield api


def problem(answer: httpx2.Response, status: int, slug: str) -> Json:
    """Assert that an answer is a problem document of a kind, and return it."""
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    document: Json = answer.json()
    assert document["type"] == f"urn:isomatch:problem:{slug}"
    assert document["status"] == status
    assert document["title"]
    assert document["detail"]
    assert document["instance"] == answer.request.url.path
    assert "Traceback" not in answer.text
    return document
