"""Reparametrised costs for lower bounds."""

from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import NO_TRIPLES, LabellingProblem, TripleCosts
from solver.optimisation.rounding import allowance


class ReparametrisedCosts(NamedTuple):
    """Costs that add up to no more than the energy, for every correspondence of a problem.

    A reparametrisation moves costs between unary and pairwise terms, and into a constant, without
    raising the energy of any correspondence; the greater the constant, the better the lower bound.

    Attributes
    ----------
    constant
        Cost of every correspondence.
    unary
        (V,) cost of each candidate.
    pairwise
        (V, V) symmetric cost of every two candidates, ``inf`` where they exclude one another.
    occlusion
        (N,) cost of leaving each source point unmatched, ``inf`` where that is forbidden.
    scale
        Of the problem's own costs, for the rounding errors of sums of these.
    triples
        Third-order costs, never negative, so that bounds may leave them out.
    """

    constant: float
    unary: FloatArray
    pairwise: FloatArray
    occlusion: FloatArray
    scale: float
    triples: TripleCosts = NO_TRIPLES

    @classmethod
    def of(cls, problem: LabellingProblem) -> "ReparametrisedCosts":
        """Return the problem's own costs."""
        occlusion = np.full(problem.n_sources, float(problem.occlusion_cost))
        pairwise = problem.pairwise_matrix()
        return cls(0.0, problem.unary, pairwise, occlusion, problem.scale, problem.triples)

    def promising(self, rows: IntArray, limit: float) -> IntArray:
        """Candidates that a correspondence below a limit may use.

        The cost of a candidate with the best choice of each other point, on its own, is a lower
        bound of all correspondences that use it, unless pairwise costs are negative: then all
        candidates are returned. Time is O(V²).

        Parameters
        ----------
        rows
            (N+1,) candidates of each source point.
        limit
            Upper bound of the energy, exclusive.

        Returns
        -------
        (V',) ascending.
        """
        if np.isinf(limit):
            return np.arange(len(self.unary))
        rounding = allowance(limit, self.scale)
        if self.pairwise.min(initial=0.0) < -rounding:
            return np.arange(len(self.unary))
        return np.flatnonzero(self.constant + _least_with_each(self, rows) < limit - rounding)

    def among(self, kept: IntArray) -> "ReparametrisedCosts":
        """Return the costs of some of the candidates."""
        pairwise = costs_among(self.pairwise, kept)
        triples = self.triples.among(kept)
        return self._replace(unary=self.unary[kept], pairwise=pairwise, triples=triples)


@kernel
def costs_among(costs: FloatArray, kept: IntArray) -> FloatArray:
    """Rows and columns of some candidates."""
    found = np.empty((len(kept), len(kept)))
    for i in range(len(kept)):
        row = costs[kept[i]]
        for j in range(len(kept)):
            found[i, j] = row[kept[j]]
    return found


@kernel
def _least_with_each(costs: ReparametrisedCosts, rows: IntArray) -> FloatArray:
    """(V,) cost of each candidate with the best choice of each other point."""
    unary, pairwise, occlusion = costs.unary, costs.pairwise, costs.occlusion
    total, least = np.zeros(len(unary)), np.empty(len(unary))
    for y in range(len(rows) - 1):
        least[:] = occlusion[y]
        for b in range(rows[y], rows[y + 1]):
            row, cost = pairwise[b], unary[b]
            for a in range(len(row)):
                least[a] = min(least[a], row[a] + cost)
        least[rows[y] : rows[y + 1]] = unary[rows[y] : rows[y + 1]]
        total += least
    return total
