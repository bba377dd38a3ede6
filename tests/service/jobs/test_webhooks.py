"""Webhooks over HTTP: where they may go, what is shown of them, and that they are sent."""

import json
from collections.abc import Iterator

import httpx2
import pytest

from broker.contracts import JobKind
from broker.queue import JobQueue, QueueSettings
from broker.webhooks import WebhookSettings
from service.standalone import EmbeddedServer
from tests.receiver import receiving
from tests.service.conftest import Api, Json, idle_api, problem, put_shapes
from tests.waiting import until
from worker.jobs.runner import Runner

SECRET = "sixteen letters and more"
NETWORKS = {"webhook_networks": "127.0.0.0/8"}


@pytest.fixture(scope="module")
def api(server: EmbeddedServer) -> Iterator[Api]:
    with idle_api(server, **NETWORKS) as api:
        yield api


@pytest.fixture
def http(api: Api) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=api.url, timeout=120.0) as http:
        yield http


def ask(http: httpx2.Client, api: Api, webhook: object) -> httpx2.Response:
    source, target = put_shapes(api)
    body = {
        "source": source,
        "target": target,
        "metric": "geodesic",
        "descriptor": "none",
        "orientation": False,
    }
    return http.post("/v1/matches", json=body | {"webhook": webhook})


def test_the_job_shows_how_its_webhook_is(http: httpx2.Client, api: Api) -> None:
    with receiving() as receiver:
        url = f"http://127.0.0.1:{receiver.port}/hook"
        answer = ask(http, api, {"url": f"{url}?token=x", "secret": SECRET})
        assert answer.status_code == 202, answer.text
        job: Json = answer.json()
        assert job["webhook"]["url"] == url
        assert (job["webhook"]["state"], job["webhook"]["attempts"]) == ("pending", 0)
        assert SECRET not in answer.text
        assert "token" not in answer.text
        http.delete(job["links"]["self"])
        # The API sees that it is due; a worker would take the try from the queue.
        attempt = queued_try(api)
        Runner(
            JobQueue(api.store, QueueSettings()), "me", WebhookSettings.model_validate(NETWORKS)
        ).run(attempt)
        (request,) = receiver.received
    told = json.loads(request.body)["job"]
    assert (told["id"], told["kind"], told["state"]) == (job["id"], job["kind"], "cancelled")
    assert told["summary"] is None
    assert request.path == "/hook?token=x"
    shown = http.get(job["links"]["self"]).json()["webhook"]
    assert (shown["state"], shown["attempts"], shown["status"]) == ("delivered", 1, 204)
    assert [item["id"] for item in http.get("/v1/jobs").json()["items"]] == [job["id"]]
    assert "isomatch_webhooks_pending 0.0" in http.get("/metrics").text


def queued_try(api: Api) -> str:
    def found() -> str | None:
        for job_id in JobQueue(api.store, QueueSettings()).rq.current.get_job_ids():
            record = api.store.jobs.get(job_id)
            if record is not None and record.kind is JobKind.WEBHOOK:
                return job_id
        return None

    return until(found, pause=0.05)


def test_no_webhook_is_delivered_unless_requested(http: httpx2.Client, api: Api) -> None:
    assert ask(http, api, None).json()["webhook"] is None


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("", "at least 1 character"),
        ("example.org", "http:// or https://"),
        ("ftp://example.org/", "http:// or https://"),
        ("http://", "http:// or https://"),
        ("https:///path", "http:// or https://"),
        ("file:///etc/passwd", "http:// or https://"),
        ("http://example.org:0/", "ort"),
        ("http://example.org:65536/", "ort"),
        ("http://example.org:x/", "ort"),
        ("http://me:word@example.org/", "user name"),
        ("http://me@example.org/", "user name"),
        ("http://[::1/", "IPv6"),
        ("http://exämple.org/", "ASCII"),
        ("http://example.org/\r\nHost: x", "ASCII"),
        ("http://example.org/a b", "ASCII"),
        ("http://" + "a" * 2000, "at most 2000"),
        ("http://10.0.0.1/", "not a public address"),
        ("http://169.254.169.254/latest/meta-data/", "not a public address"),
        ("http://[::1]/", "not a public address"),
        ("http://[::ffff:10.0.0.1]/", "not a public address"),
        ("http://0xa000001/", "not a public address"),
        (f"https://{'a' * 64}.org/", "1 to 63 characters"),
        ("https://example..org/", "1 to 63 characters"),
    ],
)
def test_addresses_that_webhooks_may_not_go_to(
    http: httpx2.Client, api: Api, url: str, said: str
) -> None:
    document = problem(ask(http, api, {"url": url}), 422, "invalid-request")
    (error,) = document["errors"]
    assert error["field"] == "body.webhook.url"
    assert said in error["message"]


@pytest.mark.parametrize(
    ("webhook", "field"),
    [
        ({"url": "http://example.org/", "secret": "short"}, "body.webhook.secret"),
        ({"url": "http://example.org/", "secret": 16 * 17}, "body.webhook.secret"),
        ({"url": "http://example.org/", "secert": SECRET}, "body.webhook.secert"),
        ({}, "body.webhook.url"),
        ({"url": None}, "body.webhook.url"),
        ("http://example.org/", "body.webhook"),
    ],
)
def test_invalid_webhooks_are_refused(
    http: httpx2.Client, api: Api, webhook: object, field: str
) -> None:
    document = problem(ask(http, api, webhook), 422, "invalid-request")
    assert [error["field"] for error in document["errors"]] == [field]


def test_this_machine_is_not_told_unless_it_is_allowed(server: EmbeddedServer) -> None:
    with idle_api(server) as api, httpx2.Client(base_url=api.url, timeout=60.0) as http:
        for host in ("127.0.0.1", "localhost", "127.1"):
            problem(ask(http, api, {"url": f"http://{host}/"}), 422, "invalid-request")
        assert ask(http, api, {"url": "https://example.org/"}).status_code == 202
