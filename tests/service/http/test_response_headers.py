"""Every answer has its security headers, whoever gives it."""

import httpx2
import pytest

from tests.service.conftest import problem

NOT_STORED = "private, no-store"


@pytest.mark.parametrize(
    ("path", "caching"),
    [
        ("/", "no-cache"),
        ("/health/live", None),
        ("/metrics", None),
        ("/openapi.json", None),
        ("/nothing", None),
        ("/static-offline-docs/favicon.png", None),
        ("/v1/shapes", NOT_STORED),
        ("/v1/structures", NOT_STORED),
        ("/v1/nothing", NOT_STORED),
    ],
)
def test_types_are_not_guessed_and_v1_is_not_stored(
    http: httpx2.Client, path: str, caching: str | None
) -> None:
    answer = http.get(path)
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers.get("cache-control") == caching


def test_refusals_are_not_stored_either(http: httpx2.Client) -> None:
    encoded = http.post("/v1/matches", content=b"{}", headers={"Content-Encoding": "gzip"})
    problem(encoded, 415, "encoded-body")
    foreign = http.get("/v1/shapes", headers={"Host": "attacker.example"})
    problem(foreign, 421, "misdirected-request")
    for answer in (encoded, foreign):
        assert answer.headers.get_list("cache-control") == [NOT_STORED]
        assert answer.headers["x-content-type-options"] == "nosniff"


def test_the_geometry_is_revalidated(http: httpx2.Client, shapes: tuple[str, str]) -> None:
    answer = http.get(f"/v1/shapes/{shapes[0]}/geometry")
    assert answer.headers.get_list("cache-control") == ["private, no-cache"]


@pytest.mark.parametrize("path", ["/docs", "/docs/oauth2-redirect", "/redoc"])
def test_the_documentation_has_a_policy(http: httpx2.Client, path: str) -> None:
    policy = http.get(path).headers["content-security-policy"].split("; ")
    assert {"default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'"} <= set(policy)
    assert "unsafe-eval" not in str(policy)
