"""Points between vertices, through the whole chain: in the numbers of the users' own files."""

from typing import Any

import httpx2
import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from tests.service.conftest import Json, Upload
from tests.service.matching import matched
from tests.solver import shapes
from tests.solver.mesh import mesh_files

REFINED = {"points": 8, "eigenpairs": 30, "refine": "gmds"}


def asked(http: httpx2.Client, pair: tuple[str, str], **parameters: object) -> tuple[Json, Any]:
    """The result of a refined match, and its link."""
    job = matched(http, pair, **(REFINED | parameters))
    link = job["links"]["result"]
    return http.get(link).json(), link


def points_of(result: Json) -> tuple[IntArray, IntArray, FloatArray]:
    """Source vertices, corners and weights; sound, and in the order of the pairs."""
    refined = result["refinement"]
    source, corners, weights = (
        np.array([point[name] for point in refined["points"]])
        for name in ("source", "vertices", "weights")
    )
    assert corners.shape == weights.shape == (len(result["correspondences"]), 3)
    assert source.tolist() == [pair["source"] for pair in result["correspondences"]]
    assert weights.min() >= 0.0
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    assert 0.0 <= refined["stress"] <= refined["initial_stress"]
    assert 0 <= refined["hypothesis"] <= len(result["alternatives"])
    return source, corners, weights


def test_of_several_components(http: httpx2.Client, upload: Upload) -> None:
    """The largest comes last, after vertices of no use to it: its numbers are not its file's."""
    mesh = shapes.blob(2)
    other, where = shapes.permuted(shapes.moved(mesh, 4), seed=8)
    small = shapes.icosphere(0)
    before = small.n_vertices
    files = []
    for one in (mesh, other):
        vertices = np.concatenate([small.vertices * 0.1 + 20.0, one.vertices])
        faces = np.concatenate([small.faces, one.faces + before])
        files.append((vertices, faces, mesh_files.ply(vertices, faces.tolist())))
    source, target = (upload(data, "m.ply")["id"] for _, _, data in files)
    result, link = asked(http, (source, target), largest_component=True)
    matched_vertices, corners, weights = points_of(result)
    vertices, faces, _ = files[1]
    assert {frozenset(three) for three in corners.tolist()} <= set(map(frozenset, faces.tolist()))
    places = np.einsum("nc,ncd->nd", weights, vertices[corners])
    truth = vertices[where[matched_vertices - before] + before]
    np.testing.assert_allclose(places, truth, atol=1e-3)
    assert http.get(link + ".png").status_code == 200


def test_of_simplified_shapes(http: httpx2.Client, upload: Upload) -> None:
    mesh = shapes.blob(3)
    other, where = shapes.permuted(shapes.moved(mesh, 4), seed=8)
    source, target = (upload(mesh_files.file_of(one), "m.ply")["id"] for one in (mesh, other))
    result, link = asked(http, (source, target), simplify=300)
    vertices, corners, weights = points_of(result)
    places = np.einsum("nc,ncd->nd", weights, other.vertices[corners])
    off = np.linalg.norm(places - other.vertices[where[vertices]], axis=1) / np.sqrt(mesh.area)
    assert off.mean() < 0.03
    assert http.get(link + ".png").status_code == 200


@pytest.mark.parametrize(
    "parameters",
    [
        {"objective": "linf", "points": 4},
        {"metric": "geodesic", "descriptor": "none", "normalise": False},
        {"occlusion_cost": 1e-9, "points": 3, "alternatives": 32},
        {"time_limit": 1e-6},
    ],
    ids=str,
)
def test_with_other_parameters(
    http: httpx2.Client, upload: Upload, parameters: dict[str, object]
) -> None:
    shape = upload(mesh_files.file_of(shapes.blob(1)), "m.ply")["id"]
    result, _ = asked(http, (shape, shape), **parameters)
    points_of(result)


def test_as_few_as_are_matched_are_refined(http: httpx2.Client, upload: Upload) -> None:
    """Of a sphere and a needle, all but a few distances differ by more than a partner is worth.

    The registration that refinement begins at does not depend on the matched points.
    """
    shapes_asked = [
        upload(mesh_files.file_of(mesh), "m.ply")["id"] for mesh in (shapes.blob(1), shapes.tube())
    ]
    parameters = {"metric": "geodesic", "descriptor": "none", "occlusion_cost": 1e-3, "points": 3}
    result, _ = asked(http, (shapes_asked[0], shapes_asked[1]), **parameters)
    assert len(result["correspondences"]) < 3
    assert len(result["refinement"]["points"]) == len(result["correspondences"])


def test_there_is_no_refinement_unless_requested(http: httpx2.Client, upload: Upload) -> None:
    shape = upload(mesh_files.file_of(shapes.blob(1)), "m.ply")["id"]
    result, _ = asked(http, (shape, shape), refine=None)
    assert result["refinement"] is None
