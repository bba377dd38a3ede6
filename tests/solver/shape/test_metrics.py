"""Metrics: equations (3) and (4), and what makes them metrics."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy.special import spence

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh import TriangleMesh
from solver.shape import (
    BiharmonicMetric,
    CommuteTimeMetric,
    DiffusionMetric,
    GeodesicMetric,
    Metric,
    farthest_point_sampling,
)
from solver.shape.choices import METRICS
from solver.shape.geodesics import FastMarching, GeodesicGraph, Geodesics
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum, laplacian
from tests.solver import shapes
from tests.solver.shape.heat import heat_kernel


def make(name: str, mesh: TriangleMesh) -> Metric:
    if name == "geodesic":
        return GeodesicMetric(GeodesicGraph(mesh))
    return spectral(name, laplace_beltrami_spectrum(mesh))


def spectral(name: str, spectrum: Spectrum) -> Metric:
    if name == "diffusion":
        return DiffusionMetric(spectrum, 0.1)
    return CommuteTimeMetric(spectrum) if name == "commute_time" else BiharmonicMetric(spectrum)


@cache
def sphere_spectrum() -> Spectrum:
    """Eigenfunctions of degrees 0 to 9, all of each, on the unit sphere."""
    return laplace_beltrami_spectrum(shapes.icosphere(4), 100)


@pytest.mark.parametrize("shape", ["blob", "torus", "plane_grid", "moebius_strip", "triangle"])
@pytest.mark.parametrize("name", METRICS)
def test_a_metric(name: str, shape: str) -> None:
    metric = make(name, shapes.CONNECTED[shape]())
    points = np.random.default_rng(0).permutation(metric.n_vertices)[:30]
    between = metric.between(points)
    np.testing.assert_array_equal(between, between.T)
    np.testing.assert_array_equal(np.diag(between), 0.0)
    assert (between[~np.eye(len(points), dtype=bool)] > 0.0).all()
    assert (between[:, None] <= between[:, :, None] + between[None] + 1e-12).all()
    rows = metric.distances(points)
    assert rows.shape == (len(points), metric.n_vertices)
    np.testing.assert_allclose(rows[:, points], between, rtol=1e-12)


@pytest.mark.parametrize("name", METRICS)
def test_no_points_no_distances(name: str) -> None:
    metric = make(name, shapes.cube(2))
    nothing = np.zeros(0, dtype=np.int64)
    assert metric.between(nothing).shape == (0, 0)
    assert metric.distances(nothing).shape == (0, 26)


def test_diffusion_is_the_distance_of_heat_kernels() -> None:
    """Both sides of (3): the L2 norm of h_t(x, ·) - h_t(y, ·), and the sum over eigenfunctions."""
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 80)
    points = np.array([0, 100, 200, 641])
    heat = heat_kernel(spectrum, 0.2)[points]
    difference = heat[:, None] - heat[None]
    expected = np.sqrt((difference**2 * spectrum.mass).sum(axis=2))
    np.testing.assert_allclose(DiffusionMetric(spectrum, 0.2).between(points), expected, atol=1e-12)


def test_commute_time_is_twice_the_integral_of_diffusion() -> None:
    """δ² = 2 ∫ d_t² dt, section 3.4, by quadrature in log t."""
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 80)
    points = np.array([0, 100, 200, 641])
    logs = np.linspace(np.log(1e-8), np.log(1e2), 4001)
    squares = np.array(
        [np.exp(u) * DiffusionMetric(spectrum, float(np.exp(u))).between(points) ** 2 for u in logs]
    )
    integral = np.trapezoid(squares, logs, axis=0)
    np.testing.assert_allclose(
        CommuteTimeMetric(spectrum).between(points) ** 2, 2.0 * integral, rtol=1e-5, atol=1e-12
    )


def test_commute_time_with_all_eigenpairs_is_the_effective_resistance() -> None:
    mesh = shapes.cube(3)
    stiffness, _ = laplacian(mesh)
    inverse = np.linalg.pinv(stiffness.toarray())
    diagonal = np.diag(inverse)
    resistance = diagonal[:, None] + diagonal - 2.0 * inverse
    metric = CommuteTimeMetric(laplace_beltrami_spectrum(mesh, mesh.n_vertices))
    np.testing.assert_allclose(
        metric.between(np.arange(mesh.n_vertices)) ** 2, resistance, atol=1e-9
    )


def sphere_angles(points: IntArray) -> FloatArray:
    directions = shapes.icosphere(4).vertices[points]
    return np.arccos(np.clip(directions @ directions.T, -1.0, 1.0))


def legendre_sum(weights: FloatArray, angles: FloatArray) -> FloatArray:
    """Σ (2l + 1)/(4π) w_l P_l(cos θ): the kernel Σ w_l Σ_m Y_lm(x) Y_lm(y) on the unit sphere."""
    factors = (2.0 * np.arange(len(weights)) + 1.0) / (4.0 * np.pi) * weights
    return np.asarray(np.polynomial.legendre.legval(np.cos(angles), factors), dtype=np.float64)


@pytest.mark.parametrize("name", ["diffusion", "commute_time", "biharmonic"])
def test_spectral_metrics_of_the_sphere(name: str) -> None:
    """d² = 2 (g(0) - g(θ)), g being the kernel of the metric's weights, l from 1 to 9."""
    points = np.arange(0, 2562, 50)
    metric = spectral(name, sphere_spectrum())
    eigenvalues = np.arange(1.0, 10.0) * np.arange(2.0, 11.0)
    weights = {
        "diffusion": np.exp(-2.0 * eigenvalues * 0.1),
        "commute_time": 1.0 / eigenvalues,
        "biharmonic": 1.0 / eigenvalues**2,
    }[name]
    kernel = legendre_sum(np.r_[0.0, weights], sphere_angles(points))
    exact = np.sqrt(np.maximum(2.0 * (kernel[0, 0] - kernel), 0.0))
    np.testing.assert_allclose(metric.between(points), exact, atol=0.01 * exact.max())


def test_biharmonic_distances_of_the_sphere_in_closed_form() -> None:
    """Green's function of Δ² on the unit sphere is a dilogarithm, Li₂(1 - v) / 4π + a constant.

    v = sin²(θ/2). It follows from that of Δ, -(1 + log v) / 4π, by integrating the equation
    -((1 - x²) g')' = -(1 + log v) in x = cos θ twice. SciPy's ``spence(v)`` is Li₂(1 - v).
    """
    points = np.arange(0, 2562, 50)
    exact = np.sqrt(
        (np.pi**2 / 6.0 - spence(np.sin(0.5 * sphere_angles(points)) ** 2)) / (2.0 * np.pi)
    )
    found = BiharmonicMetric(sphere_spectrum()).between(points)
    # What is left out, l > 9, is at most Σ 4 (2l + 1) / (4π l² (l + 1)²) = 1 / 100π.
    assert np.abs(found**2 - exact**2).max() < 1.0 / (100.0 * np.pi) + 0.01 * exact.max() ** 2
    antipodes = np.abs(exact - exact.max()) < 1e-3
    np.testing.assert_allclose(found[antipodes], np.sqrt(np.pi / 12.0), rtol=0.01)


def test_biharmonic_with_all_eigenpairs_is_the_greens_function() -> None:
    """d² = g(x, x) + g(y, y) - 2 g(x, y), and L M⁻¹ L g is the identity but for constants."""
    mesh = shapes.cube(3)
    stiffness, mass = laplacian(mesh)
    centring = np.eye(len(mass)) - np.outer(np.ones(len(mass)), mass) / mass.sum()
    green = centring @ np.linalg.pinv(stiffness.toarray()) @ centring.T  # of Δ
    green = green @ np.diag(mass) @ green  # of Δ²
    bilaplacian = stiffness @ np.diag(1.0 / mass) @ stiffness.toarray()
    np.testing.assert_allclose(bilaplacian @ green, centring.T, atol=1e-9)
    diagonal = np.diag(green)
    metric = BiharmonicMetric(laplace_beltrami_spectrum(mesh, mesh.n_vertices))
    np.testing.assert_allclose(
        metric.between(np.arange(mesh.n_vertices)) ** 2,
        diagonal[:, None] + diagonal - 2.0 * green,
        atol=1e-10,
    )


@pytest.mark.parametrize("kind", [CommuteTimeMetric, BiharmonicMetric])
def test_infinite_distances_are_refused(kind: Callable[[Spectrum], Metric]) -> None:
    apart = Spectrum(np.array([0.0, 0.0]), np.array([[1.0, 1.0], [1.0, -1.0]]), np.ones(2))
    with pytest.raises(MeshError, match="not connected"):
        kind(apart)


class Counted:
    """Geodesic distances, and the sources from which they were asked for."""

    def __init__(self, geodesics: Geodesics) -> None:
        self.geodesics = geodesics
        self.sources: list[int] = []

    @property
    def n_vertices(self) -> int:
        return self.geodesics.n_vertices

    def distances(self, sources: IntArray) -> FloatArray:
        self.sources.extend(sources.tolist())
        return self.geodesics.distances(sources)


def test_geodesic_searches_are_not_repeated() -> None:
    """Neither by longer samplings, nor for the distances between samples."""
    counted = Counted(FastMarching(shapes.blob()))
    metric = GeodesicMetric(counted)
    for count in (5, 10, 20):
        sampling = farthest_point_sampling(metric, count)
    between = metric.between(sampling.indices)
    assert len(counted.sources) == len(set(counted.sources))
    np.testing.assert_allclose(between, sampling.distances, rtol=0.02)
    assert (between <= sampling.distances).all()
    fresh = GeodesicMetric(FastMarching(shapes.blob()))
    np.testing.assert_array_equal(between, fresh.between(sampling.indices))


def test_of_more_rows_than_are_kept_those_kept_are_not_searched_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mesh = shapes.blob()
    monkeypatch.setattr("solver.shape.metrics._CACHED_BYTES", 8 * 8 * mesh.n_vertices)
    counted = Counted(GeodesicGraph(mesh))
    metric = GeodesicMetric(counted)
    points = np.arange(20) * 30
    metric.between(points[:10])
    between = metric.between(points)
    assert len(counted.sources) == 10 + 12
    np.testing.assert_array_equal(between, GeodesicMetric(GeodesicGraph(mesh)).between(points))


def test_geodesic_distances_kept_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = shapes.blob()
    monkeypatch.setattr("solver.shape.metrics._CACHED_BYTES", 3 * 8 * mesh.n_vertices)
    counted = Counted(GeodesicGraph(mesh))
    metric = GeodesicMetric(counted)
    asked = np.array([0, 1, 2, 0, 3, 0, 1])
    found = metric.distances(asked)
    assert counted.sources == [0, 1, 2, 3, 1]  # 1 was the one longest not asked for
    np.testing.assert_array_equal(found, GeodesicGraph(mesh).distances(asked))
    found[:] = -1.0
    assert (metric.distances(asked) >= 0.0).all()
