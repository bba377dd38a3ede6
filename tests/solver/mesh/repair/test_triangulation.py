"""Polygons into triangles: areas by the shoelace formula, and no triangle over another."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh import read_mesh
from solver.mesh.repair import MOST_CORNERS, triangulated
from tests.solver.mesh import mesh_files


def signed_areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    u, v = b - a, c - a
    found: FloatArray = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    return found


def shoelace(points: FloatArray) -> float:
    x, y = points.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def in_space(points: FloatArray, seed: int) -> FloatArray:
    """Lay a plane figure somewhere into space."""
    random = np.random.default_rng(seed)
    rotation, _ = np.linalg.qr(random.standard_normal((3, 3)))
    found: FloatArray = points @ rotation[:2] + random.standard_normal(3)
    return found


def cut(points: FloatArray, seed: int = 0) -> IntArray:
    n = len(points)
    found = triangulated(in_space(points, seed), np.array([n]), np.arange(n))
    assert found.crossed == 0
    return found.triangles


def star(random: np.random.Generator, n: int) -> FloatArray:
    """A polygon that sees all its corners from the origin, and is anything but convex."""
    angles = 2.0 * np.pi * (np.arange(n) + 0.9 * random.random(n)) / n
    radii = random.uniform(0.1, 1.0, n)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


def comb(teeth: int) -> FloatArray:
    x = np.repeat(np.arange(teeth), 2).astype(np.float64)
    y = np.tile([0.0, 10.0], teeth)
    return np.stack([np.r_[x, teeth, -1.0], np.r_[y, -1.0, -1.0]], axis=1)[::-1]


def spiral(turns: int, steps: int = 12) -> FloatArray:
    angle = 2.0 * np.pi * np.arange(turns * steps) / steps
    inner = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (1.0 + angle[:, None])
    outer = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (1.0 + angle[:, None] + np.pi)
    return np.concatenate([outer, inner[::-1]])


L_SHAPE = np.array([[0.0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])
ARROW = np.array([[0.0, 0], [1, 0.2], [0, 1], [0.2, 0.2]])
KEYHOLE = np.array(
    [[0.0, 0], [4, 0], [4, 4], [0, 4], [0, 0], [1, 1], [1, 3], [3, 3], [3, 1], [1, 1]]
)
"""A square with a square hole, joined to the rim by a cut."""
MIDPOINTS = np.array([[0.0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]])


@pytest.mark.parametrize(
    "points",
    [L_SHAPE, ARROW, KEYHOLE, MIDPOINTS, comb(40), spiral(4)],
    ids=["L", "arrow", "keyhole", "square with midpoints", "comb", "spiral"],
)
@pytest.mark.parametrize("first", [0, 1, 3])
def test_polygons_that_are_not_convex(points: FloatArray, first: int) -> None:
    points = np.roll(points, first, axis=0)
    triangles = cut(points, seed=first)
    areas = signed_areas(points, triangles)
    assert len(triangles) == len(points) - 2
    # All turn alike and their areas add up: they cover the polygon once.
    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(shoelace(points))


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(4, 40))
def test_any_star(seed: int, n: int) -> None:
    points = star(np.random.default_rng(seed), n)
    areas = signed_areas(points, cut(points, seed % 7))
    assert (areas >= -1e-12).all()
    assert areas.sum() == pytest.approx(shoelace(points), rel=1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_corners_on_straight_sides_leave_no_triangle_without_area(seed: int) -> None:
    """Rounding makes ears of some; dropped as degenerate, they would leave T-junctions."""
    random = np.random.default_rng(seed)
    outline = star(random, int(random.integers(5, 8)))
    points = np.concatenate(
        [
            start + (end - start) * np.r_[0.0, np.sort(random.random(4))][:, None]
            for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True)
        ]
    )
    areas = signed_areas(points, cut(points, seed))
    assert areas.min() > 1e-12
    assert areas.sum() == pytest.approx(shoelace(outline))


def test_consecutive_corners_in_one_place_all_stay() -> None:
    doubled = np.repeat(L_SHAPE, [1, 1, 1, 3, 1, 2], axis=0)
    triangles = cut(doubled)
    areas = signed_areas(doubled, triangles)
    assert len(triangles) == len(doubled) - 2
    assert (areas > -1e-12).all()
    assert areas.sum() == pytest.approx(shoelace(L_SHAPE))
    sides = {tuple(side) for t in triangles for side in np.stack([t, np.roll(t, -1)], axis=1)}
    assert {(n, (n + 1) % len(doubled)) for n in range(len(doubled))} <= sides


def test_each_edge_of_a_polygon_is_an_edge_of_its_triangles() -> None:
    points = star(np.random.default_rng(1), 25)
    triangles = cut(points)
    sides = {tuple(side) for t in triangles for side in np.stack([t, np.roll(t, -1)], axis=1)}
    assert {(n, (n + 1) % 25) for n in range(25)} <= sides


def test_quadrilaterals_are_cut_alike_whichever_corner_is_first() -> None:
    random = np.random.default_rng(2)
    for _ in range(20):
        points = random.standard_normal((4, 3))
        cuts = set()
        for first in range(4):
            corners = np.roll(np.arange(4), first)
            triangles = triangulated(points, np.array([4]), corners).triangles
            cuts.add(frozenset(frozenset(t) for t in triangles.tolist()))
        assert len(cuts) == 1


def test_the_shorter_diagonal_is_taken_if_both_lie_inside() -> None:
    points = np.array([[0.0, 0, 0], [1, -0.2, 0], [2, 0, 0], [1, 0.2, 0]])
    triangles = triangulated(points, np.array([4]), np.arange(4)).triangles
    assert all({1, 3} <= set(t) for t in triangles.tolist())


def test_many_polygons_of_mixed_sizes() -> None:
    random = np.random.default_rng(3)
    sizes = random.integers(3, 9, 200)
    figures = [star(random, n) for n in sizes]
    points = np.concatenate(figures)
    space = np.concatenate([in_space(figure, seed) for seed, figure in enumerate(figures)])
    found = triangulated(space, sizes, np.arange(len(space)))
    areas = signed_areas(points, found.triangles)
    owner = np.repeat(np.arange(200), sizes - 2)
    np.testing.assert_allclose(np.bincount(owner, areas), [shoelace(f) for f in figures])


def test_outlines_that_cross_themselves_are_counted() -> None:
    bow_tie = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    assert triangulated(bow_tie, np.array([4]), np.arange(4)).crossed == 1
    angles = 4.0 * np.pi * np.arange(5) / 5.0
    pentagram = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    assert triangulated(pentagram, np.array([5]), np.arange(5)).crossed == 1


def test_polygons_without_area_do_no_harm() -> None:
    for points in (np.zeros((6, 3)), np.arange(6.0)[:, None] * np.array([1.0, 2.0, 3.0])):
        for n in (4, 6):
            found = triangulated(points, np.array([n]), np.arange(n))
            assert len(found.triangles) == n - 2


def test_a_polygon_of_too_many_corners_is_refused() -> None:
    n = MOST_CORNERS + 1
    with pytest.raises(MeshError, match=f"face 0 has {n} corners"):
        triangulated(np.zeros((n, 3)), np.array([n]), np.arange(n))


def test_the_largest_polygon_that_is_cut_is_cut_soon() -> None:
    points = star(np.random.default_rng(5), MOST_CORNERS)
    assert signed_areas(points, cut(points)).sum() == pytest.approx(shoelace(points))


@pytest.mark.parametrize("file_type", ["off", "obj", "ply"])
def test_concave_faces_of_a_file(file_type: str) -> None:
    """A fan from the first corner would cover the notch of the L, and some of it twice."""
    block = np.concatenate([np.c_[L_SHAPE, np.zeros(6)], np.c_[L_SHAPE, np.ones(6)]])
    ring = [[n, (n + 1) % 6, 6 + (n + 1) % 6, 6 + n] for n in range(6)]
    faces = [[2, 1, 0, 5, 4, 3], [8, 9, 10, 11, 6, 7], *ring]
    mesh = read_mesh(getattr(mesh_files, file_type)(block, faces), file_type)
    assert mesh.warnings == ("cut 8 faces of more than three corners into triangles",)
    assert mesh.closed
    assert mesh.area == pytest.approx(2 * 3.0 + 8.0)
