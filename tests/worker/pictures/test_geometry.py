"""What a browser reads of a mesh is the mesh."""

import gzip
import struct
import warnings
from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from tests.worker.figures import blob
from worker.pictures import packed_geometry


def unpacked(
    data: bytes, *, is_cloud: bool = False
) -> tuple[FloatArray, IntArray, IntArray, IntArray | None]:
    """Positions, triangles, numbers, colours, as the table in `worker.pictures.geometry`."""
    raw = gzip.decompress(data)
    magic, n, f, colored, cloud = struct.unpack_from("<8s4I", raw)
    x, y, z, scale = struct.unpack_from("<4d", raw, 24)
    assert (magic, cloud) == (b"isogeom1", is_cloud)
    at = 56
    stored = np.frombuffer(raw, "<f4", 3 * n, at).reshape(n, 3)
    assert np.abs(stored).max() <= 1.0
    faces = np.frombuffer(raw, "<u4", 3 * f, at := at + 12 * n).reshape(f, 3)
    numbers = np.frombuffer(raw, "<u4", n, at := at + 12 * f)
    colors = np.frombuffer(raw, "u1", -1, at + 4 * n).reshape(-1, 3)
    positions = np.array([x, y, z]) + scale * stored.astype(np.float64)
    given = colors.astype(np.int64) if colored else None
    assert len(colors) == (n if colored else 0)
    return positions, faces.astype(np.int64), numbers.astype(np.int64), given


def check(mesh: TriangleMesh) -> None:
    positions, faces, numbers, colors = unpacked(packed_geometry(mesh), is_cloud=mesh.is_cloud)
    size = np.ptp(mesh.vertices, axis=0).max()
    # Half a unit in the last place of float32, and what the origin loses in float64.
    error = 2.0**-24 * size + 1e-15 * np.abs(mesh.vertices).max()
    assert np.abs(positions - mesh.vertices).max() <= error
    np.testing.assert_array_equal(faces, mesh.faces)
    np.testing.assert_array_equal(numbers, mesh.vertex_ids)
    if mesh.colors is None:
        assert colors is None
    else:
        assert colors is not None
        assert np.abs(colors / 255.0 - mesh.colors).max() <= 0.5 / 255.0 + 1e-12


def test_point_clouds_are_marked() -> None:
    check(replace(triangle_mesh(*blob(2)), is_cloud=True))


@pytest.mark.parametrize("size", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("away", [0.0, 1e6])
def test_packed_geometry_is_that_of_the_mesh(size: float, away: float) -> None:
    vertices, faces = blob(2, seed=3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check(triangle_mesh(size * (vertices + away), faces))


def test_vertex_indices_are_those_of_the_file() -> None:
    vertices, faces = blob(2)
    # Vertices of no face come first, and one is given twice.
    extra = np.concatenate([vertices + 50.0, vertices, vertices[:1]])
    moved = faces + len(vertices)
    moved[moved == len(vertices)] = 2 * len(vertices)
    mesh = triangle_mesh(extra, moved)
    assert mesh.vertex_ids.min() > len(vertices)
    check(mesh)


def test_colours() -> None:
    vertices, faces = blob(2)
    check(triangle_mesh(vertices, faces, np.random.default_rng(1).random((len(vertices), 3))))


def test_the_same_mesh_is_the_same_bytes() -> None:
    mesh = triangle_mesh(*blob(2))
    assert packed_geometry(mesh) == packed_geometry(mesh)
