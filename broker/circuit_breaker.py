"""Circuit breaker of a dependency that does not answer: for a while nothing is sent to it.

The state is shared with forked processes: each job is one, and would wait for a timeout anew.
"""

import mmap
import struct
import time
from typing import Final

_STATE: Final = struct.Struct("dd")
"""When the circuit may close (monotonic time), and for how many seconds it was opened."""


class CircuitBreaker:
    """State of the circuit, common to the process that makes it and to those it forks later."""

    def __init__(self) -> None:
        self._state = mmap.mmap(-1, _STATE.size)

    def open(self, seconds: float) -> None:
        """Open the circuit for some seconds."""
        self._state[:] = _STATE.pack(time.monotonic() + seconds, seconds)

    def is_open(self) -> bool:
        """Return whether nothing is to be sent.

        When the time is over, one process tries: the circuit stays open for the others until there
        was an answer.
        """
        until, seconds = _STATE.unpack(self._state[:])
        if time.monotonic() < until:
            return True
        if seconds:
            self.open(seconds)
        return False

    def close(self) -> None:
        """Record that there was an answer."""
        self._state[:] = bytes(_STATE.size)
