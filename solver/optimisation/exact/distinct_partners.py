"""Hall's condition for points that need different partners.

Without it, a search for an injective map of n points into n − 1 others tries all permutations, as
no two of the points contradict each other.
"""

import numpy as np

from solver.arrays import BoolArray, IntArray
from solver.kernel import kernel

_BITS = 63


@kernel
def point_without_partner(domains: IntArray, apart: IntArray, must: BoolArray, sources: int) -> int:
    """Return a point that cannot have a partner of its own though it needs one; −1 if none is seen.

    On either side, points that need different partners are collected greedily, and matched along
    augmenting paths (Kuhn, Naval Research Logistics Quarterly 2, 1955).

    Parameters
    ----------
    domains
        (N+M,) mask of the partners of each point: of the source points, then of the target points.
    apart
        (N+M,) mask of the points of the same side that need another partner.
    must
        (N+M,) whether a point needs a partner.
    sources
        Number N of source points.
    """
    owner = np.empty(_BITS, dtype=np.int64)
    for first, last in ((0, sources), (sources, len(domains))):
        owner[:] = -1
        collected = 0
        for point in range(first, last):
            if must[point] and collected & ~apart[point] == 0:
                collected |= 1 << (point - first)
                if not _augment(domains, owner, point):
                    return point
    return -1


@kernel
def _augment(domains: IntArray, owner: IntArray, point: int) -> bool:
    """Give one more point a partner of its own, along the shortest path of changes."""
    queue, parent = np.empty(_BITS, dtype=np.int64), np.empty(_BITS, dtype=np.int64)
    queue[0] = point
    reached, head, count = 0, 0, 1
    while head < count:
        one = queue[head]
        head += 1
        free = domains[one] & ~reached
        partner = 0
        while free >> partner != 0:
            if (free >> partner) & 1:
                parent[partner] = one
                if owner[partner] < 0:
                    _exchange(owner, parent, partner, point)
                    return True
                queue[count] = owner[partner]
                count += 1
            partner += 1
        reached |= free
    return False


@kernel
def _exchange(owner: IntArray, parent: IntArray, partner: int, point: int) -> None:
    """Move each point of a path to its new partner, from the free one back to the first point."""
    while True:
        one = parent[partner]
        previous = -1
        for other in range(_BITS):
            if owner[other] == one:
                previous = other
        owner[partner] = one
        if one == point:
            return
        partner = previous
