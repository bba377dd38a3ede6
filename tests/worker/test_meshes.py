"""Stored meshes come back as they were, and a spectrum's key says which mesh it is of."""

import numpy as np
import pytest

from solver.mesh import TriangleMesh, triangle_mesh
from tests.solver import damage, shapes
from tests.solver.test_damage import read
from worker.contracts import SpectrumKey
from worker.meshes import mesh_from_bytes, mesh_of, mesh_to_bytes

PAINTED = triangle_mesh(shapes.cube(3).vertices, shapes.cube(3).faces, shapes.cube(3).vertices)


@pytest.mark.parametrize(
    "mesh", [shapes.blob(2), PAINTED, read(damage.loose_faces(shapes.blob(3)))]
)
def test_stored_meshes_come_back(mesh: TriangleMesh) -> None:
    again = mesh_from_bytes(mesh_to_bytes(mesh))
    for field in ("vertices", "faces", "vertex_ids", "merged"):
        np.testing.assert_array_equal(getattr(again, field), getattr(mesh, field))
        assert getattr(again, field).dtype == getattr(mesh, field).dtype
    assert (again.colors is None) is (mesh.colors is None)
    np.testing.assert_array_equal(again.colors, mesh.colors)
    assert again.warnings == mesh.warnings


def test_the_mesh_that_a_key_names() -> None:
    both = shapes.two_components()
    assert mesh_of(SpectrumKey("a", 10), both) is both
    sphere = mesh_of(SpectrumKey("a", 10, largest_component=True), both)
    assert sphere.n_vertices == shapes.icosphere(2).n_vertices
    fewer = mesh_of(SpectrumKey("a", 10, largest_component=True, simplify=100), both)
    assert (fewer.n_vertices, fewer.components) == (100, 1)
    np.testing.assert_array_equal(fewer.vertices, both.vertices[fewer.vertex_ids])
