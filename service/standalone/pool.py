"""Worker processes on this machine: started, restarted when they die, and stopped."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from typing import Final

from broker.telemetry import logger

WARM_STOP_SECONDS: Final = 2.5
"""Seconds a worker may take to finish its job before the job is left for the next start."""

COLD_STOP_SECONDS: Final = 2.0
"""Seconds a worker may take to drop its job."""

_EARLY_DEATH: Final = 10.0
"""Seconds after its start within which a worker that dies has died early."""

_LONGEST_PAUSE: Final = 30.0
"""Longest pause in seconds before a worker that died early is restarted."""

log = logger("isomatch.pool")


@dataclass
class _Worker:
    process: subprocess.Popen[bytes]
    started: float = field(default_factory=time.monotonic)
    restart_at: float | None = None


class WorkerPool:
    """A number of worker processes.

    Parameters
    ----------
    count
        Number of processes.
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
        self._workers: list[_Worker] = []
        self.early_deaths = 0
        """Number of workers in a row that died early."""

    def start(self) -> None:
        """Start the workers."""
        self._workers = [self._spawn() for _ in range(self._count)]

    def tend(self) -> None:
        """Restart workers that died: at once, or after a growing pause if they died early."""
        now = time.monotonic()
        for index, worker in enumerate(self._workers):
            if worker.process.poll() is None:
                if now - worker.started > _EARLY_DEATH:
                    self.early_deaths = 0
            elif worker.restart_at is None:
                early = now - worker.started < _EARLY_DEATH
                self.early_deaths = self.early_deaths + 1 if early else 0
                pause = min(0.5 * 2**self.early_deaths, _LONGEST_PAUSE) if early else 0.0
                worker.restart_at = now + pause
                code = worker.process.returncode
                log.warning("worker died", pid=worker.process.pid, code=code, pause=pause)
            elif now >= worker.restart_at:
                self._workers[index] = self._spawn()

    def stop(self) -> None:
        """Stop the workers: after their jobs, then without finishing them, then by force."""
        self._signal(signal.SIGTERM)
        if not self._wait(WARM_STOP_SECONDS):
            # On the second signal a worker drops its job, which is resumed at the next start.
            self._signal(signal.SIGTERM)
            if not self._wait(COLD_STOP_SECONDS):
                self._signal(signal.SIGKILL)
                self._wait(COLD_STOP_SECONDS)
        self._workers = []

    def _spawn(self) -> _Worker:
        return _Worker(
            subprocess.Popen(
                [sys.executable, "-m", "worker", "--parent", str(os.getpid())],
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=sys.stderr,
                # Ctrl-C on the terminal reaches only this process, which stops its workers.
                start_new_session=True,
            )
        )

    def _signal(self, number: signal.Signals) -> None:
        for worker in self._workers:
            if worker.process.poll() is None:
                worker.process.send_signal(number)

    def _wait(self, seconds: float) -> bool:
        deadline = time.monotonic() + seconds
        while any(worker.process.poll() is None for worker in self._workers):
            if time.monotonic() > deadline:
                return False
            time.sleep(0.02)
        return True
