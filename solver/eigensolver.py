"""Smallest eigenpairs of large sparse symmetric matrices, by block Lanczos inside the spectrum.

The usual shift is just below zero, where the matrix stays definite. A shift σ in the middle of
the eigenvalues wanted brings the farthest of them twice as near, and about half the Krylov space
is enough. Two things make it safe. The factor L D Lᵀ of A - σ I knows, by the signs of D, how many
eigenvalues lie below σ (Sylvester's law of inertia): that is how σ is chosen, and how a missed
eigenvalue is noticed (Ericsson and Ruhe, Math. Comp. 35, 1980). And whatever fails a check is left
to ARPACK with the usual shift.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from solver.arrays import FloatArray

_BLOCK = 4
"""Vectors per step: repeated eigenvalues come out together, and products stay in the cache."""

_TOLERANCE = 1e-8
_BELOW = (0.4, 0.55, 0.7)
"""Share of the wanted eigenvalues below the shift: least, aim, most."""

_TRIALS = 4
_SEED = 20100707


@dataclass(frozen=True, eq=False)
class _Factor:
    """Factor of A - σ I without pivoting, and the number of eigenvalues below σ."""

    shift: float
    below: int
    lu: spla.SuperLU

    def solve(self, rows: FloatArray) -> FloatArray:
        """(A - σ I)⁻¹ applied to each row."""
        solved: FloatArray = self.lu.solve(rows.T).T
        return solved


def smallest_eigenpairs(
    matrix: sp.csc_array, k: int, null_vector: FloatArray, guess: float
) -> tuple[FloatArray, FloatArray]:
    """Find the k smallest eigenpairs of a positive semi-definite matrix with a known null space.

    Parameters
    ----------
    matrix
        (n, n) symmetric.
    k
        At least 2; less than a third of n.
    null_vector
        (n,) unit vector that spans the null space.
    guess
        About the size of the k-th eigenvalue; a bad guess costs time, not accuracy.

    Returns
    -------
    eigenvalues : (k,) ascending, the first exactly 0.
    eigenvectors : (n, k) orthonormal, the first the null vector.

    Raises
    ------
    RuntimeError
        Nothing converges.
    """
    factor = _interior_factor(matrix, k, guess)
    found = None if factor is None else _block_lanczos(factor, k, null_vector)
    if found is None:
        found = _arpack(matrix, k)
    values, vectors = found
    return np.r_[0.0, values], np.column_stack([null_vector, vectors])


def _factorised(matrix: sp.csc_array, shift: float) -> _Factor:
    shifted = sp.csc_matrix(matrix - shift * sp.eye_array(matrix.shape[0]))
    lu = spla.splu(
        shifted,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return _Factor(shift, int((lu.U.diagonal() < 0.0).sum()), lu)


def _interior_factor(matrix: sp.csc_array, k: int, guess: float) -> _Factor | None:
    """Factor at a shift with about half of the wanted eigenvalues below it, or none."""
    least, aim, most = (share * k for share in _BELOW)
    shift = _BELOW[1] * guess
    probe = np.random.default_rng(_SEED).standard_normal((1, matrix.shape[0]))
    for _ in range(_TRIALS):
        try:
            factor = _factorised(matrix, shift)
        except RuntimeError:  # exactly singular: the shift is an eigenvalue
            shift *= 0.99
            continue
        if least <= factor.below <= most:
            # Without pivoting nothing bounds the growth of rounding errors, so look at them; and
            # the count is one only if rows were not exchanged.
            solved = factor.solve(probe)[0]
            error = np.linalg.norm(matrix @ solved - shift * solved - probe[0])
            symmetric = bool((factor.lu.perm_r == factor.lu.perm_c).all())
            if symmetric and error < 1e-7 * np.linalg.norm(probe):
                return factor
            shift *= 0.99
        else:
            shift *= min(max(aim / max(factor.below, 1), 0.1), 10.0)
    return None


def _block_lanczos(
    factor: _Factor, k: int, null_vector: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """The k - 1 smallest eigenpairs beside the null vector; none if they fail the checks."""
    n = len(null_vector)
    capacity = min(5 * k + 25 * _BLOCK, n // _BLOCK * _BLOCK)
    basis = np.empty((capacity + 1, n))  # one vector a row; the first is the null vector
    basis[0] = null_vector
    projected = np.zeros((capacity, capacity))
    start = np.random.default_rng(_SEED).standard_normal((_BLOCK, n))
    block, _ = _orthonormal_rows(start, basis[:1])
    size, check = 0, 2 * k + 2 * _BLOCK
    while size + _BLOCK <= capacity:
        basis[size + 1 : size + 1 + _BLOCK] = block
        size += _BLOCK
        image = factor.solve(block)
        recent = slice(max(size - 2 * _BLOCK, 0), size)
        neighbours = basis[1:][recent]
        coupling = neighbours @ image.T
        image -= coupling.T @ neighbours
        projected[recent, size - _BLOCK : size] = coupling
        projected[size - _BLOCK : size, recent] = coupling.T
        block, remainder = _orthonormal_rows(image, basis[: size + 1])
        if size >= check:
            ritz = _converged(factor, k, projected[:size, :size], remainder)
            if ritz is not None:
                values, weights = ritz
                if int((values < factor.shift).sum()) + 1 != factor.below:
                    return None
                return values, (weights.T @ basis[1 : size + 1]).T
            check = size + max(k // 10, _BLOCK)
    return None


def _orthonormal_rows(rows: FloatArray, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Orthonormalise rows against a basis and one another: rows = Rᵀ Q + what the basis has."""
    rows = rows - (basis @ rows.T).T @ basis
    columns, triangle = scipy.linalg.qr(rows.T, mode="economic", check_finite=False)
    pivots = np.abs(np.diag(triangle))
    if pivots.min() < 1e-6 * pivots.max():
        # What was left of some row was mostly rounding error, not orthogonal to anything.
        columns = columns - basis.T @ (basis @ columns)
        columns, _ = scipy.linalg.qr(columns, mode="economic", check_finite=False)
    return np.ascontiguousarray(columns.T, dtype=np.float64), np.asarray(triangle, dtype=np.float64)


def _converged(
    factor: _Factor, k: int, projected: FloatArray, remainder: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Ritz values λ = σ + 1/θ and vectors of the k - 1 smallest, if all residuals are small."""
    theta: FloatArray
    weights: FloatArray
    theta, weights = scipy.linalg.eigh(projected, check_finite=False)
    with np.errstate(divide="ignore"):
        values = factor.shift + 1.0 / theta
    wanted = np.argsort(np.where(values > 0.0, values, np.inf))[: k - 1]
    residuals = np.linalg.norm(remainder @ weights[-_BLOCK:, wanted], axis=0)
    if not (residuals <= _TOLERANCE * np.abs(theta[wanted])).all():
        return None
    return values[wanted], weights[:, wanted]


def _arpack(matrix: sp.csc_array, k: int) -> tuple[FloatArray, FloatArray]:
    """The same by ARPACK, with a shift just below zero, where the matrix is definite."""
    n = matrix.shape[0]
    factor = _factorised(matrix, -1e-8 * float(matrix.diagonal().max()))
    start = np.random.default_rng(_SEED).standard_normal(n)
    values, vectors = spla.eigsh(
        matrix,
        k,
        sigma=factor.shift,
        OPinv=spla.LinearOperator((n, n), matvec=factor.lu.solve, dtype=np.float64),
        ncv=min(2 * k + 20, n - 1),
        tol=_TOLERANCE,
        v0=start,
    )
    order = np.argsort(values)[1:]
    return values[order], vectors[:, order]
