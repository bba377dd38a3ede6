"""What is counted over all processes: jobs by their end, their failures, and the time they took.

Jobs run in processes of their own that are gone before anybody could ask them, so what they
measured is kept here: counters in one hash, which only grow.
"""

import re
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from redis import Redis

from broker.contracts import URN, JobKind
from broker.store import keys
from broker.store.replies import text

BOUNDS: Final = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
"""Upper ends of the classes of times, in seconds; there is one more for what takes longer."""

_NUMBER: Final = re.compile(r"\d+")


@dataclass
class Times:
    """How long one stage of one kind of jobs took, over all of them.

    Attributes
    ----------
    classes
        How many took a time of each class of :data:`BOUNDS`, and longer than all of them.
    total
        Seconds in all.
    """

    classes: list[int] = field(default_factory=lambda: [0] * (len(BOUNDS) + 1))
    total: float = 0.0


@dataclass
class Counts:
    """All that is counted.

    Attributes
    ----------
    submitted
        Jobs that were queued, by kind.
    ended
        Jobs that have ended, by kind and state.
    failures
        Jobs that have failed, by kind and the name of the problem.
    times
        Times by kind and stage.
    """

    submitted: dict[str, int] = field(default_factory=dict)
    ended: dict[tuple[str, str], int] = field(default_factory=dict)
    failures: dict[tuple[str, str], int] = field(default_factory=dict)
    times: dict[tuple[str, str], Times] = field(default_factory=lambda: defaultdict(Times))


@dataclass(frozen=True)
class Tallies:
    """The counters.

    Parameters
    ----------
    client
        Connection to Redis.
    """

    client: Redis

    def time(self, kind: JobKind, stages: Mapping[str, float]) -> None:
        """Count the seconds that each stage of a job took."""
        with self.client.pipeline(transaction=False) as pipe:
            for stage, taken in stages.items():
                # Clocks of two machines differ: what began before it was asked for took no time.
                seconds = max(taken, 0.0)
                # Stages are named for people; numbers in their names would make endless many.
                name = f"{kind.value}|{_NUMBER.sub('n', stage)}"
                index = bisect_left(BOUNDS, seconds)
                pipe.hincrby(keys.TALLIES, f"class|{name}|{index}", 1)
                pipe.hincrbyfloat(keys.TALLIES, f"seconds|{name}", round(seconds, 6))
            pipe.execute()

    def read(self) -> Counts:
        """Return all counts; what only a newer version counts is left out."""
        counts = Counts()
        for field_name, value in self.client.hgetall(keys.TALLIES).items():
            match text(field_name).split("|"):
                case ["submitted", kind]:
                    counts.submitted[kind] = int(value)
                case ["ended", kind, state]:
                    counts.ended[kind, state] = int(value)
                case ["failed", kind, problem]:
                    counts.failures[kind, problem.removeprefix(URN)] = int(value)
                case ["class", kind, stage, index] if int(index) <= len(BOUNDS):
                    counts.times[kind, stage].classes[int(index)] = int(value)
                case ["seconds", kind, stage]:
                    counts.times[kind, stage].total = float(value)
        return counts
