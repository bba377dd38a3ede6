"""Progress, cancellation and deadlines of long computations, in one place."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from solver.errors import Cancelled


def _report_nothing(stage: str, fraction: float) -> None:
    pass


def _never() -> bool:
    return False


@dataclass(frozen=True)
class Control:
    """What a computation tells its caller, and what its caller may tell it.

    Parameters
    ----------
    on_progress
        Called with the stage's name and the done fraction of the whole computation, in [0, 1].
        It is called a few times a second at most, from the computing thread.
    is_cancelled
        Asked between steps; ``True`` makes the computation leave.
    deadline
        Time on the :func:`time.monotonic` clock, in seconds, after which iterative methods return
        their best answer so far; ``None`` for no limit.
    """

    on_progress: Callable[[str, float], None] = _report_nothing
    is_cancelled: Callable[[], bool] = _never
    deadline: float | None = None

    def report(self, stage: str, fraction: float) -> None:
        """Tell the caller how far the computation is, and leave if it was cancelled.

        Raises
        ------
        Cancelled
            The caller asked to stop.
        """
        self.check()
        self.on_progress(stage, min(max(fraction, 0.0), 1.0))

    def check(self) -> None:
        """Leave if the caller asked to stop.

        Raises
        ------
        Cancelled
            The caller asked to stop.
        """
        if self.is_cancelled():
            raise Cancelled("cancelled")

    def seconds_left(self) -> float:
        """Seconds until the deadline; infinite without one, never negative."""
        if self.deadline is None:
            return float("inf")
        return max(self.deadline - time.monotonic(), 0.0)

    def within(self, seconds: float) -> "Control":
        """Return the same control with a deadline at most `seconds` from now."""
        limit = time.monotonic() + seconds
        deadline = limit if self.deadline is None else min(limit, self.deadline)
        return Control(self.on_progress, self.is_cancelled, deadline)
