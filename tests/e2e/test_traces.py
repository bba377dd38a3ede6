"""Traces of the whole service: from a request over the queue into the stages of its jobs."""

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from demo.stack import Stack, running_stack
from tests.client.shapes import LASTING, write_blobs
from tests.collector import Collector, Exported, collecting
from tests.processes import descendants
from tests.stack import PATIENT
from tests.waiting import until

TRACES = {"OTEL_BSP_SCHEDULE_DELAY": "100", "ISOMATCH_WORKERS": "2", "ISOMATCH_HEARTBEAT": "2"}

QUICK: dict[str, Any] = {"points": 8, "eigenpairs": 30, "orientation": False}


@pytest.fixture(scope="module")
def collector() -> Iterator[Collector]:
    with collecting() as collector:
        yield collector


@pytest.fixture(scope="module")
def traced(collector: Collector) -> Iterator[Stack]:
    """A service that exports traces, and logs to a file that is still there after each test."""
    settings = {**PATIENT, **TRACES, "OTEL_EXPORTER_OTLP_ENDPOINT": collector.url}
    with running_stack(settings) as running:
        yield running


@pytest.fixture
def http(traced: Stack) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=traced.url, timeout=300.0) as http:
        yield http


@pytest.fixture(scope="module")
def shapes(traced: Stack, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    paths = write_blobs(tmp_path_factory.mktemp("traces"))
    with httpx2.Client(base_url=traced.url, timeout=300.0) as http:
        return [_upload(http, path) for path in paths]


def _upload(http: httpx2.Client, path: Path) -> str:
    with path.open("rb") as file:
        shape: str = http.post("/v1/shapes", files={"file": (path.name, file)}).json()["id"]
    return shape


def caller(number: int) -> tuple[str, dict[str, str]]:
    """A trace of a caller, and the header that says so."""
    trace = f"{number:032x}"
    return trace, {"traceparent": f"00-{trace}-00000000000000aa-01"}


def named(spans: list[Exported], name: str) -> Exported:
    (found,) = [span for span in spans if span.name == name]
    return found


def test_one_trace_from_the_request_to_the_stages(
    traced: Stack, http: httpx2.Client, shapes: list[str], collector: Collector
) -> None:
    trace, header = caller(0xA1)
    body = {"source": shapes[0], "target": shapes[1], "dense": True, "points": 16}
    job = http.post("/v1/matches", json=body, headers=header).json()
    assert http.get(job["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"
    until(lambda: {"match", "storing"} <= {span.name for span in collector.of(trace)})
    spans = collector.of(trace)
    request, match = named(spans, "POST /v1/matches"), named(spans, "match")
    assert request.parent == "00000000000000aa"
    assert request.service == "isomatch-api"
    assert match.parent == request.id
    assert match.service == "isomatch-worker"
    assert match.attributes["isomatch.job_id"] == job["id"]
    jobs = [span for span in spans if "isomatch.job_id" in span.attributes]
    waits = [span for span in spans if span.name == "in the queue"]
    assert len(waits) == len(jobs)
    assert {span.parent for span in (*jobs, *waits)} == {request.id}
    stages = [span for span in spans if span.parent == match.id]
    assert {"spectrum of the source", "spectrum of the target", "storing"} <= {
        stage.name for stage in stages
    }
    assert len(stages) > 5
    # Stages follow one another within the job, and take nearly all of its time.
    ends = [second for stage in stages for second in stage.seconds]
    assert ends == sorted(ends)
    assert match.seconds[0] <= ends[0]
    assert ends[-1] <= match.seconds[1]
    taken = sum(end - start for start, end in (stage.seconds for stage in stages))
    assert taken > 0.5 * (match.seconds[1] - match.seconds[0])

    # The log lines of both have the ids of their spans.
    lines = [json.loads(line) for line in traced.log.read_text().splitlines()]
    told = {line["event"]: line["span_id"] for line in lines if line.get("trace_id") == trace}
    assert told["request"] == request.id
    assert match.id in {
        line["span_id"] for line in lines if line.get("trace_id") == trace and "job_id" in line
    }

    accepted = {"accept": "application/openmetrics-text; version=1.0.0"}
    metrics = http.get("/metrics", headers=accepted).text
    assert f'trace_id="{trace}"' in metrics


def test_matches_of_a_batch_belong_to_its_trace(
    http: httpx2.Client, shapes: list[str], collector: Collector
) -> None:
    trace, header = caller(0xB1)
    body = {"source": shapes[0], "targets": [shapes[1], shapes[0], shapes[1]], **QUICK}
    job = http.post("/v1/batches", json=body, headers=header).json()
    assert http.get(job["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"
    until(lambda: [span.name for span in collector.of(trace)].count("match") == 3)
    spans = collector.of(trace)
    request = named(spans, "POST /v1/batches")
    assert {span.parent for span in spans if span.name == "match"} == {request.id}


def test_slices_of_a_comparison_belong_to_its_trace(
    http: httpx2.Client, shapes: list[str], collector: Collector
) -> None:
    trace, header = caller(0xC1)
    body = {"shapes": shapes, "points": 4}
    job = http.post("/v1/dissimilarities", json=body, headers=header).json()
    assert http.get(job["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"

    def stages() -> set[str]:
        spans = collector.of(trace)
        slices = {span.id for span in spans if span.name == "turn"}
        return {span.name for span in spans if span.parent in slices}

    # Each slice is exported when it ends.
    until(lambda: stages() >= {"structures", "pairs"})


def test_an_attempt_after_a_kill_links_to_the_one_before(
    traced: Stack, http: httpx2.Client, shapes: list[str], collector: Collector
) -> None:
    trace, header = caller(0xD1)
    body = {"source": shapes[0], "target": shapes[1], **LASTING}
    # Before the job is accepted: a worker may start its process before the answer has arrived.
    before = descendants(traced.process.pid)
    path = http.post("/v1/matches", json=body, headers=header).json()["links"]["self"]
    until(lambda: http.get(path).json()["progress"]["fraction"] > 0.4)
    # The process of the job is the only one that was not there before.
    (horse,) = descendants(traced.process.pid) - before
    os.kill(horse, signal.SIGKILL)
    until(lambda: "match lost" in {span.name for span in collector.of(trace)})
    lost = named(collector.of(trace), "match lost")
    assert lost.failed
    assert lost.parent == named(collector.of(trace), "POST /v1/matches").id
    until(lambda: http.get(path).json()["state"] == "running")
    http.delete(path)
    until(lambda: "match" in {span.name for span in collector.of(trace)})
    assert named(collector.of(trace), "match").links == (lost.id,)


def test_a_collector_that_is_away_delays_nothing(tmp_path: Path) -> None:
    a, b = write_blobs(tmp_path)
    # Nothing listens there.
    settings = {**PATIENT, **TRACES, "OTEL_EXPORTER_OTLP_ENDPOINT": "http://127.0.0.1:9"}
    with (
        running_stack(settings) as stack,
        httpx2.Client(base_url=stack.url, timeout=300.0) as http,
    ):
        body = {"source": _upload(http, a), "target": _upload(http, b), **QUICK}
        for _ in range(4):
            path = http.post("/v1/matches", json=body).json()["links"]["self"]
            assert http.get(path, params={"wait": 60}).json()["state"] == "succeeded"
        lines = [json.loads(line) for line in stack.log.read_text().splitlines()]
    dropped = [line for line in lines if "the collector of traces" in line["event"]]
    # Once for each process that exports for long, not for each job.
    assert 1 <= len(dropped) <= 4
    assert all(line["level"] != "error" or "export" in line["event"] for line in lines)
