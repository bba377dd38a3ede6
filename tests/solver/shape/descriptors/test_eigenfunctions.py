"""Eigenfunctions: what signs, bases and the order of near eigenvalues must not change."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.descriptors import (
    aligned_eigenfunctions,
    eigenfunction_groups,
    eigenfunction_magnitudes,
)
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum
from tests.solver import shapes


def magnitudes_of(spectrum: Spectrum, count: int = 20) -> FloatArray:
    return eigenfunction_magnitudes(spectrum, count, np.arange(len(spectrum.mass)))


def aligned(source: Spectrum, target: Spectrum, count: int = 20) -> tuple[FloatArray, FloatArray]:
    everywhere = (np.arange(len(spectrum.mass)) for spectrum in (source, target))
    return aligned_eigenfunctions(source, target, count, *everywhere)


def ellipsoid(*axes: float) -> TriangleMesh:
    sphere = shapes.icosphere(4)
    return triangle_mesh(sphere.vertices * np.array(axes), sphere.faces)


def with_other_bases(spectrum: Spectrum, groups: IntArray, seed: int) -> Spectrum:
    """Eigenfunctions mixed by an orthogonal matrix within every group."""
    random = np.random.default_rng(seed)
    mixtures = [
        np.linalg.qr(random.standard_normal((size, size)))[0]
        for size in np.diff([0, *groups, spectrum.n_eigenpairs])
    ]
    mixed = spectrum.eigenfunctions @ scipy.linalg.block_diag(*mixtures)
    return replace(spectrum, eigenfunctions=mixed)


def with_signs(spectrum: Spectrum, seed: int) -> Spectrum:
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], spectrum.n_eigenpairs)
    return replace(spectrum, eigenfunctions=spectrum.eigenfunctions * signs)


def test_of_the_sphere() -> None:
    """Groups are degrees, and Σ Y_lm² = (2l + 1) / 4π everywhere: the addition theorem."""
    spectrum = laplace_beltrami_spectrum(shapes.icosphere(4), 40)
    for count, groups in ((3, [1, 4]), (14, [1, 4, 9]), (15, [1, 4, 9, 16]), (2, [1, 3])):
        np.testing.assert_array_equal(eigenfunction_groups([spectrum], count), groups)
    source, target = aligned(spectrum, with_signs(spectrum, 2))
    np.testing.assert_allclose(source, 1.0 / np.sqrt(3), rtol=0.01)
    np.testing.assert_array_equal(source, target)
    magnitudes = magnitudes_of(spectrum)
    np.testing.assert_allclose(magnitudes, 1.0 / np.sqrt(20), rtol=0.01)


def test_of_a_string() -> None:
    """√2 |cos iπz|, one by one, and without signs: all are distributed alike."""
    tube = shapes.tube()
    spectrum = laplace_beltrami_spectrum(tube, 8)
    groups = eigenfunction_groups([spectrum], 5)
    np.testing.assert_array_equal(groups, [1, 2, 3, 4, 5, 6])
    exact = np.abs(np.cos(np.pi * np.outer(tube.vertices[:, 2], np.arange(1, 6))))
    for values in aligned(spectrum, with_signs(spectrum, 1), 5):
        np.testing.assert_allclose(values * np.sqrt(5), np.sqrt(2) * exact, atol=0.01)
    magnitudes = magnitudes_of(spectrum, 5)
    sums = np.cumsum(2.0 * exact**2, axis=1) / np.arange(1, 6)
    np.testing.assert_allclose(5.0 * magnitudes**2, sums, atol=0.02)


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_root_mean_squares_are_one(name: str) -> None:
    spectrum = laplace_beltrami_spectrum(shapes.CONNECTED[name]())
    magnitudes = magnitudes_of(spectrum)
    assert magnitudes.shape == (len(spectrum.mass), 20)
    for values in (magnitudes, *aligned(spectrum, spectrum)):
        squares = spectrum.mass @ values**2 / spectrum.area
        np.testing.assert_allclose(squares * values.shape[1], 1.0, rtol=1e-9)


@pytest.mark.parametrize(
    "mesh", [ellipsoid(1.0, 1.0, 1.0), ellipsoid(1.0, 1.0, 1.8), shapes.cube()]
)
def test_bases_are_without_effect(mesh: TriangleMesh) -> None:
    spectrum = laplace_beltrami_spectrum(mesh, 60)
    groups = eigenfunction_groups([spectrum], 20)
    assert (np.diff(groups) > 1).any()
    other = with_other_bases(spectrum, groups, seed=3)
    assert np.abs(other.eigenfunctions - spectrum.eigenfunctions).max() > 0.1
    for one, two in zip(
        aligned(spectrum, spectrum),
        aligned(spectrum, other),
        strict=True,
    ):
        np.testing.assert_allclose(np.abs(one), np.abs(two), atol=1e-12)


def test_magnitudes_do_not_depend_on_the_basis_of_repeated_eigenvalues() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.fine_tetrahedron(), 40)
    repeated = np.diff(spectrum.eigenvalues) <= 1e-6 * spectrum.eigenvalues[1:]
    assert repeated.any()
    other = with_other_bases(spectrum, np.flatnonzero(~repeated) + 1, seed=3)
    found = magnitudes_of(other)
    np.testing.assert_allclose(found, magnitudes_of(spectrum), atol=1e-12)
    assert np.abs(other.eigenfunctions**2 - spectrum.eigenfunctions**2).max() > 0.1


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", ["blob", "torus", "plane_grid", "moebius_strip"])
def test_signs_are_without_effect(name: str, seed: int) -> None:
    spectrum = laplace_beltrami_spectrum(shapes.CONNECTED[name](), 40)
    source, target = aligned(with_signs(spectrum, seed), with_signs(spectrum, 9))
    np.testing.assert_allclose(source, target, atol=1e-12)
    if name == "blob":
        assert (source < 0.0).any()


def test_order_of_near_eigenvalues_is_without_effect() -> None:
    """Two ellipsoids between which the second and third eigenfunctions have traded places."""
    one = laplace_beltrami_spectrum(ellipsoid(1.0, 1.03, 2.0), 40)
    other = laplace_beltrami_spectrum(ellipsoid(1.03, 1.0, 2.0), 40)
    axis = shapes.icosphere(4).vertices[:, 0]
    places = [np.argmax(np.abs(axis @ s.eigenfunctions[:, :6])) for s in (one, other)]
    assert sorted(places) == [2, 3]
    both = [magnitudes_of(spectrum) for spectrum in (one, other)]
    for source, target in (both, aligned(one, other)):
        assert np.sqrt(((source - target) ** 2).sum(axis=1)).mean() < 0.05
        assert np.sqrt((source**2).sum(axis=1)).mean() > 0.9


def test_bent_shapes_agree() -> None:
    """A strip rolled up, twice tighter: no length changes."""
    flat = shapes.plane_grid(61, 21, 3.0)
    x, y = flat.vertices[:, 0], flat.vertices[:, 1] + 0.1 * flat.vertices[:, 0] ** 2
    spectra = []
    for radius in (0.6, 1.2):
        rolled = np.stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)], axis=1)
        spectra.append(laplace_beltrami_spectrum(triangle_mesh(rolled, flat.faces), 40))
    source, target = aligned(with_signs(spectra[0], 4), spectra[1])
    assert source.shape[1] > 3
    np.testing.assert_allclose(source, target, atol=0.02)


def test_scale_motion_and_numbering() -> None:
    mesh = shapes.blob(2)
    spectrum = laplace_beltrami_spectrum(mesh, 40)
    norms = magnitudes_of(spectrum)
    np.testing.assert_allclose(magnitudes_of(spectrum.scaled(7.0)), norms, rtol=1e-9)
    moved = laplace_beltrami_spectrum(shapes.moved(mesh, seed=6, scale=3.0), 40)
    np.testing.assert_allclose(magnitudes_of(moved), norms, rtol=1e-9, atol=1e-9)
    renumbered, where = shapes.permuted(mesh, seed=7)
    numbered = laplace_beltrami_spectrum(renumbered, 40)
    np.testing.assert_allclose(magnitudes_of(numbered)[where], norms, rtol=1e-9, atol=1e-9)
    source, target = aligned(moved, numbered)
    np.testing.assert_allclose(target[where], source, rtol=1e-9, atol=1e-9)
    some, others = np.array([3, 1, 40]), np.array([5, 2])
    parts = aligned_eigenfunctions(moved, numbered, 20, some, others)
    np.testing.assert_array_equal(parts[0], source[some])
    np.testing.assert_array_equal(parts[1], target[others])


def test_what_has_no_meaning() -> None:
    spectrum = laplace_beltrami_spectrum(shapes.cube(2))
    constant = Spectrum(np.zeros(1), np.ones((4, 1)), np.full(4, 0.25))
    with pytest.raises(ValueError, match="eigenpairs"):
        aligned(spectrum, constant)
    tiny = laplace_beltrami_spectrum(shapes.triangle())
    np.testing.assert_array_equal(eigenfunction_groups([tiny], 20)[[0]], 1)
    assert magnitudes_of(tiny).shape == (3, 20)
