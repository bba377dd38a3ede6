"""Straight lines on surfaces where they are known."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.gmds import SurfacePoints, charts_of, walk
from solver.mesh import TriangleMesh, triangle_mesh
from tests.solver import shapes
from tests.solver.gmds.surfaces import random_points


def place(mesh: TriangleMesh, face: int, u: FloatArray) -> FloatArray:
    point = SurfacePoints(np.array([face]), u[None])
    at: FloatArray = point.positions(mesh.vertices, mesh.faces)[0]
    return at


def in_chart(mesh: TriangleMesh, face: int, vector: FloatArray) -> tuple[float, float]:
    """Coordinates, in a triangle's own plane, of a vector that lies in it."""
    a, b, c = mesh.vertices[mesh.faces[face]]
    x = (b - a) / np.linalg.norm(b - a)
    y = (c - a) - (c - a) @ x * x
    return float(vector @ x), float(vector @ y / np.linalg.norm(y))


@pytest.mark.parametrize("seed", range(3))
def test_a_plane_is_crossed_straight(seed: int) -> None:
    mesh = shapes.permuted(shapes.plane_grid(), seed)[0]
    charts = charts_of(mesh)
    random = np.random.default_rng(seed)
    starts = random_points(mesh, seed, 60)
    for face, u in zip(starts.faces, starts.barycentric, strict=True):
        here = place(mesh, face, u)
        there = np.append(random.uniform([0.0, 0.0], [1.5, 1.0]), 0.0)
        end, end_u = walk(charts, face, u, *in_chart(mesh, face, there - here))
        np.testing.assert_allclose(place(mesh, end, end_u), there, atol=1e-9)
        assert end_u.min() >= 0.0
        assert end_u.sum() == pytest.approx(1.0)


def test_a_line_round_a_cube_comes_back() -> None:
    mesh = shapes.cube(5)
    charts = charts_of(mesh)
    starts = random_points(mesh, 0, 40)
    for face, u in zip(starts.faces, starts.barycentric, strict=True):
        corners = mesh.vertices[mesh.faces[face]]
        side = int(np.argmin(np.ptp(corners, axis=0)))
        direction = np.zeros(3)
        direction[(side + 1) % 3] = 1.0
        here = place(mesh, face, u)
        if (np.abs(np.delete(here, (side, (side + 1) % 3)) % 0.2) < 1e-6).any():
            continue  # along an edge of the mesh: it may go round a corner of the cube
        half = walk(charts, face, u, *in_chart(mesh, face, 2.0 * direction))
        whole = walk(charts, face, u, *in_chart(mesh, face, 4.0 * direction))
        np.testing.assert_allclose(place(mesh, *whole), here, atol=1e-9)
        opposite = here.copy()
        opposite[[side, (side + 1) % 3]] = 1.0 - here[[side, (side + 1) % 3]]
        np.testing.assert_allclose(place(mesh, *half), opposite, atol=1e-9)


def test_what_leaves_the_surface_slides_along_its_border() -> None:
    mesh = triangle_mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    charts = charts_of(mesh)
    centre = np.full(3, 1.0 / 3.0)
    face, u = walk(charts, 0, centre, 0.2, -1.0)
    np.testing.assert_allclose(place(mesh, face, u), [1.0 / 3.0 + 0.2, 0.0, 0.0], atol=1e-12)
    face, u = walk(charts, 0, centre, 5.0, -1.0)
    np.testing.assert_allclose(place(mesh, face, u), [1.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("name", sorted(shapes.CONNECTED))
def test_a_line_ends_on_the_surface(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    charts = charts_of(mesh)
    random = np.random.default_rng(0)
    starts = random_points(mesh, 0, 100)
    for face, u in zip(starts.faces, starts.barycentric, strict=True):
        x, y = random.normal(scale=np.sqrt(mesh.area), size=2)
        end, end_u = walk(charts, face, u, x, y)
        assert 0 <= end < mesh.n_faces
        assert end_u.min() >= 0.0
        assert end_u.sum() == pytest.approx(1.0)
        # A line is no shorter than the segment between its ends.
        apart = np.linalg.norm(place(mesh, end, end_u) - place(mesh, face, u))
        assert apart <= np.hypot(x, y) * (1.0 + 1e-9)


def test_points_at_vertices_are_these_vertices() -> None:
    mesh = shapes.torus()
    vertices = np.arange(mesh.n_vertices)
    points = SurfacePoints.at_vertices(mesh, vertices)
    np.testing.assert_array_equal(points.positions(mesh.vertices, mesh.faces), mesh.vertices)
    np.testing.assert_array_equal(points.nearest_vertices(mesh), vertices)
