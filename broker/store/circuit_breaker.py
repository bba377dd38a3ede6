"""Circuit breaker of a cache that does not answer: for a while no process of a machine
sends it commands.

Each job is a process of its own and would wait for the same timeout again. The state is kept in the
queue's Redis, one key for each machine: a cache that one machine cannot reach, another may. (A
cache that refuses connections costs no time and needs no circuit breaker.)
"""

import socket
import time
from typing import Final

from redis import Redis

from broker.store.keys import Keys
from broker.store.replies import text

_KEPT_SECONDS: Final = 10
"""Seconds for which the state is kept after the circuit may close."""


class CircuitBreaker:
    """State of the circuit to the cache: open while no command is sent to it.

    Parameters
    ----------
    client
        Connection to the Redis of the queue.
    machine
        Name of the machine whose processes share the state; by default the present one.
    """

    def __init__(self, client: Redis, machine: str | None = None) -> None:
        self._client = client
        self._key = Keys.cache_circuit(machine or socket.gethostname())
        self._was_open = False

    def open(self, seconds: float) -> None:
        """Open the circuit for some seconds."""
        until = time.time() + seconds
        milliseconds = int(1000 * (seconds + _KEPT_SECONDS))
        self._client.set(self._key, f"{until!r} {seconds!r}", px=milliseconds)

    def is_open(self) -> bool:
        """Whether no command is to be sent to the cache.

        When the time is over, one process probes the cache: the circuit stays open for the others
        until the cache has answered.
        """
        state = text(self._client.get(self._key))
        self._was_open = state is not None
        if state is None:
            return False
        until, seconds = map(float, state.split())
        if time.time() < until:
            return True
        self.open(seconds)
        return False

    def close(self) -> None:
        """Record that the cache has answered."""
        if self._was_open:
            self._client.delete(self._key)
            self._was_open = False
