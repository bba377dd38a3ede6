"""The driver of iterative methods: end, status, and continuation."""

import time
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from solver.control import Control, Status, iterate
from solver.errors import Cancelled


@dataclass
class Bisection:
    """√2 by bisection: the interval halves in each step."""

    tolerance: float

    def init(self) -> tuple[float, float]:
        return 1.0, 2.0

    def step(self, state: tuple[float, float]) -> tuple[float, float]:
        middle = sum(state) / 2
        return (middle, state[1]) if middle * middle < 2.0 else (state[0], middle)

    def done(self, state: tuple[float, float]) -> bool:
        return state[1] - state[0] <= self.tolerance


def test_converged() -> None:
    ended = iterate(Bisection(2.0**-20), 100, Control())
    assert (ended.status, ended.iterations) == (Status.CONVERGED, 20)
    assert ended.state[0] <= 2.0**0.5 <= ended.state[1]


def test_limit_of_iterations() -> None:
    ended = iterate(Bisection(2.0**-20), 7, Control())
    assert (ended.status, ended.iterations) == (Status.ITERATIONS, 7)
    assert ended.state[1] - ended.state[0] == 2.0**-7
    assert iterate(Bisection(2.0**-7), 7, Control()).status is Status.CONVERGED


def test_deadline_in_the_past() -> None:
    ended = iterate(Bisection(0.0), 100, Control().within(-1.0))
    assert (ended.status, ended.iterations, ended.state) == (Status.DEADLINE, 0, (1.0, 2.0))


def test_continuation_from_a_state() -> None:
    first = iterate(Bisection(2.0**-20), 7, Control())
    second = iterate(Bisection(2.0**-20), 100, Control(), first.state)
    assert (second.status, second.iterations) == (Status.CONVERGED, 13)


@dataclass
class Interrupted:
    """A method whose step passes the deadline."""

    control: Control

    def init(self) -> int:
        return 0

    def step(self, state: int) -> int:
        while not self.control.expired:
            state += 1
        return state

    def done(self, state: int) -> bool:
        return False


def test_deadline_within_the_last_step() -> None:
    control = Control().within(0.01)
    assert iterate(Interrupted(control), 1, control).status is Status.DEADLINE


def test_cancellation_between_steps() -> None:
    asked = []

    def third() -> bool:
        asked.append(1)
        return len(asked) == 3

    with pytest.raises(Cancelled):
        iterate(Bisection(0.0), 100, Control(is_cancelled=third))
    assert len(asked) == 3


def test_items_in_time() -> None:
    late = Control().within(-1.0)
    assert list(late.in_time(range(5))) == []
    assert list(late.in_time(range(5), least=2)) == [0, 1]
    assert list(Control().in_time(range(5))) == [0, 1, 2, 3, 4]


def test_no_item_is_computed_after_the_deadline() -> None:
    computed = []

    def squares() -> Iterator[int]:
        for number in range(5):
            computed.append(number)
            yield number**2

    late = Control().within(-1.0)
    assert list(late.in_time(squares(), least=2)) == [0, 1]
    assert computed == [0, 1]
    with pytest.raises(Cancelled):
        list(Control(is_cancelled=lambda: True).in_time(squares()))
    assert computed == [0, 1]


def test_stages_add_up_and_are_told() -> None:
    told: list[tuple[str, float]] = []
    control = Control(on_progress=lambda stage, fraction: told.append((stage, fraction)))
    with control.stage("first", 0.25):
        time.sleep(0.01)
    before = control.timings["first"]
    with control.stage("first"):
        time.sleep(0.01)
    assert told == [("first", 0.25)]
    assert before >= 0.01
    assert control.timings["first"] >= before + 0.01
    assert control.quiet().timings == control.timed().timings == {}


def test_progress_of_a_part_of_the_work() -> None:
    told: list[tuple[str, float]] = []
    control = Control(on_progress=lambda stage, fraction: told.append((stage, fraction)))
    part = control.between(0.5, 0.75)
    with part.stage("first", 0.0):
        part.between(0.0, 0.5).report("second", 0.5)
    part.report("third", 1.0)
    assert told == [("first", 0.5), ("second", 0.5625), ("third", 0.75)]
    assert set(control.timings) == {"first"}


def test_a_later_deadline_does_not_replace_an_earlier_one() -> None:
    control = Control().within(10.0)
    assert control.within(1000.0).deadline == control.deadline
    assert control.within(None) is control
