"""Metrics: equations (3) and (4), and what makes them metrics."""

import numpy as np
import pytest

from solver.errors import MeshError
from solver.geodesics import GeodesicGraph
from solver.mesh import TriangleMesh
from solver.metrics import (
    BiharmonicMetric,
    CommuteTimeMetric,
    DiffusionMetric,
    GeodesicMetric,
    Metric,
)
from solver.spectrum import Spectrum, laplace_beltrami_spectrum, laplacian
from solver.structures import METRICS
from tests.solver import shapes


def make(name: str, mesh: TriangleMesh) -> Metric:
    if name == "geodesic":
        return GeodesicMetric(GeodesicGraph(mesh))
    spectrum = laplace_beltrami_spectrum(mesh)
    if name == "diffusion":
        return DiffusionMetric(spectrum, 0.1)
    return CommuteTimeMetric(spectrum) if name == "commute_time" else BiharmonicMetric(spectrum)


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
    heat = spectrum.heat_kernel(0.2)[points]
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


def test_behaviour_under_scaling() -> None:
    """Geodesics grow with the shape, commute times stay, diffusion needs its time scaled."""
    mesh, points = shapes.blob(), np.array([0, 50, 500])
    larger = shapes.moved(mesh, seed=1, scale=10.0)
    spectra = laplace_beltrami_spectrum(mesh), laplace_beltrami_spectrum(larger)
    geodesic = [make("geodesic", m).between(points) for m in (mesh, larger)]
    np.testing.assert_allclose(geodesic[1], 10.0 * geodesic[0], rtol=1e-9)
    commute = [CommuteTimeMetric(s).between(points) for s in spectra]
    np.testing.assert_allclose(commute[1], commute[0], rtol=1e-7)
    diffusion = [
        DiffusionMetric(s, t).between(points) for s, t in zip(spectra, (0.1, 10.0), strict=True)
    ]
    np.testing.assert_allclose(10.0 * diffusion[1], diffusion[0], rtol=1e-7)


def test_infinite_commute_times_are_refused() -> None:
    apart = Spectrum(np.array([0.0, 0.0]), np.array([[1.0, 1.0], [1.0, -1.0]]), np.ones(2))
    with pytest.raises(MeshError, match="not connected"):
        CommuteTimeMetric(apart)


@pytest.mark.parametrize("time", [0.0, -1.0, np.inf, np.nan])
def test_diffusion_times_without_meaning(time: float) -> None:
    with pytest.raises(ValueError, match="positive"):
        DiffusionMetric(laplace_beltrami_spectrum(shapes.cube(2)), time)
