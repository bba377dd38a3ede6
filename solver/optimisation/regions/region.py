"""A region of the correspondences: labels left of each source point, and a bound by dual ascent."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.regions.message_passing import MetricCosts, divide_costs, label_bounds
from solver.optimisation.rounding import ROUNDING

_ROUNDS = 40
"""Greatest number of rounds of a dual ascent."""
_STALL = 0.1
"""Least rise of the bound in a round, relative to its distance from the limit, to go on."""
_FEW = 0.03
"""Share of the labels that a round drops, up to which it counts as stalled."""
_PAIRS_PER_PART = 50_000_000
"""Pairs of labels that a sweep visits between two looks at the deadline: some 50 ms."""


@dataclass(frozen=True, eq=False)
class Region:
    """Correspondences that use some labels only; a label is a candidate, or to stay unmatched.

    Parameters
    ----------
    rows
        (N+1,) labels of source point x are ``rows[x]`` to ``rows[x+1]``.
    labels
        (L,) candidate of the problem, ascending; `UNMATCHED`, if at all, last of a source point.
    messages
        (N, L) costs moved to each label from its point's pair with each other point; (0, L) before
        any are, or after they were forgotten.
    bounds
        (L,) lower bound of the correspondences of the region with each label.
    bound
        Lower bound of all of them.
    """

    rows: IntArray
    labels: IntArray
    messages: FloatArray
    bounds: FloatArray
    bound: float

    @property
    def points(self) -> IntArray:
        """(L,) source point of each label."""
        return np.repeat(np.arange(len(self.rows) - 1), np.diff(self.rows))

    @property
    def is_empty(self) -> bool:
        """Whether a source point has no label left."""
        return bool((np.diff(self.rows) == 0).any())

    @property
    def pairs(self) -> int:
        """Number of pairs of labels of different source points."""
        counts = np.diff(self.rows)
        return int(counts.sum() ** 2 - (counts**2).sum()) // 2

    @property
    def is_divided(self) -> bool:
        """Whether a dual ascent has divided the costs, and its messages are kept."""
        return len(self.messages) > 0

    def without_messages(self) -> "Region":
        """Return the region with its bounds, but without messages."""
        return replace(self, messages=np.zeros((0, len(self.labels))))

    def among(self, kept: BoolArray) -> "Region":
        """Return the part with some of the labels.

        Parameters
        ----------
        kept
            (L,) mask.
        """
        before = np.concatenate([[0], np.cumsum(kept)]).astype(np.int64)
        part = Region(
            before[self.rows],
            self.labels[kept],
            np.ascontiguousarray(self.messages[:, kept]),
            self.bounds[kept],
            self.bound,
        )
        if part.is_empty:
            return replace(part, bound=np.inf)
        least = np.minimum.reduceat(part.bounds, part.rows[:-1]).max()
        return replace(part, bound=max(self.bound, float(least)))

    def unary(self, problem: LabellingProblem) -> FloatArray:
        """(L,) costs of the labels with the costs that were moved to them."""
        own = np.full(len(self.labels), float(problem.occlusion_cost))
        matched = self.labels != UNMATCHED
        own[matched] = problem.unary[self.labels[matched]]
        moved: FloatArray = own + self.messages.sum(axis=0)
        return moved


def whole_region(problem: LabellingProblem) -> Region:
    """Return the region of all correspondences of a problem whose costs are not negative."""
    n, count = problem.n_sources, problem.n_candidates
    points, labels = problem.candidates[:, 0], np.arange(count)
    if not problem.must_match_all:
        points = np.concatenate([points, np.arange(n)])
        labels = np.concatenate([labels, np.full(n, UNMATCHED)])
        order = np.argsort(points, kind="stable")
        points, labels = points[order], labels[order]
    rows = np.searchsorted(points, np.arange(n + 1)).astype(np.int64)
    nothing = np.zeros((0, len(labels)))
    region = Region(rows, labels.astype(np.int64), nothing, np.zeros(len(labels)), 0.0)
    return replace(region, bound=np.inf) if region.is_empty else region


def ascend(
    problem: LabellingProblem,
    costs: MetricCosts,
    region: Region,
    limit: float,
    visits: float,
    control: Control,
) -> tuple[Region, int]:
    """Raise the bound of a region by dual ascent, and drop labels whose bound reaches a limit.

    It ends when a round neither drops many labels nor raises the bound by much.

    Parameters
    ----------
    problem
        The labelling problem.
    costs
        Its pairwise costs.
    region
        A region.
    limit
        Bound from which on a label is of no interest.
    visits
        Greatest number of pairs of labels visited.
    control
        Cancels; at its deadline a round that has begun is given up.

    Returns
    -------
    The region with the labels that are left, with bound ∞ if there are none for a source point; and
    the number of pairs of labels visited.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    work = 0
    for _ in range(_ROUNDS):
        control.check()
        if region.bound >= limit or control.expired or work + region.pairs > visits:
            break
        before, count = region.bound, len(region.labels)
        work += region.pairs
        region = _drop(_round(problem, costs, region, control), limit)
        rise = region.bound - before
        if rise < _STALL * (limit - region.bound) and len(region.labels) > (1.0 - _FEW) * count:
            break
    return region, work


def _round(
    problem: LabellingProblem, costs: MetricCosts, region: Region, control: Control
) -> Region:
    """One round, in order and back, or the region as it is once the deadline has passed.

    Messages are copied, as other regions may share them.
    """
    rows, unary = region.rows, region.unary(problem)
    messages = np.zeros((problem.n_sources, len(region.labels)))
    if region.is_divided:
        messages[:] = region.messages
    matched = region.labels != UNMATCHED
    targets = np.where(matched, problem.candidates[region.labels, 1], UNMATCHED)
    parts = _parts_of_a_sweep(region)
    for back, turns in control.in_time(product((False, True), parts)):
        divide_costs(costs, rows, targets, unary, messages, back, turns)
    found = [
        label_bounds(costs, rows, targets, unary, messages, turns)
        for turns in control.in_time(parts)
    ]
    if len(found) < len(parts):
        return region
    bounds = np.concatenate(found)
    bounds = np.maximum(bounds - ROUNDING * np.abs(bounds), region.bounds)
    least = float(np.minimum.reduceat(unary, rows[:-1]).sum())
    best = float(np.minimum.reduceat(bounds, rows[:-1]).max())
    bound = max(region.bound, best, least - ROUNDING * abs(least))
    return Region(rows, region.labels, messages, bounds, bound)


def _parts_of_a_sweep(region: Region) -> list[tuple[int, int]]:
    """Turns between two looks at the deadline."""
    n = len(region.rows) - 1
    each = max(n * _PAIRS_PER_PART // max(region.pairs, 1), 1)
    return [(turn, min(turn + each, n)) for turn in range(0, n, each)]


def _drop(region: Region, limit: float) -> Region:
    kept = region.bounds < limit
    return region if kept.all() else region.among(kept)
