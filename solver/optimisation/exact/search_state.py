"""State of a depth-first search over the source points of a labelling problem, and its bound.

The bound at a node lets every open source point choose its candidate on its own, at its unary
cost, its exact pairwise costs to the points decided already, and *half* of the least pairwise cost
with each point still open (the other half is counted with that point). An open point that stays
unmatched has no pairwise cost, so that the halves which others counted with it are subtracted from
its own occlusion cost. Once two points of a triple are decided, its costs count for the third one.
"""

from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.labelling import TripleCosts
from solver.optimisation.exact.incumbents import OPEN, Incumbents
from solver.optimisation.reparametrisation import ReparametrisedCosts
from solver.optimisation.rounding import ROUNDING

DEPTH, NODES, ENTERING, FINISHED = 0, 1, 2, 3
"""Positions of the counters; the last two are flags: the node is new, the search is exhausted."""


class Search(NamedTuple):
    """State of the depth-first search, all in arrays, so that it can stop and go on."""

    rows: IntArray  # (N+1,) candidates of source point x are rows[x] .. rows[x+1]
    own: ReparametrisedCosts  # costs of the problem itself, of all its candidates
    scale: float  # of these costs
    kept: IntArray  # (V,) those candidates that are searched
    triples: TripleCosts  # of the candidates that are searched, for lower bounds
    changes: FloatArray  # (V+N, V): what candidates' costs change by with each decision
    occlusion_changes: FloatArray  # (V+N, N): likewise of the costs of leaving points unmatched
    levels: FloatArray  # (N+1, V): cost of each candidate given the decisions at each depth
    occlusion: FloatArray  # (N+1, N): cost of leaving x unmatched, likewise
    bound: FloatArray  # (N+1,) cost of the decided points
    rest: FloatArray  # (N+1,) least costs of the open points, together
    row: IntArray  # (N+1,) source point decided at each depth
    costs_here: FloatArray  # (K+1,) costs of the choices at the node being looked at
    choices: IntArray  # (N+1, K+1) its choices, cheapest first
    cursor: IntArray  # (N+1, 2) next choice, and number of choices
    least: FloatArray  # (N+1, N) least cost of each open point at each depth
    chosen: IntArray  # (N,) candidate of each source point, UNMATCHED, or OPEN
    best: Incumbents
    counters: IntArray  # (4,) see `DEPTH`


def start_search(
    own: ReparametrisedCosts,
    reparametrised: ReparametrisedCosts,
    points: IntArray,
    kept: IntArray,
    best: Incumbents,
) -> Search:
    """Return a search that has not begun.

    Parameters
    ----------
    own
        Costs of the problem.
    reparametrised
        Costs for lower bounds, of the candidates kept.
    points
        (V,) source point of each of these, ascending.
    kept
        (V,) candidates of the problem that are searched, ascending.
    best
        The best correspondences known; improved in place.
    """
    n, v = len(own.occlusion), len(kept)
    rows = np.searchsorted(points, np.arange(n + 1)).astype(np.int64)
    halves, most = _halves(rows, reparametrised.pairwise)
    changes, occlusion_changes = _changes(rows, reparametrised.pairwise, halves, most)
    unary = reparametrised.unary + halves.sum(axis=0)
    occlusion = reparametrised.occlusion - most.sum(axis=0)
    widest = int(np.diff(rows).max(initial=0))
    bound = np.zeros(n + 1)
    bound[0] = reparametrised.constant
    return Search(
        rows=rows,
        own=own,
        scale=own.scale,
        kept=kept,
        triples=reparametrised.triples,
        changes=changes,
        occlusion_changes=occlusion_changes,
        levels=np.concatenate([unary[None], np.zeros((n, v))]),
        occlusion=np.concatenate([occlusion[None], np.zeros((n, n))]),
        bound=bound,
        rest=np.zeros(n + 1),
        row=np.zeros(n + 1, dtype=np.int64),
        costs_here=np.zeros(widest + 1),
        choices=np.zeros((n + 1, widest + 1), dtype=np.int64),
        cursor=np.zeros((n + 1, 2), dtype=np.int64),
        least=np.zeros((n + 1, n)),
        chosen=np.full(n, OPEN, dtype=np.int64),
        best=best,
        counters=np.array([0, 0, 1, 0], dtype=np.int64),
    )


def root_bound(search: Search) -> float:
    """Lower bound of every correspondence that the search may find, less rounding errors."""
    rows, costs, occlusion = search.rows, search.levels[0], search.occlusion[0]
    least = [
        min(occlusion[x], costs[rows[x] : rows[x + 1]].min(initial=np.inf))
        for x in range(len(occlusion))
    ]
    bound = float(search.bound[0] + np.sum(least))
    return bound - ROUNDING * abs(bound) if np.isfinite(bound) else bound


@kernel
def _halves(rows: IntArray, pairwise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Halves of the least pairwise costs between points.

    Returns
    -------
    halves, most
        (N, V) half the least pairwise cost of each candidate with each other point; (N, N) the
        largest of them over the candidates of x, with x'.
    """
    n = len(rows) - 1
    halves = np.zeros((n, len(pairwise)))
    most = np.zeros((n, n))
    for x in range(n):
        for a in range(rows[x], rows[x + 1]):
            row = pairwise[a]
            for other in range(n):
                if other == x:
                    continue
                least = minimum(row, rows[other], rows[other + 1])
                if np.isinf(least):
                    least = 0.0  # x' has no candidate left beside a: it can only be unmatched
                halves[other, a] = 0.5 * least
                most[x, other] = max(most[x, other], 0.5 * least)
    return halves, most


@kernel
def _changes(
    rows: IntArray, pairwise: FloatArray, halves: FloatArray, most: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Changes of the costs by a decision: V rows for candidates, then N for unmatched points.

    Between a decided point and an open one the exact pairwise cost replaces the halves that either
    counted, and those that were subtracted from an occlusion cost. It is infinite where candidates
    exclude one another.
    """
    n, count = len(rows) - 1, len(pairwise)
    changes, of_occlusion = np.empty((count + n, count)), np.empty((count + n, n))
    for x in range(n):
        shared, unmatched = halves[x], changes[count + x]
        for other in range(n):
            for b in range(rows[other], rows[other + 1]):
                unmatched[b] = most[other, x] - shared[b]
            of_occlusion[count + x, other] = most[x, other] + most[other, x]
        for a in range(rows[x], rows[x + 1]):
            costs, taken = pairwise[a], changes[a]
            for other in range(n):
                own = halves[other, a]
                of_occlusion[a, other] = most[x, other] - own
                for b in range(rows[other], rows[other + 1]):
                    taken[b] = costs[b] - shared[b] - own
    return changes, of_occlusion


@inlined
def minimum(values: FloatArray, first: int, last: int) -> float:
    """Least of some values, ``inf`` of none; in four chains, which processors run in parallel."""
    a, b, c, d = np.inf, np.inf, np.inf, np.inf
    i, end = np.uint64(first), np.uint64(last)
    while i + np.uint64(4) <= end:
        a, b = min(a, values[i]), min(b, values[i + np.uint64(1)])
        c, d = min(c, values[i + np.uint64(2)]), min(d, values[i + np.uint64(3)])
        i += np.uint64(4)
    while i < end:
        a = min(a, values[i])
        i += np.uint64(1)
    return min(min(a, b), min(c, d))


@inlined
def add(values: FloatArray, changes: FloatArray, first: int, last: int, sums: FloatArray) -> float:
    """Write some sums, and return the least of them; see `minimum`."""
    a, b, c, d = np.inf, np.inf, np.inf, np.inf
    i, end = np.uint64(first), np.uint64(last)
    one, two, three, four = np.uint64(1), np.uint64(2), np.uint64(3), np.uint64(4)
    while i + four <= end:
        p, q = values[i] + changes[i], values[i + one] + changes[i + one]
        r, s = values[i + two] + changes[i + two], values[i + three] + changes[i + three]
        sums[i], sums[i + one], sums[i + two], sums[i + three] = p, q, r, s
        a, b, c, d = min(a, p), min(b, q), min(c, r), min(d, s)
        i += four
    while i < end:
        p = values[i] + changes[i]
        sums[i] = p
        a = min(a, p)
        i += one
    return min(min(a, b), min(c, d))
