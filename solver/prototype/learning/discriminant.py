"""Discriminant axes of descriptors: the directions in which points differ most."""

import numpy as np
from scipy.linalg import eigh

from solver.arrays import FloatArray
from solver.shape.descriptors import descriptor_deviation

_WITHIN_RIDGE = 0.02
"""Share of the mean variance within points that is added to it along every axis. Chosen on
generated shapes."""

_TOTAL_RIDGE = 0.01
"""Share of the total variance that is added to the variance within points, which few examples
underestimate. Chosen on generated shapes."""


def discriminant_axes(samples: FloatArray, most: int) -> FloatArray:
    """Axes of the greatest variance between points relative to that within points over examples.

    The dimensions of a descriptor are correlated, and most of its variance is that of the class.
    Linear discriminant analysis (Fisher 1936) keeps the part that separates points; the rest is
    assumed to be distributed equally at all points, so that it cancels in (6).

    Parameters
    ----------
    samples
        (N, M, m) descriptors of N points on M examples.
    most
        Greatest number of axes.

    Returns
    -------
    (m, r) float64; along each axis the mean variance of a point is 1, or less where there are few
    examples. r is 0 if the descriptors are constant.
    """
    means = samples.mean(axis=1)
    about = samples - means[:, None, :]
    size = samples.shape[0] * samples.shape[1]
    within = np.einsum("nsi,nsj->ij", about, about) / size
    between = np.cov(means.T, bias=True).reshape(within.shape)
    if descriptor_deviation(np.ascontiguousarray(samples.reshape(size, -1))) == 0.0:
        return np.zeros((samples.shape[2], 0))
    m = len(within)
    ridge = _WITHIN_RIDGE * np.trace(within) / m + 1e-9 * np.trace(within + between) / m
    noise = within + _TOTAL_RIDGE * (within + between) + ridge * np.eye(m)
    _, vectors = eigh(between, noise)
    axes: FloatArray = vectors[:, ::-1][:, : min(most, m)]
    signs = np.sign(axes[np.abs(axes).argmax(axis=0), np.arange(axes.shape[1])])
    oriented: FloatArray = axes * signs
    return oriented
