"""Exact optimum, and the m best solutions, of small labelling problems.

Depth-first search over the source points. The bound at a node lets every open source point choose
its candidate on its own: it pays its unary cost, its exact pairwise costs to the points decided
already, and *half* of the least pairwise cost it can have with each point still open (the other
half is paid by that point). Unmatched points complicate this: an open point that stays unmatched
pays no pairwise cost, so the halves that others have counted on are given back through its own
occlusion cost.

The costs that bound need not be those of the problem: a dual decomposition turns them into costs of
the same solutions whose greater part is a constant, and with these the search prunes much earlier.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.kernel import kernel
from solver.labelling import UNMATCHED, LabellingProblem
from solver.primal import partners_of

_NODES_PER_CALL = 20_000


@dataclass(frozen=True, eq=False)
class ExactSolutions:
    """The best solutions of a labelling problem.

    Parameters
    ----------
    partners
        (m, N) target point of each source point, `UNMATCHED` for none; best first. Fewer rows
        than asked for when the problem has fewer solutions.
    energies
        (m,) their energies, ascending.
    proven
        Whether the search was exhaustive: no solution outside the list is better than its last.
    nodes
        Search nodes visited.
    """

    partners: IntArray
    energies: FloatArray
    proven: bool
    nodes: int


@dataclass(frozen=True, eq=False)
class BoundingCosts:
    """Costs that add up to no more than the energy, for every correspondence of a problem.

    Parameters
    ----------
    constant
        What every correspondence costs.
    unary
        (V,) cost of each candidate.
    pairwise
        (V, V) symmetric cost of every two candidates, ``inf`` where they exclude one another.
    occlusion
        (N,) cost of leaving each source point unmatched, ``inf`` where that is forbidden.
    """

    constant: float
    unary: FloatArray
    pairwise: FloatArray
    occlusion: FloatArray

    @classmethod
    def of(cls, problem: LabellingProblem) -> "BoundingCosts":
        """Return the problem's own costs."""
        occlusion = np.full(problem.n_sources, float(problem.occlusion_cost))
        return cls(0.0, problem.unary, problem.pairwise_matrix(), occlusion)


def m_best_solutions(
    problem: LabellingProblem,
    m: int = 1,
    *,
    known: IntArray | None = None,
    bounding: BoundingCosts | None = None,
    node_limit: int = 50_000_000,
    control: Control | None = None,
) -> ExactSolutions:
    """Enumerate the m solutions of least energy.

    Parameters
    ----------
    problem
        A small problem; time grows exponentially with its number of source points. Twelve are
        quick, sixteen usually are. Memory is 8 bytes times the square of its number of
        candidates, or twice that with `bounding`.
    m
        How many solutions.
    known
        (N,) a correspondence of the problem; nothing worse is looked at when m is 1.
    bounding
        Costs to prune with; by default the problem's own.
    node_limit
        Search nodes after which the search gives up; the best found are then returned with
        ``proven`` false.
    control
        Cancels the search, or ends it at a deadline as the node limit does.

    Returns
    -------
    ExactSolutions

    Raises
    ------
    Cancelled
        Through `control`.
    ValueError
        `m` is not positive.
    """
    if m < 1:
        raise ValueError("m must be at least 1")
    control = control or Control()
    own = BoundingCosts.of(problem)
    state = _start(problem, own, bounding or own, m)
    if known is not None:
        state.best_chosen[0] = problem.chosen_candidates(known)
        state.best_energies[0] = problem.energy(known)
    done = False
    while not done and state.counters[_NODES] < node_limit and control.seconds_left() > 0.0:
        control.check()
        done = _advance(state, _NODES_PER_CALL)
    found = np.isfinite(state.best_energies)
    partners = np.stack([partners_of(problem, row) for row in state.best_chosen])[found]
    energies = np.array([problem.energy(row) for row in partners])
    order = np.argsort(energies, kind="stable")
    return ExactSolutions(partners[order], energies[order], done, int(state.counters[_NODES]))


_DEPTH, _NODES, _ENTERING = 0, 1, 2
_OPEN = -2


class _Search(NamedTuple):
    """State of the depth-first search, all in arrays, so that it can stop and go on."""

    rows: IntArray  # (N+1,) candidates of source point x are rows[x] .. rows[x+1]
    own_unary: FloatArray  # (V,) costs of the problem itself
    own_pairwise: FloatArray  # (V, V)
    own_occlusion: FloatArray  # (N,)
    changes: FloatArray  # (V+N, V): what candidates' costs change by with each decision
    occlusion_changes: FloatArray  # (V+N, N): likewise of the costs of leaving points unmatched
    levels: FloatArray  # (N+1, V): cost of each candidate given the decisions at each depth
    occlusion: FloatArray  # (N+1, N): cost of leaving x unmatched, likewise
    bound: FloatArray  # (N+1,) cost of the decided points
    row: IntArray  # (N+1,) source point decided at each depth
    offers: FloatArray  # (K+1,) costs of the choices at the node being looked at
    choices: IntArray  # (N+1, K+1) its choices, cheapest first
    cursor: IntArray  # (N+1, 2) next choice, and number of choices
    least: FloatArray  # (N,) least cost of each open point
    chosen: IntArray  # (N,) candidate of each source point, UNMATCHED, or _OPEN
    best_energies: FloatArray  # (m,)
    best_chosen: IntArray  # (m, N)
    counters: IntArray  # depth, nodes, whether the node at this depth is new


def _start(
    problem: LabellingProblem, own: BoundingCosts, bounding: BoundingCosts, m: int
) -> _Search:
    n, v = problem.n_sources, problem.n_candidates
    rows = problem.first_candidate
    halves, most = _halves(rows, bounding.pairwise)
    changes, occlusion_changes = _changes(problem, bounding.pairwise, halves, most)
    unary = bounding.unary + halves.sum(axis=0)
    occlusion = bounding.occlusion - most.sum(axis=0)
    widest = int(np.diff(rows).max(initial=0))
    bound = np.zeros(n + 1)
    bound[0] = bounding.constant
    return _Search(
        rows=rows,
        own_unary=own.unary,
        own_pairwise=own.pairwise,
        own_occlusion=own.occlusion,
        changes=changes,
        occlusion_changes=occlusion_changes,
        levels=np.concatenate([unary[None], np.zeros((n, v))]),
        occlusion=np.concatenate([occlusion[None], np.zeros((n, n))]),
        bound=bound,
        row=np.zeros(n + 1, dtype=np.int64),
        offers=np.zeros(widest + 1),
        choices=np.zeros((n + 1, widest + 1), dtype=np.int64),
        cursor=np.zeros((n + 1, 2), dtype=np.int64),
        least=np.zeros(n),
        chosen=np.full(n, _OPEN, dtype=np.int64),
        best_energies=np.full(m, np.inf),
        best_chosen=np.full((m, n), UNMATCHED, dtype=np.int64),
        counters=np.array([0, 0, 1], dtype=np.int64),
    )


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
    problem: LabellingProblem, pairwise: FloatArray, halves: FloatArray, most: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What a decision changes: the first V rows for each candidate, then for each point unmatched.

    Nothing is left to share between a decided point and an open one: what either counted on from
    the other, and what an unmatched one gave back, is replaced by the exact cost. It is infinite
    where candidates exclude one another.
    """
    x = problem.candidates[:, 0]
    taken = pairwise - halves[x] - halves[x].T
    unmatched = -halves + most.T[:, x]
    of_occlusion = most[x] - halves.T
    return np.concatenate([taken, unmatched]), np.concatenate([of_occlusion, most + most.T])


@kernel
def _advance(s: _Search, max_nodes: int) -> bool:
    """Visit up to `max_nodes` more nodes; return whether the search is finished."""
    n = len(s.chosen)
    depth = s.counters[_DEPTH]
    for _ in range(max_nodes):
        if s.counters[_ENTERING] == 1:
            s.counters[_NODES] += 1
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
def _energy(s: _Search) -> float:
    """Energy of the correspondence decided, by the problem's own costs."""
    chosen, own_occlusion = s.chosen, s.own_occlusion
    own_unary, own_pairwise = s.own_unary, s.own_pairwise
    energy = 0.0
    n = len(chosen)
    for x in range(n):
        a = chosen[x]
        if a < 0:
            energy += own_occlusion[x]
            continue
        energy += own_unary[a]
        for other in range(x):
            b = chosen[other]
            if b >= 0:
                energy += own_pairwise[a, b]
    return energy


@kernel
def _keep(s: _Search) -> None:
    """Insert a solution into the sorted list of the best, if it belongs there."""
    energy = _energy(s)
    m = len(s.best_energies)
    if energy >= s.best_energies[m - 1]:
        return
    for k in range(m):
        if s.best_energies[k] < np.inf and (s.best_chosen[k] == s.chosen).all():
            return  # the one known beforehand
    place = m - 1
    while place > 0 and s.best_energies[place - 1] > energy:
        s.best_energies[place] = s.best_energies[place - 1]
        s.best_chosen[place] = s.best_chosen[place - 1]
        place -= 1
    s.best_energies[place] = energy
    s.best_chosen[place] = s.chosen


@kernel
def _expand(s: _Search, depth: int) -> None:
    """Bound the node; unless it can be pruned, choose its source point and order the choices."""
    chosen, rows, least = s.chosen, s.rows, s.least
    costs, occlusion = s.levels[depth], s.occlusion[depth]
    bound = s.bound[depth]
    for x in range(len(chosen)):
        if chosen[x] == _OPEN:
            best = occlusion[x]
            for a in range(rows[x], rows[x + 1]):
                best = min(best, costs[a])
            least[x] = best
            bound += best
    s.cursor[depth, 0] = 0
    s.cursor[depth, 1] = 0
    worst_kept = s.best_energies[len(s.best_energies) - 1]
    slack = 1e-12 * (1.0 + abs(worst_kept)) if np.isfinite(worst_kept) else 0.0
    if not bound < worst_kept - slack:
        return
    margin = worst_kept - slack - bound
    x = _tightest(chosen, rows, least, costs, occlusion, margin)
    s.row[depth] = x
    s.cursor[depth, 1] = _order_choices(s, depth, x, least[x] + margin)


@kernel
def _tightest(
    chosen: IntArray,
    rows: IntArray,
    least: FloatArray,
    costs: FloatArray,
    occlusion: FloatArray,
    margin: float,
) -> int:
    """Open point with the fewest choices left; of these, where they cost most on average."""
    x, fewest, dearest = -1, len(costs) + 2, -np.inf
    for other in range(len(chosen)):
        if chosen[other] != _OPEN:
            continue
        limit = least[other] + margin
        count = 1 if occlusion[other] < limit else 0
        total = 0.0
        for a in range(rows[other], rows[other + 1]):
            if costs[a] < limit:
                count += 1
                total += costs[a] - least[other]
        if count < fewest or (count == fewest and total > dearest):
            x, fewest, dearest = other, count, total
    return x


@kernel
def _order_choices(s: _Search, depth: int, x: int, limit: float) -> int:
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


@kernel
def _descend(s: _Search, depth: int, a: int) -> None:
    """Give the point of this depth candidate a, and write the open points' costs given that."""
    x = s.row[depth]
    s.chosen[x] = a
    if a >= 0:
        s.bound[depth + 1] = s.bound[depth] + s.levels[depth, a]
        changes, of_occlusion = s.changes[a], s.occlusion_changes[a]
    else:
        s.bound[depth + 1] = s.bound[depth] + s.occlusion[depth, x]
        changes = s.changes[len(s.own_unary) + x]
        of_occlusion = s.occlusion_changes[len(s.own_unary) + x]
    # Points decided already are changed as well, which is faster than to leave them out.
    before, after = s.levels[depth], s.levels[depth + 1]
    for b in range(len(before)):
        after[b] = before[b] + changes[b]
    occlusion_before, occlusion_after = s.occlusion[depth], s.occlusion[depth + 1]
    for other in range(len(occlusion_before)):
        occlusion_after[other] = occlusion_before[other] + of_occlusion[other]
