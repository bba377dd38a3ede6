"""Following a job: from the running service, and over connections that break."""

import json
from collections.abc import Iterator
from functools import partial

import httpx2
import isomatch
import pytest
from isomatch._http import EventReader, retries
from isomatch._models import JobRecord
from isomatch._operations import jobs

JOB = {
    "id": "1",
    "kind": "match",
    "state": "queued",
    "progress": {"stage": "queued", "fraction": 0.0},
    "created": "2026-01-01T00:00:00Z",
    "started": None,
    "ended": None,
    "position": 0,
    "error": None,
    "caller": None,
    "webhook": None,
}


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retries, "FIRST_PAUSE", 0.001)


def event(name: str, **changes: object) -> bytes:
    return f"event: job\ndata: {json.dumps(JOB | changes)}\nid: {name}\nretry: 5\n\n".encode()


class Breaking(httpx2.SyncByteStream):
    """A stream that breaks off."""

    def __init__(self, *chunks: bytes) -> None:
        self.chunks = chunks

    def __iter__(self) -> Iterator[bytes]:
        yield from self.chunks
        raise httpx2.ReadError("broken", request=httpx2.Request("GET", "http://service.test"))


class Service:
    """Answers with one stream after the other."""

    def __init__(self, *streams: bytes | httpx2.SyncByteStream | int | None) -> None:
        self.streams = list(streams)
        self.seen: list[str | None] = []

    def __call__(self, request: httpx2.Request) -> httpx2.Response:
        if not request.url.path.endswith("/events"):
            return httpx2.Response(200, json=JOB)
        self.seen.append(request.headers.get("last-event-id"))
        stream = self.streams.pop(0)
        if stream is None:
            raise httpx2.ConnectError("refused", request=request)
        if isinstance(stream, int):
            return httpx2.Response(stream)
        headers = {"content-type": "text/event-stream"}
        if isinstance(stream, bytes):
            return httpx2.Response(200, headers=headers, content=stream)
        return httpx2.Response(200, headers=headers, stream=stream)


def records(service: Service) -> list[JobRecord]:
    transport = httpx2.MockTransport(service)
    with isomatch.Client("http://service.test", transport=transport) as client:
        return list(client.job("1").events())


def followed(service: Service) -> list[str]:
    return [job.state for job in records(service)]


def test_a_broken_stream_is_resumed() -> None:
    service = Service(
        event("a"),
        Breaking(b": still there\n\n", event("b", state="running"), b"data: {"),
        None,
        event("c", state="succeeded") + b"data: never read\n\n",
    )
    assert followed(service) == ["queued", "running", "succeeded"]
    assert service.seen == [None, "a", "b", "b"]


def test_a_job_says_what_it_waits_for() -> None:
    streams = (
        event("a", waiting_for="worker"),
        event("b", waiting_for="turn", position=3),
        event("c", waiting_for="turn"),
        event("d", state="running", progress={"stage": "level 2", "fraction": 0.6}),
        event("e", state="running", waiting_for="turn", progress={"stage": "pairs", "fraction": 0}),
        event("f", state="succeeded"),
    )
    said = [job.stage for job in records(Service(b"".join(streams)))]
    assert said[:3] == ["no worker is alive", "3 jobs ahead", "next in the queue"]
    assert said[3:5] == ["level 2", "pairs, waiting for its turn"]


def test_failures_of_a_stream_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "LONGEST_OUTAGE", 0.0)
    with pytest.raises(isomatch.ConnectionFailed, match=r"be reached.*; job 1 continues"):
        followed(Service(event("a"), None, None, None, None))


def test_following_survives_a_restart_of_the_service() -> None:
    service = Service(event("a"), None, 502, None, 503, None, 504, event("b", state="succeeded"))
    assert followed(service) == ["queued", "succeeded"]


def test_a_stream_that_shows_itself_is_no_failure() -> None:
    """However often a proxy cuts it off."""
    cut = [Breaking(b": still there\n\n") for _ in range(6)]
    assert followed(Service(*cut, event("a", state="succeeded"))) == ["succeeded"]


def test_empty_streams_are_failures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "LONGEST_OUTAGE", 0.0)
    service = Service(*[b""] * 50)
    with pytest.raises(isomatch.ConnectionFailed, match="no events came"):
        followed(service)
    assert len(service.seen) == 4


def test_an_answer_that_is_no_stream_of_events_is_refused() -> None:
    requests: list[httpx2.Request] = []

    def login_page(request: httpx2.Request) -> httpx2.Response:
        if not request.url.path.endswith("/events"):
            return httpx2.Response(200, json=JOB)
        requests.append(request)
        assert len(requests) < 10
        return httpx2.Response(200, html="<h1>Log in</h1>")

    transport = httpx2.MockTransport(login_page)
    with (
        isomatch.Client("http://service.test", transport=transport) as client,
        pytest.raises(isomatch.UnexpectedResponse, match="no stream of events, but text/html"),
    ):
        list(client.job("1").events())
    assert len(requests) == 1


@pytest.mark.parametrize("data", [b"{", b'{"id": "1"}', b"[]"])
def test_events_that_are_not_jobs(data: bytes) -> None:
    with pytest.raises(isomatch.UnexpectedResponse, match="not a job"):
        followed(Service(b"data: " + data + b"\n\n"))


def test_lines_are_parsed_as_in_the_standard() -> None:
    reader = EventReader()
    lines = [
        "data: a",
        "data:b",
        ": c",
        "retry: 1",
        "id: 1",
        "",
        "",
        "data",
        "",
        "id",
        "data: d",
        "",
    ]
    events = [event for event in map(reader.feed, lines) if event is not None]
    assert [(event.data, event.id) for event in events] == [("a\nb", "1"), ("", "1"), ("d", "")]


def test_a_match_is_followed(
    client: isomatch.Client, pair: tuple[isomatch.Shape, isomatch.Shape]
) -> None:
    job = client.match(*pair, points=24)
    told = [(step.state, step.progress.fraction) for step in job.events()]
    assert told[-1] == ("succeeded", 1.0)
    assert [fraction for _, fraction in told] == sorted(fraction for _, fraction in told)
    assert len(job.result().pairs) == 24
    assert [step.state for step in client.job(job.id).events()] == ["succeeded"]
    with pytest.raises(isomatch.NotFound):
        next(isomatch.Job(client._transport, job.record.model_copy(update={"id": "x"})).events())


def test_the_same_key_is_the_same_job(
    client: isomatch.Client, pair: tuple[isomatch.Shape, isomatch.Shape]
) -> None:
    asked = partial(client.match, *pair, orientation=False)
    job = asked(points=8, idempotency_key="once")
    assert asked(points=8, idempotency_key="once").id == job.id
    with pytest.raises(isomatch.Conflict):
        asked(points=9, idempotency_key="once")
    assert asked(points=8).id != job.id
