"""Recovery of jobs that are lost in each possible way."""

import os
import signal
import time
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from redis.exceptions import OutOfMemoryError
from rq.executions import Execution
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.contracts import BatchPayload, JobState, MatchParameters, MatchPayload, shape_id
from broker.queue import FairQueue, JobQueue
from broker.store import DEFAULT_KEYS, Keys
from broker.upkeep import LOSSES_WITH_WORKER, RecoveryTimeouts, Upkeep, recover
from broker.webhooks import WebhookSettings
from tests.processes import alive
from tests.waiting import until
from tests.worker.figures import blob_file
from tests.workers import ended, horses, validation, worker

linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")

NOW = RecoveryTimeouts(unknown=timedelta(0), heartbeat=timedelta(0), cancellation=timedelta(0))

LONG = MatchParameters(points=256, coarse_points=10, alternatives=32)


def test_a_job_dequeued_but_never_registered_is_queued_again(queue: JobQueue) -> None:
    client, waiting = queue.store.client, queue.rq.current.key
    job = validation(queue, blob_file(1))
    for _ in range(LOSSES_WITH_WORKER):
        # A worker takes it from the queue, and dies before it can say so.
        assert client.lpop(waiting) == job.encode()
        recover(queue, NOW)
        assert client.llen(waiting) == 0
        recover(queue, NOW)
        assert client.lrange(waiting, 0, -1) == [job.encode()]
        assert queue.store.jobs.state(job) is JobState.QUEUED
    client.lpop(waiting)
    recover(queue, NOW)
    recover(queue, NOW)
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert client.hlen(DEFAULT_KEYS.unseen_jobs) == 0
    # What was uploaded is not kept for a job that will never be.
    assert client.keys("isomatch:candidate:*") == []


def test_a_queued_job_is_not_recovered(queue: JobQueue) -> None:
    job = validation(queue, blob_file(1))
    for _ in range(3):
        recover(queue, NOW)
    assert queue.store.client.lrange(queue.rq.current.key, 0, -1) == [job.encode()]
    assert queue.store.client.hlen(DEFAULT_KEYS.unseen_jobs) == 0


def test_one_process_recovers_at_a_time(queue: JobQueue) -> None:
    job = validation(queue, blob_file(1))
    queue.store.client.lpop(queue.rq.current.key)
    queue.store.client.set(Keys.RECOVERY, "somebody else")
    for _ in range(2):
        recover(queue, NOW)
    assert queue.store.client.llen(queue.rq.current.key) == 0
    queue.store.client.delete(Keys.RECOVERY)
    for _ in range(2):
        recover(queue, NOW)
    assert queue.store.client.lrange(queue.rq.current.key, 0, -1) == [job.encode()]


def test_a_damaged_record_does_not_end_recovery(queue: JobQueue) -> None:
    client, match = queue.store.client, MatchPayload(source="a", target="b", parameters=LONG)
    damaged = queue.submit(match).id
    client.hset(DEFAULT_KEYS.job(damaged), "record", "{")
    batch = queue.submit(
        BatchPayload(source="a", targets=("b",), target_names=(None,), parameters=LONG)
    )
    client.hset(DEFAULT_KEYS.job(f"{batch.id}-1"), "state", "damaged")
    others = {queue.submit(match).id, queue.of("acme").submit(match).id}
    client.delete(queue.rq.current.key)
    for _ in range(2):
        recover(queue, NOW)
    assert set(queue.rq.current.get_job_ids()) == others


def executing(queue: JobQueue) -> tuple[str, Execution]:
    """Queue a job and register its execution, as a worker does that dies at once."""
    queue = queue.of("acme")
    match = MatchPayload(source="a", target="b", parameters=LONG)
    job = queue.submit(match).id
    taken = Job.fetch(job, connection=queue.store.client, serializer=JSONSerializer)
    assert queue.rq.current.remove(taken)
    assert queue.store.jobs.claim(job, "gone")
    with queue.store.client.pipeline() as pipe:
        execution = Execution.create(taken, 3600, pipe, "gone")
        pipe.execute()
    queue.store.client.hset(taken.key, "worker_name", "gone")
    return job, execution


@pytest.mark.parametrize("field", ["created_at", "last_heartbeat"])
def test_a_half_expired_execution_does_not_end_recovery(queue: JobQueue, field: str) -> None:
    jobs = [executing(queue) for _ in range(2)]
    queue.store.client.hdel(jobs[0][1].key, field)
    recover(queue)
    assert set(queue.rq.current.get_job_ids()) == {job for job, _ in jobs}
    states = {queue.of("acme").store.jobs.state(job) for job, _ in jobs}
    assert states == {JobState.QUEUED}


def test_running_jobs_are_looked_at_in_a_few_round_trips(queue: JobQueue) -> None:
    client = queue.store.client
    client.hset("rq:worker:gone", "birth", "long ago")
    jobs = [executing(queue)[0] for _ in range(40)]
    before = client.info("stats")["total_reads_processed"]
    recover(queue)
    assert client.info("stats")["total_reads_processed"] - before < len(jobs)
    assert {queue.of("acme").store.jobs.state(job) for job in jobs} == {JobState.RUNNING}
    client.hset("rq:worker:gone", "death", "now")
    recover(queue)
    assert set(queue.rq.current.get_job_ids()) == set(jobs)


@pytest.mark.parametrize("ahead", [-60.0, 60.0])
def test_a_process_whose_clock_is_wrong_recovers_nothing(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch, ahead: float
) -> None:
    job, _ = executing(queue)
    clock, upkeep = time.time, Upkeep(queue, WebhookSettings())
    monkeypatch.setattr(time, "time", lambda: clock() + ahead)
    upkeep.recover()
    assert queue.of("acme").store.jobs.state(job) is JobState.RUNNING
    monkeypatch.undo()
    # It has left the turn to others.
    upkeep.recover()
    assert queue.of("acme").store.jobs.state(job) is JobState.QUEUED


class Full:
    """A store that is full, for some times, when a job is to be put back into its queue."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, of: type, method: str) -> None:
        self.left = 2 * LOSSES_WITH_WORKER
        put = getattr(of, method)

        def refused(*arguments: Any, **options: Any) -> None:
            if self.left:
                self.left -= 1
                raise OutOfMemoryError("command not allowed when used memory > 'maxmemory'.")
            put(*arguments, **options)

        monkeypatch.setattr(of, method, refused)


def test_a_loss_counts_once_however_often_the_store_is_full(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    job, _ = executing(queue)
    full = Full(monkeypatch, Job, "retry")
    while full.left:
        with pytest.raises(OutOfMemoryError):
            recover(queue)
    recover(queue)
    assert queue.rq.current.get_job_ids() == [job]
    assert queue.store.client.hget(queue.of("acme").store.keys.job(job), "losses") == b"1"


def test_a_job_unknown_to_rq_is_lost_once_however_often_the_store_is_full(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = validation(queue, blob_file(1))
    queue.store.client.lpop(queue.rq.current.key)
    recover(queue, NOW)
    full = Full(monkeypatch, FairQueue, "push_job_id")
    while full.left:
        with pytest.raises(OutOfMemoryError):
            recover(queue, NOW)
    recover(queue, NOW)
    assert queue.rq.current.get_job_ids() == [job]
    assert queue.store.client.hget(DEFAULT_KEYS.job(job), "losses") == b"1"


@pytest.mark.parametrize("damage", [("status", "no such"), ("meta", "[")])
def test_a_damaged_job_of_rq_does_not_end_recovery(
    queue: JobQueue, damage: tuple[str, str]
) -> None:
    job, _ = executing(queue)
    queue.store.client.hset(f"rq:job:{job}", *damage)
    lost = validation(queue, blob_file(1))
    queue.store.client.lpop(queue.rq.current.key)
    for _ in range(2):
        recover(queue, NOW)
    assert lost in queue.rq.current.get_job_ids()


def begun(queue: JobQueue, data: bytes) -> str:
    """Start a long match."""
    ended(queue, validation(queue, data))
    shape = shape_id(data)
    job = queue.submit(MatchPayload(source=shape, target=shape, parameters=LONG))

    def matching() -> bool:
        record = queue.store.jobs.get(job.id)
        assert record is not None
        assert not record.state.ended, record
        return record.progress.fraction >= 0.4

    until(matching)
    return job.id


@linux
def test_the_jobs_of_a_dead_worker_are_queued_before_others(queue: JobQueue) -> None:
    with worker(queue) as first:
        job = begun(queue, blob_file(4))
        (horse,) = horses(first.pid)
        # It is alive, and is let live.
        recover(queue)
        assert queue.store.jobs.state(job) is JobState.RUNNING
        first.kill()
        first.wait()
        until(lambda: not alive({horse}))
    other = validation(queue, blob_file(1))
    recover(queue, NOW)
    assert queue.store.jobs.state(job) is JobState.QUEUED
    # It has waited before.
    assert queue.rq.current.get_job_ids() == [job, other]


@linux
def test_a_cancelled_job_that_does_not_stop_is_killed(queue: JobQueue) -> None:
    with worker(queue) as process:
        job = begun(queue, blob_file(4))
        (horse,) = horses(process.pid)
        # Deaf, as if it were in the middle of something that cannot be interrupted.
        os.kill(horse, signal.SIGSTOP)
        queue.store.jobs.cancel(job)
        recover(queue)
        assert queue.store.jobs.state(job) is JobState.RUNNING
        recover(queue, replace(RecoveryTimeouts.of(5), cancellation=timedelta(0)))
        assert ended(queue, job).state is JobState.CANCELLED
        # The worker goes on with other work.
        assert ended(queue, validation(queue, blob_file(2))).state is JobState.SUCCEEDED
