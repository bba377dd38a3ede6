"""Consistent maps through the whole chain: shapes in, maps between all of them out."""

import io
from itertools import combinations

import httpx2
import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import triangle_mesh
from tests.service.batches.test_batches import SLOW, awaited, batch
from tests.service.conftest import Json, Upload, problem
from tests.service.registrations.test_registrations import (
    PLACES,
    TEMPLATE,
    ended,
    too_coarse,
)
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.worker.figures import blob_file

PATH = "/v1/consistent-maps"

UNUSED = (50.0, 50.0, 50.0)


@pytest.fixture(scope="module")
def given(upload: Upload) -> tuple[list[str], list[FloatArray]]:
    """Ids and vertices of a shape of too few vertices, and of moved copies of one shape.

    The file of each copy ends with a vertex that no face uses.
    """
    ids = [upload(too_coarse(), "coarse.ply")["id"]]
    vertices = [np.empty((0, 3))]
    for seed, places in enumerate(PLACES):
        other, _ = shapes.permuted(triangle_mesh(places, TEMPLATE.faces), seed=seed + 60)
        data = mesh_files.ply(np.vstack([other.vertices, UNUSED]), other.faces.tolist(), "ascii")
        ids.append(upload(data, f"copy{seed}.ply")["id"])
        vertices.append(other.vertices)
    return ids, vertices


@pytest.fixture(scope="module")
def job(http: httpx2.Client, given: tuple[list[str], list[FloatArray]]) -> Json:
    found = ended(http, http.post(PATH, json={"shapes": given[0]}))
    assert found["state"] == "succeeded", found
    return found


@pytest.fixture(scope="module")
def result(http: httpx2.Client, job: Json) -> Json:
    found: Json = http.get(job["links"]["result"]).json()
    return found


def test_all_pairs_are_reported_and_a_shape_that_cannot_be_mapped_is_named(
    result: Json, given: tuple[list[str], list[FloatArray]]
) -> None:
    ids, _ = given
    pairs = list(combinations(range(len(ids)), 2))
    assert [(one["source"], one["target"]) for one in result["pairs"]] == [
        (ids[i], ids[j]) for i, j in pairs
    ]
    assert [one["name"] for one in result["shapes"]] == [
        "coarse.ply", "copy0.ply", "copy1.ply", "copy2.ply"
    ]  # fmt: skip
    assert [one["fits"] for one in result["shapes"]] == [False, True, True, True]
    assert result["shapes"][0]["reason"] is not None
    assert result["shapes"][0]["cycle_error"] is None
    for (i, _), one in zip(pairs, result["pairs"], strict=True):
        assert one["mapped"] == one["fits"] == (i > 0)
        if i > 0:
            assert one["confidence"]["probability"] > 0.9
            assert one["cycle_error"] <= one["cycle_error_before"] < 0.05
        else:
            assert "could not be registered" in one["reason"]
            assert one["confidence"] is None


def test_arrays_are_the_true_maps_of_the_pairs(
    http: httpx2.Client, job: Json, result: Json, given: tuple[list[str], list[FloatArray]]
) -> None:
    ids, vertices = given
    with np.load(io.BytesIO(http.get(job["links"]["arrays"]).content)) as arrays:
        found = dict(arrays)
    assert result["job"] == job["id"]
    table = http.get(job["links"]["map"], params={"source": 2, "target": 1})
    rows = np.loadtxt(io.StringIO(table.text), dtype=int, delimiter=",", skiprows=1)
    vertex = np.flatnonzero(found["map_2_1"] >= 0)
    np.testing.assert_array_equal(rows, np.column_stack([vertex, found["map_2_1"][vertex]]))
    # The first shape could not be mapped.
    refused = problem(http.get(job["links"]["map"]), 409, "job-without-result")
    assert "registered" in refused["detail"]
    assert found.pop("shapes").tolist() == ids
    mapped = [
        pair
        for pair, one in zip(combinations(range(4), 2), result["pairs"], strict=True)
        if one["mapped"]
    ]
    assert set(found) == {f"map_{i}_{j}" for one in mapped for i, j in (one, one[::-1])}
    for i, j in mapped:
        # Distances to the centre are the same on all copies, but for their size.
        here, there = (
            np.linalg.norm(one - one.mean(axis=0), axis=1)
            / np.sqrt(np.mean((one - one.mean(axis=0)) ** 2))
            for one in (vertices[i], vertices[j])
        )
        assert (found[f"map_{i}_{j}"][-1], found[f"map_{j}_{i}"][-1]) == (-1, -1)
        np.testing.assert_allclose(here, there[found[f"map_{i}_{j}"][:-1]], atol=0.15)
        np.testing.assert_allclose(there, here[found[f"map_{j}_{i}"][:-1]], atol=0.15)


def test_there_are_no_pictures_or_other_files(http: httpx2.Client, job: Json) -> None:
    assert job["links"]["picture"] is None
    assert job["links"]["exports"] == []
    problem(http.get(f"/v1/jobs/{job['id']}/result.png"), 409, "job-without-result")


def test_unknown_and_repeated_shapes_are_refused(
    http: httpx2.Client, given: tuple[list[str], list[FloatArray]]
) -> None:
    ids, _ = given
    wrong = problem(http.post(PATH, json={"shapes": [ids[1], ids[1]]}), 422, "invalid-request")
    assert wrong["errors"][0]["field"] == "body.shapes.1"
    problem(http.post(PATH, json={"shapes": [ids[1], "0" * 32]}), 422, "unknown-shape")
    problem(http.post(PATH, json={"shapes": ids[:1]}), 422, "invalid-request")
    body = {"shapes": ids, "names": ["one"]}
    wrong = problem(http.post(PATH, json=body), 422, "invalid-request")
    assert wrong["errors"][0]["field"] == "body.names"


def test_a_collection_without_any_map_fails_with_the_reason(
    http: httpx2.Client, given: tuple[list[str], list[FloatArray]]
) -> None:
    ids, _ = given
    found = ended(http, http.post(PATH, json={"shapes": ids[:2]}))
    assert found["state"] == "failed"
    assert "could not be registered" in str(found["error"])


def test_cancelled_consistent_maps_end(
    http: httpx2.Client, given: tuple[list[str], list[FloatArray]]
) -> None:
    queued = http.post(PATH, json={"shapes": given[0], "largest_component": True})
    http.delete(f"/v1/jobs/{queued.json()['id']}")
    assert ended(http, queued)["state"] == "cancelled"


def test_shapes_deleted_before_a_job_runs_are_named_and_other_jobs_go_on(
    http: httpx2.Client, given: tuple[list[str], list[FloatArray]], upload: Upload
) -> None:
    ids, _ = given
    gone = [upload(blob_file(2, seed=seed))["id"] for seed in (70, 71)]
    lasting = [upload(blob_file(4, seed=seed))["id"] for seed in (72, 73, 74)]
    # Both workers are busy, so that the collections are not begun when their shapes are deleted.
    busy = batch(http, {"source": lasting[0], "targets": lasting[1:], **SLOW})
    awaited(http, busy, lambda now: [one.state for one in now.matches] == ["running"] * 2)
    asked = [[*gone, ids[1]], [gone[0], *ids[1:3]], ids[1:3]]
    failing, partial, other = [http.post(PATH, json={"shapes": shapes}) for shapes in asked]
    for shape in gone:
        assert http.delete(f"/v1/shapes/{shape}").status_code == 204
    http.delete(busy["links"]["self"])
    failed = ended(http, failing)
    assert failed["state"] == "failed"
    assert failed["error"]["type"].endswith("shape-deleted")
    assert gone[0] in failed["error"]["detail"]
    problem(http.get(f"/v1/jobs/{failed['id']}/result"), 409, "job-without-result")
    partly = ended(http, partial)
    assert partly["state"] == "succeeded", partly
    found = http.get(partly["links"]["result"]).json()
    assert [one["fits"] for one in found["shapes"]] == [False, True, True]
    assert "was deleted" in found["shapes"][0]["reason"]
    assert [one["mapped"] for one in found["pairs"]] == [False, False, True]
    assert ended(http, other)["state"] == "succeeded"
