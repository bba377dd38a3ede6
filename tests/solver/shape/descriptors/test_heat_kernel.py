"""Heat kernel signatures: closed forms and invariances."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh
from solver.shape.choices import HEAT_TIMES
from solver.shape.descriptors import heat_kernel_signature, scale_invariant_heat_kernel_signature
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum
from tests.solver import shapes
from tests.solver.shape.heat import heat_kernel


def hks(spectrum: Spectrum, times: Sequence[float] | FloatArray = HEAT_TIMES) -> FloatArray:
    return heat_kernel_signature(spectrum, np.array(times), np.arange(len(spectrum.mass)))


def si_hks(spectrum: Spectrum, frequencies: int = 6) -> FloatArray:
    everywhere = np.arange(len(spectrum.mass))
    return scale_invariant_heat_kernel_signature(spectrum, frequencies, everywhere)


def whole_spectrum(mesh: TriangleMesh) -> Spectrum:
    """About a hundred eigenpairs, none of them part of a repeated eigenvalue cut by truncation.

    What is left of such an eigenvalue depends on the basis that the eigensolver happens to choose.
    """
    spectrum = laplace_beltrami_spectrum(mesh, 110)
    gaps = np.diff(spectrum.eigenvalues) > 1e-3 * spectrum.eigenvalues[1:]
    return spectrum.truncated(int(np.flatnonzero(gaps)[-1]) + 1)


def test_hks_of_the_sphere() -> None:
    """h_t(x, x) = Σ (2l+1)/(4π) exp(-l(l+1)t), the same everywhere; relative to its mean, 1."""
    times = np.array([0.05, 0.1, 0.3, 1.0])
    spectrum = laplace_beltrami_spectrum(shapes.icosphere(4), 100)  # l = 0..9 are complete
    degrees = np.arange(10)[:, None]
    exact = ((2 * degrees + 1) * np.exp(-degrees * (degrees + 1) * times)).sum(axis=0) / (4 * np.pi)
    kernel = np.stack([np.diag(heat_kernel(spectrum, t)) for t in times], axis=1)
    np.testing.assert_allclose(kernel, np.tile(exact, (len(kernel), 1)), rtol=0.02)
    signature = hks(spectrum, times)
    np.testing.assert_allclose(signature, 1.0 / np.sqrt(4), rtol=0.015)


def test_hks_is_the_diagonal_of_the_heat_kernel_over_its_mean() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 60)
    signature = hks(spectrum, (0.3, 2.0))
    for column, time in zip(signature.T, (0.3, 2.0), strict=True):
        diagonal = np.diag(heat_kernel(spectrum, time))
        mean = spectrum.mass @ diagonal / spectrum.area
        np.testing.assert_allclose(column * np.sqrt(2), diagonal / mean, rtol=1e-9)


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_every_component_of_hks_has_mean_one(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    spectrum = laplace_beltrami_spectrum(mesh.scaled(1.0 / np.sqrt(mesh.area)))
    signature = hks(spectrum)
    assert signature.shape == (mesh.n_vertices, 32)
    means = spectrum.mass @ signature / spectrum.area
    np.testing.assert_allclose(means * np.sqrt(32), 1.0, rtol=1e-9)


def test_hks_is_large_at_extremities() -> None:
    """Heat stays longest where the surface is a tip."""
    mesh = shapes.blob()
    spectrum = laplace_beltrami_spectrum(mesh.scaled(1.0 / np.sqrt(mesh.area)))
    heat = hks(spectrum)[:, 12]
    radius = np.linalg.norm(mesh.vertices, axis=1)
    assert np.corrcoef(heat, radius)[0, 1] > 0.85
    assert radius[np.argmax(heat)] > 2.0


@pytest.mark.parametrize("scale", [1e-4, 0.1, 37.0])
@pytest.mark.parametrize("name", ["blob", "plane_grid", "torus", "cube"])
def test_si_hks_does_not_change_with_scale(name: str, scale: float) -> None:
    """Without any normalisation of the mesh."""
    mesh = shapes.CONNECTED[name]()
    signature = si_hks(whole_spectrum(mesh))
    other = si_hks(whole_spectrum(shapes.moved(mesh, seed=2, scale=scale)))
    assert signature.shape == (mesh.n_vertices, 6)
    np.testing.assert_allclose(other, signature, rtol=1e-6)


def test_hks_does_change_with_scale() -> None:
    """Unless its times are scaled along: Table 1."""
    spectrum = laplace_beltrami_spectrum(shapes.blob())
    times = np.array([0.1, 1.0])
    signature = hks(spectrum, times)
    larger = spectrum.scaled(2.0)
    assert np.abs(hks(larger, times) / signature - 1.0).max() > 0.1
    np.testing.assert_allclose(hks(larger, 4.0 * times), signature, rtol=1e-9)


def test_si_hks_equals_its_definition_written_out() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 40)
    vertex = 17
    exponents = np.arange(-64, 17) / 8.0
    kernel = [
        sum(
            np.exp(-value * spectrum.area * 2.0**tau) * function[vertex] ** 2
            for value, function in zip(spectrum.eigenvalues, spectrum.eigenfunctions.T, strict=True)
        )
        for tau in exponents
    ]
    slope = np.diff(np.log(kernel))
    turns = np.exp(-2j * np.pi * np.outer(np.arange(6), np.arange(len(slope))) / len(slope))
    trace = [np.exp(-spectrum.eigenvalues * spectrum.area * 2.0**tau).sum() for tau in (-8.0, 2.0)]
    expected = np.abs(turns @ slope) / np.log(trace[0] / trace[1]) / np.sqrt(6)
    signature = si_hks(spectrum)
    np.testing.assert_allclose(signature[vertex], expected, rtol=1e-9)
    more = si_hks(spectrum, 10)
    np.testing.assert_allclose(more[:, :6] * np.sqrt(10), signature * np.sqrt(6), rtol=1e-12)


@pytest.mark.parametrize("descriptor", [hks, si_hks])
def test_intrinsic_symmetries_and_numbering(
    descriptor: Callable[[Spectrum], FloatArray],
) -> None:
    torus = shapes.torus()  # vertices of one parallel are images of one another
    unit = torus.scaled(1.0 / np.sqrt(torus.area))
    parallels = descriptor(whole_spectrum(unit)).reshape(12, 24, -1)
    np.testing.assert_allclose(parallels, np.tile(parallels[:, :1], (1, 24, 1)), rtol=1e-6)
    blob, where = shapes.permuted(shapes.blob(), seed=8)
    np.testing.assert_allclose(
        descriptor(whole_spectrum(blob))[where],
        descriptor(whole_spectrum(shapes.blob())),
        rtol=1e-6,
    )
