"""Holes closed by fans."""

import numpy as np
import pytest

from solver.mesh import TriangleMesh, triangle_mesh
from solver.mesh.holes import with_holes_closed
from tests.solver.shapes import icosphere, moebius_strip, spherical_cap, three_sheets


def volume(mesh: TriangleMesh) -> float:
    """What a closed mesh encloses."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6.0)


def test_a_cap_is_closed_by_a_disc() -> None:
    angle = 1.0
    cap = spherical_cap(angle)
    closed = with_holes_closed(cap)
    assert closed is not None
    assert closed.closed
    assert closed.genus == 0.0
    radius, height = np.sin(angle), 1.0 - np.cos(angle)
    assert closed.area - cap.area == pytest.approx(np.pi * radius**2, rel=1e-3)
    expected = np.pi * height**2 * (1.0 - height / 3.0)
    assert abs(volume(closed)) == pytest.approx(expected, rel=2e-3)


def test_each_hole_of_a_sphere_is_closed_and_vertices_keep_their_numbers() -> None:
    sphere = icosphere(3)
    heights = sphere.vertices[sphere.faces, 2]
    kept = (np.abs(heights) < 0.8).all(axis=1)
    vertices = np.unique(sphere.faces[kept])
    belt = triangle_mesh(sphere.vertices[vertices], np.searchsorted(vertices, sphere.faces[kept]))
    closed = with_holes_closed(belt)
    assert closed is not None
    assert closed.closed
    assert closed.n_vertices == belt.n_vertices + 2
    places = closed.vertices_of(np.arange(belt.n_vertices))
    np.testing.assert_array_equal(closed.vertices[places], belt.vertices)
    middles = closed.vertices[closed.vertices_of(belt.n_vertices + np.arange(2))]
    np.testing.assert_allclose(np.abs(middles[:, :2]), 0.0, atol=0.02)
    assert abs(volume(closed)) < abs(volume(sphere))


def test_what_has_no_holes_is_left() -> None:
    assert with_holes_closed(icosphere(2)) is None


@pytest.mark.parametrize("mesh", [moebius_strip(), three_sheets()])
def test_surfaces_that_are_no_orientable_manifolds_are_closed_too(mesh: TriangleMesh) -> None:
    closed = with_holes_closed(mesh)
    assert closed is not None
    assert closed.closed
