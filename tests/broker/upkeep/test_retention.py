"""Times to live: of shapes from their last use, and of the tombstones of expired records."""

from datetime import timedelta

import pytest

from broker.contracts import (
    JobState,
    MatchParameters,
    MatchPayload,
    PicturePayload,
    ValidationPayload,
)
from broker.queue import JobQueue, QueueSettings
from broker.store import DEFAULT_KEYS, Keys, Store, listings
from broker.upkeep import Sweep
from tests.worker.records import CREATED, shape_record
from worker.jobs.problems import newer_version
from worker.settings import WorkerSettings

TTL, TRACE = 1000, 5000
SHAPE = "a" * 32
PARTS = tuple(
    key(SHAPE)
    for key in (
        DEFAULT_KEYS.shape,
        DEFAULT_KEYS.shape_upload,
        DEFAULT_KEYS.shape_mesh,
        DEFAULT_KEYS.shape_geometry,
    )
)


MATCH = MatchPayload(source=SHAPE, target=SHAPE, parameters=MatchParameters())


@pytest.fixture
def kept(store: Store, settings: WorkerSettings) -> Store:
    """A store with a shape and short times to live."""
    changed = settings.model_copy(update={"shape_ttl": TTL, "job_ttl": TTL, "trace_ttl": TRACE})
    short = Store.over(store.client, changed, retry_seconds=1)
    put_shape(short)
    return short


def put_shape(store: Store, name: str = SHAPE) -> None:
    payload = ValidationPayload(shape=name, name="x", file_type="off")
    job = JobQueue(store, QueueSettings()).submit_validation(payload, b"data")
    record = shape_record(name, created=CREATED + timedelta(seconds=len(name)))
    store.shapes.accept(record, b"data", b"mesh", b"geometry", job)


def left(store: Store) -> list[int]:
    return [store.client.ttl(part) for part in PARTS]


def test_use_extends_the_life_of_a_shape(kept: Store) -> None:
    assert all(TTL - 100 <= ttl <= TTL for ttl in left(kept))
    tombstone = kept.client.ttl(DEFAULT_KEYS.shape_tombstone(SHAPE))
    assert TTL + TRACE - 100 <= tombstone <= TTL + TRACE
    uses = (kept.shapes.use, kept.shapes.upload, kept.shapes.mesh)
    for use in uses:
        for part in PARTS:
            kept.client.expire(part, 10)
        assert kept.shapes.get(SHAPE) is not None
        kept.shapes.page(10, None)
        assert max(left(kept)) <= 10
        assert use(SHAPE)
        assert min(left(kept)) >= TTL - 100


def test_expired_records_have_a_tombstone_and_deleted_ones_none(kept: Store) -> None:
    assert not kept.shapes.expired("b" * 32)
    kept.client.delete(*PARTS)
    assert kept.shapes.use(SHAPE) is None
    assert kept.shapes.expired(SHAPE)
    put_shape(kept)
    assert kept.shapes.delete(SHAPE)
    assert not kept.shapes.expired(SHAPE)


def test_expired_jobs_have_a_tombstone(kept: Store) -> None:
    queue = JobQueue(kept, QueueSettings())
    job = queue.submit(MATCH).id
    kept.jobs.claim(job, "me")
    kept.jobs.succeed(job, "me")
    assert TTL - 100 <= kept.client.ttl(DEFAULT_KEYS.job(job)) <= TTL
    assert TTL + TRACE - 100 <= kept.client.ttl(DEFAULT_KEYS.job_tombstone(job)) <= TTL + TRACE
    kept.client.delete(DEFAULT_KEYS.job(job))
    assert kept.jobs.get(job) is None
    assert kept.jobs.expired(job)
    assert not kept.jobs.expired("nobody")


@pytest.mark.parametrize("way", ["done", "cancelled", "lost"])
def test_jobs_that_serve_others_are_forgotten_soon(store: Store, way: str) -> None:
    queue = JobQueue(store, QueueSettings())
    job = queue.submit(PicturePayload(job="x")).id
    store.jobs.claim(job, "me")
    match way:
        case "done":
            assert store.jobs.succeed(job, "me")
        case "cancelled":
            store.jobs.cancel(job)
            assert store.jobs.finish_cancelled(job, "me")
        case "lost":
            assert store.jobs.lose(job, 0, newer_version()) is JobState.FAILED
    assert 3600 <= store.client.ttl(DEFAULT_KEYS.job(job)) <= 4 * 3600
    assert list(store.client.scan_iter(f"{DEFAULT_KEYS.job(job)}*")) == [
        DEFAULT_KEYS.job(job).encode()
    ]


@pytest.mark.parametrize("way", ["done", "cancelled", "lost"])
def test_the_tombstone_of_a_job_outlives_it_however_long_it_took(kept: Store, way: str) -> None:
    queue = JobQueue(kept, QueueSettings())
    job = queue.submit(MATCH).id
    kept.jobs.claim(job, "me")
    kept.client.delete(DEFAULT_KEYS.job_tombstone(job))
    match way:
        case "done":
            assert kept.jobs.succeed(job, "me")
        case "cancelled":
            kept.jobs.cancel(job)
            assert kept.jobs.finish_cancelled(job, "me")
        case "lost":
            assert kept.jobs.lose(job, 0, newer_version()) is JobState.FAILED
    assert TTL + TRACE - 500 <= kept.client.ttl(DEFAULT_KEYS.job_tombstone(job)) <= TTL + TRACE


def test_expired_entries_leave_the_listings(kept: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listings, "SWEEP_COUNT", 10)
    queue = JobQueue(kept, QueueSettings(max_queued_jobs=0))
    payload = MatchPayload(source=SHAPE, target=SHAPE, parameters=MatchParameters())
    jobs = [queue.submit(payload).id for _ in range(300)]
    put_shape(kept, "b" * 32)
    gone = jobs[::2]
    kept.client.delete(*map(DEFAULT_KEYS.job, gone), *PARTS)
    Sweep(kept).step()
    assert 150 < kept.client.zcard(DEFAULT_KEYS.jobs) < 300
    # Processes take turns: what one has begun, another continues.
    for _ in range(300):
        Sweep(kept).step()
    for listing in (DEFAULT_KEYS.jobs, DEFAULT_KEYS.jobs_in(JobState.QUEUED)):
        assert {*kept.client.zrange(listing, 0, -1)} == {job.encode() for job in jobs[1::2]}
    assert kept.client.zrange(DEFAULT_KEYS.shapes, 0, -1) == [b"b" * 32]


def test_large_listings_of_many_tenants_are_swept_in_few_steps(store: Store) -> None:
    tenants = [Keys(f"tenant{number}") for number in range(20)]
    kept, step = {f"kept{number}": number for number in range(700)}, Sweep(store).step
    for keys in tenants:
        store.client.sadd(Keys.TENANTS, keys.tenant)
        store.client.mset({keys.job(name): "" for name in kept})
        store.client.zadd(keys.jobs, kept | {f"gone{number}": number for number in range(700)})
    for _ in range(2):
        step()
    for keys in tenants:
        assert store.client.zcard(keys.jobs) == len(kept)


def test_a_listing_that_loses_entries_is_swept_in_one_round(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(listings, "SWEEP_COUNT", 10)
    jobs = DEFAULT_KEYS.jobs
    store.client.zadd(jobs, {f"{number:03}": number for number in range(100)})
    store.client.mset({DEFAULT_KEYS.job(f"{number:03}"): "" for number in range(0, 100, 3)})
    for _ in range(10):
        Sweep(store).step()
    assert store.client.zcard(jobs) == 34
