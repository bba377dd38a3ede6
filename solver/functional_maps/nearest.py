"""Nearest neighbours in many dimensions, where space-partitioning trees do not help."""

from collections.abc import Iterator

import numpy as np

from solver.arrays import IntArray, RealArray
from solver.kernel import kernel

_BLOCK_SIZE = 200_000
"""Distances computed at a time: they stay in the processor's cache."""

_MIN_BLOCK_ROWS = 64
"""Least number of queries at a time: fewer make matrix products up to twelve times as slow."""


def nearest_points(queries: RealArray, points: RealArray) -> IntArray:
    """Find the nearest point to each query, by exhaustive search.

    Parameters
    ----------
    queries, points
        (S, k) and (M, k), both in double or both in single precision, which the search uses.

    Returns
    -------
    (S,) int64 rows of `points`. O(S M k) time, O((S + M) k) memory.
    """
    ours, theirs = _lifted(queries, points)
    found = np.empty(len(queries), dtype=np.int64)
    for block in _blocks(len(queries), len(points)):
        np.argmax(ours[block] @ theirs.T, axis=1, out=found[block])
    return found


def mutual_nearest_points(points: RealArray, others: RealArray) -> tuple[IntArray, IntArray]:
    """Find the nearest of the others to each point, and the nearest point to each other.

    Parameters
    ----------
    points, others
        As for :func:`nearest_points`.

    Returns
    -------
    (S,) int64 rows of `others`, and (M,) int64 rows of `points`. Each product of a point and an
    other is computed once.
    """
    ours, theirs = _lifted(points, others)
    halves = _half_squares(points)
    images = np.empty(len(points), dtype=np.int64)
    back = np.zeros(len(others), dtype=np.int64)
    most = np.full(len(others), -np.inf, dtype=points.dtype)
    for block in _blocks(len(points), len(others)):
        products = ours[block] @ theirs.T
        np.argmax(products, axis=1, out=images[block])
        _nearest_row(products, halves[block], block.start, most, back)
    return images, back


def _lifted(queries: RealArray, points: RealArray) -> tuple[RealArray, RealArray]:
    """(S, k + 1) and (M, k + 1) whose products are x · y - |y|²/2: the greater, the nearer."""
    k = queries.shape[1]
    ours = np.empty((len(queries), k + 1), dtype=queries.dtype)
    theirs = np.empty((len(points), k + 1), dtype=points.dtype)
    ours[:, :k], ours[:, k] = queries, 1.0
    theirs[:, :k], theirs[:, k] = points, -_half_squares(points)
    return ours, theirs


def _half_squares(points: RealArray) -> RealArray:
    halves: RealArray = 0.5 * np.einsum("ij,ij->i", points, points)
    return halves


def _blocks(queries: int, points: int) -> Iterator[slice]:
    rows = max(_BLOCK_SIZE // max(points, 1), _MIN_BLOCK_ROWS)
    return (slice(start, start + rows) for start in range(0, queries, rows))


@kernel
def _nearest_row(
    products: RealArray, halves: RealArray, start: int, most: RealArray, back: IntArray
) -> None:
    """Update the nearest point to each other by a block of points.

    Parameters
    ----------
    products
        (n, M) of :func:`_lifted`, for points `start`, `start` + 1, ...
    halves
        (n,) |x|²/2 of these points.
    most, back
        (M,) greatest difference of the two so far, and its point; overwritten.
    """
    for i in range(products.shape[0]):
        for j in range(products.shape[1]):
            value = products[i, j] - halves[i]
            # Selected, not branched: loops without branches use vector instructions.
            nearer = value > most[j]
            most[j] = value if nearer else most[j]
            back[j] = start + i if nearer else back[j]
