"""Local search for the labelling problem (5), without a bound."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import (
    UNMATCHED,
    LabellingProblem,
    PairwiseCosts,
    TripleCosts,
    cost_given_third,
    distortion_cost,
    listed_cost,
    replace_costs,
    replace_triple_costs,
)
from solver.optimisation.rounding import allowance

_MAX_PASSES = 1000
"""Bound on the rounds of a local search over all source points."""


def local_search(problem: LabellingProblem, partners: IntArray) -> IntArray:
    """Improve a correspondence until no move of one or two points lowers its energy.

    A source point moves to another candidate; when that target point is taken, the point that
    had it moves to a free candidate of its own, to the target point just left (a swap), or
    becomes unmatched when that is allowed. Points are visited in order and take their best move.

    Parameters
    ----------
    problem
        The labelling problem.
    partners
        (N,) a correspondence to start from, `UNMATCHED` for none.

    Returns
    -------
    (N,) int64 correspondence whose energy is no greater; it never has more unmatched points than
    `partners` when all must be matched.
    """
    chosen = problem.chosen_candidates(partners)
    occlusion_cost = problem.occlusion_cost
    if problem.must_match_all:
        # Any complete correspondence is cheaper than this, so points are matched where possible.
        occlusion_cost = 2.0 * _largest_sum(problem) or 1.0
    _improve(
        problem.pairwise_costs,
        problem.triples,
        problem.unary,
        occlusion_cost,
        problem.scale,
        chosen,
    )
    return partners_of(problem, chosen)


def partners_of(problem: LabellingProblem, chosen: IntArray) -> IntArray:
    """Target point of each source point, from its candidate.

    Parameters
    ----------
    problem
        The labelling problem.
    chosen
        (N,) index of the candidate of each source point, negative for none.

    Returns
    -------
    (N,) int64, `UNMATCHED` for none.
    """
    if not problem.n_candidates:
        return np.full(problem.n_sources, UNMATCHED, dtype=np.int64)
    targets = problem.candidates[np.maximum(chosen, 0), 1]
    return np.where(chosen >= 0, targets, UNMATCHED).astype(np.int64)


def _largest_sum(problem: LabellingProblem) -> float:
    """Upper bound of the magnitude of the energy without occlusion costs."""
    spread = max(problem.source_distances.max(), problem.target_distances.max())
    metric = problem.beta_of_pairs.max() * problem.n_sources**2 * spread**2
    unary = problem.n_sources * np.abs(problem.unary).max(initial=0.0)
    largest = max(problem.table.max(initial=0.0), -problem.table.min(initial=0.0))
    table = problem.n_sources**2 * largest
    third = len(problem.triples.points) * problem.triples.costs.max(initial=0.0)
    return float(metric + table + unary + third + np.abs(problem.terms.costs).sum())


@kernel
def _switch(
    costs: PairwiseCosts,
    triples: TripleCosts,
    chosen: IntArray,
    owner: IntArray,
    marginal: FloatArray,
    x: int,
    new: int,
) -> None:
    """Give source point x the candidate `new`, and update the marginal costs.

    A point whose target is taken by `new` must be switched next. ``marginal[a]`` is the cost of
    candidate a given the candidates chosen for the *other* source points.
    """
    old = chosen[x]
    replace_costs(costs, x, old, new, marginal)
    replace_triple_costs(triples, chosen, x, old, new, marginal)
    if old >= 0 and owner[costs.candidates[old, 1]] == x:
        owner[costs.candidates[old, 1]] = -1
    if new >= 0:
        owner[costs.candidates[new, 1]] = x
    chosen[x] = new


@kernel
def _best_move(  # noqa: C901 - split, it would count references in its inner loop
    costs: PairwiseCosts,
    triples: TripleCosts,
    occlusion_cost: float,
    chosen: IntArray,
    owner: IntArray,
    free: int,
    marginal: FloatArray,
    x: int,
) -> tuple[float, int, int, int]:
    """Best change for x: its gain, x's new candidate, and the other point and its new one."""
    # Every array is taken out of the tuple once: that counts references, which takes longer than a
    # cost.
    candidates, rows, betas = costs.candidates, costs.rows, costs.beta[x]
    source, target = costs.source_distances[x], costs.target_distances
    more, table = len(costs.other) > 0 or len(triples.points) > 0, costs.table
    tabulated = len(table) > 0
    a = chosen[x]
    cost_a = marginal[a] if a >= 0 else occlusion_cost
    best, best_b, best_other, best_c = 0.0, a, -1, -1
    if a >= 0 and occlusion_cost - cost_a < best:
        best, best_b = occlusion_cost - cost_a, -1
    for b in range(rows[x], rows[x + 1]):
        if b == a:
            continue
        y = candidates[b, 1]
        other = owner[y]
        if other < 0:
            if marginal[b] - cost_a < best:
                best, best_b, best_other, best_c = marginal[b] - cost_a, b, -1, -1
            continue
        o = chosen[other]
        distance, beta = source[other], betas[other]
        left = cost_a + marginal[o]
        if a >= 0:
            left -= distortion_cost(beta, distance, target[candidates[a, 1], y])
        alone = marginal[b] - distortion_cost(beta, distance, 0.0)
        if tabulated:
            left -= table[a, o] if a >= 0 else 0.0
            alone -= table[b, o]
        if more:
            left -= _further_cost(costs, triples, chosen, x, a, other, o)
            alone -= _further_cost(costs, triples, chosen, x, b, other, o)
        if alone + occlusion_cost - left < best:
            best, best_b, best_other, best_c = alone + occlusion_cost - left, b, other, -1
        first, last = rows[other], rows[other + 1]
        if free == 0:  # no target point is left for the other one but x's
            first = _candidate(candidates, first, last, candidates[a, 1]) if a >= 0 else last
            last = min(first + 1, last)
        for c in range(first, last):
            z = candidates[c, 1]
            if c == o or (owner[z] >= 0 and owner[z] != x):
                continue
            gain = alone + marginal[c] - left + distortion_cost(beta, distance, target[y, z])
            if a >= 0:
                gain -= distortion_cost(beta, distance, target[candidates[a, 1], z])
            if tabulated:
                gain += table[b, c] - (table[c, a] if a >= 0 else 0.0)
            if more:
                gain += _further_cost(costs, triples, chosen, x, b, other, c)
                gain -= _further_cost(costs, triples, chosen, x, a, other, c)
            if gain < best:
                best, best_b, best_other, best_c = gain, b, other, c
    return best, best_b, best_other, best_c


@kernel
def _further_cost(
    costs: PairwiseCosts,
    triples: TripleCosts,
    chosen: IntArray,
    x: int,
    a: int,
    other: int,
    b: int,
) -> float:
    """Explicit cost of two candidates, and that of their triple, given its third point's one."""
    cost: float = listed_cost(costs, a, b)
    return cost + cost_given_third(triples, chosen, x, a, other, b)


@kernel
def _candidate(candidates: IntArray, first: int, last: int, y: int) -> int:
    """First of some candidates of one point that serves target y, or `last` for none."""
    end = last
    while first < last:
        middle = (first + last) // 2
        if candidates[middle, 1] < y:
            first = middle + 1
        else:
            last = middle
    return first if first < end and candidates[first, 1] == y else end


@kernel
def _improve(
    costs: PairwiseCosts,
    triples: TripleCosts,
    unary: FloatArray,
    occlusion_cost: float,
    scale: float,
    chosen: IntArray,
) -> None:
    n = len(chosen)
    if len(unary) == 0:
        return
    owner = np.full(costs.target_distances.shape[0], -1, dtype=np.int64)
    marginal = unary.copy()
    start = chosen.copy()
    chosen[:] = -1
    for x in range(n):
        if start[x] >= 0:
            _switch(costs, triples, chosen, owner, marginal, x, start[x])
    tolerance = allowance(np.abs(marginal).max(), scale)
    for _ in range(_MAX_PASSES):
        improved = False
        for x in range(n):
            free = int((owner < 0).sum())
            gain, b, other, c = _best_move(
                costs, triples, occlusion_cost, chosen, owner, free, marginal, x
            )
            if not gain < -tolerance:
                continue
            improved = True
            _switch(costs, triples, chosen, owner, marginal, x, b)
            if other >= 0:
                _switch(costs, triples, chosen, owner, marginal, other, c)
        if not improved:
            return
