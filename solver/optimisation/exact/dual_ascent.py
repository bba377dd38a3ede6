"""Dual ascent: lower bounds by block coordinate ascent, and candidates that they exclude.

Costs are moved from the pairs of source points to the points themselves (:mod:`.mplp`), so that no
correspondence changes its cost; the least costs of the points then add up to a lower bound.

Given an upper limit of the energy, a candidate is dropped once the lower bound of all
correspondences that use it reaches the limit. With fewer candidates the bound rises more.

To stay unmatched is a further label of a point, without pairwise costs. A round takes O(|V|²), far
less than an iteration of a dual decomposition, but of the constraints of target points it contains
only that no two source points share one.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.labelling import UNMATCHED
from solver.optimisation.mplp import mplp_sweep
from solver.optimisation.reparametrisation import ReparametrisedCosts, costs_among
from solver.optimisation.rounding import allowance

_STALL = 2e-3
"""Least rise of the bound in a round, relative to its distance from the limit, to go on."""
_COMPACT = 0.8
"""Arrays are compacted when no more than this share of the labels is left."""


class DualAscent:
    """Dual ascent as an iterative method: each step goes round all pairs, there and back.

    It is done when no correspondence is left below the limit, or when a round neither drops a
    candidate nor raises the bound by much.

    Parameters
    ----------
    costs
        Of the problem.
    rows
        (N+1,) candidates of source point x are ``rows[x]`` to ``rows[x+1]``.
    limit
        Correspondences of at least this energy need not be bounded.
    """

    def __init__(self, costs: ReparametrisedCosts, rows: IntArray, limit: float = np.inf) -> None:
        self._costs, self._rows, self._limit = costs, rows, limit

    def init(self) -> "AscentState":
        """Return the problem's own costs."""
        costs, rows = self._costs, self._rows
        n, count = len(rows) - 1, len(costs.unary)
        optional = np.flatnonzero(np.isfinite(costs.occlusion))
        points = np.concatenate([np.repeat(np.arange(n), np.diff(rows)), optional])
        labels = np.concatenate([np.arange(count), np.full(len(optional), UNMATCHED)])
        order = np.argsort(points, kind="stable") if len(optional) else np.arange(len(points))
        points, labels = points[order], labels[order]
        own = np.concatenate([costs.unary, costs.occlusion[optional]])[order]
        theta = _finite_costs(costs.pairwise, labels, np.abs(own).sum())
        messages = np.zeros((n, len(points)))
        state = AscentState(costs, points, labels, own, theta, messages, own.copy())
        if state.infeasible:
            state.bound = np.inf
        return state

    def step(self, state: "AscentState") -> "AscentState":
        """Go round all pairs of points, in order and back, and drop candidates."""
        before, count = state.bound, len(state.labels)
        for back in (False, True):
            _go_round(state.theta, state.rows, state.unary, state.messages, back)
        state.bound = state.least_sum()
        state.drop(self._limit)
        rise, distance = state.bound - before, self._limit - state.bound
        state.stalled = len(state.labels) == count and rise < _STALL * distance < np.inf
        return state

    def done(self, state: "AscentState") -> bool:
        """Return whether further rounds are of no use."""
        return state.exhausted or state.stalled


@dataclass(eq=False)
class AscentState:
    """Division of the costs so far; L labels are left, candidates and points unmatched.

    Parameters
    ----------
    original
        Costs of the problem.
    points, labels
        (L,) source point of each label; its candidate, `UNMATCHED` for none.
    own, unary
        (L,) cost of each label in the problem, and with the costs that were moved to it.
    theta
        (L, L) pairwise costs of the problem, finite.
    messages
        (N, L) costs that were moved to each label from its point's pair with each other point.
    bound
        Lower bound of all correspondences that are below the limit; −∞ before the first round, as
        pairs may have negative costs until these are divided.
    stalled
        Whether the last round was of little use.
    """

    original: ReparametrisedCosts
    points: IntArray
    labels: IntArray
    own: FloatArray
    theta: FloatArray
    messages: FloatArray
    unary: FloatArray
    bound: float = -np.inf
    stalled: bool = False

    @property
    def exhausted(self) -> bool:
        """Whether no correspondence is left below the limit."""
        return self.bound == np.inf

    @property
    def infeasible(self) -> bool:
        """Whether a point has no label left."""
        return bool((np.diff(self.rows) == 0).any())

    @property
    def kept(self) -> IntArray:
        """(V',) candidates that are left."""
        kept: IntArray = self.labels[self.labels != UNMATCHED]
        return kept

    @property
    def rows(self) -> IntArray:
        """(N+1,) labels of source point x are ``rows[x]`` to ``rows[x+1]``."""
        wanted = np.arange(len(self.messages) + 1)
        return np.searchsorted(self.points, wanted).astype(np.int64)

    def costs(self) -> ReparametrisedCosts:
        """Return the costs as they are divided now, of the candidates that are left."""
        unary = self.own + self.messages.sum(axis=0)
        return divided_costs(self.original, self.points, self.labels, unary, self.messages)

    def least_sum(self) -> float:
        """Sum of the least costs of all points, and the constant."""
        if self.infeasible:
            return np.inf
        least = np.minimum.reduceat(self.unary, self.rows[:-1])
        return float(least.sum()) + self.original.constant

    def drop(self, limit: float) -> None:
        """Drop labels whose lower bound reaches the limit."""
        if not np.isfinite(limit):
            return
        least = np.minimum.reduceat(self.unary, self.rows[:-1])[self.points]
        excess = self.unary - least
        left = self.bound + excess < limit - allowance(limit, self.original.scale)
        if left.sum() > _COMPACT * len(left) and left.any():
            return
        self.points, self.labels = self.points[left], self.labels[left]
        self.own, self.unary = self.own[left], self.unary[left]
        self.messages = np.ascontiguousarray(self.messages[:, left])
        self.theta = costs_among(self.theta, np.flatnonzero(left))
        self.bound = self.least_sum()


def _finite_costs(pairwise: FloatArray, labels: IntArray, unary: float) -> FloatArray:
    """(L, L) pairwise costs of labels; exclusive ones cost more than any correspondence."""
    matched = labels != UNMATCHED
    theta = pairwise
    if not matched.all():
        theta = np.zeros((len(labels), len(labels)))
        theta[np.ix_(matched, matched)] = pairwise
    cap = 2.0 * (unary + _largest(theta) * len(theta)) or 1.0
    finite: FloatArray = np.minimum(theta, cap)
    return finite


@kernel
def _largest(costs: FloatArray) -> float:
    """Greatest magnitude of a finite cost."""
    largest = np.zeros(len(costs))
    for row in costs:
        for b in range(len(row)):
            size = abs(row[b])
            largest[b] = max(largest[b], size if size < np.inf else 0.0)
    return largest.max() if len(largest) else 0.0


def divided_costs(
    costs: ReparametrisedCosts,
    points: IntArray,
    labels: IntArray,
    unary: FloatArray,
    messages: FloatArray,
) -> ReparametrisedCosts:
    """Costs of some labels, as a dual ascent has divided them.

    Parameters
    ----------
    costs
        Of the problem.
    points, labels
        (L,) source point of each label, ascending; its candidate, `UNMATCHED` for none.
    unary
        (L,) costs of the labels with the costs that were moved to them.
    messages
        (N, L) costs that were moved to each label from its point's pair with each other point.
    """
    matched = np.flatnonzero(labels != UNMATCHED)
    alone = np.flatnonzero(labels == UNMATCHED)
    kept = labels[matched]
    moved = np.ascontiguousarray(messages[:, matched])
    occlusion = np.full(len(messages), np.inf)
    occlusion[points[alone]] = unary[alone]
    return costs._replace(
        unary=unary[matched],
        pairwise=_less_messages(costs.pairwise, kept, points[matched], moved),
        occlusion=occlusion,
        triples=costs.triples.among(kept),
    )


@kernel
def _less_messages(
    pairwise: FloatArray, kept: IntArray, points: IntArray, messages: FloatArray
) -> FloatArray:
    """Pairwise costs of some candidates, less the costs that were moved to their points."""
    found = np.empty((len(kept), len(kept)))
    rows = np.searchsorted(points, np.arange(len(messages) + 1))
    for i in range(len(kept)):
        row, moved, left = pairwise[kept[i]], messages[points[i]], found[i]
        for y in range(len(messages)):
            back = messages[y, i]
            for j in range(rows[y], rows[y + 1]):
                left[j] = row[kept[j]] - moved[j] - back
        left[i] = 0.0
    return found


@kernel
def _go_round(
    theta: FloatArray, rows: IntArray, unary: FloatArray, messages: FloatArray, back: bool
) -> None:
    turns = 0, len(rows) - 1
    mplp_sweep(_write_least, theta.ravel(), rows, unary, messages, back, turns)


@inlined
def _write_least(
    costs: FloatArray, rows: IntArray, x: int, y: int, offsets: FloatArray, least: FloatArray
) -> None:
    """As :func:`.mplp_sweep` needs it, of (L L,) pairwise costs, row by row.

    Four labels at a time and unsigned indices let the compiler use vector instructions.
    """
    count, other, width = rows[x + 1] - rows[x], rows[y + 1] - rows[y], np.uint64(rows[-1])
    corner, b = rows[x] * rows[-1] + rows[y], 0
    while b + 4 <= other:
        p, q, r, s = np.inf, np.inf, np.inf, np.inf
        place = np.uint64(corner + b)
        for a in range(count):
            offset = offsets[a]
            p = min(p, costs[place] + offset)
            q = min(q, costs[place + np.uint64(1)] + offset)
            r = min(r, costs[place + np.uint64(2)] + offset)
            s = min(s, costs[place + np.uint64(3)] + offset)
            place += width
        least[b], least[b + 1], least[b + 2], least[b + 3] = p, q, r, s
        b += 4
    while b < other:
        p, place = np.inf, np.uint64(corner + b)
        for a in range(count):
            p = min(p, costs[place] + offsets[a])
            place += width
        least[b] = p
        b += 1
