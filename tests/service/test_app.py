"""The application round its endpoints: errors nobody foresaw, request ids, probes, the document."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from openapi_schema_validator import OAS31Validator, oas31_format_checker
from openapi_spec_validator import validate

from broker.store import DEFAULT_KEYS, connect
from service.http.openapi import headers
from service.release import VERSION
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.blobs import blob_url
from tests.service.conftest import Api, Json, idle_api, problem, running_api
from tests.waiting import until
from tests.worker.figures import blob_file

ROOT = Path(__file__).resolve().parents[2]
OPENAPI = ROOT / "openapi" / "openapi.json"


def test_addresses_and_methods_of_nothing(http: httpx2.Client) -> None:
    problem(http.get("/v1/nothing"), 404, "not-found")
    problem(http.get("/v1/shapes/"), 404, "not-found")
    answer = http.put("/v1/shapes")
    problem(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == "GET, HEAD, POST"
    answer = http.options("/v1/jobs/x")
    problem(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == "DELETE, GET, HEAD"


def test_request_ids(http: httpx2.Client) -> None:
    given = http.get("/health/live", headers={"X-Request-ID": "mine-1.2_3"})
    assert given.headers["x-request-id"] == "mine-1.2_3"
    made = {http.get("/health/live").headers["x-request-id"] for _ in range(2)}
    assert len(made) == 2
    odd = http.get("/health/live", headers={"X-Request-ID": "a b;c"})
    assert odd.headers["x-request-id"] != "a b;c"
    assert http.get("/v1/nothing", headers={"X-Request-ID": "x"}).headers["x-request-id"] == "x"


def test_request_ids_go_with_the_jobs(
    http: httpx2.Client, shapes: tuple[str, str], api: Api
) -> None:
    body = {"source": shapes[0], "target": shapes[1], "points": 8, "orientation": False}
    answer = http.post("/v1/matches", json=body, headers={"X-Request-ID": "from-me"})
    record = api.store.jobs.get(answer.json()["id"])
    assert record is not None
    assert record.request_id == "from-me"
    http.get(answer.json()["links"]["self"], params={"wait": 60})


def test_probes(http: httpx2.Client) -> None:
    assert http.get("/health/live").json() == {"status": "ok", "version": VERSION}
    assert http.get("/health/ready").json() == {"status": "ok", "workers": 2}


@pytest.mark.parametrize("path", ["/docs", "/redoc"])
def test_the_documentation_needs_no_other_host(http: httpx2.Client, path: str) -> None:
    page = http.get(path).text
    parts = re.findall(r'<(?:script|link)[^>]*(?:src|href)="([^"]+)"', page)
    assert parts
    for link in parts:
        assert link.startswith("/")
        assert http.get(link).status_code == 200


def test_without_workers_it_is_not_ready(server: EmbeddedServer) -> None:
    with idle_api(server) as api, httpx2.Client(base_url=api.url, timeout=60.0) as http:
        problem(http.get("/health/ready"), 503, "not-ready")
        assert http.get("/health/live").status_code == 200


def test_without_its_store(tmp_path: Path) -> None:
    settings = Settings(
        redis_url=f"unix://{tmp_path}/nobody.sock",
        blob_url=blob_url(tmp_path),
        redis_patience=0.2,
    )
    with running_api(settings) as api, httpx2.Client(base_url=api.url, timeout=60.0) as http:
        for path in ("/health/ready", "/v1/shapes", "/v1/jobs/x", "/v1/shapes/x"):
            answer = http.get(path)
            problem(answer, 503, "store-away")
            assert answer.headers["retry-after"]
        files = {"file": ("a.off", b"OFF")}
        problem(http.post("/v1/shapes", files=files), 503, "store-away")
        assert http.get("/health/live").status_code == 200


def until_answered(http: httpx2.Client) -> None:
    """Wait until the store does, which on a busy machine may be silent for a moment as well."""

    def answers() -> bool:
        status = http.get("/v1/shapes").status_code
        assert status in (200, 503)
        return status == 200

    until(answers, 60.0)


def test_a_store_that_is_there_and_says_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hung, or cut off from us: nobody is kept waiting for minutes."""
    monkeypatch.setattr("service.app.REDIS_TIMEOUT", 0.5)
    server = EmbeddedServer(tmp_path)
    server.start()
    assert server.pid is not None
    settings = Settings(redis_url=server.url, blob_url=blob_url(tmp_path), redis_patience=2.0)
    try:
        with running_api(settings) as api, httpx2.Client(base_url=api.url, timeout=60.0) as http:
            until_answered(http)
            os.kill(server.pid, signal.SIGSTOP)
            try:
                for path in ("/health/ready", "/v1/shapes", "/v1/jobs/x"):
                    problem(http.get(path), 503, "store-away")
                assert "isomatch_store_up 0.0" in http.get("/metrics").text
                assert http.get("/health/live").status_code == 200
            finally:
                os.kill(server.pid, signal.SIGCONT)
            until_answered(http)
    finally:
        server.stop()


def test_unexpected_errors_are_problem_documents(http: httpx2.Client, api: Api) -> None:
    # A record that this program never wrote.
    api.store.client.set(DEFAULT_KEYS.shape("broken"), b"{")
    answer = http.get("/v1/shapes/broken", headers={"X-Request-ID": "the-one"})
    document = problem(answer, 500, "internal-error")
    assert "the-one" in document["detail"]
    assert "pydantic" not in answer.text
    assert answer.headers["x-request-id"] == "the-one"
    api.store.client.delete(DEFAULT_KEYS.shape("broken"))


def test_the_api_process_knows_no_numerics() -> None:
    program = (
        "import sys, service.app, service.standalone.standalone\n"
        "heavy = {'numpy', 'scipy', 'trimesh', 'numba', 'matplotlib', 'skimage', 'solver'}\n"
        "print(sorted(heavy & set(sys.modules)))\n"
        "print(sorted(m for m in sys.modules if m.startswith('worker.') and m.count('.') == 1))\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    assert said[0] == "[]"
    for heavy in ("jobs", "runner", "spectra", "matches", "picture", "meshes"):
        assert f"'worker.{heavy}'" not in said[1]


def test_the_openapi_document_is_valid_and_served(http: httpx2.Client) -> None:
    document = json.loads(OPENAPI.read_text(encoding="utf-8"))
    validate(document)
    assert http.get("/openapi.json").json() == document
    upload = document["components"]["schemas"]["Body_upload_shape"]["properties"]["file"]
    assert upload["format"] == "binary"


def test_every_call_says_how_it_fails() -> None:
    paths = json.loads(OPENAPI.read_text(encoding="utf-8"))["paths"]
    calls = [call for path in paths.values() for call in path.values()]
    assert len({call["operationId"] for call in calls}) == len(calls) >= 12
    for call in calls:
        for status, answer in call["responses"].items():
            if status >= "400":
                content = answer["content"]["application/problem+json"]
                assert content["schema"]["$ref"].endswith("/Problem")
                for example in content["examples"].values():
                    assert str(example["value"]["status"]) == status


def test_every_call_has_examples() -> None:
    document = json.loads(OPENAPI.read_text(encoding="utf-8"))
    components = document["components"]

    def check(schema: Json, value: object) -> None:
        whole = {**schema, "components": components}
        OAS31Validator(whole, format_checker=oas31_format_checker).validate(value)

    def examples(content: Json) -> list[object]:
        if "example" in content:
            return [content["example"]]
        if "examples" in content:
            return [example["value"] for example in content["examples"].values()]
        name = content["schema"]["$ref"].rpartition("/")[2]
        return list(components["schemas"][name]["examples"])

    for path in document["paths"].values():
        for call in path.values():
            for parameter in call.get("parameters", ()):
                check(parameter["schema"], parameter["example"])
            answers = call["responses"].items()
            bodies = [call["requestBody"]] if "requestBody" in call else []
            bodies += [answer for status, answer in answers if status < "400"]
            for body in bodies:
                for kind, content in body.get("content", {}).items():
                    if content["schema"].get("format") == "binary":
                        assert kind in (
                            "application/octet-stream",
                            "image/png",
                            "text/csv",
                            "model/ply",
                            "model/obj",
                            "model/gltf-binary",
                            "application/zip",
                        )
                        continue
                    shown = examples(content)
                    assert shown, call["operationId"]
                    for value in shown:
                        check(content["schema"], value)


SCHEMAS = json.loads(OPENAPI.read_text(encoding="utf-8"))["components"]["schemas"]


def shown_of(name: str) -> list[tuple[Json, object]]:
    """Examples of a schema and of its fields, each with what it is an example of."""
    parts = [SCHEMAS[name], *SCHEMAS[name].get("properties", {}).values()]
    return [(part, one) for part in parts for one in part.get("examples", ())]


@pytest.mark.parametrize("name", [name for name in SCHEMAS if shown_of(name)])
def test_examples_of_schemas_are_valid(name: str) -> None:
    for schema, example in shown_of(name):
        whole = {**schema, "components": {"schemas": SCHEMAS}}
        OAS31Validator(whole, format_checker=oas31_format_checker).validate(example)


@pytest.mark.parametrize("name", SCHEMAS)
def test_all_fields_are_described(name: str) -> None:
    for field, part in SCHEMAS[name].get("properties", {}).items():
        assert "description" in part or "$ref" in part, field


def test_the_document_has_no_schema_without_use() -> None:
    text = OPENAPI.read_text(encoding="utf-8")
    assert [name for name in SCHEMAS if f'"#/components/schemas/{name}"' not in text] == []


def test_bounds_of_integers_are_integers() -> None:
    text = OPENAPI.read_text(encoding="utf-8")
    points = json.loads(text)["components"]["schemas"]["MatchRequest"]["properties"]["points"]
    (integer,) = [one for one in points["anyOf"] if one["type"] == "integer"]
    assert repr(integer["maximum"]) == "256"


def test_fields_that_are_always_answered_are_required() -> None:
    for name in ("Shape", "Prototype", "Job", "JobLinks", "JobWebhook", "Problem", "WebhookEvent"):
        assert set(SCHEMAS[name]["required"]) == set(SCHEMAS[name]["properties"])


def test_headers_are_declared(http: httpx2.Client) -> None:
    paths = json.loads(OPENAPI.read_text(encoding="utf-8"))["paths"]
    calls = [call for path in paths.values() for call in path.values()]
    answers = [answer for call in calls for answer in call["responses"].items()]
    assert all("X-Request-ID" in answer["headers"] for _, answer in answers)
    for status, needed in (("401", "WWW-Authenticate"), ("429", "Retry-After"), ("304", "ETag")):
        of_status = [answer["headers"] for answered, answer in answers if answered == status]
        assert of_status
        assert all(needed in declared for declared in of_status)
    operations = {call["operationId"] for call in calls}
    assert operations >= headers.NAMED_FILES


def test_an_answer_without_content_has_no_media_type(
    http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    answer = http.delete(f"/v1/shapes/{upload(blob_file(2, seed=907))['id']}")
    assert answer.status_code == 204
    assert "content-type" not in answer.headers


def test_the_version_is_that_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["version"] == VERSION
    assert json.loads(OPENAPI.read_text(encoding="utf-8"))["info"]["version"] == VERSION


def test_links_lead_to_what_there_is() -> None:
    paths = json.loads(OPENAPI.read_text(encoding="utf-8"))["paths"]
    calls = {call["operationId"]: call for path in paths.values() for call in path.values()}
    links = [
        link
        for call in calls.values()
        for answer in call["responses"].values()
        for link in answer.get("links", {}).values()
    ]
    assert len(links) >= 15
    for link in links:
        names = {entry["name"] for entry in calls[link["operationId"]]["parameters"]}
        assert set(link["parameters"]) <= names


def started(module: str, **settings: str) -> subprocess.CompletedProcess[str]:
    """Start a process that does not get far."""
    return subprocess.run(
        [sys.executable, "-m", module],
        cwd=ROOT,
        env={**os.environ, **settings},
        capture_output=True,
        text=True,
        check=False,
    )


def test_settings_that_mean_nothing_are_named() -> None:
    wrong = {
        "ISOMATCH_PORT": "much",
        "ISOMATCH_MAX_UPLOAD_BYTES": "much",
        "ISOMATCH_LOG_LEVEL": "much",
        "ISOMATCH_REDIS_URL": "localhost",
        "ISOMATCH_BLOB_URL": "file://relative",
        "ISOMATCH_CACHE_URL": "redis://localhost:much",
    }
    said = started("service", **wrong)
    assert said.returncode == 2
    assert said.stdout == ""
    named = [line.split(": ")[:2] for line in said.stderr.splitlines()]
    assert sorted(named) == [["isomatch", name] for name in sorted(wrong)]


@pytest.mark.parametrize("settings", [{}, {"ISOMATCH_LOG_LEVEL": "much"}])
def test_a_worker_that_cannot_start_says_why_in_a_line(settings: dict[str, str]) -> None:
    said = started("worker", **{"ISOMATCH_REDIS_URL": ""} | settings)
    assert said.returncode == 2
    assert said.stderr.startswith("worker: ISOMATCH_")
    assert len(said.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("module", "cause"), [("service", "ISOMATCH_BLOB_URL"), ("worker", "ISOMATCH_REDIS_URL")]
)
def test_misspelt_settings_are_logged(module: str, cause: str) -> None:
    away = {"ISOMATCH_REDIS_URL": "redis://x" if module == "service" else ""}
    said = started(module, ISOMATCH_JOB_TIMOUT="5", ISOMATCH_BLOB_URL="", **away)
    warning, error = said.stderr.splitlines()
    told = json.loads(warning)
    assert (told["event"], told["variable"]) == ("unknown setting", "ISOMATCH_JOB_TIMOUT")
    assert told["meant"] == "ISOMATCH_JOB_TIMEOUT"
    assert error.startswith(("isomatch: ", "worker: "))
    assert cause in error


@contextmanager
def running_service(log: Path, **settings: str) -> Iterator[httpx2.Client]:
    """Run the service in a process of its own, and connect to it when it listens."""
    with (
        log.open("wb") as stderr,
        subprocess.Popen(
            [sys.executable, "-m", "service", "--port", "0"],
            cwd=ROOT,
            env={**os.environ, **settings},
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
        ) as process,
    ):
        assert process.stdout is not None
        try:
            line = process.stdout.readline()
            assert line.startswith("isomatch listens on "), log.read_text()
            with httpx2.Client(base_url=line.split()[-1], timeout=60.0) as http:
                yield http
        finally:
            process.terminate()


def test_a_store_that_starts_later_is_waited_for(tmp_path: Path) -> None:
    log, later = tmp_path / "log", EmbeddedServer(tmp_path / "redis")
    settings = {
        "ISOMATCH_REDIS_URL": later.url,
        "ISOMATCH_BLOB_URL": blob_url(tmp_path),
        "ISOMATCH_REDIS_PATIENCE": "0.2",
        "ISOMATCH_HEARTBEAT": "1",
        "ISOMATCH_READY_WORKERS": "0",
    }
    with running_service(log, **settings) as http:
        assert http.get("/health/live").status_code == 200
        problem(http.get("/v1/jobs"), 503, "store-away")
        (waiting,) = [line for line in log.read_text().splitlines() if "waited for" in line]
        assert later.url.removeprefix("unix://") in json.loads(waiting)["error"]
        later.start()
        try:
            until(lambda: http.get("/health/ready").status_code == 200)
            until(lambda: http.get("/v1/jobs").status_code == 200)
        finally:
            later.stop()
    assert "Traceback" not in log.read_text()


def test_a_store_without_a_file_is_told_once(tmp_path: Path) -> None:
    log, own = tmp_path / "log", EmbeddedServer(tmp_path / "redis")
    own.start()
    try:
        with connect(own.url, retry_seconds=5) as client:
            client.config_set("appendonly", "no")
        stores = {"ISOMATCH_REDIS_URL": own.url, "ISOMATCH_BLOB_URL": blob_url(tmp_path)}
        with running_service(log, ISOMATCH_HEARTBEAT="1", **stores):
            until(lambda: "no append-only file" in log.read_text())
            time.sleep(2)  # two heartbeats
    finally:
        own.stop()
    assert log.read_text().count("no append-only file") == 1


def test_empty_settings_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HOST", "DATA_DIR", "REDIS_URL", "WORKERS"):
        monkeypatch.setenv(f"ISOMATCH_{name}", "")
    settings = Settings()
    assert settings.host == "127.0.0.1"
    assert settings.data_dir == Path("isomatch-data")
    assert settings.redis_url is None
