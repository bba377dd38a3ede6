"""Varadhan distances: geodesic ones on a sphere, bounded, and made of the heat kernel."""

import numpy as np
import pytest

from solver.shape import Shape, varadhan_distances
from solver.shape.laplacian import laplace_beltrami_spectrum
from tests.solver import shapes
from tests.solver.shape.heat import heat_kernel


def test_geodesic_distances_on_a_sphere() -> None:
    """Varadhan's formula, which at t = 0.2 r² neglects 2t log (θ / sin θ) of θ²."""
    mesh = shapes.icosphere(3)
    spectrum = laplace_beltrami_spectrum(mesh, 144)  # all of degree 11 and less
    points = np.arange(0, mesh.n_vertices, 7)
    found = varadhan_distances(spectrum, points, 0.2)
    unit = mesh.vertices[points] / np.linalg.norm(mesh.vertices[points], axis=1)[:, None]
    angles = np.arccos(np.clip(unit @ unit.T, -1.0, 1.0))
    near = (angles > 1e-6) & (angles < 2.0)
    np.testing.assert_allclose(found[near], angles[near], rtol=0.06)
    np.testing.assert_array_equal(found, found.T)
    np.testing.assert_array_equal(np.diag(found), 0.0)


def test_bounded_where_the_heat_kernel_vanishes() -> None:
    mesh = shapes.tube(8, 200, 0.01)
    ends = np.array([0, mesh.n_vertices - 1])
    found = varadhan_distances(laplace_beltrami_spectrum(mesh, 100), ends, 1e-3)
    assert found[0, 1] == pytest.approx(2.0 * np.sqrt(1e-3 * np.log(1e9)))


def test_they_follow_from_the_heat_kernel_and_scale() -> None:
    spectrum = Shape(shapes.blob()).spectrum()
    points = np.arange(12) * 20
    kernel = heat_kernel(spectrum, 0.2)[np.ix_(points, points)]
    own = np.diag(kernel)
    expected = np.sqrt(-0.8 * np.log(kernel / np.sqrt(own[:, None] * own)))
    found = varadhan_distances(spectrum, points, 0.2)
    np.testing.assert_allclose(found, np.nan_to_num(expected), atol=1e-7)
    larger = varadhan_distances(spectrum.scaled(3.0), points, 9.0 * 0.2)
    np.testing.assert_allclose(larger, 3.0 * found, atol=1e-7)
