"""Counters over all processes: submitted, ended and failed jobs, and histograms of their times.

Each job runs in a process of its own that no scrape would reach, so the counters are kept in one
hash.
"""

import re
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from redis import Redis

from broker.contracts import URN, JobKind
from broker.store.keys import Keys
from broker.store.replies import text

BUCKET_BOUNDS: Final = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
"""Upper bounds of the histograms' buckets, in seconds; one more bucket has no upper bound."""

_NUMBER: Final = re.compile(r"\d+")


@dataclass
class Histogram:
    """Times of one stage of one kind of jobs.

    Attributes
    ----------
    buckets
        Number of times in each bucket of :data:`BUCKET_BOUNDS`, and above the last.
    total
        Sum in seconds.
    """

    buckets: list[int] = field(default_factory=lambda: [0] * (len(BUCKET_BOUNDS) + 1))
    total: float = 0.0


@dataclass
class CounterValues:
    """Values of all counters.

    Attributes
    ----------
    submitted
        Jobs that were queued, by kind.
    ended
        Jobs that have ended, by kind and state.
    failures
        Jobs that have failed, by kind and slug of the problem.
    times
        Histograms by kind and stage.
    """

    submitted: dict[str, int] = field(default_factory=dict)
    ended: dict[tuple[str, str], int] = field(default_factory=dict)
    failures: dict[tuple[str, str], int] = field(default_factory=dict)
    times: dict[tuple[str, str], Histogram] = field(default_factory=lambda: defaultdict(Histogram))


@dataclass(frozen=True)
class Counters:
    """The counters.

    Parameters
    ----------
    client
        Connection to Redis.
    """

    client: Redis

    def observe(self, kind: JobKind, stages: Mapping[str, float]) -> None:
        """Add the seconds that each stage of a job took to the histograms."""
        with self.client.pipeline(transaction=False) as pipe:
            for stage, taken in stages.items():
                # The clocks of two machines differ: a job may begin before it was submitted.
                seconds = max(taken, 0.0)
                # Numbers in the names of stages would make any number of histograms.
                name = f"{kind.value}|{_NUMBER.sub('n', stage)}"
                index = bisect_left(BUCKET_BOUNDS, seconds)
                pipe.hincrby(Keys.COUNTERS, f"class|{name}|{index}", 1)
                pipe.hincrbyfloat(Keys.COUNTERS, f"seconds|{name}", round(seconds, 6))
            pipe.execute()

    def read(self) -> CounterValues:
        """Return the values of all counters that this version knows."""
        counts = CounterValues()
        for field_name, value in self.client.hgetall(Keys.COUNTERS).items():
            match text(field_name).split("|"):
                case ["submitted", kind]:
                    counts.submitted[kind] = int(value)
                case ["ended", kind, state]:
                    counts.ended[kind, state] = int(value)
                case ["failed", kind, problem]:
                    counts.failures[kind, problem.removeprefix(URN)] = int(value)
                case ["class", kind, stage, index] if int(index) <= len(BUCKET_BOUNDS):
                    counts.times[kind, stage].buckets[int(index)] = int(value)
                case ["seconds", kind, stage]:
                    counts.times[kind, stage].total = float(value)
        return counts
