"""API keys: who is let in where, and what is said to the others."""

import hashlib
import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import httpx2
import pytest
from pydantic import ValidationError

from service.http import KeyRing
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, idle_api, problem, put_shapes

ROOT = Path(__file__).resolve().parents[3]
DIGEST = hashlib.sha256(b"bobs-key").hexdigest()
KEYS = f"alice:alices-key, bob:sha256:{DIGEST}\ncarol:a:b"

MATCH = {
    "source": "a" * 32,
    "target": "b" * 32,
    "metric": "geodesic",
    "descriptor": "none",
    "orientation": False,
}


@pytest.fixture(scope="module")
def api(server: EmbeddedServer) -> Iterator[Api]:
    with idle_api(server, api_keys=KEYS, max_queued_jobs=2) as api:
        yield api


def caller(api: Api, key: str | None) -> httpx2.Client:
    headers = {} if key is None else {"Authorization": f"Bearer {key}"}
    return httpx2.Client(base_url=api.url, headers=headers, timeout=120.0)


def test_paths_that_need_a_key(api: Api) -> None:
    document = json.loads((ROOT / "openapi" / "openapi.json").read_text())
    with caller(api, None) as http:
        for path, calls in document["paths"].items():
            for method, call in calls.items():
                answer = http.request(method, path.replace("{", "").replace("}", ""))
                if path.startswith("/v1/"):
                    assert call["security"] == [{"apiKey": []}, {}]
                    problem(answer, 401, "unauthorized")
                    assert answer.headers["www-authenticate"] == 'Bearer realm="isomatch"'
                    assert answer.headers["x-request-id"]
                else:
                    assert "security" not in call
                    assert answer.status_code in (200, 503)
        for path in ("/", "/docs", "/openapi.json"):
            assert http.get(path).status_code == 200
        # What there is under /v1 is nobody's business either.
        problem(http.get("/v1/nothing"), 401, "unauthorized")
        problem(http.get("/v1"), 401, "unauthorized")


@pytest.mark.parametrize("key", ["alices-key", "bobs-key", "a:b"])
def test_those_who_have_a_key_may_call(api: Api, key: str) -> None:
    with caller(api, key) as http:
        assert http.get("/v1/shapes").status_code == 200


@pytest.mark.parametrize(
    "authorization",
    [
        "Bearer",
        "Bearer alice",
        "Bearer alices-ke",
        "Bearer alices-key2",
        "Bearer ALICES-KEY",
        "Basic alices-key",
        "alices-key",
        f"Bearer {DIGEST}",
        f"Bearer sha256:{DIGEST}",
        "Bearer \xe4",
    ],
)
def test_those_who_have_none_may_not(api: Api, authorization: str) -> None:
    headers = {b"authorization": authorization.encode("latin-1")}
    with caller(api, None) as http:
        answer = http.get("/v1/shapes", headers=headers)
    problem(answer, 401, "unauthorized")
    assert "alices-key" not in answer.text


def test_the_scheme_is_a_word_in_any_case() -> None:
    keys = Settings(api_keys=KEYS).api_keys
    ring = KeyRing(keys, None)
    assert ring.find("bearer alices-key") == keys[0]
    assert ring.find("BEARER  alices-key ") == keys[0]


def test_an_upload_without_a_key_is_told_so(api: Api) -> None:
    with caller(api, None) as http:
        files = {"file": ("a.off", b"x" * 4 * 1024**2)}
        problem(http.post("/v1/shapes", files=files), 401, "unauthorized")


def test_an_upload_that_asks_first_sends_nothing(api: Api) -> None:
    url = httpx2.URL(api.url)
    with socket.create_connection((url.host, url.port or 80), timeout=30) as connection:
        connection.sendall(
            b"POST /v1/shapes HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\n"
            b"Content-Length: 1000000\r\nContent-Type: multipart/form-data; boundary=b\r\n\r\n"
        )
        assert connection.recv(64).startswith(b"HTTP/1.1 401")


def test_shapes_and_jobs_are_common_and_say_whose_they_are(api: Api) -> None:
    shapes = put_shapes(api)
    with caller(api, "alices-key") as alice, caller(api, "bobs-key") as bob:
        job = alice.post("/v1/matches", json=MATCH).json()
        assert job["caller"] == "alice"
        assert bob.get(job["links"]["self"]).json() == job
        assert bob.get(f"/v1/shapes/{shapes[0]}").status_code == 200
        assert bob.delete(job["links"]["self"]).json()["state"] == "cancelled"


def test_limits_and_idempotency_keys_are_each_callers_own(api: Api) -> None:
    put_shapes(api)
    with caller(api, "alices-key") as alice, caller(api, "bobs-key") as bob:
        key = {"Idempotency-Key": "mine"}
        ids = [
            http.post("/v1/matches", json=MATCH, headers=key).json()["id"]
            for http in (alice, bob, alice)
        ]
        assert ids[0] == ids[2] != ids[1]
        assert alice.post("/v1/matches", json=MATCH).status_code == 202
        problem(alice.post("/v1/matches", json=MATCH), 429, "too-many-jobs")
        assert bob.post("/v1/matches", json=MATCH).status_code == 202


@pytest.mark.parametrize(
    "keys",
    [
        "alice",
        "alice:",
        ":key-of-nobody",
        "a b:key",
        "alice:key-one,alice:key-two",
        "alice:key-one,bob:key-one",
        "alice:sha256:0123",
        f"alice:sha256:{DIGEST[:-1]}g",
        "/alice:key",
        "a/b/alice:key",
        "blue/:key",
        "blue/alice:key-one,blue/alice:key-two",
    ],
)
def test_keys_that_are_none_are_refused_without_showing_them(keys: str) -> None:
    with pytest.raises(ValidationError) as refusal:
        Settings(api_keys=keys)
    message = refusal.value.errors()[0]["msg"]
    assert "key-" not in message
    assert refusal.value.errors()[0]["loc"] == ("api_keys",)


def test_names_are_those_of_a_tenant() -> None:
    keys = Settings(api_keys=f"alice:a/b:c, blue/alice:key-one red/alice:sha256:{DIGEST}").api_keys
    assert [(key.tenant, key.name) for key in keys] == [
        ("default", "alice"),
        ("blue", "alice"),
        ("red", "alice"),
    ]
    ring = KeyRing(keys, None)
    assert ring.find("Bearer a/b:c") == keys[0]
    assert ring.find("Bearer bobs-key") == keys[2]


def test_keys_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ISOMATCH_API_KEYS", KEYS)
    settings = Settings()
    assert [key.name for key in settings.api_keys] == ["alice", "bob", "carol"]
    assert "alices-key" not in repr(settings)
    monkeypatch.setenv("ISOMATCH_API_KEYS", "alice")
    said = subprocess.run(
        [sys.executable, "-m", "service"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert said.returncode == 2
    assert said.stderr.startswith("isomatch: ISOMATCH_API_KEYS: ")


@pytest.mark.parametrize(
    ("path", "authorization", "status"),
    [
        (b"/v1/shapes", b"", 401),
        (b"/v1/matches", b"Authorization: Bearer nobodys\r\n", 401),
        (b"/v1/shapez", b"Authorization: Bearer alices-key\r\n", 404),
        (b"/v1/shapes/a", b"Authorization: Bearer alices-key\r\n", 405),
        (b"/nothing", b"", 404),
    ],
)
@pytest.mark.parametrize(
    "framing", [b"Content-Length: 1000000000\r\n\r\n", b"Transfer-Encoding: chunked\r\n\r\n"]
)
def test_what_is_refused_is_refused_before_its_body_is_sent(
    api: Api, path: bytes, authorization: bytes, status: int, framing: bytes
) -> None:
    address = urlsplit(api.url)
    with socket.create_connection((address.hostname, address.port), timeout=30) as sender:
        sender.sendall(b"POST %s HTTP/1.1\r\nHost: x\r\n%s" % (path, authorization + framing))
        answer = b""
        while not answer.endswith(b"}"):
            received = sender.recv(10_000)
            assert received
            answer += received
    assert answer.startswith(b"HTTP/1.1 %d " % status)
    assert b"connection: close" in answer.lower()


def test_a_sender_that_goes_on_sending_reads_the_refusal_all_the_same(api: Api) -> None:
    files = {"file": ("a.off", bytes(50 * 1024**2))}
    with caller(api, "nobodys") as http:
        problem(http.post("/v1/shapes", files=files), 401, "unauthorized")
    with caller(api, "alices-key") as http:
        problem(http.post("/v1/nothing", files=files), 404, "not-found")
