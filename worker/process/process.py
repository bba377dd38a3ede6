"""The worker process: it warms up, then forks one process for each job."""

import argparse
import os
import sys
from types import TracebackType
from typing import Final

from pydantic import ValidationError
from redis.exceptions import RedisError
from rq import Queue, Worker
from rq.exceptions import AbandonedJobError
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.environment import complaints
from broker.processes import die_with_parent, forks_die_with_parent
from broker.queue import QUEUES
from broker.store import Store, connect
from broker.telemetry import configure_logging, logger
from broker.upkeep import LOSSES_AFTER_KILL, LOSSES_WITH_WORKER, give_back
from worker.process.entry_points import worker_settings
from worker.process.warmup import compile_rest, warm_up

WORKER_TTL: Final = 30
MAINTENANCE_INTERVAL: Final = 10

log = logger("isomatch.worker")


def main() -> int:
    """Run a worker until it is told to stop."""
    parser = argparse.ArgumentParser(prog="python -m worker", description=__doc__)
    parser.add_argument("--burst", action="store_true", help="leave when the queues are empty")
    parser.add_argument(
        "--warm-up", action="store_true", help="compile and keep what jobs need, and leave"
    )
    parser.add_argument(
        "--parent", type=int, metavar="PID", help="die with this process, which started the worker"
    )
    options = parser.parse_args()
    try:
        settings = worker_settings()
    except ValidationError as error:
        for complaint in complaints(error):
            print(f"worker: {complaint}", file=sys.stderr)
        return 2
    configure_logging(settings.log_level, process="worker")
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
    away = why_away(settings.redis_url)
    if away is not None:
        # Said at once: warming up takes a while, and only then it is waited for.
        log.warning("Redis does not answer yet, and will be waited for", error=away)
    warm_up()
    store = Store.open(settings, settings.redis_patience)
    # RQ says several lines about each job, and what matters of them is said here as well.
    chatty = settings.log_level == "DEBUG"
    try:
        new_worker(store, settings.heartbeat).work(
            burst=options.burst, logging_level="DEBUG" if chatty else "WARNING"
        )
    except RedisError as error:
        log.error("Redis was away for longer than it is waited for: leaving", error=str(error))
        return 1
    return 0


def why_away(url: str) -> str | None:
    """Return why Redis does not answer now, without waiting for it; None if it does."""
    with connect(url, patience=0, silence=5.0) as client:
        try:
            client.ping()
        except RedisError as error:
            return str(error) or type(error).__name__
    return None


def new_worker(store: Store, heartbeat: int) -> Worker:
    """Return a worker that serves all queues and leaves no job without an end.

    Parameters
    ----------
    store
        Where the jobs are.
    heartbeat
        Seconds between two signs of life while a job runs.
    """
    client = store.client

    def killed(job: Job, pid: int, status: int, usage: object) -> None:
        give_back(store, job, _how(status), LOSSES_AFTER_KILL)

    def raised(job: Job, kind: type[Exception], error: Exception, trace: TracebackType) -> None:
        # A job's own errors are dealt with where it runs; what comes here is the machinery's.
        how = "its worker is gone" if kind is AbandonedJobError else kind.__name__
        give_back(store, job, how, LOSSES_WITH_WORKER)

    return Worker(
        [Queue(name, connection=client, serializer=JSONSerializer) for name in QUEUES],
        connection=client,
        serializer=JSONSerializer,
        exception_handlers=[raised],
        work_horse_killed_handler=killed,
        worker_ttl=WORKER_TTL,
        job_monitoring_interval=heartbeat,
        maintenance_interval=MAINTENANCE_INTERVAL,
        log_job_description=False,
    )


def _how(status: int | None) -> str:
    if status is None:
        return "nobody knows how"
    code = os.waitstatus_to_exitcode(status)
    return f"signal {-code}" if code < 0 else f"exit status {code}"
