"""Connections that fail, and answers that are not the service's."""

import asyncio
import json
import os
import socket
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from pathlib import Path
from typing import Any, BinaryIO

import httpx2
import isomatch
import numpy as np
import pytest
from isomatch._http import retries
from isomatch._models import JobRecord
from isomatch._operations import jobs

SHAPE = {
    "id": "0" * 32,
    "name": "cat",
    "file_type": "off",
    "bytes": 100,
    "vertices": 3,
    "faces": 1,
    "area": 0.5,
    "components": 1,
    "closed": False,
    "has_colors": False,
    "warnings": [],
    "created": "2026-01-01T00:00:00Z",
}

JOB: dict[str, object] = {
    "id": "0" * 32,
    "created": "2026-01-01T00:00:00Z",
    "kind": "mesh",
    "state": "succeeded",
    "progress": {"stage": "finished", "fraction": 1.0},
    "started": None,
    "ended": None,
    "position": None,
    "error": None,
    "caller": None,
    "webhook": None,
}

Answer = Callable[[httpx2.Request], httpx2.Response]


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retries, "FIRST_PAUSE", 0.01)


def client_of(answer: Answer) -> isomatch.Client:
    return isomatch.Client("http://service.test", transport=httpx2.MockTransport(answer))


def closed_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port: int = listener.getsockname()[1]
        return port


class Broken:
    """Fails a number of times before it answers."""

    def __init__(self, failures: int, error: type[httpx2.TransportError], document: object) -> None:
        self.failures, self.error, self.document = failures, error, document
        self.requests: list[httpx2.Request] = []

    def __call__(self, request: httpx2.Request) -> httpx2.Response:
        self.requests.append(request)
        if len(self.requests) <= self.failures:
            raise self.error("broken", request=request)
        return httpx2.Response(200, json=self.document)


def test_nothing_listens() -> None:
    port = closed_port()
    with (
        isomatch.Client(f"http://127.0.0.1:{port}") as client,
        pytest.raises(isomatch.ConnectionFailed, match=f"127.0.0.1:{port} cannot be reached"),
    ):
        client.shape("0" * 32)


def test_a_proxy_of_the_environment_is_not_used_for_the_loopback_address(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("http_proxy", f"http://192.0.2.1:{closed_port()}")
    monkeypatch.setenv("no_proxy", "")
    with (
        isomatch.Client(f"http://127.0.0.1:{closed_port()}", timeout=2) as client,
        pytest.raises(isomatch.ConnectionFailed, match="refused"),
    ):
        client.shape("0" * 32)


@pytest.mark.parametrize("error", [httpx2.ConnectError, httpx2.ReadError, httpx2.ReadTimeout])
def test_a_safe_request_is_repeated(error: type[httpx2.TransportError]) -> None:
    service = Broken(3, error, SHAPE)
    with client_of(service) as client:
        assert client.shape("0" * 32).name == "cat"
    assert len(service.requests) == 4


def test_an_upload_is_repeated_from_its_beginning() -> None:
    service = Broken(2, httpx2.WriteError, SHAPE)
    with client_of(service) as client:
        client.upload(b"OFF\n", file_type="off")
    bodies = [request.read() for request in service.requests]
    assert len(bodies) == 3
    assert all(b"OFF\n" in body for body in bodies)


def test_retries_are_limited() -> None:
    service = Broken(100, httpx2.ReadError, SHAPE)
    with client_of(service) as client, pytest.raises(isomatch.ConnectionFailed, match="broke"):
        client.shape("0" * 32)
    assert len(service.requests) == 4


def test_a_service_that_does_not_hold_answers_back_is_not_flooded() -> None:
    service = Broken(0, httpx2.ReadError, JOB | {"state": "running"})
    with client_of(service) as client, pytest.raises(isomatch.WaitTimeout):
        client.job("0" * 32).wait(timeout=0.6)
    assert len(service.requests) <= 4


def test_an_exceeded_timeout_names_the_job() -> None:
    service = Broken(0, httpx2.ReadError, JOB | {"state": "running"})
    with client_of(service) as client, pytest.raises(isomatch.WaitTimeout) as late:
        client.job("0" * 32).wait(timeout=0.0)
    assert late.value.job_id == "0" * 32


@pytest.mark.parametrize(("error", "repeated"), [(httpx2.ConnectError, 0), (httpx2.ReadError, 4)])
def test_landmarks_that_were_never_sent_are_not_withdrawn(
    error: type[httpx2.TransportError], repeated: int
) -> None:
    service = Broken(100, error, JOB)
    template = isomatch.LandmarkTemplate(
        isomatch.Shape.model_validate(SHAPE), isomatch.LandmarkSet(("a",), np.zeros((1, 3)))
    )
    with client_of(service) as client, pytest.raises(isomatch.ConnectionFailed):
        client.landmarks([template], "0" * 32)
    assert len(service.requests) == 4 + repeated


def test_waiting_for_a_job_survives_a_restart_of_the_service(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pauses: list[float] = []
    monkeypatch.setattr(time, "sleep", pauses.append)
    service = Broken(10, httpx2.ConnectError, JOB)
    with client_of(service) as client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB | {"state": "running"}))
        assert job.wait().state == "succeeded"
    assert max(pauses) <= 6.0


@pytest.mark.parametrize("timeout", [None, 0.02])
def test_a_service_that_stays_away_is_an_error_that_names_the_job(
    monkeypatch: pytest.MonkeyPatch, timeout: float | None
) -> None:
    if timeout is None:
        monkeypatch.setattr(jobs, "LONGEST_OUTAGE", 0.02)
    with client_of(Broken(10_000, httpx2.ConnectError, JOB)) as client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB | {"state": "running"}))
        with pytest.raises(
            isomatch.ConnectionFailed, match=f"reached.*; job {job.id} cont"
        ) as failure:
            job.wait(timeout)
    assert failure.value.job_id == job.id


@pytest.mark.parametrize("status", [502, 504])
def test_a_proxy_that_does_not_reach_the_service_is_asked_again(status: int) -> None:
    answers = [httpx2.Response(status, html="<p>Bad gateway"), httpx2.Response(200, json=SHAPE)]
    with client_of(lambda _: answers.pop(0)) as client:
        assert client.shape("0" * 32).name == "cat"


def test_a_busy_service_is_an_error_that_names_the_job(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "LONGEST_OUTAGE", 0.0)
    client, _ = busy(monkeypatch, *[(503, None)] * 4)
    with client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB | {"state": "running"}))
        with pytest.raises(
            isomatch.ServiceUnavailable, match=f"Busy; job {job.id} continues"
        ) as refusal:
            job.wait()
    assert refusal.value.job_id == job.id


def test_an_open_file_is_sent_from_its_beginning_each_time(tmp_path: Path) -> None:
    service = Broken(2, httpx2.WriteError, SHAPE)
    (tmp_path / "a.off").write_bytes(b"OFF\n" * 50_000)
    with client_of(service) as client, (tmp_path / "a.off").open("rb") as file:
        file.seek(3)
        client.upload(file)
        assert not file.closed
    assert [request.read().count(b"OFF\n") for request in service.requests] == [50_000] * 3


@contextmanager
def pipe(content: bytes) -> Iterator[BinaryIO]:
    reading, writing = os.pipe()
    with os.fdopen(writing, "wb") as end:
        end.write(content)
    with os.fdopen(reading, "rb") as stream:
        yield stream


@pytest.mark.parametrize("kind", ["mesh", "attributes", "prototype"])
def test_a_pipe_is_sent_whole_each_time(kind: str) -> None:
    service = Broken(2, httpx2.WriteError, {})
    uploads: dict[str, Callable[[isomatch.Client, BinaryIO], object]] = {
        "mesh": lambda client, stream: client.upload(stream, file_type="off"),
        "attributes": lambda client, stream: client.upload_attributes(stream, file_type="npz"),
        "prototype": lambda client, stream: client.upload_prototype(stream),
    }
    with (
        client_of(service) as client,
        pipe(b"OFF\n" * 1500) as stream,
        pytest.raises(isomatch.UnexpectedResponse),
    ):
        uploads[kind](client, stream)
    assert [request.read().count(b"OFF\n") for request in service.requests] == [1500] * 3
    lengths = {int(request.headers["content-length"]) for request in service.requests}
    assert lengths == {len(request.read()) for request in service.requests}


def busy(
    monkeypatch: pytest.MonkeyPatch, *answers: tuple[int, str | None]
) -> tuple[isomatch.Client, list[float]]:
    """A client whose service is busy at first, and the seconds it pauses."""
    pauses: list[float] = []
    monkeypatch.setattr(time, "sleep", pauses.append)
    left = list(answers)

    def answer(request: httpx2.Request) -> httpx2.Response:
        if not left:
            return httpx2.Response(200, json=SHAPE)
        status, after = left.pop(0)
        problem = {"type": "urn:isomatch:problem:busy", "title": "Busy", "status": status}
        headers = {"content-type": "application/problem+json"}
        if after is not None:
            headers["retry-after"] = after
        return httpx2.Response(status, content=json.dumps(problem), headers=headers)

    return client_of(answer), pauses


def test_retry_after_of_a_busy_service_is_respected(monkeypatch: pytest.MonkeyPatch) -> None:
    later = format_datetime(datetime.now(UTC) + timedelta(seconds=20), usegmt=True)
    client, pauses = busy(monkeypatch, (503, "7"), (429, later), (503, None))
    with client:
        assert client.shape("1").name == "cat"
    assert pauses[0] == 7.0
    assert 0.0 < pauses[1] <= 20.0
    assert 0.05 < pauses[2] < 0.15  # 0.01, thrice as long each time


@pytest.mark.parametrize(
    ("answers", "kind", "paused"),
    [
        ([(503, "1")] * 4, isomatch.ServiceUnavailable, [1.0] * 3),
        ([(429, "3600")], isomatch.TooManyRequests, []),
        ([(500, "1")], isomatch.ServiceError, []),
    ],
)
def test_a_long_retry_after_is_an_error(
    monkeypatch: pytest.MonkeyPatch,
    answers: list[tuple[int, str | None]],
    kind: type[isomatch.ProblemError],
    paused: list[float],
) -> None:
    client, pauses = busy(monkeypatch, *answers)
    with client, pytest.raises(kind, match="Busy") as refusal:
        client.shape("1")
    assert pauses == paused
    assert refusal.value.retry_after == float(answers[-1][1] or 0)
    assert refusal.value.problem.type == "urn:isomatch:problem:busy"


def test_repeating_can_be_switched_off() -> None:
    service = Broken(1, httpx2.ConnectError, SHAPE)
    transport = httpx2.MockTransport(service)
    with (
        isomatch.Client("http://service.test", retries=0, transport=transport) as client,
        pytest.raises(isomatch.ConnectionFailed),
    ):
        client.shape("1")
    assert len(service.requests) == 1


def test_a_repeated_match_has_the_same_idempotency_key() -> None:
    service = Broken(2, httpx2.ReadError, {})
    with client_of(service) as client:
        for key in (None, None, "mine"):
            with pytest.raises(isomatch.UnexpectedResponse):
                client.match("a", "b", idempotency_key=key)
    keys = [request.headers["idempotency-key"] for request in service.requests]
    assert len(keys) == 5
    assert len(set(keys[:3])) == 1
    assert len(set(keys)) == 3
    assert keys[4] == "mine"


def test_a_match_that_was_never_sent_is_sent_again() -> None:
    service = Broken(1, httpx2.ConnectError, {})
    with client_of(service) as client, pytest.raises(isomatch.UnexpectedResponse):
        client.match("a", "b")
    assert len(service.requests) == 2


def test_answers_that_the_service_holds_back_are_waited_for(tmp_path: Path) -> None:
    """An upload until it is read, and files until they are made, whatever the timeout is."""
    service = Broken(0, httpx2.ReadError, SHAPE | JOB)
    transport = httpx2.MockTransport(service)
    with isomatch.Client("http://service.test", timeout=1.0, transport=transport) as client:
        client.upload(b"OFF", file_type="off")
        job = client.job("1")
        job.save_arrays(tmp_path / "result.npz")
        job.save_picture(tmp_path / "result.png")
    patience = [request.extensions["timeout"]["read"] for request in service.requests]
    assert patience == [61.0, 1.0, 61.0, 61.0]


def test_names_of_files_that_are_not_utf8_are_sent(tmp_path: Path) -> None:
    service = Broken(0, httpx2.ReadError, SHAPE)
    path = tmp_path / os.fsdecode(b"caf\xe9.off")
    path.write_bytes(b"OFF")
    with client_of(service) as client:
        client.upload(path)
        client.upload(b"OFF", os.fsdecode(b"th\xe9"), file_type="off")
    first, second = (request.read() for request in service.requests)
    assert "caf\ufffd.off".encode() in first
    assert "th\ufffd".encode() in second


def test_numbers_and_arrays_of_numpy_are_sent_as_json() -> None:
    service = Broken(0, httpx2.ReadError, {})
    pairs = np.array([[0, 1], [2, 3]])
    given: list[dict[str, Any]] = [
        {"points": np.int64(8), "landmarks": pairs},
        {"landmarks": [tuple(pair) for pair in pairs], "metric": [{"time": np.float32(0.5)}]},
    ]
    for parameters in given:
        with client_of(service) as client, pytest.raises(isomatch.UnexpectedResponse):
            client.match("a", "b", **parameters)
    first, second = (json.loads(request.content) for request in service.requests)
    assert (first["points"], second["metric"]) == (8, [{"time": 0.5}])
    assert first["landmarks"] == second["landmarks"] == [[0, 1], [2, 3]]
    strange: dict[str, Any] = {"points": object()}
    with client_of(service) as client, pytest.raises(TypeError, match="points: object is not JSON"):
        client.match("a", "b", **strange)


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("beta", float("nan")),
        ("time_limit", float("inf")),
        ("metric", [{"name": "diffusion", "time": np.float64("inf")}]),
    ],
)
def test_numbers_that_are_not_finite_are_named(name: str, given: object) -> None:
    service = Broken(0, httpx2.ReadError, {})
    parameters: dict[str, Any] = {name: given}
    with client_of(service) as client, pytest.raises(ValueError, match=f"^{name}: .* finite"):
        client.match("a", "b", **parameters)
    assert not service.requests


@pytest.mark.parametrize("key", ["", "a\nb", "é", 256 * "a"])
def test_idempotency_keys_that_the_service_refuses_are_not_sent(key: str) -> None:
    service = Broken(0, httpx2.ReadError, {})
    with client_of(service) as client, pytest.raises(ValueError, match="1 to 255 characters"):
        client.match("a", "b", idempotency_key=key)
    assert not service.requests


def test_only_given_parameters_are_sent() -> None:
    service = Broken(0, httpx2.ReadError, {})
    with client_of(service) as client, pytest.raises(isomatch.UnexpectedResponse):
        client.match("a", "b", points=8, occlusion_cost=None, metric=["geodesic"])
    assert json.loads(service.requests[0].content) == {
        "source": "a",
        "target": "b",
        "points": 8,
        "occlusion_cost": None,
        "metric": ["geodesic"],
    }


def test_a_misspelt_parameter_is_not_sent() -> None:
    service = Broken(0, httpx2.ReadError, {})
    with client_of(service) as client, pytest.raises(TypeError, match="'pints'"):
        client.match("a", "b", pints=8)  # type: ignore[call-arg]
    assert not service.requests


@pytest.mark.parametrize("missing", [None, float("nan")])
def test_missing_labels_are_not_sent(missing: Any) -> None:
    with (
        client_of(lambda _: pytest.fail("sent")) as client,
        pytest.raises(TypeError, match="label"),
    ):
        client.dissimilarities(["0" * 32, "1" * 32], [missing, "cat"])


def test_vertices_that_are_no_integers_are_not_sent() -> None:
    with (
        client_of(lambda _: pytest.fail("sent")) as client,
        pytest.raises(TypeError, match="float"),
    ):
        client.learn_prototype(["0" * 32, "1" * 32], [[1.7, 2], [1, 2]])  # type: ignore[list-item]


@pytest.mark.parametrize(
    "newer", [{"waiting_for": "licence"}, {"state": "paused"}, {"webhook": {"state": "held"}}]
)
def test_jobs_of_newer_services_are_read(newer: dict[str, Any]) -> None:
    hook = {"url": "http://a", "attempts": 0, "last_attempt": None, "status": None, "error": None}
    hook |= {"next_attempt": None, "state": "pending"}
    document = JOB | newer
    if "webhook" in newer:
        document["webhook"] = hook | newer["webhook"]
    with client_of(lambda _: httpx2.Response(200, json=document)) as client:
        (name,) = newer
        found = client.job("0" * 32).record.model_dump(mode="json")[name]
    assert found == document[name]


def test_unknown_fields_are_ignored() -> None:
    with client_of(lambda _: httpx2.Response(200, json={**SHAPE, "genus": 2})) as client:
        assert not hasattr(client.shape("0" * 32), "genus")


def without(field: str) -> dict[str, object]:
    return {name: value for name, value in SHAPE.items() if name != field}


@pytest.mark.parametrize(
    ("response", "message"),
    [
        (httpx2.Response(200, json=without("area")), "area: Field required"),
        (httpx2.Response(200, json={**SHAPE, "area": None}), "area: "),
        (httpx2.Response(200, content=json.dumps({**SHAPE, "area": float("nan")})), "area: "),
        (httpx2.Response(200, html="<p>Welcome"), "Invalid JSON"),
        (httpx2.Response(404, html="<p>Not found"), "404 without a reason"),
        (httpx2.Response(304), "304 without a reason"),
        (httpx2.Response(308, headers={"location": "/a"}), "308, moved to http://service.test/a"),
    ],
)
def test_answers_of_other_services(response: httpx2.Response, message: str) -> None:
    with (
        client_of(lambda _: response) as client,
        pytest.raises(isomatch.UnexpectedResponse, match=message),
    ):
        client.shape("0" * 32)


@pytest.mark.parametrize(
    ("status", "kind"),
    [
        (400, isomatch.BadRequest),
        (401, isomatch.Unauthorized),
        (403, isomatch.Forbidden),
        (413, isomatch.TooLarge),
        (429, isomatch.TooManyRequests),
        (502, isomatch.ServiceError),
        (503, isomatch.ServiceUnavailable),
        (504, isomatch.ServiceError),
    ],
)
def test_refusals_of_a_proxy_have_the_class_of_their_status(
    status: int, kind: type[isomatch.ProblemError]
) -> None:
    answer = httpx2.Response(status, html="<p>No", headers={"retry-after": "90"})
    with client_of(lambda _: answer) as client, pytest.raises(kind) as refusal:
        client.shape("1")
    assert (refusal.value.status, refusal.value.retry_after) == (status, 90.0)
    said = f"GET http://service.test/v1/shapes/1 was refused, perhaps by a proxy: {status} "
    assert str(refusal.value) == said + refusal.value.title


class NoGzip(httpx2.AsyncByteStream, httpx2.SyncByteStream):
    """Bytes that are not what their encoding says."""

    def __iter__(self) -> Iterator[bytes]:
        yield b"no gzip"

    async def __aiter__(self) -> AsyncIterator[bytes]:
        yield b"no gzip"


def broken_encoding(_: httpx2.Request) -> httpx2.Response:
    return httpx2.Response(200, headers={"content-encoding": "gzip"}, stream=NoGzip())


def test_answers_that_cannot_be_decoded() -> None:
    with client_of(broken_encoding) as client:
        job = isomatch.Job(client._transport, JobRecord.model_validate(JOB))
        with pytest.raises(isomatch.UnexpectedResponse, match=r"GET .*isomatch API"):
            client.shape("1")
        with pytest.raises(isomatch.UnexpectedResponse, match=r"GET .*isomatch API"):
            list(job.events())


def test_answers_that_cannot_be_decoded_asynchronously() -> None:
    async def ask() -> None:
        transport = httpx2.MockTransport(broken_encoding)
        async with isomatch.AsyncClient("http://service.test", transport=transport) as client:
            job = isomatch.AsyncJob(client._transport, JobRecord.model_validate(JOB))
            with pytest.raises(isomatch.UnexpectedResponse):
                await client.shape("1")
            with pytest.raises(isomatch.UnexpectedResponse):
                async for _ in job.events():
                    pass

    asyncio.run(ask())


def test_ids_lead_to_no_other_path() -> None:
    service = Broken(0, httpx2.ReadError, SHAPE)
    with client_of(service) as client, pytest.raises(ValueError, match="is no id"):
        client.shape("../jobs/1?x=#")
    assert not service.requests


@pytest.mark.parametrize("kind", [isomatch.Client, isomatch.AsyncClient])
@pytest.mark.parametrize(
    ("name", "given", "error"),
    [
        ("timeout", -1, ValueError),
        ("timeout", 0.0, ValueError),
        ("timeout", float("nan"), ValueError),
        ("timeout", "x", TypeError),
        ("retries", -1, ValueError),
        ("retries", "x", TypeError),
        ("retries", 1.5, TypeError),
        ("api_key", 5, TypeError),
        ("base_url", 5, TypeError),
    ],
)
def test_wrong_arguments_of_clients_are_named(
    kind: type, name: str, given: object, error: type[Exception]
) -> None:
    with pytest.raises(error, match=f"^{name} must be"):
        kind(**{name: given})


def test_the_api_key_comes_from_an_argument_or_the_environment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def sent(api_key: str | None = None) -> str | None:
        service = Broken(0, httpx2.ReadError, SHAPE)
        transport = httpx2.MockTransport(service)
        with isomatch.Client("http://a.test", api_key=api_key, transport=transport) as client:
            client.shape("1")
        return service.requests[0].headers.get("authorization")

    monkeypatch.delenv("ISOMATCH_API_KEY", raising=False)
    assert sent() is None
    assert sent("mine") == "Bearer mine"
    monkeypatch.setenv("ISOMATCH_API_KEY", "ours")
    assert sent() == "Bearer ours"
    assert sent("mine") == "Bearer mine"
    with pytest.raises(ValueError, match="API key"):
        isomatch.Client(api_key="a\nb")


def test_a_path_prefix_of_the_service_is_kept() -> None:
    service = Broken(0, httpx2.ReadError, SHAPE)
    transport = httpx2.MockTransport(service)
    with isomatch.Client("https://lab.test/isomatch/", transport=transport) as client:
        client.shape("1")
    assert str(service.requests[0].url) == "https://lab.test/isomatch/v1/shapes/1"


def test_the_address_comes_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ISOMATCH_URL", "http://192.0.2.7:1234")
    assert isomatch.Client().base_url == "http://192.0.2.7:1234"
    monkeypatch.delenv("ISOMATCH_URL")
    assert isomatch.Client().base_url == "http://127.0.0.1:8000"
    with pytest.raises(ValueError, match="must begin with http"):
        isomatch.Client("127.0.0.1:8000")
    with pytest.raises(ValueError, match="cannot be used"):
        isomatch.Client("http://localhost:abc")
