"""Quadratic assignment problem and the arrays of its search, reused from problem to problem."""

import math
from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel


class Search(NamedTuple):
    """State of a search, in arrays that are reused for one problem after the other."""

    source: FloatArray  # (N, N) distances
    target: FloatArray  # (N, N)
    source_order: IntArray  # (N, N) points by distance from each point
    target_order: IntArray  # (N, N)
    source_open: FloatArray  # (N, N) distances to open points, sorted
    target_open: FloatArray  # (N, N)
    costs: FloatArray  # (N+1, N, N) of each pair of points beside those decided at each depth
    decided: FloatArray  # (N+1,) cost of the points decided
    reduced: FloatArray  # (N, N) by how much the bound rises if two open points are matched
    assignment: FloatArray  # (3, N) potentials of rows and columns, and slacks
    columns: IntArray  # (2, N) row of each column, and column before it on a path
    row: IntArray  # (N+1,) point decided at each depth
    choices: IntArray  # (N+1, N) its partners, cheapest first
    cursor: IntArray  # (N+1, 2) next choice, and number of choices
    chosen: IntArray  # (N,) partner of each source point
    closed: BoolArray  # (3, N) source points decided, target points taken, columns scanned
    last: IntArray  # (2, 3) the last open points and their possible partners
    best: IntArray  # (N,) the best bijection


def new_search(n: int) -> Search:
    """Return the arrays for searches of n points."""
    square, line = (n, n), (n + 1, n)
    return Search(
        source=np.zeros(square),
        target=np.zeros(square),
        source_order=np.zeros(square, dtype=np.int64),
        target_order=np.zeros(square, dtype=np.int64),
        source_open=np.zeros(square),
        target_open=np.zeros(square),
        costs=np.zeros((n + 1, n, n)),
        decided=np.zeros(n + 1),
        reduced=np.zeros(square),
        assignment=np.zeros((3, n)),
        columns=np.zeros((2, n), dtype=np.int64),
        row=np.zeros(n + 1, dtype=np.int64),
        choices=np.zeros(line, dtype=np.int64),
        cursor=np.zeros((n + 1, 2), dtype=np.int64),
        chosen=np.zeros(n, dtype=np.int64),
        closed=np.zeros((3, n), dtype=np.bool_),
        last=np.zeros((2, 3), dtype=np.int64),
        best=np.zeros(n, dtype=np.int64),
    )


@kernel
def load_problem(
    s: Search,
    source: FloatArray,
    target: FloatArray,
    first: FloatArray,
    second: FloatArray,
    first_order_weight: float,
    minimax: bool,
) -> float:
    """Write a problem without decisions; return the weight of a squared distortion.

    The first-order weight is that of descriptors in their own unit.
    """
    n, m = len(source), first.shape[1]
    total = 0.0
    for x in range(n):
        s.closed[0, x] = s.closed[1, x] = False
        for y in range(n):
            s.source[x, y] = source[x, y]
            s.target[x, y] = target[x, y]
            total += source[x, y] * source[x, y] + target[x, y] * target[x, y]
            s.costs[0, x, y] = 0.0
    _sort(s.source, s.source_order)
    _sort(s.target, s.target_order)
    s.decided[0] = 0.0
    if first_order_weight > 0.0:
        scale = first_order_weight / n
        for x in range(n):
            for y in range(n):
                square = 0.0
                for c in range(m):
                    difference = first[x, c] - second[y, c]
                    square += difference * difference
                s.costs[0, x, y] = scale * math.sqrt(square)
    return 1.0 if minimax or total == 0.0 else 4.0 / total


@kernel
def _sort(distances: FloatArray, order: IntArray) -> None:
    for x in range(len(distances)):
        for point in range(len(distances)):
            place = point
            while place > 0 and distances[x, order[x, place - 1]] > distances[x, point]:
                order[x, place] = order[x, place - 1]
                place -= 1
            order[x, place] = point
