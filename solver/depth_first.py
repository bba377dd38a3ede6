"""Depth-first search over the source points of a small labelling problem.

The bound at a node lets every open source point choose its candidate on its own: it pays its unary
cost, its exact pairwise costs to the points decided already, and *half* of the least pairwise cost
it can have with each point still open (the other half is paid by that point). Unmatched points
complicate this: an open point that stays unmatched pays no pairwise cost, so the halves that others
have counted on are given back through its own occlusion cost.
"""

from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.bounding_costs import BoundingCosts
from solver.incumbents import Incumbents, energy_of, keep
from solver.kernel import inlined, kernel
from solver.labelling import UNMATCHED

_DEPTH, NODES, _ENTERING = 0, 1, 2
_OPEN = -2
_ROUNDING = 1e-12
"""What rounding errors may have added to a bound, relative to it."""


class Search(NamedTuple):
    """State of the depth-first search, all in arrays, so that it can stop and go on."""

    rows: IntArray  # (N+1,) candidates of source point x are rows[x] .. rows[x+1]
    own_unary: FloatArray  # (W,) costs of the problem itself, of all its candidates
    own_pairwise: FloatArray  # (W, W)
    own_occlusion: FloatArray  # (N,)
    kept: IntArray  # (V,) those candidates that are searched
    changes: FloatArray  # (V+N, V): what candidates' costs change by with each decision
    occlusion_changes: FloatArray  # (V+N, N): likewise of the costs of leaving points unmatched
    levels: FloatArray  # (N+1, V): cost of each candidate given the decisions at each depth
    occlusion: FloatArray  # (N+1, N): cost of leaving x unmatched, likewise
    bound: FloatArray  # (N+1,) cost of the decided points
    rest: FloatArray  # (N+1,) least costs of the open points, together
    row: IntArray  # (N+1,) source point decided at each depth
    offers: FloatArray  # (K+1,) costs of the choices at the node being looked at
    choices: IntArray  # (N+1, K+1) its choices, cheapest first
    cursor: IntArray  # (N+1, 2) next choice, and number of choices
    least: FloatArray  # (N+1, N) least cost of each open point at each depth
    chosen: IntArray  # (N,) candidate of each source point, UNMATCHED, or _OPEN
    best: Incumbents
    counters: IntArray  # depth, nodes, whether the node at this depth is new


def start_search(
    own: BoundingCosts, bounding: BoundingCosts, points: IntArray, kept: IntArray, best: Incumbents
) -> Search:
    """Return a search that has not begun.

    Parameters
    ----------
    own
        Costs of the problem.
    bounding
        Costs to prune with, of the candidates kept.
    points
        (V,) source point of each of these, ascending.
    kept
        (V,) candidates of the problem that are searched, ascending.
    best
        The best correspondences known; improved in place.
    """
    n, v = len(own.occlusion), len(kept)
    rows = np.searchsorted(points, np.arange(n + 1)).astype(np.int64)
    halves, most = _halves(rows, bounding.pairwise)
    changes, occlusion_changes = _changes(points, bounding.pairwise, halves, most)
    unary = bounding.unary + halves.sum(axis=0)
    occlusion = bounding.occlusion - most.sum(axis=0)
    widest = int(np.diff(rows).max(initial=0))
    bound = np.zeros(n + 1)
    bound[0] = bounding.constant
    return Search(
        rows=rows,
        own_unary=own.unary,
        own_pairwise=own.pairwise,
        own_occlusion=own.occlusion,
        kept=kept,
        changes=changes,
        occlusion_changes=occlusion_changes,
        levels=np.concatenate([unary[None], np.zeros((n, v))]),
        occlusion=np.concatenate([occlusion[None], np.zeros((n, n))]),
        bound=bound,
        rest=np.zeros(n + 1),
        row=np.zeros(n + 1, dtype=np.int64),
        offers=np.zeros(widest + 1),
        choices=np.zeros((n + 1, widest + 1), dtype=np.int64),
        cursor=np.zeros((n + 1, 2), dtype=np.int64),
        least=np.zeros((n + 1, n)),
        chosen=np.full(n, _OPEN, dtype=np.int64),
        best=best,
        counters=np.array([0, 0, 1], dtype=np.int64),
    )


def root_bound(search: Search) -> float:
    """What every correspondence costs at least that the search may find, less rounding errors."""
    rows, costs, occlusion = search.rows, search.levels[0], search.occlusion[0]
    least = [
        min(occlusion[x], costs[rows[x] : rows[x + 1]].min(initial=np.inf))
        for x in range(len(occlusion))
    ]
    bound = float(search.bound[0] + np.sum(least))
    return bound - _ROUNDING * abs(bound) if np.isfinite(bound) else bound


@kernel
def _halves(rows: IntArray, pairwise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What points count on from one another.

    Returns
    -------
    halves, most
        (N, V) half the least pairwise cost of each candidate with each other point; (N, N) the
        largest of them that x counts on from x'.
    """
    n = len(rows) - 1
    halves = np.zeros((n, len(pairwise)))
    most = np.zeros((n, n))
    for x in range(n):
        for a in range(rows[x], rows[x + 1]):
            for other in range(n):
                if other == x:
                    continue
                least = np.inf
                for b in range(rows[other], rows[other + 1]):
                    least = min(least, pairwise[a, b])
                if np.isinf(least):
                    least = 0.0  # x' has no candidate left beside a: it can only be unmatched
                halves[other, a] = 0.5 * least
                most[x, other] = max(most[x, other], 0.5 * least)
    return halves, most


def _changes(
    x: IntArray, pairwise: FloatArray, halves: FloatArray, most: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What a decision changes: the first V rows for each candidate, then for each point unmatched.

    Nothing is left to share between a decided point and an open one: what either counted on from
    the other, and what an unmatched one gave back, is replaced by the exact cost. It is infinite
    where candidates exclude one another.
    """
    taken = pairwise - halves[x] - halves[x].T
    unmatched = -halves + most.T[:, x]
    of_occlusion = most[x] - halves.T
    return np.concatenate([taken, unmatched]), np.concatenate([of_occlusion, most + most.T])


@kernel
def advance(s: Search, max_nodes: int) -> bool:
    """Visit up to `max_nodes` more nodes; return whether the search is finished."""
    n = len(s.chosen)
    depth = s.counters[_DEPTH]
    for _ in range(max_nodes):
        if s.counters[_ENTERING] == 1:
            s.counters[NODES] += 1
            s.counters[_ENTERING] = 0
            if depth == n:
                _keep(s)
                s.cursor[depth, 0] = 0
                s.cursor[depth, 1] = 0
            else:
                _expand(s, depth)
        if s.cursor[depth, 0] >= s.cursor[depth, 1]:
            if depth == 0:
                return True
            depth -= 1
            s.chosen[s.row[depth]] = _OPEN
            s.counters[_DEPTH] = depth
            continue
        a = s.choices[depth, s.cursor[depth, 0]]
        s.cursor[depth, 0] += 1
        _descend(s, depth, a)
        depth += 1
        s.counters[_DEPTH] = depth
        s.counters[_ENTERING] = 1
    return False


@kernel
def _keep(s: Search) -> None:
    """Keep the correspondence that is decided, in the problem's own candidates."""
    chosen = np.empty(len(s.chosen), dtype=np.int64)
    for x in range(len(chosen)):
        chosen[x] = s.kept[s.chosen[x]] if s.chosen[x] >= 0 else UNMATCHED
    keep(s.best, energy_of(s.own_unary, s.own_pairwise, s.own_occlusion, chosen), chosen)


@inlined
def _expand(s: Search, depth: int) -> None:
    """Bound the node; unless it can be pruned, choose its source point and order the choices."""
    s.cursor[depth, 0] = 0
    s.cursor[depth, 1] = 0
    worst = s.best.energies[len(s.best.energies) - 1]
    limit = worst - _ROUNDING * (1.0 + abs(worst)) if np.isfinite(worst) else np.inf
    if depth == 0:
        for x in range(len(s.chosen)):
            least = _minimum(s.levels[0], s.rows[x], s.rows[x + 1])
            s.least[0, x] = min(s.occlusion[0, x], least)
        s.rest[0] = s.least[0].sum()
        if not s.bound[0] + s.rest[0] < limit:
            return
    elif not _update(s, depth, limit):
        return
    margin = limit - s.bound[depth] - s.rest[depth]
    costs, occlusion, leasts = s.levels[depth], s.occlusion[depth], s.least[depth]
    x = _tightest(s.chosen, s.rows, leasts, costs, occlusion, margin)
    s.row[depth] = x
    s.cursor[depth, 1] = _order_choices(s, depth, x, leasts[x] + margin)


@inlined
def _update(s: Search, depth: int, limit: float) -> bool:
    """Write the open points' costs given the last decision, while the bound is below a limit.

    No cost falls with a decision, so what the points still to be looked at cost at least is what
    they did before it.
    """
    x = s.row[depth - 1]
    a = s.chosen[x] if s.chosen[x] >= 0 else len(s.kept) + x
    rows, occlusion, least = s.rows, s.occlusion[depth], s.least[depth]
    before, after, changes = s.levels[depth - 1], s.levels[depth], s.changes[a]
    occlusion_before, of_occlusion = s.occlusion[depth - 1], s.occlusion_changes[a]
    least_before, chosen = s.least[depth - 1], s.chosen
    bound, rest = s.bound[depth], s.rest[depth - 1] - least_before[x]
    total = 0.0
    for other in range(len(chosen)):
        if chosen[other] != _OPEN:
            continue
        first, last = rows[other], rows[other + 1]
        for b in range(first, last):
            after[b] = before[b] + changes[b]
        occlusion[other] = occlusion_before[other] + of_occlusion[other]
        least[other] = min(occlusion[other], _minimum(after, first, last))
        total += least[other]
        rest -= least_before[other]
        if not bound + total + rest < limit:
            return False
    s.rest[depth] = total
    below: bool = bound + total < limit
    return below


@inlined
def _minimum(values: FloatArray, first: int, last: int) -> float:
    """Least of some values, ``inf`` of none; four at a time, as each waits for the one before."""
    a, b, c, d = np.inf, np.inf, np.inf, np.inf
    i = first
    while i + 4 <= last:
        a, b = min(a, values[i]), min(b, values[i + 1])
        c, d = min(c, values[i + 2]), min(d, values[i + 3])
        i += 4
    while i < last:
        a = min(a, values[i])
        i += 1
    return min(min(a, b), min(c, d))


@kernel
def _tightest(
    chosen: IntArray,
    rows: IntArray,
    least: FloatArray,
    costs: FloatArray,
    occlusion: FloatArray,
    margin: float,
) -> int:
    """Open point with the fewest choices left, each counted by how much of the margin it leaves."""
    x, fewest = -1, np.inf
    for other in range(len(chosen)):
        if chosen[other] != _OPEN:
            continue
        limit = least[other] + margin
        count = max(limit - occlusion[other], 0.0)
        for a in range(rows[other], rows[other + 1]):
            if costs[a] < limit:
                count += limit - costs[a]
        if x < 0 or count < fewest:
            x, fewest = other, count
    return x


@inlined
def _order_choices(s: Search, depth: int, x: int, limit: float) -> int:
    """Write the choices of point x that cost less than a limit, cheapest first; return how many."""
    first, count = s.rows[x], s.rows[x + 1] - s.rows[x]
    costs, offers, choices = s.levels[depth], s.offers, s.choices[depth]
    offers[count] = s.occlusion[depth, x]
    for i in range(count):
        offers[i] = costs[first + i]
    kept = 0
    for i in range(count + 1):
        if not offers[i] < limit:
            continue
        place = kept
        while place > 0 and offers[choices[place - 1]] > offers[i]:
            choices[place] = choices[place - 1]
            place -= 1
        choices[place] = i
        kept += 1
    for i in range(kept):
        choices[i] = UNMATCHED if choices[i] == count else first + choices[i]
    return kept


@inlined
def _descend(s: Search, depth: int, a: int) -> None:
    """Give the point of this depth candidate a."""
    x = s.row[depth]
    s.chosen[x] = a
    cost = s.levels[depth, a] if a >= 0 else s.occlusion[depth, x]
    s.bound[depth + 1] = s.bound[depth] + cost
