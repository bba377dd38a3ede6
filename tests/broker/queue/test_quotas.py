"""The quotas of a tenant: what counts towards them, and until when."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from broker.contracts import JobState, MatchParameters, MatchPayload
from broker.queue import JobQueue, QueueSettings, new_job
from broker.store import DEFAULT_KEYS, Store, TooManyQueued
from tests.worker.figures import blob_file
from tests.workers import validation
from worker.jobs.runner import Runner

PAYLOAD = MatchPayload(source="a", target="b", parameters=MatchParameters())


def test_jobs_count_until_they_have_ended(store: Store) -> None:
    """Counted by the tenant, queued or running, whoever asks; the caller's own limit stays."""
    queue = JobQueue(store.of("small"), QueueSettings())
    queue.store.quotas.set(jobs=3)
    jobs = [queue.submit(new_job(PAYLOAD)) for _ in range(3)]
    assert queue.store.jobs.claim(jobs[0].id, "me")
    with pytest.raises(TooManyQueued) as refused:
        queue.submit(new_job(PAYLOAD))
    assert refused.value.of_tenant
    assert queue.store.jobs.succeed(jobs[0].id, "me", b"{}")
    queue.submit(new_job(PAYLOAD))
    assert queue.store.jobs.cancel(jobs[1].id) is JobState.CANCELLED
    queue.submit(new_job(PAYLOAD))
    with pytest.raises(TooManyQueued):
        queue.submit(new_job(PAYLOAD))
    JobQueue(store.of("other"), QueueSettings()).submit(new_job(PAYLOAD))


@pytest.mark.parametrize("running", [False, True])
def test_an_upload_does_not_count_once_its_validation_is_cancelled(
    queue: JobQueue, running: bool
) -> None:
    jobs, held = queue.store.jobs, DEFAULT_KEYS.held
    job = validation(queue, blob_file(1))
    before = queue.store.client.zcard(held)
    if running:
        assert jobs.claim(job, "runner")
    queue.cancel(job)
    if running:
        Runner(queue, "runner").run(job)
    assert jobs.state(job) is JobState.CANCELLED
    assert (before, queue.store.client.zcard(held)) == (1, 0)


def test_limits_that_are_set_at_the_same_time_are_all_kept(store: Store) -> None:
    quotas = store.of("small").quotas

    def kept(name: str) -> bool:
        for limit in range(50):
            quotas.set(**{name: limit})
            if quotas.own()[name] != limit:
                return False
        return True

    with ThreadPoolExecutor() as threads:
        assert all(threads.map(kept, ("shapes", "bytes", "jobs")))
