"""Stored meshes, and the meshes that spectrum keys name."""

import numpy as np
import pytest

from broker.contracts import SpectrumKey, ValidationPayload
from broker.queue import JobQueue, QueueSettings
from broker.store import Store
from solver.mesh import TriangleMesh, read_mesh, triangle_mesh
from tests.solver import shapes
from tests.solver.mesh.repair.damage import read, seams
from tests.worker.records import shape_record
from worker.jobs import mesh_from_bytes, mesh_to_bytes
from worker.jobs.failures import ShapeGone
from worker.jobs.meshes import mesh_of

PAINTED = triangle_mesh(shapes.cube(3).vertices, shapes.cube(3).faces, shapes.cube(3).vertices)


CLOUD = read_mesh("\n".join(f"{x} {y} {z}" for x, y, z in shapes.blob(3).vertices).encode(), "xyz")
DAMAGED = read(seams.loose_faces(shapes.blob(3)))


@pytest.mark.parametrize("mesh", [shapes.blob(2), PAINTED, CLOUD, DAMAGED])
def test_stored_meshes_are_read_back(mesh: TriangleMesh) -> None:
    again = mesh_from_bytes(mesh_to_bytes(mesh))
    assert again.file_rows == mesh.file_rows
    assert (again.face_ids is None) is (mesh.face_ids is None)
    fields = ("vertices", "faces", "vertex_ids", "merged")
    for field in fields if mesh.face_ids is None else (*fields, "face_ids"):
        np.testing.assert_array_equal(getattr(again, field), getattr(mesh, field))
        assert getattr(again, field).dtype == getattr(mesh, field).dtype
    assert (again.colors is None) is (mesh.colors is None)
    np.testing.assert_array_equal(again.colors, mesh.colors)
    assert again.warnings == mesh.warnings
    assert again.is_cloud is mesh.is_cloud


def put(store: Store, shape: str, mesh: TriangleMesh) -> TriangleMesh:
    """Store a shape."""
    payload = ValidationPayload(shape=shape, name="x", file_type="off")
    job = JobQueue(store, QueueSettings()).submit_validation(payload, b"data")
    record = shape_record(shape)
    store.shapes.accept(record, b"data", mesh_to_bytes(mesh), b"geometry", job)
    return mesh


def test_the_mesh_that_a_key_names(store: Store) -> None:
    both = put(store, "a", shapes.two_components())
    whole = mesh_of(SpectrumKey("a", 10), "a", store)
    np.testing.assert_array_equal(whole.vertices, both.vertices)
    sphere = mesh_of(SpectrumKey("a", 10, largest_component=True), "a", store)
    assert sphere.n_vertices == shapes.icosphere(2).n_vertices
    key = SpectrumKey("a", 10, largest_component=True, simplify=100)
    fewer = mesh_of(key, "a", store)
    assert (fewer.n_vertices, fewer.components) == (100, 1)
    np.testing.assert_array_equal(fewer.vertices, both.vertices[fewer.vertex_ids])


def test_a_simplified_mesh_is_cached(store: Store) -> None:
    put(store, "a", shapes.blob(3))
    put(store, "b", shapes.icosphere(3))
    key = SpectrumKey("a", 10, simplify=100)
    fewer = mesh_of(key, "a", store)
    # What is asked for by the same name is not made again, not even of another mesh.
    again = mesh_of(SpectrumKey("a", 30, simplify=100), "b", store)
    np.testing.assert_array_equal(again.vertices, fewer.vertices)
    store.spectra.drop("a")
    other = mesh_of(key, "b", store)
    assert not np.array_equal(other.vertices, fewer.vertices)


def test_the_mesh_of_a_deleted_shape_is_gone(store: Store) -> None:
    with pytest.raises(ShapeGone):
        mesh_of(SpectrumKey("a", 10), "a", store)
