"""Rotations nearest to matrices: the polar factor, or Kabsch's rotation of two sets of points.

Horn, "Closed-form solution of absolute orientation using unit quaternions", JOSA A 4(4), 1987: the
unit quaternion of the rotation is the eigenvector of a symmetric 4 x 4 matrix for its greatest
eigenvalue. Theobald, "Rapid calculation of RMSDs using a quaternion-based characteristic
polynomial", Acta Cryst. A61, 2005: Newton's method from above finds that eigenvalue.
"""

import numpy as np

from solver.arrays import FloatArray
from solver.kernel import kernel

_STEPS = 50
"""Most steps of Newton's method, which takes some six; more where two eigenvalues nearly agree."""

_PRECISION = 1e-14
"""Least step of Newton's method, relative to the eigenvalue."""

_LEAST = 1e-24
"""Squared length of a column of cofactors, for a matrix of norm 1, below which the two greatest
eigenvalues agree: many rotations are equally near, and the identity is returned."""


@kernel
def nearest_rotations(moments: FloatArray) -> FloatArray:
    """Rotations R of determinant 1 that maximise tr(Rᵀ M), as R that minimise ‖R − M‖.

    Parameters
    ----------
    moments
        (n, 3, 3) matrices M: for points x that are to go to z = x R, the sums Σ xᵀ z.

    Returns
    -------
    (n, 3, 3) float64; the identity where M leaves the rotation undetermined.
    """
    rotations = np.empty_like(moments)
    matrix = np.empty((4, 4))
    for i in range(len(moments)):
        scale = np.sqrt((moments[i] ** 2).sum())
        rotations[i] = np.eye(3)
        if scale > 0.0 and np.isfinite(scale):
            _quaternion_matrix(moments[i] / scale, matrix)
            value = _greatest_eigenvalue(matrix)
            for k in range(4):
                matrix[k, k] -= value
            _null_rotation(matrix, rotations[i])
    return rotations


@kernel
def _quaternion_matrix(moment: FloatArray, matrix: FloatArray) -> None:
    """Write Horn's matrix K, for which qᵀ K q = tr(Rᵀ M), R being the rotation of q."""
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        matrix[0, a + 1] = matrix[a + 1, 0] = moment[b, c] - moment[c, b]
        matrix[a + 1, a + 1] = moment[a, a] - moment[b, b] - moment[c, c]
        matrix[b + 1, c + 1] = matrix[c + 1, b + 1] = moment[b, c] + moment[c, b]
    matrix[0, 0] = moment[0, 0] + moment[1, 1] + moment[2, 2]


@kernel
def _greatest_eigenvalue(matrix: FloatArray) -> float:
    """Greatest root of λ⁴ − 2 λ² + c₁ λ + c₀, K being that of a matrix of norm 1."""
    constant = 0.0
    for k in range(4):
        constant += matrix[0, k] * _cofactor(matrix, 0, k)
    # The trace of the third power of a traceless matrix is three times the sum of its minors.
    linear = 0.0
    for k in range(4):
        linear -= _cofactor(matrix, k, k)
    value = np.sqrt(3.0)  # no sum of three singular values is greater
    for _ in range(_STEPS):
        square = value * value
        slope = (4.0 * square - 4.0) * value + linear
        if slope <= 0.0:
            break
        step = ((square - 2.0) * square + linear * value + constant) / slope
        value -= step
        if step <= _PRECISION * value:
            break
    return float(value)


@kernel
def _cofactor(matrix: FloatArray, row: int, column: int) -> float:
    """Signed determinant of a 4 x 4 matrix without a row and a column."""
    a, b, c = (row + 1) % 4, (row + 2) % 4, (row + 3) % 4
    d, e, f = (column + 1) % 4, (column + 2) % 4, (column + 3) % 4
    found = (
        matrix[a, d] * (matrix[b, e] * matrix[c, f] - matrix[b, f] * matrix[c, e])
        - matrix[a, e] * (matrix[b, d] * matrix[c, f] - matrix[b, f] * matrix[c, d])
        + matrix[a, f] * (matrix[b, d] * matrix[c, e] - matrix[b, e] * matrix[c, d])
    )
    return float(found if (row + column) % 2 == 0 else -found)


@kernel
def _null_rotation(singular: FloatArray, rotation: FloatArray) -> None:
    """Write the rotation of the quaternion in the null space of a 4 x 4 matrix of rank 3.

    The null space is spanned by any column of cofactors; the longest is the most accurate.
    """
    best = 0
    for k in range(1, 4):
        if abs(_cofactor(singular, k, k)) > abs(_cofactor(singular, best, best)):
            best = k
    q = np.empty(4)
    for k in range(4):
        q[k] = _cofactor(singular, best, k)
    square = (q**2).sum()
    if square <= _LEAST:
        return
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        rotation[a, a] = (
            q[0] * q[0] + q[a + 1] * q[a + 1] - q[b + 1] * q[b + 1] - q[c + 1] * q[c + 1]
        ) / square
        rotation[a, b] = 2.0 * (q[a + 1] * q[b + 1] + q[0] * q[c + 1]) / square
        rotation[b, a] = 2.0 * (q[a + 1] * q[b + 1] - q[0] * q[c + 1]) / square
