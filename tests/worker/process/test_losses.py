"""What RQ's worker makes of jobs whose store has failed, or that overran their time."""

import pytest
from redis.exceptions import OutOfMemoryError, RedisError
from redis.exceptions import TimeoutError as RedisTimeoutError
from rq import Worker
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.blobs import BlobsAway
from broker.contracts import JobState, MatchParameters, MatchPayload
from broker.queue import JobQueue
from broker.upkeep import LOSSES_WITH_WORKER
from worker.process.process import new_worker

MATCH = MatchPayload(source="a", target="b", parameters=MatchParameters())


def taken_by(worker: Worker, job_id: str) -> Job:
    """Return a job as a worker that has taken it up holds it."""
    job = Job.fetch(job_id, connection=worker.connection, serializer=JSONSerializer)
    job.worker_name = worker.name
    return job


@pytest.mark.parametrize("error", [OutOfMemoryError, RedisTimeoutError, BlobsAway])
def test_a_job_that_the_store_fails_too_often_says_so(
    queue: JobQueue, error: type[RedisError | BlobsAway]
) -> None:
    job = queue.submit(MATCH).id
    worker = new_worker(queue.store, heartbeat=5)
    for _ in range(LOSSES_WITH_WORKER + 1):
        assert queue.store.jobs.claim(job, worker.name)
        taken = taken_by(worker, job)
        worker.handle_exception(taken, error, error("full"), None)
        # It waits again, behind others.
        assert not taken.enqueue_at_front_on_retry
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == "store-away"


def test_a_job_that_does_not_notice_its_timeout_is_not_run_again(queue: JobQueue) -> None:
    # In compiled code, say: after a minute more RQ kills its process, and reports no status of it.
    job = queue.of("acme").submit(MATCH).id
    worker = new_worker(queue.store, heartbeat=5)
    jobs = queue.store.of("acme").jobs
    assert jobs.claim(job, worker.name)
    worker.handle_work_horse_killed(taken_by(worker, job), None, None, None)
    record = jobs.get(job)
    assert record is not None
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == "timed-out"
