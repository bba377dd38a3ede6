"""Farthest point sampling: covering, progressive, independent of numbering."""

import itertools

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.mesh import TriangleMesh
from solver.shape import (
    CommuteTimeMetric,
    GeodesicMetric,
    Metric,
    Shape,
    euclidean_farthest_points,
    farthest_point_sampling,
)
from solver.shape.choices import METRICS
from solver.shape.geodesics import GeodesicGraph
from solver.shape.laplacian import laplace_beltrami_spectrum
from solver.shape.sampling import extremity
from tests.solver import shapes
from tests.solver.shape.test_metrics import make


def geodesic(mesh: TriangleMesh) -> Metric:
    return GeodesicMetric(GeodesicGraph(mesh))


@pytest.mark.parametrize("shape", ["blob", "cube", "plane_grid", "tube"])
@pytest.mark.parametrize("name", METRICS)
def test_radii_cover_the_shape_and_samples_are_apart(name: str, shape: str) -> None:
    metric = make(name, shapes.CONNECTED[shape]())
    sampling = farthest_point_sampling(metric, 25)
    assert len(sampling) == 25
    rows = metric.distances(sampling.indices)
    covering = np.minimum.accumulate(rows, axis=0).max(axis=1)
    np.testing.assert_allclose(sampling.radii, covering, rtol=1e-12)
    assert (np.diff(sampling.radii) <= 0.0).all()
    np.testing.assert_allclose(sampling.distances, metric.between(sampling.indices), rtol=1e-12)
    np.testing.assert_array_equal(sampling.distances, sampling.distances.T)
    # Each sample was the farthest from those before: exactly the covering radius away.
    for i in range(1, 25):
        assert sampling.distances[i, :i].min() == pytest.approx(sampling.radii[i - 1], rel=1e-12)


def test_progressive() -> None:
    metric = geodesic(shapes.blob())
    long, short = farthest_point_sampling(metric, 40), farthest_point_sampling(metric, 7)
    first = long.first(7)
    for one, other in ((first.indices, short.indices), (first.radii, short.radii)):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(first.distances, short.distances)
    with pytest.raises(ValueError, match="40 samples"):
        long.first(41)


@pytest.mark.parametrize("method", ["fast_marching", "heat"])
def test_distances_do_not_depend_on_the_order_of_the_samples(method: str) -> None:
    """The directions between two vertices differ by the error of the method."""
    shape = Shape(shapes.blob(), geodesic_method=method)
    samples = shape.sampling("geodesic", 8)
    metric, backwards = shape.metric("geodesic"), samples.indices[::-1]
    again = Shape(shapes.blob(), geodesic_method=method).sampling(
        "geodesic", 8, tuple(backwards.tolist())
    )
    np.testing.assert_array_equal(again.indices, backwards)
    np.testing.assert_array_equal(again.distances[::-1, ::-1], samples.distances)
    one_way = metric.distances(samples.indices)[:, samples.indices]
    assert (one_way != one_way.T).any()
    np.testing.assert_array_equal(samples.distances, np.minimum(one_way, one_way.T))


def test_within_twice_the_best_covering() -> None:
    """Gonzalez' guarantee, against all choices of samples on a small mesh."""
    metric = geodesic(shapes.cube(2))
    distances = metric.between(np.arange(metric.n_vertices))
    for count in (1, 2, 3):
        best = min(
            distances[list(choice)].min(axis=0).max()
            for choice in itertools.combinations(range(metric.n_vertices), count)
        )
        assert farthest_point_sampling(metric, count).radii[-1] <= 2.0 * best + 1e-12


@pytest.mark.parametrize("seed", range(5))
def test_numbering_does_not_matter(seed: int) -> None:
    mesh = shapes.blob()
    renumbered, where = shapes.permuted(mesh, seed)
    sampling = farthest_point_sampling(geodesic(mesh), 20)
    other = farthest_point_sampling(geodesic(renumbered), 20)
    np.testing.assert_array_equal(where[sampling.indices], other.indices)
    np.testing.assert_allclose(other.radii, sampling.radii, rtol=1e-9)


def test_extremities_come_first() -> None:
    tube = shapes.tube()
    assert tube.vertices[extremity(geodesic(tube)), 2] in (0.0, 1.0)
    sheet = shapes.plane_grid(31, 21, 1.5)
    corners = sheet.vertices[farthest_point_sampling(geodesic(sheet), 2).indices, :2]
    np.testing.assert_allclose(np.abs(corners[0] - corners[1]), [1.5, 1.0])
    # The blob's bumps: local maxima of the distance from its middle.
    blob = shapes.blob()
    radius = np.linalg.norm(blob.vertices, axis=1)
    tips = farthest_point_sampling(CommuteTimeMetric(laplace_beltrami_spectrum(blob)), 4).indices
    neighbours: dict[int, set[int]] = {int(v): set() for v in tips}
    for i, j in blob.edges.tolist():
        for v, w in ((i, j), (j, i)):
            if v in neighbours:
                neighbours[v].add(w)
    for tip, around in neighbours.items():
        assert radius[tip] > 1.5
        assert radius[tip] >= 0.97 * max(radius[w] for w in around)


@pytest.mark.parametrize("name", METRICS)
def test_an_extremity_is_an_end_of_a_diameter(name: str) -> None:
    """No vertex is farther from any other than the two ends are from one another, or hardly."""
    metric = make(name, shapes.blob())
    distances = metric.between(np.arange(metric.n_vertices))
    assert distances[extremity(metric)].max() >= 0.98 * distances.max()


def test_a_given_start() -> None:
    sampling = farthest_point_sampling(geodesic(shapes.plane_grid()), 3, first=[5])
    assert sampling.indices[0] == 5


def test_all_vertices_in_the_end() -> None:
    mesh = shapes.tetrahedron()
    sampling = farthest_point_sampling(geodesic(mesh), 4)
    assert sorted(sampling.indices.tolist()) == [0, 1, 2, 3]
    assert sampling.radii[-1] == 0.0


class _Coinciding:
    """Ten vertices at one place and one at another."""

    n_vertices = 11

    def distances(self, sources: IntArray) -> FloatArray:
        places = (np.arange(11) == 4).astype(np.float64)
        rows: FloatArray = np.abs(places[sources][:, None] - places)
        return rows

    def between(self, points: IntArray) -> FloatArray:
        return self.distances(points)[:, points]


def test_coinciding_vertices_are_sampled_once_each() -> None:
    sampling = farthest_point_sampling(_Coinciding(), 11)
    assert sorted(sampling.indices.tolist()) == list(range(11))
    assert sampling.radii[1] == 0.0


def test_refusals() -> None:
    metric = geodesic(shapes.tetrahedron())
    with pytest.raises(OptionError, match="points: the shape has only 4 vertices"):
        farthest_point_sampling(metric, 5)
    with pytest.raises(ValueError, match="at least 1"):
        farthest_point_sampling(metric, 0)


def test_points_spread_in_space_are_each_the_farthest_from_those_before() -> None:
    points = np.random.default_rng(4).normal(size=(60, 3))
    chosen = euclidean_farthest_points(points, 60)
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    assert chosen[0] == np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1))
    for place in range(1, 59):
        assert chosen[place] == np.argmax(apart[chosen[:place]].min(axis=0))
    assert sorted(chosen) == list(range(60))
    np.testing.assert_array_equal(euclidean_farthest_points(points, 7), chosen[:7])


def test_points_that_coincide_are_each_taken_once() -> None:
    points = np.repeat(np.eye(3), 3, axis=0)
    assert sorted(euclidean_farthest_points(points, 9)) == list(range(9))
