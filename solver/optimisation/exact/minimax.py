"""Minimax correspondences and the Gromov-Hausdorff distance of small point sets (section 2).

The least distortion ``dis∞(C × C) = max |d_X(x, x') − d_Y(y, y')|`` over correspondences C measures
how far two metric spaces are from isometric; half of it is the Gromov-Hausdorff distance. The
optimum is one of the finitely many differences of distances, and is found by bisection among these:
a search decides whether there is a correspondence all of whose pairs are compatible, that is, whose
distortion is at most a threshold.
"""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control, iterate
from solver.labelling import LabellingProblem, Method, PairwiseTerms, Solution
from solver.optimisation.exact.compatible_pairs import (
    DEPTH,
    FOUND,
    NODES,
    UNDECIDED,
    PairSearch,
    advance,
    start_pair_search,
)

_NODES_PER_ROUND = 20_000
"""Nodes between two looks at the deadline: some 10 ms."""


def minimax_correspondence(
    source_distances: FloatArray,
    target_distances: FloatArray,
    *,
    node_limit: int = 20_000_000,
    control: Control | None = None,
) -> Solution[IntArray]:
    """Injective correspondence of least distortion dis∞.

    Parameters
    ----------
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics, N <= M. Exact for some ten source points; time grows
        exponentially with their number.
    node_limit
        Search nodes, in rounds of 20,000, after which the best correspondence so far is returned;
        every threshold takes at least one round.
    control
        Cancels the search, or ends it at a deadline as the node limit does.

    Returns
    -------
    Solution
        N pairs in lexicographic order, and dis∞ in the unit of the distances.

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
) -> Solution[IntArray]:
    """Gromov-Hausdorff distance of two finite metric spaces, as a correspondence.

    A correspondence is, as in the definition, a set of pairs in which every point of either space
    occurs at least once. The distance is half its distortion.

    Parameters
    ----------
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics. Exact for some eight points each; time grows
        exponentially with their number.
    node_limit, control
        See :func:`minimax_correspondence`.

    Returns
    -------
    Solution
        Between max(N, M) and N + M − 1 pairs in lexicographic order, and dis∞, twice the distance.

    Raises
    ------
    ValueError
        A space has no points.
    Cancelled
        Through `control`.

    Examples
    --------
    Two points at distance 3 and a single point: the distance is half the diameter.

    >>> import numpy as np
    >>> pair, point = np.array([[0.0, 3.0], [3.0, 0.0]]), np.zeros((1, 1))
    >>> found = gromov_hausdorff_distance(pair, point)
    >>> found.value / 2.0, found.answer.tolist(), found.certified
    (1.5, [[0, 0], [1, 0]], True)
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
    """Add a prohibitive cost to pairs of candidates that distort a distance by more than a limit.

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
) -> Solution[IntArray]:
    method = _Bisection(source, target, one_to_one)
    ended = iterate(method, -(-node_limit // _NODES_PER_ROUND), control)
    state, thresholds = ended.state, method.thresholds
    return Solution(
        method.pairs[state.chosen],
        float(thresholds[state.high]),
        float(thresholds[state.low]),
        state.nodes,
        Method.MINIMAX,
        ended.status,
    )


@dataclass(eq=False)
class _Bracket:
    """State of a bisection: the least distortion is between two thresholds.

    Parameters
    ----------
    low, high
        Indices of the thresholds.
    chosen
        (K,) pairs whose distortion is the upper threshold.
    search
        For a correspondence of the threshold between; ``None`` if it has not begun.
    nodes
        Search nodes visited.
    """

    low: int
    high: int
    chosen: IntArray
    search: PairSearch | None = None
    nodes: int = 0


class _Bisection:
    """Bisection among the distortions of pairs, as an iterative method.

    A step is a round of the search for a correspondence of the threshold in the middle.
    """

    def __init__(self, source: FloatArray, target: FloatArray, one_to_one: bool) -> None:
        n, m = self._shape = len(source), len(target)
        x, y = np.divmod(np.arange(n * m), m)
        self.pairs = np.stack([x, y], axis=1).astype(np.int64)
        self._one_to_one = one_to_one
        self._distortions = np.abs(source[np.ix_(x, x)] - target[np.ix_(y, y)])
        if one_to_one:
            self._distortions[(x[:, None] == x) ^ (y[:, None] == y)] = np.inf
        self.thresholds = np.unique(self._distortions[np.isfinite(self._distortions)])

    def init(self) -> _Bracket:
        """Return the bracket between no distortion and that of an arbitrary correspondence."""
        chosen = _any_correspondence(*self._shape, self._one_to_one)
        return _Bracket(0, self._index(chosen), chosen)

    def step(self, state: _Bracket) -> _Bracket:
        """Go on searching; move an end of the bracket when the search has ended."""
        middle = (state.low + state.high) // 2
        if state.search is None:
            compatible = self._distortions <= self.thresholds[middle]
            state.search = start_pair_search(compatible, self.pairs, *self._shape, self._one_to_one)
        search, before = state.search, int(state.search.counters[NODES])
        outcome = advance(search, _NODES_PER_ROUND)
        state.nodes += int(search.counters[NODES]) - before
        if outcome == UNDECIDED:
            return state
        state.search = None
        if outcome == FOUND:
            state.chosen = np.sort(search.chosen[: search.counters[DEPTH]])
            state.high = self._index(state.chosen)
        else:
            state.low = middle + 1
        return state

    def done(self, state: _Bracket) -> bool:
        """Return whether the bracket is a single threshold."""
        return state.low >= state.high

    def _index(self, chosen: IntArray) -> int:
        """Index of the threshold that is the distortion of some pairs."""
        worst = self._distortions[np.ix_(chosen, chosen)].max()
        return int(np.searchsorted(self.thresholds, worst))


def _any_correspondence(n: int, m: int, one_to_one: bool) -> IntArray:
    count = n if one_to_one else max(n, m)
    turn = np.arange(count)
    return np.unique((turn % n) * m + turn % m).astype(np.int64)
