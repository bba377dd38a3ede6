"""Windows on their way over a surface, nearest first, more or less.

A window is the part from `low` to `high` of a side that its lines are about to cross into the
side's face, and their origin in the plane of that face: at `x` along the side, `y` behind it, and
at distance `start` from the source. A vertex from which lines start anew waits as a window too.
"""

from typing import NamedTuple, TypeAlias

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined

Window: TypeAlias = tuple[float, float, float, float, float]
"""low, high, x, y, start."""

_BUCKETS = 4096
_USED, _FREE, _WAITING, _BUCKET = range(4)
_NONE = -1


class Front(NamedTuple):
    """Windows in slots, chained in buckets of about equal distance from the source."""

    windows: FloatArray
    """(n, 5) a window in each slot, see `Window`; of a vertex, only its distance, `start`."""
    sides: IntArray
    """(n, 2) the side of each window, and the vertex its lines start from; a vertex has no side."""
    links: IntArray
    """(n,) next slot in the same bucket, or next free one."""
    heads: IntArray
    """First slot in each bucket; the buckets are used round and round."""
    counts: IntArray
    """Slots ever used, the first free one of these, windows waiting, number of the bucket."""
    width: float
    """Difference of distances between buckets."""

    @property
    def room(self) -> int:
        """Windows that can be added for certain."""
        return len(self.links) - int(self.counts[_USED])

    @property
    def waiting(self) -> int:
        """Number of windows on their way."""
        return int(self.counts[_WAITING])

    def doubled(self) -> "Front":
        """Return the same with twice the slots."""
        return self._replace(
            windows=np.concatenate([self.windows, np.empty_like(self.windows)]),
            sides=np.concatenate([self.sides, np.empty_like(self.sides)]),
            links=np.concatenate([self.links, np.empty_like(self.links)]),
        )

    def clear(self) -> None:
        """Forget all windows."""
        self.heads[:] = _NONE
        self.counts[:] = 0, _NONE, 0, 0


def new_front(slots: int, width: float) -> Front:
    """Return an empty front.

    Parameters
    ----------
    slots
        Room for so many windows.
    width
        Difference of distances between buckets.
    """
    front = Front(
        np.empty((slots, 5)),
        np.empty((slots, 2), dtype=np.int64),
        np.empty(slots, dtype=np.int64),
        np.empty(_BUCKETS, dtype=np.int64),
        np.empty(4, dtype=np.int64),
        width,
    )
    front.clear()
    return front


@inlined
def is_at_rest(front: Front, spare: int) -> bool:
    """Whether no window waits, or there is no certain room for `spare` more."""
    counts = front.counts
    return bool(counts[_WAITING] == 0 or len(front.links) - counts[_USED] < spare)


@inlined
def put_window(front: Front, side: int, origin: int, window: Window) -> None:
    """Add a window with lines from a vertex; there must be room."""
    low, high, x, y, start = window
    aside = x - min(max(x, low), high)
    _put(front, side, origin, window, start + np.sqrt(aside * aside + y * y))


@inlined
def put_vertex(front: Front, vertex: int, distance: float) -> None:
    """Add a vertex, lines to start from; there must be room."""
    _put(front, _NONE, vertex, (0.0, 0.0, 0.0, 0.0, distance), distance)


@inlined
def take(front: Front) -> int:
    """Take out one of the nearest; its slot, which is good until the next is put in."""
    counts, heads = front.counts, front.heads
    while heads[counts[_BUCKET] & (_BUCKETS - 1)] == _NONE:
        counts[_BUCKET] += 1
    bucket = counts[_BUCKET] & (_BUCKETS - 1)
    slot = heads[bucket]
    heads[bucket] = front.links[slot]
    front.links[slot] = counts[_FREE]
    counts[_FREE] = slot
    counts[_WAITING] -= 1
    return int(slot)


@inlined
def window_in(front: Front, slot: int) -> Window:
    """Window in a slot."""
    row = front.windows
    return row[slot, 0], row[slot, 1], row[slot, 2], row[slot, 3], row[slot, 4]


@inlined
def _put(front: Front, side: int, origin: int, window: Window, distance: float) -> None:
    counts = front.counts
    slot = counts[_FREE]
    if slot == _NONE:
        slot = counts[_USED]
        counts[_USED] += 1
    else:
        counts[_FREE] = front.links[slot]
    low, high, x, y, start = window
    row = front.windows
    row[slot, 0], row[slot, 1], row[slot, 2], row[slot, 3] = low, high, x, y
    row[slot, 4] = start
    front.sides[slot, 0], front.sides[slot, 1] = side, origin
    # What belongs beyond the last bucket comes a little early, which costs time and nothing else.
    last = counts[_BUCKET] + _BUCKETS - 1
    bucket = min(max(int(distance / front.width), counts[_BUCKET]), last) & (_BUCKETS - 1)
    front.links[slot] = front.heads[bucket]
    front.heads[bucket] = slot
    counts[_WAITING] += 1
