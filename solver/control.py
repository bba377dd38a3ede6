"""Time, progress, cancellation and deadlines of long computations, in one place.

Iterative methods are values with ``init``, ``step`` and ``done``; :func:`iterate` drives them all.
Loops over independent items ask :meth:`Control.in_time`; stages of a pipeline are timed and
reported by :meth:`Control.stage`.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Generic, Protocol, TypeVar

from solver.errors import Cancelled

StateT = TypeVar("StateT")
ItemT = TypeVar("ItemT")


class Status(StrEnum):
    """Why an iterative method ended."""

    CONVERGED = "converged"
    ITERATIONS = "iterations"
    DEADLINE = "deadline"


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
    timings
        Seconds spent so far in each stage, filled by :meth:`stage`.
    """

    on_progress: Callable[[str, float], None] = _report_nothing
    is_cancelled: Callable[[], bool] = _never
    deadline: float | None = None
    timings: dict[str, float] = field(default_factory=dict)

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

    @property
    def expired(self) -> bool:
        """Whether the deadline has passed."""
        return self.seconds_left() <= 0.0

    def within(self, seconds: float | None) -> "Control":
        """Return the same control with a deadline at most `seconds` from now, if any are given."""
        if seconds is None:
            return self
        limit = time.monotonic() + seconds
        return replace(self, deadline=limit if self.deadline is None else min(limit, self.deadline))

    def quiet(self) -> "Control":
        """Return the same control without progress, and with timings of its own."""
        return replace(self, on_progress=_report_nothing, timings={})

    def timed(self) -> "Control":
        """Return the same control with timings of its own."""
        return replace(self, timings={})

    @contextmanager
    def stage(self, name: str, fraction: float | None = None) -> Iterator[None]:
        """Report a stage, if a fraction is given, and add its duration to its timings.

        Raises
        ------
        Cancelled
            The caller asked to stop, before the stage began.
        """
        if fraction is not None:
            self.report(name, fraction)
        started = time.perf_counter()
        try:
            yield
        finally:
            spent = time.perf_counter() - started
            self.timings[name] = self.timings.get(name, 0.0) + spent

    def in_time(self, items: Iterable[ItemT], least: int = 0) -> Iterator[ItemT]:
        """Yield items until the deadline, but at least the first `least`.

        Raises
        ------
        Cancelled
            The caller asked to stop.
        """
        for index, item in enumerate(items):
            self.check()
            if index >= least and self.expired:
                return
            yield item


class IterativeMethod(Protocol[StateT]):
    """A method that :func:`iterate` drives: a first state, a step, and when it is enough.

    A state is either a new value at each step, or one object that the steps change.
    """

    def init(self) -> StateT:
        """Return the state to begin with."""
        ...

    def step(self, state: StateT) -> StateT:
        """Return the next state."""
        ...

    def done(self, state: StateT) -> bool:
        """Whether the state needs no further step."""
        ...


@dataclass(frozen=True)
class Iterated(Generic[StateT]):
    """Where an iteration ended, and why.

    Parameters
    ----------
    state
        The last state.
    status
        Why it is the last.
    iterations
        Steps taken.
    """

    state: StateT
    status: Status
    iterations: int


def iterate(method: IterativeMethod[StateT], iterations: int, control: Control) -> Iterated[StateT]:
    """Step from the method's first state until it is done, a limit of steps, or the deadline.

    Parameters
    ----------
    method
        What to drive.
    iterations
        The most steps.
    control
        Cancels before a step; at its deadline no further step is begun.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    state = method.init()
    for count in range(iterations):
        control.check()
        if method.done(state):
            return Iterated(state, Status.CONVERGED, count)
        if control.expired:
            return Iterated(state, Status.DEADLINE, count)
        state = method.step(state)
    return Iterated(
        state, Status.CONVERGED if method.done(state) else Status.ITERATIONS, iterations
    )
