"""Workers forked from one process, which imports and compiles for all of them."""

import os
import signal
import sys
import time
from contextlib import suppress
from typing import Final, NoReturn

from broker.telemetry import logger

_SHORTEST_LIFE: Final = 1.0
"""Seconds between the start of a worker and that of the one that replaces it, at least."""

_STOPS: Final = (signal.SIGINT, signal.SIGTERM)

log = logger("isomatch.worker")


def fork_workers(count: int) -> int | None:
    """Fork workers, and replace those that are killed, until SIGTERM or SIGINT.

    Each of these signals is passed on to the workers as SIGTERM. A worker that ends with an error,
    such as a store that is full, ends all: whoever started this process decides when to try again.

    Parameters
    ----------
    count
        Number of workers.

    Returns
    -------
    ``None`` in a forked worker; in the process that forked them, its exit status, when all have
    ended.
    """
    return _Workers().run(count)


class _Workers:
    def __init__(self) -> None:
        self._started: dict[int, float] = {}
        self._stopping = False
        self._status = 0

    def run(self, count: int) -> int | None:
        for number in _STOPS:
            signal.signal(number, lambda _number, _frame: self._stop())
        for _ in range(count):
            if self._fork():
                return None
        while self._started:
            pid, status = os.wait()
            if self._is_replaced(pid, os.waitstatus_to_exitcode(status)) and self._fork():
                return None
        return self._status

    def _fork(self) -> bool:
        """Fork a worker, unless all are to stop; true in it."""
        # A signal before the worker is known would not reach it.
        signal.pthread_sigmask(signal.SIG_BLOCK, _STOPS)
        pid = None if self._stopping else os.fork()
        if pid == 0:
            # Ctrl-C on a terminal reaches only the process that forks, which passes it on.
            os.setsid()
            for number in _STOPS:
                signal.signal(number, _exit)
        elif pid is not None:
            self._started[pid] = time.monotonic()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _STOPS)
        return pid == 0

    def _is_replaced(self, pid: int, code: int) -> bool:
        """Return whether a worker that has ended is to be replaced."""
        # As the first process of a container, this one also reaps what a killed worker had forked.
        started = self._started.pop(pid, None)
        if started is None or self._stopping:
            return False
        log.warning("worker died", pid=pid, code=code)
        if code > 0:
            self._status = code
            self._stop()
            return False
        time.sleep(max(started + _SHORTEST_LIFE - time.monotonic(), 0.0))
        return True

    def _stop(self) -> None:
        self._stopping = True
        for pid in list(self._started):
            # It may have ended just now.
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)


def _exit(number: int, frame: object) -> NoReturn:
    sys.exit(0)
