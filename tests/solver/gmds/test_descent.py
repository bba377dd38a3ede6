"""Minimisation of the stress (7): never up, and to the truth where it is known."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control, Status
from solver.errors import Cancelled
from solver.gmds import (
    Fields,
    InterpolatedMetric,
    SurfacePoints,
    Term,
    descent_model,
    gmds,
    share,
    stress,
)
from solver.shape import EmbeddedMetric, Shape
from tests.solver import shapes
from tests.solver.gmds.surfaces import (
    StraightMetric,
    blob_twice,
    nearest_vertices,
    plane_points,
    random_points,
)


def distances_among(places: FloatArray) -> FloatArray:
    apart: FloatArray = np.linalg.norm(places[:, None] - places, axis=2)
    return apart


def even(places: FloatArray, target: InterpolatedMetric) -> Term:
    """All distances of some places, with equal weights."""
    return Term(distances_among(places), target, np.ones((len(places), len(places))))


def plane_metric() -> InterpolatedMetric:
    mesh = shapes.plane_grid()
    return InterpolatedMetric(EmbeddedMetric(mesh.vertices), mesh)


@pytest.mark.parametrize("seed", range(4))
def test_points_of_a_plane_are_found_between_its_vertices(seed: int) -> None:
    target = plane_metric()
    truth = plane_points(seed, 16)
    noise = np.random.default_rng(seed).normal(scale=0.05, size=truth.shape)
    start = nearest_vertices(target.surface, truth + noise)
    start_points = SurfacePoints.at_vertices(target.surface, start)
    found = gmds([even(truth, target)], start_points, tolerance=1e-12)
    assert found.status is Status.CONVERGED
    assert found.value < 1e-12
    assert found.history[0] > 0.1
    places = found.answer.positions(target.surface.vertices, target.surface.faces)
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
        [Term(distances_among(truth), target, weights)],
        SurfacePoints.at_vertices(mesh, start),
        tolerance=1e-12,
    )
    places = found.answer.positions(mesh.vertices, mesh.faces)
    np.testing.assert_allclose(places[4:], truth[4:], atol=1e-4)


class CrookedMetric(StraightMetric):
    """Longer one way than the other, as fast marching's distances are."""

    def distances(self, sources: IntArray) -> FloatArray:
        slope = np.arange(self.n_vertices) / self.n_vertices
        crooked: FloatArray = super().distances(sources) * (1.0 + 0.05 * slope)
        return crooked


@pytest.mark.parametrize("name", sorted(shapes.CONNECTED))
def test_the_stress_never_rises(name: str) -> None:
    shape = Shape(shapes.CONNECTED[name]())
    random = np.random.default_rng(0)
    metrics = shape.metric("geodesic"), CrookedMetric(shape.surface)
    for metric in metrics:
        target = InterpolatedMetric(metric, shape.surface)
        start = random_points(shape.surface, 0, 9)
        source = distances_among(random.uniform(size=(9, 3)))
        weights = random.uniform(size=(9, 9))
        weights += weights.T
        found = gmds([Term(source, target, weights)], start, iterations=6)
        course = np.array(found.history)
        assert len(course) == found.iterations + 1
        assert (np.diff(course) <= 1e-12 * course[0]).all()
        assert found.value == found.history[-1]
        for points, value in (start, found.history[0]), (found.answer, found.value):
            assert value == pytest.approx(stress(source, target.between(points), weights))
        assert (found.answer.barycentric >= 0.0).all()


def test_another_triangulation_of_a_surface_is_matched_between_its_vertices() -> None:
    first, second = blob_twice()
    source, target = Shape(first), Shape(second)
    sampled = source.sampling("geodesic", 20).indices
    truth = first.vertices[sampled]
    random = np.random.default_rng(3)
    start = nearest_vertices(second, truth + random.normal(scale=0.1, size=truth.shape))
    metric = InterpolatedMetric(target.metric("geodesic"), target.surface)
    found = gmds(
        [Term(source.metric("geodesic").between(sampled), metric, np.ones((20, 20)))],
        SurfacePoints.at_vertices(second, start),
    )

    def error(places: FloatArray) -> float:
        return float(np.linalg.norm(places - truth, axis=1).mean())

    after = error(found.answer.positions(second.vertices, second.faces))
    assert after < 0.35 * error(second.vertices[start])
    # No choice of vertices comes near.
    assert after < 0.5 * error(second.vertices[nearest_vertices(second, truth)])


def test_terms_add_up() -> None:
    shape = Shape(shapes.blob(2), eigenpairs=30)
    targets = [
        InterpolatedMetric(shape.metric(m), shape.surface) for m in ("geodesic", "diffusion")
    ]
    start = random_points(shape.surface, 5, 10)
    random = np.random.default_rng(5)
    sources = [distances_among(random.uniform(size=(10, 3))) for _ in targets]
    weights = np.where(np.eye(10), 0.0, 3.0)
    terms = [
        Term(sources[0], targets[0], np.ones((10, 10))),
        Term(sources[1], targets[1], weights),
    ]
    found = gmds(terms, start)
    assert found.value < found.history[0]
    for points, value in (start, found.history[0]), (found.answer, found.value):
        expected = sum(term.stress(points) for term in terms)
        assert value == pytest.approx(expected)


def test_kernels_agree_with_numpy() -> None:
    shape = Shape(shapes.blob(2), eigenpairs=30)
    target = InterpolatedMetric(shape.metric("diffusion"), shape.surface)
    mesh, charts = shape.surface, target.charts
    points = random_points(mesh, 4, 12)
    squares = np.array(
        [target.squares_from(f, u) for f, u in zip(points.faces, points.barycentric, strict=True)],
        dtype=np.float32,
    )
    random = np.random.default_rng(4)
    source = distances_among(random.uniform(size=(12, 3)))
    weights = random.uniform(size=(12, 12))
    np.fill_diagonal(weights, 0.0)
    fields = Fields(charts, target.edges[None], squares[None], source[None], weights[None])
    between = target.between(points)
    for i in range(12):
        expected = (weights[i] * (between[i] - source[i]) ** 2).sum()
        here = int(points.faces[i]), points.barycentric[i]
        found = share(fields, points.faces, points.barycentric, i, squares[i][None], *here)
        assert found == pytest.approx(expected)
        model = descent_model(fields, i, *here)
        assert model[0] == pytest.approx(expected)
        _check_derivatives(fields, i, here, model)


def _check_derivatives(
    fields: Fields, i: int, here: tuple[int, FloatArray], model: tuple[float, ...]
) -> None:
    """Gradient and Gauss-Newton matrix against finite differences of distances in the chart."""
    face, u = here
    base, along, height = fields.charts.corners[face]
    corners, edges = fields.charts.faces[face], fields.edges[0, face]
    others = np.arange(len(fields.source[0])) != i
    step = 1e-6

    def distances(x: float, y: float) -> FloatArray:
        du = np.array([0.0, (x - y / height * along) / base, y / height])
        du[0] = -du.sum()
        v = u + du
        inner = v[1] * v[2] * edges[0] + v[2] * v[0] * edges[1] + v[0] * v[1] * edges[2]
        apart: FloatArray = np.sqrt(fields.squares[0][others][:, corners] @ v - inner)
        return apart

    slopes = np.stack(
        [
            (distances(step, 0.0) - distances(-step, 0.0)) / (2.0 * step),
            (distances(0.0, step) - distances(0.0, -step)) / (2.0 * step),
        ]
    )
    weights = fields.weights[0, i][others]
    gradient = 2.0 * slopes @ (weights * (distances(0.0, 0.0) - fields.source[0, i][others]))
    matrix = 2.0 * (slopes * weights) @ slopes.T
    np.testing.assert_allclose(model[1:3], gradient, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(
        [model[3], model[4], model[5]], [matrix[0, 0], matrix[0, 1], matrix[1, 1]], rtol=1e-5
    )


def test_cancellation_and_deadline() -> None:
    target = plane_metric()
    truth = plane_points(0, 8)
    start = SurfacePoints.at_vertices(target.surface, np.arange(8))
    term = even(truth, target)
    with pytest.raises(Cancelled):
        gmds([term], start, control=Control(is_cancelled=lambda: True))
    found = gmds([term], start, control=Control().within(0.0))
    assert found.status is Status.DEADLINE
    assert found.value == found.history[0]
    once = gmds([term], start, iterations=1)
    assert once.status is Status.ITERATIONS
    assert once.iterations == 1


def test_wrong_shapes_are_refused() -> None:
    target = plane_metric()
    start = SurfacePoints.at_vertices(target.surface, np.arange(8))
    with pytest.raises(ValueError, match="8 points need"):
        gmds([Term(np.zeros((7, 7)), target, np.ones((7, 7)))], start)
    with pytest.raises(ValueError, match="another mesh"):
        InterpolatedMetric(EmbeddedMetric(np.zeros((5, 3))), target.surface)
