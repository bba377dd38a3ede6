"""Point clouds through the whole chain: points in, a map with a row for each point out."""

import io

import httpx2
import numpy as np

from tests.service.conftest import Upload, problem
from tests.service.matching import matched
from tests.solver import shapes
from tests.solver.mesh.mesh_files import file_of


def test_a_cloud_is_matched_with_its_mesh(http: httpx2.Client, upload: Upload) -> None:
    directions = np.random.default_rng(8).standard_normal((1200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = shapes.with_bumps(directions)
    lines = "\n".join(f"{x!r},{y!r},{z!r}" for x, y, z in points.tolist())
    cloud = upload(f"x,y,z\n{lines}\n".encode(), "points.csv")
    body = shapes.blob(3)
    mesh = upload(file_of(body), "body.ply")
    assert (cloud["kind"], cloud["file_type"]) == ("points", "csv")
    assert 1195 <= cloud["vertices"] <= cloud["file_vertices"] == 1200
    assert mesh["kind"] == "mesh"
    assert "was made of the points" in cloud["warnings"][0]
    job = matched(http, (cloud["id"], mesh["id"]), dense=True, points=12, eigenpairs=60)
    dense = http.get(job["links"]["result"]).json()["dense"]
    assert dense["source"] == list(range(1200))
    nearest = np.argmax(directions @ shapes.icosphere(3).vertices.T, axis=1)
    apart = np.linalg.norm(body.vertices[dense["target"]] - body.vertices[nearest], axis=1)
    assert np.mean(apart) / np.sqrt(body.area) < 0.03
    faces = io.BytesIO()
    np.savez(faces, part=np.arange(body.n_faces))
    files = {"file": ("part.npz", faces.getvalue())}
    attributes = http.post("/v1/attributes", files=files).json()["id"]
    asked = {"match": job["id"], "what": "labels", "direction": "target_to_source"}
    asked |= {"attributes": attributes}
    refused = http.post("/v1/transfers", json={**asked, "on": "faces"})
    assert problem(refused, 422, "invalid-request")["errors"] == [
        {
            "field": "body.on",
            "message": 'a point cloud has no faces that could take values; give "vertices"',
            "pointer": "/on",
        }
    ]
    for on, state in ((None, "failed"), ("vertices", "succeeded")):
        transfer = http.post("/v1/transfers", json={**asked, "on": on}).json()
        ended = http.get(transfer["links"]["self"], params={"wait": 60}).json()
        assert ended["state"] == state, ended["error"]
        if on is None:
            assert ended["error"]["errors"][0]["field"] == "body.on"


def test_points_in_a_volume_are_refused(http: httpx2.Client) -> None:
    points = np.random.default_rng(9).random((1000, 3))
    lines = "\n".join(f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist())
    files = {"file": ("points.xyz", f"{lines}\n".encode())}
    found = problem(http.post("/v1/shapes", files=files), 422, "unusable-mesh")
    assert "too sparse or too noisy" in found["detail"]
