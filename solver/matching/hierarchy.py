"""Hierarchical matching, section 4.1: exact where points are few, then closer and closer."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.matching.level import Level
from solver.optimisation.primal import InfeasibleError, local_search, solve_lap

_CANDIDATES_PER_POINT = 12
_MOST_CANDIDATES = 2048
"""Bound on |V| above the coarsest level: a dual decomposition takes some 45 |V|² bytes, 190 MB."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """A correspondence at some level, with the problem it solves there.

    Parameters
    ----------
    problem
        Problem (5) on the candidates near the coarser correspondence.
    partners
        (N,) index of each source sample's target sample, `UNMATCHED` for none.
    energy
        Its energy.
    """

    problem: LabellingProblem
    partners: IntArray
    energy: float


def refine(partners: IntArray, fine: Level, rho: float) -> Refinement:
    """Carry a correspondence from one level to the next finer one.

    Parameters
    ----------
    partners
        (N_k,) correspondence C_k at the coarser level, whose samples begin those of `fine`.
    fine
        The next level.
    rho
        ρ of 4.1.

    Returns
    -------
    Refinement
        The best correspondence that local search finds among the candidates.
    """
    matched = np.flatnonzero(partners != UNMATCHED)
    source = fine.source.distances[:, matched]
    target = fine.target.distances[:, partners[matched]]
    disagreement = _disagreement(source, target)
    allowed = fine.allowed()
    near = _neighbourhoods(source, target, rho) & allowed
    # However far the coarser levels have taken it, a landmark's partner is near.
    near[: fine.landmarks] = allowed[: fine.landmarks]
    for candidates in _candidates(disagreement, near, allowed):
        problem = fine.problem(candidates)
        try:
            start = solve_lap(problem, disagreement[candidates[:, 0], candidates[:, 1]])
        except InfeasibleError:
            continue
        found = local_search(problem, start)
        return Refinement(problem, found, problem.energy(found))
    raise InfeasibleError("there are fewer target points than source points")


def rematch(partners: IntArray, level: Level, rho: float) -> Refinement:
    """Match the same points again, among more samples of the target.

    Parameters
    ----------
    partners
        (N,) correspondence at the level before, whose samples begin those of `level`.
    level
        The level, with as many source samples.
    rho
        Points stay within so many covering radii of their partners: a hypothesis remains what it
        is. Those that have none may go anywhere.

    Returns
    -------
    Refinement
        What local search finds among all these pairs.
    """
    matched = np.flatnonzero(partners != UNMATCHED)
    moved = level.target.distances[partners[matched]]
    near = level.allowed()
    near[matched] &= moved <= rho * moved.min(axis=0, initial=np.inf).max(initial=0.0)
    # However far, a landmark's partner is its own, and every point may stay where it is.
    near[matched, partners[matched]] = True
    problem = level.problem(np.argwhere(near).astype(np.int64))
    found = local_search(problem, partners)
    return Refinement(problem, found, problem.energy(found))


def _candidates(
    disagreement: FloatArray, near: BoolArray, allowed: BoolArray
) -> Iterator[IntArray]:
    """(V, 2) candidates, and more where points compete for too few: the last always suffice."""
    per_point = candidates_per_point(len(near))
    yield closest(disagreement, near, per_point)
    yield closest(disagreement, near, 2 * per_point)
    if allowed.size <= 2 * _MOST_CANDIDATES:
        yield np.argwhere(allowed).astype(np.int64)
        return
    # The pairwise costs of all pairs would take tens of gigabytes.
    x, y = closest(disagreement, allowed, 2 * per_point).T
    chosen = np.zeros_like(allowed)
    chosen[x, y] = True
    chosen[linear_sum_assignment(np.where(allowed, disagreement, np.inf))] = True
    yield np.argwhere(chosen).astype(np.int64)


def _disagreement(source: FloatArray, target: FloatArray) -> FloatArray:
    """(N, M) mean squared difference of the distances to the points matched already.

    `source` (N, K) and `target` (M, K) hold these distances.
    """
    squares = (
        (source**2).sum(axis=1)[:, None]
        + (target**2).sum(axis=1)[None, :]
        - 2.0 * source @ target.T
    )
    result: FloatArray = np.maximum(squares, 0.0) / max(source.shape[1], 1)
    return result


def _neighbourhoods(source: FloatArray, target: FloatArray, rho: float) -> BoolArray:
    """(N, M) whether a pair is near some matched pair on both shapes: V_{k+1} of 4.1.

    The radii r_k and r'_k are those with which the matched points cover this level's samples.
    """
    near_source = source < rho * source.min(axis=1, initial=np.inf).max(initial=0.0)
    near_target = target < rho * target.min(axis=1, initial=np.inf).max(initial=0.0)
    near: BoolArray = near_source @ near_target.T
    return near


def candidates_per_point(points: int) -> int:
    """How many candidates each of some points may have above the coarsest level."""
    return max(min(_CANDIDATES_PER_POINT, _MOST_CANDIDATES // points), 1)


def closest(disagreement: FloatArray, near: BoolArray, per_point: int) -> IntArray:
    """Candidates of each source sample that agree best with what is known of it.

    Parameters
    ----------
    disagreement, near
        (N, M) how little each pair agrees, and whether it may be a candidate.
    per_point
        Of each source sample at most so many.

    Returns
    -------
    (V, 2) in lexicographic order.
    """
    cost = np.where(near, disagreement, np.inf)
    count = min(per_point, cost.shape[1])
    columns = np.sort(np.argsort(cost, axis=1, kind="stable")[:, :count], axis=1)
    rows = np.repeat(np.arange(len(cost)), count)
    pairs = np.stack([rows, columns.ravel()], axis=1).astype(np.int64)
    return pairs[np.isfinite(cost[pairs[:, 0], pairs[:, 1]])]
