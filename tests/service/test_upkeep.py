"""Upkeep by several API processes over one store."""

import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.blobs import blob_url
from tests.service.conftest import Api, running_api

PROCESSES = 3


@pytest.fixture
def apis(tmp_path: Path) -> Iterator[list[Api]]:
    """Several APIs on a server of their own."""
    embedded = EmbeddedServer(tmp_path / "redis")
    embedded.start()
    settings = Settings(redis_url=embedded.url, blob_url=blob_url(tmp_path), heartbeat=1)
    with ExitStack() as stack:
        stack.callback(embedded.stop)
        yield [stack.enter_context(running_api(settings)) for _ in range(PROCESSES)]


def test_several_processes_do_the_upkeep_of_one(apis: list[Api]) -> None:
    client = apis[0].store.client

    def passes() -> int:
        """Looks through all tenants: of recovery, sweep and dispatch, one a second each."""
        return int(client.info("commandstats").get("cmdstat_smembers", {"calls": 0})["calls"])

    while passes() == 0:
        time.sleep(0.05)
    start, before = time.monotonic(), passes()
    while passes() - before < 9:
        assert time.monotonic() - start < 60
        time.sleep(0.05)
    assert passes() - before <= 3 * (time.monotonic() - start + 1)
