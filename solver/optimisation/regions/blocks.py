"""Lower bounds from blocks of source points, which are solved one by one.

The relaxation behind dual ascent weakens as points get denser, since it sees two points at a time.
A *block* is a problem of its own, of some of the points with all of their labels, whose optimum
counts in full. The energy is a sum of such problems, so that the sum of their optima, or of the
bounds reached so far, is a lower bound.

The points are divided into groups, and the blocks are the lines of a projective plane whose points
are the groups: any two groups are together in exactly one block. A pair of points of two groups
belongs to one block; the unary costs, and the pairs within a group, are divided evenly among the
blocks of the group. Costs are taken as dual ascent has moved them, so that the bound begins where
that of the dual ascent ends.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import LabellingProblem
from solver.optimisation.primal import InfeasibleError, solve_lap
from solver.optimisation.regions.message_passing import MetricCosts
from solver.optimisation.regions.region import Region
from solver.optimisation.regions.search import MEMORY, RegionSearch, RegionSearchState
from solver.optimisation.rounding import allowance

_PLANES = (
    (31, (0, 1, 3, 8, 12, 18)),
    (21, (0, 1, 4, 14, 16)),
    (13, (0, 1, 3, 9)),
    (7, (0, 1, 3)),
)
"""Numbers of groups, and groups of one block; the others follow by cyclic shifts (perfect
difference sets: Singer, Trans. AMS 43, 1938)."""

_SMALLEST = 18
"""Mean number of points of a division's blocks from which on it takes part; the last one always
does. Blocks of 20 of 64 points take some 0.1 to 1 s."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """Division of pairs of points among blocks.

    Parameters
    ----------
    points
        Points of each block, ascending.
    weights
        (N, N) share of the cost of a pair that each of its blocks has.
    times
        Number of blocks of each point.
    """

    points: list[IntArray]
    weights: FloatArray
    times: int


def blocks_of(count: int) -> list[Blocks]:
    """Divisions of points into ever larger blocks.

    Parameters
    ----------
    count
        Number N of points. Point x is in group x modulo the number of groups: points far from one
        another, as farthest point sampling orders them, are in a block together.
    """
    large = [plane for plane in _PLANES if count * len(plane[1]) >= _SMALLEST * plane[0]]
    return [_lines(count, *plane) for plane in large or _PLANES[-1:]]


def _lines(count: int, groups: int, base: tuple[int, ...]) -> Blocks:
    group = np.arange(count) % groups
    lines = [(np.array(base) + shift) % groups for shift in range(groups)]
    points = [np.flatnonzero(np.isin(group, line)) for line in lines]
    alike = group[:, None] == group
    return Blocks(points, np.where(alike, 1.0 / len(base), 1.0), len(base))


def block_problem(
    problem: LabellingProblem, region: Region, blocks: Blocks, number: int
) -> tuple[LabellingProblem, float]:
    """Return the problem of a block, and a constant to be added to its energies.

    Parameters
    ----------
    problem
        The problem of all points, each of which must be matched.
    region
        A region of it, after dual ascent.
    blocks, number
        A division, and the block.

    Returns
    -------
    A problem without negative costs, on the points of the block, with all target points.
    """
    points, n = blocks.points[number], problem.n_sources
    place = np.full(n, -1)
    place[points] = np.arange(len(points))
    kept = np.flatnonzero(place[region.points] >= 0)
    own = region.points[kept]
    moved = blocks.weights[np.ix_(points, own)] * region.messages[np.ix_(points, kept)]
    unary = region.unary(problem)[kept] / blocks.times - moved.sum(axis=0)
    rows = np.searchsorted(own, points)
    least = np.minimum.reduceat(unary, rows)
    pairs = np.ix_(points, points)
    part = LabellingProblem(
        np.stack([place[own], problem.candidates[region.labels[kept], 1]], axis=1),
        unary - least[place[own]],
        np.ascontiguousarray(problem.source_distances[pairs]),
        problem.target_distances,
        problem.beta,
        weights=np.ascontiguousarray(blocks.weights[pairs]),
    )
    return part, float(least.sum())


@dataclass(eq=False)
class BlockSearchState:
    """Bounds of the blocks of one division, and the best bound of the former ones.

    Parameters
    ----------
    bound
        Lower bound of the region.
    left
        Divisions that have not been begun.
    constant
        Of all blocks of the present division.
    searches
        Their searches, and how far they are.
    work
        Pairs of labels looked at so far.
    """

    bound: float
    left: list[Blocks]
    constant: float
    searches: list[tuple[RegionSearch, RegionSearchState]]
    work: float = 0.0


class BlockSearch:
    """Lower bound of a region by ever larger blocks: each step works on one block.

    Parameters
    ----------
    problem
        A problem whose points must all be matched.
    region
        A region of it, after dual ascent, with a label for each point.
    control
        Cancels and ends steps.
    memory
        Limit on the bytes of the messages of the open regions of all blocks.
    """

    def __init__(
        self, problem: LabellingProblem, region: Region, control: Control, memory: int = MEMORY
    ) -> None:
        self._problem, self._region = problem, region
        self._control, self._memory = control, memory
        self._left = blocks_of(problem.n_sources)
        # Of all blocks, so that they share a matrix of target distances.
        greatest = problem.n_sources**2 * problem.scale
        self._costs = MetricCosts.of(problem, greatest * max(each.times for each in self._left))

    def init(self) -> BlockSearchState:
        """Return the bound of the region, and no block."""
        return BlockSearchState(self._region.bound, list(self._left), 0.0, [])

    def step(self, state: BlockSearchState) -> BlockSearchState:
        """Raise the bound of the block that may be farthest from its optimum, or divide anew."""
        unfinished = [
            (searched.incumbent.energy - searched.lower_bound, number)
            for number, (search, searched) in enumerate(state.searches)
            if not search.done(searched)
        ]
        if not unfinished:
            self._divide(state)
            return state
        _, number = max(unfinished)
        search, searched = state.searches[number]
        before = searched.work
        searched = search.step(searched)
        state.searches[number] = search, searched
        state.work += searched.work - before
        self._raise(state)
        return state

    def done(self, state: BlockSearchState) -> bool:
        """Return whether the blocks of all divisions are solved."""
        return not state.left and all(search.done(found) for search, found in state.searches)

    def _divide(self, state: BlockSearchState) -> None:
        """Begin with the next division."""
        blocks = state.left.pop(0)
        state.searches, state.constant = [], 0.0
        memory = self._memory // len(blocks.points)
        for number in range(len(blocks.points)):
            part, constant = block_problem(self._problem, self._region, blocks, number)
            try:
                start = solve_lap(part, part.unary)
            except InfeasibleError:  # nor is there a correspondence of all points
                state.bound, state.left, state.searches = np.inf, [], []
                return
            costs = self._costs.of_block(part)
            search = RegionSearch(part, [start], np.inf, self._control, memory, costs)
            state.searches.append((search, search.init()))
            state.constant += constant

    def _raise(self, state: BlockSearchState) -> None:
        bounds = np.array([max(found.lower_bound, 0.0) for _, found in state.searches])
        total = float(bounds.sum())
        errors = len(bounds) * allowance(abs(state.constant) + total, self._problem.scale)
        state.bound = max(state.bound, state.constant + total - errors)
