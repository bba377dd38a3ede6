"""Depth-first search over the source points of a small labelling problem.

At each node the open source point with the fewest choices left is decided, cheapest choice first,
unless no completion can be among the best: see :mod:`solver.optimisation.exact.search_state` for
the lower bound.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.labelling import UNMATCHED, triple_cost
from solver.optimisation.exact.incumbents import OPEN, energy_of, keep
from solver.optimisation.exact.search_state import (
    DEPTH,
    ENTERING,
    FINISHED,
    NODES,
    Search,
    add,
    minimum,
)
from solver.optimisation.rounding import allowance

NODES_PER_STEP = 20_000
"""Nodes between two looks at the deadline: some 10 to 20 ms, longer with triples."""


class DepthFirstSearch:
    """Depth-first search as an iterative method: each step visits some more nodes.

    Parameters
    ----------
    search
        The search, which has not begun; changed in place.
    nodes
        Nodes of a step.
    """

    def __init__(self, search: Search, nodes: int) -> None:
        self._search, self._nodes = search, nodes

    def init(self) -> Search:
        """Return the search."""
        return self._search

    def step(self, state: Search) -> Search:
        """Visit some more nodes."""
        _advance(state, self._nodes)
        return state

    def done(self, state: Search) -> bool:
        """Return whether the search was exhaustive."""
        return bool(state.counters[FINISHED])


@kernel
def _advance(s: Search, max_nodes: int) -> None:
    """Visit up to `max_nodes` more nodes."""
    n = len(s.chosen)
    depth = s.counters[DEPTH]
    limit = s.counters[NODES] + max_nodes
    while True:
        if s.counters[ENTERING] == 1:
            if s.counters[NODES] == limit:
                return
            s.counters[NODES] += 1
            s.counters[ENTERING] = 0
            if depth == n:
                _keep(s)
                s.cursor[depth, 0] = 0
                s.cursor[depth, 1] = 0
            else:
                _expand(s, depth)
        if s.cursor[depth, 0] >= s.cursor[depth, 1]:
            if depth == 0:
                s.counters[FINISHED] = 1
                return
            depth -= 1
            s.chosen[s.row[depth]] = OPEN
            s.counters[DEPTH] = depth
            continue
        a = s.choices[depth, s.cursor[depth, 0]]
        s.cursor[depth, 0] += 1
        _descend(s, depth, a)
        depth += 1
        s.counters[DEPTH] = depth
        s.counters[ENTERING] = 1


@kernel
def _keep(s: Search) -> None:
    """Keep the complete correspondence, in the numbering of all candidates of the problem."""
    chosen = np.empty(len(s.chosen), dtype=np.int64)
    for x in range(len(chosen)):
        chosen[x] = s.kept[s.chosen[x]] if s.chosen[x] >= 0 else UNMATCHED
    keep(s.best, energy_of(s.own, chosen), chosen)


@inlined
def _expand(s: Search, depth: int) -> None:
    """Bound the node; unless it can be pruned, choose its source point and order the choices."""
    s.cursor[depth, 0] = 0
    s.cursor[depth, 1] = 0
    worst = s.best.energies[len(s.best.energies) - 1]
    limit = worst - allowance(worst, s.scale) if np.isfinite(worst) else np.inf
    if depth == 0:
        for x in range(len(s.chosen)):
            least = minimum(s.levels[0], s.rows[x], s.rows[x + 1])
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

    No cost falls with a decision, so the least costs before it bound those of the points whose
    costs have not been written yet.
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
        if chosen[other] != OPEN:
            continue
        occlusion[other] = occlusion_before[other] + of_occlusion[other]
        cheapest = add(before, changes, rows[other], rows[other + 1], after)
        least[other] = min(occlusion[other], cheapest)
        total += least[other]
        rest -= least_before[other]
        if not bound + total + rest < limit:
            return False
    if len(s.triples.points):
        total += _complete_triples(s, depth, x)
    s.rest[depth] = total
    below: bool = bound + total < limit
    return below


@kernel
def _complete_triples(s: Search, depth: int, x: int) -> float:
    """Add costs of the triples of which x was the second point decided; return the bound's rise."""
    triples, costs = s.triples, s.levels[depth]
    rise = 0.0
    for k in range(triples.containing.shape[1]):
        t = triples.containing[x, k]
        if t < 0:
            break
        for place in range(3):
            y = triples.points[t, place]
            if s.chosen[y] != OPEN:
                continue
            for b in range(s.rows[y], s.rows[y + 1]):
                costs[b] += triple_cost(triples, t, s.chosen, y, b, y, b)
            least = min(s.occlusion[depth, y], minimum(costs, s.rows[y], s.rows[y + 1]))
            rise += least - s.least[depth, y]
            s.least[depth, y] = least
    return rise


@kernel
def _tightest(
    chosen: IntArray,
    rows: IntArray,
    least: FloatArray,
    costs: FloatArray,
    occlusion: FloatArray,
    margin: float,
) -> int:
    """Open point with the fewest choices left, each weighted by the margin that it leaves."""
    x, fewest = -1, np.inf
    for other in range(len(chosen)):
        if chosen[other] != OPEN:
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
    costs, costs_here, choices = s.levels[depth], s.costs_here, s.choices[depth]
    costs_here[count] = s.occlusion[depth, x]
    for i in range(count):
        costs_here[i] = costs[first + i]
    kept = 0
    for i in range(count + 1):
        if not costs_here[i] < limit:
            continue
        place = kept
        while place > 0 and costs_here[choices[place - 1]] > costs_here[i]:
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
