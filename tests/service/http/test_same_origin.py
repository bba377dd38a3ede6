"""Without API keys, web pages of other sites are refused; with keys nothing changes."""

import httpx2
import pytest
from pydantic import ValidationError
from starlette.datastructures import Headers

from service.http.same_origin import foreign_request
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.service.conftest import idle_api, problem

HOSTS = ("isomatch.example",)
ATTACKER = "attacker.example:8000"


def refused(method: str, **headers: str) -> bool:
    sent = Headers({name.replace("_", "-"): value for name, value in headers.items()})
    return foreign_request(method, sent, HOSTS) is not None


@pytest.mark.parametrize(
    "host",
    [
        "localhost",
        "LOCALHOST:8000",
        "localhost.",
        "isomatch.localhost",
        "127.0.0.1:8000",
        "10.1.2.3",
        "[::1]:8000",
        "[fe80::1]",
        "api:8000",
        "testserver",
        "host.docker.internal:8000",
        "isomatch-api.shapes.svc.cluster.local",
        "scanner.local.",
        "isomatch.example",
        "Isomatch.Example.:443",
        "",
    ],
)
def test_hosts_that_are_accepted(host: str) -> None:
    assert not refused("GET", host=host)
    assert not refused("POST", host=host)


@pytest.mark.parametrize(
    "host",
    [
        ATTACKER,
        "attacker.example",
        "localhost.attacker.example",
        "internal.attacker.example",
        "127.0.0.1.attacker.example",
        "1.2.3.4.5",
        "other.isomatch.example",
        "attacker@localhost",
        "localhost:8000:attacker.example",
        "[attacker.example]",
        "[::1",
    ],
)
def test_hosts_that_are_not(host: str) -> None:
    assert refused("GET", host=host)


@pytest.mark.parametrize("method", ["POST", "PUT", "PATCH", "DELETE"])
@pytest.mark.parametrize(
    ("host", "headers", "foreign"),
    [
        ("localhost:8000", {}, False),
        ("localhost:8000", {"sec_fetch_site": "same-origin"}, False),
        ("localhost:8000", {"sec_fetch_site": "none"}, False),
        ("localhost:8000", {"sec_fetch_site": "same-site"}, True),
        ("localhost:8000", {"sec_fetch_site": "cross-site"}, True),
        # Behind a proxy with TLS the two may differ.
        ("api:8000", {"sec_fetch_site": "same-origin", "origin": "https://a.example"}, False),
        ("localhost:8000", {"origin": "http://localhost:8000"}, False),
        ("localhost", {"origin": "http://localhost:80"}, False),
        ("api:443", {"origin": "https://api"}, False),
        ("[::1]:8000", {"origin": "http://[::1]:8000"}, False),
        ("localhost:8000", {"origin": "http://localhost:3000"}, True),
        ("localhost:8000", {"origin": "http://127.0.0.1:8000"}, True),
        ("localhost", {"origin": "http://localhost:8000"}, True),
        ("10.1.2.3:8000", {"origin": "https://attacker.example"}, True),
        ("localhost:8000", {"origin": "null"}, True),
        ("localhost:8000", {"origin": "file://"}, True),
        ("api:8000", {"origin": "https://isomatch.example"}, False),
        ("api:8000", {"origin": "https://attacker.example"}, True),
    ],
)
def test_origins(method: str, host: str, headers: dict[str, str], foreign: bool) -> None:
    assert refused(method, host=host, **headers) is foreign
    assert not refused("GET", host=host, **headers)


def test_pages_of_other_sites_neither_read_nor_change_anything(server: EmbeddedServer) -> None:
    upload = {"file": ("a.off", b"OFF")}
    with (
        idle_api(server, allowed_hosts="isomatch.example", validation_wait=0) as api,
        httpx2.Client(base_url=api.url, timeout=60.0) as http,
    ):
        for method in ("GET", "DELETE"):
            answer = http.request(method, "/v1/shapes/x", headers={"Host": ATTACKER})
            document = problem(answer, 421, "misdirected-request")
            assert "ISOMATCH_ALLOWED_HOSTS" in document["detail"]
        # Probes and Prometheus use addresses of pods and names of services.
        for path in ("/health/live", "/metrics", "/docs", "/"):
            assert http.get(path, headers={"Host": "isomatch-api.isomatch.svc"}).status_code == 200
        assert http.get("/v1/shapes", headers={"Host": "isomatch.example"}).status_code == 200
        for headers in ({"Sec-Fetch-Site": "cross-site"}, {"Origin": "http://attacker.example"}):
            answer = http.post("/v1/shapes", files=upload, headers=headers)
            document = problem(answer, 403, "cross-site-request")
            assert "ISOMATCH_ALLOWED_HOSTS" in document["detail"]
        own = http.post("/v1/shapes", files=upload, headers={"Sec-Fetch-Site": "same-origin"})
        assert own.status_code == 202


def test_with_keys_host_and_origin_do_not_matter(server: EmbeddedServer) -> None:
    key = "the-key-of-alice-is-long"
    foreign = {"Host": ATTACKER, "Origin": "http://b.example", "Sec-Fetch-Site": "cross-site"}
    with (
        idle_api(server, api_keys=f"alice:{key}") as api,
        httpx2.Client(base_url=api.url, headers=foreign, timeout=60.0) as http,
    ):
        problem(http.get("/v1/shapes"), 401, "unauthorized")
        known = {"Authorization": f"Bearer {key}"}
        assert http.get("/v1/shapes", headers=known).status_code == 200
        problem(http.delete("/v1/shapes/x", headers=known), 404, "shape-not-found")


def test_names_of_the_setting() -> None:
    read = Settings(allowed_hosts="Isomatch.Example., box.lan\nother").allowed_hosts
    assert read == ("isomatch.example", "box.lan", "other")
    for wrong in ("https://a.example", "a.example:443", "*.example", "a..example"):
        with pytest.raises(ValidationError, match="without scheme, port and path"):
            Settings(allowed_hosts=wrong)
