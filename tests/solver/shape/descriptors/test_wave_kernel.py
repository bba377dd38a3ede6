"""Wave kernel signatures: closed forms and invariances."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.shape.choices import WaveKernelSignature
from solver.shape.descriptors import wave_kernel_signature
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum
from tests.solver import shapes


def everywhere(spectrum: Spectrum, sigma: float = WaveKernelSignature.sigma) -> FloatArray:
    return wave_kernel_signature(spectrum, sigma, np.arange(len(spectrum.mass)))


def energies_of(spectrum: Spectrum) -> FloatArray:
    """Over three quarters of the eigenvalues that Weyl's law gives."""
    counts = np.geomspace(0.5, 0.75 * (spectrum.n_eigenpairs - 1), 32)
    return np.log(4.0 * np.pi * counts / spectrum.area)


def test_of_the_sphere() -> None:
    """The same everywhere: what is likely depends on the energy alone."""
    spectrum = laplace_beltrami_spectrum(shapes.icosphere(4), 100)  # l = 0..9 are complete
    signature = everywhere(spectrum)
    np.testing.assert_allclose(signature, 1.0 / np.sqrt(32), rtol=0.04)


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_every_component_has_mean_one(name: str) -> None:
    spectrum = laplace_beltrami_spectrum(shapes.CONNECTED[name]())
    signature = everywhere(spectrum)
    means = spectrum.mass @ signature / spectrum.area
    np.testing.assert_allclose(means * np.sqrt(32), 1.0, rtol=1e-9)


def test_it_equals_its_definition_written_out() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 40)
    sigma, vertex = 0.3, 17
    signature = everywhere(spectrum, sigma)[vertex]
    for energy, found in zip(energies_of(spectrum), signature, strict=True):
        likely, total = 0.0, 0.0
        for value, function in zip(
            spectrum.eigenvalues[1:], spectrum.eigenfunctions.T[1:], strict=True
        ):
            passed = np.exp(-((energy - np.log(value)) ** 2) / (2.0 * sigma**2))
            likely += passed * function[vertex] ** 2
            total += passed
        assert found == pytest.approx(likely / total * spectrum.area / np.sqrt(32), rel=1e-9)


def test_narrow_filters_pick_the_nearest_eigenvalue() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 10)
    apart = np.abs(energies_of(spectrum) - np.log(spectrum.eigenvalues[1:, None]))
    nearest = spectrum.eigenfunctions[:, 1 + np.argmin(apart, axis=0)]
    expected = nearest**2 * spectrum.area / np.sqrt(32)
    np.testing.assert_allclose(everywhere(spectrum, 1e-6), expected, rtol=1e-9)


def test_scale_is_without_effect() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob())
    larger = spectrum.scaled(30.0)
    signature = everywhere(spectrum)
    np.testing.assert_allclose(everywhere(larger), signature, rtol=1e-9)


def test_motion_and_numbering() -> None:
    mesh = shapes.blob(2)
    signature = everywhere(laplace_beltrami_spectrum(mesh, 60))
    moved = laplace_beltrami_spectrum(shapes.moved(mesh, seed=6), 60)
    np.testing.assert_allclose(everywhere(moved), signature, rtol=1e-9)
    renumbered, where = shapes.permuted(mesh, seed=7)
    found = everywhere(laplace_beltrami_spectrum(renumbered, 60))[where]
    np.testing.assert_allclose(found, signature, rtol=1e-9)
    some = np.array([3, 1, 40])
    spectrum = laplace_beltrami_spectrum(mesh, 60)
    found = wave_kernel_signature(spectrum, WaveKernelSignature.sigma, some)
    np.testing.assert_allclose(found, signature[some], rtol=1e-12)


def test_a_single_eigenvalue_is_enough() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(2), 2)
    expected = spectrum.eigenfunctions[:, [1]] ** 2 * spectrum.area / np.sqrt(32)
    np.testing.assert_allclose(everywhere(spectrum), np.tile(expected, 32))


def test_what_has_no_meaning() -> None:
    constant = Spectrum(np.zeros(1), np.ones((4, 1)), np.full(4, 0.25))
    with pytest.raises(ValueError, match="eigenpairs"):
        everywhere(constant)
