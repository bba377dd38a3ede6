"""Functional maps of a shape to its own copy, where the answer is known."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.functional_maps import (
    FunctionalMap,
    fit_functional_map,
    fit_orthonormal_map,
    zoomout,
)
from solver.mesh import triangle_mesh
from solver.shape import Shape
from solver.shape.laplacian import Spectrum
from tests.solver import shapes

K = 40


@pytest.fixture(scope="module")
def spectrum() -> Spectrum:
    return Shape(shapes.blob()).spectrum(K)


@pytest.fixture(scope="module")
def numbering() -> IntArray:
    """Vertex of the copy that each vertex of the original is."""
    return np.random.default_rng(3).permutation(shapes.blob().n_vertices)


@pytest.fixture(scope="module")
def copy(numbering: IntArray) -> Spectrum:
    mesh = shapes.blob()
    vertices = np.empty_like(mesh.vertices)
    vertices[numbering] = mesh.vertices @ _rotation()
    return Shape(triangle_mesh(vertices, numbering[mesh.faces])).spectrum(K)


def _rotation() -> FloatArray:
    rotation, _ = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))
    return rotation


def test_points_in_correspondence_give_the_isometry(
    spectrum: Spectrum, copy: Spectrum, numbering: IntArray
) -> None:
    found = fit_orthonormal_map(spectrum.eigenfunctions, copy.eigenfunctions[numbering])
    np.testing.assert_allclose(found.matrix @ found.matrix.T, np.eye(K), atol=1e-10)
    np.testing.assert_allclose(
        found.images(spectrum.eigenfunctions), copy.eigenfunctions[numbering], atol=1e-5
    )
    np.testing.assert_array_equal(
        found.nearest(spectrum.eigenfunctions, copy.eigenfunctions), numbering
    )


def test_no_orthonormal_map_fits_points_better() -> None:
    random = np.random.default_rng(0)
    source, target = random.standard_normal((2, 30, 5))
    best = fit_orthonormal_map(source, target)

    def misfit(one: FunctionalMap) -> float:
        return float(((one.images(source) - target) ** 2).sum())

    for _ in range(200):
        other, _ = np.linalg.qr(random.standard_normal((5, 5)))
        assert misfit(best) <= misfit(FunctionalMap(other)) + 1e-12


def test_functions_in_correspondence_give_the_isometry(
    spectrum: Spectrum, copy: Spectrum, numbering: IntArray
) -> None:
    """As many functions as eigenfunctions determine the map; commutativity agrees with it."""
    functions = np.random.default_rng(1).standard_normal((len(spectrum.mass), 2 * K))
    coefficients = spectrum.eigenfunctions.T @ (spectrum.mass[:, None] * functions)
    renumbered = np.empty_like(functions)
    renumbered[numbering] = functions
    images = copy.eigenfunctions.T @ (copy.mass[:, None] * renumbered)
    found = fit_functional_map(
        coefficients, images, (spectrum.eigenvalues, copy.eigenvalues), commutativity=1e-3
    )
    np.testing.assert_allclose(found.matrix @ coefficients, images, atol=1e-5)


def test_the_fit_is_the_least_of_its_objective() -> None:
    """The gradient vanishes, by differences of the objective written out."""
    random = np.random.default_rng(2)
    a, b = random.standard_normal((2, 4, 6))
    lambdas, mus = np.sort(random.random((2, 4)), axis=1)
    weight = 0.3

    def objective(matrix: FloatArray) -> float:
        commutator = matrix * lambdas - mus[:, None] * matrix
        return float(
            ((matrix @ a - b) ** 2).sum()
            + weight * (commutator**2).sum() / max(lambdas[-1], mus[-1]) ** 2
        )

    found = fit_functional_map(a, b, (lambdas, mus), weight).matrix
    for _ in range(50):
        step = 1e-4 * random.standard_normal((4, 4))
        assert objective(found) <= objective(found + step) + 1e-10


def test_zoomout_recovers_the_isometry_from_few_eigenfunctions(
    spectrum: Spectrum, copy: Spectrum, numbering: IntArray
) -> None:
    some = np.arange(0, len(numbering), 40)
    start = fit_orthonormal_map(
        spectrum.eigenfunctions[some, :6], copy.eigenfunctions[numbering[some], :6]
    )
    found = zoomout(start, spectrum.eigenfunctions, copy.eigenfunctions, [*range(8, K, 4), K])
    assert found.size == K
    np.testing.assert_array_equal(
        found.nearest(spectrum.eigenfunctions, copy.eigenfunctions), numbering
    )


def test_nearest_is_the_same_however_many_points_are_asked_at_once() -> None:
    random = np.random.default_rng(4)
    source, target = random.standard_normal((50, 8)), random.standard_normal((90000, 8))
    found = FunctionalMap(np.eye(8)).nearest(source, target)
    one_by_one = [np.argmin(((target - point) ** 2).sum(axis=1)) for point in source]
    np.testing.assert_array_equal(found, one_by_one)
