"""The store: the states of jobs, listings, shapes and the spectrum cache, in a real Redis."""

import base64
import gzip
import itertools
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from broker.contracts import (
    BatchPayload,
    JobKind,
    JobRecord,
    JobState,
    MatchParameters,
    Problem,
    ProblemType,
    Progress,
    ShapeRecord,
    SpectrumKey,
    SpectrumPayload,
    ValidationPayload,
)
from broker.queue import JobQueue, QueueSettings, new_job
from broker.store import (
    DEFAULT_KEYS,
    CandidateGone,
    InvalidCursor,
    Jobs,
    Keys,
    Listing,
    Page,
    Spectra,
    Store,
    renewed,
)
from tests.broker.store.records import accepted, calls, match_job, numbered, running, stored
from worker.settings import WorkerSettings

BROKEN = Problem.of(ProblemType.INTERNAL_ERROR, "it broke")


def in_state(jobs: Jobs, state: JobState) -> str:
    if state is JobState.QUEUED:
        return stored(jobs)
    job = running(jobs)
    match state:
        case JobState.SUCCEEDED:
            assert jobs.succeed(job, "r", b"{}")
        case JobState.FAILED:
            assert jobs.fail(job, "r", BROKEN)
        case JobState.CANCELLED:
            assert jobs.finish_cancelled(job, "r")
    return job


def test_a_stored_job_is_read_back(store: Store) -> None:
    record = match_job()
    stored(store.jobs, record)
    assert store.jobs.get(record.id) == record
    assert store.jobs.get("nobody") is None


def test_the_life_of_a_job(store: Store) -> None:
    job = running(store.jobs)
    assert store.jobs.report(job, "r", Progress(stage="matching", fraction=0.5))
    begun = store.jobs.get(job)
    assert begun is not None
    assert begun.state is JobState.RUNNING
    assert begun.progress == Progress(stage="matching", fraction=0.5)
    assert begun.started is not None
    assert store.jobs.succeed(job, "r", b'{"x": 1}')
    done = store.jobs.get(job)
    assert done is not None
    assert done.state is JobState.SUCCEEDED
    assert done.progress.fraction == 1.0
    assert done.ended is not None
    assert done.ended >= begun.started
    packed = store.results.document(job)
    assert packed is not None
    assert gzip.decompress(packed) == b'{"x": 1}'


def test_only_one_runner_gets_a_job(store: Store) -> None:
    job = stored(store.jobs)
    assert store.jobs.claim(job, "first")
    assert not store.jobs.claim(job, "second")
    # The reply of a claim may be lost on the way, and the claim repeated.
    assert store.jobs.claim(job, "first")
    assert not store.jobs.claim("nobody", "first")


ENDS = [state for state in JobState if state.ended]


@pytest.mark.parametrize("end", ENDS)
def test_an_end_never_changes(store: Store, end: JobState) -> None:
    jobs = store.jobs
    job = in_state(jobs, end)
    before = jobs.get(job)
    result = store.results.document(job)
    jobs.claim(job, "r2")
    assert not jobs.succeed(job, "r2", b"other")
    assert not jobs.fail(job, "r2", BROKEN)
    assert not jobs.finish_cancelled(job, "r2")
    assert jobs.cancel(job) is end
    assert jobs.lose(job, 5, BROKEN) is end
    assert not jobs.report(job, "r", Progress(stage="late", fraction=0.1))
    assert not jobs.succeed(job, "r", b"other")
    refused = {
        JobState.FAILED: jobs.fail(job, "r", BROKEN),
        JobState.CANCELLED: jobs.finish_cancelled(job, "r"),
    }
    # The same call repeated, as after a lost reply, succeeds.
    assert refused == {state: state is end for state in refused}
    assert jobs.get(job) == before
    assert store.results.document(job) == result


def test_calls_of_a_runner_that_was_given_up_are_refused(store: Store) -> None:
    job = running(store.jobs, "old")
    assert store.jobs.lose(job, 1, BROKEN) is JobState.QUEUED
    assert store.jobs.claim(job, "new")
    assert not store.jobs.is_held(job, "old")
    assert not store.jobs.succeed(job, "old", b"old", b"old arrays")
    assert not store.jobs.fail(job, "old", BROKEN)
    assert store.results.document(job) is None
    assert store.results.arrays(job) is None
    assert store.jobs.lose(job, 1, BROKEN, "old") is JobState.RUNNING
    assert store.jobs.is_held(job, "new")
    assert store.jobs.succeed(job, "new", b"new", b"new arrays")
    # Though both came to the same end, only one result is that of the job.
    assert not store.jobs.succeed(job, "old", b"old", b"old arrays")
    assert store.results.arrays(job) == b"new arrays"


def test_a_job_fails_after_too_many_losses(store: Store) -> None:
    job = running(store.jobs)
    assert store.jobs.lose(job, 2, BROKEN, "r") is JobState.QUEUED
    # This one was lost before it claimed the job.
    assert store.jobs.lose(job, 2, BROKEN, "r2") is JobState.QUEUED
    assert store.jobs.claim(job, "r3")
    assert store.jobs.lose(job, 2, BROKEN, "r3") is JobState.FAILED
    record = store.jobs.get(job)
    assert record is not None
    assert record.error == BROKEN


def test_a_loss_is_counted_once(store: Store) -> None:
    job = running(store.jobs)
    for _ in range(5):
        assert store.jobs.lose(job, 1, BROKEN, "r", "first") is JobState.QUEUED
    assert store.jobs.claim(job, "r2")
    # Whoever has recorded the first loss comes late.
    assert store.jobs.lose(job, 1, BROKEN, loss="first") is JobState.RUNNING
    assert store.jobs.lose(job, 1, BROKEN, "r2", "second") is JobState.FAILED


def test_cancelling(store: Store) -> None:
    queued = stored(store.jobs)
    assert store.jobs.cancel(queued) is JobState.CANCELLED
    assert not store.jobs.claim(queued, "r")
    begun = running(store.jobs)
    assert store.jobs.is_held(begun, "r")
    assert store.jobs.cancel(begun) is JobState.RUNNING
    assert not store.jobs.is_held(begun, "r")
    assert not store.jobs.report(begun, "r", Progress(stage="on", fraction=0.2))
    (asked,) = store.jobs.active()
    assert (asked.id, asked.state) == (begun, JobState.RUNNING)
    assert asked.cancelled is not None
    assert store.jobs.finish_cancelled(begun, "r")
    # A cancelled job whose process is killed is cancelled, not repeated.
    killed = running(store.jobs)
    store.jobs.cancel(killed)
    assert store.jobs.lose(killed, 5, BROKEN) is JobState.CANCELLED
    assert store.jobs.cancel("nobody") is None


def test_listings_follow_the_states(store: Store) -> None:
    jobs = {state: in_state(store.jobs, state) for state in JobState}
    stored(store.jobs, new_job(SpectrumPayload(shape="a", eigenpairs=9, largest_component=False)))
    for state, job in jobs.items():
        assert [record.id for record in store.jobs.page(10, None, [state]).items] == [job]
    everything = store.jobs.page(10, None)
    assert {record.id for record in everything.items} == set(jobs.values())
    assert everything.next_cursor is None
    assert {record.kind for record in store.jobs.active()} == {JobKind.MATCH, JobKind.SPECTRUM}


def test_records_of_ended_jobs_expire_and_leave_the_listings(store: Store) -> None:
    job = in_state(store.jobs, JobState.SUCCEEDED)
    assert 0 < store.client.ttl(DEFAULT_KEYS.job(job)) <= store.jobs.settings.job_ttl
    assert 0 < store.client.ttl(DEFAULT_KEYS.job_result(job)) <= store.jobs.settings.result_ttl
    assert store.client.ttl(DEFAULT_KEYS.job(stored(store.jobs))) == -1
    store.client.delete(DEFAULT_KEYS.job(job))
    assert job not in [record.id for record in store.jobs.page(10, None).items]
    assert store.client.zscore(DEFAULT_KEYS.jobs, job) is None


def test_a_record_that_cannot_be_read_does_not_end_a_listing(store: Store) -> None:
    names = [stored(store.jobs) for _ in range(3)]
    store.client.hset(DEFAULT_KEYS.job(names[1]), "record", "{")
    assert [one.id for one in store.jobs.page(10, None).items] == [names[2], names[0]]
    assert store.client.zscore(DEFAULT_KEYS.jobs, names[1]) is not None
    records = [accepted(store, numbered(i, seconds=i)) for i in range(3)]
    store.client.set(DEFAULT_KEYS.shape(records[2].id), "{")
    assert store.shapes.page(1, None).items == (records[1],)


@pytest.mark.parametrize("every", [1, 4, 90])
def test_pages_of_what_is_rare_hold_all_of_it_once(store: Store, every: int) -> None:
    names = [stored(store.jobs) for _ in range(90)]
    rare = names[::every]
    for name in rare:
        assert store.jobs.claim(name, "runner")

    def pages(limit: int, state: JobState) -> Iterator[Page[JobRecord]]:
        # By the listing of all jobs, as those of one shape are read.
        listing = Listing(store.client, DEFAULT_KEYS.jobs, DEFAULT_KEYS.job)
        cursor = None
        while True:
            page = listing.page(limit, cursor, store.jobs.records, lambda one: one.state is state)
            yield page
            cursor = page.next_cursor
            if cursor is None:
                return

    found = list(pages(3, JobState.RUNNING))
    assert [one.id for page in found for one in page.items] == rare[::-1]
    assert all(len(page.items) == 3 for page in found[:-1])


def test_a_page_of_a_rare_kind_reads_only_records_of_it(store: Store) -> None:
    batch = BatchPayload(
        source="a", targets=("b",), target_names=(None,), parameters=MatchParameters()
    )
    rare = [stored(store.jobs, new_job(batch)) for _ in range(3)]
    common = [stored(store.jobs) for _ in range(1200)]
    for name in common[::100]:
        store.client.delete(DEFAULT_KEYS.job(name))
    before = calls(store, "hgetall"), calls(store, "zrevrangebyscore")
    first = store.jobs.page(2, None, kind=JobKind.BATCH)
    assert first.items == ()
    # Those that have expired are removed.
    gone = store.client.zmscore(DEFAULT_KEYS.jobs, common[300::100])
    assert set(gone) == {None}
    second = store.jobs.page(2, first.next_cursor, kind=JobKind.BATCH)
    assert [one.id for one in second.items] == rare[:0:-1]
    third = store.jobs.page(2, second.next_cursor, kind=JobKind.BATCH)
    assert [one.id for one in third.items] == rare[:1]
    assert calls(store, "hgetall") - before[0] < 20
    assert calls(store, "zrevrangebyscore") - before[1] < 30


@pytest.mark.parametrize("limit", [1, 3, 7, 8, 100])
def test_pages_hold_everything_once_newest_first(store: Store, limit: int) -> None:
    # Several of the same time, as a script makes them.
    records = [accepted(store, numbered(i, seconds=i // 3)) for i in range(8)]
    seen: list[ShapeRecord] = []
    cursor = None
    for _ in itertools.count():
        page = store.shapes.page(limit, cursor)
        assert 0 < len(page.items) <= limit
        seen += page.items
        cursor = page.next_cursor
        if cursor is None:
            break
    assert seen == sorted(records, key=lambda record: (record.created, record.id), reverse=True)


def test_a_cursor_stays_valid_while_entries_change(store: Store) -> None:
    records = [accepted(store, numbered(i, seconds=i)) for i in range(6)]
    first = store.shapes.page(2, None)
    accepted(store, numbered(99, days=1))
    store.shapes.delete(first.items[1].id)
    second = store.shapes.page(2, first.next_cursor)
    assert list(second.items) == [records[3], records[2]]


def test_a_cursor_of_another_listing_is_refused(store: Store) -> None:
    for number in range(3):
        accepted(store, numbered(number, seconds=number))
        stored(store.jobs)
    shapes, jobs = store.shapes.page(1, None), store.jobs.page(1, None, [JobState.QUEUED])
    assert store.shapes.page(1, shapes.next_cursor).items
    assert store.jobs.page(1, jobs.next_cursor, [JobState.QUEUED]).items
    with pytest.raises(InvalidCursor, match="this listing"):
        store.shapes.page(1, jobs.next_cursor)
    for filters in (((), None), ([JobState.RUNNING], None), ([JobState.QUEUED], JobKind.MATCH)):
        with pytest.raises(InvalidCursor, match="these filters"):
            store.jobs.page(1, jobs.next_cursor, *filters)


def test_an_invented_cursor_is_refused(store: Store) -> None:
    """Also one of the form that cursors have."""
    invented = base64.urlsafe_b64encode(b"1e9:zzz").decode().rstrip("=")
    for cursor in (invented, base64.urlsafe_b64encode(b"00:1e9:zz").decode()):
        with pytest.raises(InvalidCursor):
            store.shapes.page(1, cursor)


@pytest.mark.parametrize("cursor", ["", "x", "bm9uc2Vuc2U", "bmFuOmE", "é"])
def test_invalid_cursors_are_refused(store: Store, cursor: str) -> None:
    with pytest.raises(InvalidCursor):
        store.shapes.page(2, cursor)


def test_a_shape_is_stored_atomically(store: Store) -> None:
    record = accepted(store, numbered(1))
    assert store.shapes.get(record.id) == record
    assert store.shapes.upload(record.id) == b"data"
    assert store.shapes.mesh(record.id) == b"mesh"
    assert store.shapes.delete(record.id)
    assert not store.shapes.delete(record.id)
    assert store.client.keys("*") == []


def test_equal_uploads_are_validated_once(store: Store) -> None:
    queue = JobQueue(store, QueueSettings())
    payload = ValidationPayload(shape="id", name="x", file_type="off")
    other = payload.model_copy(update={"file_type": "obj"})
    first = queue.submit_validation(payload, b"data")
    assert queue.submit_validation(payload, b"data") == first
    third = queue.submit_validation(other, b"data")
    assert third != first
    assert store.uploads.candidate("id", "off", first) == b"data"
    # Given up without a verdict it is validated again, and nobody takes that away.
    store.jobs.cancel(first)
    again = queue.submit_validation(payload, b"data")
    assert again != first
    store.uploads.reject("id", "off", first)
    with pytest.raises(CandidateGone):
        store.uploads.candidate("id", "off", first)
    assert store.uploads.candidate("id", "off", again) == b"data"
    assert queue.submit_validation(payload, b"data") == again
    store.uploads.reject("id", "off", again)
    store.uploads.reject("id", "obj", third)
    assert store.client.keys("isomatch:candidate:*") == []


def test_equal_uploads_at_the_same_time_have_one_job(store: Store) -> None:
    queue = JobQueue(store, QueueSettings())
    for n in range(10):
        payload = ValidationPayload(shape=f"id{n}", name="x", file_type="off")
        with ThreadPoolExecutor(16) as threads:
            asked = [threads.submit(queue.submit_validation, payload, b"data") for _ in range(16)]
        assert len({answer.result() for answer in asked}) == 1
    assert queue.rq.current.count == 10


def small_cache(store: Store, settings: WorkerSettings, **changes: int) -> Spectra:
    return replace(store.spectra, settings=settings.model_copy(update=changes))


def test_the_cache_evicts_the_least_recently_used(store: Store, settings: WorkerSettings) -> None:
    spectra = small_cache(store, settings, cache_bytes=300)
    a, b, c, d = (SpectrumKey(name, 10) for name in "abcd")
    for key in (a, b, c):
        assert spectra.put(key, bytes(100))
    assert spectra.get(a) is not None
    assert spectra.put(d, bytes(150))
    assert [spectra.has(key) for key in (a, b, c, d)] == [True, False, False, True]
    assert store.client.hget(Keys.CACHED_SIZES, "total") == b"250"
    # The same again takes the place of the old.
    assert spectra.put(d, bytes(200))
    assert store.client.hget(Keys.CACHED_SIZES, "total") == b"300"
    assert not spectra.put(c, bytes(301))
    assert spectra.has(a)


def test_a_spectrum_larger_than_a_redis_value_is_not_cached(store: Store) -> None:
    assert not store.spectra.put(SpectrumKey("a", 10), bytes(513 * 1024**2))
    assert not store.spectra.has(SpectrumKey("a", 10))


def test_the_cache_drops_unused_spectra(store: Store, settings: WorkerSettings) -> None:
    spectra = small_cache(store, settings, cache_ttl=0)
    a, b = SpectrumKey("a", 10), SpectrumKey("b", 10)
    spectra.put(a, bytes(10))
    time.sleep(0.01)
    spectra.put(b, bytes(10))
    assert not spectra.has(a)
    assert spectra.has(b)


def test_the_cache_drops_a_shape(store: Store) -> None:
    kept = SpectrumKey("b", 10)
    for key in (SpectrumKey("a", 10), SpectrumKey("a", 20, True), kept):
        store.spectra.put(key, bytes(10))
    store.spectra.drop("a")
    assert store.spectra.has(kept)
    assert store.client.zcard(Keys.CACHED_SPECTRA) == 1
    assert store.client.hgetall(Keys.CACHED_SIZES) == {str(kept).encode(): b"10", b"total": b"10"}


def test_a_spectrum_key_has_all_that_the_spectrum_depends_on() -> None:
    names = {
        str(SpectrumKey(shape, eigenpairs, largest, simplify, file_type))
        for shape in ("a", "b")
        for eigenpairs in (10, 20)
        for largest in (False, True)
        for simplify in (None, 10, 500)
        for file_type in ("off", "obj")
    }
    assert len(names) == 48


def test_locks_belong_to_their_holder(store: Store) -> None:
    key = SpectrumKey("a", 10)
    spectra = store.spectra
    assert spectra.lock(key, "me", 60.0)
    assert not spectra.lock(key, "you", 60.0)
    with spectra.renewed(key, "you", 60.0):
        pass
    assert spectra.locked(key)
    with spectra.renewed(key, "me", 60.0):
        pass
    assert spectra.lock(key, "you", 0.05)
    time.sleep(0.1)
    assert not spectra.locked(key)


def test_a_lock_is_renewed_until_it_is_lost(store: Store) -> None:
    client = store.client
    client.set("lock", "me", px=200)
    with renewed(client, "lock", "me", 0.2) as lost:
        time.sleep(0.4)
        assert client.get("lock") == b"me"
        assert not lost.is_set()
    assert client.get("lock") is None
    client.set("lock", "me", px=200)
    with renewed(client, "lock", "me", 0.2) as lost:
        client.set("lock", "you", px=60_000)
        assert lost.wait(60)
    assert client.get("lock") == b"you"
    assert 50_000 < client.pttl("lock") <= 60_000


def test_negative_times_between_two_clocks_count_as_zero(
    store: Store,
) -> None:
    store.counters.observe(JobKind.MATCH, {"in the queue": -3.5, "total": 2.0})
    times = store.counters.read().times
    assert (times["match", "in the queue"].total, times["match", "total"].total) == (0.0, 2.0)
    assert times["match", "in the queue"].buckets[0] == 1
