"""Equation (5): the correspondence problem as a binary labelling problem, section 4.

Labels are attached to *candidates*, the pairs of V ⊂ X × Y that may be matched. Each source point
takes one of its candidates or stays unmatched; each target point is used at most once.

The energy is (5) plus the constant γ|X|: the distortion of the matched points, and γ for every
unmatched source point. For distortions it is never negative, zero only for a perfect
correspondence, and its relative gap does not depend on γ|X|.

Pairwise costs have three forms, which add up: distortions of two metrics, computed from the two
distance matrices when they are needed; a table of all pairs of candidates, such as the likelihoods
of (6); and explicit terms on some pairs of candidates. Third-order costs are tables on triples of
source points (:mod:`solver.labelling.triples`).
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling.pairwise import (
    NO_TABLE,
    NO_TERMS,
    NO_WEIGHTS,
    PairwiseCosts,
    PairwiseTerms,
    pairwise_sums,
    pairwise_table,
)
from solver.labelling.triples import NO_TRIPLES, TripleCosts, costs_of_triples

UNMATCHED = -1
"""Marks a source point without a partner wherever an array holds partners."""


@dataclass(frozen=True, eq=False)
class LabellingProblem:
    """Problem (5) on a set of candidate pairs.

    Parameters
    ----------
    candidates
        (V, 2) indices (x, y) into the source and target points, each row once, in
        lexicographic order.
    unary
        (V,) first-order cost of each candidate: the weighted ‖f_X(x) − f_Y(y)‖.
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics d_X and d_Y between the sampled points.
    beta
        Weight β ≥ 0 of the second-order term; every unordered pair of candidates counts once.
    occlusion_cost
        γ ≥ 0, cost of an unmatched source point; ``inf`` when every one must be matched.
    terms
        Explicit pairwise costs, in addition to the metrics' distortions.
    table
        (V, V) symmetric costs of all pairs of candidates, in addition, or `NO_TABLE`; 0 where
        candidates exclude one another.
    triples
        Third-order costs of the candidates; a triple of which a point is unmatched costs nothing.
    weights
        (N, N) symmetric factors > 0 of β for two source points, or `NO_WEIGHTS` for 1.
    """

    candidates: IntArray
    unary: FloatArray
    source_distances: FloatArray
    target_distances: FloatArray
    beta: float = 1.0
    occlusion_cost: float = np.inf
    terms: PairwiseTerms = NO_TERMS
    table: FloatArray = field(default_factory=lambda: NO_TABLE)
    triples: TripleCosts = NO_TRIPLES
    weights: FloatArray = field(default_factory=lambda: NO_WEIGHTS)

    def __post_init__(self) -> None:
        count = len(self.candidates)
        if self.candidates.shape != (count, 2) or self.unary.shape != (count,):
            raise ValueError("candidates must be (V, 2) and unary costs (V,)")
        for distances in (self.source_distances, self.target_distances):
            if distances.ndim != 2 or distances.shape[0] != distances.shape[1]:
                raise ValueError("distances must be square matrices")
            if not np.isfinite(distances).all():
                raise ValueError("distances must be finite")
        if not np.isfinite(self.unary).all():
            raise ValueError("unary costs must be finite")
        if not (0.0 <= self.beta < np.inf) or not self.occlusion_cost >= 0.0:
            raise ValueError("beta must be finite and >= 0, the occlusion cost >= 0")
        if len(self.terms.first) and self.terms.second.max() >= count:
            raise ValueError("pairwise terms name candidates that do not exist")
        if len(self.table) and self.table.shape != (count, count):
            raise ValueError("the table must have a cost for every two candidates")
        if not np.isfinite(self.table).all():
            raise ValueError("tabulated costs must be finite")
        if count and (self.candidates.min() < 0 or (self.candidates >= self.shape).any()):
            raise ValueError("candidates name points that do not exist")
        if (np.diff(self._keys) <= 0).any():
            raise ValueError("candidates must be unique and in lexicographic order")
        self._check_weights()
        self._check_triples()

    def _check_weights(self) -> None:
        if not len(self.weights):
            return
        if self.weights.shape != self.source_distances.shape:
            raise ValueError("the weights must be those of every two source points")
        if not 0.0 < self.weights.min() <= self.weights.max() < np.inf:
            raise ValueError("weights must be finite and > 0")

    def _check_triples(self) -> None:
        third = self.triples
        if len(third.points) and not np.array_equal(third.rows, self.first_candidate):
            raise ValueError("third-order costs are of other candidates")

    @classmethod
    def explicit(
        cls,
        shape: tuple[int, int],
        candidates: IntArray,
        unary: FloatArray,
        terms: PairwiseTerms,
        occlusion_cost: float = np.inf,
    ) -> "LabellingProblem":
        """Return a problem without metrics, whose pairwise costs are all listed.

        Parameters
        ----------
        shape
            (N, M) numbers of source and target points.
        candidates, unary, terms, occlusion_cost
            As above.
        """
        source, target = (np.zeros((points, points)) for points in shape)
        return cls(candidates, unary, source, target, 0.0, occlusion_cost, terms)

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
        """(N, M), numbers of source and target points."""
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
    def beta_of_pairs(self) -> FloatArray:
        """(N, N) weight β of the distortion for two source points."""
        shape = self.source_distances.shape
        return self.beta * (self.weights if len(self.weights) else np.ones(shape))

    @cached_property
    def pairwise_costs(self) -> PairwiseCosts:
        """Pairwise costs in the form that compiled code takes."""
        first, other, cost = self.terms.adjacency(self.n_candidates)
        return PairwiseCosts(
            np.ascontiguousarray(self.candidates),  # else each kernel is compiled twice
            self.first_candidate,
            self.source_distances,
            self.target_distances,
            self.beta_of_pairs,
            first,
            other,
            cost,
            self.table,
        )

    @cached_property
    def non_negative(self) -> bool:
        """True if no cost is negative, as with distortions; then no energy is negative either."""
        costs = self.unary, self.terms.costs, self.table
        return all(bool(each.min(initial=0.0) >= 0.0) for each in costs)

    @cached_property
    def scale(self) -> float:
        """Upper bound of the magnitude of a single cost, γ apart: the unit of rounding errors."""
        farthest = max(
            self.source_distances.max(initial=0.0), self.target_distances.max(initial=0.0)
        )
        costs = self.unary, self.terms.costs, self.table, self.triples.costs
        largest = max(max(each.max(initial=0.0), -each.min(initial=0.0)) for each in costs)
        return float(max(largest, self.beta_of_pairs.max(initial=0.0) * farthest**2))

    @property
    def all_pairs_cost(self) -> bool:
        """Whether any two candidates may have a cost together, not only those of terms."""
        return self.beta > 0.0 or len(self.table) > 0 or len(self.triples.points) > 0

    def pairwise_matrix(self) -> FloatArray:
        """Pairwise cost of every two candidates: β |d_X(x, x') − d_Y(y, y')|², table and terms.

        Returns
        -------
        (V, V) float64, symmetric; ``inf`` for pairs that exclude one another (the same source or
        the same target point), 0 on the diagonal. Memory grows with V².
        """
        costs = pairwise_table(self.pairwise_costs)
        terms = self.terms
        np.add.at(costs, (terms.first, terms.second), terms.costs)
        np.add.at(costs, (terms.second, terms.first), terms.costs)
        return costs

    def among(self, kept: IntArray) -> "LabellingProblem":
        """Return the problem with some of the candidates, on the same points.

        Parameters
        ----------
        kept
            (V',) candidates, ascending.
        """
        table = self.table
        return replace(
            self,
            candidates=self.candidates[kept],
            unary=self.unary[kept],
            terms=self.terms.among(kept, self.n_candidates),
            table=np.ascontiguousarray(table[np.ix_(kept, kept)]) if len(table) else table,
            triples=self.triples.among(kept),
        )

    def chosen_candidates(self, partners: IntArray) -> IntArray:
        """Index of the candidate that each source point uses, -1 for none.

        Parameters
        ----------
        partners
            (N,) target point of each source point, `UNMATCHED` for none.

        Raises
        ------
        ValueError
            A matched pair is not a candidate, or a target point is used twice.
        """
        matched = partners != UNMATCHED
        targets = partners[matched]
        if len(np.unique(targets)) != len(targets):
            raise ValueError("a target point is used twice")
        if ((targets < 0) | (targets >= self.n_targets)).any():
            raise ValueError("a matched pair is not a candidate")
        wanted = np.arange(self.n_sources) * self.n_targets + partners
        place = np.minimum(np.searchsorted(self._keys, wanted), len(self._keys) - 1)
        if matched.any() and (
            len(self._keys) == 0 or (self._keys[place[matched]] != wanted[matched]).any()
        ):
            raise ValueError("a matched pair is not a candidate")
        return np.where(matched, place, UNMATCHED).astype(np.int64)

    @cached_property
    def _keys(self) -> IntArray:
        keys: IntArray = self.candidates[:, 0] * self.n_targets + self.candidates[:, 1]
        return keys

    def costs(self, partners: IntArray) -> FloatArray:
        """Each source point's share of the energy.

        It is its unary cost, half its pairwise costs, and a third of those of its triples.

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
        chosen = self.chosen_candidates(partners)
        used = chosen[chosen >= 0]
        shares = np.full(self.n_sources, self.occlusion_cost, dtype=np.float64)
        shares[chosen >= 0] = self.unary[used] + 0.5 * pairwise_sums(self.pairwise_costs, used)
        third = costs_of_triples(self.triples, chosen) / 3.0
        np.add.at(shares, self.triples.points, third[:, None])
        return shares

    def energy(self, partners: IntArray) -> float:
        """Equation (5), plus γ|X|: energy of a correspondence.

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
