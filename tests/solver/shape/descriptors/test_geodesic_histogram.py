"""Local histograms of geodesic distances: areas of annuli and caps, borders, continuity."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import GeodesicMetric
from solver.shape.descriptors import geodesic_histogram
from solver.shape.geodesics import GeodesicGraph
from tests.solver import shapes
from tests.solver.shape.descriptors.exact_distances import GreatCircles, straight_lines


def graph(mesh: TriangleMesh) -> GeodesicMetric:
    return GeodesicMetric(GeodesicGraph(mesh))


def everywhere(mesh: TriangleMesh, radius: float, bins: int) -> FloatArray:
    return geodesic_histogram(mesh, graph(mesh), radius, bins, np.arange(mesh.n_vertices))


def test_in_the_plane_every_bin_is_one() -> None:
    plane = shapes.disc(60)
    histogram = geodesic_histogram(plane, straight_lines(plane), 0.9, 9, np.array([0]))
    np.testing.assert_allclose(3.0 * histogram, 1.0, rtol=0.01)


def test_at_borders_and_corners_bins_are_halves_and_quarters() -> None:
    square = shapes.plane_grid(81, 81, 1.0)
    histogram = geodesic_histogram(square, straight_lines(square), 0.4, 4, np.array([0, 40]))
    np.testing.assert_allclose(2.0 * histogram, [[0.25] * 4, [0.5] * 4], rtol=0.02)


def test_on_the_sphere_bins_are_zones() -> None:
    """2π (cos a - cos b), over π (b² - a²)."""
    sphere = shapes.icosphere(5)
    edges = np.linspace(0.0, 2.0, 9)
    exact = 2.0 * -np.diff(np.cos(edges)) / np.diff(edges**2)
    points = np.array([0, 500, 10000])
    histogram = geodesic_histogram(sphere, GreatCircles(sphere), 2.0, 8, points)
    np.testing.assert_allclose(np.sqrt(8) * histogram, np.tile(exact, (3, 1)), rtol=0.01)
    measured = geodesic_histogram(sphere, graph(sphere), 2.0, 8, points)
    np.testing.assert_allclose(np.sqrt(8) * measured, np.tile(exact, (3, 1)), rtol=0.1)


def test_a_large_radius_takes_in_the_whole_surface() -> None:
    cube = shapes.cube()
    histogram = everywhere(cube, 4.0, 5)
    flat = np.pi * 0.8**2 * np.array([1.0, 3.0, 5.0, 7.0, 9.0])
    np.testing.assert_allclose(np.sqrt(5) * histogram @ flat, 6.0, rtol=1e-9)


def test_it_tells_tips_from_plains() -> None:
    blob = shapes.blob()
    mean = everywhere(blob, 1.0, 4).mean(axis=1)
    tip = int(np.argmax(np.linalg.norm(blob.vertices, axis=1)))
    assert mean[tip] < 0.8 * np.median(mean)


def test_it_changes_little_when_the_point_moves_little() -> None:
    """Whole vertices would fall from one bin into the next: 40 of them at once, at the corner."""
    square = shapes.plane_grid(41, 41, 1.0)
    metric = straight_lines(square)
    before = geodesic_histogram(square, metric, 0.5, 5, np.array([820]))
    for shift in (1e-4, 1e-6):
        moved = square.vertices.copy()
        moved[820, 0] += shift
        mesh = triangle_mesh(moved, square.faces)
        after = geodesic_histogram(mesh, straight_lines(mesh), 0.5, 5, np.array([820]))
        assert 0.0 < np.abs(after - before).max() < 20.0 * shift


@pytest.mark.parametrize("name", ["blob", "plane_grid", "moebius_strip", "three_sheets"])
def test_invariances(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    histogram = everywhere(mesh, 0.8, 6)
    assert histogram.shape == (mesh.n_vertices, 6)
    moved = shapes.moved(mesh, seed=6)
    found = everywhere(moved, 0.8, 6)
    np.testing.assert_allclose(found, histogram, rtol=1e-9, atol=1e-9)
    renumbered, where = shapes.permuted(mesh, seed=7)
    found = everywhere(renumbered, 0.8, 6)[where]
    np.testing.assert_allclose(found, histogram, rtol=1e-9, atol=1e-9)
    # Table 1: it changes with scale, unless the radius does too.
    larger = shapes.moved(mesh, seed=6, scale=10.0)
    found = everywhere(larger, 8.0, 6)
    np.testing.assert_allclose(found, histogram, rtol=1e-6, atol=1e-9)
    assert np.abs(everywhere(larger, 0.8, 6) - histogram).max() > 0.01
    some = np.array([3, 1, 40])
    found = geodesic_histogram(mesh, graph(mesh), 0.8, 6, some)
    np.testing.assert_allclose(found, histogram[some], rtol=1e-12)
