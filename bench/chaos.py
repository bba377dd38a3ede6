"""Faults under load, and a count of what became of the jobs: ``python -m bench.chaos --minutes 5``.

A cluster of a store, an API and two workers is given jobs by several callers of two tenants, who
ask again with the same idempotency key until they are answered. Meanwhile one fault after the other
is injected (:mod:`bench.faults`). Then everything is left alone, and counted:

- lost: accepted jobs that the service does not know, or that succeeded without a result;
- duplicated: jobs beyond one for each key, and jobs that ended more than once;
- stuck: jobs that have not ended, and what RQ still holds;
- leaked: jobs that the other tenant is shown;
- keys without a time to live, besides those that belong to no single job or shape.

The exit status is 1 if there is any of these. The
seed fixes the faults and the requests, but not which process is where at the time of a fault.
"""

import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from random import Random
from typing import Any, Final, cast

import httpx2
from redis import Redis

from bench.command_line import command_line, parsed, print_json
from bench.faults import FAULTS, restored
from bench.load import MOST_OPEN, Account, Callers
from bench.machines import Cluster, running_cluster
from broker.contracts import DEFAULT_TENANT
from broker.queue import JobQueue, QueueSettings
from broker.store import Keys, Store, text
from worker.jobs import torus_file
from worker.settings import WorkerSettings

PATIENCE: Final = 180.0
"""Seconds after the last fault within which all jobs have to end."""

SHAPES: Final = 3
TENANTS: Final = (DEFAULT_TENANT, "other")
CALLERS: Final = 2
"""Callers of each tenant."""

PERMANENT: Final = re.compile(
    r"isomatch:(tenant:[^:]+:)?"
    r"(shapes|prototypes|jobs|jobs:(queued|running|succeeded|failed|cancelled)|held)"
    r"|isomatch:(tallies|spectra:counters|cache:(spectra|sizes)|blobs:(owner|sweep)|listings:sweep)"
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
    lost, duplicated, stuck, leaked
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
    leaked: list[str] = field(default_factory=list)
    without_ttl: list[str] = field(default_factory=list)
    died: list[str] = field(default_factory=list)
    refusals: dict[str, int] = field(default_factory=dict)

    @property
    def clean(self) -> bool:
        """Whether nothing was lost, duplicated, stuck, leaked, or left for ever."""
        return not any(getattr(self, name) for name in _WRONG)


_WRONG: Final = ("lost", "duplicated", "stuck", "leaked", "without_ttl")


def main() -> int:
    """Run the experiment and return its exit status."""
    parser = command_line(__doc__)
    parser.add_argument("--minutes", type=float, default=2.0, help="time of faults and load (2)")
    parser.add_argument("--seed", type=int, default=0, help="of faults and requests (0)")
    parser.add_argument("--logs", type=Path, help="keep logs and store in this folder")
    arguments = parsed(parser)
    if sys.platform != "linux":
        print("bench.chaos reads /proc: it runs on Linux", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="isomatch-chaos-") as temporary:
        folder = arguments.logs or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        with running_cluster(folder) as cluster:
            count = chaos(cluster, 60.0 * arguments.minutes, arguments.seed)
    print(table(count))
    print_json(arguments, asdict(count))
    return 0 if count.clean else 1


def chaos(
    cluster: Cluster,
    seconds: float,
    seed: int,
    faults: tuple[str, ...] = (),
    callers: int = CALLERS,
    most_open: int = MOST_OPEN,
) -> Count:
    """Inject faults under load, and count what became of the jobs.

    Parameters
    ----------
    cluster
        A cluster that nothing else uses. Its client gets the key of the default tenant.
    seconds
        Time of faults and load.
    seed
        Seed of faults and requests.
    faults
        Names of the faults in their order, over and over; by default all, at random.
    callers
        Number of callers of each tenant.
    most_open
        Jobs of one caller that have not ended.
    """
    count = Count()
    with _other_tenant(cluster) as other:
        parties = []
        for number, http in enumerate((cluster.http, other)):
            shapes = [cluster.upload(torus_file() + b"# %d\n" % n, http) for n in range(SHAPES)]
            parties.append(Callers(http, shapes, seed + number, callers, most_open))
        for party in parties:
            party.start()
        try:
            injected = _inject(cluster, seconds, Random(seed), faults, count)
        finally:
            for party in parties:
                party.stop()
        count.faults = dict(injected)
        count.died += restored(cluster)
        take_stock(cluster, {party.service: party.account for party in parties}, count)
    return count


@contextmanager
def _other_tenant(cluster: Cluster) -> Iterator[httpx2.Client]:
    """Create a key for each tenant: for the cluster's client, and for the one that is returned."""
    store = open_store(cluster)
    try:
        first, second = (store.api_keys.create(tenant, "caller") for tenant in TENANTS)
    finally:
        store.close()
    cluster.until(lambda: cluster.http.get("/v1/shapes").status_code == 401, 60)
    cluster.http.headers["Authorization"] = f"Bearer {first}"
    headers = {"Authorization": f"Bearer {second}"}
    with httpx2.Client(base_url=cluster.http.base_url, headers=headers, timeout=300.0) as http:
        # Both keys are known once one is, or a moment later.
        cluster.until(lambda: http.get("/v1/shapes").status_code == 200, 60)
        yield http


def open_store(cluster: Cluster) -> Store:
    """Return the store of a cluster."""
    settings = WorkerSettings(redis_url=cluster.store.url, blob_url=cluster.blobs)
    return Store.open(settings, retry_seconds=1)


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


def _settle(http: httpx2.Client, account: Account, count: Count) -> None:
    """Wait until all accepted jobs of a tenant have ended, and record those that have not."""
    waiting, deadline = set(account.accepted), time.monotonic() + PATIENCE
    ended: Counter[str] = Counter()
    _say(f"no more faults; {len(waiting)} jobs of a tenant were accepted")
    while waiting and time.monotonic() < deadline:
        for job in sorted(waiting):
            record = _record(http, job)
            if record is None:
                count.lost.append(f"{job}: unknown")
            elif record["state"] in ("queued", "running"):
                continue
            else:
                problem = (record["error"] or {}).get("type", "").rpartition(":")[2]
                ended[f"{record['state']} {problem}".strip()] += 1
                if record["state"] == "succeeded" and not _has_result(http, record):
                    count.lost.append(f"{job}: its result")
            waiting.discard(job)
        time.sleep(0.5)
    count.stuck += [f"{job}: {(_record(http, job) or {}).get('state')}" for job in waiting]
    count.accepted += len(account.accepted)
    count.repeated += account.repeated
    count.ended = dict(Counter(count.ended) + ended)
    count.refusals = dict(Counter(count.refusals) + Counter(account.refusals))


def _record(http: httpx2.Client, job: str) -> dict[str, Any] | None:
    answer = http.get(f"/v1/jobs/{job}")
    if answer.status_code in (404, 410):
        return None
    record: dict[str, Any] = answer.raise_for_status().json()
    return record


def _has_result(http: httpx2.Client, record: dict[str, Any]) -> bool:
    answer: httpx2.Response = http.get(record["links"]["self"] + "/result")
    return answer.status_code == 200 and bool(answer.json())


def take_stock(cluster: Cluster, accounts: Mapping[httpx2.Client, Account], count: Count) -> None:
    """Wait for the ends of all jobs, and count what was lost, duplicated, stuck and left behind.

    Parameters
    ----------
    cluster
        The cluster, all of whose processes run again.
    accounts
        What the callers of each tenant were promised, by a client of the tenant.
    count
        The count, which is completed.
    """
    for http, account in accounts.items():
        _settle(http, account, count)
        count.duplicated += [
            f"key {key}: {sorted(jobs)}" for key, jobs in account.jobs.items() if len(jobs) > 1
        ]
        count.duplicated += [f"{job}: of no key" for job in _listed(http) - account.accepted]
        others = (other.accepted for other in accounts.values() if other is not account)
        for job in set().union(*others):
            if _record(http, job) is not None:
                count.leaked.append(job)
    store = open_store(cluster)
    try:
        queue = JobQueue(store, QueueSettings())
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


def _listed(http: httpx2.Client) -> set[str]:
    """Ids of all jobs that the service lists for a tenant."""
    found: set[str] = set()
    after: dict[str, str] = {}
    while True:
        page = http.get("/v1/jobs", params={"limit": "200", **after}).json()
        # Matches of batches are listed with their batch alone.
        found |= {job["id"] for job in page["items"] if job["batch"] is None}
        if page["next_cursor"] is None:
            return found
        after = {"cursor": page["next_cursor"]}


def _left(queue: JobQueue) -> list[str]:
    """Return what is still active: records, and entries of RQ."""
    left = [
        f"{job.id}: {job.kind.value} is {job.state.value}"
        for tenant in queue.store.tenants()
        for job in queue.store.of(tenant).jobs.active()
    ]
    for rq_queue in queue.rq.all():
        left += [f"{job}: in RQ's queue" for job in rq_queue.get_job_ids()]
        running = rq_queue.started_job_registry.get_job_ids(cleanup=False)
        left += [f"{job}: started for RQ" for job in running]
    return left


def _without_ttl(client: Redis) -> list[str]:
    """Return the keys that stay for ever, besides those that are listed where they are dropped."""
    members = cast(list[bytes], client.zrange(Keys.CACHED_SPECTRA, 0, -1))
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
    for name in _WRONG:
        yield name.replace("_", " "), len(getattr(count, name))


def table(count: Count) -> str:
    """Return the count as text, with what must not be in full."""
    rows = [f"{name:44}{number!s:>8}" for name, number in _rows(count)]
    for name in ("died", *_WRONG):
        rows += [f"{name}: {one}" for one in getattr(count, name)[:20]]
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())
