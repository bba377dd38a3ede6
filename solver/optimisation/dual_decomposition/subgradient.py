"""The projected subgradient method that joins the subproblems."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import CERTIFIED_GAP, LabellingProblem, Method, Solution, relative_gap
from solver.optimisation.dual_decomposition.relaxation import Relaxation, Subproblems
from solver.optimisation.primal import assign, fuse, local_search
from solver.optimisation.reparametrisation import BoundingCosts

_PATIENCE = 15
_SHORTER = 0.7
_LONGER = 1.02
_SHORTEST = 0.005
_TRIPLES_BELOW = 0.1
"""Triples are added once steps are so short: before, the pairs still have much to gain."""
_PROPOSAL_EVERY = 20
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class DualSolution(Solution):
    """A solution with the history of its lower bound.

    Parameters
    ----------
    bounds
        (iterations,) best lower bound after each iteration; it never falls.
    """

    bounds: FloatArray


def dual_decomposition(
    problem: LabellingProblem,
    start: IntArray | None = None,
    *,
    subproblems: Subproblems | None = None,
    iterations: int = 1000,
    gap: float = CERTIFIED_GAP,
    control: Control | None = None,
) -> DualSolution:
    """Solve problem (5) approximately, with a lower bound of its optimum.

    Parameters
    ----------
    problem, start, subproblems
        See :class:`DualDecomposition`.
    iterations
        Limit on the iterations.
    gap
        Relative gap at which to stop.
    control
        Cancels, or ends the iterations at a deadline.

    Returns
    -------
    DualSolution
        ``lower_bound <= optimum <= energy``, up to rounding errors, for which the bound is
        lowered by 1e-9 of the energy. Without an iteration the bound is 0 where no cost is
        negative, else minus infinity.

    Raises
    ------
    Cancelled
        Through `control`.
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """
    decomposition = DualDecomposition(problem, start, subproblems)
    decomposition.run(iterations, gap, control)
    return decomposition.solution()


class DualDecomposition:
    """A dual decomposition under way.

    Steps have Polyak's length, towards the energy of the best correspondence known, along a
    direction that remembers the earlier ones (heavy ball). They grow while the bound rises above
    its recent best, and are cut when it has not for some time. The assignments of the linear
    subproblem, improved by local search and fused with the best one, are proposals for the
    correspondence.

    Parameters
    ----------
    problem
        The labelling problem. Memory is some 50 bytes for every pair of candidates that has a
        pairwise cost, with metrics about every one of the V²/2, and 40 V (N + M).
    start
        (N,) correspondence to start from; by default the assignment of least unary cost.
    subproblems
        What the energy is split into; by default the linear subproblem and the local ones of
        both sides, which give the best bound for their time.

    Attributes
    ----------
    partners, energy
        The best correspondence so far.
    lower_bound
        The best bound so far.

    Raises
    ------
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """

    def __init__(
        self,
        problem: LabellingProblem,
        start: IntArray | None = None,
        subproblems: Subproblems | None = None,
    ) -> None:
        self._problem = problem
        if start is None:
            start = assign(problem, problem.unary)
        self.partners: IntArray = local_search(problem, start)
        self.energy = problem.energy(self.partners)
        self.lower_bound = 0.0 if problem.non_negative else -np.inf
        self._relaxation = Relaxation(problem, subproblems or Subproblems())
        self._bounds: list[float] = []
        self._stalled, self._scale, self._recent_best = 0, 1.0, -np.inf

    @property
    def gap(self) -> float:
        """Relative gap so far."""
        return relative_gap(self.energy, self.lower_bound)

    def run(
        self, iterations: int, gap: float = CERTIFIED_GAP, control: Control | None = None
    ) -> None:
        """Go on for some iterations, until a gap is reached or the deadline passed.

        Raises
        ------
        Cancelled
            Through `control`.
        """
        control = control or Control()
        for _ in range(iterations):
            control.check()
            if self.gap <= gap or control.seconds_left() <= 0.0:
                return
            self._iterate()

    def solution(self) -> DualSolution:
        """Return the best correspondence and bound so far."""
        return DualSolution(
            self.partners,
            self.energy,
            self.lower_bound,
            len(self._bounds),
            Method.DUAL_DECOMPOSITION,
            np.array(self._bounds),
        )

    def improve(self, partners: IntArray) -> None:
        """Fuse the best correspondence with another one and search around the result."""
        fused = fuse(self._problem, self.partners, local_search(self._problem, partners))
        if self._problem.energy(fused) < self.energy:
            self.partners = local_search(self._problem, fused)
            self.energy = self._problem.energy(self.partners)

    def learn_bound(self, bound: float) -> None:
        """Take note of a lower bound that is known from elsewhere."""
        self.lower_bound = max(self.lower_bound, min(bound, self.energy))

    def bounding_costs(self) -> BoundingCosts:
        """Return the present relaxation's costs, to prune an exact search with.

        Memory is 8 bytes times the square of the number of candidates.
        """
        self._relaxation.minimise()
        return self._relaxation.bounding_costs()

    def _iterate(self) -> None:
        bound = self._relaxation.minimise()
        rounding = _ROUNDING * abs(self.energy)
        rises = bound > self._recent_best + 2.0 * rounding
        self.lower_bound = max(self.lower_bound, min(bound - rounding, self.energy))
        if len(self._bounds) % _PROPOSAL_EVERY == 0 or (rises and len(self._bounds) % 5 == 0):
            self.improve(self._relaxation.linear.partners)
        self._bounds.append(self.lower_bound)
        self._pace(bound, rises)
        self._relaxation.ascend(self._scale * max(self.energy - bound, 0.0))

    def _pace(self, bound: float, rises: bool) -> None:
        """Lengthen or shorten the steps, and bring in triples when they have become short.

        A bound is held against the best since the last cut, not against the best of all: after a
        step that went too far, what matters is whether the bound recovers.
        """
        if rises:
            self._stalled, self._recent_best = 0, bound
            self._scale = min(self._scale * _LONGER, 1.0)
            return
        self._stalled += 1
        if self._stalled >= _PATIENCE:
            self._stalled, self._recent_best = 0, bound
            self._scale = max(self._scale * _SHORTER, _SHORTEST)
            if self._scale < _TRIPLES_BELOW:
                self._relaxation.add_triples()
