"""Factors of definite matrices: solutions, and errors for singular ones."""

import numpy as np
import pytest
import scipy.sparse as sp

from solver.errors import MeshError
from solver.shape.laplacian import definite_factor, laplacian
from tests.solver import shapes


def test_solutions() -> None:
    stiffness, mass = laplacian(shapes.blob())
    matrix = sp.csc_array(stiffness + sp.diags_array(mass))
    factor = definite_factor(matrix)
    right = np.random.default_rng(0).standard_normal((matrix.shape[0], 3))
    np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-11)
    np.testing.assert_allclose(factor.solve(right[:, 0]), factor.solve(right)[:, 0], rtol=1e-12)


@pytest.mark.parametrize("shift", [0.0, 1e-16])
def test_singular_matrix(shift: float) -> None:
    stiffness, _ = laplacian(shapes.blob())
    with pytest.raises(MeshError, match="degenerate"):
        definite_factor(sp.csc_array(stiffness + shift * sp.eye_array(stiffness.shape[0])))
    with pytest.raises(MeshError, match="degenerate"):
        definite_factor(sp.csc_array((2, 2)))
