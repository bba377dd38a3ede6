"""Iterated local search: from randomised greedy starts and from perturbed incumbents."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import UNMATCHED, LabellingProblem, PairwiseCosts, replace_costs
from solver.optimisation.primal.incumbent import Incumbent
from solver.optimisation.primal.local_search import local_search, partners_of

_SEED = 7333
_RANDOM_POINTS = 2
"""Points of a greedy start that take a random candidate: a few right ones fix all others."""


class IteratedLocalSearch:
    """Iterated local search (Lourenço, Martin and Stützle 2003) as an iterative method.

    Each step searches once from a randomised greedy start, which finds the region of the optimum,
    and once from a perturbation of the incumbent, which finds the best correspondence within it;
    a problem may need either. Draws are from a fixed seed, so that the same problem is always
    searched in the same way.

    Parameters
    ----------
    problem
        The labelling problem.
    partners
        (N,) correspondence to begin with.
    """

    def __init__(self, problem: LabellingProblem, partners: IntArray) -> None:
        self._problem, self._partners = problem, partners
        self._random = np.random.default_rng(_SEED)

    def init(self) -> Incumbent:
        """Return the given correspondence."""
        return Incumbent.of(self._problem, self._partners)

    def step(self, state: Incumbent) -> Incumbent:
        """Search from a greedy start, then from a perturbation of the incumbent."""
        state = self._better(state, self._greedy_start())
        return self._better(state, self._perturbation(state.partners))

    def done(self, state: Incumbent) -> bool:
        """Return false: it is not known when the incumbent is optimal."""
        return False

    def _better(self, incumbent: Incumbent, start: IntArray) -> Incumbent:
        found = local_search(self._problem, start)
        if self._problem.must_match_all and (found == UNMATCHED).any():
            return incumbent
        other = Incumbent.of(self._problem, found)
        return other if other.energy < incumbent.energy else incumbent

    def _greedy_start(self) -> IntArray:
        problem = self._problem
        order = self._random.permutation(problem.n_sources).astype(np.int64)
        draws = self._random.random(_RANDOM_POINTS)
        chosen = _greedy_start(
            problem.pairwise_costs, problem.unary, float(problem.occlusion_cost), order, draws
        )
        return partners_of(problem, chosen)

    def _perturbation(self, partners: IntArray) -> IntArray:
        problem = self._problem
        strength = int(self._random.integers(2, max(3, problem.n_sources // 4) + 1))
        return _perturbed(
            problem.candidates,
            problem.first_candidate,
            partners,
            problem.n_targets,
            self._random.random((strength, 2)),
        )


@kernel
def _greedy_start(
    costs: PairwiseCosts,
    unary: FloatArray,
    occlusion_cost: float,
    order: IntArray,
    draws: FloatArray,
) -> IntArray:
    """Candidate of each point: random for the first points, then the one of least marginal cost."""
    candidates, rows = costs.candidates, costs.rows
    chosen = np.full(len(order), -1, dtype=np.int64)
    taken = np.zeros(costs.target_distances.shape[0], dtype=np.bool_)
    marginal = unary.copy()
    for k in range(len(order)):
        x = order[k]
        first, last = rows[x], rows[x + 1]
        best, least = -1, occlusion_cost
        if k < len(draws) and last > first:
            a = first + int(draws[k] * (last - first))
            if not taken[candidates[a, 1]]:
                best = a
        if best < 0:
            for a in range(first, last):
                if marginal[a] < least and not taken[candidates[a, 1]]:
                    best, least = a, marginal[a]
        if best >= 0:
            chosen[x] = best
            taken[candidates[best, 1]] = True
            replace_costs(costs, x, -1, best, marginal)
    return chosen


@kernel
def _perturbed(
    candidates: IntArray,
    first: IntArray,
    partners: IntArray,
    n_targets: int,
    draws: FloatArray,
) -> IntArray:
    """Give random candidates to some points; a point that loses its target takes the vacated one.

    Each of the (k, 2) draws in [0, 1) selects a source point and one of its candidates. A point
    for which the vacated target is not a candidate becomes unmatched.
    """
    partners = partners.copy()
    owner = np.full(n_targets, -1, dtype=np.int64)
    for x in range(len(partners)):
        if partners[x] >= 0:
            owner[partners[x]] = x
    for k in range(len(draws)):
        x = int(draws[k, 0] * len(partners))
        count = first[x + 1] - first[x]
        if count == 0:
            continue
        y = candidates[first[x] + int(draws[k, 1] * count), 1]
        left, loser = partners[x], owner[y]
        if loser == x:
            continue
        if left >= 0:
            owner[left] = -1
        if loser >= 0:
            partners[loser] = -1
            for a in range(first[loser], first[loser + 1]):
                if left >= 0 and candidates[a, 1] == left:
                    partners[loser] = left
                    owner[left] = loser
        partners[x] = y
        owner[y] = x
    return partners
