"""Search for pairwise compatible pairs that cover all points of two small sets.

The partners that each point still has are a bit mask, its *domain*. A search node removes every
pair without a compatible pair at some other point (arc consistency: Mackworth, Artificial
Intelligence 8, 1977), and ends if points that need different partners have too few (Hall's
condition). It then branches on a pair of a point with few partners, which failed often before: with
the pair, or without.
"""

from typing import Final, NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.optimisation.exact.distinct_partners import point_without_partner

MAX_POINTS: Final = 62
"""Most points of a set: the bits of a mask."""
UNDECIDED, FOUND, NONE = 0, 1, 2
"""Outcomes of a search."""
DEPTH, NODES, WORK = 0, 1, 2
"""Positions of its counters; the work, in comparisons of domains."""
_NODE_WORK = 20
"""Work of a node for each point, beside the comparison of domains."""


class PairSearch(NamedTuple):
    """Depth-first search for compatible pairs that cover all points, in arrays, to be resumed.

    Points are the N source points, then the M target points. Pair (x, y) has the number xM + y.
    """

    sources: int  # N
    targets: int  # M
    support: IntArray  # (NM, N+M) mask of each point's partners in pairs compatible with a pair
    apart: IntArray  # (N+M,) mask of the points of the same side that need another partner
    order: IntArray  # (N+M, max(N, M)) partners of each point in the order of trial, then -1
    must: BoolArray  # (N+M,) whether a point has to be covered
    domains: IntArray  # (D+1, N+M) masks at each depth
    changed: BoolArray  # (N+M,) domains at this depth that were changed since they were consistent
    covered: IntArray  # (N+M,) how many chosen pairs cover each point
    chosen: IntArray  # (D,) pairs
    failures: IntArray  # (N+M,) 1, and nodes that ended for want of a partner
    counters: IntArray  # (3,) see `DEPTH`


def start_pair_search(
    source: FloatArray,
    target: FloatArray,
    limit: float,
    one_to_one: bool,
    order: IntArray,
    failures: IntArray,
) -> PairSearch:
    """Return a search that has not begun.

    Parameters
    ----------
    source, target
        (N, N) and (M, M) symmetric metrics of at most `MAX_POINTS` points. Two pairs are compatible
        if their distances differ by at most the limit.
    limit
        The limit.
    one_to_one
        Whether no point may be in two pairs, and only source points must be covered.
    order
        (N+M, max(N, M)) partners of each point, the most promising first, then −1.
    failures
        (N+M,) weights of the points, at least 1: those of great weight are branched on early. The
        search adds 1 where a point has no partner left.
    """
    n, m = len(source), len(target)
    must = np.ones(n + m, dtype=np.bool_)
    must[n:] = not one_to_one or n == m
    domains = np.zeros((n + m + 1, n + m), dtype=np.int64)
    domains[0, :n], domains[0, n:] = (1 << m) - 1, (1 << n) - 1
    farthest = -1.0 if one_to_one else limit
    return PairSearch(
        sources=n,
        targets=m,
        support=_support(source, target, limit, one_to_one),
        apart=np.concatenate([_apart(d, farthest) for d in (source, target)]),
        order=order,
        must=must,
        domains=domains,
        changed=np.ones(n + m, dtype=np.bool_),
        covered=np.zeros(n + m, dtype=np.int64),
        chosen=np.zeros(n + m, dtype=np.int64),
        failures=failures,
        counters=np.zeros(3, dtype=np.int64),
    )


@kernel
def _support(source: FloatArray, target: FloatArray, limit: float, one_to_one: bool) -> IntArray:
    """(NM, N+M) masks of the partners of each point in pairs that are compatible with a pair."""
    n, m = len(source), len(target)
    support = np.zeros((n * m, n + m), dtype=np.int64)
    for x in range(n):
        for y in range(m):
            masks = support[x * m + y]
            for other in range(n):
                for partner in range(m):
                    if one_to_one and (other == x) != (partner == y):
                        continue
                    if abs(source[x, other] - target[y, partner]) <= limit:
                        masks[other] |= 1 << partner
                        masks[n + partner] |= 1 << other
    return support


def _apart(distances: FloatArray, limit: float) -> IntArray:
    """(n,) masks of the points farther from each than a limit, itself left out."""
    far = distances > limit
    np.fill_diagonal(far, False)
    masks: IntArray = (far * (1 << np.arange(len(far)))).sum(axis=1)
    return masks


@kernel
def advance(s: PairSearch, max_work: int) -> int:
    """Visit more nodes until some work is done, or the search ends; return the outcome."""
    stop = s.counters[WORK] + max_work
    while s.counters[WORK] < stop:
        depth = s.counters[DEPTH]
        s.counters[NODES] += 1
        s.counters[WORK] += _NODE_WORK * len(s.must)
        if not _is_consistent(s, s.domains[depth]):
            if depth == 0:
                return NONE
            s.counters[DEPTH] = depth - 1
            _leave(s, depth - 1)
            continue
        pair = _next_pair(s, s.domains[depth])
        if pair < 0:
            return FOUND
        _enter(s, depth, pair)
        s.counters[DEPTH] = depth + 1
    return UNDECIDED


@kernel
def _enter(s: PairSearch, depth: int, pair: int) -> None:
    """Choose a pair: the next depth keeps what is compatible with it."""
    x, y = divmod(pair, s.targets)
    for point in range(len(s.must)):
        before = s.domains[depth, point]
        after = before & s.support[pair, point]
        s.domains[depth + 1, point] = after
        s.changed[point] = after != before
    s.chosen[depth] = pair
    s.covered[x] += 1
    s.covered[s.sources + y] += 1


@kernel
def _leave(s: PairSearch, depth: int) -> None:
    """Drop the pair chosen at a depth: correspondences with it have been searched."""
    x, y = divmod(s.chosen[depth], s.targets)
    s.covered[x] -= 1
    s.covered[s.sources + y] -= 1
    s.changed[:] = False
    _drop(s, s.domains[depth], x, y)


@inlined
def _drop(s: PairSearch, domains: IntArray, x: int, y: int) -> None:
    domains[x] &= ~(1 << y)
    domains[s.sources + y] &= ~(1 << x)
    s.changed[x] = s.changed[s.sources + y] = True


@kernel
def _is_consistent(s: PairSearch, domains: IntArray) -> bool:
    """Drop pairs without support; return whether all points may still be covered."""
    checked = np.empty(len(domains), dtype=np.int64)
    while True:
        count = 0
        for point in range(len(domains)):
            if s.must[point]:
                if domains[point] == 0:
                    s.failures[point] += 1
                    return False
                if s.changed[point]:
                    checked[count] = point
                    count += 1
            s.changed[point] = False
        if count == 0:
            break
        _keep_supported(s, domains, checked[:count])
    lacking = point_without_partner(domains, s.apart, s.must, s.sources)
    if lacking >= 0:
        s.failures[lacking] += 1
    return lacking < 0


@kernel
def _keep_supported(s: PairSearch, domains: IntArray, checked: IntArray) -> None:
    """Drop pairs that are compatible with no pair of one of some points."""
    for x in range(s.sources):
        for y in range(s.targets):
            if (domains[x] >> y) & 1 == 0:
                continue
            masks = s.support[x * s.targets + y]
            s.counters[WORK] += len(checked)
            for point in checked:
                if domains[point] & masks[point] == 0:
                    _drop(s, domains, x, y)
                    break


@kernel
def _next_pair(s: PairSearch, domains: IntArray) -> int:
    """First pair of the uncovered point of fewest partners per failure; −1 if all are covered."""
    best, least = -1, np.inf
    for point in range(len(domains)):
        if s.must[point] and s.covered[point] == 0:
            count, mask = 0, domains[point]
            while mask != 0:
                mask &= mask - 1
                count += 1
            share = count / s.failures[point]
            if share < least:
                best, least = point, share
    if best < 0:
        return -1
    place = 0
    while (domains[best] >> s.order[best, place]) & 1 == 0:
        place += 1
    partner = s.order[best, place]
    if best < s.sources:
        return int(best * s.targets + partner)
    return int(partner * s.targets + best - s.sources)
