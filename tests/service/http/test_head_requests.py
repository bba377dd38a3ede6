"""HEAD is answered wherever GET is, with its headers and without its body."""

from collections.abc import Callable

import httpx2
import pytest

from broker.contracts import PicturePayload
from service.http.security import ApiKey
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, idle_api, problem, put_shapes
from tests.worker.figures import blob_file

OF_ONE_ANSWER = ("date", "x-request-id")


@pytest.fixture(scope="module")
def matched(http: httpx2.Client, shapes: tuple[str, str]) -> Json:
    """A match whose picture nobody has asked for."""
    body = {"source": shapes[0], "target": shapes[1], "points": 9, "eigenpairs": 31}
    job: Json = http.post("/v1/matches", json=body).json()
    assert http.get(job["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"
    return job


def headers(answer: httpx2.Response) -> dict[str, str]:
    return {name: value for name, value in answer.headers.items() if name not in OF_ONE_ANSWER}


@pytest.mark.parametrize(
    "path",
    [
        *("/", "/page/style.css", "/docs", "/openapi.json", "/health/live", "/health/ready"),
        *("/v1/structures", "/v1/prototypes", "/v1/shapes?limit=x", "/v1/jobs?cursor=none"),
        *("/v1/jobs/nobody", "/v1/shapes/nobody/mesh", "/page/nothing.js", "/nothing"),
    ],
)
def test_head_is_get_without_its_body(http: httpx2.Client, path: str) -> None:
    get, head = http.get(path), http.head(path)
    assert head.status_code == get.status_code
    assert headers(head) == headers(get)
    assert head.content == b""
    assert get.content


def test_head_of_what_belongs_to_shapes_and_jobs(http: httpx2.Client, matched: Json) -> None:
    links = matched["links"]
    shape_path = f"/v1/shapes/{matched['source']}"
    shape = http.get(shape_path).json()
    for path in (
        *(shape_path, f"{shape_path}/mesh", f"{shape_path}/geometry"),
        *(links["self"], links["result"], links["arrays"]),
    ):
        get, head = http.get(path), http.head(path)
        assert head.status_code == get.status_code == 200
        assert headers(head) == headers(get), path
        assert head.content == b""
    assert int(http.head(f"{shape_path}/mesh").headers["content-length"]) == shape["bytes"]


def test_head_draws_no_picture(http: httpx2.Client, api: Api, matched: Json) -> None:
    path = matched["links"]["picture"]
    before = http.head(path)
    assert (before.status_code, before.headers["content-type"]) == (200, "image/png")
    assert api.store.results.picture(PicturePayload(job=matched["id"])) is None
    picture = http.get(path)
    after = http.head(path)
    assert headers(after) == headers(picture)
    assert int(after.headers["content-length"]) == len(picture.content)
    assert set(headers(picture)) - set(headers(before)) == {"content-length"}


def test_head_of_a_picture_that_cannot_be_drawn(
    http: httpx2.Client, upload: Callable[..., Json], matched: Json
) -> None:
    count = len(http.get(matched["links"]["result"]).json()["alternatives"])
    shape = upload(blob_file(2, seed=41))["id"]
    body = {"source": matched["source"], "target": shape, "points": 8, "eigenpairs": 30}
    gone: Json = http.post("/v1/matches", json=body).json()
    assert http.get(gone["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"
    assert http.delete(f"/v1/shapes/{shape}").status_code == 204
    for picture, status in (
        (f"{matched['links']['picture']}?alternative={count + 1}", 422),
        (f"{matched['links']['picture']}?alternative=33", 422),
        (gone["links"]["picture"], 410),
        ("/v1/jobs/nobody/result.png", 404),
        (f"{matched['links']['self']}/result.zip", 409),
    ):
        get, head = http.get(picture), http.head(picture)
        assert head.status_code == get.status_code == status, picture
        assert headers(head) == headers(get)
        assert head.content == b""


def test_head_of_events_ends_at_once(server: EmbeddedServer) -> None:
    with idle_api(server) as api, httpx2.Client(base_url=api.url, timeout=120.0) as http:
        source, target = put_shapes(api)
        body = {
            "source": source,
            "target": target,
            "metric": "geodesic",
            "descriptor": "none",
            "orientation": False,
        }
        job = http.post("/v1/matches", json=body).json()
        answer = http.head(job["links"]["events"])
        assert answer.status_code == 200
        assert answer.headers["content-type"].startswith("text/event-stream")
        assert answer.headers["cache-control"] == "no-store"
        # The connection is whole, and the next answer on it is the right one.
        assert http.get(job["links"]["self"]).json()["state"] == "queued"


def test_head_where_nothing_is_got(http: httpx2.Client, server: EmbeddedServer) -> None:
    answer = http.head("/v1/matches")
    assert answer.status_code == 405
    assert answer.headers["allow"] == "POST"
    assert problem(http.get("/v1/matches"), 405, "method-not-allowed")
    assert http.put("/v1/shapes").headers["allow"] == "GET, HEAD, POST"
    assert http.head("/v1/shapes/" + "0" * 32).status_code == 404
    keys = (ApiKey("somebody", b"0" * 32),)
    with (
        idle_api(server, api_keys=keys) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as stranger,
    ):
        assert stranger.head("/v1/shapes").status_code == 401
        assert stranger.head("/health/live").status_code == 200


def test_head_of_a_format_that_needs_a_dense_map(http: httpx2.Client, matched: Json) -> None:
    path = f"{matched['links']['self']}/result.ply"
    assert http.head(path).status_code == http.get(path).status_code == 409
