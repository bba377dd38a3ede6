"""Minimax correspondences and the Gromov-Hausdorff distance of small point sets, exactly.

Section 2 measures how far two metric spaces are from isometric by the least distortion
``dis∞(C × C) = max |d_X(x, x') − d_Y(y, y')|`` over correspondences C; half of it is the
Gromov-Hausdorff distance. The optimum is one of the finitely many differences of distances, so it
is found by bisection among these: at each step a search decides whether there is a correspondence
all of whose pairs are compatible, that is, distort no distance by more.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.kernel import kernel
from solver.labelling import LabellingProblem, PairwiseTerms

_NODES_PER_CALL = 20_000


@dataclass(frozen=True, eq=False)
class MinimaxSolution:
    """A correspondence of least greatest distortion.

    Parameters
    ----------
    pairs
        (K, 2) indices (x, y), in lexicographic order.
    distortion
        dis∞ of the pairs, in the unit of the distances.
    lower_bound
        No correspondence distorts less; equal to `distortion` when the search was finished.
    nodes
        Search nodes visited.
    """

    pairs: IntArray
    distortion: float
    lower_bound: float
    nodes: int

    @property
    def proven(self) -> bool:
        """Whether the correspondence is optimal."""
        return self.lower_bound >= self.distortion


def minimax_correspondence(
    source_distances: FloatArray,
    target_distances: FloatArray,
    *,
    node_limit: int = 20_000_000,
    control: Control | None = None,
) -> MinimaxSolution:
    """Give every source point a target point of its own so that dis∞ is least.

    Parameters
    ----------
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics, N <= M. Exact for some ten source points; time grows
        exponentially with their number.
    node_limit
        Search nodes after which the best correspondence so far is returned.
    control
        Cancels the search, or ends it at a deadline as the node limit does.

    Returns
    -------
    MinimaxSolution
        N pairs.

    Raises
    ------
    ValueError
        There are fewer target points than source points, or no points.
    Cancelled
        Through `control`.
    """
    if not 0 < len(source_distances) <= len(target_distances):
        raise ValueError("every source point needs a target point of its own")
    return _bisect(source_distances, target_distances, True, node_limit, control or Control())


def gromov_hausdorff_distance(
    source_distances: FloatArray,
    target_distances: FloatArray,
    *,
    node_limit: int = 20_000_000,
    control: Control | None = None,
) -> MinimaxSolution:
    """Gromov-Hausdorff distance of two finite metric spaces, as a correspondence.

    Correspondences are here what the definition takes them to be: sets of pairs in which every
    point of either space occurs at least once. The distance is half the distortion.

    Parameters
    ----------
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics. Exact for some eight points each; time grows
        exponentially with their number.
    node_limit, control
        See :func:`minimax_correspondence`.

    Returns
    -------
    MinimaxSolution
        Between max(N, M) and N + M − 1 pairs.

    Raises
    ------
    ValueError
        A space has no points.
    Cancelled
        Through `control`.
    """
    if not (len(source_distances) and len(target_distances)):
        raise ValueError("a metric space needs a point")
    return _bisect(source_distances, target_distances, False, node_limit, control or Control())


def within_distortion(
    problem: LabellingProblem,
    source_distances: FloatArray,
    target_distances: FloatArray,
    distortion: float,
) -> LabellingProblem:
    """Make candidates that distort a distance by more than a limit too costly to go together.

    Parameters
    ----------
    problem
        A labelling problem whose candidates are all pairs.
    source_distances, target_distances
        (N, N) and (M, M) metrics to be preserved.
    distortion
        The limit.

    Returns
    -------
    LabellingProblem
        Its solutions of least energy keep to the limit, if any do.
    """
    x, y = problem.candidates.T
    difference = np.abs(source_distances[np.ix_(x, x)] - target_distances[np.ix_(y, y)])
    first, second = np.nonzero(np.triu(difference > distortion, 1))
    pairwise = problem.pairwise_matrix()
    worst = problem.n_sources * float(problem.unary.max(initial=0.0))
    worst += problem.n_sources**2 * float(pairwise[np.isfinite(pairwise)].max(initial=0.0))
    penalty = np.full(len(first), 1.0 + worst)
    terms = PairwiseTerms(first.astype(np.int64), second.astype(np.int64), penalty)
    return replace(problem, terms=terms)


def _bisect(
    source: FloatArray, target: FloatArray, one_to_one: bool, node_limit: int, control: Control
) -> MinimaxSolution:
    n, m = len(source), len(target)
    x, y = np.divmod(np.arange(n * m), m)
    distortions = np.abs(source[np.ix_(x, x)] - target[np.ix_(y, y)])
    if one_to_one:
        exclusive = (x[:, None] == x) ^ (y[:, None] == y)
        distortions[exclusive] = np.inf
    thresholds = np.unique(distortions[np.isfinite(distortions)])
    chosen = _any_correspondence(n, m, one_to_one)
    low, high = 0, int(np.searchsorted(thresholds, distortions[np.ix_(chosen, chosen)].max()))
    nodes = 0
    while low < high and nodes < node_limit and control.seconds_left() > 0.0:
        middle = (low + high) // 2
        search = _begin(distortions <= thresholds[middle], x, y, n, m, one_to_one)
        verdict = _UNDECIDED
        while verdict == _UNDECIDED and nodes < node_limit and control.seconds_left() > 0.0:
            control.check()
            verdict = _advance(search, _NODES_PER_CALL)
            nodes += _NODES_PER_CALL if verdict == _UNDECIDED else int(search.counters[1])
        if verdict == _FOUND:
            chosen = np.sort(search.chosen[: search.counters[0]])
            worst = distortions[np.ix_(chosen, chosen)].max()
            high = int(np.searchsorted(thresholds, worst))
        elif verdict == _NONE:
            low = middle + 1
    pairs = np.stack([x[chosen], y[chosen]], axis=1).astype(np.int64)
    return MinimaxSolution(pairs, float(thresholds[high]), float(thresholds[low]), nodes)


def _any_correspondence(n: int, m: int, one_to_one: bool) -> IntArray:
    count = n if one_to_one else max(n, m)
    turn = np.arange(count)
    return np.unique((turn % n) * m + turn % m).astype(np.int64)


_UNDECIDED, _FOUND, _NONE = 0, 1, 2


class _Search(NamedTuple):
    """Search for pairwise compatible pairs that cover all points; it can stop and go on."""

    compatible: BoolArray  # (V, V)
    points: IntArray  # (V, 2) numbers of the points that each pair covers, -1 for need not be
    alive: BoolArray  # (D+1, V) pairs compatible with all chosen so far
    covered: IntArray  # (P,) how many chosen pairs cover each point
    chosen: IntArray  # (D,) pairs
    branch: IntArray  # (D+1,) the point to cover at each depth
    cursor: IntArray  # (D+1,) next pair to try
    counters: IntArray  # depth, nodes, whether the node at this depth is new


def _begin(
    compatible: BoolArray, x: IntArray, y: IntArray, n: int, m: int, one_to_one: bool
) -> _Search:
    count = n if one_to_one else n + m
    second = np.full(len(y), -1) if one_to_one else n + y
    depth = count + 1
    alive = np.zeros((depth + 1, len(x)), dtype=np.bool_)
    alive[0] = np.diag(compatible)
    return _Search(
        compatible=compatible,
        points=np.stack([x, second], axis=1).astype(np.int64),
        alive=alive,
        covered=np.zeros(count, dtype=np.int64),
        chosen=np.zeros(depth, dtype=np.int64),
        branch=np.zeros(depth + 1, dtype=np.int64),
        cursor=np.zeros(depth + 1, dtype=np.int64),
        counters=np.array([0, 0, 1], dtype=np.int64),
    )


@kernel
def _advance(s: _Search, max_nodes: int) -> int:
    """Visit up to `max_nodes` more nodes; say whether a correspondence was found."""
    points, alive, covered, chosen = s.points, s.alive, s.covered, s.chosen
    depth = s.counters[0]
    for _ in range(max_nodes):
        if s.counters[2] == 1:
            s.counters[1] += 1
            s.counters[2] = 0
            s.branch[depth] = _tightest(points, alive[depth], covered)
            s.cursor[depth] = 0
            if s.branch[depth] == -1:
                s.counters[0] = depth
                return _FOUND
        point = s.branch[depth]
        a = s.cursor[depth] if point >= 0 else len(points)
        while a < len(points) and not (
            alive[depth, a] and (points[a, 0] == point or points[a, 1] == point)
        ):
            a += 1
        if a == len(points):
            if depth == 0:
                return _NONE
            depth -= 1
            for point in points[chosen[depth]]:
                if point >= 0:
                    covered[point] -= 1
            continue
        s.cursor[depth] = a + 1
        # This pair's subtree is all there is with it: later siblings do without it.
        chosen[depth] = a
        alive[depth, a] = False
        row, compatible = alive[depth], s.compatible[a]
        for b in range(len(points)):
            alive[depth + 1, b] = row[b] and compatible[b]
        for point in points[a]:
            if point >= 0:
                covered[point] += 1
        depth += 1
        s.counters[2] = 1
        s.counters[0] = depth
    s.counters[0] = depth
    return _UNDECIDED


@kernel
def _tightest(points: IntArray, alive: BoolArray, covered: IntArray) -> int:
    """Uncovered point with the fewest pairs left; -1 when all are covered, -2 for a dead end."""
    count = np.zeros(len(covered), dtype=np.int64)
    for a in range(len(points)):
        if alive[a]:
            for point in points[a]:
                if point >= 0:
                    count[point] += 1
    best = -1
    for point in range(len(covered)):
        if covered[point] == 0 and (best < 0 or count[point] < count[best]):
            best = point
    if best >= 0 and count[best] == 0:
        return -2
    return best
