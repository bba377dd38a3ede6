"""Recovery, webhooks and retention are those of all tenants."""

from datetime import timedelta

from rq.job import Job
from rq.serializers import JSONSerializer

from broker.contracts import (
    JobState,
    MatchParameters,
    MatchPayload,
    RequestOrigin,
    SpectrumKey,
    Webhook,
)
from broker.queue import JobQueue, tenant_of
from broker.upkeep import (
    RecoveryTimeouts,
    Sweep,
    evict_deleted,
    handle_lost_process,
    recover,
)
from broker.webhooks import WebhookSettings, dispatch
from tests.worker.figures import blob_file
from tests.worker.records import shape_record
from tests.workers import validation

NOW = RecoveryTimeouts(unknown=timedelta(0), heartbeat=timedelta(0), cancellation=timedelta(0))
MATCH = MatchPayload(source="a", target="b", parameters=MatchParameters())
SHAPE = "a" * 32


def waiting(queue: JobQueue) -> dict[str, str]:
    """Return the tenants of the jobs that wait for workers, by id."""
    ids = [name for one in queue.rq.all() for name in one.get_job_ids()]
    client, found = queue.store.client, {}
    for name in ids:
        found[name] = tenant_of(Job.fetch(name, connection=client, serializer=JSONSerializer))
    return found


def lose(queue: JobQueue) -> None:
    """Let a worker take all jobs, and die before it says so."""
    for one in queue.rq.all():
        for name in one.get_job_ids():
            one.remove(name)


def test_jobs_carry_their_tenant_and_are_recovered_with_it(queue: JobQueue) -> None:
    acme = queue.of("acme")
    jobs = {
        acme.submit(MATCH).id: "acme",
        validation(acme, blob_file(1)): "acme",
        queue.submit(MATCH).id: "default",
    }
    assert waiting(queue) == jobs
    for one in acme.store.jobs.active():
        job = Job.fetch(one.id, connection=queue.store.client, serializer=JSONSerializer)
        assert job.meta["tenant"] == "acme"
    lose(queue)
    for _ in range(2):
        recover(queue, NOW)
    assert waiting(queue) == jobs
    assert queue.store.client.hlen(acme.store.keys.unseen_jobs) == 0


def test_a_killed_job_is_its_tenants(queue: JobQueue) -> None:
    job_id = queue.of("acme").submit(MATCH).id
    own = queue.store.of("acme").jobs
    job = Job.fetch(job_id, connection=queue.store.client, serializer=JSONSerializer)
    assert own.claim(job_id, "me")
    handle_lost_process(queue.store, job, "signal 9", 1, "me")
    assert own.state(job_id) is JobState.QUEUED
    assert own.claim(job_id, "me")
    handle_lost_process(queue.store, job, "signal 9", 1, "me")
    assert own.state(job_id) is JobState.FAILED


def test_a_late_process_leaves_a_job_to_its_new_worker(queue: JobQueue) -> None:
    job_id = queue.submit(MATCH).id
    jobs = queue.store.jobs
    job = Job.fetch(job_id, connection=queue.store.client, serializer=JSONSerializer)
    assert jobs.claim(job_id, "old")
    handle_lost_process(queue.store, job, "its worker is gone", 1, "old")
    assert jobs.claim(job_id, "new")
    handle_lost_process(queue.store, job, "signal 9", 1, "old")
    assert job.retries_left == 0
    assert jobs.is_held(job_id, "new")


def test_webhooks_of_a_tenant_are_delivered_by_its_jobs(queue: JobQueue) -> None:
    acme = queue.of("acme")
    webhook = Webhook(url="https://example.org/", secret="16 letters or more")
    job = acme.submit(MATCH, RequestOrigin("r", None, webhook=webhook)).id
    acme.cancel(job)
    dispatch(queue, WebhookSettings())
    (delivery,) = waiting(queue)
    assert waiting(queue) == {delivery: "acme"}
    assert acme.store.webhooks.attempts(job) == 1
    assert queue.store.webhooks.attempts(job) == 0


def test_listings_of_all_tenants_are_swept(queue: JobQueue) -> None:
    own = queue.of("acme")
    job = own.submit(MATCH).id
    queue.store.client.delete(own.store.keys.job(job))
    for _ in range(20):
        Sweep(queue.store).step()
    assert queue.store.client.zscore(own.store.keys.jobs, job) is None


def test_cached_blobs_stay_while_a_tenant_has_the_shape(queue: JobQueue) -> None:
    store, key = queue.store, SpectrumKey(SHAPE, 10)
    tenants = [store.of(name) for name in ("acme", "globex", "default")]
    for own in tenants:
        own.client.set(own.keys.shape(SHAPE), shape_record(SHAPE).model_dump_json())
        JobQueue(own, queue.settings).submit(MATCH)
    assert tenants[0].spectra.put(key, b"spectrum")
    # It is there for all, and known to those that have used it.
    assert [own.spectra.known([key])[0] for own in tenants] == [True, False, False]
    assert tenants[1].spectra.get(key) == b"spectrum"
    assert [own.spectra.known([key])[0] for own in tenants] == [True, True, False]
    for own, is_kept in zip(tenants, (True, True, False), strict=True):
        own.shapes.delete(SHAPE)
        evict_deleted(own, [SHAPE])
        assert store.spectra.has(key) is is_kept
        assert own.spectra.known([key]) == [False]
