"""Minimax correspondences and the Gromov-Hausdorff distance of small point sets (section 2).

The least distortion ``dis∞(C × C) = max |d_X(x, x') − d_Y(y, y')|`` over correspondences C measures
how far two metric spaces are from isometric; half of it is the Gromov-Hausdorff distance, if every
point of either space is in a pair of C or more. The optimum is one of the finitely many differences
of distances, and is found by bisection among these: a search decides whether there is a
correspondence all of whose pairs are compatible, that is, whose distortion is at most a threshold.

The first node of a search takes polynomial time. It rejects every threshold below the lower bounds
that diameters, eccentricities, the set of all distances and the sets of distances from a point give
(Mémoli, "Some properties of Gromov-Hausdorff distances", Discrete Comput. Geom. 48, 2012).
"""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import UNLIMITED, Control, Status, iterate
from solver.labelling import LabellingProblem, Method, Solution
from solver.optimisation.exact.compatible_pairs import (
    DEPTH,
    FOUND,
    MAX_POINTS,
    NODES,
    NONE,
    WORK,
    PairSearch,
    advance,
    start_pair_search,
)

_COMPARISONS_PER_SECOND = 3e8
"""Work of one core in a second, in comparisons of domains, nearly."""
_COMPARISONS_PER_ROUND = 5_000_000
"""Work between two looks at the deadline: some 20 ms."""
_FIRST_WORK, _MORE_WORK = 6e7, 4.0
"""Work after which a search is given up at first, and its growth from one trial to the next."""


def minimax_correspondence(
    source_distances: FloatArray,
    target_distances: FloatArray,
    *,
    seconds: float = 10.0,
    control: Control | None = None,
) -> Solution[IntArray]:
    """Injective correspondence of least distortion dis∞.

    Parameters
    ----------
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics, N <= M <= 62. Twelve source points are proven within a
        second, thirty-two similar ones usually; time grows exponentially with their number.
    seconds
        Limit on the work, in seconds of a typical core, after which the best correspondence so far
        is returned with a bound. Operations are counted, so that the answer is the same everywhere.
    control
        Cancels the search, or ends it at a deadline as the limit does.

    Returns
    -------
    Solution
        N pairs in lexicographic order, and dis∞ in the unit of the distances.

    Raises
    ------
    ValueError
        There are fewer target points than source points, no points, or too many.
    Cancelled
        Through `control`.
    """
    if not 0 < len(source_distances) <= len(target_distances):
        raise ValueError("every source point needs a target point of its own")
    return _bisect(source_distances, target_distances, True, seconds, control or Control())


def gromov_hausdorff_distance(
    source_distances: FloatArray,
    target_distances: FloatArray,
    *,
    seconds: float = 10.0,
    control: Control | None = None,
) -> Solution[IntArray]:
    """Gromov-Hausdorff distance of two finite metric spaces, as a correspondence.

    A correspondence is, as in the definition, a set of pairs in which every point of either space
    occurs at least once. The distance is half its distortion.

    Parameters
    ----------
    source_distances, target_distances
        (N, N) and (M, M) symmetric metrics of at most 62 points. Twelve points each are proven
        within a second; time grows exponentially with their number.
    seconds, control
        See :func:`minimax_correspondence`.

    Returns
    -------
    Solution
        Between max(N, M) and N + M − 1 pairs in lexicographic order, and dis∞, twice the distance.

    Raises
    ------
    ValueError
        A space has no points, or too many.
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
    spaces = source_distances, target_distances
    # Fewer pairs suit the points of the wider space, which are then branched on first.
    turned = target_distances.max() > source_distances.max()
    found = _bisect(*(spaces[::-1] if turned else spaces), False, seconds, control or Control())
    pairs = np.unique(found.answer[:, ::-1] if turned else found.answer, axis=0)
    return replace(found, answer=pairs)


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
    pairwise = problem.pairwise_matrix()
    compatible = np.isfinite(pairwise)
    worst = problem.n_sources * float(problem.unary.max(initial=0.0))
    worst += problem.n_sources**2 * float(pairwise[compatible].max(initial=0.0))
    penalty = np.where((difference > distortion) & compatible, 2.0 * worst or 1.0, 0.0)
    return replace(problem, table=penalty + problem.table if len(problem.table) else penalty)


def _bisect(
    source: FloatArray, target: FloatArray, one_to_one: bool, seconds: float, control: Control
) -> Solution[IntArray]:
    if max(len(source), len(target)) > MAX_POINTS:
        raise ValueError(f"a set has more than {MAX_POINTS} points")
    method = _Bisection(source, target, one_to_one, seconds * _COMPARISONS_PER_SECOND)
    ended = iterate(method, UNLIMITED, control)
    state, status = ended.state, ended.status
    if state.low < state.high and status is Status.CONVERGED:
        status = Status.ITERATIONS
    thresholds = method.thresholds
    return Solution(
        np.stack(np.divmod(state.chosen, len(target)), axis=1),
        float(thresholds[state.high]),
        float(thresholds[state.low]),
        state.nodes,
        Method.MINIMAX,
        status,
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
    limit
        Work after which a search is given up for the time being.
    given_up
        Range of the thresholds whose searches were given up, the last one included.
    threshold, search
        Search for a correspondence of a threshold between; ``None`` if none is going on.
    nodes, work
        Search nodes visited and work done.
    """

    low: int
    high: int
    chosen: IntArray
    limit: float
    given_up: tuple[int, int] | None = None
    threshold: int = 0
    search: PairSearch | None = None
    nodes: int = 0
    work: float = 0.0


class _Bisection:
    """Bisection among the distortions of pairs, as an iterative method.

    A step is a round of the search for a correspondence of one threshold. Searches are hardest at
    the least distortion: one that takes too long is given up, both ends of the bracket are moved
    towards it, and only then is it tried again, with more work.
    """

    def __init__(
        self, source: FloatArray, target: FloatArray, one_to_one: bool, work: float
    ) -> None:
        self._source, self._target, self._one_to_one = source, target, one_to_one
        self._work = work
        # Points without partner in one search are branched on early in the next (Boussemart et al.,
        # Boosting systematic search by weighting constraints, ECAI 2004).
        self._failures = np.ones(len(source) + len(target), dtype=np.int64)
        self._order = _order_of_trial(source, target)
        lengths = (np.append(d[np.triu_indices(len(d), 1)], 0.0) for d in (source, target))
        self.thresholds = np.unique(np.abs(np.subtract.outer(*lengths)))

    def init(self) -> _Bracket:
        """Return the bracket between no distortion and that of an arbitrary correspondence."""
        n, m = len(self._source), len(self._target)
        turn = np.arange(n if self._one_to_one else max(n, m))
        chosen = np.unique((turn % n) * m + turn % m).astype(np.int64)
        return _Bracket(0, self._index(chosen), chosen, _FIRST_WORK)

    def step(self, state: _Bracket) -> _Bracket:
        """Go on searching; move an end of the bracket when the search has ended."""
        if state.search is None:
            state.threshold = _next_threshold(state)
            limit = float(self.thresholds[state.threshold])
            state.search = start_pair_search(
                self._source, self._target, limit, self._one_to_one, self._order, self._failures
            )
            state.work += len(state.search.support) ** 2
        search, before = state.search, state.search.counters.copy()
        outcome = advance(search, int(min(_COMPARISONS_PER_ROUND, state.limit)))
        state.nodes += int(search.counters[NODES] - before[NODES])
        state.work += int(search.counters[WORK] - before[WORK])
        if outcome == FOUND:
            state.chosen = np.sort(search.chosen[: search.counters[DEPTH]])
            state.high = self._index(state.chosen)
        elif outcome == NONE:
            state.low = state.threshold + 1
        elif search.counters[WORK] < state.limit:
            return state
        else:
            first, last = state.given_up or (state.threshold, state.threshold)
            state.given_up = min(first, state.threshold), max(last, state.threshold)
        state.search = None
        return state

    def done(self, state: _Bracket) -> bool:
        """Return whether the bracket is a single threshold, or the work is done."""
        return state.low >= state.high or state.work >= self._work

    def _index(self, chosen: IntArray) -> int:
        """Index of the threshold that is the distortion of some pairs."""
        x, y = np.divmod(chosen, len(self._target))
        worst = np.abs(self._source[np.ix_(x, x)] - self._target[np.ix_(y, y)]).max()
        return int(np.searchsorted(self.thresholds, worst))


def _next_threshold(state: _Bracket) -> int:
    """Return the middle of the wider range of thresholds that are not given up."""
    if state.given_up is not None:
        first, last = min(state.given_up[0], state.high), state.given_up[1] + 1
        if max(first - state.low, state.high - last) > 0:
            below = first - state.low >= state.high - last
            return (state.low + first) // 2 if below else (last + state.high) // 2
        state.given_up = None
        state.limit *= _MORE_WORK
    return (state.low + state.high) // 2


def _order_of_trial(source: FloatArray, target: FloatArray) -> IntArray:
    """(N+M, max(N, M)) partners of each point, those of most similar distances first, then −1."""
    n, m = len(source), len(target)
    near = np.empty((n, m))
    for x in range(n):
        difference = np.abs(source[x][None, :, None] - target[:, None, :])
        near[x] = difference.min(axis=2).mean(axis=1) + difference.min(axis=1).mean(axis=1)
    order = np.full((n + m, max(n, m)), -1, dtype=np.int64)
    order[:n, :m] = near.argsort(axis=1, kind="stable")
    order[n:, :n] = near.T.argsort(axis=1, kind="stable")
    return order
