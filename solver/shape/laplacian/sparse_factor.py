"""Sparse symmetric positive definite systems, as they come from the Laplace-Beltrami operator."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from solver.arrays import FloatArray
from solver.errors import MeshError

_TOLERANCE = 1e-4
_SEED = 20100707


class DefiniteFactor:
    """Factor of a sparse symmetric positive definite matrix, without pivoting.

    Parameters
    ----------
    matrix
        (n, n).

    Raises
    ------
    MeshError
        The matrix is singular in floating point, as those of nearly degenerate meshes may be.
    """

    def __init__(self, matrix: sp.csc_array) -> None:
        try:
            self._lu = spla.splu(
                sp.csc_matrix(matrix),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                relax=1,  # relaxed supernodes are slow on meshes of regular subdivision
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise MeshError(_SINGULAR) from error
        probe = np.random.default_rng(_SEED).standard_normal(matrix.shape[0])
        deviation = np.abs(self.solve(matrix @ probe) - probe).max()
        if not deviation < _TOLERANCE * np.abs(probe).max():
            raise MeshError(_SINGULAR)

    def solve(self, right: FloatArray) -> FloatArray:
        """Solve for one right-hand side (n,) or for several (n, m)."""
        solution: FloatArray = self._lu.solve(right)
        return solution


_SINGULAR = "the mesh has no sound Laplacian: some of its faces are nearly degenerate"
