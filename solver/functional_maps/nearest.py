"""Nearest points in a space of many dimensions, where trees are of no use."""

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray

_CELLS_SEARCHED = 24
_BLOCK = 200_000
"""Distances at a time, so that they stay in the processor's cache."""
_ROWS = 64
"""Images at a time, at least: of fewer, products take up to twelve times as long."""


def nearest_points(images: RealArray, points: RealArray) -> IntArray:
    """Nearest of some points to each of others, among all.

    Parameters
    ----------
    images, points
        (S, k) and (M, k), both of double or both of single precision, in which is computed.

    Returns
    -------
    (S,) int64 rows of `points`. O(S M k) time, O(S + M) memory.
    """
    halves = np.einsum("ij,ij->i", points, points)
    halves *= 0.5
    found = np.empty(len(images), dtype=np.int64)
    rows = max(_BLOCK // max(len(points), 1), _ROWS)
    for start in range(0, len(images), rows):
        products = images[start : start + rows] @ points.T
        np.subtract(halves, products, out=products)
        np.argmin(products, axis=1, out=found[start : start + rows])
    return found


def nearly_nearest_points(images: FloatArray, points: FloatArray, cells: int) -> IntArray:
    """Nearest of some points to each of others, among those in the cells around.

    Points and images are gathered around some of the points; each image is compared with the
    points of the cells nearest to its own. The point found is the nearest, or not much farther.

    Parameters
    ----------
    images, points
        (S, k) and (M, k).
    cells
        How many there are to be, at least.

    Returns
    -------
    (S,) int64 rows of `points`. O((S + M) C k) time for C cells.
    """
    centres = points[:: max(len(points) // cells, 1)]
    cell, home = nearest_points(points, centres), nearest_points(images, centres)
    members = _rows_of(cell, len(centres))
    visitors = _rows_of(home, len(centres))
    count = min(_CELLS_SEARCHED, len(centres))
    found = np.empty(len(images), dtype=np.int64)
    for number, here in enumerate(visitors):
        if len(here):
            apart = np.linalg.norm(centres - centres[number], axis=1)
            around = np.argpartition(apart, count - 1)[:count]
            there = np.concatenate([members[place] for place in around])
            found[here] = there[nearest_points(images[here], points[there])]
    return found


def _rows_of(number: IntArray, count: int) -> list[IntArray]:
    """Rows that have each number."""
    order = np.argsort(number, kind="stable")
    ends = np.searchsorted(number[order], np.arange(1, count))
    return [rows.astype(np.int64) for rows in np.split(order, ends)]
