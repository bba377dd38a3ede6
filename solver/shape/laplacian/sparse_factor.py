"""Direct solution of sparse symmetric systems of the Laplace-Beltrami operator, by SuperLU."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from solver.errors import MeshError

_TOLERANCE = 1e-4
"""Greatest relative error of a known solution that :func:`definite_factor` accepts: an inaccurate
factor means a matrix that is singular to working precision."""

_SEED = 20100707
"""Seed of the known solution."""

_SINGULAR = (
    "the Laplacian of the mesh is singular to working precision: some of its faces are nearly "
    "degenerate"
)


def symmetric_factor(matrix: sp.sparray) -> spla.SuperLU:
    """Factor a symmetric matrix without pivoting, with a minimum degree ordering.

    Nothing bounds the growth of rounding errors if the matrix is indefinite: check a solution.

    Parameters
    ----------
    matrix
        (n, n) sparse symmetric.

    Raises
    ------
    RuntimeError
        The matrix is exactly singular.
    """
    return spla.splu(
        sp.csc_matrix(matrix),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        relax=1,  # relaxed supernodes take 40 times as long on meshes of regular subdivision
        options={"SymmetricMode": True},
    )


def definite_factor(matrix: sp.csc_array) -> spla.SuperLU:
    """Factor a symmetric positive definite matrix.

    Parameters
    ----------
    matrix
        (n, n) sparse.

    Returns
    -------
    SuperLU
        Its ``solve`` takes right-hand sides (n,) or (n, m).

    Raises
    ------
    MeshError
        The matrix is singular to working precision, as those of nearly degenerate meshes may be.
    """
    try:
        factor = symmetric_factor(matrix)
    except RuntimeError as error:
        raise MeshError(_SINGULAR) from error
    known = np.random.default_rng(_SEED).standard_normal(matrix.shape[0])
    deviation = np.abs(factor.solve(matrix @ known) - known).max()
    if not deviation < _TOLERANCE * np.abs(known).max():
        raise MeshError(_SINGULAR)
    return factor
