"""Interpolated distances against closed forms."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.gmds import InterpolatedMetric, SurfacePoints
from solver.mesh import TriangleMesh
from solver.shape import EmbeddedMetric, Shape
from tests.solver import shapes
from tests.solver.gmds.surfaces import StraightMetric, random_points


class CountedMetric(StraightMetric):
    """A metric that says which vertices it was asked for."""

    def __init__(self, mesh: TriangleMesh) -> None:
        super().__init__(mesh)
        self.asked: list[int] = []

    def distances(self, sources: IntArray) -> FloatArray:
        self.asked += sources.tolist()
        return super().distances(sources)


@pytest.mark.parametrize("embedded", [True, False])
def test_a_plane_is_exact_near_and_far(embedded: bool) -> None:
    mesh = shapes.plane_grid()
    metric = EmbeddedMetric(mesh.vertices) if embedded else StraightMetric(mesh)
    points = random_points(mesh, 0, 80)
    u = points.barycentric  # and further points of the same triangles
    points = SurfacePoints(np.tile(points.faces, 2), np.concatenate([u, np.roll(u, 1, axis=1)]))
    places = points.positions(mesh.vertices, mesh.faces)
    exact = np.linalg.norm(places[:, None] - places, axis=2)
    found = InterpolatedMetric(metric, mesh).between(points)
    np.testing.assert_allclose(found, exact, atol=2e-8)


@pytest.mark.parametrize("metric", ["diffusion", "commute_time", "biharmonic"])
def test_a_spectral_metric_is_that_of_the_interpolated_embedding(metric: str) -> None:
    shape = Shape(shapes.blob(2), eigenpairs=40)
    points = random_points(shape.surface, 1, 40)
    known = shape.metric(metric)
    assert isinstance(known, EmbeddedMetric)
    images = points.positions(known.embedding, shape.surface.faces)
    exact = np.linalg.norm(images[:, None] - images, axis=2)
    found = InterpolatedMetric(known, shape.surface).between(points)
    np.testing.assert_allclose(found, exact, atol=1e-7 * exact.max())


def test_great_circles() -> None:
    mesh = shapes.icosphere(3)
    points = random_points(mesh, 2, 40)
    places = points.positions(mesh.vertices, mesh.faces)
    places /= np.linalg.norm(places, axis=1)[:, None]
    exact = np.arccos(np.clip(places @ places.T, -1.0, 1.0))

    class Arcs(StraightMetric):
        def distances(self, sources: IntArray) -> FloatArray:
            cosines = self.vertices[sources] @ self.vertices.T
            arcs: FloatArray = np.arccos(np.clip(cosines, -1.0, 1.0))
            return arcs

    found = InterpolatedMetric(Arcs(mesh), mesh).between(points)
    ends = mesh.vertices[mesh.edges]
    edge = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).max()
    # Circles of radius r are curved like cot r and not like 1/r; near the antipodes that matters.
    assert np.abs(found - exact)[exact < 2.0].max() < edge**2 / 3.0


def test_only_corners_that_count_are_asked_for() -> None:
    mesh = shapes.plane_grid()
    metric = CountedMetric(mesh)
    interpolated = InterpolatedMetric(metric, mesh)
    assert not metric.asked
    interpolated.squares_from(3, np.array([0.5, 0.0, 0.5]))
    assert metric.asked == mesh.faces[3, [0, 2]].tolist()
