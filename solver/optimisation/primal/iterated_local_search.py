"""Local search again and again, from greedy starts and from kicks out of the best optimum."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import UNMATCHED, LabellingProblem, PairwiseCosts, replace_costs
from solver.optimisation.primal.local_search import local_search, partners_of

_SEED = 7333
_RANDOM_POINTS = 2


class IteratedLocalSearch:
    """Greedy starts from random points in turn with kicks of the best correspondence known.

    Starts find the region of the optimum, kicks what is best within it; which of the two a problem
    needs is not known beforehand. They are drawn from a fixed seed: the same problem is searched in
    the same way every time.

    Parameters
    ----------
    problem
        The labelling problem.
    partners
        (N,) correspondence to begin with.

    Attributes
    ----------
    partners, energy
        The best correspondence so far.
    """

    def __init__(self, problem: LabellingProblem, partners: IntArray) -> None:
        self._problem = problem
        self._random = np.random.default_rng(_SEED)
        self.partners = partners
        self.energy = problem.energy(partners)

    def run(self, rounds: int) -> bool:
        """Start anew and kick once in each round; return whether anything better was found."""
        before = self.energy
        for _ in range(rounds):
            self._try(self._start())
            self._try(self._kick())
        return self.energy < before

    def offer(self, partners: IntArray) -> None:
        """Go on from another correspondence if that is better."""
        energy = self._problem.energy(partners)
        if energy < self.energy:
            self.partners, self.energy = partners, energy

    def _try(self, start: IntArray) -> None:
        found = local_search(self._problem, start)
        if not (self._problem.must_match_all and (found == UNMATCHED).any()):
            self.offer(found)

    def _start(self) -> IntArray:
        problem = self._problem
        order = self._random.permutation(problem.n_sources).astype(np.int64)
        draws = self._random.random(_RANDOM_POINTS)
        chosen = _greedy_start(
            problem.pairwise_costs, problem.unary, float(problem.occlusion_cost), order, draws
        )
        return partners_of(problem, chosen)

    def _kick(self) -> IntArray:
        problem = self._problem
        strength = int(self._random.integers(2, max(3, problem.n_sources // 4) + 1))
        return _kicked(
            problem.candidates,
            problem.first_candidate,
            self.partners,
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
    """Candidate of each point: at random for the first points, then what costs least beside them.

    Of two metrics' distortions, a few points that happen to be right carry all others along.
    """
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
def _kicked(
    candidates: IntArray,
    first: IntArray,
    partners: IntArray,
    n_targets: int,
    draws: FloatArray,
) -> IntArray:
    """Some points take random candidates; who loses a target point takes the one left, if it may.

    Each of the (k, 2) draws is a source point and one of its candidates, as parts of one.
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
