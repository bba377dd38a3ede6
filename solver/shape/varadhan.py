"""Varadhan approximation of geodesic distances from the heat kernel (2).

Varadhan, "On the behavior of the fundamental solution of the heat equation with variable
coefficients", Comm. Pure Appl. Math. 20(2), 1967.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.shape.laplacian import Spectrum

_LEAST_HEAT = 1e-9
"""Least normalised heat kernel that counts: eigenfunctions are computed with residuals of about
10⁻⁸ (:mod:`solver.shape.laplacian.eigensolver`), and cancel to nothing below."""


def varadhan_distances(spectrum: Spectrum, points: IntArray, time: float) -> FloatArray:
    """Varadhan approximation of geodesic distances from the heat kernel, among some vertices.

    d² = -4t log (h_t(x, y) / √(h_t(x, x) h_t(y, y))), with h_t of equation (2), tends to the
    squared geodesic distance as t → 0 (Varadhan 1967, without the normalisation). At t > 0 it is
    smooth, depends on the whole surface between two points, and needs eigenpairs only; it keeps
    growing where commute times level off. It saturates at 2√(t log 10⁹), where h_t is too small to
    be known.

    Parameters
    ----------
    spectrum
        Spectrum of the shape.
    points
        (A,) int64 vertices.
    time
        t > 0, in the spectrum's unit of area.

    Returns
    -------
    (A, A) float64, exactly symmetric, zero on the diagonal.
    """
    embedded = heat_kernel_embedding(spectrum, points, time)
    found = embedded_varadhan_distances(embedded, embedded, time)
    found = np.maximum(found, found.T)
    np.fill_diagonal(found, 0.0)
    return found


def heat_kernel_embedding(spectrum: Spectrum, points: IntArray, time: float) -> FloatArray:
    """Unit vectors whose inner products are h_t(x, y) / √(h_t(x, x) h_t(y, y)).

    Parameters
    ----------
    spectrum
        Spectrum of the shape, with k eigenpairs.
    points
        (A,) int64 vertices.
    time
        t > 0, in the spectrum's unit of area.

    Returns
    -------
    (A, k) float64
    """
    decay = np.exp(-0.5 * time * spectrum.eigenvalues)
    embedded: FloatArray = spectrum.eigenfunctions[points] * decay
    embedded /= np.linalg.norm(embedded, axis=1)[:, None]
    return embedded


def embedded_varadhan_distances(one: FloatArray, other: FloatArray, time: float) -> FloatArray:
    """Varadhan distances between two sets of points, see :func:`varadhan_distances`.

    Parameters
    ----------
    one, other
        (A, k) and (B, k) of :func:`heat_kernel_embedding`, at the same time.
    time
        Their t > 0, in the spectrum's unit of area.

    Returns
    -------
    (A, B) float64, in the spectrum's unit of length.
    """
    heat = np.clip(one @ other.T, _LEAST_HEAT, 1.0)
    found: FloatArray = np.sqrt(-4.0 * time * np.log(heat))
    return found
