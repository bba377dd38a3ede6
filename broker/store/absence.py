"""A cache that is asked and says nothing: for a while no process of a machine asks it.

Jobs are processes of their own: each would find out anew, and wait for it. So it is noted in the
queue's Redis, by machine: what one cannot reach, another may. (One that refuses connections costs
nothing to be asked.)
"""

import socket
import time
from typing import Final

from redis import Redis

from broker.store import keys
from broker.store.replies import text

_REMEMBERED: Final = 10
"""Seconds for which it is remembered that it was away, after it may be asked again."""


class Absence:
    """Whether the cache is away.

    Parameters
    ----------
    client
        Connection to the Redis of the queue.
    machine
        Whose processes know of it.
    """

    def __init__(self, client: Redis, machine: str | None = None) -> None:
        self._client = client
        self._key = keys.cache_away(machine or socket.gethostname())
        self._known = False

    def begin(self, lull: float) -> None:
        """Note that it is away, and is not to be asked for so many seconds."""
        over = time.time() + lull
        self._client.set(self._key, f"{over!r} {lull!r}", px=int(1000 * (lull + _REMEMBERED)))

    def lasts(self) -> bool:
        """Whether it is not to be asked.

        When that is over, the first who asks does so for all: if it says nothing, others were not
        kept waiting for it.
        """
        noted = text(self._client.get(self._key))
        self._known = noted is not None
        if noted is None:
            return False
        over, lull = map(float, noted.split())
        if time.time() < over:
            return True
        self.begin(lull)
        return False

    def end(self) -> None:
        """Note that it has answered."""
        if self._known:
            self._client.delete(self._key)
            self._known = False
