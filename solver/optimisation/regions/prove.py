"""Proof of optimality over all candidates of a problem, however many."""

from collections.abc import Sequence
from dataclasses import dataclass

from solver.arrays import IntArray
from solver.control import UNLIMITED, Control, Status, iterate
from solver.labelling import LabellingProblem, Method, Solution
from solver.optimisation.primal import solve_lap
from solver.optimisation.regions.blocks import BlockSearch, BlockSearchState
from solver.optimisation.regions.search import MEMORY, RegionSearch, RegionSearchState

_PAIRS_PER_SECOND = 3e9
"""Pairs of labels that one core looks at in a second, nearly."""
_MOST_BYTES = 64 * 2**20
"""Bytes of the messages of all candidates above which nothing is proven: 8 |V| N."""
_MANY_POINTS = 40
"""Source points from which on blocks of them are bounded, too. Of fewer, blocks of a size that can
be solved bound no better than regions do in the same time."""


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
        are the regions bounded. Open regions take at most 256 MB, and a proof of 100 points and 800
        samples, with its blocks, some 660 MB.

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
    proof = _Proof(problem, starts or [assignment], seconds * _PAIRS_PER_SECOND, control)
    ended = iterate(proof, UNLIMITED, control)
    regions, status = ended.state.regions, ended.status
    if regions.open and status is Status.CONVERGED:
        status = Status.ITERATIONS
    best = regions.incumbent
    bound = min(max(ended.state.lower_bound, 0.0), best.energy)
    return Solution(
        best.partners, best.energy, bound, regions.regions, Method.BRANCH_AND_BOUND, status
    )


@dataclass(eq=False)
class _ProofState:
    """The regions, and the blocks of all of them once these are bounded."""

    regions: RegionSearchState
    search: BlockSearch | None = None
    blocks: BlockSearchState | None = None

    @property
    def lower_bound(self) -> float:
        return max(self.regions.lower_bound, self.blocks.bound if self.blocks else 0.0)


class _Proof:
    """Search of regions and, of many points, bounds of blocks, with equal shares of the work."""

    def __init__(
        self, problem: LabellingProblem, starts: Sequence[IntArray], work: float, control: Control
    ) -> None:
        self._problem, self._control = problem, control
        self._many = problem.n_sources >= _MANY_POINTS and problem.must_match_all
        self._memory = MEMORY // 2 if self._many else MEMORY
        self._search = RegionSearch(problem, starts, work, control, self._memory)

    def init(self) -> _ProofState:
        return _ProofState(self._search.init())

    def step(self, state: _ProofState) -> _ProofState:
        regions, search, blocks = state.regions, state.search, state.blocks
        if search and blocks and not search.done(blocks) and 2.0 * blocks.work < regions.work:
            before = blocks.work
            state.blocks = blocks = search.step(blocks)
            regions.work += blocks.work - before
            if blocks.bound >= regions.limit:
                regions.open.clear()
            return state
        state.regions = regions = self._search.step(regions)
        if self._many and not search and regions.open:
            state.search = BlockSearch(self._problem, regions.open[0], self._control, self._memory)
            state.blocks = state.search.init()
        return state

    def done(self, state: _ProofState) -> bool:
        return self._search.done(state.regions)
