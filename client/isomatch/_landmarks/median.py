"""Geometric median of points."""

from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_ROUNDS: Final = 200
_PRECISION: Final = 1e-12


def geometric_median(points: Floats, weights: Floats) -> Floats:
    """Return the point of least weighted sum of distances.

    One of the points is the median if the unit vectors from it to the others, times their weights,
    add up to less than its own weight (Kuhn 1973); otherwise Weiszfeld's iteration finds it, from
    the weighted mean. Of two points of equal weight it is the middle.

    Parameters
    ----------
    points
        (T, 3), at least one.
    weights
        (T,) not negative; if all are 0 they count the same.
    """
    shares = weights if weights.sum() > 0.0 else np.ones(len(points))
    shares = shares / shares.sum()
    point: Floats
    for point in points:
        offsets = points - point
        distances = np.linalg.norm(offsets, axis=1)
        same = distances == 0.0
        pull = shares[~same] / distances[~same] @ offsets[~same]
        if np.linalg.norm(pull) < shares[same].sum():
            return point
    found: Floats = shares @ points
    scale = np.abs(points - found).max()
    for _ in range(_ROUNDS):
        distances = np.maximum(np.linalg.norm(points - found, axis=1), _PRECISION * scale)
        pulls = shares / distances
        moved = pulls @ points / pulls.sum()
        if np.abs(moved - found).max() <= _PRECISION * scale:
            break
        found = moved
    return found
