"""Depth-first search; the point with the fewest choices is decided next, cheapest choice first."""

import numpy as np

from solver.kernel import inlined, kernel
from solver.similarity.qap.bound import lower_bound
from solver.similarity.qap.problem import Search

_COMPLETED = 3
"""Number of the last open points, which are matched in all six ways."""


@kernel
def solve(s: Search, weight: float, minimax: bool, limit: float) -> tuple[float, int]:
    """Search for an assignment below a limit; return the least cost and the nodes visited."""
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
                bound = lower_bound(s, depth, weight, minimax, least - slack)
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
def _complete(s: Search, depth: int, weight: float, minimax: bool, least: float) -> float:
    """Try all six ways to match the last three points; return the least cost so far."""
    n, places, costs = len(s.source), s.last, s.costs[depth]
    for side in range(2):
        count = 0
        for point in range(n):
            if not s.closed[side, point]:
                places[side, count] = point
                count += 1
    for permutation in range(6):
        # Three cyclic shifts, each also with the last two exchanged.
        shift, step = permutation % 3, 1 if permutation < 3 else 2
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


@inlined
def _bound_with(minimax: bool, bound: float, reduced: float) -> float:
    return reduced if minimax else bound + reduced


@kernel
def _order_choices(s: Search, depth: int, minimax: bool, bound: float, limit: float) -> None:
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
                if _bound_with(minimax, bound, s.reduced[x, y]) < limit:
                    count += 1
        if count < fewest or (count == fewest and total > dearest):
            best, fewest, dearest = x, count, total
    s.row[depth] = best
    costs, choices = s.reduced[best], s.choices[depth]
    kept = 0
    for y in range(n):
        if s.closed[1, y] or not _bound_with(minimax, bound, costs[y]) < limit:
            continue
        place = kept
        while place > 0 and costs[choices[place - 1]] > costs[y]:
            choices[place] = choices[place - 1]
            place -= 1
        choices[place] = y
        kept += 1
    s.cursor[depth, 1] = kept


@kernel
def _descend(s: Search, depth: int, weight: float, minimax: bool) -> None:
    """Match the point of this depth with its next choice; update the costs of open points."""
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
