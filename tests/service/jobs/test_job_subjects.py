"""Shapes and prototypes of jobs, in the jobs and as filters of the listing."""

from collections.abc import Iterator
from typing import Any, get_args

import httpx2
import pytest

from broker.contracts import (
    JobKind,
    JobState,
    PrototypeParameters,
    PrototypePayload,
    PrototypeValidationPayload,
    subject_of,
)
from broker.store import DEFAULT_KEYS, listings
from service.jobs.endpoints import ListedKind
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, idle_api, problem, put_shapes


@pytest.fixture(scope="module")
def api(server: EmbeddedServer) -> Iterator[Api]:
    with idle_api(server) as api:
        yield api


@pytest.fixture
def http(api: Api) -> Iterator[httpx2.Client]:
    api.store.client.flushdb()
    put_shapes(api)
    with httpx2.Client(base_url=api.url, timeout=120.0) as http:
        yield http


A, B = "a" * 32, "b" * 32


def ask(http: httpx2.Client, path: str, **body: Any) -> Json:
    answer = http.post(f"/v1/{path}", json=body)
    assert answer.status_code == 202, answer.text
    job: Json = answer.json()
    return job


def match(http: httpx2.Client, source: str = A, target: str = B) -> Json:
    return ask(http, "matches", source=source, target=target, metric="geodesic")


def learn(http: httpx2.Client, name: str = "letters") -> Json:
    given = [[0, 1, 2], [0, 1, 2]]
    return ask(http, "prototypes", shapes=[B, A], correspondences=given, name=name)


def ids(http: httpx2.Client, **query: Any) -> list[str]:
    found: list[str] = []
    cursor = None
    while True:
        page = http.get("/v1/jobs", params={**query, **({"cursor": cursor} if cursor else {})})
        assert page.status_code == 200, page.text
        found += [job["id"] for job in page.json()["items"]]
        cursor = page.json()["next_cursor"]
        if cursor is None:
            return found


def test_jobs_say_the_names_and_parameters_of_the_request(http: httpx2.Client) -> None:
    asked = {"source": A, "target": B, "target_name": "b.off", "metric": "geodesic", "dense": True}
    job = ask(http, "matches", **asked, points=32, landmarks=[[0, 0]])
    assert job["names"] == [None, "b.off"]
    # Neither what is the default, nor lists.
    assert job["parameters"] == {"metric": "geodesic", "dense": True}
    assert job["links"]["match"] is None
    counted = ask(http, "matches", source=A, target=B, points=40)["parameters"]["points"]
    assert (counted, type(counted)) == (40, int)
    # What a kind of job sets itself was not requested.
    bodies: dict[str, Json] = {
        "registrations": {"template": A, "shapes": [B]},
        "consistent-maps": {"shapes": [A, B]},
    }
    for path, body in bodies.items():
        assert ask(http, path, **body)["parameters"] == {}
        job = ask(http, path, **body, largest_component=True)
        assert job["parameters"] == {"largest_component": True}


def test_jobs_name_what_they_are_of(http: httpx2.Client) -> None:
    job = match(http)
    assert (job["source"], job["target"], job["shapes"]) == (A, B, [A, B])
    assert (job["shape_count"], job["prototype"], job["name"]) == (2, None, None)
    assert (job["names"], job["parameters"]) == (
        [None, None],
        {"metric": "geodesic"},
    )
    same = match(http, A, A)
    assert (same["shapes"], same["shape_count"]) == ([A], 1)
    learned = learn(http)
    assert (learned["source"], learned["target"]) == (None, None)
    assert (learned["shapes"], learned["name"]) == ([B, A], "letters")
    listed = http.get("/v1/jobs").json()["items"]
    assert [one["shapes"] for one in listed] == [[B, A], [A], [A, B]]
    assert http.get(job["links"]["self"]).json()["target"] == B


def test_jobs_are_of_all_their_shapes_and_archives_of_their_prototype() -> None:
    shapes = tuple(f"{number:032x}" for number in range(50))
    payload = PrototypePayload(
        shapes=shapes,
        reference=0,
        correspondences=None,
        name="many",
        parameters=PrototypeParameters(),
    )
    assert subject_of(payload).shapes == shapes
    archive = PrototypeValidationPayload(prototype="p-1", name="one.npz")
    assert subject_of(archive).prototype == "p-1"
    assert subject_of(archive).named == ("p-1",)


def test_collections_are_told_in_short(http: httpx2.Client, api: Api) -> None:
    shapes = [f"{number:032x}" for number in range(30)]
    record = api.store.shapes.get(A)
    assert record is not None
    for shape in shapes:
        changed = record.model_copy(update={"id": shape, "vertices": 9})
        api.store.client.set(DEFAULT_KEYS.shape(shape), changed.model_dump_json())
    job = ask(http, "dissimilarities", shapes=shapes)
    assert job["shapes"] == shapes[:20]
    assert job["shape_count"] == 30
    # It is found by those that are not named, too.
    assert ids(http, shape=shapes[-1]) == [job["id"]]


def test_listings_are_filtered_by_every_kind_that_users_request() -> None:
    assert set(get_args(ListedKind)) == {kind.value for kind in JobKind if kind.has_result}


def test_listings_are_filtered(http: httpx2.Client, api: Api) -> None:
    first, own, learned = match(http), match(http, A, A), learn(http)
    assert ids(http, shape=A) == [learned["id"], own["id"], first["id"]]
    assert ids(http, shape=B) == [learned["id"], first["id"]]
    assert ids(http, shape="c" * 32) == []
    assert ids(http, kind="match") == [own["id"], first["id"]]
    assert ids(http, kind="prototype", shape=A) == [learned["id"]]
    assert ids(http, kind="dissimilarities") == []
    http.delete(first["links"]["self"])
    assert ids(http, state="cancelled", shape=A) == [first["id"]]
    assert ids(http, state="queued", shape=B, kind="match") == []
    for query in ({"limit": 1}, {"limit": 1, "shape": A}, {"limit": 2, "kind": "match"}):
        every = ids(http, **{key: value for key, value in query.items() if key != "limit"})
        assert ids(http, **query) == every
    for wrong in ({"kind": "turn"}, {"kind": "picture"}, {"shape": "a b"}, {"state": "gone"}):
        (field,) = wrong
        document = problem(http.get("/v1/jobs", params=wrong), 422, "invalid-request")
        assert document["errors"][0]["field"].startswith(f"query.{field}")
        assert "JobKind" not in document["errors"][0]["message"]


def test_filtered_listing_pages_through_rare_jobs(
    http: httpx2.Client, api: Api, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(listings, "MOST_SKIPPED", 3)
    learned = learn(http)
    for _ in range(10):
        match(http)
    page = http.get("/v1/jobs", params={"kind": "prototype", "limit": 1}).json()
    assert page["items"] == []
    assert page["next_cursor"] is not None
    assert ids(http, kind="prototype", limit=1) == [learned["id"]]
    assert len(ids(http, kind="match", limit=3)) == 10


def test_listing_by_shape_is_forgotten_with_its_jobs(http: httpx2.Client, api: Api) -> None:
    job = match(http)
    key = DEFAULT_KEYS.jobs_of(A)
    settings = api.store.jobs.settings
    left = settings.job_ttl + settings.trace_ttl
    assert left - 60 < api.store.client.ttl(key) <= left
    api.store.client.zadd(key, {"long-ago": 1.0})
    other = match(http)
    assert api.store.client.zcard(key) == 2
    api.store.client.delete(DEFAULT_KEYS.job(job["id"]))
    assert ids(http, shape=A) == [other["id"]]
    assert api.store.client.zcard(key) == 1
    (found,) = api.store.jobs.page(9, None, [JobState.QUEUED], of=A).items
    assert found.id == other["id"]
    assert api.store.jobs.page(1, None, of=A, kind=JobKind.PROTOTYPE).items == ()
