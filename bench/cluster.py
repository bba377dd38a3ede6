"""Throughput and its limits: ``python -m bench.cluster``.

Measures, on this machine, 1, 2, 4 and 8 workers before one Redis, and 1 and 3 API processes:
answers and accepted jobs per second, jobs per second that compute nothing and that match two small
shapes, and what each costs Redis. Then it simulates 100 and 1,000 workers with these costs, each
with a processor of its own, and says what is the limit. How well the simulation predicts what was
measured here is printed, too.
"""

import math
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from datetime import timedelta
from itertools import cycle
from pathlib import Path
from typing import Final

import httpx2

from bench.command_line import command_line, parsed, print_json
from bench.machines import Cluster, end, running_cluster
from bench.queueing import Load, simulate
from broker.contracts import SpectrumPayload
from broker.queue import JobQueue, QueueSettings
from broker.store import Store, StoreSettings
from broker.telemetry import configure_logging
from demo.figures import generate, write_off

VERTICES: Final = 700
MATCH: Final = {"points": 24}
CALLERS: Final = 8
"""Threads that ask at a time."""

ROUND_TRIP: Final = 0.0005
"""Seconds to another machine of the same data centre and back, for the simulation."""

NETWORK: Final = 1.25e9
"""Bytes per second of a network of 10 Gbit/s, for the simulation."""


@dataclass(frozen=True)
class Cost:
    """What jobs of one kind cost.

    Parameters
    ----------
    rate
        Jobs per second, of all workers.
    run
        Seconds from a job's beginning to its end, on average.
    busy
        Seconds of Redis's thread a job.
    turns
        Times that Redis read something from a connection, a job.
    sent
        Bytes that Redis sent and received, a job.
    """

    rate: float
    run: float
    busy: float
    turns: float
    sent: float


@dataclass(frozen=True)
class Measured:
    """What one cluster did.

    Parameters
    ----------
    workers, apis
        Its processes.
    answered, accepted
        Requests per second that read a shape, and that submit a match.
    idle
        Seconds of Redis's thread a second for each idle worker, with its share of the API's upkeep.
    empty, match
        Costs of jobs that compute nothing, and of small matches.
    """

    workers: int
    apis: int
    answered: float
    accepted: float
    idle: float
    empty: Cost
    match: Cost


def main() -> None:
    """Measure, print, simulate."""
    parser = command_line(__doc__)
    parser.add_argument("--quick", action="store_true", help="two clusters and few jobs")
    options = parsed(parser)
    configure_logging("WARNING", process="bench")
    clusters = [(1, 1), (2, 1)] if options.quick else [(1, 1), (2, 1), (4, 1), (8, 1), (2, 3)]
    jobs = 20 if options.quick else 100
    print(f"{os.cpu_count()} processors; Redis with appendfsync always; {CALLERS} callers")
    print(HEAD)
    found = []
    for workers, apis in clusters:
        found.append(measure(workers, apis, jobs))
        print(_row(found[-1]), flush=True)
    print(_causes(found[0]))
    print(_checked(found))
    print(_far(found[0], 2000 if options.quick else 20000))
    print_json(options, [asdict(one) for one in found])


def measure(workers: int, apis: int, jobs: int) -> Measured:
    """Run a cluster, and measure it.

    Parameters
    ----------
    workers, apis
        Numbers of processes.
    jobs
        Number of jobs of each kind.
    """
    with (
        tempfile.TemporaryDirectory(prefix="isomatch-") as folder,
        running_cluster(Path(folder), workers=workers) as cluster,
    ):
        urls, others = [cluster.listens], []
        for _ in range(apis - 1):
            others.append(cluster.start_api("0"))
            urls.append(cluster.listens)
        settings = StoreSettings(redis_url=cluster.store.url, blob_url=cluster.blobs)
        store = Store.open(settings, retry_seconds=10.0)
        try:
            return _measured(cluster, store, urls, workers, jobs)
        finally:
            store.close()
            for process in others:
                end(process)


def _measured(
    cluster: Cluster, store: Store, urls: Sequence[str], workers: int, jobs: int
) -> Measured:
    shapes = _shapes(cluster)
    body = {"source": shapes[0], "target": shapes[1], **MATCH}
    # Spectra are cached, and everything is in memory, from here on.
    cluster.ended(_submit(cluster.http, body))
    before, since = _info(store), time.monotonic()
    time.sleep(4.0)
    idle = (_info(store).busy - before.busy) / (time.monotonic() - since) / workers
    answered = _asked(urls, 20 * jobs, lambda http: _got(http, shapes[0]))
    queue = JobQueue(store, QueueSettings())
    cached = SpectrumPayload(shape=shapes[0], eigenpairs=1, largest_component=False)
    store.spectra.put(cached.key, b"nothing reads it")

    def submit_empty() -> list[str]:
        return [queue.submit(cached).id for _ in range(2 * jobs)]

    empty = _cost(store, submit_empty)
    accepted = [0.0]

    def submit_matches() -> list[str]:
        names: list[str] = []
        accepted[0] = _asked(urls, jobs, lambda http: names.append(_submit(http, body)))
        return names

    match = _cost(store, submit_matches)
    return Measured(workers, len(urls), answered, accepted[0], idle, empty, match)


def _shapes(cluster: Cluster) -> list[str]:
    figures, found = generate(VERTICES), []
    with tempfile.TemporaryDirectory() as folder:
        for shape in (figures.source, figures.target):
            write_off(file := Path(folder, "shape.off"), shape)
            found.append(cluster.upload(file.read_bytes()))
    return found


def _submit(http: httpx2.Client, body: dict[str, object]) -> str:
    answer = http.post("/v1/matches", json=body)
    assert answer.status_code == 202, answer.text
    name: str = answer.json()["id"]
    return name


def _got(http: httpx2.Client, shape: str) -> None:
    assert http.get(f"/v1/shapes/{shape}").status_code == 200


def _asked(urls: Sequence[str], times: int, ask: Callable[[httpx2.Client], None]) -> float:
    """Ask from several threads, each of one API, and return the answers per second."""
    clients = [
        httpx2.Client(base_url=url, timeout=60.0)
        for url, _ in zip(cycle(urls), range(CALLERS), strict=False)
    ]
    each = math.ceil(times / CALLERS)

    def repeated(http: httpx2.Client) -> None:
        for _ in range(each):
            ask(http)

    start = time.monotonic()
    with ThreadPoolExecutor(CALLERS) as threads:
        list(threads.map(repeated, clients))
    elapsed = time.monotonic() - start
    for http in clients:
        http.close()
    return each * CALLERS / elapsed


@dataclass(frozen=True)
class _Info:
    busy: float
    turns: float
    sent: float


def _info(store: Store) -> _Info:
    stats = store.client.info("stats")
    commands = store.client.info("commandstats")
    # Blocking commands count the time for which they were blocked in no version.
    busy = sum(values["usec"] for values in commands.values()) / 1e6
    sent = stats["total_net_input_bytes"] + stats["total_net_output_bytes"]
    return _Info(busy, float(stats["total_reads_processed"]), float(sent))


def _cost(store: Store, submit: Callable[[], list[str]]) -> Cost:
    before, start = _info(store), time.monotonic()
    names = submit()
    while store.client.zcard(store.keys.active_jobs):
        time.sleep(0.05)
    elapsed, after = time.monotonic() - start, _info(store)
    runs = [
        record.ended - record.started
        for record in store.jobs.records(names)
        if record is not None and record.ended is not None and record.started is not None
    ]
    count = len(names)
    return Cost(
        rate=count / elapsed,
        run=sum(runs, timedelta()).total_seconds() / len(runs),
        busy=(after.busy - before.busy) / count,
        turns=(after.turns - before.turns) / count,
        sent=(after.sent - before.sent) / count,
    )


HEAD: Final = (
    "workers  APIs   answers/s  accepted/s   empty jobs/s   matches/s"
    "   ms of Redis, kB: empty job, match"
)


def _row(found: Measured) -> str:
    costs = "; ".join(
        f"{1000 * cost.busy:.2f}, {cost.sent / 1000:.0f}" for cost in (found.empty, found.match)
    )
    return (
        f"{found.workers:7d} {found.apis:5d} {found.answered:11.0f} {found.accepted:11.1f}"
        f" {found.empty.rate:14.1f} {found.match.rate:11.2f}   {costs}"
    )


def load_of(cost: Cost, idle: float, workers: int) -> Load:
    """Return what a job takes, from what one cluster measured.

    Parameters
    ----------
    cost
        Of jobs of the kind, where processors were not shared.
    idle
        Seconds of Redis's thread a second for each worker.
    workers
        Number of workers of that cluster.
    """
    return Load(
        processor=workers / cost.rate - cost.busy,
        store=cost.busy,
        turns=max(round(cost.turns), 1),
        network=0.0,
        heartbeats=idle,
    )


def _causes(one: Measured) -> str:
    """Say where the time of a job goes, with one worker and one API."""
    whole, run = 1000 / one.empty.rate, 1000 * one.empty.run
    return (
        f"\na job that computes nothing takes {whole:.1f} ms of a worker: {run:.1f} ms from its"
        f" beginning to its end, {whole - run:.1f} ms for RQ to take it, to start a process and to"
        f" notice its end; of these Redis works {1000 * one.empty.busy:.2f} ms, in"
        f" {one.empty.turns:.0f} round trips"
        f"\nan accepted match takes {1000 * CALLERS / one.accepted:.0f} ms of each of {CALLERS}"
        f" callers, reading a shape {1000 * CALLERS / one.answered:.0f} ms"
        f"\nan idle worker takes {100 * one.idle:.3f} % of Redis"
    )


def _checked(found: Sequence[Measured]) -> str:
    one, lines = (
        found[0],
        [
            "\npredicted from one worker, and measured here (empty jobs, matches):"
            " API, Redis and callers share the processors, which the simulation leaves out"
        ],
    )
    for each in found[1:]:
        if each.apis != 1:
            continue
        told = []
        for mine, theirs in ((one.empty, each.empty), (one.match, each.match)):
            load = load_of(mine, one.idle, one.workers)
            rate = simulate(load, each.workers, os.cpu_count() or 1, 2000).rate
            told.append(f"{rate:7.2f} {theirs.rate:7.2f}")
        lines.append(f"{each.workers:4d} workers   " + "   ".join(told))
    return "\n".join(lines)


def _far(one: Measured, jobs: int) -> str:
    """Simulate many workers, each with a processor, in a network."""
    lines = [
        "\nsimulated: each worker with a processor, round trips of"
        f" {1000 * ROUND_TRIP:.1f} ms, 10 Gbit/s",
        "workers   seconds a job   jobs/s   Redis busy   workers busy   network   limit",
    ]
    for workers in (100, 1000):
        for factor in (0.0, 1.0, 10.0):
            cost = one.match if factor else one.empty
            load = load_of(cost, one.idle, one.workers)
            load = Load(
                processor=load.processor * (factor or 1.0),
                store=load.store,
                turns=load.turns,
                network=ROUND_TRIP,
                heartbeats=load.heartbeats,
            )
            try:
                told = simulate(load, workers, workers, jobs)
            except ValueError as error:
                lines.append(f"{workers:7d}   {error}")
                continue
            network = told.rate * cost.sent / NETWORK
            limit = "workers"
            if told.store > 0.9:
                limit = "Redis"
            elif network > 0.9:
                limit = "network"
            lines.append(
                f"{workers:7d} {load.processor:15.3f} {told.rate:8.0f} {told.store:11.0%}"
                f" {told.workers:13.0%} {network:10.1%}   {limit}"
            )
    accepted = f"{one.accepted:.0f}"
    lines.append(f"one API process accepts {accepted} jobs/s: so many more are needed beside each")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
