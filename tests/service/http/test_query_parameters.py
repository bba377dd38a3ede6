"""Query parameters that an address does not take are refused, and those that it takes are named."""

import httpx2
import pytest

from service.http import MOST_FIELDS
from tests.service.conftest import problem


@pytest.mark.parametrize(
    ("method", "path", "takes"),
    [
        ("GET", "/v1/jobs", "it takes cursor, kind, limit, shape, state"),
        ("GET", "/v1/jobs/7", "it takes wait"),
        ("GET", "/v1/jobs/7/result.png", "it takes alternative, view"),
        ("GET", "/v1/shapes/7", "it takes none"),
        ("HEAD", "/v1/shapes/7", ""),
        ("DELETE", "/v1/jobs/7", "it takes none"),
        ("POST", "/v1/matches", "it takes none"),
        ("GET", "/v1/structures", "it takes none"),
    ],
)
def test_unknown_parameters_are_refused(
    http: httpx2.Client, method: str, path: str, takes: str
) -> None:
    body = {"source": "a", "target": "b"} if method == "POST" else None
    answer = http.request(method, path, params={"stat": "queued", "page": "2"}, json=body)
    if method == "HEAD":
        assert answer.status_code == 422
        return
    errors = problem(answer, 422, "invalid-request")["errors"]
    assert [one["field"] for one in errors] == ["query.stat", "query.page"]
    assert all(takes in one["message"] for one in errors)


def test_repeated_parameters_are_refused(http: httpx2.Client) -> None:
    asked = "/v1/jobs?state=queued&limit=1&state=failed&limit=1&kind=match"
    errors = problem(http.get(asked), 422, "invalid-request")["errors"]
    assert [one["field"] for one in errors] == ["query.limit"]
    assert all("several times" in one["message"] for one in errors)


def test_few_of_many_are_named_and_briefly(http: httpx2.Client) -> None:
    asked = {f"{number:03}" + 300 * "x": "1" for number in range(50)}
    errors = problem(http.get("/v1/jobs", params=asked), 422, "invalid-request")["errors"]
    assert len(errors) == MOST_FIELDS
    assert max(len(one["field"]) for one in errors) <= 100


@pytest.mark.parametrize("path", ["/", "/page/main.js", "/health/live", "/metrics"])
def test_page_and_probes_take_any(http: httpx2.Client, path: str) -> None:
    assert http.get(path, params={"utm_source": "mail"}).status_code == 200


def test_known_parameters_are_taken(http: httpx2.Client) -> None:
    asked = {"state": "queued", "kind": "match", "limit": "1"}
    assert http.get("/v1/jobs", params=asked).status_code == 200
