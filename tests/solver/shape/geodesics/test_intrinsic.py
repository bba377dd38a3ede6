"""Intrinsic Delaunay triangulations: the same surface, with rounder triangles."""

from collections.abc import Callable

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.geodesics.intrinsic import IntrinsicTriangulation, intrinsic_triangulation
from tests.solver import shapes
from tests.solver.shape.geodesics import surfaces


def stretched() -> TriangleMesh:
    sphere = shapes.icosphere(3)
    return triangle_mesh(sphere.vertices * np.array([1.0, 0.2, 5.0]), sphere.faces)


MESHES: dict[str, Callable[[], TriangleMesh]] = {
    **shapes.CONNECTED,
    "stretched": stretched,
    "random": lambda: surfaces.random_rectangle(10.0),
    "two_components": shapes.two_components,
    "needle": lambda: surfaces.cone(4, 0.2)[0],
}


def sides_per_edge(triangulation: IntrinsicTriangulation) -> IntArray:
    """Number of sides on each edge, ascending."""
    sides = np.arange(len(triangulation.across))
    count, step = np.ones_like(sides), triangulation.across
    while (step != sides).any():
        count += step != sides
        step = np.where(step != sides, triangulation.across[step], step)
    return np.sort(count)


def angles(triangulation: IntrinsicTriangulation) -> FloatArray:
    """(3F,) at the corner where each side begins."""
    sides = triangulation.lengths.reshape(-1, 3)
    here, opposite, before = sides, sides[:, [1, 2, 0]], sides[:, [2, 0, 1]]
    cosines = (here**2 + before**2 - opposite**2) / (2.0 * here * before)
    found: FloatArray = np.arccos(np.clip(cosines, -1.0, 1.0)).ravel()
    return found


def opposite_angles(triangulation: IntrinsicTriangulation) -> FloatArray:
    """(3F,) angle opposite each side."""
    return angles(triangulation).reshape(-1, 3)[:, [2, 0, 1]].ravel()


@pytest.mark.parametrize("name", MESHES)
def test_the_same_surface(name: str) -> None:
    """Area, boundary, and the angle at each vertex, which is its curvature, stay."""
    mesh = MESHES[name]()
    given = intrinsic_triangulation(mesh)
    found = given.delaunay()
    for one in (given, found):
        size = one.lengths.reshape(-1, 3).max(axis=1)
        apexes = one.apexes()
        areas = 0.5 * one.lengths * apexes[:, 1]
        assert areas.reshape(-1, 3)[:, 0].sum() == pytest.approx(mesh.area, rel=1e-9)
        np.testing.assert_allclose(
            areas, np.repeat(areas.reshape(-1, 3)[:, 0], 3), atol=1e-12 * size.max() ** 2
        )
        np.testing.assert_allclose(one.lengths, one.lengths[one.across])
    here, there = (np.bincount(one.starts, angles(one), mesh.n_vertices) for one in (given, found))
    np.testing.assert_allclose(there, here, atol=1e-6)
    alone = given.across == np.arange(len(given.across))
    alone_found = found.across == np.arange(len(found.across))
    assert alone.sum() == alone_found.sum() == (0 if mesh.closed else alone.sum())
    assert found.lengths[alone_found].sum() == pytest.approx(given.lengths[alone].sum())
    np.testing.assert_array_equal(sides_per_edge(found), sides_per_edge(given))


@pytest.mark.parametrize("name", MESHES)
def test_delaunay(name: str) -> None:
    """Angles opposite an edge add up to π at most, unless it must not be flipped."""
    found = intrinsic_triangulation(MESHES[name]()).delaunay()
    sides = np.arange(len(found.across))
    free = (found.across != sides) & (found.across[found.across] == sides)
    free &= found.forward != found.forward[found.across]
    free &= found.across // 3 != sides // 3
    opposite = opposite_angles(found)
    assert (opposite + opposite[found.across])[free].max(initial=0.0) <= np.pi + 1e-6


def test_sides_go_round_their_edge() -> None:
    for name, make in MESHES.items():
        found = intrinsic_triangulation(make()).delaunay()
        assert np.array_equal(np.sort(found.across), np.arange(len(found.across))), name
        ends = np.stack([found.starts, found.faces[:, [1, 2, 0]].ravel()], axis=1)
        ends.sort(axis=1)
        np.testing.assert_array_equal(ends, ends[found.across])


def test_rounder_triangles() -> None:
    for mesh in (stretched(), surfaces.random_rectangle(10.0)):
        given = intrinsic_triangulation(mesh)
        sharpest, found = angles(given), angles(given.delaunay())
        assert np.quantile(found, 0.05) > 1.5 * np.quantile(sharpest, 0.05)
        assert np.quantile(found, 0.99) < np.quantile(sharpest, 0.99)
