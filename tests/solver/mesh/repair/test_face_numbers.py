"""Numbers of the file's faces survive repair: each triangle lies in the face that it names."""

from typing import Any

import numpy as np
import pytest
import trimesh

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, largest_component, read_mesh, simplified, triangle_mesh
from solver.mesh.formats import READERS
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.repair.damage import DISTORTING, HARMLESS, Damage, name_of, read

CLOSEST: Any = trimesh.triangles.closest_point
CUBE = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])


def centres(mesh: TriangleMesh) -> FloatArray:
    found: FloatArray = mesh.vertices[mesh.faces].mean(axis=1)
    return found


@pytest.mark.parametrize("cause", [*HARMLESS, *DISTORTING], ids=name_of)
def test_triangles_lie_in_the_faces_of_the_file_that_they_name(cause: Damage) -> None:
    damaged = cause(shapes.blob(3))
    mesh = read(damaged)
    raw = READERS["ply"](mesh_files.ply(damaged.vertices, damaged.faces))
    assert mesh.face_ids is not None
    assert raw.face_ids is not None
    assert mesh.file_rows == (len(damaged.vertices), len(damaged.faces))
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    centre = (centres(mesh) - low) / (high - low).max()
    # From the centre of each triangle, the nearest triangle that the face it names was cut into.
    apart = np.full(mesh.n_faces, np.inf)
    by_face = np.argsort(raw.face_ids, kind="stable")
    first, last = (
        np.searchsorted(raw.face_ids[by_face], mesh.face_ids, side=side)
        for side in ("left", "right")
    )
    for offset in range(int((last - first).max())):
        chosen = np.flatnonzero(first + offset < last)
        corners = raw.vertices[raw.faces[by_face[first[chosen] + offset]]]
        corners = (corners - low) / (high - low).max()
        nearest = CLOSEST(corners, centre[chosen])
        distance = np.linalg.norm(nearest - centre[chosen], axis=1)
        apart[chosen] = np.fmin(apart[chosen], distance)
    assert apart.max() < 1e-3


@pytest.mark.parametrize("file_type", ["off", "obj", "ply"])
def test_a_polygon_is_one_face(file_type: str) -> None:
    write = {"off": mesh_files.off, "obj": mesh_files.obj, "ply": mesh_files.ply}[file_type]
    mesh = read_mesh(write(CORNERS, CUBE), file_type)
    assert mesh.face_ids is not None
    assert mesh.file_rows == (8, 6)
    assert np.bincount(mesh.face_ids).tolist() == [2] * 6
    for triangle, face in zip(mesh.faces.tolist(), mesh.face_ids.tolist(), strict=True):
        assert set(triangle) <= set(CUBE[face])


@pytest.mark.parametrize("file_type", ["stl", "glb"])
def test_formats_without_polygons_number_their_triangles(file_type: str) -> None:
    blob = shapes.blob(1)
    write = {"stl": mesh_files.stl, "glb": mesh_files.glb}[file_type]
    mesh = read_mesh(write(blob.vertices, blob.faces), file_type)
    assert mesh.face_ids is not None
    np.testing.assert_array_equal(mesh.face_ids, np.arange(blob.n_faces))
    assert mesh.file_rows is not None
    assert mesh.file_rows[1] == blob.n_faces


def test_faces_that_are_dropped_leave_gaps() -> None:
    """Vertices that no face uses, and a last face without area, are rows of the file too."""
    blob = shapes.blob(1)
    vertices = np.concatenate([blob.vertices, blob.vertices[:1] + 9.0])
    faces = np.concatenate([[[0, 0, 1]], blob.faces, [[0, 1, 1]]])
    mesh = triangle_mesh(vertices, faces)
    assert mesh.face_ids is not None
    np.testing.assert_array_equal(mesh.face_ids, np.arange(1, blob.n_faces + 1))
    assert mesh.file_rows == (len(vertices), len(faces))


def test_parts_of_a_mesh_keep_the_numbers() -> None:
    both = shapes.two_components()
    whole = triangle_mesh(both.vertices, both.faces)
    part = largest_component(whole)
    fewer = simplified(part, 60)
    assert part.file_rows == fewer.file_rows == whole.file_rows
    assert part.face_ids is not None
    np.testing.assert_array_equal(
        part.vertices[part.faces], whole.vertices[whole.faces[part.face_ids]]
    )
    assert fewer.face_ids is not None
    assert set(fewer.face_ids) <= set(part.face_ids)
    assert len(fewer.face_ids) == fewer.n_faces
