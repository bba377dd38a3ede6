"""Geodesic distances against closed forms on surfaces where they are known."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from solver.arrays import FloatArray
from solver.mesh import triangle_mesh
from solver.shape.geodesics import GeodesicGraph
from tests.solver import shapes


def all_distances(name: str) -> FloatArray:
    mesh = shapes.CONNECTED[name]()
    return GeodesicGraph(mesh).distances(np.arange(mesh.n_vertices))


def test_plane() -> None:
    mesh = shapes.plane_grid(31, 21, 1.5)  # square cells
    found = GeodesicGraph(mesh).distances(np.arange(mesh.n_vertices))
    exact = np.linalg.norm(mesh.vertices[:, None] - mesh.vertices, axis=2)
    assert (found >= exact - 1e-12).all()
    x, y = np.abs(mesh.vertices[:, None] - mesh.vertices).transpose(2, 0, 1)[:2]
    straight = (x < 1e-9) | (y < 1e-9) | (np.abs(x - y) < 1e-9)
    np.testing.assert_allclose(found[straight], exact[straight], atol=1e-12)
    apart = exact > 0.0
    # Eight directions of a grid err by 8.2 % at worst; flips over the diagonals add some of the
    # knight's moves.
    assert (found[apart] / exact[apart]).max() <= 1.0 / np.cos(np.pi / 8)
    assert (found[apart] / exact[apart]).mean() < 1.04


def test_sphere() -> None:
    mesh = shapes.icosphere(4)
    sources = np.arange(0, mesh.n_vertices, 97)
    found = GeodesicGraph(mesh).distances(sources)
    exact = np.arccos(np.clip(mesh.vertices[sources] @ mesh.vertices.T, -1.0, 1.0))
    apart = exact > 0.3
    ratio = found[apart] / exact[apart]
    assert ratio.min() > 0.997  # chords are shorter than arcs
    assert ratio.max() < 1.05
    assert ratio.mean() < 1.025


def test_cube() -> None:
    mesh = shapes.cube(12)
    corner = int(np.argmin(mesh.vertices.sum(axis=1)))
    found = GeodesicGraph(mesh).distances(np.array([corner]))[0]
    x, y, z = mesh.vertices.T
    opposite = int(np.argmax(x + y + z))
    assert np.sqrt(5.0) - 1e-12 <= found[opposite] <= 1.04 * np.sqrt(5.0)
    beside = (x == 0) | (y == 0) | (z == 0)  # the three sides that meet in the corner
    exact = np.linalg.norm(mesh.vertices[beside], axis=1)
    assert (found[beside] >= exact - 1e-12).all()
    assert (found[beside] <= 1.083 * exact + 1e-12).all()


def test_flat_tetrahedron() -> None:
    """From corner to corner along an edge, and from a corner straight down the opposite face."""
    mesh = shapes.fine_tetrahedron(4)
    corners = np.array(
        [
            int(np.argmin(((mesh.vertices - v) ** 2).sum(axis=1)))
            for v in shapes.tetrahedron().vertices
        ]
    )
    found = GeodesicGraph(mesh).distances(corners)[:, corners]
    np.testing.assert_allclose(found + np.sqrt(2.0) * np.eye(4), np.sqrt(2.0), rtol=1e-12)
    middle = int(np.argmin(((mesh.vertices - mesh.vertices[corners[:2]].mean(axis=0)) ** 2).sum(1)))
    across = GeodesicGraph(mesh).distances(np.array([middle]))[0, corners[2]]
    assert across == pytest.approx(np.sqrt(1.5), rel=1e-9)  # a height: flips follow it exactly


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_a_metric(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    sources = np.arange(0, mesh.n_vertices, max(mesh.n_vertices // 40, 1))
    found = GeodesicGraph(mesh).distances(sources)
    assert found.shape == (len(sources), mesh.n_vertices)
    between = found[:, sources]
    np.testing.assert_allclose(between, between.T, rtol=1e-12)
    assert (np.diag(between) == 0.0).all()
    off_diagonal = between[~np.eye(len(sources), dtype=bool)]
    assert (off_diagonal > 0.0).all()
    assert np.isfinite(found).all()
    assert (found[:, None, :] <= between[:, :, None] + found[None, :, :] + 1e-12).all()
    chords = np.linalg.norm(mesh.vertices[sources][:, None] - mesh.vertices, axis=2)
    assert (found >= chords - 1e-12).all()


def test_flips_halve_the_error_of_edges() -> None:
    mesh = shapes.icosphere(4)
    i, j = mesh.edges.T
    lengths = np.linalg.norm(mesh.vertices[i] - mesh.vertices[j], axis=1)
    edges = sp.coo_array((lengths, (i, j)), shape=(mesh.n_vertices,) * 2).tocsr()
    sources = np.arange(0, mesh.n_vertices, 97)
    exact = np.arccos(np.clip(mesh.vertices[sources] @ mesh.vertices.T, -1.0, 1.0))
    far = exact > 0.3
    along_edges = dijkstra(edges, directed=False, indices=sources)[far] / exact[far]
    with_flips = GeodesicGraph(mesh).distances(sources)[far] / exact[far]
    assert with_flips.mean() - 1.0 < 0.5 * (along_edges.mean() - 1.0)


def test_bending_does_not_matter() -> None:
    flat = shapes.plane_grid(61, 41, 1.5)
    x, y, _ = flat.vertices.T
    rolled = triangle_mesh(np.stack([np.cos(x), y, np.sin(x)], axis=1), flat.faces)
    sources = np.array([0, 600, 1200])
    np.testing.assert_allclose(
        GeodesicGraph(rolled).distances(sources), GeodesicGraph(flat).distances(sources), rtol=1e-3
    )


COORDINATE = st.floats(-1.0, 1.0).filter(lambda x: abs(x) > 1e-3)


@given(
    st.lists(COORDINATE, min_size=12, max_size=12),
    st.permutations(range(4)),
)
def test_two_triangles_against_the_best_point_on_their_edge(
    coordinates: list[float], order: list[int]
) -> None:
    """The way from a to b is the shortest broken line through a point of the shared edge."""
    points = np.array(coordinates).reshape(4, 3)
    a, i, j, b = order
    areas = [np.linalg.norm(np.cross(points[j] - points[i], points[p] - points[i])) for p in (a, b)]
    if min(areas) < 1e-3:
        return
    mesh = triangle_mesh(points, np.array([[i, j, a], [j, i, b]]))
    found = GeodesicGraph(mesh).distances(np.array([a]))[0, b]
    crossing = points[i] + np.linspace(0.0, 1.0, 20001)[:, None] * (points[j] - points[i])
    lengths = np.linalg.norm(crossing - points[a], axis=1)
    lengths += np.linalg.norm(crossing - points[b], axis=1)
    assert found <= lengths.min() + 1e-12
    assert found == pytest.approx(lengths.min(), rel=1e-4)


def test_sheets_that_meet_in_one_line() -> None:
    """Every edge on the line has three triangles; ways between any two sheets are straight."""
    mesh = shapes.three_sheets()
    x, y, z = mesh.vertices.T
    angle, radius = np.arctan2(y, x), np.hypot(x, y)
    ends = [
        int(np.argmin(np.abs(np.exp(1j * angle) - np.exp(1j * a)) + abs(radius - 1) + abs(z - 0.5)))
        for a in (0.0, 2.0, 4.0)
    ]
    found = GeodesicGraph(mesh).distances(np.array(ends))[:, ends]
    np.testing.assert_allclose(found, 2.0 * (1 - np.eye(3)), atol=1e-9)
