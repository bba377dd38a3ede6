"""Statistics of specimens with common vertices: Procrustes alignment, mean shape, components."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray
from solver.errors import OptionError
from solver.mesh import nearest_rotations

_TOLERANCE = 1e-10
"""Change of the mean, relative to its centroid size, at which the alignment has converged."""

_MOST_ROUNDS = 100

_ROUNDING = 10.0 * _TOLERANCE
"""Standard deviation, relative to the centroid size, up to which a component is rounding noise."""


@dataclass(frozen=True, eq=False)
class ProcrustesAlignment:
    """Specimens after generalised Procrustes analysis.

    Parameters
    ----------
    positions
        (N, V, 3) aligned specimens, centred at the origin.
    mean
        (V, 3) their mean.
    sizes
        (N,) centroid sizes before: root of the sum of squared distances from the centroid.
    """

    positions: FloatArray
    mean: FloatArray
    sizes: FloatArray


@dataclass(frozen=True, eq=False)
class ShapeStatistics:
    """Mean shape and principal components of aligned specimens.

    Parameters
    ----------
    alignment
        The aligned specimens.
    components
        (C, V, 3) orthonormal directions of greatest variance, by falling variance: all in which
        specimens differ by more than rounding errors, N − 1 at most.
    variances
        (C,) variances of the scores, with N − 1 in the denominator.
    scores
        (N, C) coordinates of the specimens: a position is the mean plus the sum of scores times
        components.
    """

    alignment: ProcrustesAlignment
    components: FloatArray
    variances: FloatArray
    scores: FloatArray

    @property
    def mean(self) -> FloatArray:
        """(V, 3) mean shape."""
        return self.alignment.mean

    @property
    def total_variance(self) -> float:
        """Sum of the variances of all coordinates."""
        deviations = self.alignment.positions - self.mean
        return float((deviations**2).sum()) / max(len(deviations) - 1, 1)

    @property
    def explained(self) -> FloatArray:
        """(C,) share of each component in the total variance."""
        return self.variances / self.total_variance


def generalised_procrustes(positions: FloatArray, scale: bool = False) -> ProcrustesAlignment:
    """Move, rotate and, if asked for, scale specimens to their common mean; nothing is reflected.

    Rotations onto the mean (Kabsch 1976) and the mean of the rotated specimens follow one another;
    the sum of squared distances from the mean never rises (Gower, "Generalized Procrustes
    analysis", Psychometrika 40(1), 1975). The mean has the orientation of the first specimen.

    Parameters
    ----------
    positions
        (N, V, 3) of specimens with common vertices, N ≥ 1.
    scale
        Scale all to the geometric mean of their centroid sizes: what remains is shape without size.

    Raises
    ------
    OptionError
        There is no specimen, or one is a single point.
    """
    if positions.ndim != 3 or not len(positions):
        raise OptionError("positions", "there is no specimen; give at least one")
    centred = positions - positions.mean(axis=1, keepdims=True)
    sizes: FloatArray = np.sqrt((centred**2).sum(axis=(1, 2)))
    if (sizes == 0.0).any():
        raise OptionError("positions", "all vertices of a specimen are at one point; leave it out")
    common = float(np.exp(np.log(sizes).mean()))
    if scale:
        centred = centred * (common / sizes)[:, None, None]
    mean = centred[0]
    for _ in range(_MOST_ROUNDS):
        aligned = np.stack([_rotated(one, mean) for one in centred])
        following = _rotated(aligned.mean(axis=0), centred[0])
        change = np.sqrt(((following - mean) ** 2).sum())
        mean = following
        if change <= _TOLERANCE * common:
            break
    aligned = np.stack([_rotated(one, mean) for one in centred])
    return ProcrustesAlignment(aligned, aligned.mean(axis=0), sizes)


def shape_statistics(positions: FloatArray, scale: bool = False) -> ShapeStatistics:
    """Mean shape and principal components of specimens.

    Parameters
    ----------
    positions
        (N, V, 3) of specimens with common vertices, N ≥ 1. One specimen, or several of the same
        shape, have no components.
    scale
        As for :func:`generalised_procrustes`.

    Raises
    ------
    OptionError
        As for :func:`generalised_procrustes`.
    """
    alignment = generalised_procrustes(positions, scale)
    count, vertices, _ = positions.shape
    deviations = (alignment.positions - alignment.mean).reshape(count, -1)
    left, values, right = np.linalg.svd(deviations, full_matrices=False)
    variances = values[: count - 1] ** 2 / max(count - 1, 1)
    kept = int((variances > _noise(positions, alignment.sizes) ** 2).sum())
    components, scores = right[:kept], (left * values)[:, :kept]
    # Of the two signs of a component, the one with a positive greatest entry.
    greatest = np.abs(components).argmax(axis=1) if kept else np.empty(0, dtype=np.int64)
    signs = np.where(components[np.arange(kept), greatest] < 0.0, -1.0, 1.0)
    return ShapeStatistics(
        alignment,
        (signs[:, None] * components).reshape(kept, vertices, 3),
        variances[:kept],
        signs * scores,
    )


def _noise(positions: FloatArray, sizes: FloatArray) -> float:
    """Root of the sum of squared rounding errors of a specimen, also of one far from the origin."""
    coordinates = np.sqrt(positions[0].size) * np.spacing(np.abs(positions).max())
    return float(max(_ROUNDING * sizes.max(), coordinates))


def _rotated(points: FloatArray, onto: FloatArray) -> FloatArray:
    """Centred points, rotated onto others."""
    rotated: FloatArray = points @ nearest_rotations((points.T @ onto)[None])[0]
    return rotated
