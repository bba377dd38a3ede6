"""The quota of jobs of a tenant."""

import pytest

from broker.contracts import JobState, MatchParameters, MatchPayload
from broker.queue import JobQueue, QueueSettings, new_job
from broker.store import Store, TooManyQueued

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
