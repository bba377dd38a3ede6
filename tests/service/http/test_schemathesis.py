"""The running service is asked all that its OpenAPI document allows, and what it does not."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest

from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.blobs import blob_url
from tests.service.conftest import LIMIT, PATIENCE, Api, empty_database, served_api
from tests.worker.figures import blob_file

ROOT = Path(__file__).resolve().parents[3]
EXAMPLES = 3
"""Requests of each kind for each call."""

PHASES = ("examples", "coverage", "fuzzing", "stateful")


@pytest.fixture(scope="module")
def api(server: EmbeddedServer, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    """A service of its own: what it lists is followed, and deleted."""
    settings = Settings(
        redis_url=empty_database(server),
        blob_url=blob_url(tmp_path_factory.mktemp("store")),
        max_upload_bytes=LIMIT,
        validation_wait=PATIENCE,
    )
    with served_api(settings) as running:
        yield running


@pytest.fixture
def http(api: Api) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=api.url, timeout=300.0) as http:
        yield http


@pytest.fixture
def real_ids(http: httpx2.Client) -> Iterator[dict[str, str]]:
    """Shapes, and jobs of them with results, as the hooks want them; no job is left behind."""
    files = [{"file": ("blob.off", blob_file(2, seed=seed))} for seed in (91, 92)]
    shapes = [http.post("/v1/shapes", files=file).json()["id"] for file in files]
    asked = (
        ("matches", {"source": shapes[0], "target": shapes[1], "points": 8, "eigenpairs": 30}),
        ("dissimilarities", {"shapes": shapes, "eigenpairs": 30}),
        ("prototypes", {"shapes": shapes, "points": 6, "components": 1, "eigenpairs": 30}),
    )
    jobs = [http.post(f"/v1/{path}", json=body).json() for path, body in asked]
    for job in jobs:
        ended = http.get(job["links"]["self"], params={"wait": 60}).json()
        assert ended["state"] == "succeeded", ended
    ids = [job["id"] for job in jobs]
    learned = http.get(f"/v1/jobs/{ids[-1]}/result").json()["prototype"]["id"]
    yield {
        "REAL_SHAPES": json.dumps(shapes),
        "REAL_JOBS": json.dumps(ids),
        "REAL_PROTOTYPES": json.dumps([learned]),
    }
    for state in ("queued", "running"):
        left = http.get("/v1/jobs", params={"state": state, "limit": 200}).json()["items"]
        for job in left:
            http.delete(job["links"]["self"])


def test_schemathesis_finds_nothing(api: Api, real_ids: dict[str, str]) -> None:
    hooks = {"SCHEMATHESIS_HOOKS": "tests.service.http.schemathesis_hooks", "PYTHONPATH": str(ROOT)}
    command = [
        str(Path(sys.executable).with_name("st")),
        "--no-color",
        "run",
        f"{api.url}/openapi.json",
        *("--phases", ",".join(PHASES)),
        *("--max-examples", str(EXAMPLES)),
        *("--seed", "1"),
        *("--generation-database", "none"),
        *("--suppress-health-check", "too_slow"),
        *("--request-timeout", "300"),
        *("--warnings", "off"),
    ]
    done = subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, **hooks, **real_ids},
        capture_output=True,
        text=True,
        check=False,
        timeout=540,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for phase in PHASES:
        assert f"✅ {phase.capitalize()}\n" in done.stdout
