"""Time, progress, cancellation and deadlines of long computations, in one place.

Iterative methods are values with ``init``, ``step`` and ``done``; :func:`iterate` drives them all.
Loops over independent items ask :meth:`Control.in_time`; stages of a pipeline are timed and
reported by :meth:`Control.stage`.
"""

import itertools
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Final, Generic, Protocol, TypeVar

from solver.errors import Cancelled

StateT = TypeVar("StateT")
ItemT = TypeVar("ItemT")


UNLIMITED: Final = 10**9
"""Iterations of a method that ends of itself, or at its deadline."""


class Status(StrEnum):
    """Reason for the end of an iterative method."""

    CONVERGED = "converged"
    ITERATIONS = "iterations"
    DEADLINE = "deadline"


def _report_nothing(stage: str, fraction: float) -> None:
    pass


def _never() -> bool:
    return False


@dataclass(frozen=True)
class Control:
    """Progress, cancellation, deadline and timings of a computation.

    Parameters
    ----------
    on_progress
        Called from the computing thread, a few times a second at most, with the stage's name and
        the fraction of the whole computation that is done, in [0, 1].
    is_cancelled
        Called between steps; ``True`` ends the computation by :exc:`Cancelled`.
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
        """Report progress, unless the computation was cancelled.

        Raises
        ------
        Cancelled
            The caller asked to stop.
        """
        self.check()
        self.on_progress(stage, min(max(fraction, 0.0), 1.0))

    def check(self) -> None:
        """Raise if the caller asked to stop.

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
        """Return the same control with a deadline at most `seconds` from now; ``None`` for none."""
        if seconds is None:
            return self
        limit = time.monotonic() + seconds
        return replace(self, deadline=limit if self.deadline is None else min(limit, self.deadline))

    def quiet(self) -> "Control":
        """Return the same control without progress, and with timings of its own."""
        return replace(self, on_progress=_report_nothing, timings={})

    def between(self, start: float, end: float) -> "Control":
        """Return the same control for a part of the work: its progress goes from start to end.

        Parameters
        ----------
        start, end
            Fractions of the whole work.
        """

        def report(stage: str, fraction: float) -> None:
            self.on_progress(stage, start + (end - start) * fraction)

        return replace(self, on_progress=report)

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

        Items of a generator are computed only if they are yielded.

        Raises
        ------
        Cancelled
            The caller asked to stop.
        """
        left = iter(items)
        for index in itertools.count():
            self.check()
            if index >= least and self.expired:
                return
            try:
                item = next(left)
            except StopIteration:
                return
            yield item


class IterativeMethod(Protocol[StateT]):
    """A method that :func:`iterate` drives: first state, step, and convergence.

    A state is either a new value at each step, or one object that the steps change.
    """

    def init(self) -> StateT:
        """Return the state to begin with."""
        ...

    def step(self, state: StateT) -> StateT:
        """Return the next state."""
        ...

    def done(self, state: StateT) -> bool:
        """Return whether the state needs no further step."""
        ...


@dataclass(frozen=True)
class Iterated(Generic[StateT]):
    """Last state of an iteration.

    Parameters
    ----------
    state
        The last state.
    status
        Why the iteration ended.
    iterations
        Steps taken.
    """

    state: StateT
    status: Status
    iterations: int


def iterate(
    method: IterativeMethod[StateT],
    iterations: int,
    control: Control,
    state: StateT | None = None,
) -> Iterated[StateT]:
    """Step until the method is done, the limit of steps is reached, or the deadline has passed.

    Parameters
    ----------
    method
        An iterative method.
    iterations
        Limit on the steps.
    control
        Cancels before a step; at its deadline no further step is begun.
    state
        A state to continue from, by default the method's first one.

    Raises
    ------
    Cancelled
        Through `control`.

    Examples
    --------
    >>> class Halving:
    ...     def init(self) -> float:
    ...         return 1.0
    ...
    ...     def step(self, state: float) -> float:
    ...         return state / 2.0
    ...
    ...     def done(self, state: float) -> bool:
    ...         return state < 0.1
    >>> ended = iterate(Halving(), 100, Control())
    >>> ended.state, ended.iterations
    (0.0625, 4)
    """
    if state is None:
        state = method.init()
    for count in range(iterations):
        control.check()
        if method.done(state):
            return Iterated(state, Status.CONVERGED, count)
        if control.expired:
            return Iterated(state, Status.DEADLINE, count)
        state = method.step(state)
    if method.done(state):
        return Iterated(state, Status.CONVERGED, iterations)
    # A step may itself have been cut short by the deadline.
    return Iterated(state, Status.DEADLINE if control.expired else Status.ITERATIONS, iterations)
