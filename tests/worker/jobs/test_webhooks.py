"""Webhooks from the end of a job to a real receiver: signed, retried, and given up."""

import contextlib
import hashlib
import hmac
import json
import socket
import ssl
import time
from collections.abc import Callable, Iterator
from datetime import timedelta
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest
import trustme

from broker.contracts import (
    DeliveryPayload,
    DeliveryState,
    Distortion,
    JobKind,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    MatchSummary,
    Problem,
    ProblemType,
    RequestOrigin,
    SpectrumPayload,
    Webhook,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS
from broker.store.webhooks import LEASE
from broker.webhooks import WebhookSettings, dispatch, retry_delay
from tests.receiver import Receiver, receiving
from worker.jobs.delivery import Outcome, post
from worker.jobs.runner import Runner

SECRET = "a secret of more than sixteen letters"
SETTINGS = WebhookSettings.model_validate(
    {"webhook_networks": "127.0.0.0/8", "webhook_pause": 0.01, "webhook_attempts": 3}
)
LOST = Problem.of(ProblemType.WORKER_LOST, "its process is gone")

Asked = Callable[..., str]


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    with receiving() as receiver:
        yield receiver


SUMMARY = MatchSummary(
    confidence=None,
    distortion=Distortion(first_order=None, second_order=0.5, linf=0.2),
    energy=0.5,
    gap=0.0,
    certified=True,
    dense=False,
    warnings=("looks odd",),
)


def asked(queue: JobQueue, url: str, secret: str | None = SECRET) -> str:
    """Queue a match with a webhook."""
    payload = MatchPayload(source="a", target="b", parameters=MatchParameters())
    order = RequestOrigin("the-request", "alice", webhook=Webhook(url=url, secret=secret))
    return queue.submit(payload, order).id


def ended(queue: JobQueue, url: str, secret: str | None = SECRET) -> str:
    """Have it succeed."""
    job = asked(queue, url, secret)
    assert queue.store.jobs.claim(job, "me")
    assert queue.store.jobs.succeed(job, "me", b"{}", summary=SUMMARY)
    return job


def here(receiver: Receiver, path: str = "/hook?key=1") -> str:
    return f"http://127.0.0.1:{receiver.port}{path}"


def told(queue: JobQueue, job: str) -> JobRecord:
    record = queue.store.jobs.get(job)
    assert record is not None
    return record


def pending(queue: JobQueue) -> int:
    """Number of webhooks that are not delivered yet."""
    return int(queue.store.client.zcard(DEFAULT_KEYS.webhooks))


def tries(queue: JobQueue) -> list[str]:
    """The queued delivery jobs."""
    records = queue.store.jobs.records(queue.rq.current.get_job_ids())
    return [job.id for job in records if job is not None and job.kind is JobKind.WEBHOOK]


def go_round(queue: JobQueue, settings: WebhookSettings = SETTINGS) -> int:
    """Queue due deliveries and run them as a worker would; return their number."""
    dispatch(queue, settings)
    queued = tries(queue)
    for job in queued:
        queue.store.client.lrem(queue.rq.current.key, 1, job)
        Runner(queue, "me", settings).run(job)
    return len(queued)


def until_settled(queue: JobQueue, job: str, settings: WebhookSettings = SETTINGS) -> int:
    """Deliver until the webhook is delivered or failed; return the number of attempts."""
    count = 0
    deadline = time.monotonic() + 240
    while pending(queue):
        assert time.monotonic() < deadline
        count += go_round(queue, settings)
        time.sleep(0.005)
    return count


def test_a_webhook_is_delivered_once_and_signed(queue: JobQueue, receiver: Receiver) -> None:
    job = ended(queue, here(receiver))
    assert until_settled(queue, job) == 1
    assert go_round(queue) == 0
    (request,) = receiver.received
    record = told(queue, job)
    assert request.path == "/hook?key=1"
    assert request.headers["host"] == f"127.0.0.1:{receiver.port}"
    assert request.headers["content-type"] == "application/json"
    assert request.headers["isomatch-delivery"] == job
    assert request.headers["isomatch-attempt"] == "1"
    assert request.headers["x-request-id"] == "the-request"
    event = json.loads(request.body)
    assert event["type"] == "job.ended"
    assert MatchSummary.model_validate(event["job"].pop("summary")) == SUMMARY
    assert record.started is not None
    assert record.ended is not None
    assert event["job"] == {
        "id": job,
        "kind": "match",
        "state": "succeeded",
        "created": record.created.isoformat().replace("+00:00", "Z"),
        "started": record.started.isoformat().replace("+00:00", "Z"),
        "ended": record.ended.isoformat().replace("+00:00", "Z"),
        "error": None,
        "path": f"/v1/jobs/{job}",
    }
    assert SECRET not in str(request)
    stated = dict(part.split("=") for part in request.headers["isomatch-signature"].split(","))
    signed = stated["t"].encode() + b"." + request.body
    assert stated["v1"] == hmac.new(SECRET.encode(), signed, hashlib.sha256).hexdigest()
    assert abs(int(stated["t"]) - request.when) < 100
    assert record.delivery is not None
    assert record.delivery.state is DeliveryState.DELIVERED
    assert (record.delivery.attempts, record.delivery.status) == (1, 204)
    assert record.delivery.error is None
    assert record.delivery.next_attempt is None


def test_without_a_secret_there_is_no_signature(queue: JobQueue, receiver: Receiver) -> None:
    until_settled(queue, ended(queue, here(receiver), secret=None))
    assert "isomatch-signature" not in receiver.received[0].headers


@pytest.mark.parametrize("way", ["failed", "cancelled", "cancelled while queued", "lost"])
def test_every_end_state_is_delivered(queue: JobQueue, receiver: Receiver, way: str) -> None:
    job = asked(queue, here(receiver))
    if way != "cancelled while queued":
        queue.store.jobs.claim(job, "me")
    assert go_round(queue) == 0
    match way:
        case "failed":
            queue.store.jobs.fail(job, "me", Problem.of(ProblemType.TIMED_OUT, "too slow"))
        case "lost":
            queue.store.jobs.lose(job, 0, LOST)
        case _:
            queue.store.jobs.cancel(job)
            queue.store.jobs.finish_cancelled(job, "me")
    until_settled(queue, job)
    (request,) = receiver.received
    event = json.loads(request.body)["job"]
    assert event["state"] == ("cancelled" if "cancelled" in way else "failed")
    assert (event["error"] is None) is ("cancelled" in way)


def test_only_ended_jobs_with_a_webhook_are_delivered(queue: JobQueue, receiver: Receiver) -> None:
    job = asked(queue, here(receiver))
    queue.store.jobs.claim(job, "me")
    queue.store.jobs.lose(job, 5, LOST)
    payload = MatchPayload(source="a", target="b", parameters=MatchParameters())
    other = queue.submit(payload).id
    queue.store.jobs.cancel(other)
    # What only serves the job that was asked for ends for itself.
    order = RequestOrigin(webhook=Webhook(url=here(receiver)))
    spectrum = SpectrumPayload(shape="a", eigenpairs=9, largest_component=False)
    queue.store.jobs.cancel(queue.submit(spectrum, order).id)
    assert pending(queue) == 0
    assert told(queue, job).state is JobState.QUEUED


@pytest.mark.parametrize("answer", [500, 404, 301, 307, 199, None])
def test_a_failed_delivery_is_retried(
    queue: JobQueue, receiver: Receiver, answer: int | None
) -> None:
    receiver.answers = [answer]
    job = ended(queue, here(receiver))
    assert go_round(queue) == 1
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert delivery.state is DeliveryState.PENDING
    assert delivery.error
    assert delivery.next_attempt is not None
    assert delivery.last_attempt is not None
    assert delivery.next_attempt - delivery.last_attempt == retry_delay(1, SETTINGS)
    assert until_settled(queue, job) == 1
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert (delivery.state, delivery.attempts) == (DeliveryState.DELIVERED, 2)
    # Wherever a redirect leads, nobody went there.
    assert [request.path for request in receiver.received] == ["/hook?key=1"] * 2
    assert [request.headers["isomatch-attempt"] for request in receiver.received] == ["1", "2"]
    assert len({request.headers["isomatch-delivery"] for request in receiver.received}) == 1


def test_delays_grow_and_attempts_are_limited(queue: JobQueue, receiver: Receiver) -> None:
    receiver.answers = [503] * 10
    job = ended(queue, here(receiver))
    assert until_settled(queue, job) == SETTINGS.webhook_attempts == len(receiver.received)
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert (delivery.state, delivery.attempts, delivery.status) == (DeliveryState.FAILED, 3, 503)
    assert "503" in (delivery.error or "")
    gaps = [b.when - a.when for a, b in zip(receiver.received, receiver.received[1:], strict=False)]
    for count, gap in enumerate(gaps, start=1):
        assert gap >= retry_delay(count, SETTINGS).total_seconds() * 0.99
    defaults = WebhookSettings()
    whole = sum(
        (retry_delay(n, defaults) for n in range(1, defaults.webhook_attempts)), timedelta()
    )
    assert timedelta(hours=1) < whole < timedelta(hours=3)


def test_a_receiver_that_is_gone_is_not_retried(queue: JobQueue, receiver: Receiver) -> None:
    receiver.answers = [410]
    job = ended(queue, here(receiver))
    assert until_settled(queue, job) == 1
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert delivery.state is DeliveryState.FAILED


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "localhost", "127.1", "2130706433", "[::1]", "[::ffff:127.0.0.1]"]
)
def test_private_addresses_are_refused(queue: JobQueue, receiver: Receiver, host: str) -> None:
    job = ended(queue, f"http://{host}:{receiver.port}/")
    assert until_settled(queue, job, WebhookSettings()) == 1
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert (delivery.state, delivery.status) == (DeliveryState.FAILED, None)
    assert "no public address" in (delivery.error or "")
    assert receiver.received == []


def resolving(monkeypatch: pytest.MonkeyPatch, *addresses: str) -> list[str]:
    """Have DNS answer these addresses in turn; return the list of resolved names."""
    names: list[str] = []
    left = list(addresses)

    def getaddrinfo(host: str, port: int, **_: object) -> list[Any]:
        names.append(host)
        return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (left.pop(0), port))]

    monkeypatch.setattr(socket, "getaddrinfo", getaddrinfo)
    return names


def test_a_name_is_resolved_once(
    queue: JobQueue, receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = ended(queue, f"http://hook.example:{receiver.port}/")
    settings = SETTINGS.model_copy(update={"webhook_timeout": 2.0})
    # A second question would have another answer, and a third none.
    allowed, elsewhere = "127.0.0.1", "203.0.113.1"
    create = socket.create_connection
    with monkeypatch.context() as patched:
        names = resolving(patched, allowed, elsewhere)

        def connect(address: tuple[str, int], *rest: Any) -> socket.socket:
            assert address == (allowed, receiver.port)
            patched.undo()
            return create(address, *rest)

        patched.setattr(socket, "create_connection", connect)
        assert until_settled(queue, job, settings) == 1
    assert names == ["hook.example"]
    assert receiver.received[0].headers["host"] == f"hook.example:{receiver.port}"


def test_a_name_of_many_addresses_takes_no_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    waited: list[float] = []

    def connect(address: tuple[str, int], seconds: float) -> socket.socket:
        waited.append(seconds)
        raise TimeoutError

    found = [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (f"127.0.0.{n}", 80)) for n in range(100)]
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: found)
    monkeypatch.setattr(socket, "create_connection", connect)
    assert post(Webhook(url="http://hook.example/"), b"", {}, SETTINGS).error is not None
    assert sum(waited) <= SETTINGS.webhook_timeout


def test_a_name_of_a_private_address_is_refused(
    queue: JobQueue, receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = ended(queue, f"http://hook.example:{receiver.port}/")
    with monkeypatch.context() as patched:
        resolving(patched, "127.0.0.1")
        patched.setattr(socket, "create_connection", None)
        dispatch(queue, SETTINGS)
        (attempt,) = tries(queue)
        # The store needs no names: its connection is there.
        Runner(queue, "me", WebhookSettings()).run(attempt)
    assert receiver.received == []
    assert "no public address" in (told(queue, job).delivery or LOST).model_dump_json()


def test_proxies_of_the_environment_are_not_used(
    queue: JobQueue, receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    with receiving() as proxy:
        for name in ("http_proxy", "HTTP_PROXY", "all_proxy"):
            monkeypatch.setenv(name, f"http://127.0.0.1:{proxy.port}")
        until_settled(queue, ended(queue, here(receiver)))
        assert proxy.received == []
    assert len(receiver.received) == 1


def test_a_slow_receiver_times_out(queue: JobQueue, receiver: Receiver) -> None:
    receiver.pause = 0.3
    settings = SETTINGS.model_copy(update={"webhook_timeout": 0.5, "webhook_attempts": 1})
    job = ended(queue, here(receiver))
    start = time.monotonic()
    until_settled(queue, job, settings)
    assert time.monotonic() - start > 0.4
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert delivery.error == "the receiver did not answer within 0.5 s"


@pytest.mark.parametrize("step", ["getaddrinfo", "create_connection"])
def test_dns_and_connection_count_towards_the_timeout(
    receiver: Receiver, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    done, function = Event(), getattr(socket, step)

    def wait(*arguments: Any, **options: Any) -> Any:
        done.wait()
        return function(*arguments, **options)

    monkeypatch.setattr(socket, step, wait)
    settings = SETTINGS.model_copy(update={"webhook_timeout": 0.2})
    try:
        outcome = post(Webhook(url=here(receiver)), b"", {}, settings)
    finally:
        done.set()
    assert outcome == Outcome(error="the receiver did not answer within 0.2 s")


def test_a_receiver_that_refuses_connections(queue: JobQueue) -> None:
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        port = closed.getsockname()[1]
    job = ended(queue, f"http://127.0.0.1:{port}/")
    assert until_settled(queue, job) == SETTINGS.webhook_attempts
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert "refused" in (delivery.error or "")


@pytest.mark.parametrize("answer", [b"\x1b[31mgarbage\r\n\r\n", b"HTTP/1.1 200 " + b"x" * 70_000])
def test_a_receiver_that_does_not_speak_http(queue: JobQueue, answer: bytes) -> None:
    """Its bytes are not shown: they may be terminal escapes."""
    settings = SETTINGS.model_copy(update={"webhook_attempts": 1})
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()

        def speak() -> None:
            connection, _ = listening.accept()
            with connection, contextlib.suppress(OSError):
                connection.recv(65536)
                connection.sendall(answer)
                connection.shutdown(socket.SHUT_WR)
                while connection.recv(65536):
                    pass

        thread = Thread(target=speak)
        thread.start()
        job = ended(queue, f"http://127.0.0.1:{listening.getsockname()[1]}/")
        until_settled(queue, job, settings)
        thread.join()
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert (delivery.error or "").startswith("the receiver's answer is no HTTP (")


def test_certificates_must_match_the_name(
    queue: JobQueue, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    authority = trustme.CA()
    authority.cert_pem.write_to_path(str(tmp_path / "ca.pem"))
    monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "ca.pem"))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    authority.issue_cert("localhost").configure_cert(context)
    once = SETTINGS.model_copy(update={"webhook_attempts": 1})
    with receiving(context) as receiver:
        right = ended(queue, f"https://localhost:{receiver.port}/")
        until_settled(queue, right, once)
        # The same receiver by its address, for which it has no certificate.
        wrong = ended(queue, f"https://127.0.0.1:{receiver.port}/")
        until_settled(queue, wrong, once)
    assert len(receiver.received) == 1
    deliveries = [told(queue, job).delivery for job in (right, wrong)]
    assert [delivery and delivery.state.value for delivery in deliveries] == ["delivered", "failed"]
    assert "certificate" in (deliveries[1] or LOST).model_dump_json()


def test_a_delivery_in_progress_is_not_queued_again(queue: JobQueue, receiver: Receiver) -> None:
    job = ended(queue, here(receiver))
    for _ in range(3):
        dispatch(queue, SETTINGS)
    (first,) = tries(queue)
    # Long after, it still waits in the queue.
    queue.store.client.zadd(DEFAULT_KEYS.webhooks, {job: 1.0})
    dispatch(queue, SETTINGS)
    assert tries(queue) == [first]


def test_webhooks_of_a_tenant_are_delivered_one_by_one(queue: JobQueue, receiver: Receiver) -> None:
    """Receivers that do not answer would hold all workers."""
    acme = queue.of("acme")
    jobs = [ended(queue, here(receiver)) for _ in range(3)]
    for place, job in enumerate(jobs, start=1):
        queue.store.client.zadd(DEFAULT_KEYS.webhooks, {job: place})
    other = ended(acme, here(receiver))
    dispatch(queue, SETTINGS)
    dispatch(queue, SETTINGS)
    delivered = []
    for _ in jobs:
        # The others' turn does not wait for the next dispatch.
        (attempt,) = tries(queue)
        queue.store.client.lrem(queue.rq.current.key, 1, attempt)
        Runner(queue, "me", SETTINGS).run(attempt)
        delivered.append(receiver.received[-1].headers["isomatch-delivery"])
    assert delivered == jobs
    (attempt,) = tries(acme)
    Runner(acme, "me", SETTINGS).run(attempt)
    assert receiver.received[-1].headers["isomatch-delivery"] == other


def test_a_lost_delivery_does_not_hold_back_others(queue: JobQueue, receiver: Receiver) -> None:
    lost, other = ended(queue, here(receiver)), ended(queue, here(receiver))
    queue.store.client.zadd(DEFAULT_KEYS.webhooks, {lost: 1.0, other: 2.0})
    dispatch(queue, SETTINGS)
    (attempt,) = tries(queue)
    queue.store.client.lrem(queue.rq.current.key, 1, attempt)
    queue.store.jobs.lose(attempt, 0, LOST)
    assert go_round(queue) == 1
    assert receiver.received[0].headers["isomatch-delivery"] == other
    # It is due again after its lease.
    assert queue.store.webhooks.due(10) == []
    due = queue.store.client.zscore(DEFAULT_KEYS.webhooks, lost)
    assert due is not None
    assert time.time() < due <= time.time() + LEASE


def test_a_webhook_stays_due_if_another_is_queued_at_the_same_time(
    queue: JobQueue, receiver: Receiver
) -> None:
    first, second = ended(queue, here(receiver)), ended(queue, here(receiver))
    queue.store.client.zadd(DEFAULT_KEYS.webhooks, {first: 1.0, second: 2.0})

    def choose() -> tuple[DeliveryPayload, RequestOrigin]:
        dispatch(queue, SETTINGS)  # another process, meanwhile
        return DeliveryPayload(job=second, attempt=1), RequestOrigin()

    queue.submit_delivery(choose)
    (attempt,) = tries(queue)
    payload = told(queue, attempt).payload
    assert isinstance(payload, DeliveryPayload)
    assert payload.job == first
    assert queue.store.webhooks.due(10) == [second]
    assert queue.store.webhooks.attempts(second) == 0


def test_the_last_attempt_is_not_given_up_while_it_is_in_flight(
    queue: JobQueue, receiver: Receiver
) -> None:
    once = SETTINGS.model_copy(update={"webhook_attempts": 1})
    job = ended(queue, here(receiver))
    dispatch(queue, once)
    queue.store.client.zadd(DEFAULT_KEYS.webhooks, {job: 1.0})
    dispatch(queue, once)
    assert told(queue, job).delivery is None
    (attempt,) = tries(queue)
    Runner(queue, "me", once).run(attempt)
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert delivery.state is DeliveryState.DELIVERED


def test_a_lost_delivery_is_repeated_a_limited_number_of_times(
    queue: JobQueue, receiver: Receiver
) -> None:
    job = ended(queue, here(receiver))
    for count in range(1, SETTINGS.webhook_attempts + 1):
        queue.store.client.zadd(DEFAULT_KEYS.webhooks, {job: 1.0})
        dispatch(queue, SETTINGS)
        (attempt,) = tries(queue)
        payload = told(queue, attempt).payload
        assert isinstance(payload, DeliveryPayload)
        assert payload.attempt == count
        queue.store.client.lrem(queue.rq.current.key, 1, attempt)
        queue.store.jobs.lose(attempt, 0, LOST)
    queue.store.client.zadd(DEFAULT_KEYS.webhooks, {job: 1.0})
    assert go_round(queue) == 0
    delivery = told(queue, job).delivery
    assert delivery is not None
    assert (delivery.state, delivery.attempts) == (DeliveryState.FAILED, 3)
    assert pending(queue) == 0


def test_an_expired_job_is_not_delivered(queue: JobQueue, receiver: Receiver) -> None:
    early, late = ended(queue, here(receiver)), ended(queue, here(receiver))
    queue.store.client.delete(DEFAULT_KEYS.job(early))
    dispatch(queue, SETTINGS)
    queue.store.client.delete(DEFAULT_KEYS.job(late))
    (attempt,) = tries(queue)
    Runner(queue, "me", SETTINGS).run(attempt)
    assert pending(queue) == 0
    assert receiver.received == []
    assert queue.store.client.exists(DEFAULT_KEYS.job(late)) == 0


def test_a_damaged_record_does_not_hold_back_others(queue: JobQueue, receiver: Receiver) -> None:
    damaged, other = ended(queue, here(receiver)), ended(queue, here(receiver))
    queue.store.client.hset(DEFAULT_KEYS.job(damaged), "record", "{")
    assert go_round(queue) == 1
    assert told(queue, other).delivery is not None
    assert len(receiver.received) == 1
    # It may be that of a newer version, and stays.
    assert pending(queue) == 1
