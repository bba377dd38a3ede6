"""Branch and bound over regions, best bound first: proof of optimality over very many candidates.

The bound of a region comes from dual ascent, which also drops the labels that no better
correspondence uses. What is left is searched exactly where it is small, else divided by the place
of the partner of one source point. A division by places breaks intrinsic symmetries at once, which
a relaxation of the whole problem mixes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from solver.arrays import IntArray
from solver.control import Control
from solver.labelling import LabellingProblem
from solver.optimisation.primal import Incumbent, local_search
from solver.optimisation.regions.branching import divide_region
from solver.optimisation.regions.completion import assign_labels, search_region
from solver.optimisation.regions.message_passing import MetricCosts
from solver.optimisation.regions.region import Region, ascend, whole_region
from solver.optimisation.rounding import allowance

_SEARCH_LABELS = 400
"""Labels up to which a region is searched depth first."""
_SEARCH_WORK = 8_000_000
"""Nodes times labels of such a search, after which the region is divided further: some 20 ms."""
_PATIENCE = 8
"""Regions divided after such a search until the next ones are as much longer."""
MEMORY = 256 * 2**20
"""Bytes of open regions, 8 (N + 2) L each; beyond, messages are forgotten until needed."""
_STEP_WORK = 10**7
"""Work of a step apart from what is counted: some 3 ms."""
_PAIR_VISITS = 8
"""Times that a round of dual ascent looks at each pair of labels."""
_NODE_WORK = 10
"""Work of a search node for each label of its region."""


@dataclass(eq=False)
class RegionSearchState:
    """Open regions, and the best correspondence so far.

    Parameters
    ----------
    incumbent
        The best correspondence known.
    scale
        Of the problem's costs.
    open
        Disjoint regions that contain every better one.
    regions
        Number of regions bounded so far.
    work
        Pairs of labels looked at so far.
    divided
        Number of regions that were searched in vain.
    seen
        Assignments that local search has begun at.
    """

    incumbent: Incumbent
    scale: float
    open: list[Region]
    regions: int = 0
    work: float = 0.0
    divided: int = 0
    seen: set[bytes] = field(default_factory=set)

    @property
    def lower_bound(self) -> float:
        """Lower bound of the optimum, at most the energy of the incumbent."""
        return min((region.bound for region in self.open), default=self.incumbent.energy)

    @property
    def limit(self) -> float:
        """Bound at and above which a region is of no interest."""
        return self.incumbent.energy - allowance(self.incumbent.energy, self.scale)


class RegionSearch:
    """Branch and bound over regions as an iterative method: each step closes or divides one.

    Parameters
    ----------
    problem
        A problem with β > 0, without explicit or tabulated costs and without negative ones.
    starts
        Correspondences of it, at least one.
    work
        Limit on the pairs of labels looked at: some 3 · 10⁹ a second.
    control
        Cancels and ends steps.
    memory
        Limit on the bytes of open regions, beyond which their messages are forgotten.
    costs
        Pairwise costs of the problem, if made already.
    """

    def __init__(
        self,
        problem: LabellingProblem,
        starts: Sequence[IntArray],
        work: float,
        control: Control,
        memory: int = MEMORY,
        costs: MetricCosts | None = None,
    ) -> None:
        self._problem, self._starts, self._work = problem, starts, work
        self._control, self._memory, self._made = control, memory, costs

    def init(self) -> RegionSearchState:
        """Return the region of all correspondences, and the best local optimum near the starts."""
        problem = self._problem
        found = [Incumbent.of(problem, local_search(problem, start)) for start in self._starts]
        best = min(found, key=lambda one: one.energy)
        self._costs = self._made or MetricCosts.of(problem, best.energy)
        return RegionSearchState(best, problem.scale, [whole_region(problem)])

    def step(self, state: RegionSearchState) -> RegionSearchState:
        """Bound, search or divide the region of least bound."""
        state.work += _STEP_WORK
        state.open.sort(key=_precedence, reverse=True)
        region = state.open.pop()
        if region.bound >= state.limit:
            state.open.clear()
        elif not region.is_divided:
            self._raise(state, region)
        elif not self._searched(state, region):
            self._divide(state, region)
        self._forget(state)
        return state

    def done(self, state: RegionSearchState) -> bool:
        """Return whether the incumbent is optimal, or the work is used up."""
        return not state.open or state.work >= self._work

    def _raise(self, state: RegionSearchState, region: Region) -> None:
        """Raise the bound of a region, and keep it open unless it is of no interest."""
        visits = (self._work - state.work) / _PAIR_VISITS
        if region.pairs > visits:
            state.work = self._work
            state.open.append(region)
            return
        raised, pairs = ascend(
            self._problem, self._costs, region, state.limit, visits, self._control
        )
        state.regions += 1
        state.work += _PAIR_VISITS * pairs
        if raised.bound < state.limit:
            state.open.append(raised)

    def _divide(self, state: RegionSearchState, region: Region) -> None:
        """Divide a region, and bound its parts."""
        if self._control.expired:  # the search of it may have been cut short
            state.open.append(region)
            return
        self._improve(state, region)
        for part in divide_region(self._problem, region, state.limit):
            self._raise(state, part)

    def _forget(self, state: RegionSearchState) -> None:
        """Forget the messages of the regions of greatest bound where they take too much memory."""
        used = 0
        state.open.sort(key=_precedence)
        for place, region in enumerate(state.open):
            used += region.messages.nbytes + region.labels.nbytes + region.bounds.nbytes
            if used > self._memory and region.is_divided and place > 0:
                state.open[place] = region.without_messages()

    def _searched(self, state: RegionSearchState, region: Region) -> bool:
        """Search a small region; return whether it has no better correspondence."""
        if len(region.labels) > max(_SEARCH_LABELS, self._problem.n_sources):
            return False
        work = _SEARCH_WORK * (1 + state.divided // _PATIENCE)
        most_nodes = max(work // len(region.labels), self._problem.n_sources + 1)
        state.incumbent, exhausted, nodes = search_region(
            self._problem, region, state.incumbent, most_nodes, self._control
        )
        state.divided += not exhausted
        state.work += _NODE_WORK * nodes * len(region.labels)
        return exhausted

    def _improve(self, state: RegionSearchState, region: Region) -> None:
        """Search locally around the assignment of least cost in a region."""
        start = assign_labels(self._problem, region)
        if start.tobytes() in state.seen:
            return
        state.seen.add(start.tobytes())
        found = Incumbent.of(self._problem, local_search(self._problem, start))
        state.incumbent = min(state.incumbent, found, key=lambda one: one.energy)


def _precedence(region: Region) -> tuple[float, bool]:
    """Sort key: the least bound first and, of equal ones, a region whose messages are kept.

    Otherwise they might be forgotten again before the region is divided, for ever.
    """
    return region.bound, not region.is_divided
