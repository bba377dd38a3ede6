"""Search for pairwise compatible pairs that cover all points of two small sets."""

from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, IntArray
from solver.kernel import kernel

UNDECIDED, FOUND, NONE = 0, 1, 2
"""Outcomes of a search."""
DEPTH, NODES, ENTERING = 0, 1, 2
"""Positions of its counters; the last one is a flag: the node is new."""


class PairSearch(NamedTuple):
    """Depth-first search for compatible pairs that cover all points, in arrays, to be resumed."""

    compatible: BoolArray  # (V, V)
    points: IntArray  # (V, 2) points that each pair covers, -1 for those that may stay free
    alive: BoolArray  # (D+1, V) pairs compatible with all chosen so far
    covered: IntArray  # (P,) how many chosen pairs cover each point
    chosen: IntArray  # (D,) pairs
    branch: IntArray  # (D+1,) the point to cover at each depth
    cursor: IntArray  # (D+1,) next pair to try
    counters: IntArray  # (3,) see `DEPTH`


def start_pair_search(
    compatible: BoolArray, pairs: IntArray, n: int, m: int, one_to_one: bool
) -> PairSearch:
    """Return a search that has not begun.

    Parameters
    ----------
    compatible
        (V, V) whether two pairs may go together; the diagonal, whether a pair may occur.
    pairs
        (V, 2) indices (x, y).
    n, m
        Numbers of source and target points.
    one_to_one
        Whether only source points must be covered, each once.
    """
    x, y = pairs.T
    count = n if one_to_one else n + m
    second = np.full(len(y), -1) if one_to_one else n + y
    depth = count + 1
    alive = np.zeros((depth + 1, len(x)), dtype=np.bool_)
    alive[0] = np.diag(compatible)
    return PairSearch(
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
def advance(s: PairSearch, max_nodes: int) -> int:
    """Visit some more nodes, at most `max_nodes`; return the outcome."""
    points, alive, covered, chosen = s.points, s.alive, s.covered, s.chosen
    depth = s.counters[DEPTH]
    for _ in range(max_nodes):
        if s.counters[ENTERING] == 1:
            s.counters[NODES] += 1
            s.counters[ENTERING] = 0
            s.branch[depth] = _tightest(points, alive[depth], covered)
            s.cursor[depth] = 0
            if s.branch[depth] == -1:
                s.counters[DEPTH] = depth
                return FOUND
        point = s.branch[depth]
        a = s.cursor[depth] if point >= 0 else len(points)
        while a < len(points) and not (
            alive[depth, a] and (points[a, 0] == point or points[a, 1] == point)
        ):
            a += 1
        if a == len(points):
            if depth == 0:
                return NONE
            depth -= 1
            for point in points[chosen[depth]]:
                if point >= 0:
                    covered[point] -= 1
            continue
        s.cursor[depth] = a + 1
        # All correspondences with this pair are in its subtree: later siblings go without it.
        chosen[depth] = a
        alive[depth, a] = False
        row, compatible = alive[depth], s.compatible[a]
        for b in range(len(points)):
            alive[depth + 1, b] = row[b] and compatible[b]
        for point in points[a]:
            if point >= 0:
                covered[point] += 1
        depth += 1
        s.counters[ENTERING] = 1
        s.counters[DEPTH] = depth
    s.counters[DEPTH] = depth
    return UNDECIDED


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
