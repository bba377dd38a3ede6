"""The correspondence problem as a binary labelling problem: equation (5), section 4.

Labels are attached to *candidates*, the pairs of V ⊂ X × Y that may be matched. Each source point
takes one of its candidates or stays unmatched, each target point serves at most one source point.

The energy is (5) plus the constant γ|X|, so that it counts what a correspondence costs: the
distortion of what is matched, and γ for every source point that is not. It is never negative, zero
only for a perfect correspondence, and a relative gap has a meaning that γ does not dilute.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel

UNMATCHED = -1
"""Marks a source point without a partner wherever an array holds partners."""


@dataclass(frozen=True, eq=False)
class LabellingProblem:
    """Problem (5) on a set of candidate pairs, with pairwise costs computed on the fly.

    Parameters
    ----------
    candidates
        (V, 2) indices (x, y) into the source and target points, each row once, in
        lexicographic order.
    unary
        (V,) first-order cost of each candidate, non-negative: the weighted ‖f_X(x) − f_Y(y)‖.
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics d_X and d_Y between the sampled points.
    beta
        Weight β ≥ 0 of the second-order term; every unordered pair of candidates counts once.
    occlusion_cost
        γ > 0, what an unmatched source point costs; ``inf`` when every one must be matched.
    """

    candidates: IntArray
    unary: FloatArray
    source_distances: FloatArray
    target_distances: FloatArray
    beta: float = 1.0
    occlusion_cost: float = np.inf

    def __post_init__(self) -> None:
        count = len(self.candidates)
        if self.candidates.shape != (count, 2) or self.unary.shape != (count,):
            raise ValueError("candidates must be (V, 2) and unary costs (V,)")
        for distances in (self.source_distances, self.target_distances):
            if distances.ndim != 2 or distances.shape[0] != distances.shape[1]:
                raise ValueError("distances must be square matrices")
            if not np.isfinite(distances).all():
                raise ValueError("distances must be finite")
        if count and not (np.isfinite(self.unary).all() and self.unary.min() >= 0.0):
            raise ValueError("unary costs must be finite and non-negative")
        if not (0.0 <= self.beta < np.inf) or not self.occlusion_cost > 0.0:
            raise ValueError("beta must be finite and >= 0, the occlusion cost > 0")
        keys = self.candidates[:, 0] * self.n_targets + self.candidates[:, 1]
        if count and (self.candidates.min() < 0 or (self.candidates >= self.shape).any()):
            raise ValueError("candidates name points that do not exist")
        if (np.diff(keys) <= 0).any():
            raise ValueError("candidates must be unique and in lexicographic order")

    @property
    def n_sources(self) -> int:
        """Number N of source points."""
        return int(self.source_distances.shape[0])

    @property
    def n_targets(self) -> int:
        """Number M of target points."""
        return int(self.target_distances.shape[0])

    @property
    def shape(self) -> tuple[int, int]:
        """(N, M)."""
        return self.n_sources, self.n_targets

    @property
    def n_candidates(self) -> int:
        """Number |V| of candidates."""
        return len(self.candidates)

    @property
    def must_match_all(self) -> bool:
        """Whether leaving a source point unmatched is forbidden (γ infinite)."""
        return bool(np.isinf(self.occlusion_cost))

    @cached_property
    def first_candidate(self) -> IntArray:
        """(N+1,) offsets: the candidates of source point x are first[x] .. first[x+1]-1."""
        return np.searchsorted(self.candidates[:, 0], np.arange(self.n_sources + 1)).astype(
            np.int64
        )

    @cached_property
    def unary_matrix(self) -> FloatArray:
        """(N, M) unary costs, ``inf`` where (x, y) is not a candidate."""
        matrix = np.full(self.shape, np.inf)
        matrix[self.candidates[:, 0], self.candidates[:, 1]] = self.unary
        return matrix

    def pairwise_matrix(self) -> FloatArray:
        """Second-order cost of every pair of candidates: β |d_X(x, x') − d_Y(y, y')|².

        Returns
        -------
        (V, V) float64, symmetric; ``inf`` for pairs that exclude one another (the same source or
        the same target point), 0 on the diagonal. Memory grows with V².
        """
        x, y = self.candidates.T
        difference = self.source_distances[np.ix_(x, x)] - self.target_distances[np.ix_(y, y)]
        costs = self.beta * difference**2
        costs[(x[:, None] == x[None, :]) | (y[:, None] == y[None, :])] = np.inf
        np.fill_diagonal(costs, 0.0)
        return costs

    def costs(self, partners: IntArray) -> FloatArray:
        """Each source point's share of the energy: its unary cost and half its pairwise costs.

        Parameters
        ----------
        partners
            (N,) target point of each source point, `UNMATCHED` for none.

        Returns
        -------
        (N,) float64; their sum is :meth:`energy`.

        Raises
        ------
        ValueError
            `partners` uses a pair that is not a candidate, or a target point twice.
        """
        matched = np.flatnonzero(partners != UNMATCHED)
        targets = partners[matched]
        if len(np.unique(targets)) != len(targets):
            raise ValueError("a target point is used twice")
        unary = self.unary_matrix[matched, targets]
        if not np.isfinite(unary).all():
            raise ValueError("a matched pair is not a candidate")
        difference = (
            self.source_distances[np.ix_(matched, matched)]
            - self.target_distances[np.ix_(targets, targets)]
        )
        np.fill_diagonal(difference, 0.0)
        shares = np.full(self.n_sources, self.occlusion_cost, dtype=np.float64)
        shares[matched] = unary + 0.5 * self.beta * (difference**2).sum(axis=1)
        return shares

    def energy(self, partners: IntArray) -> float:
        """Value of (5), plus γ|X|, of a correspondence.

        Parameters
        ----------
        partners
            (N,) target point of each source point, `UNMATCHED` for none.

        Raises
        ------
        ValueError
            `partners` uses a pair that is not a candidate, or a target point twice.
        """
        return float(self.costs(partners).sum())


@kernel
def pairwise_cost(beta: float, source_distance: float, target_distance: float) -> float:
    """Second-order cost of two candidates in (5): β |d_X(x, x') − d_Y(y, y')|²."""
    difference = source_distance - target_distance
    return beta * difference * difference
