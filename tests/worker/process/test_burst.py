"""A worker that leaves by itself."""

import os
import subprocess
import sys

from broker.contracts import JobState
from broker.queue import JobQueue
from tests.worker.figures import blob_file
from tests.workers import validation


def test_a_worker_leaves_after_so_many_jobs(queue: JobQueue) -> None:
    jobs = [validation(queue, blob_file(1, seed)) for seed in range(3)]
    settings = queue.store.jobs.settings
    assert settings.redis_url is not None
    assert settings.blob_url is not None
    stores = {"ISOMATCH_REDIS_URL": settings.redis_url, "ISOMATCH_BLOB_URL": settings.blob_url}
    command = [sys.executable, "-m", "worker", "--burst", "--jobs", "2"]
    subprocess.run(command, env={**os.environ, **stores}, timeout=540, check=True)
    states = [queue.store.jobs.state(job) for job in jobs]
    assert states == [JobState.SUCCEEDED, JobState.SUCCEEDED, JobState.QUEUED]
