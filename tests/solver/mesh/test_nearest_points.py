"""Nearest vertices by descent and nearest points of triangles, against exhaustive searches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.arrays import FloatArray, IntArray
from solver.mesh import descend, project
from solver.registration.surface import SmoothSurface
from solver.shape import Shape
from tests.solver import shapes

SEEDS = st.integers(0, 2**31 - 1)


@pytest.fixture(scope="module")
def sphere() -> SmoothSurface:
    return SmoothSurface(Shape(shapes.icosphere(3)))


def squares(queries: FloatArray, points: FloatArray) -> FloatArray:
    apart: FloatArray = ((queries[:, None] - points[None]) ** 2).sum(axis=2)
    return apart


def test_descent_on_a_sphere_ends_at_the_nearest_vertex(sphere: SmoothSurface) -> None:
    """Vertices of equal norm: their distances are linear functions on a convex polytope."""
    points = shapes.icosphere(3).vertices
    random = np.random.default_rng(0)
    queries = random.standard_normal((200, 3))
    start = random.integers(len(points), size=200)
    found = descend(queries, points, *sphere.mesh.neighbours, start)
    apart = squares(queries, points)
    np.testing.assert_allclose(apart[np.arange(200), found], apart.min(axis=1), rtol=1e-12)


@given(SEEDS)
def test_descent_ends_at_a_local_minimum_no_farther_than_its_start(
    sphere: SmoothSurface, seed: int
) -> None:
    random = np.random.default_rng(seed)
    points = random.standard_normal((sphere.mesh.n_vertices, 5))
    queries, start = random.standard_normal((20, 5)), random.integers(len(points), size=20)
    first, neighbours = sphere.mesh.neighbours
    found = descend(queries, points, first, neighbours, start)
    apart = squares(queries, points)
    for query, (begin, end) in enumerate(zip(start, found, strict=True)):
        assert apart[query, end] <= apart[query, begin]
        around = neighbours[first[end] : first[end + 1]]
        assert (apart[query, end] <= apart[query, around] + 1e-12).all()


TRIANGLES: IntArray = np.array([[0, 1, 2], [3, 0, 2], [1, 4, 0]])
"""Three round vertex 0, which is at another corner of each."""
INCIDENT = np.array([0, 3, 3, 3, 3, 3]), np.array([0, 1, 2])


def barycentric_grid(steps: int) -> FloatArray:
    s, t = np.meshgrid(*[np.arange(steps + 1)] * 2, indexing="ij")
    inside = s + t <= steps
    grid: FloatArray = np.stack([steps - s - t, s, t], axis=-1)[inside] / steps
    return grid


@given(SEEDS, st.sampled_from([2, 3, 7]), st.sampled_from([0.1, 1.0, 10.0]))
def test_projections_are_the_nearest_points_of_the_triangles(
    seed: int, dimensions: int, far: float
) -> None:
    random = np.random.default_rng(seed)
    points = random.standard_normal((5, dimensions))
    query = far * random.standard_normal((1, dimensions))
    faces, weights = project(query, points, TRIANGLES, *INCIDENT, np.array([0]))
    assert (weights >= 0.0).all()
    assert weights.sum() == pytest.approx(1.0)
    found = np.linalg.norm(weights[0] @ points[TRIANGLES[faces[0]]] - query[0])
    steps = 60
    grid = np.concatenate([barycentric_grid(steps) @ points[corners] for corners in TRIANGLES])
    least = float(np.linalg.norm(grid - query, axis=1).min())
    longest = float(np.sqrt(squares(points, points).max()))
    assert least - longest / steps <= found <= least + 1e-9


@given(SEEDS)
def test_points_of_a_triangle_are_their_own_projections(seed: int) -> None:
    random = np.random.default_rng(seed)
    points = random.standard_normal((5, 4))
    face = int(random.integers(3))
    inside = random.dirichlet([1.0, 1.0, 1.0])
    query = inside @ points[TRIANGLES[face]]
    found, weights = project(query[None], points, TRIANGLES, *INCIDENT, np.array([0]))
    np.testing.assert_allclose(weights[0] @ points[TRIANGLES[found[0]]], query, atol=1e-8)


def test_degenerate_triangles_have_projections() -> None:
    """All corners on a line, or at one point."""
    triangles = np.array([[0, 1, 2]])
    incident = np.array([0, 1, 1, 1]), np.array([0])
    for points, nearest in (
        (np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]]), [2.0, 0.0]),
        (np.zeros((3, 2)), [0.0, 0.0]),
    ):
        _, weights = project(np.array([[2.0, 1.0]]), points, triangles, *incident, np.array([0]))
        assert (weights >= 0.0).all()
        np.testing.assert_allclose(weights[0] @ points, nearest, atol=1e-9)
