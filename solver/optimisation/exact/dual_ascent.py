"""Bounds by block coordinate ascent, and candidates that no good correspondence uses.

Costs are moved from the pairs of source points to the points themselves, so that no correspondence
becomes cheaper or dearer by it, and what every point costs at least adds up to a bound. Pairs take
turns: each is given all that its two points cost, and divides it such that neither could cost more
(MPLP++ of Tourani, Shekhovtsov, Rother and Savchynskyy, "MPLP++: fast, parallel dual block-
coordinate ascent for dense graphical models", 2018). The bound never falls.

Where it is known what a correspondence must cost less than, a candidate is dropped as soon as the
bound of all correspondences that use it is no less. With fewer candidates the bound rises more.

To stay unmatched is a further candidate of a point, without pairwise costs. A bound takes
O(|V|²) for each round, far less than one of a dual decomposition, but knows of target points only
that no two source points share one.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.labelling import UNMATCHED
from solver.optimisation.reparametrisation import BoundingCosts, costs_among

_ROUNDING = 1e-12
"""What rounding errors may have added to a bound, relative to it."""
_STALLED = 2e-3
"""A round that raises the bound by less of what it is away from the limit is of no use."""
_COMPACT = 0.8
"""Candidates are moved together when no more than this share of them is left."""


class DualAscent:
    """The costs of a problem, and how they are divided so far.

    Parameters
    ----------
    costs
        Of the problem.
    rows
        (N+1,) candidates of source point x are ``rows[x]`` to ``rows[x+1]``.

    Attributes
    ----------
    bound
        What every correspondence costs at least, of those that cost less than any limit given;
        −∞ before the first round.
    """

    def __init__(self, costs: BoundingCosts, rows: IntArray) -> None:
        self._costs = costs
        n, count = len(rows) - 1, len(costs.unary)
        everyone = np.arange(count)
        optional = np.flatnonzero(np.isfinite(costs.occlusion))
        points = np.concatenate([np.repeat(np.arange(n), np.diff(rows)), optional])
        labels = np.concatenate([everyone, np.full(len(optional), UNMATCHED)])
        order = np.argsort(points, kind="stable") if len(optional) else np.arange(len(points))
        self._points, self._labels = points[order], labels[order]
        self._own = np.concatenate([costs.unary, costs.occlusion[optional]])[order]
        self._theta = _finite_costs(costs.pairwise, self._labels, np.abs(self._own).sum())
        self._messages = np.zeros((n, len(points)))
        self._unary = self._own.copy()
        # Until they have been divided, pairs may cost less than nothing.
        self.bound = np.inf if self._starved() else -np.inf

    @property
    def exhausted(self) -> bool:
        """Whether no correspondence is left that costs less than the limit."""
        return self.bound == np.inf

    @property
    def kept(self) -> IntArray:
        """(V',) candidates that are left."""
        kept: IntArray = self._labels[self._labels != UNMATCHED]
        return kept

    def run(self, rounds: int, limit: float = np.inf) -> None:
        """Go round all pairs of points, there and back, several times or until that is of no use.

        Parameters
        ----------
        rounds
            How often.
        limit
            Correspondences that cost as much or more need not be bounded.
        """
        for _ in range(rounds):
            before, left = self.bound, len(self._labels)
            if self.exhausted:
                return
            for back in (False, True):
                _go_round(self._theta, self._rows(), self._unary, self._messages, back)
            self.bound = self._bound()
            self._drop(limit)
            rise, open_gap = self.bound - before, limit - self.bound
            if len(self._labels) == left and rise < _STALLED * open_gap < np.inf:
                return

    def costs(self) -> BoundingCosts:
        """Return the costs as they are divided now, of the candidates that are left."""
        unary = self._own + self._messages.sum(axis=0)
        matched = np.flatnonzero(self._labels != UNMATCHED)
        alone = np.flatnonzero(self._labels == UNMATCHED)
        pairwise = _divided(
            self._costs.pairwise,
            self._labels[matched],
            self._points[matched],
            np.ascontiguousarray(self._messages[:, matched]),
        )
        occlusion = np.full(len(self._messages), np.inf)
        occlusion[self._points[alone]] = unary[alone]
        constant = self._costs.constant
        return BoundingCosts(constant, unary[matched], pairwise, occlusion)

    def _rows(self) -> IntArray:
        wanted = np.arange(len(self._messages) + 1)
        return np.searchsorted(self._points, wanted).astype(np.int64)

    def _starved(self) -> bool:
        """Whether some point has no label left."""
        return bool((np.diff(self._rows()) == 0).any())

    def _bound(self) -> float:
        if self._starved():
            return np.inf
        rows = self._rows()
        return float(np.minimum.reduceat(self._unary, rows[:-1]).sum()) + self._costs.constant

    def _drop(self, limit: float) -> None:
        """Drop candidates whose bound reaches the limit."""
        if not np.isfinite(limit):
            return
        least = np.minimum.reduceat(self._unary, self._rows()[:-1])[self._points]
        excess = self._unary - least
        left = self.bound + excess < limit - _ROUNDING * (1.0 + abs(limit))
        if left.sum() > _COMPACT * len(left) and left.any():
            return
        self._points, self._labels = self._points[left], self._labels[left]
        self._own, self._unary = self._own[left], self._unary[left]
        self._messages = np.ascontiguousarray(self._messages[:, left])
        where = np.flatnonzero(left)
        self._theta = costs_among(self._theta, where)
        self.bound = self._bound()


def _finite_costs(pairwise: FloatArray, labels: IntArray, unary: float) -> FloatArray:
    """(L, L) pairwise costs of labels; those that exclude one another cost more than anything."""
    matched = labels != UNMATCHED
    theta = pairwise
    if not matched.all():
        theta = np.zeros((len(labels), len(labels)))
        theta[np.ix_(matched, matched)] = pairwise
    cap = 1.0 + 2.0 * (unary + _largest(theta) * len(theta))
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


@kernel
def _divided(
    pairwise: FloatArray, kept: IntArray, points: IntArray, messages: FloatArray
) -> FloatArray:
    """Pairwise costs of some candidates without what was moved away from them.

    Parameters
    ----------
    pairwise
        (V, V) of all.
    kept, points
        (V',) those that are wanted, and their source points.
    messages
        (N, V') what was moved to each of them from its point's pair with each other.
    """
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
    """Let every pair of points divide its costs anew, in order or in the opposite order.

    Parameters
    ----------
    theta
        (L, L) pairwise costs, symmetric and finite.
    rows
        (N+1,) labels of each point.
    unary
        (L,) costs of labels with all that was moved there; changed in place.
    messages
        (N, L) what was moved to each label from its point's pair with each other; likewise.
    back
        Whether in the opposite order.
    """
    n = len(rows) - 1
    widest = np.diff(rows).max() if n > 0 else 0
    costs = theta.ravel()
    f, g, half, second = np.empty(widest), np.empty(widest), np.empty(widest), np.empty(widest)
    for i in range(n):
        for j in range(i + 1, n):
            x, y = (n - 1 - i, n - 1 - j) if back else (i, j)
            here, there = rows[x], rows[y]
            count, other = rows[x + 1] - here, rows[y + 1] - there
            for a in range(count):
                f[a] = unary[here + a] - messages[y, here + a]
            for b in range(other):
                g[b] = unary[there + b] - messages[x, there + b]
            # Each in turn takes what is left, the first one half of it beforehand.
            _least(costs, rows, y, x, g, half)
            for a in range(count):
                half[a] = f[a] - 0.5 * (f[a] + half[a])
            _least(costs, rows, x, y, half, second)
            for b in range(other):
                second[b] += g[b]
                messages[x, there + b] += second[b] - unary[there + b]
                unary[there + b] = second[b]
                g[b] -= second[b]
            _least(costs, rows, y, x, g, half)
            for a in range(count):
                first = f[a] + half[a]
                messages[y, here + a] += first - unary[here + a]
                unary[here + a] = first


@inlined
def _least(
    costs: FloatArray, rows: IntArray, x: int, y: int, offsets: FloatArray, least: FloatArray
) -> None:
    """Write what each label of y costs at least with one of x, an offset being added to each.

    Four labels are looked at together, and places are unsigned, so that compilers make vector
    instructions of it.

    Parameters
    ----------
    costs
        (L L,) pairwise costs, row by row.
    rows
        (N+1,) labels of each point.
    x, y
        Points.
    offsets
        Of the labels of x.
    least
        Of the labels of y, written.
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
