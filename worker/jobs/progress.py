"""Progress and cancellation of a job, exchanged with Redis at a limited rate."""

import time
from typing import Final

from broker.contracts import Progress
from broker.store import Jobs
from broker.tracing import StageSpans
from solver.control import Control

REPORT_INTERVAL: Final = 0.25
"""Seconds between two reports of the same stage."""

CHECK_INTERVAL: Final = 0.25
"""Seconds between two checks whether the job is cancelled."""

SHARE_FOR_PARTS: Final = 0.7
"""Share of a job's time after which no part of a collection is begun: pair or specimen."""

WAITING: Final = "in the queue"
"""Time before the job starts, beside the times of its stages."""

TOTAL: Final = "total"
"""Time from the start of the job to its end."""


class Reporter:
    """Progress, times and cancellation of a running job.

    Parameters
    ----------
    jobs
        The jobs' records.
    job_id
        The job.
    runner
        Its runner; a job that another runner holds counts as cancelled.
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
        self._spans = StageSpans()

    def seconds(self) -> dict[str, float]:
        """Return the seconds of each reported stage so far."""
        return {**self._seconds, **self._present()}

    def control(self, start: float = 0.0, end: float = 1.0) -> Control:
        """Return the control of a computation whose progress is `start` to `end` of the job's."""

        def report(stage: str, fraction: float) -> None:
            self._report(stage, start + (end - start) * fraction)

        return Control(on_progress=report, is_cancelled=self._is_cancelled)

    def _report(self, stage: str, fraction: float) -> None:
        now = time.monotonic()
        # Computations estimate their progress separately; the job's never decreases.
        fraction = min(max(fraction, self._progress.fraction), 1.0)
        if stage != self._progress.stage:
            self._seconds |= self._present()
            self._since = now
            self._spans.enter(stage)
        due = stage != self._progress.stage or now - self._reported >= REPORT_INTERVAL
        self._progress = Progress(stage=stage, fraction=fraction)
        if due:
            self._reported = self._checked = now
            self._cancelled = not self._jobs.report(self._job_id, self._runner, self._progress)

    def end(self) -> None:
        """End the span of the last stage."""
        self._spans.leave()

    def _present(self) -> dict[str, float]:
        stage = self._progress.stage
        if not stage:
            return {}
        return {stage: self._seconds.get(stage, 0.0) + time.monotonic() - self._since}

    def _is_cancelled(self) -> bool:
        now = time.monotonic()
        if not self._cancelled and now - self._checked >= CHECK_INTERVAL:
            self._checked = now
            self._cancelled = not self._jobs.is_held(self._job_id, self._runner)
        return self._cancelled
