"""Messages between labels of source points, with pairwise costs computed from the two metrics.

A label of a source point is a target point, or `UNMATCHED`. Nothing of the size of all pairs of
candidates is stored: a pairwise cost takes three operations on two distances, which is faster than
reading it from memory.
"""

from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined, kernel
from solver.labelling import UNMATCHED, LabellingProblem, distortion_cost
from solver.optimisation.mplp import mplp_sweep

_DENSE = 0.35
"""Share of the target points above which costs with all of them take less time than with some."""


class MetricCosts(NamedTuple):
    """Pairwise costs β |d_X(x, x') − d_Y(y, y')|², for compiled code.

    Attributes
    ----------
    source, target
        (N, N) and (M, M) symmetric distances. The diagonal of the latter is negative, so that two
        source points with the same target point cost more than a limit.
    beta
        (N, N) weights β > 0 of two source points.
    """

    source: FloatArray
    target: FloatArray
    beta: FloatArray

    @classmethod
    def of(cls, problem: LabellingProblem, limit: float) -> "MetricCosts":
        """Return the costs of a problem.

        Parameters
        ----------
        problem
            A problem whose pairwise costs are all distortions of the metrics, with β > 0.
        limit
            Energy that is reached where a target point is used twice, not negative.
        """
        target = problem.target_distances.copy()
        beta = problem.beta_of_pairs
        np.fill_diagonal(target, -np.sqrt(2.0 * (limit + problem.scale) / beta.min()))
        return cls(np.ascontiguousarray(problem.source_distances), target, beta)

    def of_block(self, block: LabellingProblem) -> "MetricCosts":
        """Return the costs of a problem with the same target distances, which are not copied.

        Its energies, weighted as they are, have to stay below the limit of these costs.
        """
        return self._replace(source=block.source_distances, beta=block.beta_of_pairs)


@kernel
def divide_costs(
    costs: MetricCosts,
    rows: IntArray,
    targets: IntArray,
    unary: FloatArray,
    messages: FloatArray,
    back: bool,
    turns: tuple[int, int],
) -> None:
    """Let every pair of source points divide its costs anew: see :func:`.mplp_sweep`.

    Parameters
    ----------
    costs
        Pairwise costs.
    rows, unary, messages, back, turns
        As there.
    targets
        (L,) target point of each label; `UNMATCHED`, if at all, last of a source point.
    """
    labels = costs, targets, np.empty(len(costs.target))
    mplp_sweep(_write_least, labels, rows, unary, messages, back, turns)


@kernel
def label_bounds(
    costs: MetricCosts,
    rows: IntArray,
    targets: IntArray,
    unary: FloatArray,
    messages: FloatArray,
    turns: tuple[int, int],
) -> FloatArray:
    """Lower bounds of all correspondences with each label: its cost with the best of each point.

    Parameters
    ----------
    costs, rows, targets, unary, messages
        After :func:`divide_costs`.
    turns
        The first source point, and the one before which to stop.

    Returns
    -------
    (K,) float64, of the labels of these points.
    """
    n, widest = len(rows) - 1, np.diff(rows).max()
    g, least = np.empty(widest), np.empty(widest)
    labels = costs, targets, np.empty(len(costs.target))
    begin, end = turns
    total = unary[rows[begin] : rows[end]].copy()
    for x in range(begin, end):
        here, count = rows[x], rows[x + 1] - rows[x]
        own = here - rows[begin]
        for y in range(n):
            if x == y:
                continue
            there, other = rows[y], rows[y + 1] - rows[y]
            for b in range(other):
                g[b] = unary[there + b] - messages[x, there + b]
            _write_least(labels, rows, y, x, g, least)
            for a in range(count):
                total[own + a] += least[a] - messages[y, here + a]
    return total


@inlined
def _write_least(
    labels: tuple[MetricCosts, IntArray, FloatArray],
    rows: IntArray,
    x: int,
    y: int,
    offsets: FloatArray,
    least: FloatArray,
) -> None:
    """As :func:`.mplp_sweep` needs it, of pairwise costs, target points, and (M,) scratch space."""
    costs, targets, scratch = labels
    theirs, ours = targets[rows[x] : rows[x + 1]], targets[rows[y] : rows[y + 1]]
    distance, beta, target = costs.source[y, x], costs.beta[y, x], costs.target
    count, other = len(ours), len(theirs)
    alone = np.inf
    if other > 0 and theirs[other - 1] == UNMATCHED:
        other -= 1
        alone = offsets[other]
    if count > 0 and ours[count - 1] == UNMATCHED:
        count -= 1
        least[count] = alone
        for b in range(other):
            least[count] = min(least[count], offsets[b])
    if count > _DENSE * len(scratch):
        scratch[:] = alone
        _lower(target, beta, distance, theirs, other, offsets, scratch)
        for a in range(count):
            least[a] = scratch[ours[a]]
    else:
        _lower_some(target, beta, distance, theirs, other, offsets, ours, count, alone, least)


@kernel
def _lower(
    target: FloatArray,
    beta: float,
    distance: float,
    theirs: IntArray,
    other: int,
    offsets: FloatArray,
    least: FloatArray,
) -> None:
    """Lower the cost of each target point to the least with some labels, four at a time."""
    b = 0
    while b + 4 <= other:
        p, q = target[theirs[b]], target[theirs[b + 1]]
        r, s = target[theirs[b + 2]], target[theirs[b + 3]]
        e, f, g, h = offsets[b], offsets[b + 1], offsets[b + 2], offsets[b + 3]
        for y in range(len(least)):
            one = distortion_cost(beta, distance, p[y]) + e
            two = distortion_cost(beta, distance, q[y]) + f
            three = distortion_cost(beta, distance, r[y]) + g
            four = distortion_cost(beta, distance, s[y]) + h
            one = one if one < two else two
            three = three if three < four else four
            one = one if one < three else three
            least[y] = one if one < least[y] else least[y]
        b += 4
    while b < other:
        p, e = target[theirs[b]], offsets[b]
        for y in range(len(least)):
            one = distortion_cost(beta, distance, p[y]) + e
            least[y] = one if one < least[y] else least[y]
        b += 1


@kernel
def _lower_some(
    target: FloatArray,
    beta: float,
    distance: float,
    theirs: IntArray,
    other: int,
    offsets: FloatArray,
    ours: IntArray,
    count: int,
    most: float,
    least: FloatArray,
) -> None:
    """Write the least cost of some labels with others, at most a given one."""
    a = 0
    while a + 4 <= count:
        p, q, r, s = most, most, most, most
        i, j, k, h = ours[a], ours[a + 1], ours[a + 2], ours[a + 3]
        for b in range(other):
            y, offset = theirs[b], offsets[b]
            one = distortion_cost(beta, distance, target[y, i]) + offset
            two = distortion_cost(beta, distance, target[y, j]) + offset
            three = distortion_cost(beta, distance, target[y, k]) + offset
            four = distortion_cost(beta, distance, target[y, h]) + offset
            p, q = one if one < p else p, two if two < q else q
            r, s = three if three < r else r, four if four < s else s
        least[a], least[a + 1], least[a + 2], least[a + 3] = p, q, r, s
        a += 4
    while a < count:
        p, i = most, ours[a]
        for b in range(other):
            one = distortion_cost(beta, distance, target[theirs[b], i]) + offsets[b]
            p = one if one < p else p
        least[a] = p
        a += 1
