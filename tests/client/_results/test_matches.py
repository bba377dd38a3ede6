"""Matches on the running service: from the call to the arrays."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import isomatch
import numpy as np
import pytest

from tests.client.shapes import LASTING, blob_meshes, moved

Pair = tuple[isomatch.Shape, isomatch.Shape]


def test_a_match_comes_back_as_arrays(client: isomatch.Client, pair: Pair, tmp_path: Path) -> None:
    job = client.match(*pair, points=8, coarse_points=6)
    assert (job.kind, job.position is None or job.position >= 0) == ("match", True)
    match = job.result()
    assert (job.state, job.finished, job.error) == ("succeeded", True, None)
    assert job.started is not None
    assert job.ended is not None
    assert job.created <= job.started <= job.ended

    assert (match.source, match.target) == (pair[0].id, pair[1].id)
    assert (match.parameters["points"], match.parameters["rho"]) == (8, 1.5)
    assert match.pairs.shape == (8, 2)
    assert match.pairs.dtype == np.int64
    assert match.costs.shape == (8,)
    assert match.costs.dtype == np.float64
    assert len(np.unique(match.pairs[:, 0])) == len(np.unique(match.pairs[:, 1])) == 8
    assert match.pairs.min() >= 0
    assert match.pairs[:, 0].max() < pair[0].vertices
    assert match.pairs[:, 1].max() < pair[1].vertices
    assert match.lower_bound <= match.energy + 1e-9
    assert match.levels[0].certified
    assert len(match.unmatched_vertices) == 0
    for alternative in match.alternatives:
        assert alternative.pairs.shape == (8, 2)

    assert repr(match) == str(match)
    assert match.confidence is not None
    assert repr(match).startswith(f"<Match of 8 points, {match.confidence}, energy ")

    match.save(tmp_path / "match.json")
    saved = (tmp_path / "match.json").read_bytes()
    assert isomatch.Match.from_json(saved) == match
    assert json.loads(saved)["distortion"]["linf"] == match.distortion.linf
    job.save_picture(tmp_path / "match.png")
    assert (tmp_path / "match.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    for write in (match.save, job.save):
        write(tmp_path / "document")
        assert (tmp_path / "document").read_bytes() == saved
    for save, wrong, message in (
        (match.save, "match.csv", r"not held as \.csv: give \.json, or use job\.save"),
        (job.save_picture, "match.jpg", "'jpg' is none of png"),
        (job.save_arrays, "match.mat", "'mat' is none of npz"),
    ):
        with pytest.raises(ValueError, match=message):
            save(tmp_path / wrong)
        assert not (tmp_path / wrong).exists()


def test_refined_points(client: isomatch.Client, pair: Pair, blobs: tuple[Path, Path]) -> None:
    job = client.match(*pair, points=16, refine="gmds")
    match = job.result()
    refined = match.refinement
    assert refined is not None
    np.testing.assert_array_equal(refined.source_vertices, match.pairs[:, 0])
    assert refined.refined_vertices.shape == refined.refined_weights.shape == (16, 3)
    assert refined.refined_vertices.dtype == np.int64
    assert refined.refined_weights.min() >= 0.0
    np.testing.assert_allclose(refined.refined_weights.sum(axis=1), 1.0, atol=1e-12)
    assert 0.0 <= refined.stress <= refined.initial_stress

    first, second = blob_meshes()
    truth = moved(first.vertices)[match.pairs[:, 0]]
    before = np.linalg.norm(second.vertices[match.pairs[:, 1]] - truth, axis=1)
    places = refined.refined_positions(second.vertices)
    after = np.linalg.norm(places - truth, axis=1)
    assert after.mean() < 0.6 * before.mean()
    assert isomatch.Match.from_json(match.to_json()) == match
    assert job.picture() != client.match(*pair, points=16).wait().picture()
    for wrong in (second.vertices[:3], second.vertices[:, :2]):
        with pytest.raises(ValueError, match="vertices"):
            refined.refined_positions(wrong)


def test_progress_is_printed(
    client: isomatch.Client, pair: Pair, capsys: pytest.CaptureFixture[str]
) -> None:
    job = client.match(*pair, points=6, orientation=False, rho=1.9)
    match = job.result(progress=True)
    said = capsys.readouterr()
    assert said.out == ""
    assert f"100%  match {job.id[:8]}: succeeded" in said.err
    assert "\n" not in "".join(map(str, (match, *match.alternatives)))


def test_jobs_at_once_have_named_bars(
    client: isomatch.Client,
    pair: Pair,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    jobs = [client.match(*pair, points=6, coarse_points=6, rho=rho) for rho in (1.81, 1.82)]
    with ThreadPoolExecutor(len(jobs)) as threads:
        list(threads.map(lambda job: job.result(progress=True), jobs))
    said = capsys.readouterr().err
    for job in jobs:
        assert f"match {job.id[:8]}: " in said


def test_parameters_are_sent(client: isomatch.Client, pair: Pair) -> None:
    match = client.match(
        pair[0].id,
        pair[1].id,
        points=np.int64(6),  # type: ignore[arg-type]  # fit for an int all the same
        coarse_points=6,
        metric=[{"name": "diffusion", "time": 0.01}],
        descriptor="none",
        orientation=False,
        alternatives=1,
    ).result()
    assert match.distortion.first_order is None
    assert match.parameters["metric"] == [{"name": "diffusion", "time": 0.01}]
    assert [level.metric for level in match.levels] == ["diffusion"]


def test_jobs_are_found_again(client: isomatch.Client, pair: Pair) -> None:
    job = client.match(*pair, points=6, orientation=False).wait()
    found = client.job(job.id)
    assert (found.id, found.state) == (job.id, "succeeded")
    assert found.result() == job.result()
    assert job.id in {other.id for other in client.jobs(state="succeeded")}
    assert job.id not in {other.id for other in client.jobs(state="failed")}
    assert repr(found) == f"<Job {job.id} succeeded>"


def test_a_cancelled_job_has_no_result(client: isomatch.Client, pair: Pair) -> None:
    jobs = [client.match(*pair, **LASTING, beta=1.0 + i) for i in range(4)]
    last = jobs[-1].cancel()
    last.wait(timeout=240)
    assert last.state == "cancelled"
    with pytest.raises(isomatch.JobCancelled, match=last.id):
        last.result()
    for job in jobs:
        job.cancel()
        assert job.wait(timeout=240).finished


def test_a_timeout_leaves_the_job_running(client: isomatch.Client, pair: Pair) -> None:
    job = client.match(*pair, **LASTING, rho=1.9)
    with pytest.raises(isomatch.WaitTimeout, match="it continues"):
        job.result(timeout=0.0)
    with pytest.raises(TimeoutError):
        job.wait(timeout=0.01)
    assert job.refresh().state in ("queued", "running", "succeeded")
    job.cancel()
    job.wait(timeout=240)


def test_a_failed_job_has_a_problem(client: isomatch.Client, pair: Pair) -> None:
    # That all distances vanish is found out when they are computed.
    job = client.match(*pair, points=6, metric=[{"name": "diffusion", "time": 1e9}])
    job.wait(timeout=240)
    assert job.state == "failed"
    assert job.error is not None
    with pytest.raises(isomatch.JobFailed) as failure:
        job.result()
    assert failure.value.problem == job.error
    assert job.error.detail is not None
    assert job.error.detail in str(failure.value)
