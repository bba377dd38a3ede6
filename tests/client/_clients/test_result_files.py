"""Requests for results and their files."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx2
import isomatch
import pytest
from isomatch._cli.job_runs import finish
from isomatch._models import JobRecord
from isomatch._operations import results

from service.http.openapi.examples import EXAMPLES

JOB: dict[str, Any] = {
    "id": "0" * 32,
    "created": "2026-01-01T00:00:00Z",
    "state": "succeeded",
    "progress": {"stage": "finished", "fraction": 1.0},
    "started": None,
    "ended": None,
    "position": None,
    "error": None,
    "caller": None,
    "webhook": None,
}


class Service:
    """A job that has ended, its result and its arrays, which take some attempts to get."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.requests: list[str] = []
        self.broken = 0
        self.document = json.dumps(EXAMPLES["answers"]["get_result"]["200"].get(kind, {}))

    def __call__(self, request: httpx2.Request) -> httpx2.Response:
        name = request.url.path.rpartition("/")[2]
        self.requests.append(name)
        if name == "result":
            return httpx2.Response(200, text=self.document)
        if name == "result.npz" and self.broken > 0:
            self.broken -= 1
            raise httpx2.ConnectError("away", request=request)
        if name == "result.npz":
            return httpx2.Response(200, content=b"arrays")
        return httpx2.Response(200, json=JOB | {"kind": self.kind})

    def job(self) -> isomatch.Job:
        transport = httpx2.MockTransport(self)
        job: isomatch.Job = isomatch.Client("http://a.test", transport=transport).job("0" * 32)
        self.requests.clear()
        return job


ARRAYS = pytest.mark.parametrize("kind", ["registration", "consistent_maps"])


@ARRAYS
def test_a_document_is_saved_without_the_arrays(kind: str, tmp_path: Path) -> None:
    service = Service(kind)
    service.job().save(tmp_path / "found.json")
    assert service.requests == ["result"]
    assert (tmp_path / "found.json").read_text() == service.document


@ARRAYS
def test_a_result_with_arrays_outlasts_a_restart(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time, "sleep", lambda _: None)
    service = Service(kind)
    service.broken = 10
    assert service.job().result()._archive == b"arrays"


@ARRAYS
def test_an_outage_before_the_arrays_names_the_job(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time, "sleep", lambda _: None)
    monkeypatch.setattr(results, "LONGEST_OUTAGE", 0.0)
    service = Service(kind)
    service.broken = 10
    job = service.job()
    with pytest.raises(isomatch.ConnectionFailed, match=f"job {job.id} has succeeded") as failure:
        job.result()
    assert failure.value.job_id == job.id


@ARRAYS
@pytest.mark.parametrize("ending", ["json", "npz"])
def test_the_command_requests_each_file_once(kind: str, ending: str, tmp_path: Path) -> None:
    service = Service(kind)
    finish(service.job(), True, tmp_path / f"found.{ending}", None)
    assert service.requests == ["result", "result.npz"]
    written = {"json": service.document.encode(), "npz": b"arrays"}
    assert (tmp_path / f"found.{ending}").read_bytes() == written[ending]


@pytest.mark.parametrize("ending", results.ENDINGS)
@pytest.mark.parametrize(
    ("state", "kind"), [("failed", isomatch.JobFailed), ("cancelled", isomatch.JobCancelled)]
)
def test_a_job_without_a_result_is_not_saved(
    state: str, kind: type[isomatch.IsomatchError], ending: str, tmp_path: Path
) -> None:
    service = Service("match")
    record = JobRecord.model_validate(JOB | {"kind": "match", "state": state})
    job = isomatch.Job(service.job()._transport, record)
    with pytest.raises(kind):
        job.save(tmp_path / f"found.{ending}")
    assert service.requests == []


def test_a_missing_folder_is_noticed_before_anything_is_requested(tmp_path: Path) -> None:
    service = Service("registration")
    job, folder = service.job(), tmp_path / "no"
    calls: list[tuple[Callable[[Path], None], str]] = [
        (job.save, "npz"),
        (job.save, "json"),
        (job.save_arrays, "npz"),
        (job.save_picture, "png"),
        (job.save_registered, "ply"),
    ]
    for save, ending in calls:
        with pytest.raises(FileNotFoundError, match=folder.name):
            save(folder / f"found.{ending}")
    assert service.requests == []


def test_a_result_of_an_unknown_kind_is_named() -> None:
    with pytest.raises(isomatch.UnexpectedResponse, match="kind 'morph', which this version"):
        Service("morph").job().result()
