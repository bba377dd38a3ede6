"""Requests that make jobs: known again when they are repeated, and not too many at a time."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import httpx2
import pytest

from broker.contracts import MatchParameters, MatchPayload, Problem, ProblemType, shape_id
from broker.queue import new_job
from broker.store import DEFAULT_KEYS
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, idle_api, problem, put_shapes
from tests.worker.figures import blob_file

LIMIT = 3
KEY = "Idempotency-Key"


@pytest.fixture(scope="module")
def api(server: EmbeddedServer) -> Iterator[Api]:
    with idle_api(server, max_queued_jobs=LIMIT, idempotency_ttl=100) as api:
        yield api


@pytest.fixture
def http(api: Api) -> Iterator[httpx2.Client]:
    api.store.client.flushdb()
    put_shapes(api)
    with httpx2.Client(base_url=api.url, timeout=120.0) as http:
        yield http


BODY: Json = {
    "source": "a" * 32,
    "target": "b" * 32,
    "metric": "geodesic",
    "descriptor": "none",
    "orientation": False,
}


def ask(http: httpx2.Client, key: str | None = None, **changes: object) -> httpx2.Response:
    headers = {} if key is None else {KEY: key}
    return http.post("/v1/matches", json={**BODY, **changes}, headers=headers)


def listed(http: httpx2.Client) -> list[str]:
    return [job["id"] for job in http.get("/v1/jobs").json()["items"]]


def test_a_repeated_request_makes_no_second_job(http: httpx2.Client, api: Api) -> None:
    first, again, other, none = (ask(http, key) for key in ("a", "a", "b", None))
    assert [answer.status_code for answer in (first, again, other)] == [202] * 3
    assert first.json() == again.json()
    assert first.headers["location"] == again.headers["location"]
    replayed = [
        answer.headers.get("idempotency-replayed") for answer in (first, again, other, none)
    ]
    assert replayed == [None, "true", None, None]
    assert len({answer.json()["id"] for answer in (first, other, none)}) == 3
    assert len(listed(http)) == 3
    for key in api.store.client.scan_iter(DEFAULT_KEYS.idempotency_record("*")):
        assert 0 < api.store.client.ttl(key) <= 100


def test_the_repetition_answers_with_the_job_as_it_is(http: httpx2.Client, api: Api) -> None:
    job = ask(http, "a").json()
    http.delete(job["links"]["self"])
    api.store.shapes.delete(BODY["source"])
    assert ask(http, "a").json()["state"] == "cancelled"
    problem(ask(http, "b"), 422, "unknown-shape")


def test_a_key_with_another_request_is_refused(http: httpx2.Client) -> None:
    ask(http, "a")
    problem(ask(http, "a", points=16), 409, "idempotency-key-reused")
    assert len(listed(http)) == 1


def test_a_refused_request_does_not_use_its_key(http: httpx2.Client) -> None:
    problem(ask(http, "a", points=1), 422, "invalid-request")
    problem(ask(http, "a", source="nobody"), 422, "unknown-shape")
    assert ask(http, "a").status_code == 202


def test_repetitions_at_the_same_time_make_one_job(http: httpx2.Client) -> None:
    with ThreadPoolExecutor(16) as threads:
        answers = list(threads.map(lambda _: ask(http, "at once"), range(32)))
    assert {answer.status_code for answer in answers} == {202}
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert len(listed(http)) == 1
    replayed = [answer.headers.get("idempotency-replayed") for answer in answers]
    assert (replayed.count(None), replayed.count("true")) == (1, 31)
    # Nobody who came late holds a place in the queue.
    assert [ask(http).status_code for _ in range(LIMIT)] == [202] * (LIMIT - 1) + [429]


def test_a_key_outlives_neither_its_time_nor_its_job(http: httpx2.Client, api: Api) -> None:
    first = ask(http, "a").json()["id"]
    api.store.client.delete(DEFAULT_KEYS.job(first))
    second = ask(http, "a").json()
    assert second["state"] == "queued"
    assert ask(http, "a").json() == second
    (key,) = api.store.client.scan_iter(DEFAULT_KEYS.idempotency_record("*"))
    api.store.client.delete(key)
    assert ask(http, "a", points=16).json()["id"] != second["id"]


def test_a_key_that_outlives_a_batch_makes_a_new_one(http: httpx2.Client, api: Api) -> None:
    body = {"source": BODY["source"], "targets": [BODY["target"]] * 3}

    def batch() -> Json:
        return dict(http.post("/v1/batches", json=body, headers={KEY: "a"}).json())

    first = batch()["id"]
    # All of it has ended and expired.
    api.store.client.delete(*map(DEFAULT_KEYS.job, (first, f"{first}-1", f"{first}-2")))
    api.store.client.set(DEFAULT_KEYS.job_tombstone(f"{first}-2"), "", ex=100)
    second = batch()
    assert second["id"] != first
    assert batch()["id"] == second["id"]
    matches = http.get(f"/v1/batches/{second['id']}").json()["matches"]
    assert [one["state"] for one in matches] == ["queued"] * 3


def test_a_key_whose_request_was_one_too_many(http: httpx2.Client, api: Api) -> None:
    first, *_ = (ask(http).json()["id"] for _ in range(LIMIT))
    problem(ask(http, "a"), 429, "too-many-jobs")
    http.delete(f"/v1/jobs/{first}")
    job = ask(http, "a")
    assert job.status_code == 202
    # The job leaves its place only when it is begun, however often it is asked for.
    assert ask(http, "a").json() == job.json()
    assert ask(http).status_code == 429
    api.store.jobs.claim(job.json()["id"], "me")
    assert ask(http, "a").json()["state"] == "running"
    assert [ask(http).status_code for _ in range(2)] == [202, 429]


@pytest.mark.parametrize("key", ["", "a" * 256, "a\tb", b"\xe4"])
def test_invalid_idempotency_keys_are_refused(http: httpx2.Client, key: str | bytes) -> None:
    headers = {KEY.encode(): key if isinstance(key, bytes) else key.encode()}
    document = problem(http.post("/v1/matches", json=BODY, headers=headers), 422, "invalid-request")
    assert document["errors"][0]["field"] == f"header.{KEY}"


def test_uploads_take_a_key_as_well(http: httpx2.Client, api: Api) -> None:
    def upload(data: bytes, key: str) -> httpx2.Response:
        files = {"file": ("a.off", data)}
        return http.post("/v1/shapes", files=files, headers={KEY: key})

    # Nobody validates it here, and a known one need not be.
    data = blob_file(1)
    api.store.client.copy(DEFAULT_KEYS.shape(BODY["source"]), DEFAULT_KEYS.shape(shape_id(data)))
    assert [upload(data, "a").status_code for _ in range(2)] == [200, 200]
    problem(upload(data + b"\n", "a"), 409, "idempotency-key-reused")
    problem(ask(http, "a"), 409, "idempotency-key-reused")


def test_so_many_jobs_and_no_more(http: httpx2.Client, api: Api) -> None:
    jobs = [ask(http).json() for _ in range(LIMIT)]
    refused = ask(http)
    problem(refused, 429, "too-many-jobs")
    assert int(refused.headers["retry-after"]) > 0
    # What has begun, or is cancelled, does not count; what is begun again does.
    assert api.store.jobs.claim(jobs[0]["id"], "me")
    http.delete(jobs[1]["links"]["self"])
    assert [ask(http).status_code for _ in range(3)] == [202, 202, 429]
    api.store.jobs.lose(jobs[0]["id"], 1, Problem.of(ProblemType.WORKER_LOST, "lost"))
    http.delete(jobs[2]["links"]["self"])
    assert ask(http).status_code == 429
    assert len(listed(http)) == LIMIT + 2


def test_no_more_than_that_at_the_same_time_either(http: httpx2.Client) -> None:
    with ThreadPoolExecutor(16) as threads:
        answers = list(threads.map(lambda _: ask(http).status_code, range(16)))
    assert sorted(answers) == [202] * LIMIT + [429] * (16 - LIMIT)


def test_places_of_those_who_died_before_they_used_them(http: httpx2.Client, api: Api) -> None:
    payload = MatchPayload(source="a", target="b", parameters=MatchParameters())
    for _ in range(LIMIT):
        job = new_job(payload)
        api.store.admission.admit(job, LIMIT)
    assert ask(http).status_code == 429
    api.store.client.zincrby(DEFAULT_KEYS.queued_by(None), -100, job.id)
    assert [ask(http).status_code for _ in range(2)] == [202, 429]
