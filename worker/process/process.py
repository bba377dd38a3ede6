"""The worker process: warms up, then forks one process for each job, or workers that do."""

import argparse
import os
import sys
from types import TracebackType
from typing import Final

from pydantic import ValidationError
from redis.exceptions import OutOfMemoryError, RedisError
from rq import Worker
from rq.exceptions import AbandonedJobError
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.blobs import BlobError
from broker.environment import misspelt_variables, setting_errors
from broker.processes import die_with_parent, forks_die_with_parent
from broker.queue import QUEUES, FairQueue, tenant_of
from broker.store import CONNECT_TIMEOUT, Store, connect
from broker.telemetry import configure_logging, logger
from broker.tracing import exporting, prepare
from broker.upkeep import (
    LOSSES_AFTER_KILL,
    LOSSES_WITH_WORKER,
    handle_lost_process,
    store_away,
)
from worker.jobs import timed_out, worker_settings
from worker.process.prefork import fork_workers
from worker.process.warmup import compile_rest, warm_up
from worker.settings import WorkerSettings

WORKER_TTL: Final = 30
"""Seconds without a heartbeat after which RQ forgets an idle worker, which sends one every 15 s."""

MAINTENANCE_INTERVAL: Final = 10
"""Seconds between two cleanups of RQ's registries."""

log = logger("isomatch.worker")


def main() -> int:
    """Run a worker until SIGTERM."""
    options = _options()
    try:
        settings = worker_settings()
    except ValidationError as error:
        for line in setting_errors(error):
            print(f"worker: {line}", file=sys.stderr)
        return 2
    configure_logging(settings.log_level, process="worker")
    for name, meant in misspelt_variables(os.environ, WorkerSettings).items():
        log.warning("unknown setting", variable=name, meant=meant)
    if options.parent is not None:
        die_with_parent(options.parent)
    forks_die_with_parent()
    if options.warm_up:
        warm_up()
        compile_rest()
        return 0
    if settings.redis_url is None:
        print("worker: ISOMATCH_REDIS_URL is not set", file=sys.stderr)
        return 2
    if settings.blob_url is None:
        print("worker: ISOMATCH_BLOB_URL is not set", file=sys.stderr)
        return 2
    unreachable = redis_error(settings.redis_url)
    if unreachable is not None:
        # Logged before the warm-up, which takes a while.
        log.warning("Redis does not answer yet, and will be waited for", error=unreachable)
    warm_up()
    prepare()
    if options.count is not None:
        status = fork_workers(options.count)
        if status is not None:
            return status
    store = Store.open(settings, settings.worker_patience, forks=True)
    # RQ logs several lines about each job; the jobs' own logs have the same information.
    level = "DEBUG" if settings.log_level == "DEBUG" else "WARNING"
    try:
        _warn_of_a_shared_cache(store)
        new_worker(store, settings.heartbeat).work(
            burst=options.burst, max_jobs=options.jobs, logging_level=level
        )
    except RedisError as error:
        # A full store answers at once, and is not waited for: whoever starts workers does that.
        full = isinstance(error, OutOfMemoryError) or "maxmemory" in str(error)
        event = "the store is full" if full else "Redis has not answered for too long"
        log.error(f"{event}: stopping", error=str(error))
        return 1
    return 0


def _options() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m worker", description=__doc__)
    parser.add_argument(
        "--parent", type=int, metavar="PID", help="die with this process, which started the worker"
    )
    parser.add_argument("--jobs", type=int, metavar="N", help="stop after so many jobs")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--burst", action="store_true", help="stop when the queues are empty")
    how.add_argument(
        "--warm-up", action="store_true", help="compile and cache what jobs need, and stop"
    )
    how.add_argument(
        "--count",
        type=int,
        metavar="N",
        help="fork so many workers of this process, and replace those that are killed",
    )
    options = parser.parse_args()
    for name in ("count", "jobs"):
        number = getattr(options, name)
        if number is not None and number < 1:
            parser.error(f"argument --{name}: at least 1")
    return options


def _warn_of_a_shared_cache(store: Store) -> None:
    budget, wanted = store.spectra.budget(), store.settings.cache_bytes
    if budget < wanted:
        log.warning(
            "the cache is in the Redis of the queue, which limits it (ISOMATCH_CACHE_URL)",
            bytes=budget,
            wanted=wanted,
        )


def redis_error(url: str) -> str | None:
    """Return the error of a connection to Redis, None if it answers."""
    with connect(url, retry_seconds=0, timeout=CONNECT_TIMEOUT) as client:
        try:
            client.ping()
        except RedisError as error:
            return str(error) or type(error).__name__
    return None


def new_worker(store: Store, heartbeat: int) -> Worker:
    """Return a worker that serves all queues and handles lost processes.

    Parameters
    ----------
    store
        The store.
    heartbeat
        Seconds between two heartbeats while a job runs.
    """
    client = store.client

    def killed(job: Job, pid: int | None, status: int | None, usage: object) -> None:
        # RQ itself has killed a process that did not notice its timeout, and then gives no status.
        allowed, reason = LOSSES_AFTER_KILL, None
        if status is None:
            allowed, reason = 0, timed_out(store.of(tenant_of(job)).jobs.readable(job.id))
        with exporting("worker"):
            handle_lost_process(store, job, _describe(status), allowed, worker.name, reason)

    def raised(job: Job, kind: type[Exception], error: Exception, trace: TracebackType) -> None:
        # The runner handles the errors of jobs; these are RQ's own, or the store's.
        how = "its worker is gone" if kind is AbandonedJobError else kind.__name__
        reason = store_away() if issubclass(kind, (BlobError, RedisError)) else None
        with exporting("worker"):
            handle_lost_process(store, job, how, LOSSES_WITH_WORKER, job.worker_name, reason)

    worker = Worker(
        [FairQueue(name, connection=client, serializer=JSONSerializer) for name in QUEUES],
        connection=client,
        queue_class=FairQueue,
        serializer=JSONSerializer,
        exception_handlers=[raised],
        work_horse_killed_handler=killed,
        worker_ttl=WORKER_TTL,
        job_monitoring_interval=heartbeat,
        maintenance_interval=MAINTENANCE_INTERVAL,
        log_job_description=False,
    )
    return worker


def _describe(status: int | None) -> str:
    if status is None:
        return "its time was up"
    code = os.waitstatus_to_exitcode(status)
    return f"signal {-code}" if code < 0 else f"exit status {code}"
