"""Projected subgradient method for the lower bound of a relaxation."""

from dataclasses import dataclass, field

import numpy as np

from solver.arrays import IntArray
from solver.control import Status
from solver.labelling import CERTIFIED_GAP, LabellingProblem, Method, Solution, relative_gap
from solver.optimisation.dual_decomposition.reduced_costs import SUM_ROUNDING
from solver.optimisation.dual_decomposition.relaxation import Relaxation, Subproblems
from solver.optimisation.primal import Incumbent, improved, local_search, solve_lap
from solver.optimisation.reparametrisation import ReparametrisedCosts

_STALL_LIMIT = 15
"""Iterations without a rise after which steps are shortened."""
_SHORTEN, _LENGTHEN = 0.7, 1.02
"""Factors on the step after a stall, and after an iteration that raises the bound."""
_LEAST_FACTOR = 0.005
"""Steps are shortened no further."""
_PROPOSAL_PERIOD, _RISING_PROPOSAL_PERIOD = 20, 5
"""Iterations between two proposals for the correspondence; the second while the bound rises."""


@dataclass
class PolyakStep:
    """Polyak's step length with an adaptive factor.

    The bound is compared with the best one since the steps were last shortened, not with the best
    of all: after a step that went too far, it matters whether the bound recovers.

    Parameters
    ----------
    factor
        Factor on Polyak's length, in (0, 1].
    stalled
        Iterations since the bound last rose.
    best
        Best bound since the steps were last shortened.
    """

    factor: float = 1.0
    stalled: int = 0
    best: float = -np.inf

    def update(self, bound: float, rises: bool) -> None:
        """Adapt the factor to the bound of an iteration."""
        self.stalled += 1
        if rises:
            self.stalled, self.best = 0, bound
            self.factor = min(self.factor * _LENGTHEN, 1.0)
        elif self.stalled == _STALL_LIMIT:
            self.stalled, self.best = 0, bound
            self.factor = max(self.factor * _SHORTEN, _LEAST_FACTOR)


@dataclass(eq=False)
class DualState:
    """State of a dual decomposition; steps change it in place.

    Parameters
    ----------
    relaxation
        The subproblems, with the present division of the costs.
    incumbent
        The best correspondence so far.
    lower_bound
        The best bound so far.
    step
        Step length.
    history
        Best bound after each iteration; it never falls.
    """

    relaxation: Relaxation
    incumbent: Incumbent
    lower_bound: float
    step: PolyakStep = field(default_factory=PolyakStep)
    history: list[float] = field(default_factory=list)

    @property
    def gap(self) -> float:
        """Relative gap so far."""
        return relative_gap(self.incumbent.energy, self.lower_bound)

    def solution(self, status: Status) -> Solution[IntArray]:
        """Return the best correspondence and bound so far.

        The bound is lowered by 1e-9 of the energy, for rounding errors. Without an iteration it is
        0 where no cost is negative, else minus infinity, or the one that was known.
        """
        return Solution(
            self.incumbent.partners,
            self.incumbent.energy,
            self.lower_bound,
            len(self.history),
            Method.DUAL_DECOMPOSITION,
            status,
            tuple(self.history),
        )

    def reparametrised_costs(self) -> ReparametrisedCosts:
        """Return the costs as they are divided at present, for lower bounds of an exact search.

        Memory is 8 bytes times the square of the number of candidates.
        """
        self.relaxation.minimise()
        return self.relaxation.reparametrised_costs()


class DualDecomposition:
    """Dual decomposition as an iterative method: problem, subproblems, and step rule.

    Steps have Polyak's length (Polyak 1969), towards the energy of the incumbent, along a
    heavy-ball direction. The assignments of the linear subproblem, improved by local search and
    fused with the incumbent, are proposals for the correspondence.

    Parameters
    ----------
    problem
        The labelling problem. Memory is some 50 bytes for every pair of candidates that has a
        pairwise cost, with metrics about every one of the V²/2, and 40 V (N + M).
    start
        (N,) correspondence to start from; by default the assignment of least unary cost.
    subproblems
        Split of the energy; by default the linear subproblem and the pairs of both shapes, which
        give the best bound for their time (``python -m bench.solver``).
    gap
        Relative gap that suffices.
    lower_bound
        A lower bound of the optimum, if one is known.

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
        *,
        gap: float = CERTIFIED_GAP,
        lower_bound: float = -np.inf,
    ) -> None:
        self._problem, self._subproblems = problem, subproblems or Subproblems()
        self._start = solve_lap(problem, problem.unary) if start is None else start
        self._gap, self._lower_bound = gap, lower_bound

    def init(self) -> DualState:
        """Return the state before the first iteration, in which costs are divided evenly."""
        problem = self._problem
        incumbent = Incumbent.of(problem, local_search(problem, self._start))
        bound = max(self._lower_bound, 0.0 if problem.non_negative else -np.inf)
        relaxation = Relaxation(problem, self._subproblems)
        return DualState(relaxation, incumbent, min(bound, incumbent.energy))

    def step(self, state: DualState) -> DualState:
        """Compute the bound of the present division, and take a subgradient step."""
        relaxation, rule, count = state.relaxation, state.step, len(state.history)
        energy = state.incumbent.energy
        bound = relaxation.minimise()
        rounding = SUM_ROUNDING * abs(energy)
        rises = bound > rule.best + 2.0 * rounding
        state.lower_bound = max(state.lower_bound, min(bound - rounding, energy))
        period = _RISING_PROPOSAL_PERIOD if rises else _PROPOSAL_PERIOD
        if count % period == 0:
            proposal = relaxation.linear.partners
            state.incumbent = improved(self._problem, state.incumbent, proposal)
        state.history.append(state.lower_bound)
        rule.update(bound, rises)
        relaxation.ascend(rule.factor * max(state.incumbent.energy - bound, 0.0))
        return state

    def done(self, state: DualState) -> bool:
        """Return whether the gap suffices."""
        return state.gap <= self._gap
