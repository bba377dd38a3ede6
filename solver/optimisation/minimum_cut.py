"""Minimum cuts of graphs with real capacities."""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel

_NEGLIGIBLE = 1e-12
"""Residual capacity, over the greatest one, that counts as none: it is a rounding error."""


@kernel
def minimum_cut(
    tails: IntArray, heads: IntArray, capacities: FloatArray, source: int, sink: int
) -> tuple[float, BoolArray]:
    """Maximum flow and minimum cut, by blocking flows of shortest paths.

    Dinic, "Algorithm for solution of a problem of maximum flow in networks with power estimation",
    1970. Each path saturates an arc, so that real capacities need no rounding, and the flow is
    never greater than the maximum but by errors of double precision.

    Parameters
    ----------
    tails, heads, capacities
        (E,) arcs; capacities are not negative. Several arcs may join the same nodes.
    source, sink
        The last two nodes.

    Returns
    -------
    flow, side
        Value of the flow; (n,) whether each node is on the source's side of the cut that has the
        fewest nodes there.
    """
    n, count = max(source, sink) + 1, len(tails)
    # Arc 2 e + 1 is the reverse of arc 2 e; arcs are listed by the nodes that they leave.
    first = np.zeros(n + 2, dtype=np.int64)
    for e in range(count):
        first[tails[e] + 2] += 1
        first[heads[e] + 2] += 1
    first = np.cumsum(first)
    arcs, ends = np.empty(2 * count, dtype=np.int64), np.empty(2 * count, dtype=np.int64)
    left = np.zeros(2 * count)
    for e in range(count):
        left[2 * e] = capacities[e]
        ends[2 * e], ends[2 * e + 1] = heads[e], tails[e]
        for arc, node in ((2 * e, tails[e]), (2 * e + 1, heads[e])):
            arcs[first[node + 1]] = arc
            first[node + 1] += 1
    least = _NEGLIGIBLE * capacities.max() if count else 0.0
    flow = 0.0
    while True:
        # From the sink: paths down these levels end nowhere else.
        level = _levels(first, arcs, ends, left, least, sink, 1)
        if level[source] < 0:
            return flow, _levels(first, arcs, ends, left, least, source, 0) >= 0
        flow += _block(first, arcs, ends, left, least, level, source, sink)


@kernel
def _levels(
    first: IntArray,
    arcs: IntArray,
    ends: IntArray,
    left: FloatArray,
    least: float,
    start: int,
    back: int,
) -> IntArray:
    """(n,) arcs with capacity left from the start to each node, or with `back` 1 to the start.

    -1 where there is no such path.
    """
    level = np.full(len(first) - 2, -1)
    queue, count = np.empty_like(level), 1
    queue[0], level[start] = start, 0
    place = 0
    while place < count:
        node = queue[place]
        place += 1
        for arc in arcs[first[node] : first[node + 1]]:
            if level[ends[arc]] < 0 and left[arc ^ back] > least:
                level[ends[arc]] = level[node] + 1
                queue[count] = ends[arc]
                count += 1
    return level


@kernel
def _block(
    first: IntArray,
    arcs: IntArray,
    ends: IntArray,
    left: FloatArray,
    least: float,
    level: IntArray,
    source: int,
    sink: int,
) -> float:
    """Send a blocking flow along shortest paths, and return its value."""
    following, path = first.copy(), np.empty_like(level)
    node, depth, flow = source, 0, 0.0
    while True:
        if node == sink:
            sent = left[path[:depth]].min()
            flow += sent
            for place in range(depth - 1, -1, -1):
                left[path[place]] -= sent
                left[path[place] ^ 1] += sent
                if left[path[place]] <= least:
                    # Another path may leave the last one before the first arc that is full.
                    depth, node = place, ends[path[place] ^ 1]
        elif following[node] < first[node + 1]:
            arc = arcs[following[node]]
            if level[ends[arc]] == level[node] - 1 and left[arc] > least:
                path[depth], node = arc, ends[arc]
                depth += 1
            else:
                following[node] += 1
        elif depth:
            depth -= 1
            node = ends[path[depth] ^ 1]
            following[node] += 1
        else:
            return flow
