"""Two tenants: what one has does not exist for the other, on any route, in any body."""

import json
from collections.abc import Callable, Iterator
from dataclasses import astuple, dataclass
from pathlib import Path

import httpx2
import pytest

from service.settings import Settings
from tests.service.conftest import Api, Json, problem, running_api
from tests.waiting import until
from tests.worker.figures import blob, blob_file

ROOT = Path(__file__).resolve().parents[2]
OTHER_DIGITS = str.maketrans("0123456789abcdef", "fedcba9876543210")
MATCH = {"points": 8, "coarse_points": 8, "eigenpairs": 30, "dense": True}
ATTRIBUTES = b"vertex,height\n0,1.5\n1,2.5\n"


@dataclass(frozen=True)
class Ids:
    """Ids of everything that one tenant has."""

    shape: str
    other: str
    match: str
    prototype: str
    attributes: str
    comparison: str
    batch: str

    def absent(self) -> "Ids":
        """Ids of the same form, of nothing."""
        return Ids(*(one[:-20] + one[-20:].translate(OTHER_DIGITS) for one in astuple(self)))


Asks = Callable[[Ids], list[Json]]


def of_job(each: Callable[[str], Json]) -> Asks:
    """The same request of jobs of three kinds."""
    return lambda ids: [each(job) for job in (ids.match, ids.comparison, ids.batch)]


REQUESTS: dict[str, Asks] = {
    "GET /v1/shapes/{shape}": lambda ids: [{"shape": ids.shape}],
    "DELETE /v1/shapes/{shape}": lambda ids: [{"shape": ids.shape}],
    "GET /v1/shapes/{shape}/mesh": lambda ids: [{"shape": ids.shape}],
    "GET /v1/shapes/{shape}/geometry": lambda ids: [{"shape": ids.shape}],
    "POST /v1/matches": lambda ids: [
        {"json": {"source": ids.shape, "target": ids.other}},
        {"json": {"source": ids.prototype, "target": ids.shape}},
    ],
    "POST /v1/batches": lambda ids: [{"json": {"source": ids.shape, "targets": [ids.other]}}],
    "GET /v1/batches/{job_id}": lambda ids: [{"job_id": ids.batch}, {"job_id": ids.match}],
    "GET /v1/attributes/{attributes}": lambda ids: [{"attributes": ids.attributes}],
    "DELETE /v1/attributes/{attributes}": lambda ids: [{"attributes": ids.attributes}],
    "POST /v1/transfers": lambda ids: [
        {"json": {"match": ids.match, "what": "colors"}},
        {"json": {"match": ids.match, "what": "scalars", "attributes": ids.attributes}},
        {"json": {"match": ids.batch, "what": "colors"}},
    ],
    "GET /v1/transfers/{job_id}/source.npz": of_job(lambda job: {"job_id": job}),
    "POST /v1/dissimilarities": lambda ids: [{"json": {"shapes": [ids.shape, ids.other]}}],
    "GET /v1/dissimilarities/{job_id}": lambda ids: [{"job_id": ids.comparison}],
    "POST /v1/registrations": lambda ids: [
        {"json": {"template": ids.shape, "shapes": [ids.other]}}
    ],
    "POST /v1/consistent-maps": lambda ids: [{"json": {"shapes": [ids.shape, ids.other]}}],
    "GET /v1/prototypes/{prototype}/archive": lambda ids: [{"prototype": ids.prototype}],
    "GET /v1/prototypes/{prototype}/geometry": lambda ids: [{"prototype": ids.prototype}],
    "POST /v1/prototypes": lambda ids: [
        {"json": {"name": "mine", "shapes": [ids.shape, ids.other]}}
    ],
    "GET /v1/prototypes/{prototype}": lambda ids: [{"prototype": ids.prototype}],
    "DELETE /v1/prototypes/{prototype}": lambda ids: [{"prototype": ids.prototype}],
    "GET /v1/jobs/{job_id}": of_job(lambda job: {"job_id": job}),
    "DELETE /v1/jobs/{job_id}": of_job(lambda job: {"job_id": job}),
    "GET /v1/jobs/{job_id}/events": of_job(lambda job: {"job_id": job}),
    "GET /v1/jobs/{job_id}/result": of_job(lambda job: {"job_id": job}),
    "DELETE /v1/jobs/{job_id}/result": of_job(lambda job: {"job_id": job}),
    "GET /v1/jobs/{job_id}/map.csv": of_job(lambda job: {"job_id": job}),
    "GET /v1/jobs/{job_id}/result.npz": of_job(lambda job: {"job_id": job}),
    "GET /v1/jobs/{job_id}/result.png": of_job(lambda job: {"job_id": job}),
    "GET /v1/jobs/{job_id}/result.{format}": of_job(lambda job: {"job_id": job, "format": "ply"}),
    "GET /v1/jobs/{job_id}/registered.{format}": of_job(
        lambda job: {"job_id": job, "format": "ply"}
    ),
}
"""Requests of each route that name what another tenant has: path parameters, or a body."""

LISTINGS = ("/v1/shapes", "/v1/prototypes", "/v1/jobs")
UPLOADS = ("/v1/shapes", "/v1/attributes", "/v1/prototype-archives")
NOTHING_OF_ANYONE = {"GET /v1/structures"}


@pytest.fixture(scope="module")
def shared(api: Api, settings: Settings) -> Iterator[Api]:
    """An API with keys, over the store and before the workers of the session."""
    keys = "blue/ann:anns-key, red/bob:bobs-key, red/rose:roses-key, dora:doras-key"
    loaded = settings.model_dump() | {"api_keys": keys}
    with running_api(Settings(**loaded)) as running:
        yield running


def client(shared: Api, name: str) -> httpx2.Client:
    headers = {"Authorization": f"Bearer {name}s-key"}
    return httpx2.Client(base_url=shared.url, headers=headers, timeout=300.0)


@pytest.fixture(scope="module")
def ann(shared: Api) -> Iterator[httpx2.Client]:
    with client(shared, "ann") as http:
        yield http


@pytest.fixture(scope="module")
def bob(shared: Api) -> Iterator[httpx2.Client]:
    with client(shared, "bob") as http:
        yield http


def upload(http: httpx2.Client, path: str, data: bytes, name: str) -> httpx2.Response:
    answer = http.post(path, files={"file": (name, data)})
    assert answer.status_code in (200, 201), answer.text
    return answer


def begun(http: httpx2.Client, path: str, body: Json) -> str:
    """Request a job, and return its id."""
    answer = http.post(path, json=body)
    assert answer.status_code == 202, answer.text
    job: str = answer.json()["id"]
    return job


def succeeded(http: httpx2.Client, job: str) -> str:
    """Return the id of a job when it has succeeded."""

    def has_succeeded() -> bool:
        state: str = http.get(f"/v1/jobs/{job}").json()["state"]
        assert state in ("queued", "running", "succeeded")
        return state == "succeeded"

    until(has_succeeded, pause=0.05)
    return job


def done(http: httpx2.Client, path: str, body: Json) -> str:
    """Request a job, and return its id when it has succeeded."""
    return succeeded(http, begun(http, path, body))


@pytest.fixture(scope="module")
def anns(ann: httpx2.Client) -> Ids:
    """What Ann has."""
    shape, other = (
        upload(ann, "/v1/shapes", blob_file(2, seed=seed), "blob.off").json()["id"]
        for seed in (101, 102)
    )
    attributes = upload(ann, "/v1/attributes", ATTRIBUTES, "heights.csv").json()["id"]
    pair = {"shapes": [shape, other]}
    requests: dict[str, Json] = {
        "/v1/matches": {"source": shape, "target": other, **MATCH},
        "/v1/batches": {"source": shape, "targets": [other], **MATCH},
        "/v1/dissimilarities": {**pair, "points": 5},
        "/v1/prototypes": {**pair, "name": "blobs", "points": 8},
    }
    jobs = [begun(ann, path, body) for path, body in requests.items()]
    match, batch, comparison, learned = [succeeded(ann, job) for job in jobs]
    prototype = ann.get(f"/v1/jobs/{learned}/result").json()["prototype"]["id"]
    return Ids(shape, other, match, prototype, attributes, comparison, batch)


def test_every_route_is_tried() -> None:
    document = json.loads((ROOT / "openapi" / "openapi.json").read_text())
    routes = {
        f"{method.upper()} {path}"
        for path, calls in document["paths"].items()
        if path.startswith("/v1/")
        for method in calls
    }
    others = {f"GET {path}" for path in LISTINGS} | {f"POST {path}" for path in UPLOADS}
    assert routes == REQUESTS.keys() | others | NOTHING_OF_ANYONE


def told(answer: httpx2.Response, ids: Ids) -> tuple[object, ...]:
    """Everything an answer says, without the ids of the request."""
    said = answer.text
    for one in astuple(ids):
        said = said.replace(one, "ID")
    varying = {"date", "x-request-id", "content-length"}
    headers = {name: value for name, value in answer.headers.items() if name not in varying}
    return answer.status_code, headers, said


def ask(http: httpx2.Client, route: str, request: Json) -> httpx2.Response:
    method, path = route.split()
    return http.request(method, path.format(**request), json=request.get("json"))


@pytest.mark.parametrize("route", REQUESTS)
def test_what_another_tenant_has_does_not_exist(
    anns: Ids, ann: httpx2.Client, bob: httpx2.Client, route: str
) -> None:
    nothing = anns.absent()
    requests = zip(REQUESTS[route](anns), REQUESTS[route](nothing), strict=True)
    for foreign, absent in requests:
        answer = ask(bob, route, foreign)
        assert answer.status_code in (404, 422), answer.text
        assert told(answer, anns) == told(ask(bob, route, absent), nothing)
    # It is all still there.
    for path in (f"shapes/{anns.shape}", f"prototypes/{anns.prototype}", f"jobs/{anns.match}"):
        assert ann.get(f"/v1/{path}").status_code == 200


@pytest.mark.parametrize("path", LISTINGS)
def test_listings_have_ones_own(
    anns: Ids, ann: httpx2.Client, bob: httpx2.Client, path: str
) -> None:
    mine = ann.get(path, params={"limit": 1}).json()
    assert len(mine["items"]) == 1
    assert bob.get(path).json() == {"items": [], "next_cursor": None}
    # A cursor of another tenant is none of this listing.
    if mine["next_cursor"] is not None:
        answer = bob.get(path, params={"cursor": mine["next_cursor"]})
        assert problem(answer, 422, "invalid-request")["errors"][0]["field"] == "query.cursor"
    if path == "/v1/jobs":
        assert bob.get(path, params={"shape": anns.shape}).json()["items"] == []


def test_the_keys_of_a_tenant_share(anns: Ids, shared: Api, bob: httpx2.Client) -> None:
    record = upload(bob, "/v1/shapes", blob_file(2, seed=103), "bob.off").json()
    with client(shared, "rose") as rose, client(shared, "dora") as dora:
        assert rose.get(f"/v1/shapes/{record['id']}").json() == record
        problem(dora.get(f"/v1/shapes/{record['id']}"), 404, "shape-not-found")
        assert rose.delete(f"/v1/shapes/{record['id']}").status_code == 204
    problem(bob.get(f"/v1/shapes/{record['id']}"), 404, "shape-not-found")


def test_a_service_without_keys_is_the_default_tenants(
    anns: Ids, shared: Api, http: httpx2.Client
) -> None:
    with client(shared, "dora") as dora:
        record = upload(dora, "/v1/shapes", blob_file(2, seed=104), "dora.off").json()
    assert http.get(f"/v1/shapes/{record['id']}").json() == record
    problem(http.get(f"/v1/shapes/{anns.shape}"), 404, "shape-not-found")


def test_the_same_bytes_of_two_tenants(
    anns: Ids, shared: Api, ann: httpx2.Client, bob: httpx2.Client
) -> None:
    """Neither is told of the other, or loses anything when the other deletes; once computed."""
    data, computed = blob_file(2, seed=105), shared.store.spectra.counts
    first = upload(ann, "/v1/shapes", data, "blob.off")
    second = upload(bob, "/v1/shapes", data, "blob.off")
    shape = first.json()["id"]
    ids = Ids(shape, *astuple(anns)[1:])
    created = first.json()["created"], second.json()["created"]
    hidden = [told(answer, ids) for answer in (first, second)]
    assert hidden[0][:2] == hidden[1][:2]
    assert first.status_code == 201
    assert {**first.json(), "created": None} == {**second.json(), "created": None}
    assert created[0] < created[1]
    other = upload(bob, "/v1/shapes", blob_file(2, seed=101), "other.off").json()["id"]
    assert other == anns.shape

    done(ann, "/v1/matches", {"source": shape, "target": anns.shape, **MATCH})
    before = computed().computed
    mine = done(bob, "/v1/matches", {"source": shape, "target": other, **MATCH})
    assert computed().computed == before
    assert bob.delete(f"/v1/shapes/{other}").status_code == 204
    assert ann.get(f"/v1/shapes/{anns.shape}/mesh").status_code == 200
    assert ann.delete(f"/v1/shapes/{shape}").status_code == 204
    assert bob.get(f"/v1/shapes/{shape}/mesh").content == data
    assert bob.get(f"/v1/jobs/{mine}/result").status_code == 200
    # What was computed of the shape that both had is kept for the one who still has it.
    done(bob, "/v1/matches", {"source": shape, "target": shape, **MATCH})
    assert computed().computed == before
    assert bob.delete(f"/v1/shapes/{shape}").status_code == 204
    assert not list(shared.store.client.scan_iter(f"isomatch:cache:spectrum:{shape}*"))


def test_the_same_bytes_in_two_formats(ann: httpx2.Client, bob: httpx2.Client) -> None:
    """What is computed of one mesh is not taken for another, whose file has the same bytes."""
    vertices, faces = blob(3, seed=107)
    corners = [f"v {x} {y} {z}" for x, y, z in vertices]
    triangles = [f"f {a} {b} {c}" for a, b, c in faces + 1]
    both = blob_file(2, seed=106) + "\n".join(corners + triangles).encode()
    shapes = [
        upload(http, "/v1/shapes", both, name).json()
        for http, name in ((ann, "blob.obj"), (bob, "blob.off"))
    ]
    assert shapes[0]["id"] == shapes[1]["id"]
    assert shapes[0]["vertices"] > shapes[1]["vertices"]
    for http, shape in zip((ann, bob), shapes, strict=True):
        body = {"source": shape["id"], "target": shape["id"], **MATCH, "dense": False}
        done(http, "/v1/matches", body)


def test_an_idempotency_key_is_ones_own(anns: Ids, ann: httpx2.Client, bob: httpx2.Client) -> None:
    ids = [
        upload(bob, "/v1/shapes", blob_file(2, seed=seed), "blob.off").json()["id"]
        for seed in (101, 102)
    ]
    assert ids == [anns.shape, anns.other]
    body, headers = {"shapes": ids}, {"Idempotency-Key": "the same"}
    jobs = [
        http.post("/v1/dissimilarities", json=body, headers=headers) for http in (ann, bob, bob)
    ]
    assert [job.status_code for job in jobs] == [202] * 3
    names = [job.json()["id"] for job in jobs]
    assert names[0] != names[1] == names[2]
