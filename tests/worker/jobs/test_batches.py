"""Batches: their matches follow one another, whatever dies on the way."""

import gzip
import os
import signal
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path

import pytest

from broker.contracts import (
    BatchPayload,
    BatchResult,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    Problem,
    ProblemType,
    Progress,
)
from broker.queue import JobQueue, new_job
from broker.queue.batches import Batches
from broker.queue.new_jobs import new_batch_match
from broker.store import DEFAULT_KEYS, QueuedMatches, text
from broker.store.jobs import Jobs
from broker.upkeep import RecoveryTimeouts, recover
from tests.broker.store.test_blobs import files
from tests.waiting import until
from tests.worker.figures import blob_file
from tests.workers import Upload, another_horse, ended

linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")

LONG = MatchParameters()

NOW = RecoveryTimeouts(unknown=timedelta(0), heartbeat=timedelta(0), cancellation=timedelta(0))


def of(source: str, targets: list[str], parameters: MatchParameters) -> BatchPayload:
    names = (None,) * len(targets)
    return BatchPayload(
        source=source, targets=tuple(targets), target_names=names, parameters=parameters
    )


def result_of(queue: JobQueue, batch: str) -> BatchResult:
    packed = queue.store.results.document(batch)
    assert packed is not None
    return BatchResult.model_validate_json(gzip.decompress(packed))


def queued(queue: JobQueue) -> list[str]:
    return [text(name) for name in queue.store.client.lrange(queue.rq.current.key, 0, -1)]


@linux
def test_a_match_that_kills_its_processes_fails_and_the_batch_goes_on(
    served: JobQueue, upload: Upload
) -> None:
    shape, other = upload(blob_file(4)), upload(blob_file(2))
    lasting = MatchParameters(points=100, alternatives=32, coarse_points=10)
    batch = served.submit(of(shape, [shape, other], lasting))
    struck = 0
    for _ in range(2):
        struck = another_horse(served, f"{batch.id}-1", struck)
        os.kill(struck, signal.SIGKILL)

    def has_ended() -> bool:
        # As the service does regularly.
        recover(served)
        record = served.store.jobs.get(batch.id)
        return record is not None and record.state.ended

    until(has_ended, pause=0.1)
    record = ended(served, batch.id)
    assert record.state is JobState.SUCCEEDED
    first, second = result_of(served, batch.id).matches
    assert (first.state, second.state) == (JobState.FAILED, JobState.SUCCEEDED)
    assert first.error is not None
    assert first.error.slug == "worker-lost"
    assert second.summary is not None


def test_as_many_matches_are_queued_as_there_are_workers(queue: JobQueue) -> None:
    batch = queue.submit(of("a", ["b", "c", "d"], MatchParameters()))
    for _ in range(3):  # none: one match waits
        queue.batches.advance(batch.id)
        recover(queue, NOW)
    assert queued(queue) == [f"{batch.id}-1"]


def test_a_batch_says_that_it_has_begun(queue: JobQueue) -> None:
    batch = queue.submit(of("a", ["b", "c"], MatchParameters()))
    assert queue.batches.begin(batch.id)
    record = queue.store.jobs.get(batch.id)
    assert record is not None
    assert (record.state, record.progress.stage) == (JobState.RUNNING, "0 of 2 matches")
    assert record.progress.fraction == 0.0
    queue.cancel(batch.id)
    assert not queue.batches.begin(batch.id)


def test_recovery_goes_on_with_a_batch_that_everybody_left(queue: JobQueue) -> None:
    jobs, client = queue.store.jobs, queue.store.client
    # The process that submitted it died at once, and so did each that ended a match.
    batch = queue.submit(of("a", ["b", "c"], MatchParameters()))
    reason = Problem.of(ProblemType.WORKER_LOST, "It is lost.")
    for place in (1, 2):
        assert queued(queue) == [f"{batch.id}-{place}"]
        client.delete(queue.rq.current.key)
        jobs.claim(batch.id, batch.id)
        jobs.claim(f"{batch.id}-{place}", "a worker")
        jobs.fail(f"{batch.id}-{place}", "a worker", reason)
        recover(queue, NOW)
    assert queued(queue) == []
    assert ended(queue, batch.id).state is JobState.SUCCEEDED
    result = result_of(queue, batch.id)
    assert result.succeeded == 0
    assert [one.error for one in result.matches] == [reason, reason]


def test_a_match_of_a_cancelled_batch_does_not_begin(served: JobQueue) -> None:
    batch = new_job(of("a", ["b"], MatchParameters()))
    first = new_batch_match(batch, 0)
    with served.store.client.pipeline() as pipe:
        served.store.jobs.create(batch, pipe)
        served.store.jobs.create(first, pipe)
        pipe.execute()
    # The process that cancelled the batch died before it cancelled the match.
    assert served.store.jobs.cancel(batch.id) is JobState.CANCELLED
    served.rq.enqueue(first)
    assert ended(served, first.id).state is JobState.CANCELLED
    assert ended(served, batch.id).state is JobState.CANCELLED


def test_recovery_cancels_the_matches_of_a_cancelled_batch(queue: JobQueue) -> None:
    jobs, batch = queue.store.jobs, queue.submit(of("a", ["b"] * 3, MatchParameters())).id
    queued, running = f"{batch}-1", f"{batch}-2"
    queue.batches.queue_waiting(running)
    assert jobs.claim(running, "me")
    assert queue.batches.begin(batch)
    # The process that cancelled the batch died before it cancelled the matches.
    assert jobs.cancel(batch) is JobState.CANCELLED
    recover(queue)
    assert jobs.state(queued) is JobState.CANCELLED
    assert not jobs.is_held(running, "me"), "it is asked to stop"


def test_a_match_is_cancelled_while_the_batch_makes_progress(queue: JobQueue) -> None:
    batch = queue.submit(of("a", ["b"] * 12, MatchParameters()))
    over = threading.Event()

    def progress() -> None:
        # The fields of the job that a worker's report, or the end of another match, changes.
        while not over.is_set():
            queue.store.jobs.report(batch.id, batch.id, Progress(stage="matches", fraction=0.5))

    assert queue.batches.begin(batch.id)
    reports = threading.Thread(target=progress)
    reports.start()
    try:
        names = [f"{batch.id}-{place}" for place in range(2, 13)]
        for name in names:
            queue.cancel(name)
        records = queue.store.jobs.records(names)
    finally:
        over.set()
        reports.join()
    states = {record.state for record in records if record is not None}
    assert (len(records), states) == (11, {JobState.CANCELLED})
    assert None not in records


def test_the_progress_of_a_batch_never_decreases(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, look = queue.store, Batches._look
    batch = queue.submit(of("a", ["b"] * 4, MatchParameters()))
    assert queue.batches.begin(batch.id)
    waiting = [f"{batch.id}-{place}" for place in range(1, 4)]

    def end(match: str) -> None:
        queue.batches.queue_waiting(match)
        assert store.jobs.claim(match, "me")
        assert store.jobs.succeed(match, "me", b"{}")
        queue.batches.advance(batch.id)

    def ends_meanwhile(batches: Batches, record: JobRecord) -> QueuedMatches:
        found = look(batches, record)
        if waiting:
            end(waiting.pop())
        return found

    monkeypatch.setattr(Batches, "_look", ends_meanwhile)
    end(waiting.pop())
    now = store.jobs.get(batch.id)
    assert now is not None
    assert now.progress == Progress(stage="3 of 4 matches", fraction=0.75)


def test_a_match_that_is_queued_while_matches_are_read_has_not_expired(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs, read = queue.store.jobs, Jobs.records
    batch = queue.submit(of("a", ["b"] * 4, MatchParameters()))
    waiting = [f"{batch.id}-{place}" for place in (2, 3, 4)]

    def records(store: Jobs, job_ids: Sequence[str]) -> list[JobRecord | None]:
        found = read(store, job_ids)
        if waiting:
            # One is queued, one runs and one has ended after its record was not found.
            for match in waiting:
                queue.batches.queue_waiting(match)
            ended, running, _ = waiting
            waiting.clear()
            assert jobs.claim(ended, "me")
            assert jobs.succeed(ended, "me", b"{}")
            assert jobs.claim(running, "me")
        return found

    monkeypatch.setattr(Jobs, "records", records)
    shown = [(one.state, one.error) for one in queue.batches.matches(batch)]
    states = JobState.QUEUED, JobState.SUCCEEDED, JobState.RUNNING, JobState.QUEUED
    assert shown == [(state, None) for state in states]


def test_early_ends_of_matches_are_counted_whatever_they_are(queue: JobQueue) -> None:
    store, reason = queue.store, Problem.of(ProblemType.WORKER_LOST, "It is lost.")
    batch = queue.submit(of("a", ["b"] * 6, MatchParameters()))
    assert queue.batches.begin(batch.id)
    for place in (2, 4, 5):
        queue.batches.queue_waiting(f"{batch.id}-{place}")
    queue.cancel(f"{batch.id}-2")
    assert store.jobs.claim(f"{batch.id}-4", "me")
    assert store.jobs.fail(f"{batch.id}-4", "me", reason)
    # Its record has expired.
    store.client.delete(DEFAULT_KEYS.job(f"{batch.id}-5"))

    def stage() -> str:
        queue.batches.advance(batch.id)
        now = store.jobs.get(batch.id)
        assert now is not None
        return now.progress.stage

    assert stage() == "3 of 6 matches"
    assert store.jobs.claim(f"{batch.id}-1", "me")
    assert store.jobs.succeed(f"{batch.id}-1", "me", b"{}")
    assert stage() == "4 of 6 matches"
    assert queue.batches.live(batch) == [f"{batch.id}-3"]
    for place in (3, 6):
        assert store.jobs.claim(f"{batch.id}-{place}", "me")
        assert store.jobs.succeed(f"{batch.id}-{place}", "me", b"{}")
        queue.batches.advance(batch.id)
    states = [one.state for one in result_of(queue, batch.id).matches]
    assert states == ["succeeded", "cancelled", "succeeded", "failed", "failed", "succeeded"]
    # Nothing else is kept of it than of its matches.
    assert not store.client.keys(f"{DEFAULT_KEYS.job_chunks(batch.id)}*")
    assert not store.client.exists(DEFAULT_KEYS.time_slices(batch.id))


def test_a_batch_goes_on_that_an_earlier_version_began(queue: JobQueue) -> None:
    store = queue.store
    batch = queue.submit(of("a", ["b"] * 5, MatchParameters()))
    assert queue.batches.begin(batch.id)
    for place in (1, 2):
        assert store.jobs.claim(f"{batch.id}-{place}", "me")
        assert store.jobs.succeed(f"{batch.id}-{place}", "me", b"{}")
        queue.batches.advance(batch.id)
    queue.batches.queue_waiting(f"{batch.id}-4")
    # It recorded nothing of this, and still queues matches besides.
    recorded = DEFAULT_KEYS.job_chunks(batch.id), DEFAULT_KEYS.time_slices(batch.id)
    store.client.delete(*recorded)
    recover(queue)
    assert queue.batches.live(batch) == [f"{batch.id}-3", f"{batch.id}-4"]
    for place in (3, 4, 5):
        store.client.delete(*recorded)
        assert store.jobs.claim(f"{batch.id}-{place}", "me")
        assert store.jobs.succeed(f"{batch.id}-{place}", "me", b"{}")
        recover(queue)
        now = store.jobs.get(batch.id)
        assert now is not None
        if place == 3:
            assert now.progress.stage == "3 of 5 matches"
    assert ended(queue, batch.id).state is JobState.SUCCEEDED


def test_matches_that_a_batch_never_queued_expire_with_it(queue: JobQueue) -> None:
    batch = queue.submit(of("a", ["b"] * 3, MatchParameters()))
    queue.cancel(batch.id)
    match = queue.submit(MatchPayload(source="a", target="b", parameters=LONG))
    assert not queue.expired(f"{batch.id}-3")
    for job in (batch, match):
        queue.store.client.delete(DEFAULT_KEYS.job(job.id))
        assert queue.expired(job.id)
    assert queue.expired(f"{batch.id}-1")
    assert queue.expired(f"{batch.id}-3")
    for end in ("-4", "-0", "-03", "-", "-nonsense", "-3-1", "3"):
        assert not queue.expired(batch.id + end)
    assert not queue.expired(f"{match.id}-1")


def test_a_batch_ends_once_though_several_notice_its_end(queue: JobQueue) -> None:
    store, batches = queue.store, 5
    with ThreadPoolExecutor(4) as threads:
        for _ in range(batches):
            batch = queue.submit(of("a", ["b"], MatchParameters()))
            match = f"{batch.id}-1"
            assert store.jobs.claim(match, "me")
            assert queue.batches.begin(batch.id)
            assert store.jobs.succeed(match, "me", b"{}")
            list(threads.map(queue.batches.advance, [batch.id] * 4))
    assert sum(store.counters.read().times["batch", "total"].buckets) == batches
    # The results of each batch and of its match.
    assert len(files(store)) == 2 * batches


def test_the_batch_counts_once_towards_the_quota(queue: JobQueue) -> None:
    queue.submit(of("a", ["b", "c", "d"], MatchParameters()))
    (key,) = queue.store.client.keys("isomatch:queued:*")
    assert queue.store.client.zcard(key) == 1
