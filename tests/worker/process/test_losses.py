"""What RQ's worker makes of jobs whose store has failed."""

import pytest
from redis.exceptions import OutOfMemoryError, RedisError
from redis.exceptions import TimeoutError as RedisTimeoutError
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.blobs import BlobsAway
from broker.contracts import JobState, MatchParameters, MatchPayload
from broker.queue import JobQueue
from broker.upkeep import LOSSES_WITH_WORKER
from worker.process.process import new_worker


@pytest.mark.parametrize("error", [OutOfMemoryError, RedisTimeoutError, BlobsAway])
def test_a_job_that_the_store_fails_too_often_says_so(
    queue: JobQueue, error: type[RedisError | BlobsAway]
) -> None:
    job = queue.submit(MatchPayload(source="a", target="b", parameters=MatchParameters())).id
    worker = new_worker(queue.store, heartbeat=5)
    for _ in range(LOSSES_WITH_WORKER + 1):
        assert queue.store.jobs.claim(job, worker.name)
        taken = Job.fetch(job, connection=queue.store.client, serializer=JSONSerializer)
        taken.worker_name = worker.name
        worker.handle_exception(taken, error, error("full"), None)
        # It waits again, behind others.
        assert not taken.enqueue_at_front_on_retry
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == "store-away"
