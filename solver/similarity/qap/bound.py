"""Gilmore-Lawler lower bound of all completions of a partial assignment.

The bound at a node is that of Gilmore (1962) and Lawler (1963). Matching an open point x with an
open point y costs at least their costs with the points decided, and half the cost of their
distances to open points when both are sorted, since sorted sequences differ least. The linear
assignment of these costs is a lower bound of all completions. For the greatest distortion, maxima
take the place of sums, and nothing is halved.
"""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel
from solver.similarity.qap.problem import Search

_ASSIGNED_FROM = 5
"""Open points from which the assignment is solved; with fewer, its reduction alone bounds."""


@kernel
def lower_bound(s: Search, depth: int, weight: float, minimax: bool, limit: float) -> float:
    """Lower bound of all completions; writes its rise with each pair of open points."""
    _collect_open(s.source, s.source_order, s.closed[0], s.source_open)
    _collect_open(s.target, s.target_order, s.closed[1], s.target_open)
    _completions(s, depth, weight, minimax)
    decided: float = s.decided[depth]
    if minimax:
        return max(decided, _bottleneck(s))
    bound = decided + _reduce(s)
    if bound < limit and len(s.source) - depth >= _ASSIGNED_FROM:
        bound += _assign(s)
    return bound


@kernel
def _collect_open(
    distances: FloatArray, order: IntArray, closed: BoolArray, sorted_open: FloatArray
) -> None:
    """Write the distances of each open point to the other open ones, shortest first."""
    n = len(distances)
    for x in range(n):
        if closed[x]:
            continue
        count = 0
        for place in range(n):
            other = order[x, place]
            if other != x and not closed[other]:
                sorted_open[x, count] = distances[x, other]
                count += 1


@kernel
def _completions(s: Search, depth: int, weight: float, minimax: bool) -> None:
    """Write the least cost of two open points, with decided points and with open ones."""
    n = len(s.source)
    others = n - depth - 1
    costs = s.costs[depth]
    for x in range(n):
        if s.closed[0, x]:
            continue
        near = s.source_open[x]
        for y in range(n):
            if s.closed[1, y]:
                continue
            far, total, worst = s.target_open[y], 0.0, costs[x, y]
            for k in range(others):
                difference = near[k] - far[k]
                if minimax:
                    worst = max(worst, abs(difference))
                else:
                    total += difference * difference
            s.reduced[x, y] = worst + 0.5 * weight * total


@kernel
def _bottleneck(s: Search) -> float:
    """The greatest of the least costs of open points on either side."""
    n = len(s.source)
    greatest = 0.0
    for x in range(n):
        if not s.closed[0, x]:
            least = np.inf
            for y in range(n):
                if not s.closed[1, y]:
                    least = min(least, s.reduced[x, y])
            greatest = max(greatest, least)
    for y in range(n):
        if not s.closed[1, y]:
            least = np.inf
            for x in range(n):
                if not s.closed[0, x]:
                    least = min(least, s.reduced[x, y])
            greatest = max(greatest, least)
    return greatest


@kernel
def _reduce(s: Search) -> float:
    """Subtract the least cost of every row, then of every column; the sum of these."""
    n = len(s.source)
    total = 0.0
    for x in range(n):
        if not s.closed[0, x]:
            least = np.inf
            for y in range(n):
                if not s.closed[1, y]:
                    least = min(least, s.reduced[x, y])
            total += least
            for y in range(n):
                s.reduced[x, y] -= least
    for y in range(n):
        if not s.closed[1, y]:
            least = np.inf
            for x in range(n):
                if not s.closed[0, x]:
                    least = min(least, s.reduced[x, y])
            if least > 0.0:
                total += least
                for x in range(n):
                    s.reduced[x, y] -= least
    return total


@kernel
def _assign(s: Search) -> float:
    """Solve the assignment of open points and subtract its potentials; its cost.

    By shortest augmenting paths (Jonker and Volgenant, Computing 1987).
    """
    n = len(s.source)
    rows, columns, owner = s.assignment[0], s.assignment[1], s.columns[0]
    for x in range(n):
        rows[x] = columns[x] = 0.0
        owner[x] = -1
    for x in range(n):
        if not s.closed[0, x]:
            _augment(s, x)
    total = 0.0
    for x in range(n):
        if not s.closed[0, x]:
            total += rows[x]
            for y in range(n):
                s.reduced[x, y] -= rows[x] + columns[y]
    for y in range(n):
        if not s.closed[1, y]:
            total += columns[y]
    return total


@kernel
def _augment(s: Search, x: int) -> None:
    """Give one more row a column, along the shortest path of changes."""
    n = len(s.source)
    rows, columns, slack = s.assignment[0], s.assignment[1], s.assignment[2]
    owner, before, scanned = s.columns[0], s.columns[1], s.closed[2]
    for y in range(n):
        slack[y] = np.inf
        scanned[y] = False
    last, row = -1, x
    while row >= 0:
        step, nearest = np.inf, -1
        for y in range(n):
            if s.closed[1, y] or scanned[y]:
                continue
            cost = s.reduced[row, y] - rows[row] - columns[y]
            if cost < slack[y]:
                slack[y] = cost
                before[y] = last
            if slack[y] < step:
                step, nearest = slack[y], y
        rows[x] += step
        for y in range(n):
            if scanned[y]:
                rows[owner[y]] += step
                columns[y] -= step
            else:
                slack[y] -= step
        scanned[nearest] = True
        last, row = nearest, owner[nearest]
    while last >= 0:
        previous = before[last]
        owner[last] = x if previous < 0 else owner[previous]
        last = previous
