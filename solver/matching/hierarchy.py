"""Hierarchical matching (4.1): a correspondence of one level refined to the next finer level."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.labelling import UNMATCHED, LabellingProblem
from solver.matching.level import Level
from solver.optimisation.primal import InfeasibleError, local_search, maximum_matching

_CANDIDATES_PER_POINT = 12
"""Candidates of a source point above the coarsest level, chosen on generated shapes."""

_MAX_CANDIDATES = 2048
"""Bound on |V| above the coarsest level: a dual decomposition takes some 45 |V|² bytes, 190 MB."""


@dataclass(frozen=True, eq=False)
class RefinedCorrespondence:
    """A correspondence at a level, with the problem that it solves there.

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


def refine(partners: IntArray, fine: Level, rho: float) -> RefinedCorrespondence:
    """Refine a correspondence from one level to the next finer one (4.1).

    Parameters
    ----------
    partners
        (N_k,) correspondence C_k at the coarser level, whose samples begin those of `fine`.
    fine
        The next level.
    rho
        ρ of 4.1: radius of the neighbourhoods of the matched points, in their covering radii.

    Returns
    -------
    RefinedCorrespondence
        The best correspondence that local search finds among the candidates V_{k+1}.

    Raises
    ------
    InfeasibleError
        There are fewer target samples than source samples.
    """
    matched = np.flatnonzero(partners != UNMATCHED)
    source = fine.source.distances[:, matched]
    target = fine.target.distances[:, partners[matched]]
    disagreement = _disagreement(source, target)
    allowed = fine.allowed()
    near = _neighbourhoods(source, target, rho) & allowed
    # The partner of a landmark is a candidate however far the coarser levels have moved it.
    near[: fine.landmarks] = allowed[: fine.landmarks]
    for candidates in _candidates(disagreement, near, allowed):
        problem = fine.problem(candidates)
        try:
            start = maximum_matching(problem, disagreement[candidates[:, 0], candidates[:, 1]])
        except InfeasibleError:
            continue
        found = local_search(problem, start)
        return RefinedCorrespondence(problem, found, problem.energy(found))
    raise InfeasibleError("there are fewer target points than source points")


def rematch(partners: IntArray, level: Level, rho: float) -> RefinedCorrespondence:
    """Match the same source samples again among more target samples.

    Parameters
    ----------
    partners
        (N,) correspondence at the level before, whose samples begin those of `level`.
    level
        The level, with as many source samples.
    rho
        Partners move by at most ρ covering radii of the old partners, so that a hypothesis keeps
        its identity. All target samples are candidates of unmatched points.

    Returns
    -------
    RefinedCorrespondence
        The best correspondence that local search finds among these candidates.
    """
    matched = np.flatnonzero(partners != UNMATCHED)
    moved = level.target.distances[partners[matched]]
    near = level.allowed()
    near[matched] &= moved <= rho * moved.min(axis=0, initial=np.inf).max(initial=0.0)
    # The old partner remains a candidate, as do the partners of landmarks.
    near[matched, partners[matched]] = True
    problem = level.problem(np.argwhere(near).astype(np.int64))
    found = local_search(problem, partners)
    return RefinedCorrespondence(problem, found, problem.energy(found))


def _candidates(
    disagreement: FloatArray, near: BoolArray, allowed: BoolArray
) -> Iterator[IntArray]:
    """Yield growing sets of (V, 2) candidates; the last one always admits an assignment."""
    per_point = candidates_per_point(len(near))
    yield best_candidates(disagreement, near, per_point)
    yield best_candidates(disagreement, near, 2 * per_point)
    if allowed.size <= 2 * _MAX_CANDIDATES:
        yield np.argwhere(allowed).astype(np.int64)
        return
    # Pairwise costs of all pairs would take tens of gigabytes: add an optimal assignment instead.
    x, y = best_candidates(disagreement, allowed, 2 * per_point).T
    chosen = np.zeros_like(allowed)
    chosen[x, y] = True
    chosen[linear_sum_assignment(np.where(allowed, disagreement, np.inf))] = True
    yield np.argwhere(chosen).astype(np.int64)


def _disagreement(source: FloatArray, target: FloatArray) -> FloatArray:
    """(N, M) mean squared difference of the distances to the K points matched already.

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
    """(N, M) mask of the pairs near some matched pair on both shapes: V_{k+1} of 4.1.

    The radii r_k and r'_k are those with which the matched points cover this level's samples.
    """
    near_source = source < rho * source.min(axis=1, initial=np.inf).max(initial=0.0)
    near_target = target < rho * target.min(axis=1, initial=np.inf).max(initial=0.0)
    near: BoolArray = near_source @ near_target.T
    return near


def candidates_per_point(points: int) -> int:
    """Greatest number of candidates of each of N points above the coarsest level."""
    return max(min(_CANDIDATES_PER_POINT, _MAX_CANDIDATES // points), 1)


def best_candidates(disagreement: FloatArray, near: BoolArray, per_point: int) -> IntArray:
    """Choose the candidates of least disagreement for each source sample.

    Parameters
    ----------
    disagreement, near
        (N, M) disagreement of each pair, and mask of the pairs that may be candidates.
    per_point
        Greatest number of candidates of a source sample.

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
