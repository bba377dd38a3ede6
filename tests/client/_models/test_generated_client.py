"""A client generated from the OpenAPI document, as other languages' are, uploads and matches."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from demo.stack import ROOT

PROGRAM = """
import sys
from pathlib import Path

from generated import Client
from generated.api.jobs import get_job, get_picture, get_result, list_jobs
from generated.api.matches import create_match
from generated.api.shapes import get_mesh, upload_shape
from generated.api.structures import list_structures
from generated.models import BodyUploadShape, DiffusionMetric, Job, JobPage, JobState
from generated.models import MatchRequest, MatchResult, Problem, Shape, Structures
from generated.types import File

url, *paths = sys.argv[1:]
with Client(base_url=url, timeout=300) as client:
    shapes = []
    for path in paths:
        with open(path, "rb") as mesh:
            body = BodyUploadShape(file=File(payload=mesh, file_name=Path(path).name))
            shape = upload_shape.sync(client=client, body=body)
        assert isinstance(shape, Shape), shape
        sent = get_mesh.sync_detailed(shape.id, client=client)
        assert sent.content == Path(path).read_bytes()
        shapes.append(shape)
    assert isinstance(list_structures.sync(client=client), Structures)

    request = MatchRequest(source=shapes[0].id, target=shapes[1].id, points=8)
    request.metric = DiffusionMetric(name="diffusion", time=0.02)
    job = create_match.sync(client=client, body=request)
    assert isinstance(job, Job), job
    while job.state not in (JobState.SUCCEEDED, JobState.FAILED):
        job = get_job.sync(job.id, client=client, wait=10)
        assert isinstance(job, Job), job
    match = get_result.sync(job.id, client=client)
    assert isinstance(match, MatchResult), match
    assert len({pair.source for pair in match.correspondences}) == 8
    assert match.lower_bound <= match.energy + 1e-9
    picture = get_picture.sync(job.id, client=client)
    assert picture.payload.read().startswith(b"\\x89PNG")
    listed = list_jobs.sync(client=client, state=JobState.SUCCEEDED)
    assert isinstance(listed, JobPage)
    assert job.id in [other.id for other in listed.items]

    request.points = 2
    refused = create_match.sync(client=client, body=request)
    assert isinstance(refused, Problem)
    assert [wrong.field for wrong in refused.errors] == ["body.points"]
    print(len(match.correspondences), refused.status)
"""


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package ``generated``."""
    folder = tmp_path_factory.mktemp("generated")
    here = Path(sys.executable).parent
    done = subprocess.run(
        [
            *(str(here / "openapi-python-client"), "generate", "--fail-on-warning"),
            *("--path", str(ROOT / "openapi" / "openapi.json"), "--meta", "none"),
            *("--output-path", str(folder / "generated")),
        ],
        env={**os.environ, "PATH": f"{here}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=500,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower()
    return folder


def test_it_uploads_and_matches(url: str, generated: Path, blobs: tuple[Path, Path]) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", PROGRAM, url, *map(str, blobs)],
        cwd=generated,
        capture_output=True,
        text=True,
        timeout=500,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "8 422\n"), done.stderr
