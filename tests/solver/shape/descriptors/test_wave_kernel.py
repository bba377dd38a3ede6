"""Wave kernel signatures: closed forms and invariances."""

import numpy as np
import pytest

from solver.shape.descriptors import wave_kernel_signature
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum
from tests.solver import shapes


def test_of_the_sphere() -> None:
    """The same everywhere: what is likely depends on the energy alone."""
    spectrum = laplace_beltrami_spectrum(shapes.icosphere(4), 100)  # l = 0..9 are complete
    signature = wave_kernel_signature(spectrum)
    np.testing.assert_allclose(signature, 1.0 / np.sqrt(32), rtol=0.04)


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_every_component_has_mean_one(name: str) -> None:
    spectrum = laplace_beltrami_spectrum(shapes.CONNECTED[name]())
    signature = wave_kernel_signature(spectrum)
    means = spectrum.mass @ signature / spectrum.area
    np.testing.assert_allclose(means * np.sqrt(32), 1.0, rtol=1e-9)


def test_it_equals_its_definition_written_out() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 40)
    energies, sigma, vertex = np.array([0.5, 1.0, 2.5]), 0.3, 17
    for energy, found in zip(
        energies, wave_kernel_signature(spectrum, energies, sigma)[vertex], strict=True
    ):
        likely, total = 0.0, 0.0
        for value, function in zip(
            spectrum.eigenvalues[1:], spectrum.eigenfunctions.T[1:], strict=True
        ):
            passed = np.exp(-((energy - np.log(value)) ** 2) / (2.0 * sigma**2))
            likely += passed * function[vertex] ** 2
            total += passed
        assert found == pytest.approx(likely / total * spectrum.area / np.sqrt(3), rel=1e-9)


def test_narrow_filters_pick_the_nearest_eigenvalue() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(), 10)
    energy = np.log(spectrum.eigenvalues[[3]]) + 1e-3
    signature = wave_kernel_signature(spectrum, energy, 1e-6)
    expected = spectrum.eigenfunctions[:, [3]] ** 2 * spectrum.area
    np.testing.assert_allclose(signature, expected, rtol=1e-9)


def test_scale() -> None:
    """None with default energies; given ones have to be shifted along."""
    spectrum = laplace_beltrami_spectrum(shapes.blob())
    larger = spectrum.scaled(30.0)
    signature = wave_kernel_signature(spectrum)
    np.testing.assert_allclose(wave_kernel_signature(larger), signature, rtol=1e-9)
    energies = np.linspace(0.0, 4.0, 5)
    fixed = wave_kernel_signature(spectrum, energies)
    shifted = wave_kernel_signature(larger, energies - 2.0 * np.log(30.0))
    np.testing.assert_allclose(shifted, fixed, rtol=1e-9)
    assert np.abs(wave_kernel_signature(larger, energies) - fixed).max() > 0.1


def test_motion_and_numbering() -> None:
    mesh = shapes.blob(2)
    signature = wave_kernel_signature(laplace_beltrami_spectrum(mesh, 60))
    moved = laplace_beltrami_spectrum(shapes.moved(mesh, seed=6), 60)
    np.testing.assert_allclose(wave_kernel_signature(moved), signature, rtol=1e-9)
    renumbered, where = shapes.permuted(mesh, seed=7)
    found = wave_kernel_signature(laplace_beltrami_spectrum(renumbered, 60))[where]
    np.testing.assert_allclose(found, signature, rtol=1e-9)
    some = np.array([3, 1, 40])
    found = wave_kernel_signature(laplace_beltrami_spectrum(mesh, 60), vertices=some)
    np.testing.assert_allclose(found, signature[some], rtol=1e-12)


def test_a_single_eigenvalue_is_enough() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.blob(2), 2)
    expected = spectrum.eigenfunctions[:, [1]] ** 2 * spectrum.area / np.sqrt(32)
    np.testing.assert_allclose(wave_kernel_signature(spectrum), np.tile(expected, 32))


def test_what_has_no_meaning() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.cube(2))
    for sigma in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="sigma"):
            wave_kernel_signature(spectrum, sigma=sigma)
    constant = Spectrum(np.zeros(1), np.ones((4, 1)), np.full(4, 0.25))
    with pytest.raises(ValueError, match="eigenpairs"):
        wave_kernel_signature(constant)
