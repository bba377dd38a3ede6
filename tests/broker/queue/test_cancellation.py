"""Cancellation of jobs that spectra were queued for, and loss of the spectra's own jobs."""

import pytest

from broker.contracts import (
    ConsistentMapsPayload,
    JobKind,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, ActiveJob
from broker.upkeep import store_away
from tests.broker.store.test_store import accepted, numbered

SHAPES = tuple(f"{number:032x}" for number in range(3))

DENSE = MatchParameters(dense=True)
MAPS = ConsistentMapsPayload(shapes=SHAPES, parameters=DENSE)


@pytest.fixture
def maps(queue: JobQueue) -> JobRecord:
    """A queued job that needs the spectra of all shapes, which are queued before it."""
    for number in range(len(SHAPES)):
        accepted(queue.store, numbered(number))
    return queue.submit(MAPS)


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
