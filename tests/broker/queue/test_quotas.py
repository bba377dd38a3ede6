"""The quotas of a tenant: what counts towards them, and until when."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from broker.blobs import BlobsFull
from broker.contracts import (
    JobState,
    MatchParameters,
    MatchPayload,
    Problem,
    ProblemType,
    ValidationPayload,
)
from broker.queue import JobQueue, QueueSettings, new_job
from broker.store import DEFAULT_KEYS, Store, TooManyQueued
from broker.store.uploads import Uploads
from tests.worker.figures import blob_file
from tests.workers import validation
from worker.jobs.runner import Runner

PAYLOAD = MatchPayload(source="a", target="b", parameters=MatchParameters())
LOST = Problem.of(ProblemType.WORKER_LOST, "its process is gone")


def test_jobs_count_until_they_have_ended(store: Store) -> None:
    """Counted by the tenant, queued or running, whoever asks; the caller's own limit stays."""
    queue = JobQueue(store.of("small"), QueueSettings())
    queue.store.quotas.set(jobs=3)
    jobs = [queue.submit(PAYLOAD) for _ in range(3)]
    assert queue.store.jobs.claim(jobs[0].id, "me")
    with pytest.raises(TooManyQueued) as refused:
        queue.submit(PAYLOAD)
    assert refused.value.of_tenant
    assert queue.store.jobs.succeed(jobs[0].id, "me", b"{}")
    queue.submit(PAYLOAD)
    assert queue.store.jobs.cancel(jobs[1].id) is JobState.CANCELLED
    queue.submit(PAYLOAD)
    with pytest.raises(TooManyQueued):
        queue.submit(PAYLOAD)
    JobQueue(store.of("other"), QueueSettings()).submit(PAYLOAD)


def test_validations_count_until_they_have_ended(store: Store) -> None:
    """Apart from jobs: an upload does not wait for a match that takes hours."""
    queue = JobQueue(store.of("small"), QueueSettings())
    jobs, held = queue.store.jobs, queue.store.keys.held
    queue.store.quotas.set(jobs=1)
    queue.submit(PAYLOAD)

    def end(job: str, how: str) -> None:
        if how == "cancelled":
            queue.cancel(job)
        else:
            assert jobs.claim(job, "me")
        if how == "succeeded":
            assert jobs.succeed(job, "me")
        if how == "lost":
            assert jobs.lose(job, 1, LOST) is JobState.QUEUED
            refused(100)
            assert jobs.lose(job, 1, LOST) is JobState.FAILED

    def refused(seed: int) -> None:
        before = store.client.zcard(held)
        with pytest.raises(TooManyQueued) as error:
            validation(queue, blob_file(1, seed))
        assert (error.value.of_tenant, error.value.record.is_upload) == (True, True)
        assert store.client.zcard(held) == before

    for seed, how in enumerate(("cancelled", "succeeded", "lost")):
        job = validation(queue, blob_file(1, seed))
        # The same bytes are no second upload.
        assert validation(queue, blob_file(1, seed)) == job
        refused(100)
        end(job, how)
    with pytest.raises(TooManyQueued) as error:
        queue.submit(PAYLOAD)
    assert not error.value.record.is_upload


def test_no_place_is_reserved_for_ever(queue: JobQueue) -> None:
    """A process may die before it stores the job."""
    queue.admit(new_job(PAYLOAD))
    queue.admit(new_job(ValidationPayload(shape="a", name="a", file_type="off")))
    keys, client = queue.store.keys, queue.store.client
    for key in (keys.admitted, keys.validating, keys.queued_by(None), keys.validations_by(None)):
        assert client.ttl(key) > 0


def test_callers_have_a_limit_of_queued_validations(store: Store) -> None:
    queue = JobQueue(store, QueueSettings(max_queued_jobs=1))
    job = validation(queue, blob_file(1))
    with pytest.raises(TooManyQueued):
        validation(queue, blob_file(1, 1))
    assert store.jobs.claim(job, "me")
    validation(queue, blob_file(1, 1))


def test_an_upload_that_is_refused_gives_back_its_place(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    queue.store.quotas.set(jobs=1)

    def full(*_: object) -> None:
        raise BlobsFull

    with monkeypatch.context() as patched:
        patched.setattr(Uploads, "put_candidate", full)
        with pytest.raises(BlobsFull):
            validation(queue, blob_file(1))
    validation(queue, blob_file(1))


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
