"""Faults under load, and a count of what became of the jobs: ``python -m bench.chaos --minutes 5``.

A cluster of a store, an API and two workers is given jobs by several callers, who ask again with
the same idempotency key until they are answered. Meanwhile one fault after the other is injected
(:mod:`bench.faults`). Then everything is left alone, and counted:

- lost: accepted jobs that the service does not know, or that succeeded without a result;
- duplicated: jobs beyond one for each key, and jobs that ended more than once;
- stuck: jobs that have not ended, and what RQ still holds;
- keys without a time to live, besides those that belong to no single job or shape.

The exit status is 1 if anything was lost, duplicated or stuck, or a key has no time to live. The
seed fixes the faults and the requests, but not which process is where at the time of a fault.
"""

import argparse
import json
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from random import Random
from typing import Any, Final

import httpx2
from redis import Redis

from bench.faults import FAULTS, restored
from bench.load import Account, Callers
from bench.machines import Cluster, running_cluster
from broker.queue import JobQueue
from broker.store import Keys, Store, text
from worker.jobs import torus_file
from worker.settings import WorkerSettings

PATIENCE: Final = 180.0
"""Seconds after the last fault within which all jobs have to end."""

SHAPES: Final = 3
CALLERS: Final = 4

PERMANENT: Final = re.compile(
    r"isomatch:(tenant:[^:]+:)?"
    r"(shapes|prototypes|jobs|jobs:(queued|running|succeeded|failed|cancelled)|held)"
    r"|isomatch:(tallies|spectra:counters|cache:(spectra|sizes)|blobs:(owner|sweep))"
    r"|isomatch:(tenants|quotas|keys|keys:ever)"
    r"|rq:(queues|workers(:.*)?|queue:.*|finished:.*|failed:.*|wip:.*|deferred:.*|scheduled:.*"
    r"|canceled:.*|clean_registries:.*)"
)
"""Listings and counters, which belong to no single job or shape, and what administrators set; RQ's
queues and registries."""


@dataclass
class Count:
    """What became of the jobs.

    Attributes
    ----------
    faults
        Number of injected faults of each kind.
    accepted
        Jobs that callers were promised.
    repeated
        Requests that had to be repeated.
    ended
        Number of these jobs by state, and of failed ones by problem.
    lost, duplicated, stuck
        What must not be, in words.
    without_ttl
        Keys without a time to live.
    died
        Processes that ended without having been killed.
    refusals
        Answers that callers did not expect, with their number.
    """

    faults: dict[str, int] = field(default_factory=dict)
    accepted: int = 0
    repeated: int = 0
    ended: dict[str, int] = field(default_factory=dict)
    lost: list[str] = field(default_factory=list)
    duplicated: list[str] = field(default_factory=list)
    stuck: list[str] = field(default_factory=list)
    without_ttl: list[str] = field(default_factory=list)
    died: list[str] = field(default_factory=list)
    refusals: dict[str, int] = field(default_factory=dict)

    @property
    def clean(self) -> bool:
        """Whether nothing was lost, duplicated, stuck, or left for ever."""
        return not (self.lost or self.duplicated or self.stuck or self.without_ttl)


def main() -> int:
    """Run the experiment and return its exit status."""
    parser = argparse.ArgumentParser(prog="python -m bench.chaos", description=__doc__)
    parser.add_argument("--minutes", type=float, default=2.0, help="time of faults and load (2)")
    parser.add_argument("--seed", type=int, default=0, help="of faults and requests (0)")
    parser.add_argument("--json", action="store_true", help="print the count as JSON")
    parser.add_argument("--logs", type=Path, help="keep logs and store in this folder")
    arguments = parser.parse_args()
    if sys.platform != "linux":
        print("bench.chaos reads /proc: it runs on Linux", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="isomatch-chaos-") as temporary:
        folder = arguments.logs or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        with running_cluster(folder) as cluster:
            count = chaos(cluster, 60.0 * arguments.minutes, arguments.seed)
    print(json.dumps(asdict(count), indent=1) if arguments.json else table(count))
    return 0 if count.clean else 1


def chaos(
    cluster: Cluster,
    seconds: float,
    seed: int,
    faults: tuple[str, ...] = (),
    callers: int = CALLERS,
) -> Count:
    """Inject faults under load, and count what became of the jobs.

    Parameters
    ----------
    cluster
        A cluster that nothing else uses.
    seconds
        Time of faults and load.
    seed
        Seed of faults and requests.
    faults
        Names of the faults in their order, over and over; by default all, at random.
    callers
        Number of callers.
    """
    count = Count()
    shapes = [cluster.upload(torus_file() + b"# %d\n" % n) for n in range(SHAPES)]
    asking = Callers(str(cluster.http.base_url), shapes, seed, callers)
    asking.start()
    try:
        injected = _inject(cluster, seconds, Random(seed), faults, count)
    finally:
        asking.stop()
    count.faults = dict(injected)
    count.died += restored(cluster)
    take_stock(cluster, asking.account, count)
    return count


def _inject(
    cluster: Cluster, seconds: float, random: Random, names: tuple[str, ...], count: Count
) -> Counter[str]:
    injected: Counter[str] = Counter()
    start = time.monotonic()
    while (now := time.monotonic() - start) < seconds:
        number = injected.total()
        name = names[number % len(names)] if names else random.choice([*FAULTS])
        _say(f"{now:6.1f} s  {name}")
        FAULTS[name](cluster, random)
        injected[name] += 1
        time.sleep(random.uniform(0.2, 3.0))
        if died := restored(cluster):
            _say(f"{time.monotonic() - start:6.1f} s  died by itself: {', '.join(died)}")
            count.died += died
    return injected


def _settle(cluster: Cluster, account: Account, count: Count) -> None:
    """Wait until all accepted jobs have ended, and record those that have not."""
    waiting, deadline = set(account.accepted), time.monotonic() + PATIENCE
    ended: Counter[str] = Counter()
    _say(f"no more faults; {len(waiting)} jobs were accepted")
    while waiting and time.monotonic() < deadline:
        for job in sorted(waiting):
            record = _record(cluster, job)
            if record is None:
                count.lost.append(f"{job}: unknown")
            elif record["state"] in ("queued", "running"):
                continue
            else:
                problem = (record["error"] or {}).get("type", "").rpartition(":")[2]
                ended[f"{record['state']} {problem}".strip()] += 1
                if record["state"] == "succeeded" and not _has_result(cluster, record):
                    count.lost.append(f"{job}: its result")
            waiting.discard(job)
        time.sleep(0.5)
    count.stuck += [f"{job}: {(_record(cluster, job) or {}).get('state')}" for job in waiting]
    count.accepted, count.repeated = len(account.accepted), account.repeated
    count.ended, count.refusals = dict(ended), dict(account.refusals)


def _record(cluster: Cluster, job: str) -> dict[str, Any] | None:
    answer = cluster.http.get(f"/v1/jobs/{job}")
    if answer.status_code in (404, 410):
        return None
    record: dict[str, Any] = answer.raise_for_status().json()
    return record


def _has_result(cluster: Cluster, record: dict[str, Any]) -> bool:
    answer: httpx2.Response = cluster.http.get(record["links"]["result"])
    return answer.status_code == 200 and bool(answer.json())


def take_stock(cluster: Cluster, account: Account, count: Count) -> None:
    """Wait for the ends of all jobs, and count what was lost, duplicated, stuck and left behind.

    Parameters
    ----------
    cluster
        The cluster, all of whose processes run again.
    account
        What its callers were promised.
    count
        The count, which is completed.
    """
    _settle(cluster, account, count)
    count.duplicated += [
        f"key {key}: {sorted(jobs)}" for key, jobs in account.jobs.items() if len(jobs) > 1
    ]
    count.duplicated += [f"{job}: of no key" for job in _listed(cluster) - account.accepted]
    settings = WorkerSettings(redis_url=cluster.store.url, blob_url=cluster.blobs)
    store = Store.open(settings, retry_seconds=1)
    try:
        queue = JobQueue(store, settings)
        deadline = time.monotonic() + PATIENCE
        # Parts of jobs that were cancelled end a little later than these.
        while (left := _left(queue)) and time.monotonic() < deadline:
            time.sleep(0.5)
        count.stuck += left
        counters = store.counters.read()
        for kind, submitted in counters.submitted.items():
            done = sum(number for (of, _), number in counters.ended.items() if of == kind)
            if done > submitted:
                count.duplicated.append(f"{kind}: {submitted} submitted, {done} ended")
        count.without_ttl += _without_ttl(store.client)
    finally:
        store.close()


def _listed(cluster: Cluster) -> set[str]:
    """Ids of all jobs that the service lists."""
    found: set[str] = set()
    after: dict[str, str] = {}
    while True:
        page = cluster.http.get("/v1/jobs", params={"limit": "200", **after}).json()
        # Matches of batches are listed with their batch alone.
        found |= {job["id"] for job in page["items"] if job["batch"] is None}
        if page["next_cursor"] is None:
            return found
        after = {"cursor": page["next_cursor"]}


def _left(queue: JobQueue) -> list[str]:
    """Return what is still active: records, and entries of RQ."""
    left = [f"{job.id}: {job.kind.value} is {job.state.value}" for job in queue.store.jobs.active()]
    for rq_queue in queue.rq.all():
        left += [f"{job}: in RQ's queue" for job in rq_queue.get_job_ids()]
        running = rq_queue.started_job_registry.get_job_ids(cleanup=False)
        left += [f"{job}: started for RQ" for job in running]
    return left


def _without_ttl(client: Redis) -> list[str]:
    """Return the keys that stay for ever, besides those that are listed where they are dropped."""
    members: list[bytes] = client.zrange(Keys.CACHED_SPECTRA, 0, -1)  # type: ignore[assignment]
    # Cached blobs are dropped when they are unused for long or the cache is full.
    cached = {Keys.cached_spectrum(text(member)) for member in members}
    return sorted(
        name
        for name in map(text, client.scan_iter(count=1000))
        if client.ttl(name) == -1 and not PERMANENT.fullmatch(name) and name not in cached
    )


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _rows(count: Count) -> Iterator[tuple[str, object]]:
    for name, number in sorted(count.faults.items()):
        yield f"fault: {name}", number
    yield "accepted", count.accepted
    yield "requests repeated", count.repeated
    for name, number in sorted(count.ended.items()):
        yield f"ended: {name}", number
    for name, number in sorted(count.refusals.items()):
        yield f"refused: {name}", number
    yield "died by themselves", len(count.died)
    for name in ("lost", "duplicated", "stuck", "without_ttl"):
        yield name.replace("_", " "), len(getattr(count, name))


def table(count: Count) -> str:
    """Return the count as text, with what must not be in full."""
    rows = [f"{name:44}{number!s:>8}" for name, number in _rows(count)]
    for name in ("died", "lost", "duplicated", "stuck", "without_ttl"):
        rows += [f"{name}: {one}" for one in getattr(count, name)[:20]]
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())
