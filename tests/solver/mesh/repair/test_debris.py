"""Debris: components too small to matter are left out, and said so."""

import numpy as np

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import Shape
from tests.solver import shapes


def with_triangles(mesh: TriangleMesh, count: int, size: float) -> tuple[FloatArray, TriangleMesh]:
    """Some loose triangles with legs of a size, before the body's vertices in the file."""
    random = np.random.default_rng(7)
    places = random.uniform(-3.0, 3.0, (count, 1, 3))
    legs = np.array([[0.0, 0, 0], [size, 0, 0], [0, size, 0]])
    loose = (places + legs).reshape(-1, 3)
    vertices = np.concatenate([loose, mesh.vertices])
    faces = np.concatenate([np.arange(3 * count).reshape(-1, 3), mesh.faces + 3 * count])
    return vertices, triangle_mesh(vertices, faces)


def test_loose_triangles_are_left_out() -> None:
    body = shapes.blob()
    vertices, mesh = with_triangles(body, 50, 0.05)
    assert (mesh.components, mesh.closed) == (1, True)
    np.testing.assert_array_equal(mesh.vertices, vertices[mesh.vertex_ids])
    np.testing.assert_array_equal(mesh.vertex_ids, np.arange(150, 150 + body.n_vertices))
    share = 50 * 0.5 * 0.05**2 / (body.area + 50 * 0.5 * 0.05**2)
    assert mesh.warnings == (
        "left out 50 loose components of less than a thousandth of the largest one's area: 150"
        f" vertices, 50 triangles, {100 * share:.2g} % of the area",
    )
    # Numbers of vertices that were left out have no place on the surface.
    assert (mesh.vertices_of(np.arange(150)) == -1).all()


def test_what_is_computed_is_that_of_the_body_alone() -> None:
    body = shapes.blob(2)
    mesh = with_triangles(body, 50, 0.02)[1]
    found, expected = Shape(mesh, eigenpairs=10), Shape(body, eigenpairs=10)
    np.testing.assert_allclose(
        found.spectrum().eigenvalues, expected.spectrum().eigenvalues, rtol=1e-9, atol=1e-9
    )


def test_components_that_matter_are_kept() -> None:
    mesh = with_triangles(shapes.blob(), 3, 0.5)[1]
    assert mesh.components == 4
    assert not any("left out" in warning for warning in mesh.warnings)


def test_a_surface_in_equal_pieces_keeps_all_of_them() -> None:
    """However many there are, and however small each is."""
    corners = np.stack(np.meshgrid(np.arange(45), np.arange(45), [0]), axis=-1).reshape(-1, 1, 3)
    legs = np.array([[0.0, 0, 0], [0.4, 0, 0], [0, 0.4, 0]])
    vertices = (corners + legs).reshape(-1, 3)
    mesh = triangle_mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))
    assert mesh.components == 45 * 45
    assert np.isfinite(Shape(mesh).metric("geodesic").distances(np.array([0]))).all()
