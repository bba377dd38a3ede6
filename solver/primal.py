"""Good correspondences without a proof: rounding and local search for problem (5)."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import UNMATCHED, LabellingProblem, pairwise_cost


class InfeasibleError(ValueError):
    """Every source point must be matched, and the candidates do not allow it."""


def assign(problem: LabellingProblem, costs: FloatArray) -> IntArray:
    """Cheapest assignment for a cost on each candidate, without pairwise costs.

    Parameters
    ----------
    problem
        Says which pairs are candidates and what an unmatched source point costs.
    costs
        (V,) finite cost of each candidate; may be negative.

    Returns
    -------
    (N,) int64 target point of each source point, `UNMATCHED` for none.

    Raises
    ------
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """
    n, m = problem.shape
    width = m if problem.must_match_all else m + n
    matrix = np.full((n, width), np.inf)
    matrix[problem.candidates[:, 0], problem.candidates[:, 1]] = costs
    if not problem.must_match_all:
        own_column = np.arange(n)
        matrix[own_column, m + own_column] = problem.occlusion_cost
    try:
        rows, columns = linear_sum_assignment(matrix)
    except ValueError as error:
        raise InfeasibleError("the candidates admit no complete correspondence") from error
    if len(rows) < n:
        raise InfeasibleError("there are fewer target points than source points")
    return np.where(columns < m, columns, UNMATCHED).astype(np.int64)


def local_search(
    problem: LabellingProblem, partners: IntArray, *, max_passes: int = 1000
) -> IntArray:
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
    max_passes
        Bound on the rounds over all source points.

    Returns
    -------
    (N,) int64 correspondence whose energy is no greater; it never has more unmatched points than
    `partners` when all must be matched.
    """
    chosen = _candidate_of(problem, partners)
    occlusion_cost = problem.occlusion_cost
    if problem.must_match_all:
        # Any complete correspondence is cheaper than this, so points are matched where possible.
        spread = max(problem.source_distances.max(), problem.target_distances.max())
        occlusion_cost = 1.0 + problem.n_sources * (
            problem.unary.max(initial=0.0) + problem.beta * problem.n_sources * spread**2
        )
    _improve(
        problem.candidates,
        problem.first_candidate,
        problem.unary,
        problem.source_distances,
        problem.target_distances,
        problem.beta,
        occlusion_cost,
        chosen,
        max_passes,
    )
    result = np.full(problem.n_sources, UNMATCHED, dtype=np.int64)
    matched = chosen >= 0
    result[matched] = problem.candidates[chosen[matched], 1]
    return result


def _candidate_of(problem: LabellingProblem, partners: IntArray) -> IntArray:
    """(N,) index of the candidate each source point uses, -1 for none."""
    width = problem.n_targets
    keys = problem.candidates[:, 0] * width + problem.candidates[:, 1]
    wanted = np.arange(problem.n_sources) * width + partners
    place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    matched = partners != UNMATCHED
    if (keys[place[matched]] != wanted[matched]).any():
        raise ValueError("a matched pair is not a candidate")
    return np.where(matched, place, -1).astype(np.int64)


@kernel
def _cost_between(
    candidates: IntArray,
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    a: int,
    b: int,
) -> float:
    """Pairwise cost of two candidates; 0 when either is "unmatched" (negative)."""
    if a < 0 or b < 0:
        return 0.0
    return pairwise_cost(
        beta,
        source_distances[candidates[a, 0], candidates[b, 0]],
        target_distances[candidates[a, 1], candidates[b, 1]],
    )


@kernel
def _switch(
    candidates: IntArray,
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    chosen: IntArray,
    owner: IntArray,
    marginal: FloatArray,
    x: int,
    new: int,
) -> None:
    """Give source point x the candidate `new`, keeping every candidate's marginal cost true."""
    old = chosen[x]
    for a in range(len(candidates)):
        if candidates[a, 0] == x:
            continue
        marginal[a] += _cost_between(
            candidates, source_distances, target_distances, beta, a, new
        ) - _cost_between(candidates, source_distances, target_distances, beta, a, old)
    if old >= 0 and owner[candidates[old, 1]] == x:
        owner[candidates[old, 1]] = -1
    if new >= 0:
        owner[candidates[new, 1]] = x
    chosen[x] = new


@kernel
def _best_move(
    candidates: IntArray,
    first: IntArray,
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    occlusion_cost: float,
    chosen: IntArray,
    owner: IntArray,
    marginal: FloatArray,
    x: int,
) -> tuple[float, int, int, int]:
    """Best change for x: its gain, x's new candidate, and the other point and its new one."""
    a = chosen[x]
    cost_a = marginal[a] if a >= 0 else occlusion_cost
    best, best_b, best_other, best_c = 0.0, a, -1, -1
    if a >= 0 and occlusion_cost - cost_a < best:
        best, best_b = occlusion_cost - cost_a, -1
    for b in range(first[x], first[x + 1]):
        if b == a:
            continue
        other = owner[candidates[b, 1]]
        if other < 0:
            if marginal[b] - cost_a < best:
                best, best_b, best_other, best_c = marginal[b] - cost_a, b, -1, -1
            continue
        o = chosen[other]
        between = _cost_between(candidates, source_distances, target_distances, beta, a, o)
        left = cost_a + marginal[o] - between
        alone = marginal[b] - _cost_between(
            candidates, source_distances, target_distances, beta, b, o
        )
        if alone + occlusion_cost - left < best:
            best, best_b, best_other, best_c = alone + occlusion_cost - left, b, other, -1
        for c in range(first[other], first[other + 1]):
            place = owner[candidates[c, 1]]
            if c == o or (place >= 0 and place != x):
                continue
            gain = (
                alone
                + marginal[c]
                - _cost_between(candidates, source_distances, target_distances, beta, c, a)
                + _cost_between(candidates, source_distances, target_distances, beta, b, c)
                - left
            )
            if gain < best:
                best, best_b, best_other, best_c = gain, b, other, c
    return best, best_b, best_other, best_c


@kernel
def _improve(
    candidates: IntArray,
    first: IntArray,
    unary: FloatArray,
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    occlusion_cost: float,
    chosen: IntArray,
    max_passes: int,
) -> None:
    n = len(chosen)
    owner = np.full(target_distances.shape[0], -1, dtype=np.int64)
    marginal = unary.copy()
    start = chosen.copy()
    chosen[:] = -1
    for x in range(n):
        if start[x] >= 0:
            _switch(
                candidates, source_distances, target_distances, beta, chosen, owner, marginal,
                x, start[x],
            )  # fmt: skip
    for _ in range(max_passes):
        improved = False
        for x in range(n):
            gain, b, other, c = _best_move(
                candidates, first, source_distances, target_distances, beta, occlusion_cost,
                chosen, owner, marginal, x,
            )  # fmt: skip
            if not gain < -1e-12:
                continue
            improved = True
            if other >= 0:
                _switch(
                    candidates, source_distances, target_distances, beta, chosen, owner,
                    marginal, other, -1,
                )  # fmt: skip
            _switch(
                candidates, source_distances, target_distances, beta, chosen, owner, marginal,
                x, b,
            )  # fmt: skip
            if other >= 0 and c >= 0:
                _switch(
                    candidates, source_distances, target_distances, beta, chosen, owner,
                    marginal, other, c,
                )  # fmt: skip
        if not improved:
            return
