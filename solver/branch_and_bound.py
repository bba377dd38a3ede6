"""Exact optimum, and the m best solutions, of small labelling problems.

Depth-first search over the source points. The bound at a node lets every open source point choose
its target on its own: it pays its unary cost, its exact pairwise costs to the points decided
already, and *half* of the least pairwise cost it can have with each point still open (the other
half is paid by that point). Unmatched points complicate this: an open point that stays unmatched
pays no pairwise cost, so the halves that others have counted on are given back through its own
occlusion cost.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.kernel import kernel
from solver.labelling import UNMATCHED, LabellingProblem, pairwise_cost

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


def m_best_solutions(
    problem: LabellingProblem,
    m: int = 1,
    *,
    node_limit: int = 50_000_000,
    control: Control | None = None,
) -> ExactSolutions:
    """Enumerate the m solutions of least energy.

    Parameters
    ----------
    problem
        A small problem; time grows exponentially with its number of source points. Twelve are
        quick, sixteen usually are.
    m
        How many solutions.
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
    search = _Search.start(problem, m)
    done = False
    while not done and search.counters[_NODES] < node_limit and control.seconds_left() > 0.0:
        control.check()
        done = _advance(
            problem.source_distances,
            problem.target_distances,
            problem.beta,
            search.halves,
            search.most,
            search.levels,
            search.occlusion,
            search.energy,
            search.row,
            search.columns,
            search.cursor,
            search.used,
            search.partners,
            search.best_energies,
            search.best_partners,
            search.counters,
            _NODES_PER_CALL,
        )
    found = np.isfinite(search.best_energies)
    partners = search.best_partners[found]
    energies = np.array([problem.energy(row) for row in partners])
    order = np.argsort(energies, kind="stable")
    return ExactSolutions(partners[order], energies[order], done, int(search.counters[_NODES]))


_DEPTH, _NODES, _ENTERING = 0, 1, 2


@dataclass(frozen=True, eq=False)
class _Search:
    """State of the depth-first search, all in arrays, so that it can stop and go on."""

    halves: FloatArray  # (N, M, N): half the least pairwise cost of (x, y) with open point x'
    most: FloatArray  # (N, N): the largest half that x counts on from x'
    levels: FloatArray  # (N+1, N, M): cost of (x, y) given the decisions made at each depth
    occlusion: FloatArray  # (N+1, N): cost of leaving x unmatched, likewise
    energy: FloatArray  # (N+1,) energy of the decided points
    row: IntArray  # (N+1,) source point decided at each depth
    columns: IntArray  # (N+1, M+1) its choices, cheapest first
    cursor: IntArray  # (N+1, 2) next choice, and number of choices
    used: BoolArray  # (M,)
    partners: IntArray  # (N,) UNMATCHED or a target; -2 while open
    best_energies: FloatArray  # (m,)
    best_partners: IntArray  # (m, N)
    counters: IntArray  # depth, nodes, whether the node at this depth is new

    @classmethod
    def start(cls, problem: LabellingProblem, m: int) -> "_Search":
        n, k = problem.shape
        halves, most, levels, occlusion = _root_costs(
            problem.source_distances,
            problem.target_distances,
            problem.beta,
            problem.unary_matrix,
            problem.occlusion_cost,
        )
        return cls(
            halves=halves,
            most=most,
            levels=np.concatenate([levels[None], np.zeros((n, n, k))]),
            occlusion=np.concatenate([occlusion[None], np.zeros((n, n))]),
            energy=np.zeros(n + 1),
            row=np.zeros(n + 1, dtype=np.int64),
            columns=np.zeros((n + 1, k + 1), dtype=np.int64),
            cursor=np.zeros((n + 1, 2), dtype=np.int64),
            used=np.zeros(k, dtype=np.bool_),
            partners=np.full(n, _OPEN, dtype=np.int64),
            best_energies=np.full(m, np.inf),
            best_partners=np.full((m, n), UNMATCHED, dtype=np.int64),
            counters=np.array([0, 0, 1], dtype=np.int64),
        )


_OPEN = -2


@kernel
def _root_costs(
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    unary: FloatArray,
    occlusion_cost: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    n, k = unary.shape
    halves = np.zeros((n, k, n))
    most = np.zeros((n, n))
    for x in range(n):
        for y in range(k):
            if np.isinf(unary[x, y]):
                continue
            for other in range(n):
                if other == x:
                    continue
                least = np.inf
                for z in range(k):
                    if z != y and np.isfinite(unary[other, z]):
                        cost = pairwise_cost(
                            beta, source_distances[x, other], target_distances[y, z]
                        )
                        least = min(least, cost)
                if np.isinf(least):
                    least = 0.0  # x' has no target left beside y: it can only be unmatched
                halves[x, y, other] = 0.5 * least
                most[x, other] = max(most[x, other], 0.5 * least)
    costs = unary.copy()
    occlusion = np.full(n, float(occlusion_cost))
    for x in range(n):
        for other in range(n):
            for y in range(k):
                costs[x, y] += halves[x, y, other]
            occlusion[x] -= most[other, x]
    return halves, most, costs, occlusion


@kernel
def _advance(
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    halves: FloatArray,
    most: FloatArray,
    levels: FloatArray,
    occlusion: FloatArray,
    energy: FloatArray,
    row: IntArray,
    columns: IntArray,
    cursor: IntArray,
    used: BoolArray,
    partners: IntArray,
    best_energies: FloatArray,
    best_partners: IntArray,
    counters: IntArray,
    max_nodes: int,
) -> bool:
    """Visit up to `max_nodes` more nodes; return whether the search is finished."""
    n = len(partners)
    m = len(best_energies)
    depth = counters[_DEPTH]
    for _ in range(max_nodes):
        if counters[_ENTERING] == 1:
            counters[_NODES] += 1
            counters[_ENTERING] = 0
            if depth == n:
                _keep(best_energies, best_partners, energy[n], partners)
                cursor[depth, 0] = 0
                cursor[depth, 1] = 0
            else:
                _expand(
                    depth, levels, occlusion, energy, row, columns, cursor, used, partners,
                    best_energies[m - 1],
                )  # fmt: skip
        if cursor[depth, 0] >= cursor[depth, 1]:
            if depth == 0:
                return True
            depth -= 1
            x = row[depth]
            if partners[x] >= 0:
                used[partners[x]] = False
            partners[x] = _OPEN
            counters[_DEPTH] = depth
            continue
        y = columns[depth, cursor[depth, 0]]
        cursor[depth, 0] += 1
        _descend(
            depth, row[depth], y, source_distances, target_distances, beta, halves, most,
            levels, occlusion, energy, used, partners,
        )  # fmt: skip
        depth += 1
        counters[_DEPTH] = depth
        counters[_ENTERING] = 1
    return False


@kernel
def _keep(
    best_energies: FloatArray, best_partners: IntArray, energy: float, partners: IntArray
) -> None:
    """Insert a solution into the sorted list of the best, if it belongs there."""
    m = len(best_energies)
    if energy >= best_energies[m - 1]:
        return
    place = m - 1
    while place > 0 and best_energies[place - 1] > energy:
        best_energies[place] = best_energies[place - 1]
        best_partners[place] = best_partners[place - 1]
        place -= 1
    best_energies[place] = energy
    best_partners[place] = partners


@kernel
def _expand(
    depth: int,
    levels: FloatArray,
    occlusion: FloatArray,
    energy: FloatArray,
    row: IntArray,
    columns: IntArray,
    cursor: IntArray,
    used: BoolArray,
    partners: IntArray,
    worst_kept: float,
) -> None:
    """Bound the node; unless it can be pruned, choose its source point and order the choices.

    The point chosen is the one whose second-best choice costs most over its best, so that wrong
    decisions are refuted early.
    """
    n, k = levels.shape[1], levels.shape[2]
    costs = levels[depth]
    bound = energy[depth]
    widest = -1.0
    chosen = -1
    for x in range(n):
        if partners[x] != _OPEN:
            continue
        best = occlusion[depth, x]
        second = np.inf
        for y in range(k):
            if not used[y]:
                cost = costs[x, y]
                if cost < best:
                    second = best
                    best = cost
                elif cost < second:
                    second = cost
        bound += best
        regret = second - best if np.isfinite(best) else np.inf
        if regret > widest:
            widest = regret
            chosen = x
    cursor[depth, 0] = 0
    cursor[depth, 1] = 0
    row[depth] = chosen
    slack = 1e-12 * (1.0 + abs(worst_kept)) if np.isfinite(worst_kept) else 0.0
    if not bound < worst_kept - slack:
        return
    choices = np.empty(k + 1)
    least = occlusion[depth, chosen]
    choices[k] = occlusion[depth, chosen]
    for y in range(k):
        choices[y] = np.inf if used[y] else costs[chosen, y]
        least = min(least, choices[y])
    order = np.argsort(choices)
    count = 0
    for place in range(k + 1):
        y = order[place]
        if not bound - least + choices[y] < worst_kept - slack:
            break
        columns[depth, count] = UNMATCHED if y == k else y
        count += 1
    cursor[depth, 1] = count


@kernel
def _descend(
    depth: int,
    x: int,
    y: int,
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    halves: FloatArray,
    most: FloatArray,
    levels: FloatArray,
    occlusion: FloatArray,
    energy: FloatArray,
    used: BoolArray,
    partners: IntArray,
) -> None:
    """Decide x → y and write the open points' costs given that decision."""
    n, k = levels.shape[1], levels.shape[2]
    partners[x] = y
    if y >= 0:
        used[y] = True
        energy[depth + 1] = energy[depth] + levels[depth, x, y]
    else:
        energy[depth + 1] = energy[depth] + occlusion[depth, x]
    for other in range(n):
        if partners[other] != _OPEN:
            continue
        # Nothing is left to share between x and this point: what either counted on from the
        # other, and what an unmatched one gave back, is replaced by the exact cost.
        settled = -halves[x, y, other] if y >= 0 else most[other, x]
        for z in range(k):
            cost = levels[depth, other, z] - halves[other, z, x] + settled
            if y >= 0:
                cost += pairwise_cost(beta, source_distances[x, other], target_distances[y, z])
            levels[depth + 1, other, z] = cost
        occlusion[depth + 1, other] = occlusion[depth, other] + most[x, other] + settled
