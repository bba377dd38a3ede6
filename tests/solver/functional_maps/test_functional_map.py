"""Functional maps of a shape to its own copy, where the answer is known."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.functional_maps import FunctionalMap, fit_orthonormal_map, nearest_points
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
    images = found.images(spectrum.eigenfunctions)
    np.testing.assert_allclose(images, copy.eigenfunctions[numbering], atol=1e-5)
    np.testing.assert_array_equal(nearest_points(images, copy.eigenfunctions), numbering)


def test_no_orthonormal_map_fits_points_better() -> None:
    random = np.random.default_rng(0)
    source, target = random.standard_normal((2, 30, 5))
    best = fit_orthonormal_map(source, target)

    def misfit(one: FunctionalMap) -> float:
        return float(((one.images(source) - target) ** 2).sum())

    for _ in range(200):
        other, _ = np.linalg.qr(random.standard_normal((5, 5)))
        assert misfit(best) <= misfit(FunctionalMap(other)) + 1e-12
