"""Nearest neighbours in many dimensions, where space-partitioning trees do not help."""

import numpy as np

from solver.arrays import IntArray, RealArray

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
    (S,) int64 rows of `points`. O(S M k) time, O(S + M) memory.
    """
    halves = np.einsum("ij,ij->i", points, points)
    halves *= 0.5
    found = np.empty(len(queries), dtype=np.int64)
    rows = max(_BLOCK_SIZE // max(len(points), 1), _MIN_BLOCK_ROWS)
    for start in range(0, len(queries), rows):
        products = queries[start : start + rows] @ points.T
        np.subtract(halves, products, out=products)
        np.argmin(products, axis=1, out=found[start : start + rows])
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
    here = 0.5 * np.einsum("ij,ij->i", points, points)
    there = 0.5 * np.einsum("ij,ij->i", others, others)
    images = np.empty(len(points), dtype=np.int64)
    back = np.zeros(len(others), dtype=np.int64)
    least = np.full(len(others), np.inf, dtype=points.dtype)
    rows = max(_BLOCK_SIZE // max(len(others), 1), _MIN_BLOCK_ROWS)
    for start in range(0, len(points), rows):
        block = slice(start, start + rows)
        squares = points[block] @ others.T
        np.subtract(there, squares, out=squares)
        np.argmin(squares, axis=1, out=images[block])
        squares += here[block, None]
        nearest = np.argmin(squares, axis=0)
        found = squares[nearest, np.arange(len(others))]
        closer = found < least
        back[closer], least[closer] = start + nearest[closer], found[closer]
    return images, back
