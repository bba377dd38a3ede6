"""The best answer to one labelling problem that its size and the time allow, with its proof.

Branch and bound with the bounds of a dual ascent proves most of what a match asks for. Else, with
the candidates that are left, the dual decomposition and the search work together: the decomposition
moves costs to where they bound, and a search that prunes with these costs often proves within
thousands of nodes what millions of its own would not.
"""

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.labelling import CERTIFIED_GAP, LabellingProblem, Method, Solution
from solver.optimisation.dual_decomposition import DualDecomposition, Subproblems
from solver.optimisation.exact import ExactSolutions, m_best_solutions
from solver.optimisation.primal import IteratedLocalSearch, assign, local_search

_PLAIN_POINTS = 16
"""Up to this many source points count as few."""
_FEW_ROUNDS, _ROUNDS = 4, 40
"""Of the dual ascent, with up to so many source points and with more."""
_PLAIN_WORK = 300_000_000
"""Nodes times candidates of the search before any dual decomposition: some 0.5 s."""
_SEARCH_CANDIDATES = 1500
"""Up to this many candidates a search with the decomposition's costs is tried: 36 MB."""
_SEARCH_GAP = 0.25
"""Above this gap a search has no chance yet, unless there are very few points."""
_FIRST_ROUND = 100
_NODES_PER_ITERATION = 100
_WIDE_GAP = 0.05


def minimise(
    problem: LabellingProblem,
    start: IntArray | None = None,
    *,
    iterations: int = 2000,
    gap: float = CERTIFIED_GAP,
    subproblems: Subproblems | None = None,
    control: Control | None = None,
) -> Solution:
    """Solve problem (5): exactly where that can be done, else with a bound.

    Parameters
    ----------
    problem
        The labelling problem.
    start
        (N,) a good correspondence, if one is known.
    iterations
        Limit on the iterations of the dual decomposition; searches take about as long.
    gap
        Relative gap that suffices.
    subproblems
        Of the dual decomposition.
    control
        Cancels; at its deadline the best answer so far is returned with its bound.

    Returns
    -------
    Solution
        ``lower_bound <= optimum <= energy``; both equal where the optimum was proven by a search.

    Raises
    ------
    Cancelled
        Through `control`.
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """
    control = control or Control()
    if not problem.n_candidates:
        nobody = local_search(problem, assign(problem, problem.unary))
        energy = problem.energy(nobody)
        return Solution(nobody, energy, energy, 0, Method.BRANCH_AND_BOUND)
    bound = -np.inf
    if problem.n_candidates <= _SEARCH_CANDIDATES and control.seconds_left() > 0.0:
        found = _search_first(problem, start, control)
        if found.proven and len(found.energies):
            energy = float(found.energies[0])
            return Solution(found.partners[0], energy, energy, found.nodes, Method.BRANCH_AND_BOUND)
        if len(found.partners):
            start, bound = found.partners[0], found.lower_bound
            used = problem.chosen_candidates(start)
            problem = problem.among(np.union1d(found.candidates, used[used >= 0]))
    decomposition = DualDecomposition(problem, start, subproblems)
    decomposition.learn_bound(bound)
    return _decompose(problem, decomposition, iterations, gap, control)


def _decompose(
    problem: LabellingProblem,
    decomposition: DualDecomposition,
    iterations: int,
    gap: float,
    control: Control,
) -> Solution:
    """Let the dual decomposition, local search and searches with its costs take turns."""
    primal = IteratedLocalSearch(problem, decomposition.partners)
    done, until = 0, _FIRST_ROUND
    while done < iterations:
        decomposition.run(min(until, iterations) - done, gap, control)
        done, until = min(until, iterations), 2 * until
        if decomposition.gap <= gap or control.seconds_left() <= 0.0:
            break
        primal.offer(decomposition.partners)
        if primal.run(_rounds(problem, decomposition.gap, done)):
            decomposition.improve(primal.partners)
        nodes = _NODES_PER_ITERATION * done
        if _promising(problem, decomposition.gap) and _search(
            problem, decomposition, nodes, control
        ):
            energy = decomposition.energy
            return Solution(decomposition.partners, energy, energy, done, Method.BRANCH_AND_BOUND)
    return decomposition.solution()


def _search_first(
    problem: LabellingProblem, start: IntArray | None, control: Control
) -> ExactSolutions:
    """Search with the costs of a dual ascent for about as long as that takes."""
    count = problem.n_candidates
    rounds = _FEW_ROUNDS if problem.n_sources <= _PLAIN_POINTS else _ROUNDS
    return m_best_solutions(
        problem, known=start, rounds=rounds, node_limit=_PLAIN_WORK // count, control=control
    )


def _promising(problem: LabellingProblem, gap: float) -> bool:
    few = problem.n_sources <= _PLAIN_POINTS
    return problem.n_candidates <= _SEARCH_CANDIDATES and (few or gap <= _SEARCH_GAP)


def _rounds(problem: LabellingProblem, gap: float, iterations: int) -> int:
    """How often to look for a better correspondence, after so many iterations and with such a gap.

    Where every point may go almost anywhere local search has many optima, and a wide gap may be the
    correspondence's fault.
    """
    anywhere = 2 * problem.n_candidates >= problem.n_sources * problem.n_targets
    doubtful = anywhere and problem.n_sources > _PLAIN_POINTS and gap > _WIDE_GAP
    return 2 * iterations if doubtful else iterations // 20


def _search(
    problem: LabellingProblem, decomposition: DualDecomposition, nodes: int, control: Control
) -> bool:
    """Search with the decomposition's costs; return whether the optimum is known now."""
    found = m_best_solutions(
        problem,
        known=decomposition.partners,
        bounding=decomposition.bounding_costs(),
        node_limit=nodes,
        control=control,
    )
    decomposition.improve(found.partners[int(np.argmin(found.energies))])
    return found.proven
