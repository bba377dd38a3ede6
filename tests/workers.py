"""Fixtures: a Redis server for the session, and real forking workers."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from rq import Worker

from broker.contracts import JobRecord, JobState, Payload, ValidationPayload, shape_id
from broker.queue import JobQueue
from broker.store import Store
from service.standalone import EmbeddedServer, WorkerPool
from tests.blobs import blob_url
from tests.waiting import until
from worker.settings import WorkerSettings

Upload = Callable[..., str]
WORKERS = 2


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedServer]:
    embedded = EmbeddedServer(tmp_path_factory.mktemp("redis"))
    embedded.start()
    yield embedded
    embedded.stop()


@pytest.fixture
def settings(server: EmbeddedServer, tmp_path: Path) -> WorkerSettings:
    """Settings of a database that no worker serves."""
    return WorkerSettings(redis_url=f"{server.url}?db=1", blob_url=blob_url(tmp_path))


@pytest.fixture
def store(settings: WorkerSettings) -> Iterator[Store]:
    """An empty store that no worker serves."""
    opened = Store.open(settings, retry_seconds=1)
    opened.client.flushdb()
    yield opened
    opened.close()


@pytest.fixture
def queue(store: Store, settings: WorkerSettings) -> JobQueue:
    return JobQueue(store, settings)


@pytest.fixture(scope="session")
def served(server: EmbeddedServer, tmp_path_factory: pytest.TempPathFactory) -> Iterator[JobQueue]:
    """A queue, and through it a store, with workers behind it."""
    blobs = blob_url(tmp_path_factory.mktemp("store"))
    settings = WorkerSettings(redis_url=server.url, blob_url=blobs)
    opened = Store.open(settings, retry_seconds=1)
    queue = JobQueue(opened, settings)
    pool = WorkerPool(WORKERS, server.url, blobs)
    pool.start()
    until(lambda: queue.workers() == WORKERS, 540.0, pause=0.05)
    yield queue
    pool.stop()
    opened.close()


@pytest.fixture
def run(served: JobQueue) -> Callable[[Payload], JobRecord]:
    """Have the workers run a job, and return it when it has ended."""

    def run_payload(payload: Payload) -> JobRecord:
        return ended(served, served.submit(payload).id)

    return run_payload


@pytest.fixture
def upload(served: JobQueue) -> Callable[..., str]:
    """Have the workers make a shape of a file, and return its id."""

    def upload_data(data: bytes, file_type: str = "off") -> str:
        payload = ValidationPayload(shape=shape_id(data), name="test", file_type=file_type)
        record = ended(served, served.submit_validation(payload, data))
        assert record.error is None
        return shape_id(data)

    return upload_data


def ended(queue: JobQueue, job_id: str, seconds: float = 240.0) -> JobRecord:
    """Wait for the end of a job."""

    def found() -> JobRecord | None:
        record = queue.store.jobs.get(job_id)
        assert record is not None
        return record if record.state.ended else None

    return until(found, seconds)


def nothing_is_left(store: Store, *words: str) -> None:
    """Wait until no key has all these words: an upload is deleted when its job has failed."""
    until(
        lambda: all(
            any(word.encode() not in key for word in words) for key in store.client.keys("*")
        ),
        60.0,
        pause=0.01,
    )


def horses(worker: int) -> list[int]:
    """Processes that a worker has forked; Linux only."""
    children = Path(f"/proc/{worker}/task/{worker}/children").read_text()
    return [int(pid) for pid in children.split()]


def horse_of(served: JobQueue, job_id: str) -> int:
    """The process that runs a job, once its matching has started."""

    def found() -> int | None:
        record = served.store.jobs.get(job_id)
        assert record is not None
        assert not record.state.ended, record
        if record.state is JobState.RUNNING and record.progress.fraction >= 0.4:
            for worker in Worker.all(connection=served.store.client):
                if worker.get_current_job_id() == job_id:
                    assert worker.pid is not None
                    # One that was killed may still be spoken of.
                    if alive := horses(worker.pid):
                        return alive[0]
        return None

    return until(found, pause=0.01)


def another_horse(served: JobQueue, job_id: str, killed: int) -> int:
    """The process that runs a job after another one was killed."""

    def found() -> int | None:
        horse = horse_of(served, job_id)
        return None if horse == killed else horse

    return until(found, pause=0.01)


def validation(queue: JobQueue, data: bytes) -> str:
    """Queue the validation of a file."""
    payload = ValidationPayload(shape=shape_id(data), name="x", file_type="off")
    return queue.submit_validation(payload, data)


@contextmanager
def worker(queue: JobQueue, **settings: str) -> Iterator[subprocess.Popen[bytes]]:
    """A worker of the queue, with settings from its environment."""
    found = queue.store.jobs.settings
    assert found.redis_url is not None
    assert found.blob_url is not None
    stores = {"ISOMATCH_REDIS_URL": found.redis_url, "ISOMATCH_BLOB_URL": found.blob_url}
    process = subprocess.Popen(
        [sys.executable, "-m", "worker", "--parent", str(os.getpid())],
        env={**os.environ, **stores, **settings},
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
