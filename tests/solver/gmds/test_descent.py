"""Minimisation of the stress (7): never up, and to the truth where it is known."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import Cancelled
from solver.gmds import InterpolatedMetric, Status, SurfacePoints, gmds
from solver.gmds.stress import costs_of_vertices, descent_model, share, stress
from solver.gmds.surface import Charts, charts_of
from solver.metrics import EmbeddedMetric
from solver.shape import Shape
from tests.solver import shapes
from tests.solver.gmds.surfaces import blob_twice, nearest_vertices, plane_points, random_points


def distances_among(places: FloatArray) -> FloatArray:
    apart: FloatArray = np.linalg.norm(places[:, None] - places, axis=2)
    return apart


def plane_metric() -> InterpolatedMetric:
    mesh = shapes.plane_grid()
    return InterpolatedMetric(EmbeddedMetric(mesh.vertices), mesh)


@pytest.mark.parametrize("leaps", [0, 2])
@pytest.mark.parametrize("seed", range(4))
def test_points_of_a_plane_are_found_between_its_vertices(seed: int, leaps: int) -> None:
    target = plane_metric()
    truth = plane_points(seed, 16)
    noise = np.random.default_rng(seed).normal(scale=0.05, size=truth.shape)
    start = nearest_vertices(target.surface, truth + noise)
    start_points = SurfacePoints.at_vertices(target.surface, start)
    found = gmds(distances_among(truth), target, start_points, leaps=leaps, tolerance=1e-12)
    assert found.status is Status.CONVERGED
    assert found.stress < 1e-12
    assert found.initial_stress > 0.1
    places = found.points.positions(target.surface.vertices, target.surface.faces)
    np.testing.assert_allclose(distances_among(places), distances_among(truth), atol=1e-6)


def test_points_fixed_by_weights_determine_the_rest() -> None:
    """A point that knows its distances to three others alone is where these say."""
    target = plane_metric()
    truth = plane_points(7, 12)
    mesh = target.surface
    fixed = nearest_vertices(mesh, truth[:4])
    truth[:4] = mesh.vertices[fixed]
    weights = np.zeros((12, 12))
    weights[4:, :4] = weights[:4, 4:] = 1.0
    weights[:4, :4] = 1e6  # these stay where they are
    start = nearest_vertices(mesh, truth)
    found = gmds(
        distances_among(truth),
        target,
        SurfacePoints.at_vertices(mesh, start),
        weights=weights,
        tolerance=1e-12,
    )
    places = found.points.positions(mesh.vertices, mesh.faces)
    np.testing.assert_allclose(places[4:], truth[4:], atol=1e-4)


class CrookedMetric(EmbeddedMetric):
    """Longer one way than the other, as fast marching's distances are."""

    def distances(self, sources: IntArray) -> FloatArray:
        slope = np.arange(self.n_vertices) / self.n_vertices
        crooked: FloatArray = super().distances(sources) * (1.0 + 0.05 * slope)
        return crooked


@pytest.mark.parametrize("leaps", [0, 1])
@pytest.mark.parametrize("name", sorted(shapes.CONNECTED))
def test_the_stress_never_rises(name: str, leaps: int) -> None:
    shape = Shape(shapes.CONNECTED[name]())
    random = np.random.default_rng(0)
    metrics = shape.metric("geodesic"), CrookedMetric(shape.surface.vertices)
    for metric in metrics:
        target = InterpolatedMetric(metric, shape.surface)
        start = random_points(shape.surface, 0, 9)
        source = distances_among(random.uniform(size=(9, 3)))
        weights = random.uniform(size=(9, 9))
        weights += weights.T
        found = gmds(source, target, start, weights=weights, leaps=leaps, iterations=6)
        course = np.array([found.initial_stress, *found.history])
        assert (np.diff(course) <= 1e-12 * course[0]).all()
        assert found.stress == found.history[-1]
        for points, value in (start, found.initial_stress), (found.points, found.stress):
            assert value == pytest.approx(stress(source, target.between(points), weights))
        assert (found.points.barycentric >= 0.0).all()


def test_another_triangulation_of_a_surface_is_matched_between_its_vertices() -> None:
    first, second = blob_twice()
    source, target = Shape(first), Shape(second)
    sampled = source.sampling("geodesic", 20).indices
    truth = first.vertices[sampled]
    random = np.random.default_rng(3)
    start = nearest_vertices(second, truth + random.normal(scale=0.1, size=truth.shape))
    metric = InterpolatedMetric(target.metric("geodesic"), target.surface)
    found = gmds(
        source.metric("geodesic").between(sampled),
        metric,
        SurfacePoints.at_vertices(second, start),
    )

    def error(places: FloatArray) -> float:
        return float(np.linalg.norm(places - truth, axis=1).mean())

    after = error(found.points.positions(second.vertices, second.faces))
    assert after < 0.35 * error(second.vertices[start])
    # No choice of vertices comes near.
    assert after < 0.5 * error(second.vertices[nearest_vertices(second, truth)])


def test_kernels_agree_with_numpy() -> None:
    shape = Shape(shapes.blob(2), eigenpairs=30)
    target = InterpolatedMetric(shape.metric("diffusion"), shape.surface)
    mesh, charts = shape.surface, charts_of(shape.surface)
    points = random_points(mesh, 4, 12)
    fields = np.array(
        [target.squares_from(f, u) for f, u in zip(points.faces, points.barycentric, strict=True)]
    )
    random = np.random.default_rng(4)
    source = distances_among(random.uniform(size=(12, 3)))
    weights = random.uniform(size=(12, 12))
    between = target.between(points)
    for i in range(12):
        others = np.arange(12) != i
        expected = (weights[i] * (between[i] - source[i]) ** 2)[others].sum()
        here = int(points.faces[i]), points.barycentric[i]
        found = share(
            fields, fields[i], charts, target.edges, points.faces, points.barycentric, i, *here,
            source[i], weights[i],
        )  # fmt: skip
        assert found == pytest.approx(expected)
        costs = costs_of_vertices(fields, np.arange(mesh.n_vertices), i, source[i], weights[i])
        spread = (np.sqrt(fields) - source[i][:, None]) ** 2
        np.testing.assert_allclose(costs, weights[i][others] @ spread[others])
        model = descent_model(fields, charts, target.edges, i, *here, source[i], weights[i])
        assert model[0] == pytest.approx(expected)
        _check_derivatives(fields, charts, target, i, here, source[i], weights[i], model)


def _check_derivatives(
    fields: FloatArray,
    charts: Charts,
    target: InterpolatedMetric,
    i: int,
    here: tuple[int, FloatArray],
    source: FloatArray,
    weights: FloatArray,
    model: tuple[float, ...],
) -> None:
    """Gradient and Gauss-Newton matrix against finite differences of distances in the chart."""
    face, u = here
    base, along, height = charts.corners[face]
    step = 1e-6

    def distances(x: float, y: float) -> FloatArray:
        du = np.array([0.0, (x - y / height * along) / base, y / height])
        du[0] = -du.sum()
        v = u + du
        corners = charts.faces[face]
        edges = target.edges[face]
        inner = v[1] * v[2] * edges[0] + v[2] * v[0] * edges[1] + v[0] * v[1] * edges[2]
        apart: FloatArray = np.sqrt(np.delete(fields[:, corners], i, axis=0) @ v - inner)
        return apart

    value = distances(0.0, 0.0)
    slopes = np.stack(
        [
            (distances(step, 0.0) - distances(-step, 0.0)) / (2.0 * step),
            (distances(0.0, step) - distances(0.0, -step)) / (2.0 * step),
        ]
    )
    w = np.delete(weights, i)
    gradient = 2.0 * slopes @ (w * (value - np.delete(source, i)))
    matrix = 2.0 * (slopes * w) @ slopes.T
    np.testing.assert_allclose(model[1:3], gradient, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(
        [model[3], model[4], model[5]], [matrix[0, 0], matrix[0, 1], matrix[1, 1]], rtol=1e-5
    )


def test_cancellation_and_deadline() -> None:
    target = plane_metric()
    truth = plane_points(0, 8)
    start = SurfacePoints.at_vertices(target.surface, np.arange(8))
    with pytest.raises(Cancelled):
        gmds(distances_among(truth), target, start, control=Control(is_cancelled=lambda: True))
    found = gmds(distances_among(truth), target, start, control=Control().within(0.0))
    assert found.status is Status.DEADLINE
    assert found.stress == found.initial_stress
    once = gmds(distances_among(truth), target, start, iterations=1)
    assert once.status is Status.ITERATIONS
    assert once.iterations == 1


def test_wrong_shapes_are_refused() -> None:
    target = plane_metric()
    start = SurfacePoints.at_vertices(target.surface, np.arange(8))
    with pytest.raises(ValueError, match="8 points need"):
        gmds(np.zeros((7, 7)), target, start)
    with pytest.raises(ValueError, match="another mesh"):
        InterpolatedMetric(EmbeddedMetric(np.zeros((5, 3))), target.surface)
