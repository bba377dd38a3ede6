"""Dense maps and landmarks, through the whole chain: in the numbers of the users' own files."""

import csv
import io

import httpx2
import numpy as np
import pytest

from tests.service.conftest import Json, Upload, problem
from tests.service.matching import matched
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.mesh_files import file_of


@pytest.fixture
def pair(upload: Upload) -> tuple[str, str]:
    """A blob and itself, turned and numbered anew."""
    mesh = shapes.blob(3)
    other, _ = shapes.permuted(shapes.moved(mesh, 4), seed=8)
    source, target = (upload(file_of(one), "m.ply")["id"] for one in (mesh, other))
    return source, target


TRUTH = shapes.permuted(shapes.blob(3), seed=8)[1]


def test_a_dense_map(http: httpx2.Client, pair: tuple[str, str]) -> None:
    job = matched(http, pair, points=12, dense=True)
    link = job["links"]["result"]
    found = http.get(link).json()["dense"]
    assert found["source"] == list(range(len(TRUTH)))
    np.testing.assert_array_equal(found["target"], TRUTH)
    assert found["hypothesis"] == 0
    assert found["inverse"]["target"] == list(range(len(TRUTH)))
    np.testing.assert_array_equal(TRUTH[found["inverse"]["source"]], np.arange(len(TRUTH)))
    arrays = np.load(io.BytesIO(http.get(link + ".npz").content), allow_pickle=False)
    np.testing.assert_array_equal(arrays["dense_target"], TRUTH)
    np.testing.assert_array_equal(TRUTH[arrays["inverse_source"]], arrays["inverse_target"])
    assert arrays["inverse_faces"].shape == arrays["inverse_barycentric"].shape == (len(TRUTH), 3)
    np.testing.assert_array_equal(arrays["target"], TRUTH[arrays["source"]])
    assert http.get(link + ".png").status_code == 200
    registered = [f"{job['links']['self']}/registered.{one}" for one in ("ply", "obj", "glb")]
    assert job["links"]["registered"] == registered
    assert http.get(registered[0]).content.startswith(b"ply")
    for query, sources, targets in (
        ({}, found["source"], found["target"]),
        ({"source": 1, "target": 0}, found["inverse"]["target"], found["inverse"]["source"]),
    ):
        table = http.get(job["links"]["map"], params=query)
        assert table.headers["content-type"].startswith("text/csv")
        header, *rows = csv.reader(io.StringIO(table.text))
        assert header == ["source", "target"]
        assert [[int(value) for value in row] for row in rows] == [
            [vertex, image] for vertex, image in zip(sources, targets, strict=True)
        ]
    for query, field in (({"target": 0}, "query.target"), ({"source": 2}, "query.source")):
        refused = problem(http.get(job["links"]["map"], params=query), 422, "invalid-request")
        assert refused["errors"][0]["field"] == field


def test_only_a_dense_match_has_a_table_of_its_map(
    http: httpx2.Client, pair: tuple[str, str]
) -> None:
    job = matched(http, pair, points=12)
    assert job["links"]["map"] is None
    assert job["links"]["registered"] == []
    problem(http.get(f"{job['links']['self']}/map.csv"), 409, "job-without-result")


def test_of_a_component_and_simplified(http: httpx2.Client, upload: Upload) -> None:
    mesh, small = shapes.blob(4), shapes.icosphere(0)
    before = small.n_vertices
    vertices = np.concatenate([small.vertices * 0.1 + 20.0, mesh.vertices])
    faces = np.concatenate([small.faces, mesh.faces + before])
    shape = upload(mesh_files.ply(vertices, faces.tolist()), "m.ply")["id"]
    options = {"points": 12, "dense": True, "largest_component": True, "simplify": 300}
    # Most vertices are simplified away: others stand for these.
    known = [[vertex, vertex] for vertex in range(before, before + 400, 100)]
    job = matched(http, (shape, shape), landmarks=known, **options)
    result = http.get(job["links"]["result"]).json()
    found = result["dense"]
    assert found["source"] == list(range(before, before + mesh.n_vertices))
    images = found["target"]
    assert len(set(images)) == 300
    assert all(images[image - before] == image for image in images)
    assert result["parameters"]["landmarks"] == known
    assert all(pair["source"] == pair["target"] for pair in result["correspondences"])
    assert http.get(job["links"]["result"] + ".png").status_code == 200


def test_landmarks(http: httpx2.Client, pair: tuple[str, str]) -> None:
    known = [[5, int(TRUTH[5])], [200, int(TRUTH[200])]]
    job = matched(http, pair, points=12, landmarks=known)
    result = http.get(job["links"]["result"]).json()
    pairs = [[one["source"], one["target"]] for one in result["correspondences"]]
    assert all(one in pairs for one in known)
    assert len(pairs) == 12


@pytest.mark.parametrize(
    ("landmarks", "options", "field"),
    [
        ([[1, 2], [1, 3]], {}, "body.landmarks"),
        ([[1]], {}, "body.landmarks.0"),
        ([[1, -2]], {}, "body.landmarks.0.1"),
        ([[1, 2.5]], {}, "body.landmarks.0.1"),
        ([[i, i] for i in range(9)], {"points": 8}, "body.landmarks"),
        ([[1, 2]], {"objective": "linf", "points": 8}, "body.landmarks"),
        ("all", {}, "body.landmarks"),
    ],
)
def test_landmarks_that_cannot_be(
    http: httpx2.Client, landmarks: object, options: Json, field: str
) -> None:
    asked = {"source": "a", "target": "b", "landmarks": landmarks, **options}
    answer = problem(http.post("/v1/matches", json=asked), 422, "invalid-request")
    assert field in [error["field"] for error in answer["errors"]]


def test_a_landmark_that_is_no_vertex(http: httpx2.Client, pair: tuple[str, str]) -> None:
    asked = {"source": pair[0], "target": pair[1], "points": 8, "landmarks": [[0, 0], [1, 99999]]}
    answer = problem(http.post("/v1/matches", json=asked), 422, "invalid-request")
    (error,) = answer["errors"]
    assert error["field"] == "body.landmarks.1.1"
    assert "99999 is no vertex of target" in error["message"]
