"""Health check of a worker."""

import os
import socket
import subprocess
import sys
import time
from datetime import timedelta
from pathlib import Path

import pytest
from rq import Worker
from rq.utils import utcformat

from broker.queue import WORKER_TIMEOUT, JobQueue
from broker.store import CONNECT_TIMEOUT
from service.standalone import EmbeddedServer
from worker.process import health
from worker.process.health import has_live_worker
from worker.process.process import redis_error


def asked(redis_url: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "worker.process.health"],
        env={**os.environ, "ISOMATCH_REDIS_URL": redis_url},
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )


@pytest.fixture
def born(queue: JobQueue) -> Worker:
    """A registered worker."""
    worker = Worker(queue.rq.all(), connection=queue.store.client)
    worker.register_birth()
    return worker


def test_a_worker_is_live_until_its_heartbeat_is_overdue(queue: JobQueue, born: Worker) -> None:
    client, here = queue.store.client, socket.gethostname()
    assert has_live_worker(client, here)
    assert not has_live_worker(client, "elsewhere")
    assert born.last_heartbeat is not None
    for silent, live in ((timedelta(seconds=-5), True), (timedelta(seconds=1), False)):
        last = born.last_heartbeat - WORKER_TIMEOUT - silent
        client.hset(born.key, "last_heartbeat", utcformat(last))
        assert has_live_worker(client, here) is live


def test_a_worker_that_has_stopped_is_not_live(queue: JobQueue, born: Worker) -> None:
    born.register_death()
    assert not has_live_worker(queue.store.client, socket.gethostname())


def test_the_health_check(queue: JobQueue) -> None:
    url = queue.store.jobs.settings.redis_url
    assert url is not None
    assert asked(url).returncode == 1
    worker = Worker(queue.rq.all(), connection=queue.store.client)
    worker.register_birth()
    assert asked(url).returncode == 0


def test_the_health_check_loads_the_client_of_redis_alone() -> None:
    program = "import sys, worker.process.health; print(*sys.modules)"
    command = [sys.executable, "-c", program]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert "redis" in loaded
    assert not {"rq", "pydantic", "broker", "solver", "numpy"} & set(loaded)


def test_an_address_that_is_none_is_not_quoted() -> None:
    done = asked("redis://:se/cret@queue:6379/0")
    assert done.returncode == 2
    assert done.stderr == "ISOMATCH_REDIS_URL: not an address of a Redis\n"


def test_a_worker_is_healthy_while_redis_does_not_answer(queue: JobQueue) -> None:
    done = asked("redis://127.0.0.1:1")
    assert done.returncode == 0
    assert "does not answer" in done.stdout


def test_a_redis_that_says_nothing_is_given_up_before_the_check_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"redis://127.0.0.1:{silent.getsockname()[1]}"
        monkeypatch.setenv("ISOMATCH_REDIS_URL", url)
        begun = time.monotonic()
        assert health.main() == 0
        assert CONNECT_TIMEOUT <= time.monotonic() - begun < 10, "the limit of HEALTHCHECK"


def test_a_worker_notices_an_unreachable_store_at_once(
    server: EmbeddedServer, tmp_path: Path
) -> None:
    assert redis_error(server.url) is None
    assert "nobody.sock" in (redis_error(f"unix://{tmp_path}/nobody.sock") or "")
