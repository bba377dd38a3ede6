"""Eigenpairs by block Lanczos inside the spectrum, against dense ones."""

import numpy as np
import pytest
import scipy.sparse as sp

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh
from solver.shape.laplacian import laplacian, smallest_eigenpairs
from tests.solver import shapes

CASES = {
    "repeated eigenvalues of a sphere": shapes.icosphere(3),
    "repeated eigenvalues of a cube": shapes.cube(12),
    "repeated eigenvalues of a torus": shapes.torus(48, 24),
    "string-like eigenvalues of a tube": shapes.tube(4, 300, 1e-3),
    "multiplicity 6, above the shift too": shapes.fine_tetrahedron(4),
    "boundary": shapes.plane_grid(40, 27),
    "no symmetry": shapes.blob(3),
}


def standard_form(mesh: TriangleMesh) -> tuple[sp.csc_array, FloatArray]:
    stiffness, mass = laplacian(mesh.scaled(1.0 / np.sqrt(mesh.area)))
    scale = sp.diags_array(1.0 / np.sqrt(mass))
    return sp.csc_array(scale @ stiffness @ scale), np.sqrt(mass / mass.sum())


@pytest.mark.parametrize(
    ("name", "k", "guess"),
    [(name, k, 1.0) for name in CASES for k in (2, 30, 150)]
    + [("no symmetry", 30, guess) for guess in (1e-12, 0.01, 30.0, 1e12)],
)
def test_the_same_as_dense(name: str, k: int, guess: float) -> None:
    """Whatever the guess: a bad one only costs time."""
    matrix, null_vector = standard_form(CASES[name])
    expected = dense_eigenvalues(name)[:k]
    values, vectors = smallest_eigenpairs(matrix, k, null_vector, guess * 4.0 * np.pi * k)
    assert values[0] == 0.0
    np.testing.assert_allclose(vectors[:, 0], null_vector, rtol=1e-14)
    np.testing.assert_allclose(values, expected, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(k), atol=1e-10)
    residuals = np.linalg.norm(matrix @ vectors - vectors * values, axis=0)
    assert residuals.max() < 1e-6 * sp.linalg.norm(matrix, 1)


_DENSE: dict[str, FloatArray] = {}


def dense_eigenvalues(name: str) -> FloatArray:
    if name not in _DENSE:
        _DENSE[name] = np.linalg.eigvalsh(standard_form(CASES[name])[0].toarray())
    return _DENSE[name]


def test_eigenvectors_span_the_right_spaces() -> None:
    """Only the projector on a whole cluster of eigenvalues is determined."""
    matrix, null_vector = standard_form(shapes.blob(3))
    values, vectors = smallest_eigenpairs(matrix, 60, null_vector, 4.0 * np.pi * 60)
    _, expected = np.linalg.eigh(matrix.toarray())
    gap = 40 + int(np.argmax(np.diff(values)[40:]))
    projector = vectors[:, : gap + 1] @ vectors[:, : gap + 1].T
    np.testing.assert_allclose(
        projector, expected[:, : gap + 1] @ expected[:, : gap + 1].T, atol=1e-8
    )


def test_a_shift_that_is_an_eigenvalue() -> None:
    matrix, null_vector = standard_form(shapes.cube(12))
    eigenvalues = dense_eigenvalues("repeated eigenvalues of a cube")
    guess = float(eigenvalues[14] / 0.55)  # the first shift tried is the 14th eigenvalue
    values, _ = smallest_eigenpairs(matrix, 25, null_vector, guess)
    np.testing.assert_allclose(values, eigenvalues[:25], rtol=1e-8, atol=1e-8)
