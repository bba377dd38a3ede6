"""Worker processes on this machine: started, restarted when they die, and stopped."""

import os
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

from broker.telemetry import logger

WARM_STOP_SECONDS: Final = 2.5
"""Seconds workers may take to finish their jobs before these are left for the next start."""

COLD_STOP_SECONDS: Final = 2.0
"""Seconds workers may take to drop their jobs."""

_EARLY_DEATH: Final = 10.0
"""Seconds after their start within which workers that die have died early."""

_LONGEST_PAUSE: Final = 30.0
"""Longest pause in seconds before workers that died early are restarted."""

_MOST_DOUBLINGS: Final = 6
"""Doublings of half a second that exceed the longest pause; thousands of them exceed a float."""

log = logger("isomatch.pool")


@dataclass
class _Running:
    process: subprocess.Popen[bytes]
    started: float = field(default_factory=time.monotonic)
    restart_at: float | None = None


class WorkerPool:
    """A number of worker processes, forked by one process, which replaces those that are killed.

    Parameters
    ----------
    count
        Number of workers; none is possible.
    redis_url, blob_url
        Addresses of their queue and store.
    """

    def __init__(self, count: int, redis_url: str, blob_url: str) -> None:
        self._count = count
        self._environment = {
            **os.environ,
            "ISOMATCH_REDIS_URL": redis_url,
            "ISOMATCH_BLOB_URL": blob_url,
        }
        self._running: _Running | None = None
        self.early_deaths = 0
        """How often in a row the workers died early."""

    def start(self) -> None:
        """Start the workers."""
        if self._count:
            self._running = self._spawn()

    def tend(self) -> None:
        """Restart workers that died: at once, or after a growing pause if they died early."""
        running = self._running
        if running is None:
            return
        now = time.monotonic()
        lived = now - running.started
        if running.process.poll() is None:
            if lived > _EARLY_DEATH:
                self.early_deaths = 0
        elif running.restart_at is None:
            early = lived < _EARLY_DEATH
            self.early_deaths = self.early_deaths + 1 if early else 0
            doublings = min(self.early_deaths, _MOST_DOUBLINGS)
            pause = min(0.5 * 2**doublings, _LONGEST_PAUSE) if early else 0.0
            running.restart_at = now + pause
            log.warning("workers died", code=running.process.returncode, pause=pause)
        elif now >= running.restart_at:
            self._running = self._spawn()

    def stop(self) -> None:
        """Stop the workers: after their jobs, then without finishing them, then by force."""
        if self._running is None:
            return
        process = self._running.process
        # On the second signal a worker drops its job, which is resumed at the next start.
        for seconds in (WARM_STOP_SECONDS, COLD_STOP_SECONDS):
            process.terminate()
            if _ended(process, seconds):
                break
        else:
            # They die with the process that forked them.
            process.kill()
            _ended(process, COLD_STOP_SECONDS)
        self._running = None

    def _spawn(self) -> _Running:
        return _Running(
            subprocess.Popen(
                [
                    *(sys.executable, "-m", "worker"),
                    *("--count", str(self._count)),
                    *("--parent", str(os.getpid())),
                ],
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=sys.stderr,
                # Ctrl-C on the terminal reaches only this process, which stops its workers.
                start_new_session=True,
            )
        )


def _ended(process: subprocess.Popen[bytes], seconds: float) -> bool:
    """Wait for the end of a process, and return whether it came."""
    with suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    return process.returncode is not None
