"""A request is accepted when it is on the disk of Redis, and else may be repeated."""

from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest

from service.standalone import EmbeddedServer
from tests.service.conftest import Api, idle_api, problem, put_shapes


@pytest.fixture
def own(tmp_path: Path) -> Iterator[EmbeddedServer]:
    """A Redis that a test may configure."""
    server = EmbeddedServer(tmp_path / "redis")
    server.start()
    yield server
    server.stop()


@pytest.fixture
def apart(own: EmbeddedServer) -> Iterator[Api]:
    with idle_api(own) as api:
        yield api


@pytest.mark.parametrize("key", ["x", None])
def test_a_job_that_is_not_on_the_disk_is_not_accepted(
    apart: Api, own: EmbeddedServer, key: str | None
) -> None:
    source, target = put_shapes(apart)
    body, headers = {"source": source, "target": target}, {"Idempotency-Key": key} if key else {}
    with httpx2.Client(base_url=apart.url, timeout=60.0) as http:
        # The system writes its file to the disk when it likes.
        apart.store.client.config_set("appendfsync", "no")
        refused = http.post("/v1/matches", json=body, headers=headers)
        told = problem(refused, 503, "store-away")
        assert "Idempotency-Key" in told["detail"]
        assert refused.headers["retry-after"]
        apart.store.client.config_set("appendfsync", "always")
        accepted = [http.post("/v1/matches", json=body, headers=headers) for _ in range(2)]
        assert [answer.status_code for answer in accepted] == [202, 202]
        jobs = http.get("/v1/jobs", params={"kind": "match"}).json()["items"]
    # With a key all three are one job; without one each is a job of its own.
    assert len(jobs) == (1 if key else 3)
    assert {answer.json()["id"] for answer in accepted} <= {job["id"] for job in jobs}
