"""Pages of other sites that may call the API."""

import httpx2
import pytest
from pydantic import ValidationError

from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.service.conftest import idle_api, problem

PAGE = "https://app.example"
KEY = "the-key-of-alice-is-long"
PREFLIGHT = {
    "Origin": PAGE,
    "Access-Control-Request-Method": "POST",
    "Access-Control-Request-Headers": "authorization, content-type, idempotency-key",
}


def test_pages_of_listed_origins_call_with_a_key(server: EmbeddedServer) -> None:
    with (
        idle_api(server, api_keys=f"alice:{KEY}", cors_origins=PAGE) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        asked = http.options("/v1/matches", headers=PREFLIGHT)
        assert asked.status_code == 200
        assert asked.headers["access-control-allow-origin"] == PAGE
        assert "POST" in asked.headers["access-control-allow-methods"]
        keyless = http.get("/v1/shapes", headers={"Origin": PAGE})
        problem(keyless, 401, "unauthorized")
        assert keyless.headers["access-control-allow-origin"] == PAGE
        headers = {"Origin": PAGE, "Authorization": f"Bearer {KEY}"}
        answer = http.post("/v1/matches", json={}, headers=headers)
        problem(answer, 422, "invalid-request")
        assert answer.headers["access-control-allow-origin"] == PAGE
        exposed = answer.headers["access-control-expose-headers"]
        for name in ("X-Request-ID", "Location", "Retry-After", "ETag"):
            assert name in exposed
        for refused in (
            http.options("/v1/matches", headers=PREFLIGHT | {"Origin": "https://other.example"}),
            http.get("/v1/shapes", headers=headers | {"Origin": "https://other.example"}),
            http.get("/health/live", headers={"Origin": PAGE}),
        ):
            assert "access-control-allow-origin" not in refused.headers


def test_without_keys_no_page_of_another_site_calls(server: EmbeddedServer) -> None:
    with (
        idle_api(server, cors_origins=PAGE) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        assert not http.options("/v1/matches", headers=PREFLIGHT).is_success
        answer = http.get("/v1/shapes", headers={"Origin": PAGE})
        assert "access-control-allow-origin" not in answer.headers


def test_origins_of_the_setting() -> None:
    read = Settings(cors_origins="https://A.example, http://localhost:5173").cors_origins
    assert read == ("https://a.example", "http://localhost:5173")
    for wrong in ("*", "a.example", "https://a.example/", "null"):
        with pytest.raises(ValidationError, match="not an origin"):
            Settings(cors_origins=wrong)
    with pytest.raises(ValidationError, match="need API keys"):
        Settings(cors_origins=PAGE, auth="none")
