"""A simulation of many workers before one Redis: jobs as discrete events.

A job waits for a worker, which then takes turns between Redis, one command at a time for all, and
a processor. The network adds a time to each turn at Redis, but nobody waits for it; its bandwidth
is a bound that is computed, not simulated. Times are exponential about their means.
"""

import heapq
from dataclasses import dataclass
from itertools import count
from random import Random


@dataclass(frozen=True)
class Load:
    """What a job takes, as it was measured.

    Parameters
    ----------
    processor
        Seconds of a processor, those included in which the worker starts and ends the process that
        runs the job.
    store
        Seconds of Redis's only thread, over all turns.
    turns
        Round trips to Redis.
    network
        Seconds of a round trip, besides Redis's own time.
    heartbeats
        Seconds of Redis's thread that each worker takes in a second, whether it works or not.
    """

    processor: float
    store: float
    turns: int
    network: float
    heartbeats: float


@dataclass(frozen=True)
class Outcome:
    """What was simulated.

    Parameters
    ----------
    rate
        Jobs per second.
    store, workers
        Share of the time in which Redis, and the average worker, was busy.
    """

    rate: float
    store: float
    workers: float


def simulate(load: Load, workers: int, processors: int, jobs: int, seed: int = 1) -> Outcome:
    """Simulate workers that always find a job.

    Parameters
    ----------
    load
        What a job takes.
    workers, processors
        Numbers of workers, and of processors that they share.
    jobs
        Number of jobs to simulate; the first fifth is not counted.
    seed
        Of the times.

    Raises
    ------
    ValueError
        Heartbeats alone are more than Redis can do.
    """
    free = 1.0 - workers * load.heartbeats
    if free <= 0.0:
        raise ValueError(f"the heartbeats of {workers} workers are more than Redis can do")
    random, order = Random(seed), count()
    # Redis does what jobs ask for in the time that heartbeats leave.
    command = load.store / load.turns / free
    step = load.processor / load.turns
    store_free, processor_free = 0.0, [0.0] * processors
    store_busy = worker_busy = 0.0
    first, done, counted_from = max(jobs // 5, 1), 0, 0.0
    events = [(0.0, next(order), 0) for _ in range(workers)]
    now = 0.0
    while done < jobs:
        now, _, turn = heapq.heappop(events)
        if turn == load.turns:
            done += 1
            if done == first:
                counted_from, store_busy, worker_busy = now, 0.0, 0.0
            heapq.heappush(events, (now, next(order), 0))
            continue
        asked, worked = _drawn(random, command), _drawn(random, step)
        store_free = max(store_free, now) + asked
        store_busy += asked
        ready = store_free + load.network
        begun = max(heapq.heappop(processor_free), ready)
        heapq.heappush(processor_free, begun + worked)
        worker_busy += begun + worked - now
        heapq.heappush(events, (begun + worked, next(order), turn + 1))
    elapsed = now - counted_from
    return Outcome(
        rate=(jobs - first) / elapsed,
        store=min(1.0, store_busy * free / elapsed + 1.0 - free),
        workers=min(1.0, worker_busy / elapsed / workers),
    )


def _drawn(random: Random, mean: float) -> float:
    return random.expovariate(1.0 / mean) if mean > 0.0 else 0.0
