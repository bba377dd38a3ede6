"""Pairwise costs of candidates: distortions of two metrics, tabulated ones, and explicit terms."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel


@dataclass(frozen=True, eq=False)
class PairwiseTerms:
    """Costs of some pairs of candidates, one by one.

    Parameters
    ----------
    first, second
        (E,) indices of candidates, ``first < second``, each pair once, in lexicographic order.
    costs
        (E,) finite, of any sign.
    """

    first: IntArray
    second: IntArray
    costs: FloatArray

    def __post_init__(self) -> None:
        if not self.first.shape == self.second.shape == self.costs.shape:
            raise ValueError("every pairwise term needs two candidates and a cost")
        if not np.isfinite(self.costs).all():
            raise ValueError("pairwise costs must be finite")
        if (self.first < 0).any() or (self.first >= self.second).any():
            raise ValueError("a pairwise term needs two candidates, the lower index first")
        rises = np.diff(self.first), np.diff(self.second)
        if ((rises[0] < 0) | ((rises[0] == 0) & (rises[1] <= 0))).any():
            raise ValueError("pairwise terms must be unique and in lexicographic order")

    @classmethod
    def collect(cls, pairs: IntArray, costs: FloatArray) -> "PairwiseTerms":
        """Put terms in order; those of one pair of candidates are added up.

        Parameters
        ----------
        pairs
            (E, 2) two different candidates each.
        costs
            (E,) their costs.
        """
        low, high = np.minimum(*pairs.T), np.maximum(*pairs.T)
        width = int(high.max(initial=0)) + 1
        keys, where = np.unique(low * width + high, return_inverse=True)
        total = np.bincount(where, weights=costs, minlength=len(keys))
        first, second = np.divmod(keys, width)
        return cls(first.astype(np.int64), second.astype(np.int64), total.astype(np.float64))

    def among(self, kept: IntArray, n_candidates: int) -> "PairwiseTerms":
        """Return the terms of some of the candidates, renumbered.

        Parameters
        ----------
        kept
            (V',) candidates, ascending.
        n_candidates
            Number of all candidates.
        """
        place = np.full(n_candidates, -1, dtype=np.int64)
        place[kept] = np.arange(len(kept))
        first, second = place[self.first], place[self.second]
        both = (first >= 0) & (second >= 0)
        return PairwiseTerms(first[both], second[both], self.costs[both])

    def adjacency(self, n_candidates: int) -> tuple[IntArray, IntArray, FloatArray]:
        """Terms of each candidate, in compressed rows.

        Returns
        -------
        first, other, cost
            (V+1,), (2E,) and (2E,): candidate a has terms with ``other[first[a]:first[a+1]]``,
            ascending.
        """
        one = np.concatenate([self.first, self.second])
        two = np.concatenate([self.second, self.first])
        order = np.lexsort((two, one))
        first = np.searchsorted(one[order], np.arange(n_candidates + 1)).astype(np.int64)
        return first, two[order], np.concatenate([self.costs, self.costs])[order]


NO_TABLE: FloatArray = np.empty((0, 0), dtype=np.float64)
"""No tabulated costs."""

NO_WEIGHTS: FloatArray = np.empty((0, 0), dtype=np.float64)
"""Every two source points have the weight 1."""

NO_TERMS = PairwiseTerms(
    np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.float64)
)
"""No explicit terms: all pairwise costs are distortions of the metrics."""


class PairwiseCosts(NamedTuple):
    """All forms of the pairwise costs, for compiled code.

    Attributes
    ----------
    candidates
        (V, 2) indices (x, y).
    rows
        (N+1,) candidates of source point x are ``rows[x]`` to ``rows[x+1]``.
    source_distances, target_distances
        (N, N) and (M, M).
    beta
        (N, N) weights of the metrics' distortion for two source points.
    first, other, cost
        Explicit terms in compressed rows; see :meth:`PairwiseTerms.adjacency`.
    table
        (V, V) costs of all pairs of candidates, or `NO_TABLE`.
    """

    candidates: IntArray
    rows: IntArray
    source_distances: FloatArray
    target_distances: FloatArray
    beta: FloatArray
    first: IntArray
    other: IntArray
    cost: FloatArray
    table: FloatArray


@inlined
def distortion_cost(beta: float, source_distance: float, target_distance: float) -> float:
    """Equation (5), second-order term of two candidates: β |d_X(x, x') − d_Y(y, y')|²."""
    difference = source_distance - target_distance
    return beta * difference * difference


@inlined
def metric_cost(costs: PairwiseCosts, a: int, b: int) -> float:
    """Cost of two candidates that comes from the metrics, or from the table."""
    c = costs.candidates
    distortion = distortion_cost(
        costs.beta[c[a, 0], c[b, 0]],
        costs.source_distances[c[a, 0], c[b, 0]],
        costs.target_distances[c[a, 1], c[b, 1]],
    )
    return distortion + costs.table[a, b] if len(costs.table) else distortion


@kernel
def listed_cost(costs: PairwiseCosts, a: int, b: int) -> float:
    """Cost of two candidates that is an explicit term; 0 when either is negative."""
    if a < 0 or b < 0:
        return 0.0
    row = costs.other[costs.first[a] : costs.first[a + 1]]
    place = np.searchsorted(row, b)
    if place < len(row) and row[place] == b:
        value: float = costs.cost[costs.first[a] + place]
        return value
    return 0.0


@kernel
def pairwise_cost(costs: PairwiseCosts, a: int, b: int) -> float:
    """Cost of two compatible candidates; 0 if an index is negative: no candidate."""
    if a < 0 or b < 0:
        return 0.0
    return metric_cost(costs, a, b) + listed_cost(costs, a, b)


@kernel
def pairwise_sums(costs: PairwiseCosts, chosen: IntArray) -> FloatArray:
    """Sum of each chosen candidate's costs with the others.

    Parameters
    ----------
    costs
        Of all candidates.
    chosen
        (K,) compatible candidates.

    Returns
    -------
    (K,) float64; each pair's cost counts in both.
    """
    sums = np.zeros(len(chosen))
    candidates, beta = costs.candidates, costs.beta
    source, target = costs.source_distances, costs.target_distances
    listed, table = len(costs.other) > 0, costs.table
    for i in range(len(chosen)):
        x, y = candidates[chosen[i]]
        for j in range(i + 1, len(chosen)):
            other, z = candidates[chosen[j]]
            value = distortion_cost(beta[x, other], source[x, other], target[y, z])
            if len(table):
                value += table[chosen[i], chosen[j]]
            if listed:
                value += listed_cost(costs, chosen[i], chosen[j])
            sums[i] += value
            sums[j] += value
    return sums


@kernel
def pairwise_table(costs: PairwiseCosts) -> FloatArray:
    """Cost of every two candidates, without explicit terms.

    Returns
    -------
    (V, V) float64, symmetric; ``inf`` for pairs that exclude one another (the same source or the
    same target point), 0 on the diagonal.
    """
    candidates, beta, count = costs.candidates, costs.beta, len(costs.candidates)
    targets = candidates[:, 1].copy()
    found = np.empty((count, count))
    for a in range(count):
        x, y = candidates[a]
        row = found[a]
        if len(costs.table):
            row[:] = costs.table[a]
        else:
            row[:] = 0.0
        distances = costs.target_distances[y]
        for b in range(count):
            other = candidates[b, 0]
            distance = costs.source_distances[x, other]
            row[b] += distortion_cost(beta[x, other], distance, distances[targets[b]])
        for b in range(count):
            if targets[b] == y:
                row[b] = np.inf
        row[costs.rows[x] : costs.rows[x + 1]] = np.inf
        row[a] = 0.0
    return found


@kernel
def replace_costs(costs: PairwiseCosts, x: int, old: int, new: int, marginal: FloatArray) -> None:
    """Replace the pairwise costs with candidate `old` of x by those with `new`.

    Parameters
    ----------
    costs
        Of all candidates.
    x
        A source point.
    old, new
        Candidates of it, negative for none.
    marginal
        (V,) cost of each candidate given those chosen; changed in place, except for candidates of
        x itself.
    """
    targets = costs.candidates[:, 1]
    before = costs.target_distances[targets[max(old, 0)]]
    after = costs.target_distances[targets[max(new, 0)]]
    for other in range(len(costs.rows) - 1):
        beta = costs.beta[x, other]
        if other == x or beta == 0.0:
            continue
        distance = costs.source_distances[x, other]
        minus = beta if old >= 0 else 0.0
        plus = beta if new >= 0 else 0.0
        for a in range(costs.rows[other], costs.rows[other + 1]):
            y = targets[a]
            marginal[a] += distortion_cost(plus, distance, after[y]) - distortion_cost(
                minus, distance, before[y]
            )
    if len(costs.table):
        _replace_tabulated(costs, x, old, new, marginal)
    if len(costs.other):
        own, end = costs.rows[x], costs.rows[x + 1]
        for sign, which in ((-1.0, old), (1.0, new)):
            if which >= 0:
                for place in range(costs.first[which], costs.first[which + 1]):
                    a = costs.other[place]
                    if not own <= a < end:
                        marginal[a] += sign * costs.cost[place]


@kernel
def _replace_tabulated(
    costs: PairwiseCosts, x: int, old: int, new: int, marginal: FloatArray
) -> None:
    own, end = costs.rows[x], costs.rows[x + 1]
    for sign, which in ((-1.0, old), (1.0, new)):
        if which >= 0:
            row = costs.table[which]
            for a in range(own):
                marginal[a] += sign * row[a]
            for a in range(end, len(marginal)):
                marginal[a] += sign * row[a]
