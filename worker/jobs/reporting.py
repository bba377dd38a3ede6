"""The solver's progress and cancellation, over Redis and not too often."""

import time
from typing import Final

from broker.contracts import Progress
from broker.store import Jobs
from solver.control import Control

REPORT_INTERVAL: Final = 0.25
"""Seconds between two reports of the same stage."""

CHECK_INTERVAL: Final = 0.25
"""Seconds between two looks whether the job is cancelled."""

WAITING: Final = "in the queue"
TOTAL: Final = "total"
"""What besides the stages of a job is measured: before it begins, and all of it from then on."""


class Reporter:
    """What a running job says of itself, and hears.

    Parameters
    ----------
    jobs
        Where the job's record is.
    job_id
        The job.
    runner
        Who runs it; a job that is taken over by another runner is to be left.
    """

    def __init__(self, jobs: Jobs, job_id: str, runner: str) -> None:
        self._jobs = jobs
        self._job_id = job_id
        self._runner = runner
        self._progress = Progress(stage="", fraction=0.0)
        self._reported = -REPORT_INTERVAL
        self._checked = time.monotonic()
        self._cancelled = False
        self._since = time.monotonic()
        self._seconds: dict[str, float] = {}

    def seconds(self) -> dict[str, float]:
        """Return how long each stage took that was reported, so far."""
        return {**self._seconds, **self._present()}

    def control(self, start: float = 0.0, end: float = 1.0) -> Control:
        """Return the control of a computation that is the part from `start` to `end` of the job."""

        def report(stage: str, fraction: float) -> None:
            self._report(stage, start + (end - start) * fraction)

        return Control(on_progress=report, is_cancelled=self._is_cancelled)

    def _report(self, stage: str, fraction: float) -> None:
        now = time.monotonic()
        # Parts of a computation do not always know of each other; a bar that runs back annoys.
        fraction = min(max(fraction, self._progress.fraction), 1.0)
        if stage != self._progress.stage:
            self._seconds |= self._present()
            self._since = now
        due = stage != self._progress.stage or now - self._reported >= REPORT_INTERVAL
        self._progress = Progress(stage=stage, fraction=fraction)
        if due:
            self._reported = self._checked = now
            self._cancelled = not self._jobs.report(self._job_id, self._runner, self._progress)

    def _present(self) -> dict[str, float]:
        stage = self._progress.stage
        if not stage:
            return {}
        return {stage: self._seconds.get(stage, 0.0) + time.monotonic() - self._since}

    def _is_cancelled(self) -> bool:
        now = time.monotonic()
        if not self._cancelled and now - self._checked >= CHECK_INTERVAL:
            self._checked = now
            self._cancelled = not self._jobs.wanted(self._job_id, self._runner)
        return self._cancelled
