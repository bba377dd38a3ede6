"""Bijections of least distortion between sets of a few points, of many pairs of shapes at once.

The problem is (5) with N points on either side, all of them matched, and all pairs candidates: the
quadratic assignment problem. A dissimilarity matrix solves it hundreds of thousands of times, so
here is a branch and bound for nothing else, which allocates next to no memory within a batch.

The bound at a node is that of Gilmore (1962) and Lawler (1963). To give an open point x the open
point y costs at least what they cost beside the points decided, and half of what their distances to
open points cost when both are sorted, since sorted sequences differ least. The least assignment of
these costs is no more than any completion costs. For the greatest distortion, maxima take the place
of sums, and nothing is halved.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import inlined, kernel

MAX_POINTS = 10
"""Most points that a bijection is searched of: no search visits more than ten million nodes."""

_COMPLETED = 3
"""Open points that are matched in all ways there are."""

_ASSIGNED_FROM = 5
"""Open points from which the assignment is solved: with fewer its bound is not worth its time."""


class Bijections(NamedTuple):
    """Least distortions of pairs of shapes, each proven.

    Attributes
    ----------
    costs
        (P,) least cost of each pair, over all samplings and all bijections.
    samplings
        (P,) the sampling that has it.
    partners
        (P, N) point of the second shape for each point of the first, in that sampling.
    nodes
        (P,) search nodes visited.
    """

    costs: FloatArray
    samplings: IntArray
    partners: IntArray
    nodes: IntArray


class _Search(NamedTuple):
    """One search, all in arrays, which serve one problem after the other."""

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


def least_distortions(
    distances: FloatArray,
    descriptors: FloatArray,
    pairs: IntArray,
    first_order_weight: float,
    minimax: bool,
) -> Bijections:
    """Find the bijection of least distortion for each of many pairs of shapes.

    Parameters
    ----------
    distances
        (K, S, N, N) metrics of K shapes between the points of S samplings.
    descriptors
        (K, S, N, m) descriptors at these points, m = 0 for none.
    pairs
        (P, 2) indices of shapes.
    first_order_weight
        Of the descriptors.
    minimax
        Whether the greatest distortion of a distance is minimised, in the unit of the distances
        and without descriptors. Otherwise the cost is the energy (5) for each point, with the
        weights of a match: the mean squared distortion of the distances, divided by the mean of
        the squared distances of both shapes, and the weight times the mean deviation of the
        descriptors, divided by their root mean square deviation on both shapes.

    Returns
    -------
    Bijections
    """
    n, count = distances.shape[2], len(pairs)
    found = Bijections(
        np.zeros(count),
        np.zeros(count, dtype=np.int64),
        np.zeros((count, n), dtype=np.int64),
        np.zeros(count, dtype=np.int64),
    )
    weight = 0.0 if minimax else float(first_order_weight)
    _compare(
        _new_search(n),
        np.ascontiguousarray(distances),
        np.ascontiguousarray(descriptors),
        np.ascontiguousarray(pairs),
        weight,
        minimax,
        found,
    )
    return found


def _new_search(n: int) -> _Search:
    square, line = (n, n), (n + 1, n)
    return _Search(
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
def _compare(
    search: _Search,
    distances: FloatArray,
    descriptors: FloatArray,
    pairs: IntArray,
    first_order_weight: float,
    minimax: bool,
    found: Bijections,
) -> None:
    """Solve all pairs, for each the sampling of the least bound first."""
    n, kinds = distances.shape[2], distances.shape[1]
    bounds = np.zeros(kinds)
    for p in range(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        for k in range(kinds):
            weight = _pose(
                search,
                distances[i, k],
                distances[j, k],
                descriptors[i, k],
                descriptors[j, k],
                first_order_weight,
                minimax,
            )
            bounds[k] = _bound(search, 0, weight, minimax, np.inf)
        least = np.inf
        for _ in range(kinds):
            k = 0
            for other in range(kinds):
                if bounds[other] < bounds[k]:
                    k = other
            if not bounds[k] < least:
                break
            bounds[k] = np.inf
            weight = _pose(
                search,
                distances[i, k],
                distances[j, k],
                descriptors[i, k],
                descriptors[j, k],
                first_order_weight,
                minimax,
            )
            cost, nodes = _solve(search, weight, minimax, least)
            found.nodes[p] += nodes
            if cost < least:
                least = cost
                found.costs[p] = cost
                found.samplings[p] = k
                for x in range(n):
                    found.partners[p, x] = search.best[x]


@kernel
def _pose(
    s: _Search,
    source: FloatArray,
    target: FloatArray,
    first: FloatArray,
    second: FloatArray,
    first_order_weight: float,
    minimax: bool,
) -> float:
    """Write a problem with nothing decided; the weight of a pair's squared distortion."""
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
    if first_order_weight > 0.0 and m > 0:
        scale = first_order_weight / (n * _deviation(first, second))
        for x in range(n):
            for y in range(n):
                square = 0.0
                for c in range(m):
                    difference = first[x, c] - second[y, c]
                    square += difference * difference
                s.costs[0, x, y] = scale * math.sqrt(square)
    return 1.0 if minimax or total == 0.0 else 4.0 / total


@kernel
def _deviation(first: FloatArray, second: FloatArray) -> float:
    """Root mean square deviation of descriptors from their mean on both shapes; 1 if all agree."""
    n, m = first.shape
    total = 0.0
    for c in range(m):
        mean = 0.0
        for x in range(n):
            mean += (first[x, c] + second[x, c]) / (2 * n)
        for x in range(n):
            total += (first[x, c] - mean) ** 2 + (second[x, c] - mean) ** 2
    return math.sqrt(total / (2 * n)) if total > 0.0 else 1.0


@kernel
def _sort(distances: FloatArray, order: IntArray) -> None:
    for x in range(len(distances)):
        for point in range(len(distances)):
            place = point
            while place > 0 and distances[x, order[x, place - 1]] > distances[x, point]:
                order[x, place] = order[x, place - 1]
                place -= 1
            order[x, place] = point


@kernel
def _solve(s: _Search, weight: float, minimax: bool, limit: float) -> tuple[float, int]:
    """Search for a bijection that costs less than a limit; the least cost, and nodes visited."""
    last = len(s.source) - _COMPLETED
    least, depth, nodes, entering = limit, 0, 0, True
    while True:
        if entering:
            nodes += 1
            entering = False
            s.cursor[depth, 0] = s.cursor[depth, 1] = 0
            if depth == last:
                least = _complete(s, depth, weight, minimax, least)
            else:
                # Sums are rounded, maxima are not.
                slack = 0.0 if minimax or least == np.inf else 1e-12 * least
                bound = _bound(s, depth, weight, minimax, least - slack)
                if bound < least - slack:
                    _order_choices(s, depth, minimax, bound, least - slack)
        if s.cursor[depth, 0] >= s.cursor[depth, 1]:
            if depth == 0:
                return least, nodes
            depth -= 1
            x = s.row[depth]
            s.closed[1, s.chosen[x]] = False
            s.closed[0, x] = False
            continue
        _descend(s, depth, weight, minimax)
        depth += 1
        entering = True


@kernel
def _complete(s: _Search, depth: int, weight: float, minimax: bool, least: float) -> float:
    """Try all six ways to match the last three points; the least cost, of these or known before."""
    n, places, costs = len(s.source), s.last, s.costs[depth]
    for side in range(2):
        count = 0
        for point in range(n):
            if not s.closed[side, point]:
                places[side, count] = point
                count += 1
    for turn in range(6):
        # Three cyclic shifts, each also with the last two exchanged.
        shift, step = turn % 3, 1 if turn < 3 else 2
        cost = s.decided[depth]
        for i in range(3):
            x, y = places[0, i], places[1, (shift + step * i) % 3]
            cost = max(cost, costs[x, y]) if minimax else cost + costs[x, y]
            for j in range(i):
                other, partner = places[0, j], places[1, (shift + step * j) % 3]
                difference = s.source[x, other] - s.target[y, partner]
                if minimax:
                    cost = max(cost, abs(difference))
                else:
                    cost += weight * difference * difference
        if cost < least:
            least = cost
            for x in range(n):
                s.best[x] = s.chosen[x]
            for i in range(3):
                s.best[places[0, i]] = places[1, (shift + step * i) % 3]
    return least


@kernel
def _bound(s: _Search, depth: int, weight: float, minimax: bool, limit: float) -> float:
    """What every completion costs at least; and what it rises by with each pair of open points."""
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
def _completions(s: _Search, depth: int, weight: float, minimax: bool) -> None:
    """Write what two open points cost at least, beside decided points and beside open ones."""
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
def _bottleneck(s: _Search) -> float:
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
def _reduce(s: _Search) -> float:
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
def _assign(s: _Search) -> float:
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
def _augment(s: _Search, x: int) -> None:
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


@inlined
def _rise(minimax: bool, bound: float, reduced: float) -> float:
    return reduced if minimax else bound + reduced


@kernel
def _order_choices(s: _Search, depth: int, minimax: bool, bound: float, limit: float) -> None:
    """Take the open point with the fewest choices below a limit; order these by their bounds."""
    n = len(s.source)
    best, fewest, dearest = -1, n + 1, -np.inf
    for x in range(n):
        if s.closed[0, x]:
            continue
        count, total = 0, 0.0
        for y in range(n):
            if not s.closed[1, y]:
                total += s.reduced[x, y]
                if _rise(minimax, bound, s.reduced[x, y]) < limit:
                    count += 1
        if count < fewest or (count == fewest and total > dearest):
            best, fewest, dearest = x, count, total
    s.row[depth] = best
    costs, choices = s.reduced[best], s.choices[depth]
    kept = 0
    for y in range(n):
        if s.closed[1, y] or not _rise(minimax, bound, costs[y]) < limit:
            continue
        place = kept
        while place > 0 and costs[choices[place - 1]] > costs[y]:
            choices[place] = choices[place - 1]
            place -= 1
        choices[place] = y
        kept += 1
    s.cursor[depth, 1] = kept


@kernel
def _descend(s: _Search, depth: int, weight: float, minimax: bool) -> None:
    """Match the point of this depth with its next choice, and write what that costs open points."""
    n = len(s.source)
    x, y = s.row[depth], s.choices[depth, s.cursor[depth, 0]]
    s.cursor[depth, 0] += 1
    s.chosen[x] = y
    s.closed[0, x] = s.closed[1, y] = True
    cost = s.costs[depth, x, y]
    s.decided[depth + 1] = max(s.decided[depth], cost) if minimax else s.decided[depth] + cost
    before, after = s.costs[depth], s.costs[depth + 1]
    source, target = s.source[x], s.target[y]
    for other in range(n):
        if s.closed[0, other]:
            continue
        for partner in range(n):
            difference = source[other] - target[partner]
            if minimax:
                after[other, partner] = max(before[other, partner], abs(difference))
            else:
                after[other, partner] = before[other, partner] + weight * difference * difference
