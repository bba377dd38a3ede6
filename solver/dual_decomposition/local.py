"""Local subproblems: two source points, or two target points, with all their candidates.

A source point of a local subproblem takes one of its candidates (or none, where source points may
stay unmatched); a target point is taken by one of its candidates or by none (unless every target
point must be taken). Two candidates that exclude one another are never taken together.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import pairwise_cost

NOTHING = -1
"""Marks a point that takes no candidate in a local subproblem."""


@kernel
def minimise_source_pairs(
    candidates: IntArray,
    first: IntArray,
    unary_shares: FloatArray,
    pairwise_shares: FloatArray,
    may_be_unmatched: bool,
    choices: IntArray,
) -> float:
    """Solve the local subproblems of all pairs of source points, by enumeration.

    Parameters
    ----------
    candidates
        (V, 2), in lexicographic order.
    first
        (N+1,) offsets of each source point's candidates.
    unary_shares
        (V, N); see ``Duals``.
    pairwise_shares
        (V, V), upper part.
    may_be_unmatched
        Whether a source point may take nothing, at no cost.
    choices
        (N, N) written: the candidate that x takes in the subproblem {x, x'}, or `NOTHING`.

    Returns
    -------
    Sum of the minima; ``inf`` when some subproblem has no solution.
    """
    n = len(first) - 1
    total = 0.0
    for x in range(n):
        for z in range(x + 1, n):
            best, best_a, best_b = np.inf, NOTHING, NOTHING
            if may_be_unmatched:
                best = 0.0
                for b in range(first[z], first[z + 1]):
                    if unary_shares[b, x] < best:
                        best, best_b = unary_shares[b, x], b
            for a in range(first[x], first[x + 1]):
                alone = unary_shares[a, z]
                if may_be_unmatched and alone < best:
                    best, best_a, best_b = alone, a, NOTHING
                for b in range(first[z], first[z + 1]):
                    cost = alone + unary_shares[b, x] + pairwise_shares[a, b]
                    if cost < best and candidates[a, 1] != candidates[b, 1]:
                        best, best_a, best_b = cost, a, b
            total += best
            choices[x, z] = best_a
            choices[z, x] = best_b
    return total


@kernel
def minimise_target_pairs(
    candidates: IntArray,
    first: IntArray,
    order: IntArray,
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    unary_shares: FloatArray,
    source_pairwise_shares: FloatArray,
    may_be_unmatched: bool,
    choices: IntArray,
) -> float:
    """Solve the local subproblems of all pairs of target points, by enumeration.

    Parameters
    ----------
    candidates
        (V, 2), in lexicographic order.
    first, order
        (M+1,) and (V,): the candidates of target point y are ``order[first[y]:first[y+1]]``.
    source_distances, target_distances, beta
        The pairwise cost is computed from these.
    unary_shares
        (V, M); see ``Duals``.
    source_pairwise_shares
        (V, V), upper part; the target pairs have what these leave of the pairwise cost.
    may_be_unmatched
        Whether a target point may be taken by nothing, at no cost.
    choices
        (M, M) written: the candidate that takes y in the subproblem {y, y'}, or `NOTHING`.

    Returns
    -------
    Sum of the minima; ``inf`` when some subproblem has no solution.
    """
    m = len(first) - 1
    total = 0.0
    for y in range(m):
        for z in range(y + 1, m):
            best, best_a, best_b = np.inf, NOTHING, NOTHING
            if may_be_unmatched:
                best = 0.0
                for j in range(first[z], first[z + 1]):
                    b = order[j]
                    if unary_shares[b, y] < best:
                        best, best_b = unary_shares[b, y], b
            between = target_distances[y, z]
            for i in range(first[y], first[y + 1]):
                a = order[i]
                alone = unary_shares[a, z]
                if may_be_unmatched and alone < best:
                    best, best_a, best_b = alone, a, NOTHING
                for j in range(first[z], first[z + 1]):
                    b = order[j]
                    if candidates[a, 0] == candidates[b, 0]:
                        continue
                    share = source_pairwise_shares[min(a, b), max(a, b)]
                    cost = alone + unary_shares[b, y] - share
                    cost += pairwise_cost(
                        beta, source_distances[candidates[a, 0], candidates[b, 0]], between
                    )
                    if cost < best:
                        best, best_a, best_b = cost, a, b
            total += best
            choices[y, z] = best_a
            choices[z, y] = best_b
    return total


@kernel
def add_local_subgradient(
    choices: IntArray, sign: float, unary: FloatArray, pairwise: FloatArray
) -> None:
    """Add the local minimisers to a direction in the space of the duals.

    Parameters
    ----------
    choices
        (P, P) as written by the functions above.
    sign
        Of the pairwise part: +1 for source pairs, -1 for target pairs, which have what the
        source pairs leave.
    unary
        (V, P) changed in place.
    pairwise
        (V, V) changed in place, upper part.
    """
    points = len(choices)
    for x in range(points):
        for z in range(x + 1, points):
            a = choices[x, z]
            b = choices[z, x]
            if a >= 0:
                unary[a, z] += 1.0
            if b >= 0:
                unary[b, x] += 1.0
            if a >= 0 and b >= 0:
                pairwise[min(a, b), max(a, b)] += sign
