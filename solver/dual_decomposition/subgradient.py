"""The projected subgradient method that joins the subproblems."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.dual_decomposition.duals import Duals
from solver.dual_decomposition.local import (
    add_local_subgradient,
    minimise_source_pairs,
    minimise_target_pairs,
)
from solver.labelling import UNMATCHED, LabellingProblem
from solver.primal import assign, local_search
from solver.solution import CERTIFIED_GAP, Method, Solution, relative_gap

_MOMENTUM = 0.9
_PATIENCE = 30
_SHORTER = 0.7
_SHORTEST = 0.02
_PROPOSAL_EVERY = 20


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
    iterations: int = 1000,
    gap: float = CERTIFIED_GAP,
    control: Control | None = None,
) -> DualSolution:
    """Solve problem (5) approximately, with a lower bound of its optimum.

    Steps have Polyak's length, towards the energy of the best correspondence known, along a
    direction that remembers the earlier ones (heavy ball); a bound that stagnates makes them
    shorter. The assignments of the linear subproblem, improved by local search, are proposals
    for the correspondence.

    Parameters
    ----------
    problem
        The labelling problem. Memory is 16 bytes times the square of its number of candidates.
    start
        (N,) correspondence to start from; by default the assignment of least unary cost.
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
        lowered by 1e-9 of the energy.

    Raises
    ------
    Cancelled
        Through `control`.
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """
    control = control or Control()
    state = _Decomposition(problem)
    partners = local_search(problem, assign(problem, problem.unary) if start is None else start)
    energy = problem.energy(partners)
    best, stalled, scale = 0.0, 0, 1.0
    bounds = []
    for iteration in range(iterations):
        control.check()
        if relative_gap(energy, best) <= gap or control.seconds_left() <= 0.0:
            break
        bound, proposal = state.evaluate()
        bound -= 1e-9 * energy
        stalled = 0 if bound > best + 1e-9 * energy else stalled + 1
        if bound > best:
            best = min(bound, energy)
        bounds.append(best)
        if iteration % _PROPOSAL_EVERY == 0 or (stalled == 0 and iteration % 5 == 0):
            improved = local_search(problem, proposal)
            if problem.energy(improved) < energy:
                partners, energy = improved, problem.energy(improved)
        if stalled >= _PATIENCE:
            scale, stalled = max(scale * _SHORTER, _SHORTEST), 0
        state.ascend(scale * max(energy - bound, 0.0))
    return DualSolution(
        partners, energy, best, len(bounds), Method.DUAL_DECOMPOSITION, np.array(bounds)
    )


class _Decomposition:
    """The subproblems of one labelling problem, their duals, and the way these move."""

    def __init__(self, problem: LabellingProblem) -> None:
        n, m = problem.shape
        self._problem = problem
        self._duals = Duals.halves(problem)
        self._direction = Duals.zeros(problem)
        targets = problem.candidates[:, 1]
        self._target_order = np.argsort(targets, kind="stable").astype(np.int64)
        self._target_first = np.searchsorted(targets[self._target_order], np.arange(m + 1)).astype(
            np.int64
        )
        # A target point may go without partner unless there are as many as source points, all
        # of which must be matched.
        self._targets_optional = not problem.must_match_all or m > n
        self._source_choices = np.full((n, n), -1, dtype=np.int64)
        self._target_choices = np.full((m, m), -1, dtype=np.int64)
        self._assigned: IntArray = np.full(n, UNMATCHED, dtype=np.int64)

    def evaluate(self) -> tuple[float, IntArray]:
        """Lower bound at the present duals, and the linear subproblem's assignment."""
        problem, duals = self._problem, self._duals
        linear = duals.linear_costs(problem.unary)
        self._assigned = assign(problem, linear)
        used = self._used_candidates()
        unmatched = problem.n_sources - len(used)
        bound = float(linear[used].sum())
        if unmatched:
            bound += unmatched * problem.occlusion_cost
        bound += minimise_source_pairs(
            problem.candidates,
            problem.first_candidate,
            duals.source_unary,
            duals.source_pairwise,
            not problem.must_match_all,
            self._source_choices,
        )
        bound += minimise_target_pairs(
            problem.candidates,
            self._target_first,
            self._target_order,
            problem.source_distances,
            problem.target_distances,
            problem.beta,
            duals.target_unary,
            duals.source_pairwise,
            self._targets_optional,
            self._target_choices,
        )
        return bound, self._assigned

    def _used_candidates(self) -> IntArray:
        """Indices of the candidates that the linear subproblem's assignment uses."""
        x, y = self._problem.candidates.T
        return np.flatnonzero(self._assigned[x] == y).astype(np.int64)

    def ascend(self, expected_gain: float) -> None:
        """Step along the remembered direction, turned towards the present subgradient."""
        direction = self._direction
        direction.scale(_MOMENTUM)
        used = self._used_candidates()
        sources, targets = self._problem.candidates[used].T
        direction.source_unary[used] -= 1.0
        direction.source_unary[used, sources] += 1.0
        direction.target_unary[used] -= 1.0
        direction.target_unary[used, targets] += 1.0
        add_local_subgradient(
            self._source_choices, 1.0, direction.source_unary, direction.source_pairwise
        )
        add_local_subgradient(
            self._target_choices, -1.0, direction.target_unary, direction.source_pairwise
        )
        norm = direction.squared_norm()
        if norm > 0.0:
            self._duals.step(expected_gain / norm, direction)
