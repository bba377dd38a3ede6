"""Metrics for Prometheus, and readiness."""

import math
import os
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path

import httpx2
import pytest
from prometheus_client.parser import text_string_to_metric_families
from rq import Worker
from rq.utils import utcformat

from broker.contracts import JobKind, Problem, ProblemType
from broker.queue import WORKER_TIMEOUT
from broker.store import BUCKET_BOUNDS
from service.release import VERSION
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.blobs import blob_url
from tests.service.conftest import Api, Json, idle_api, problem, put_shapes, running_api
from tests.waiting import until
from tests.worker.figures import blob_file


@pytest.fixture(scope="module")
def own_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedServer]:
    """A server whose settings may be changed."""
    embedded = EmbeddedServer(tmp_path_factory.mktemp("redis"))
    embedded.start()
    yield embedded
    embedded.stop()


@pytest.fixture
def idle(own_server: EmbeddedServer) -> Iterator[tuple[httpx2.Client, Api]]:
    with (
        idle_api(own_server, redis_patience=0.2) as api,
        httpx2.Client(base_url=api.url, timeout=120.0) as http,
    ):
        yield http, api


def samples(http: httpx2.Client) -> dict[str, float]:
    """All samples, as ``name{label=value,...}`` with the labels in order."""
    answer = http.get("/metrics")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/plain; version=")
    found = {}
    for family in text_string_to_metric_families(answer.text):
        assert family.documentation
        for sample in family.samples:
            labels = ",".join(f"{name}={sample.labels[name]}" for name in sorted(sample.labels))
            found[f"{sample.name}{{{labels}}}".removesuffix("{}")] = sample.value
    return found


def test_jobs_are_counted_from_their_queue_to_their_end(
    idle: tuple[httpx2.Client, Api],
) -> None:
    http, api = idle
    source, target = put_shapes(api)
    body = {
        "source": source,
        "target": target,
        "metric": "geodesic",
        "descriptor": "none",
        "orientation": False,
    }
    jobs = [http.post("/v1/matches", json=body).json()["id"] for _ in range(5)]
    assert samples(http)["isomatch_queue_jobs{queue=matches}"] == 5
    http.delete(f"/v1/jobs/{jobs[0]}")
    for job in jobs[1:4]:
        api.store.jobs.claim(job, "me")
    api.store.jobs.succeed(jobs[1], "me", b"{}")
    api.store.jobs.fail(jobs[2], "me", Problem.of(ProblemType.TIMED_OUT, "x"))
    api.store.jobs.lose(jobs[3], 0, Problem.of(ProblemType.WORKER_LOST, "x"))
    for job in jobs[:4]:
        # What has ended has ended once.
        api.store.jobs.cancel(job)
        api.store.jobs.lose(job, 0, Problem.of(ProblemType.WORKER_LOST, "x"))
    told = samples(http)
    ends = {"succeeded": 1, "cancelled": 1, "failed": 2}
    for state, count in ends.items():
        assert told[f"isomatch_jobs_ended_total{{kind=match,state={state}}}"] == count
        assert told[f"isomatch_jobs{{state={state}}}"] == count
    assert told["isomatch_jobs{state=queued}"] == 1
    assert told["isomatch_jobs_submitted_total{kind=match}"] == 5
    for slug in ("timed-out", "worker-lost"):
        assert told[f"isomatch_job_failures_total{{kind=match,problem={slug}}}"] == 1
    assert told["isomatch_queue_jobs{queue=matches}"] == 4
    assert 0 < told["isomatch_queue_age_seconds"] < 240
    assert told["isomatch_store_up"] == 1


def test_times_are_counted_by_class(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    times = [0.001, 0.01, 0.0101, 2.0, 1e5]
    for seconds in times:
        api.store.counters.observe(JobKind.MATCH, {"bounds for 32 points": seconds, "total": 1.0})
    told = samples(http)
    name, labels = "isomatch_job_seconds", "kind=match,stage=bounds for n points"
    assert told[f"{name}_count{{{labels}}}"] == len(times)
    assert told[f"{name}_sum{{{labels}}}"] == pytest.approx(sum(times))
    for bound in (*BUCKET_BOUNDS, math.inf):
        label = "+Inf" if bound == math.inf else str(bound)
        below = sum(seconds <= bound for seconds in times)
        assert told[f"{name}_bucket{{kind=match,le={label},stage=bounds for n points}}"] == below
    assert told[f"{name}_count{{kind=match,stage=total}}"] == len(times)


def test_requests_are_counted_by_route(idle: tuple[httpx2.Client, Api]) -> None:
    http, _ = idle
    for path in ("/v1/jobs/a", "/v1/jobs/b", "/nothing", "/nowhere", "/health/live"):
        http.get(path)
    http.request("BREW", "/v1/jobs")
    told = samples(http)
    count = "isomatch_http_request_seconds_count"
    assert told[f"{count}{{method=GET,route=/v1/jobs/{{job_id}},status=404}}"] == 2
    assert told[f"{count}{{method=GET,route=none,status=404}}"] == 2
    assert told[f"{count}{{method=GET,route=/health/live,status=200}}"] == 1
    assert any("method=other" in name and "status=405" in name for name in told)
    assert told["isomatch_http_requests_open"] == 1
    assert told[f"isomatch_build_info{{version={VERSION}}}"] == 1


def test_measurements_of_workers_are_exported(
    http: httpx2.Client, api: Api, upload: Callable[..., Json]
) -> None:
    def matches() -> float:
        return samples(http).get("isomatch_job_seconds_count{kind=match,stage=total}", 0.0)

    before, spectra = matches(), samples(http)
    shape = upload(blob_file(2, seed=77))["id"]
    for _ in range(2):
        body = {"source": shape, "target": shape, "points": 8, "eigenpairs": 30}
        job = http.post("/v1/matches", json=body).json()
        assert http.get(job["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"
    # The state is told as soon as it is so, and the times are counted afterwards.
    while matches() < before + 2:
        time.sleep(0.02)
    told = samples(http)
    for stage in ("in the queue", "spectrum of the source", "coarse matching", "total"):
        assert told[f"isomatch_job_seconds_count{{kind=match,stage={stage}}}"] >= 2
    assert told["isomatch_job_seconds_count{kind=validation,stage=total}"] >= 1
    for outcome in ("hit", "miss"):
        name = f"isomatch_spectra_total{{cache={outcome}}}"
        assert told[name] > spectra[name]
    assert told["isomatch_spectrum_cache_bytes"] > 0
    assert told["isomatch_workers{state=idle}"] + told["isomatch_workers{state=busy}"] == 2


def test_without_the_store_there_is_still_something_to_tell(tmp_path: Path) -> None:
    settings = Settings(
        redis_url=f"unix://{tmp_path}/nobody.sock",
        blob_url=blob_url(tmp_path),
        redis_patience=0.2,
        auth="none",
    )
    with running_api(settings) as api, httpx2.Client(base_url=api.url, timeout=60.0) as http:
        problem(http.get("/v1/jobs/x"), 503, "store-away")
        told = samples(http)
    assert told["isomatch_store_up"] == 0
    labels = "{method=GET,route=/v1/jobs/{job_id},status=503}"
    assert told["isomatch_http_request_seconds_count" + labels] == 1


def test_a_store_that_does_not_answer_is_told_soon(
    idle: tuple[httpx2.Client, Api], own_server: EmbeddedServer
) -> None:
    http, _ = idle
    assert samples(http)["isomatch_store_up"] == 1
    assert own_server.pid is not None
    os.kill(own_server.pid, signal.SIGSTOP)
    try:
        start = time.monotonic()
        told = samples(http)
        assert time.monotonic() - start < 10
    finally:
        os.kill(own_server.pid, signal.SIGCONT)
    assert told["isomatch_store_up"] == 0
    while samples(http)["isomatch_store_up"] == 0:
        time.sleep(0.05)


def test_metrics_are_given_while_all_threads_wait_for_the_store(
    idle: tuple[httpx2.Client, Api], own_server: EmbeddedServer
) -> None:
    http, _ = idle
    assert own_server.pid is not None
    with ThreadPoolExecutor(50) as callers:
        os.kill(own_server.pid, signal.SIGSTOP)
        try:
            waiting = [callers.submit(http.get, "/v1/jobs/x") for _ in range(50)]
            while samples(http)["isomatch_http_requests_open"] <= len(waiting):
                time.sleep(0.05)
            start = time.monotonic()
            assert samples(http)["isomatch_store_up"] == 0
            assert time.monotonic() - start < 10
        finally:
            os.kill(own_server.pid, signal.SIGCONT)
        assert {answer.result().status_code for answer in waiting} == {404}


def test_a_blob_store_that_is_away_is_told(own_server: EmbeddedServer, tmp_path: Path) -> None:
    folder, elsewhere = tmp_path / "blobs", tmp_path / "elsewhere"
    with (
        idle_api(own_server, blob_url=folder.as_uri(), heartbeat=1) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):

        def is_up(expected: float) -> bool:
            return samples(http)["isomatch_blobs_up"] == expected

        until(lambda: is_up(1))
        folder.rename(elsewhere)
        until(lambda: is_up(0))
        problem(http.get("/health/ready"), 503, "not-ready")
        # The check has made a directory, as where a volume is not mounted.
        shutil.rmtree(folder)
        elsewhere.rename(folder)
        until(lambda: is_up(1))


def test_the_memory_of_the_store_is_told(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    told = samples(http)
    assert told["isomatch_store_memory_bytes"] > 1e5
    assert "isomatch_store_memory_limit_bytes" not in told
    api.store.client.config_set("maxmemory", 2**30)
    try:
        assert samples(http)["isomatch_store_memory_limit_bytes"] == 2**30
    finally:
        api.store.client.config_set("maxmemory", 0)


def heartbeat(api: Api, age: timedelta, **fields: str) -> None:
    """Put a worker in the store that was heard of so long ago."""
    when = utcformat((datetime.now(UTC) - age).replace(tzinfo=None))
    api.store.client.sadd(Worker.redis_workers_keys, "rq:worker:x")
    for name, value in {"last_heartbeat": when, "state": "idle", **fields}.items():
        api.store.client.hset("rq:worker:x", name, value)


def test_a_worker_that_is_silent_or_leaving_is_none(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    problem(http.get("/health/ready"), 503, "not-ready")
    heartbeat(api, timedelta(0))
    assert http.get("/health/ready").json() == {"status": "ok", "workers": 1}
    assert samples(http)["isomatch_workers{state=idle}"] == 1
    heartbeat(api, WORKER_TIMEOUT + timedelta(seconds=1))
    problem(http.get("/health/ready"), 503, "not-ready")
    heartbeat(api, timedelta(0), death="now")
    problem(http.get("/health/ready"), 503, "not-ready")
    assert samples(http)["isomatch_workers{state=idle}"] == 0


def test_where_workers_come_with_the_jobs_none_is_needed(own_server: EmbeddedServer) -> None:
    with (
        idle_api(own_server, ready_workers=0) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        assert http.get("/health/ready").json() == {"status": "ok", "workers": 0}


def test_a_store_that_is_full_is_not_ready(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    heartbeat(api, timedelta(0))
    assert http.get("/health/ready").status_code == 200
    api.store.client.config_set("maxmemory", 1)
    try:
        document = problem(http.get("/health/ready"), 503, "not-ready")
        assert "refuses writes" in document["detail"]
        files = {"file": ("a.off", blob_file(1))}
        problem(http.post("/v1/shapes", files=files), 503, "store-away")
        assert http.get("/health/live").status_code == 200
    finally:
        api.store.client.config_set("maxmemory", 0)
    assert http.get("/health/ready").status_code == 200


def test_a_store_that_evicts_is_not_ready(idle: tuple[httpx2.Client, Api]) -> None:
    http, api = idle
    heartbeat(api, timedelta(0))
    api.store.client.config_set("maxmemory", 2**30)
    assert http.get("/health/ready").status_code == 200
    api.store.client.config_set("maxmemory-policy", "allkeys-lru")
    try:
        document = problem(http.get("/health/ready"), 503, "not-ready")
        assert "maxmemory-policy is allkeys-lru" in document["detail"]
    finally:
        api.store.client.config_set("maxmemory-policy", "noeviction")
        api.store.client.config_set("maxmemory", 0)
    assert http.get("/health/ready").status_code == 200
