"""Jobs done in time slices: others wait briefly, finished chunks are kept, none is lost."""

import os
import signal
import time
from datetime import timedelta
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from rq import Worker
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.contracts import (
    PAIRS,
    DissimilaritiesPayload,
    DissimilarityParameters,
    DissimilarityResult,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    Problem,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Jobs, Store
from broker.upkeep import RecoveryTimeouts, handle_lost_process, recover, store_away
from service.standalone import EmbeddedServer
from solver.arrays import FloatArray
from solver.similarity import (
    Signature,
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    pairs_between,
)
from tests.blobs import blob_url
from tests.broker.store.records import calls
from tests.waiting import until
from tests.worker.collections import imagined, name_of
from tests.worker.figures import blob_file
from tests.worker.jobs.test_dissimilarities import result_of, until_forgotten
from tests.workers import Upload, ended, horses, worker
from worker.jobs.failures import JobTimedOut
from worker.jobs.options import options_of
from worker.jobs.runner import Runner
from worker.settings import WorkerSettings

linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")

NOW = RecoveryTimeouts(unknown=timedelta(0), heartbeat=timedelta(0), cancellation=timedelta(0))

HARD = DissimilarityParameters(points=10)
"""Random metrics of ten points, which take long to compare."""


SHAPES = 70
"""Shapes whose pairs take a few seconds."""

MANY = 200
"""Shapes whose pairs take so long that only a failure or a cancellation ends the job."""


def begun(queue: JobQueue, seed: int, shapes: int = SHAPES) -> "Watched":
    """Submit a comparison, and wait until some of its pairs are compared."""
    payload = imagined(queue.store, shapes, HARD, seed)
    watched = Watched(queue, queue.submit(payload), payload)
    until(lambda: watched.look() or len(watched.chunks) >= 2)
    assert not watched.ended, "there are too few pairs"
    return watched


class Watched:
    """A comparison that is observed while it runs: finished chunks must stay."""

    def __init__(self, queue: JobQueue, job: JobRecord, payload: DissimilaritiesPayload) -> None:
        self.queue, self.job, self.payload = queue, job, payload
        self.counts = queue.store.chunks.counts(job.id)
        self.chunks: dict[int, bytes] = {}
        self.fraction = 0.0
        self.ranges = 0
        self.ended = False

    def look(self) -> bool:
        """Check the progress; return whether the job has ended."""
        parts = self.queue.store.chunks.results(self.job.id, PAIRS)
        now = self.queue.store.chunks.counts(self.job.id)
        record = self.queue.store.jobs.get(self.job.id)
        assert record is not None
        self.ended = record.state.ended
        if not self.ended:
            assert self.chunks.items() <= parts.items()
            assert now.claims >= self.counts.claims
            assert record.progress.fraction >= self.fraction
            self.chunks, self.counts, self.fraction = parts, now, record.progress.fraction
            self.ranges = now.count if now.stage == PAIRS else self.ranges
        return self.ended

    def result(self) -> DissimilarityResult:
        """Wait for the end, and return the result, which must be correct."""
        until(self.look, 300.0)
        found = result_of(self.queue, ended(self.queue, self.job.id))
        values = np.array(found.lower_bounds)
        assert values == pytest.approx(self._expected(values), rel=1e-8)
        until_forgotten(self.queue, self.job)
        return found

    def is_over(self, process: int) -> bool:
        """Whether a killed process has ended, or the job has."""
        return self.look() or not Path(f"/proc/{process}").exists()

    def repeated(self) -> int:
        """Number of chunks that were claimed again; the last chunk is the result."""
        return self.counts.claims - self.ranges - 1

    def horse(self, besides: str = "") -> tuple[int, str] | None:
        """A process that works on it, and its time slice, which is not `besides`.

        None if it has ended.
        """
        deadline = time.monotonic() + 240
        while time.monotonic() < deadline:
            if self.look():
                return None
            for known in Worker.all(connection=self.queue.store.client):
                time_slice = known.get_current_job_id() or ""
                wanted = time_slice.startswith(self.job.id) and time_slice != besides
                found = horses(known.pid) if wanted and known.pid else []
                # The process may be that of the next time slice already.
                if found and known.get_current_job_id() == time_slice:
                    return found[0], time_slice
        raise AssertionError("nobody works on it")

    def _expected(self, values: FloatArray) -> FloatArray:
        """All values; every fifteenth is computed here."""
        names = [name_of(shape, HARD) for shape in self.payload.shapes]
        stored = [data for data in self.queue.store.spectra.get_many(names) if data]
        collection = SignatureCollection.of([*map(Signature.from_bytes, stored)], HARD.points)
        every = pairs_between(len(stored), 0, len(values))
        correct = values.copy()
        correct[::15] = dissimilarities(
            collection, every[::15], options_of(SimilarityOptions, HARD)
        ).costs
        return correct


def test_other_jobs_do_not_wait_for_a_large_comparison(served: JobQueue, upload: Upload) -> None:
    shape = upload(blob_file(2))
    quick = MatchParameters(points=8, eigenpairs=30, orientation=False)
    matching = MatchPayload(source=shape, target=shape, parameters=quick)
    watched, begins = begun(served, seed=10), 0
    while not watched.look() and len(watched.chunks) <= watched.counts.count // 2:
        record = ended(served, served.submit(matching).id)
        assert record.state is JobState.SUCCEEDED
        assert record.started is not None
        # A time slice ends within about a second once another job waits.
        assert (record.started - record.created).total_seconds() < 10.0
        begins += 1
    assert begins > 0
    assert len(watched.result().shapes) == SHAPES


@linux
def test_a_killed_process_loses_no_finished_chunk(served: JobQueue) -> None:
    watched = begun(served, seed=11)
    struck, killed = "", 0
    # A time slice that dies twice fails the comparison.
    while killed < 2 and (found := watched.horse(besides=struck)) is not None:
        horse, struck = found
        os.kill(horse, signal.SIGKILL)
        killed += 1
        until(partial(watched.is_over, horse))
    assert killed > 0
    watched.result()
    assert watched.repeated() <= killed


@linux
def test_a_chunk_that_kills_every_process_fails_the_comparison(served: JobQueue) -> None:
    watched = begun(served, seed=12, shapes=MANY)
    while (found := watched.horse()) is not None:
        horse, _ = found
        os.kill(horse, signal.SIGKILL)
        until(partial(watched.is_over, horse))
    record = ended(served, watched.job.id)
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == "worker-lost"
    until_forgotten(served, watched.job)


def test_a_cancelled_comparison_ends_at_once(served: JobQueue) -> None:
    watched = begun(served, seed=13, shapes=MANY)
    assert served.store.jobs.cancel(watched.job.id) is JobState.CANCELLED
    until_forgotten(served, watched.job)
    record = ended(served, watched.job.id)
    assert record.state is JobState.CANCELLED
    assert served.store.results.document(watched.job.id) is None


def test_a_comparison_that_is_cancelled_at_its_end_leaves_no_arrays(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, job = queue.store, queue.submit(imagined(queue.store, 4, HARD)).id

    def cancelled(*_: object) -> bytes:
        queue.cancel(job)
        return b"arrays"

    monkeypatch.setattr("worker.jobs.comparison.arrays_of", cancelled)
    Runner(queue, "me").run(f"{job}-1")
    assert store.jobs.state(job) is JobState.CANCELLED
    assert store.results.arrays(job) is None


def test_a_time_slice_reads_the_collection_once(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("worker.jobs.comparison.CHUNK_SECONDS", 1e-9)
    easy = DissimilarityParameters(points=4)
    job = queue.submit(imagined(queue.store, 21, easy)).id
    before, slices = calls(queue.store, "get"), 0
    while queue.store.jobs.state(job) is not JobState.SUCCEEDED:
        slices += 1
        assert slices < 20, queue.store.jobs.get(job)
        Runner(queue, "me").run(f"{job}-{slices}")
    read = calls(queue.store, "get") - before
    # Each of the 210 pairs is a chunk.
    assert read <= 5 * slices, (read, slices)


def test_a_time_slice_that_was_given_up_fails_no_comparison(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs, job = queue.store.jobs, queue.submit(imagined(queue.store, 4, HARD)).id
    time_slice = f"{job}-1"

    def stand_still(*_: object) -> bytes:
        assert jobs.lose(time_slice, 1, store_away(), "first") is JobState.QUEUED
        assert jobs.claim(time_slice, "second")
        raise JobTimedOut

    monkeypatch.setattr("worker.jobs.comparison.Comparison.compute", stand_still)
    Runner(queue, "first").run(time_slice)
    assert (jobs.state(job), jobs.state(time_slice)) == (JobState.RUNNING, JobState.RUNNING)
    assert queue.store.chunks.time_slices(job) == {time_slice: JobState.RUNNING}


def test_a_time_slice_that_fails_its_comparison_has_ended(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs, job = queue.store.jobs, queue.submit(imagined(queue.store, 4, HARD)).id
    time_slice, fail, states = f"{job}-1", Jobs.fail, []

    def time_out(*_: object) -> bytes:
        raise JobTimedOut

    def failing(jobs: Jobs, job_id: str, runner: str, problem: Problem) -> bool:
        # Given up now, it would be run again.
        states.append(jobs.lose(time_slice, 1, store_away(), "first"))
        return fail(jobs, job_id, runner, problem)

    monkeypatch.setattr("worker.jobs.comparison.Comparison.compute", time_out)
    monkeypatch.setattr(Jobs, "fail", failing)
    Runner(queue, "first").run(time_slice)
    assert (jobs.state(job), states) == (JobState.FAILED, [JobState.SUCCEEDED])


@linux
def test_a_killed_worker_loses_no_finished_chunk(queue: JobQueue) -> None:
    with worker(queue) as first, worker(queue):
        until(lambda: queue.workers() == 2)
        watched = begun(queue, seed=14)
        first.kill()
        first.wait()
        # The other one does what is left, but for the part that the dead one holds.
        until(lambda: watched.look() or len(queue.store.chunks.time_slices(watched.job.id)) == 1)
        recover(queue, NOW)
        watched.result()
    assert watched.repeated() <= 1


def test_a_comparison_whose_time_slices_are_lost_gets_another(queue: JobQueue) -> None:
    job = queue.submit(imagined(queue.store, 4, HARD))
    client = queue.store.client
    for _ in range(2):
        recover(queue, NOW)
    assert queue.store.client.lrange(queue.rq.current.key, 0, -1) == [f"{job.id}-1".encode()]
    assert queue.rq.position(job) == 0
    # Delete the time slice from queue and store.
    client.delete(queue.rq.current.key, DEFAULT_KEYS.job(f"{job.id}-1"))
    recover(queue, NOW)
    recover(queue, NOW)
    assert client.lrange(queue.rq.current.key, 0, -1) == [f"{job.id}-2".encode()]
    assert queue.store.jobs.state(job.id) is JobState.QUEUED


def test_an_ended_time_slice_that_counts_as_abandoned_does_no_harm(queue: JobQueue) -> None:
    jobs = queue.store.jobs
    job = queue.submit(imagined(queue.store, 4, HARD))
    time_slice = Job.fetch(f"{job.id}-1", connection=queue.store.client, serializer=JSONSerializer)
    assert jobs.claim(time_slice.id, "runner")
    assert jobs.succeed(time_slice.id, "runner")
    handle_lost_process(queue.store, time_slice, "its worker is gone", 0, "runner")
    assert jobs.state(job.id) is JobState.QUEUED


@linux
def test_a_restart_of_the_store_loses_no_finished_chunk(tmp_path: Path) -> None:
    server = EmbeddedServer(tmp_path)
    server.start()
    settings = WorkerSettings(redis_url=server.url, blob_url=blob_url(tmp_path))
    queue = JobQueue(Store.open(settings, retry_seconds=20, pause=0.1), settings)
    try:
        with worker(queue):
            watched = begun(queue, seed=15)
            assert server.pid is not None
            os.kill(server.pid, signal.SIGKILL)
            server.stop()
            server.start()
            watched.counts = queue.store.chunks.counts(watched.job.id)
            watched.chunks = queue.store.chunks.results(watched.job.id, PAIRS)
            watched.fraction = 0.0
            assert len(watched.chunks) >= 2
            watched.result()
            assert watched.repeated() <= 1
    finally:
        queue.store.close()
        server.stop()
