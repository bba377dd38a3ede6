"""Smallest eigenpairs of large sparse symmetric matrices, by block Lanczos inside the spectrum.

The usual shift is just below zero, where the matrix stays definite. A shift σ in the middle of
the eigenvalues wanted brings the farthest of them twice as near, and about half the Krylov space
is enough. Two things make it safe, both from Sylvester's law of inertia: the factor L D Lᵀ of
A - σ I tells by the signs of D how many eigenvalues lie below σ (Ericsson and Ruhe, Math. Comp.
35, 1980). That is how a good σ is recognised; and a second factor, just below the largest
eigenvalue found, tells whether any is missing. On symmetric shapes that happens: eigenvalues of
multiplicity m need blocks of m vectors, or are found one by one, thanks to rounding, or never.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from solver.arrays import FloatArray

_BLOCKS = (4, 16, 64)
"""Vectors per step. Four make good use of the cache; more are for higher multiplicities."""

_TOLERANCE = 1e-8
_BELOW = (0.4, 0.55, 0.7)
"""Share of the wanted eigenvalues below the shift: least, aim, most."""

_ACCURATE, _SOUND = 1e-9, 1e-6
"""Relative errors of a factor's solutions: fit to find eigenpairs with, and to count them with."""

_TRIALS = 5
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
    for factor in _factors(matrix, k, guess):
        for block in _BLOCKS:
            found = _block_lanczos(factor, k, null_vector, block)
            if found is not None and _complete(matrix, found[0]):
                return found
    raise RuntimeError("the eigensolver does not converge")


def _factors(matrix: sp.csc_array, k: int, guess: float) -> Iterator[_Factor]:
    """Factors to try: one inside the spectrum, then one below it."""
    least, aim, most = (share * k for share in _BELOW)
    shift = _BELOW[1] * guess
    for _ in range(_TRIALS):
        factor = _factorised(matrix, shift, _ACCURATE)
        if factor is None:
            shift *= 0.99
        elif least <= factor.below <= most:
            yield factor
            break
        else:
            shift *= min(max(aim / max(factor.below, 1), 0.01), 100.0)
    factor = _factorised(matrix, -1e-8 * float(matrix.diagonal().max()), _SOUND)
    if factor is not None:
        yield factor


def _factorised(matrix: sp.csc_array, shift: float, tolerance: float) -> _Factor | None:
    """Factor of A - σ I, or none if its solutions err by more than a tolerance."""
    n = matrix.shape[0]
    try:
        lu = spla.splu(
            sp.csc_matrix(matrix - shift * sp.eye_array(n)),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            relax=1,  # relaxed supernodes take 40 times as long on meshes of regular subdivision
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # exactly singular: the shift is an eigenvalue
        return None
    factor = _Factor(shift, int((lu.U.diagonal() < 0.0).sum()), lu)
    # Without pivoting nothing bounds the growth of rounding errors, so look at them; and the
    # count is one only if rows were not exchanged.
    probe = np.random.default_rng(_SEED).standard_normal((1, n))
    solved = factor.solve(probe)[0]
    error = np.linalg.norm(matrix @ solved - shift * solved - probe[0])
    sound = (lu.perm_r == lu.perm_c).all() and error < tolerance * np.linalg.norm(probe)
    return factor if sound else None


def _complete(matrix: sp.csc_array, values: FloatArray) -> bool:
    """Whether no eigenvalue is missing among the smallest, as far as can be told."""
    gaps = np.flatnonzero(np.diff(values) > 1e-4 * values[1:])
    below = int(gaps[-1]) + 1  # of what follows the last gap, any members are as good as others
    for place in (0.5, 0.25, 0.75):
        shift = (1.0 - place) * values[below - 1] + place * values[below]
        factor = _factorised(matrix, float(shift), _SOUND)
        if factor is not None:
            return factor.below == below
    return True


def _block_lanczos(
    factor: _Factor, k: int, null_vector: FloatArray, width: int
) -> tuple[FloatArray, FloatArray] | None:
    """The k smallest eigenpairs, the first of them the null vector's; none if they do not converge.

    Every block is orthogonalised against all before, so that no eigenpair is found twice.
    """
    n = len(null_vector)
    capacity = min(5 * k + 25 * width, n // width * width)
    # One vector a row, the first of them the null vector; these rows are seldom too few.
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
    """Orthonormalise rows against a basis and one another: Q and R of what the basis leaves."""
    rows = rows - (basis @ rows.T).T @ basis
    columns, triangle = scipy.linalg.qr(rows.T, mode="economic", check_finite=False)
    pivots = np.abs(np.diag(triangle))
    if pivots.min() < 1e-6 * pivots.max():
        # What was left of some row was mostly rounding error, not orthogonal to anything.
        columns = columns - basis.T @ (basis @ columns)
        columns, _ = scipy.linalg.qr(columns, mode="economic", check_finite=False)
    return np.ascontiguousarray(columns.T, dtype=np.float64), np.asarray(triangle, dtype=np.float64)


def _converged(
    shift: float, count: int, projected: FloatArray, remainder: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Smallest positive Ritz values λ = σ + 1/θ and their vectors, if all residuals are small."""
    theta, weights = scipy.linalg.eigh(projected, check_finite=False)
    with np.errstate(divide="ignore"):
        values = shift + 1.0 / theta
    wanted = np.argsort(np.where(values > 0.0, values, np.inf))[:count]
    residuals = np.linalg.norm(remainder @ weights[-len(remainder) :, wanted], axis=0)
    if not (residuals <= _TOLERANCE * np.abs(theta[wanted])).all():
        return None
    return values[wanted], weights[:, wanted]
