"""Cancellation of jobs, also while Redis is full; spectra that were queued for them."""

from collections.abc import Callable, Iterator

import pytest

from broker.contracts import (
    BatchPayload,
    ConsistentMapsPayload,
    JobKind,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    PicturePayload,
    Progress,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, ActiveJob
from broker.upkeep import store_away
from tests.broker.store.records import accepted, numbered

SHAPES = tuple(f"{number:032x}" for number in range(3))

DENSE = MatchParameters(dense=True)
MAPS = ConsistentMapsPayload(shapes=SHAPES, parameters=DENSE)


@pytest.fixture
def maps(queue: JobQueue) -> JobRecord:
    """A queued job that needs the spectra of all shapes, which are queued before it."""
    for number in range(len(SHAPES)):
        accepted(queue.store, numbered(number))
    return queue.submit(MAPS)


@pytest.fixture
def full(queue: JobQueue) -> Iterator[Callable[[], object]]:
    """Leaves Redis no memory."""
    config = queue.store.client.config_set
    yield lambda: config("maxmemory", 1)
    config("maxmemory", 0)


def test_a_batch_is_cancelled_while_redis_is_full(
    queue: JobQueue, full: Callable[[], object]
) -> None:
    jobs, payload = (
        queue.store.jobs,
        BatchPayload(
            source="a", targets=("b",) * 3, target_names=(None,) * 3, parameters=MatchParameters()
        ),
    )
    batch = queue.submit(payload).id
    queued, running = f"{batch}-1", f"{batch}-2"
    queue.batches.queue_waiting(running)
    assert jobs.claim(running, "me")
    assert queue.batches.begin(batch)
    full()
    queue.cancel(batch)
    assert [jobs.state(one) for one in (batch, queued)] == [JobState.CANCELLED] * 2
    assert not jobs.is_held(running, "me"), "it is asked to stop"
    assert jobs.finish_cancelled(running, "me")


def test_jobs_are_cancelled_while_redis_is_full(
    queue: JobQueue, full: Callable[[], object]
) -> None:
    jobs, match = queue.store.jobs, MatchPayload(source="a", target="b", parameters=DENSE)
    payload = BatchPayload(
        source="a", targets=("b",) * 3, target_names=(None,) * 3, parameters=DENSE
    )
    first, last = f"{queue.submit(payload).id}-1", queue.submit(match).id
    picture = queue.submit_picture(PicturePayload(job="x"))
    assert jobs.claim(last, "me")
    full()
    for job in (first, picture, last):
        queue.cancel(job)
    states = JobState.CANCELLED, JobState.CANCELLED, JobState.RUNNING
    assert tuple(map(jobs.state, (first, picture, last))) == states
    assert not jobs.report(last, "me", Progress(stage="x", fraction=0.5))


def test_progress_is_reported_while_redis_is_full(
    queue: JobQueue, full: Callable[[], object]
) -> None:
    job = queue.submit(MatchPayload(source="a", target="b", parameters=DENSE)).id
    assert queue.store.jobs.claim(job, "me")
    full()
    assert queue.store.jobs.report(job, "me", Progress(stage="x", fraction=0.5))


def waiting_spectra(queue: JobQueue) -> list[ActiveJob]:
    """The jobs that compute spectra and have not ended."""
    return [one for one in queue.store.jobs.active() if one.kind is JobKind.SPECTRUM]


def test_spectra_of_a_cancelled_job_are_withdrawn(queue: JobQueue, maps: JobRecord) -> None:
    assert len(waiting_spectra(queue)) == 3
    queue.cancel(maps.id)
    assert waiting_spectra(queue) == []
    assert queue.rq.waiting() == 0
    # They are queued again for whoever needs them then.
    queue.submit(MAPS)
    assert len(waiting_spectra(queue)) == 3


def test_spectra_that_others_need_stay(queue: JobQueue, maps: JobRecord) -> None:
    match = MatchPayload(source=SHAPES[0], target=SHAPES[1], parameters=DENSE)
    other = queue.submit(match)
    queue.cancel(maps.id)
    assert queue.spectra_ahead(other) == len(waiting_spectra(queue)) == 2
    queue.cancel(other.id)
    assert waiting_spectra(queue) == []


def test_spectra_that_are_being_computed_go_on(queue: JobQueue, maps: JobRecord) -> None:
    running = waiting_spectra(queue)[0].id
    assert queue.store.jobs.claim(running, "runner")
    queue.cancel(maps.id)
    assert queue.store.jobs.is_held(running, "runner")
    assert [one.id for one in waiting_spectra(queue)] == [running]
    assert queue.store.jobs.state(maps.id) is JobState.CANCELLED


@pytest.mark.parametrize("how", ["killed", "expired"])
def test_a_spectrum_whose_job_is_gone_is_not_waited_for(
    queue: JobQueue, maps: JobRecord, how: str
) -> None:
    gone = waiting_spectra(queue)[0].id
    if how == "killed":
        assert queue.store.jobs.lose(gone, 0, store_away()) is JobState.FAILED
    else:
        queue.store.client.delete(DEFAULT_KEYS.job(gone))
    assert queue.spectra_ahead(maps) == len(waiting_spectra(queue)) == 2
    queue.submit(MAPS)
    assert queue.spectra_ahead(maps) == len(waiting_spectra(queue)) == 3
