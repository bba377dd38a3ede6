"""Expired shapes are gone (410); unknown ones are not found (404)."""

from collections.abc import Iterator

import httpx2
import pytest

from broker.store import DEFAULT_KEYS
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, idle_api, problem, put_shapes


@pytest.fixture(scope="module")
def api(server: EmbeddedServer) -> Iterator[Api]:
    with idle_api(server, shape_ttl=1000) as api:
        yield api


@pytest.fixture
def http(api: Api) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=api.url, timeout=120.0) as http:
        yield http


def test_shapes(http: httpx2.Client, api: Api) -> None:
    shape, other = put_shapes(api)
    body = {
        "source": shape,
        "target": other,
        "metric": "geodesic",
        "descriptor": "none",
        "orientation": False,
    }
    assert api.store.client.ttl(DEFAULT_KEYS.shape(shape)) == -1
    assert http.post("/v1/matches", json=body).status_code == 202
    assert 0 < api.store.client.ttl(DEFAULT_KEYS.shape(shape)) <= 1000
    # Its time is over.
    api.store.client.set(DEFAULT_KEYS.shape_tombstone(shape), b"")
    api.store.client.delete(DEFAULT_KEYS.shape(shape))
    problem(http.get(f"/v1/shapes/{shape}"), 410, "shape-expired")
    problem(http.get(f"/v1/shapes/{shape}/mesh"), 410, "shape-expired")
    document = problem(http.post("/v1/matches", json=body), 422, "unknown-shape")
    assert document["errors"][0]["field"] == "body.source"
    assert "upload it again" in document["errors"][0]["message"]
    for path in ("", "/mesh"):
        problem(http.get(f"/v1/shapes/nobody{path}"), 404, "shape-not-found")
    # Who deletes it wants it forgotten.
    problem(http.delete(f"/v1/shapes/{shape}"), 404, "shape-not-found")
    problem(http.get(f"/v1/shapes/{shape}"), 404, "shape-not-found")


def test_jobs(http: httpx2.Client, api: Api) -> None:
    source, target = put_shapes(api)
    body = {
        "source": source,
        "target": target,
        "metric": "geodesic",
        "descriptor": "none",
        "orientation": False,
    }
    job = http.post("/v1/matches", json=body).json()["links"]["self"]
    api.store.client.delete(DEFAULT_KEYS.job(job.rpartition("/")[2]))
    for path in ("", "/result", "/result.png", "/events"):
        problem(http.get(job + path), 410, "job-expired")
        problem(http.get(f"/v1/jobs/nobody{path}"), 404, "job-not-found")
    problem(http.delete(job), 410, "job-expired")
