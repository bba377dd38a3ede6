"""Copies that differ by a rigid motion and the order of their vertices."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.control import Control
from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration import register
from solver.registration.congruence import congruent_vertices
from solver.shape import Shape
from synthetic import human
from tests.solver import shapes


@pytest.fixture(scope="module")
def body() -> TriangleMesh:
    figure = human("walking", resolution=1500, seed=1)
    return triangle_mesh(figure.vertices, figure.faces)


def turned(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh, turned and moved."""
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    return triangle_mesh(mesh.vertices @ turn + [3.0, -1.0, 2.0], mesh.faces)


def test_a_motion_is_found_from_a_map_near_it(body: TriangleMesh) -> None:
    unit = body.scaled(1.0 / np.sqrt(body.area))
    other, where = shapes.permuted(turned(unit), seed=4)
    near = np.linalg.norm(unit.vertices[:, None] - unit.vertices[None], axis=2)
    neighbours = where[np.argsort(near, axis=1)[:, 5]]
    found = congruent_vertices(unit, other, neighbours)
    np.testing.assert_array_equal(found, where)


def test_what_is_bent_or_has_other_vertices_is_not_congruent(body: TriangleMesh) -> None:
    unit = body.scaled(1.0 / np.sqrt(body.area))
    every = np.arange(unit.n_vertices)
    bent = triangle_mesh(unit.vertices + 0.01 * np.sin(4.0 * unit.vertices[:, ::-1]), unit.faces)
    assert congruent_vertices(unit, bent, every) is None
    assert congruent_vertices(unit, shapes.icosphere(2), every) is None


def test_vertices_at_one_place_are_divided_among_their_preimages() -> None:
    """Two tetrahedra that touch in a point, which is a vertex of each."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.0, 1.2, 0.0], [0.1, 0.0, 1.3]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    both = triangle_mesh(
        np.concatenate([corners, -2.0 * corners]), np.concatenate([faces, faces + 4])
    )
    every = np.arange(8)
    assert (both.vertices[0] == both.vertices[4]).all()
    met = congruent_vertices(both, both, np.array([4, 1, 2, 3, 4, 5, 6, 7]))
    np.testing.assert_array_equal(met, every)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_copy_of_a_body_is_mapped_to_itself(mirrored: bool) -> None:
    """Its points as well as its dense map, and that back; landmarks choose the mirror image."""
    figure = human("walking", resolution=1500, seed=2)
    source = triangle_mesh(figure.vertices, figure.faces)
    signs = np.array([-1.0, 1.0, 1.0]) if mirrored else np.ones(3)
    reflected = triangle_mesh(source.vertices * signs, source.faces)
    other, where = shapes.permuted(turned(reflected), seed=4)
    marks = np.array([10, 300, 700, 1100, 1400])
    known = marks, where[marks]
    found = register(Shape(source), Shape(other), (), Control(), known)
    assert found is not None
    assert found.reflected == mirrored
    assert found.opened._congruent is not None
    dense = found.dense(Control())
    np.testing.assert_array_equal(dense.target, where)
    np.testing.assert_array_equal(found.images(marks, Control()), where[marks])
    assert dense.inverse is not None
    np.testing.assert_array_equal(dense.inverse.target[where], np.arange(len(where)))
    places = np.einsum("nc,ncd->nd", dense.barycentric, other.vertices[dense.faces])
    np.testing.assert_allclose(places, other.vertices[where])
