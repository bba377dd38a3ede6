"""Batches over HTTP: run, looked at on the way, cancelled, and matches that fail."""

import io
from collections.abc import Callable
from typing import Any

import httpx2
import numpy as np
import pytest

from broker.contracts import BatchResult, JobState
from service.batches.schemas import BatchProgress
from tests.service.conftest import Api, Json, Upload, problem
from tests.waiting import until
from tests.worker.figures import blob_file

QUICK: dict[str, Any] = {"points": 8, "eigenpairs": 40}
SLOW: dict[str, Any] = {"points": 256, "alternatives": 32, "coarse_points": 10}
"""Parameters of matches that last until they are cancelled."""


def batch(http: httpx2.Client, body: Json) -> Json:
    asked = http.post("/v1/batches", json=body)
    assert asked.status_code == 202, asked.text
    assert asked.headers["location"] == asked.json()["links"]["self"]
    job: Json = asked.json()
    return job


def progress(http: httpx2.Client, job: Json) -> BatchProgress:
    answer = http.get(job["links"]["partial"])
    assert answer.status_code == 200, answer.text
    return BatchProgress.model_validate_json(answer.content)


def awaited(http: httpx2.Client, job: Json, met: Callable[[BatchProgress], bool]) -> BatchProgress:
    def found() -> BatchProgress | None:
        seen = progress(http, job)
        return seen if met(seen) else None

    return until(found, pause=0.05)


def ended(http: httpx2.Client, job: Json) -> Json:
    found: Json = http.get(job["links"]["self"], params={"wait": 60}).json()
    return found


def test_every_match_of_a_batch_is_a_match(http: httpx2.Client, upload: Upload) -> None:
    source = upload(blob_file())["id"]
    targets = [upload(blob_file(seed=seed))["id"] for seed in (1, 2, 3)]
    body = {"source": source, "targets": targets, "dense": True, **QUICK}
    named = {"source_name": "template", "target_names": ["one", None, "three"]}
    job = batch(http, body | named)
    assert (job["kind"], job["source"], job["shapes"]) == ("batch", source, [source, *targets])
    assert ended(http, job)["state"] == JobState.SUCCEEDED
    assert job["links"]["arrays"] is None
    problem(http.get(f"/v1/jobs/{job['id']}/result.npz"), 409, "job-without-result")
    result = BatchResult.model_validate_json(http.get(job["links"]["result"]).content)
    assert result.succeeded == 3
    assert [one.target for one in result.matches] == targets
    found_names = [one.target_name for one in result.matches]
    assert (result.source_name, found_names) == ("template", ["one", "mesh.off", "three"])
    assert progress(http, job).matches == result.matches
    alone = http.post("/v1/matches", json={"source": source, "target": targets[0], **QUICK})
    single = http.get(alone.json()["links"]["self"], params={"wait": 60}).json()
    expected = http.get(single["links"]["result"]).json()
    for place, match in enumerate(result.matches):
        record = http.get(f"/v1/jobs/{match.job}").json()
        assert (record["kind"], record["batch"]) == ("match", job["id"])
        found = http.get(record["links"]["result"]).json()
        assert found["target"] == targets[place]
        assert (found["source_name"], found["target_name"]) == (
            "template",
            named["target_names"][place] or "mesh.off",
        )
        assert match.summary is not None
        assert match.summary.energy == found["energy"]
        assert match.summary.dense
        if place == 0:
            assert found["correspondences"] == expected["correspondences"]
    path = f"/v1/jobs/{result.matches[0].job}"
    with np.load(io.BytesIO(http.get(f"{path}/result.npz").content)) as arrays:
        assert len(arrays["dense_source"]) == 642
    assert http.get(f"{path}/result.ply").content.startswith(b"ply")
    body = {"match": result.matches[1].job, "what": "landmarks", "points": [3]}
    carried = http.post("/v1/transfers", json=body).json()
    assert ended(http, carried)["state"] == JobState.SUCCEEDED
    listed = http.get("/v1/jobs", params={"kind": "batch"}).json()["items"]
    assert job["id"] in [one["id"] for one in listed]
    assert result.matches[0].job not in [
        one["id"] for one in http.get("/v1/jobs", params={"limit": 100}).json()["items"]
    ]


def test_names_are_those_that_shapes_are_stored_under(http: httpx2.Client, upload: Upload) -> None:
    source = upload(blob_file(), "template.off")["id"]
    target = upload(blob_file(seed=1), "specimen.off")["id"]
    job = batch(http, {"source": source, "targets": [target], **QUICK})
    assert ended(http, job)["state"] == JobState.SUCCEEDED
    assert job["links"]["arrays"] is None
    problem(http.get(f"/v1/jobs/{job['id']}/result.npz"), 409, "job-without-result")
    result = BatchResult.model_validate_json(http.get(job["links"]["result"]).content)
    for found in (result, progress(http, job)):
        names = found.source_name, found.matches[0].target_name
        assert names == (stored_name(http, source), stored_name(http, target))


def stored_name(http: httpx2.Client, shape: str) -> str:
    name: str = http.get(f"/v1/shapes/{shape}").json()["name"]
    return name


def test_matches_that_fail_are_named_and_the_others_go_on(
    http: httpx2.Client, upload: Upload
) -> None:
    source = upload(blob_file(4))["id"]
    lasting = [upload(blob_file(4, seed=seed))["id"] for seed in (21, 22)]
    deleted = upload(blob_file(4, seed=23))["id"]
    job = batch(http, {"source": source, "targets": [*lasting, deleted], **SLOW})
    # Both workers are busy, so that the third match is not queued when its shape is deleted.
    running = awaited(http, job, lambda now: all(one.state == "running" for one in now.matches[:2]))
    assert running.matches[2].state == JobState.QUEUED
    problem(http.get(job["links"]["result"]), 409, "result-not-ready")
    assert http.delete(f"/v1/shapes/{deleted}").status_code == 204
    for match in running.matches[:2]:
        http.delete(f"/v1/jobs/{match.job}")
    assert ended(http, job)["state"] == JobState.SUCCEEDED
    assert job["links"]["arrays"] is None
    problem(http.get(f"/v1/jobs/{job['id']}/result.npz"), 409, "job-without-result")
    result = BatchResult.model_validate_json(http.get(job["links"]["result"]).content)
    assert [one.state for one in result.matches] == ["cancelled", "cancelled", "failed"]
    error = result.matches[2].error
    assert error is not None
    assert error.slug == "shape-deleted"
    assert result.succeeded == 0


def test_a_match_that_waits_is_a_job_that_can_be_cancelled(
    http: httpx2.Client, upload: Upload
) -> None:
    source = upload(blob_file(4))["id"]
    targets = [upload(blob_file(4, seed=seed))["id"] for seed in (21, 22, 24, 25)]
    job = batch(http, {"source": source, "targets": targets, **SLOW})
    known = awaited(http, job, lambda now: all(one.state == "running" for one in now.matches[:2]))
    names = [one.job for one in known.matches]
    assert names == [f"{job['id']}-{number}" for number in (1, 2, 3, 4)]
    waiting = http.get(f"/v1/jobs/{names[3]}").json()
    found = [waiting[name] for name in ("state", "batch", "target", "position", "waiting_for")]
    assert found == ["queued", job["id"], targets[3], None, "turn"]
    assert http.get(f"/v1/jobs/{names[3]}", params={"wait": 0.5}).json() == waiting
    problem(http.get(waiting["links"]["result"]), 409, "result-not-ready")
    for unknown in ("0", "04", "5", "x", "1-1"):
        problem(http.delete(f"/v1/jobs/{job['id']}-{unknown}"), 404, "job-not-found")
    cancelled = http.delete(f"/v1/jobs/{names[3]}").json()
    assert cancelled["state"] == JobState.CANCELLED
    assert ended(http, cancelled) == cancelled
    after = progress(http, job)
    assert [one.state for one in after.matches] == ["running", "running", "queued", "cancelled"]
    # The third has its turn, the fourth none.
    http.delete(f"/v1/jobs/{names[0]}")
    awaited(http, job, lambda now: now.matches[2].state == "running")
    http.delete(f"/v1/jobs/{names[1]}")
    awaited(http, job, lambda now: now.matches[1].state == "cancelled")
    assert progress(http, job).state == JobState.RUNNING
    http.delete(f"/v1/jobs/{names[2]}")
    assert ended(http, job)["state"] == JobState.SUCCEEDED
    result = BatchResult.model_validate_json(http.get(job["links"]["result"]).content)
    assert [one.state for one in result.matches] == ["cancelled"] * 4


def test_a_cancelled_batch_ends_with_all_its_matches(
    http: httpx2.Client, api: Api, upload: Upload
) -> None:
    source = upload(blob_file(4))["id"]
    targets = [upload(blob_file(4, seed=seed))["id"] for seed in (21, 22, 24)]
    job = batch(http, {"source": source, "targets": targets, **SLOW})
    awaited(http, job, lambda now: "running" in [one.state for one in now.matches])
    cancelled = http.delete(job["links"]["self"]).json()
    assert cancelled["state"] == JobState.CANCELLED
    last = awaited(http, job, lambda now: now.ended == 3)
    assert {one.state for one in last.matches} == {JobState.CANCELLED}
    assert http.get(f"/v1/jobs/{last.matches[2].job}").json()["state"] == JobState.CANCELLED
    problem(http.get(job["links"]["result"]), 409, "job-without-result")


@pytest.mark.parametrize(
    ("change", "field", "word"),
    [
        ({"targets": []}, "body.targets", "at least 1"),
        ({"targets": ["a"] * 1001}, "body.targets", "at most 1000"),
        ({"target_names": ["a", "b"]}, "body.target_names", "name for each target"),
        ({"target_names": ["a\n"]}, "body.target_names.0", "one line"),
        ({"points": 2}, "body.points", "greater than or equal"),
        ({"target": "a"}, "body.target", "no such field"),
    ],
)
def test_wrong_requests(
    http: httpx2.Client, shapes: tuple[str, str], change: Json, field: str, word: str
) -> None:
    body = {"source": shapes[0], "targets": [shapes[1]], **change}
    refused = problem(http.post("/v1/batches", json=body), 422, "invalid-request")
    assert refused["errors"][0]["field"] == field
    assert word in refused["errors"][0]["message"]


def test_targets_that_cannot_be_matched(http: httpx2.Client, shapes: tuple[str, str]) -> None:
    body = {"source": shapes[0], "targets": [shapes[1]], "points": 200, "simplify": 199}
    refused = problem(http.post("/v1/batches", json=body), 422, "invalid-request")
    assert [one["field"] for one in refused["errors"]] == ["body.simplify"]
    unknown = http.post("/v1/batches", json={"source": shapes[0], "targets": ["nobody"]})
    refused = problem(unknown, 422, "unknown-shape")
    assert [one["field"] for one in refused["errors"]] == ["body.targets.0"]


def test_a_match_is_no_batch(http: httpx2.Client, shapes: tuple[str, str]) -> None:
    body = {"source": shapes[0], "target": shapes[1], **QUICK}
    job = http.post("/v1/matches", json=body).json()
    problem(http.get(f"/v1/batches/{job['id']}"), 409, "job-without-result")
    problem(http.get("/v1/batches/nobody"), 404, "job-not-found")
    http.get(job["links"]["self"], params={"wait": 60})
