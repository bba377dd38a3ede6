"""A job followed by server-sent events, over a connection that is read as it comes in."""

import json
import time
from collections.abc import Iterator
from threading import Timer
from typing import Any

import httpx2
import pytest

from broker.contracts import Progress
from broker.store import DEFAULT_KEYS
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, idle_api, problem, put_shapes
from tests.waiting import until

HEARTBEAT = 0.3
LIFETIME = 2.0


@pytest.fixture(scope="module")
def api(server: EmbeddedServer) -> Iterator[Api]:
    with idle_api(server, events_heartbeat=HEARTBEAT, events_lifetime=LIFETIME) as api:
        yield api


@pytest.fixture
def http(api: Api) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=api.url, timeout=120.0) as http:
        yield http


def asked(http: httpx2.Client, api: Api) -> Json:
    source, target = put_shapes(api)
    body = {
        "source": source,
        "target": target,
        "metric": "geodesic",
        "descriptor": "none",
        "orientation": False,
    }
    job: Json = http.post("/v1/matches", json=body).json()
    return job


@pytest.fixture
def job(http: httpx2.Client, api: Api) -> Json:
    return asked(http, api)


@pytest.fixture
def lasting(server: EmbeddedServer) -> Iterator[tuple[httpx2.Client, Api, Json]]:
    """A job, and an API whose streams last longer than any machine takes to read them."""
    with (
        idle_api(server, events_heartbeat=HEARTBEAT, events_lifetime=300.0) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        yield http, api, asked(http, api)


def events(stream: httpx2.Response) -> Iterator[dict[str, str]]:
    """The events of a stream, as the standard reads them."""
    event: dict[str, str] = {}
    for line in stream.iter_lines():
        if line:
            field, _, value = line.partition(":")
            event[field or "comment"] = value.removeprefix(" ")
        elif event:
            yield event
            event = {}


def told_of(stream: httpx2.Response) -> Iterator[dict[str, str]]:
    """The events that tell of the job, and not only that the stream is there."""
    return (event for event in events(stream) if "data" in event)


def follow(http: httpx2.Client, job: Json, last: str | None = None) -> Any:
    headers = {} if last is None else {"Last-Event-ID": last}
    return http.stream("GET", job["links"]["events"], headers=headers)


def test_events_follow_the_job_until_it_has_ended(
    lasting: tuple[httpx2.Client, Api, Json],
) -> None:
    http, api, job = lasting
    with follow(http, job) as stream:
        assert stream.status_code == 200
        assert stream.headers["content-type"].startswith("text/event-stream")
        assert stream.headers["cache-control"] == "no-store"
        coming = told_of(stream)
        first = next(coming)
        assert first["event"] == "job"
        assert json.loads(first["data"]) == http.get(job["links"]["self"]).json()
        assert int(first["retry"]) > 0
        api.store.jobs.claim(job["id"], "me")
        assert json.loads(next(coming)["data"])["state"] == "running"
        api.store.jobs.report(job["id"], "me", Progress(stage="half", fraction=0.5))
        assert json.loads(next(coming)["data"])["progress"] == {"stage": "half", "fraction": 0.5}
        api.store.jobs.succeed(job["id"], "me", b"{}")
        last = next(coming)
        assert json.loads(last["data"])["state"] == "succeeded"
        assert list(coming) == []
    # Who comes back for more is told to stay away; who does not know the end yet is told it.
    with follow(http, job, last["id"]) as stream:
        assert stream.status_code == 204
    with follow(http, job, first["id"]) as stream:
        assert [event["id"] for event in told_of(stream)] == [last["id"]]


def test_a_match_that_waits_ends_with_its_batch(
    lasting: tuple[httpx2.Client, Api, Json],
) -> None:
    http, api, match = lasting
    body = {"source": match["source"], "targets": [match["target"]] * 2, "points": 8}
    batch: Json = http.post("/v1/batches", json=body).json()
    waiting: Json = http.get(f"/v1/jobs/{batch['id']}-2").json()
    with follow(http, waiting) as stream:
        coming = told_of(stream)
        assert json.loads(next(coming)["data"]) == waiting
        ended = http.delete(batch["links"]["self"]).json()["ended"]
        last = next(coming)
        cancelled = json.loads(last["data"])
        assert (cancelled["state"], cancelled["ended"]) == ("cancelled", ended)
        assert list(coming) == []
    with follow(http, waiting, last["id"]) as stream:
        assert stream.status_code == 204
    for ask in http.get, http.delete:
        assert ask(waiting["links"]["self"]).json() == cancelled
    problem(http.get(waiting["links"]["result"]), 409, "job-without-result")
    problem(http.get(f"/v1/jobs/{batch['id']}-3"), 404, "job-not-found")
    for job in http.get(f"/v1/batches/{batch['id']}").json()["matches"]:
        assert job["state"] == http.get(f"/v1/jobs/{job['job']}").json()["state"] == "cancelled"
    api.store.client.delete(DEFAULT_KEYS.job(batch["id"]))
    problem(http.get(waiting["links"]["self"]), 410, "job-expired")


def test_the_last_event_is_not_repeated(lasting: tuple[httpx2.Client, Api, Json]) -> None:
    http, api, job = lasting
    with follow(http, job) as stream:
        first = next(events(stream))
    with follow(http, job, first["id"]) as stream:
        timer = Timer(0.4, lambda: api.store.jobs.cancel(job["id"]))
        timer.start()
        told = list(told_of(stream))
        timer.join()
    assert [json.loads(event["data"])["state"] for event in told] == ["cancelled"]


def test_streams_send_heartbeats_and_end_after_their_lifetime(
    http: httpx2.Client, job: Json
) -> None:
    start = time.monotonic()
    with follow(http, job) as stream:
        told = list(events(stream))
    assert time.monotonic() - start >= LIFETIME
    assert "data" in told[0]
    assert 1 <= len(told[1:]) <= LIFETIME / HEARTBEAT + 1
    assert all(set(event) == {"comment"} for event in told[1:])


def test_a_record_that_expires_ends_it(http: httpx2.Client, api: Api, job: Json) -> None:
    with follow(http, job) as stream:
        coming = events(stream)
        next(coming)
        api.store.client.delete(DEFAULT_KEYS.job(job["id"]))
        assert all("data" not in event for event in coming)
    problem(http.get(job["links"]["events"]), 410, "job-expired")


def test_a_record_that_a_newer_version_goes_on_with_ends_it(
    lasting: tuple[httpx2.Client, Api, Json],
) -> None:
    http, api, job = lasting
    with follow(http, job) as stream:
        coming = events(stream)
        next(coming)
        api.store.client.hset(DEFAULT_KEYS.job(job["id"]), "state", "paused")
        # The stream ends as it should: one that broke off would be an error here.
        assert all("data" not in event for event in coming)
    problem(http.get(job["links"]["events"]), 503, "newer-version")


def looked_at(api: Api, job: Json, seconds: float) -> bool:
    """Whether anybody looks at a job within a time."""
    end = time.monotonic() + seconds
    with api.store.client.monitor() as monitor:
        while (left := end - time.monotonic()) > 0:
            told = monitor.connection.can_read(timeout=left)
            if told and job["id"] in monitor.next_command()["command"]:
                return True
    return False


def test_a_client_that_goes_away_costs_nothing_more(server: EmbeddedServer) -> None:
    with (
        idle_api(server, events_heartbeat=HEARTBEAT, events_lifetime=300.0) as api,
        httpx2.Client(base_url=api.url, timeout=120.0) as http,
    ):
        job = asked(http, api)
        with follow(http, job) as stream:
            next(events(stream))
            assert looked_at(api, job, 60.0)
        # Long before its time is over nobody looks at the job any more.
        until(lambda: not looked_at(api, job, 0.8), 120.0)


def test_jobs_of_nobody_have_no_events(http: httpx2.Client) -> None:
    problem(http.get("/v1/jobs/nobody/events"), 404, "job-not-found")
