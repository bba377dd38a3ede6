"""Minimisation of the energy (5): the best answer that size and time allow, with its proof.

Branch and bound with the bounds of a dual ascent proves most problems of a match. What it leaves
open is decomposed, with the candidates that are left; the dual decomposition, local search and a
further exact search take turns. With the reparametrised costs of the decomposition, an exact search
often needs thousands of nodes where it would need millions with its own.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solver.arrays import IntArray
from solver.control import Control, Status, iterate
from solver.labelling import CERTIFIED_GAP, LabellingProblem, Method, Solution
from solver.optimisation.dual_decomposition import DualDecomposition, DualState
from solver.optimisation.exact import FEW_POINTS, Enumeration, m_best_solutions
from solver.optimisation.primal import (
    IteratedLocalSearch,
    improved,
    solve_lap,
)

_FEW_ROUNDS, _ROUNDS = 4, 40
"""Rounds of the dual ascent, of small and of larger problems."""
_OPERATIONS_PER_SECOND = 600_000_000
"""Operations of a search in a second on one core: candidates of each node, and of each triple."""
_PER_TRIPLE = 2
"""Operations of a triple at a node, per candidate."""
_SEARCH_CANDIDATES = 1500
"""Candidates up to which an exact search is tried; its costs take 36 MB."""
_SEARCH_GAP = 0.25
"""Relative gap above which a search with the decomposition's costs is not tried, if not small."""
_FIRST_TURN = 100
"""Iterations of the dual decomposition before local search; they double from turn to turn."""
_NODES_PER_ITERATION = 100
"""Search nodes of a turn, per iteration so far: the two take about equal time."""
_WIDE_GAP = 0.05
"""Relative gap above which the correspondence rather than the bound may be at fault."""
_FEW_SEARCHES, _MANY_SEARCHES = 0.05, 2.0
"""Local searches of a turn, per iteration so far."""


def minimise(
    problem: LabellingProblem,
    start: IntArray | None = None,
    *,
    iterations: int = 2000,
    search_seconds: float = 0.5,
    gap: float = CERTIFIED_GAP,
    control: Control | None = None,
) -> Solution[IntArray]:
    """Solve problem (5): exactly where that is possible, else with a lower bound.

    Parameters
    ----------
    problem
        The labelling problem.
    start
        (N,) a good correspondence, if one is known.
    iterations
        Limit on the iterations of the dual decomposition; searches in turn with it take about as
        long.
    search_seconds
        Limit on the search before the decomposition, in seconds of a typical core; its nodes are
        counted.
    gap
        Relative gap that suffices.
    control
        Cancels; at its deadline the best answer so far is returned with its bound.

    Returns
    -------
    Solution
        ``lower_bound <= optimum <= value``; both equal where a search has proven the optimum.

    Raises
    ------
    Cancelled
        Through `control`.
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.

    Examples
    --------
    A triangle and its mirror image, all nine pairs being candidates:

    >>> import numpy as np
    >>> source = np.array([[0.0, 3.0, 4.0], [3.0, 0.0, 5.0], [4.0, 5.0, 0.0]])
    >>> target = np.ascontiguousarray(source[::-1, ::-1])
    >>> pairs = np.argwhere(np.ones((3, 3)))
    >>> found = minimise(LabellingProblem(pairs, np.zeros(9), source, target))
    >>> found.answer.tolist(), found.value, found.gap
    ([2, 1, 0], 0.0, 0.0)
    """
    control = control or Control()
    if not problem.n_candidates:
        return _without_candidates(problem)
    searched = _search_first(problem, start, search_seconds, control)
    if searched.proven and len(searched):
        return searched[0]
    problem, start = _reduce(problem, start, searched)
    method = DualDecomposition(problem, start, gap=gap, lower_bound=searched.lower_bound)
    return _take_turns(problem, method, iterations, control)


def _without_candidates(problem: LabellingProblem) -> Solution[IntArray]:
    """No point is matched, where that is allowed."""
    unmatched = solve_lap(problem, problem.unary)
    energy = problem.energy(unmatched)
    return Solution(unmatched, energy, energy, 0, Method.BRANCH_AND_BOUND)


def _search_first(
    problem: LabellingProblem, start: IntArray | None, seconds: float, control: Control
) -> Enumeration:
    """Exact search with the costs of a dual ascent, of problems that are small enough for it."""
    count = problem.n_candidates
    if count > _SEARCH_CANDIDATES or control.expired:
        nothing = np.empty((0, problem.n_sources), dtype=np.int64), np.empty(0)
        return Enumeration(*nothing, -np.inf, 0, Status.DEADLINE, np.arange(count))
    rounds = _FEW_ROUNDS if problem.n_sources <= FEW_POINTS else _ROUNDS
    work = count * (1 + _PER_TRIPLE * len(problem.triples.points))
    limit = int(seconds * _OPERATIONS_PER_SECOND) // work
    return m_best_solutions(problem, known=start, rounds=rounds, node_limit=limit, control=control)


def _reduce(
    problem: LabellingProblem, start: IntArray | None, searched: Enumeration
) -> tuple[LabellingProblem, IntArray | None]:
    """Keep the candidates of the best solution found, and those of any better one."""
    if not len(searched):
        return problem, start
    best = searched[0].answer
    used = problem.chosen_candidates(best)
    return problem.among(np.union1d(searched.candidates, used[used >= 0])), best


def _take_turns(
    problem: LabellingProblem, method: DualDecomposition, iterations: int, control: Control
) -> Solution[IntArray]:
    """Dual decomposition, local search and exact search with its costs, in turns."""
    ended = iterate(method, 0, control)
    local = IteratedLocalSearch(problem, ended.state.incumbent.partners)
    for done, limit in _turns(iterations):
        ended = iterate(method, limit - done, control, ended.state)
        state = ended.state
        if ended.status is not Status.ITERATIONS:
            break
        searches = _local_searches(problem, state.gap, limit)
        found = iterate(local, searches, control, state.incumbent).state
        state.incumbent = improved(problem, state.incumbent, found.partners)
        if _searchable(problem, state.gap) and _search(problem, state, limit, control):
            proven = state.incumbent.energy
            solution = state.solution(Status.CONVERGED)
            return replace(solution, lower_bound=proven, method=Method.BRANCH_AND_BOUND)
    return ended.state.solution(ended.status)


def _turns(iterations: int) -> Iterator[tuple[int, int]]:
    """Iterations before and after each turn, which double."""
    done, limit = 0, _FIRST_TURN
    while done < iterations:
        yield done, min(limit, iterations)
        done, limit = limit, 2 * limit


def _local_searches(problem: LabellingProblem, gap: float, iterations: int) -> int:
    """Steps of the iterated local search in a turn, after so many iterations.

    Where every point may go almost anywhere, local search has many optima, and a wide gap may be
    the fault of the correspondence.
    """
    anywhere = 2 * problem.n_candidates >= problem.n_sources * problem.n_targets
    doubtful = anywhere and problem.n_sources > FEW_POINTS and gap > _WIDE_GAP
    return int((_MANY_SEARCHES if doubtful else _FEW_SEARCHES) * iterations)


def _searchable(problem: LabellingProblem, gap: float) -> bool:
    """Return whether an exact search with the decomposition's costs may succeed."""
    few = problem.n_sources <= FEW_POINTS
    return problem.n_candidates <= _SEARCH_CANDIDATES and (few or gap <= _SEARCH_GAP)


def _search(problem: LabellingProblem, state: DualState, iterations: int, control: Control) -> bool:
    """Search with the decomposition's costs; return whether the incumbent is optimal now."""
    found = m_best_solutions(
        problem,
        known=state.incumbent.partners,
        reparametrised=state.reparametrised_costs(),
        node_limit=_NODES_PER_ITERATION * iterations,
        control=control,
    )
    state.incumbent = improved(problem, state.incumbent, found[0].answer)
    return found.proven
