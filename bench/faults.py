"""Faults of a running cluster: processes that are killed or stopped, a silent or a full store."""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from typing import Final

from redis import Redis
from redis.exceptions import RedisError

from bench.machines import Cluster

LONGEST_STOP: Final = 14.0
"""Seconds that a process is stopped at most: longer than four heartbeats of a cluster, so that the
job of a stopped worker is given to another while its process still exists."""

LONGEST_SILENCE: Final = 5.0
"""Seconds that the store is silent or full at most."""

Fault = Callable[[Cluster, Random], None]


def kill_horse(cluster: Cluster, random: Random) -> None:
    """Kill the process of a running job."""
    horses = _horses(cluster)
    if horses:
        _signal(random.choice(horses), signal.SIGKILL)


def stop_horse(cluster: Cluster, random: Random) -> None:
    """Stop the process of a running job for a while."""
    horses = _horses(cluster)
    if horses:
        with _stopped(random.choice(horses)):
            time.sleep(random.uniform(1.0, LONGEST_STOP))


def kill_worker(cluster: Cluster, random: Random) -> None:
    """Kill a worker, with its job, and start another after a while."""
    worker = random.choice(cluster.workers)
    worker.kill()
    worker.wait()
    time.sleep(random.uniform(0.0, 2.0))
    cluster.workers[cluster.workers.index(worker)] = cluster.start_worker()


def stop_worker(cluster: Cluster, random: Random) -> None:
    """Stop a worker for a while, but not the process of its job."""
    with _stopped(random.choice(cluster.workers).pid):
        time.sleep(random.uniform(1.0, LONGEST_STOP))


def kill_api(cluster: Cluster, random: Random) -> None:
    """Kill the API, and start it again after a while."""
    cluster.kill_api()
    time.sleep(random.uniform(0.0, 2.0))
    cluster.api = cluster.start_api()


def stop_api(cluster: Cluster, random: Random) -> None:
    """Stop the API for a while: connections are made, and nothing answers."""
    with _stopped(cluster.api.pid):
        time.sleep(random.uniform(0.5, LONGEST_SILENCE))


def kill_store(cluster: Cluster, random: Random) -> None:
    """Kill the store, and start it again with what it has acknowledged."""
    cluster.restart_store()


def stop_store(cluster: Cluster, random: Random) -> None:
    """Stop the store for a while: it is connected and silent."""
    assert cluster.store.pid is not None
    with _stopped(cluster.store.pid):
        time.sleep(random.uniform(0.5, LONGEST_SILENCE))


def fill_store(cluster: Cluster, random: Random) -> None:
    """Have the store refuse all that takes memory, for a while."""
    with Redis.from_url(cluster.store.url) as client:
        client.config_set("maxmemory", "1")
        try:
            time.sleep(random.uniform(0.5, LONGEST_SILENCE))
        finally:
            client.config_set("maxmemory", "0")


FAULTS: Final[Mapping[str, Fault]] = {
    "kill a job's process": kill_horse,
    "stop a job's process": stop_horse,
    "kill a worker": kill_worker,
    "stop a worker": stop_worker,
    "kill the API": kill_api,
    "stop the API": stop_api,
    "kill the store": kill_store,
    "silence the store": stop_store,
    "fill the store": fill_store,
}
"""All faults. Each is over when its function returns."""


def _horses(cluster: Cluster) -> list[int]:
    """Processes of running jobs; Linux only."""
    found: list[int] = []
    for worker in cluster.workers:
        with suppress(OSError):
            children = Path(f"/proc/{worker.pid}/task/{worker.pid}/children").read_text()
            found += map(int, children.split())
    return found


@contextmanager
def _stopped(pid: int) -> Iterator[None]:
    _signal(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        _signal(pid, signal.SIGCONT)


def _signal(pid: int, number: signal.Signals) -> None:
    # A job, and so its process, may end at any time.
    with suppress(ProcessLookupError):
        os.kill(pid, number)


def restored(cluster: Cluster) -> list[str]:
    """Start what died without having been killed, and return what that was."""
    died = []
    for place, worker in enumerate(cluster.workers):
        if worker.poll() is not None:
            died.append(f"a worker, with code {worker.returncode}")
            cluster.workers[place] = cluster.start_worker()
    if _ended(cluster.api):
        died.append(f"the API, with code {cluster.api.returncode}")
        cluster.api = cluster.start_api()
    if not cluster.store.alive():
        died.append("the store")
        with suppress(RedisError):
            cluster.store.start()
    return died


def _ended(process: subprocess.Popen[str]) -> bool:
    return process.poll() is not None
