"""Smallest eigenpairs of large sparse symmetric matrices, by shift-invert block Lanczos.

The usual shift is just below zero, where the matrix stays definite. A shift σ in the middle of the
wanted eigenvalues halves the distance to the farthest of them, and about half the Krylov space is
enough. Sylvester's law of inertia makes this safe: the signs of D in the factor L D Lᵀ of A - σ I
count the eigenvalues below σ (Ericsson and Ruhe, "The spectral transformation Lanczos method",
Math. Comp. 35, 1980; Grimes, Lewis and Simon, "A shifted block Lanczos algorithm", SIAM J. Matrix
Anal. Appl. 15, 1994). The count selects σ; and a second factor, just below the largest eigenvalue
found, verifies that none is missing. On symmetric shapes eigenvalues can be missed: those of
multiplicity m need blocks of m vectors, or are found one by one by rounding errors, or never.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from solver.arrays import FloatArray
from solver.shape.laplacian.sparse_factor import symmetric_factor

_BLOCK_WIDTHS = (4, 16, 64)
"""Vectors per Lanczos step, tried in turn until no eigenvalue is missing. Four use the cache well;
wider blocks find higher multiplicities."""

_RITZ_TOLERANCE = 1e-8
"""Greatest residual of a Ritz pair of (A - σ I)⁻¹, relative to its Ritz value."""

_SHARES_BELOW = (0.4, 0.55, 0.7)
"""Least, aimed at, and greatest share of the wanted eigenvalues below the shift."""

_SOLVE_TOLERANCE, _COUNT_TOLERANCE = 1e-9, 1e-6
"""Greatest relative residual of a factor that solves for eigenpairs, and of one that only counts
eigenvalues."""

_SHIFT_TRIALS = 5
"""Factors tried for a shift inside the spectrum; the fallback is a shift below it."""

_DISTINCT = 1e-4
"""Relative gap of eigenvalues between which a shift can be placed to count them."""

_LOSS_OF_ORTHOGONALITY = 1e-6
"""Ratio of pivots from which on a block is orthogonalised a second time."""

_SEED = 20100707
"""Seed of the first block and of probes."""


@dataclass(frozen=True, eq=False)
class _Factor:
    """Factor of A - σ I, and the number of eigenvalues below σ."""

    shift: float
    n_below: int
    lu: spla.SuperLU

    def solve(self, rows: FloatArray) -> FloatArray:
        """(A - σ I)⁻¹ applied to each row."""
        solved: FloatArray = self.lu.solve(rows.T).T
        return solved


def smallest_eigenpairs(
    matrix: sp.csc_array, k: int, null_vector: FloatArray, guess: float
) -> tuple[FloatArray, FloatArray]:
    """Find the k smallest eigenpairs of a positive semi-definite matrix with a known null vector.

    Parameters
    ----------
    matrix
        (n, n) sparse symmetric.
    k
        At least 2; less than a third of n.
    null_vector
        (n,) unit vector that spans the null space.
    guess
        Estimate of the k-th eigenvalue; a bad one costs time, not accuracy.

    Returns
    -------
    eigenvalues : (k,) ascending, the first exactly 0.
    eigenvectors : (n, k) orthonormal, the first the null vector.

    Raises
    ------
    RuntimeError
        The iteration does not converge.
    """
    for factor in _factors(matrix, k, guess):
        for width in _BLOCK_WIDTHS:
            found = _block_lanczos(factor, k, null_vector, width)
            if found is not None and _is_complete(matrix, found[0]):
                return found
    raise RuntimeError("the eigensolver does not converge")


def _factors(matrix: sp.csc_array, k: int, guess: float) -> Iterator[_Factor]:
    """Factors to try: one inside the spectrum, then one just below it."""
    least, aim, most = (share * k for share in _SHARES_BELOW)
    shift = _SHARES_BELOW[1] * guess
    for _ in range(_SHIFT_TRIALS):
        factor = _factorised(matrix, shift, _SOLVE_TOLERANCE)
        if factor is None:
            shift *= 0.99
        elif least <= factor.n_below <= most:
            yield factor
            break
        else:
            shift *= min(max(aim / max(factor.n_below, 1), 0.01), 100.0)
    factor = _factorised(matrix, -1e-8 * float(matrix.diagonal().max()), _COUNT_TOLERANCE)
    if factor is not None:
        yield factor


def _factorised(matrix: sp.csc_array, shift: float, tolerance: float) -> _Factor | None:
    """Factor of A - σ I; none if the relative residual of a solution exceeds the tolerance."""
    n = matrix.shape[0]
    try:
        lu = symmetric_factor(matrix - shift * sp.eye_array(n))
    except RuntimeError:  # exactly singular: the shift is an eigenvalue
        return None
    factor = _Factor(shift, int((lu.U.diagonal() < 0.0).sum()), lu)
    # Rounding errors grow without bound where nothing is pivoted; and the signs of D are the
    # inertia only if no rows were exchanged.
    probe = np.random.default_rng(_SEED).standard_normal((1, n))
    solved = factor.solve(probe)[0]
    residual = np.linalg.norm(matrix @ solved - shift * solved - probe[0])
    accurate = residual < tolerance * np.linalg.norm(probe)
    return factor if accurate and (lu.perm_r == lu.perm_c).all() else None


def _is_complete(matrix: sp.csc_array, values: FloatArray) -> bool:
    """Return whether no eigenvalue is missing; true if no factor is accurate enough to tell."""
    gaps = np.flatnonzero(np.diff(values) > _DISTINCT * values[1:])
    below = int(gaps[-1]) + 1  # any members of the last cluster are as good as others
    for place in (0.5, 0.25, 0.75):
        shift = (1.0 - place) * values[below - 1] + place * values[below]
        factor = _factorised(matrix, float(shift), _COUNT_TOLERANCE)
        if factor is not None:
            return factor.n_below == below
    return True


def _block_lanczos(
    factor: _Factor, k: int, null_vector: FloatArray, width: int
) -> tuple[FloatArray, FloatArray] | None:
    """The k smallest eigenpairs, the null vector first; none if they do not converge.

    Every block is orthogonalised against all before (full reorthogonalisation), so that no
    eigenpair is found twice.
    """
    n = len(null_vector)
    capacity = min(5 * k + 25 * width, n // width * width)
    # One basis vector per row, the null vector first; these rows are rarely too few.
    basis = np.empty((5 * k // 2 + 2 * width + 1, n))
    basis[0] = null_vector
    projected = np.zeros((capacity, capacity))
    block, _ = _orthonormal(np.random.default_rng(_SEED).standard_normal((width, n)), basis[:1])
    size, check = 0, 2 * k + 2 * width
    while size + width <= capacity:
        if size + 1 + width > len(basis):
            basis = np.concatenate([basis, np.empty((k + width, n))])
        basis[size + 1 : size + 1 + width] = block
        size += width
        image = factor.solve(block)
        recent = slice(max(size - 2 * width, 0), size)
        neighbours = basis[1:][recent]
        coupling = neighbours @ image.T
        image -= coupling.T @ neighbours
        projected[recent, size - width : size] = coupling
        projected[size - width : size, recent] = coupling.T
        block, remainder = _orthonormal(image, basis[: size + 1])
        if size >= check:
            ritz = _converged(factor.shift, k - 1, projected[:size, :size], remainder)
            if ritz is not None:
                values, weights = ritz
                weights = scipy.linalg.block_diag(np.ones((1, 1)), weights)
                return np.r_[0.0, values], basis[: size + 1].T @ weights
            check = size + max(k // 10, width)
    return None


def _orthonormal(rows: FloatArray, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """QR decomposition of the rows' components orthogonal to a basis: Q by rows, and R."""
    rows = rows - (basis @ rows.T).T @ basis
    columns, triangle = scipy.linalg.qr(rows.T, mode="economic", check_finite=False)
    pivots = np.abs(np.diag(triangle))
    if pivots.min() < _LOSS_OF_ORTHOGONALITY * pivots.max():
        # The remainder of some row was mostly rounding error.
        columns = columns - basis.T @ (basis @ columns)
        columns, _ = scipy.linalg.qr(columns, mode="economic", check_finite=False)
    return np.ascontiguousarray(columns.T, dtype=np.float64), np.asarray(triangle, dtype=np.float64)


def _converged(
    shift: float, count: int, projected: FloatArray, remainder: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Smallest positive Ritz values λ = σ + 1/θ and their coordinates, if residuals are small."""
    theta, weights = scipy.linalg.eigh(projected, check_finite=False)
    with np.errstate(divide="ignore"):
        values = shift + 1.0 / theta
    wanted = np.argsort(np.where(values > 0.0, values, np.inf))[:count]
    residuals = np.linalg.norm(remainder @ weights[-len(remainder) :, wanted], axis=0)
    if not (residuals <= _RITZ_TOLERANCE * np.abs(theta[wanted])).all():
        return None
    return values[wanted], weights[:, wanted]
