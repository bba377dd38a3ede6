"""Proof of optimality over all candidates of a problem, however many."""

from collections.abc import Sequence

from solver.arrays import IntArray
from solver.control import UNLIMITED, Control, Status, iterate
from solver.labelling import LabellingProblem, Method, Solution
from solver.optimisation.primal import solve_lap
from solver.optimisation.regions.search import RegionSearch

_WORK_PER_SECOND = 3e9
"""Pairs of labels that one core looks at in a second, nearly."""
_MOST_BYTES = 64 * 2**20
"""Bytes of the messages of all candidates above which nothing is proven: 8 |V| N."""


def can_prove(problem: LabellingProblem) -> bool:
    """Return whether the costs have the form, and the candidates the number, for :func:`prove`."""
    small = 8 * problem.n_candidates * problem.n_sources <= _MOST_BYTES
    others = problem.table, problem.terms.first, problem.triples.points
    only_metrics = not any(len(costs) for costs in others)
    return small and only_metrics and problem.non_negative


def prove(
    problem: LabellingProblem,
    starts: Sequence[IntArray] = (),
    *,
    seconds: float = float("inf"),
    control: Control | None = None,
) -> Solution[IntArray]:
    """Solve problem (5) over thousands of candidates, or bound it.

    Parameters
    ----------
    problem
        A problem that :func:`can_prove`, such as one whose candidates are all pairs of samples.
    starts
        Good correspondences, if known: the better, the less is to be searched.
    seconds
        Limit on the work, in seconds of a typical core. What is counted are operations, not time,
        so that the answer is the same on every machine.
    control
        Cancels; at its deadline the best answer so far is returned with its bound.

    Returns
    -------
    Solution
        ``lower_bound <= optimum <= value``; both equal where the optimum is proven. Its iterations
        are the regions bounded. The memory of a proof is at most some 450 MB.

    Raises
    ------
    Cancelled
        Through `control`.
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    ValueError
        The problem has costs of another form, or too many candidates.

    Examples
    --------
    >>> import numpy as np
    >>> source = np.array([[0.0, 3.0, 4.0], [3.0, 0.0, 5.0], [4.0, 5.0, 0.0]])
    >>> target = np.ascontiguousarray(source[::-1, ::-1])
    >>> pairs = np.argwhere(np.ones((3, 3)))
    >>> found = prove(LabellingProblem(pairs, np.zeros(9), source, target))
    >>> found.answer.tolist(), found.value, found.gap
    ([2, 1, 0], 0.0, 0.0)
    """
    if not can_prove(problem):
        raise ValueError("the costs are not distortions of metrics alone, or candidates too many")
    control = control or Control()
    control.check()
    assignment = solve_lap(problem, problem.unary)
    if problem.beta == 0.0 or not problem.n_candidates:
        energy = problem.energy(assignment)
        return Solution(assignment, energy, energy, 0, Method.BRANCH_AND_BOUND)
    search = RegionSearch(problem, starts or [assignment], seconds * _WORK_PER_SECOND, control)
    ended = iterate(search, UNLIMITED, control)
    state, status = ended.state, ended.status
    if state.open and status is Status.CONVERGED:
        status = Status.ITERATIONS
    best = state.incumbent
    bound = min(max(state.lower_bound, 0.0), best.energy)
    return Solution(
        best.partners, best.energy, bound, state.regions, Method.BRANCH_AND_BOUND, status
    )
