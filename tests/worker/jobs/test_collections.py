"""Jobs of several shapes of which no part of the result is found."""

import pytest

from broker.contracts import (
    ConsistentMapsPayload,
    JobState,
    MatchParameters,
    Payload,
    Problem,
    RegistrationPayload,
    shape_id,
)
from broker.queue import JobQueue, new_job
from tests.worker.families import family
from tests.workers import validation
from worker.jobs.runner import Runner

FAST = MatchParameters(points=12, coarse_points=6)


def uploaded(queue: JobQueue, files: list[bytes]) -> tuple[str, ...]:
    for data in files:
        Runner(queue, "runner").run(validation(queue, data))
    return tuple(map(shape_id, files))


def failure(queue: JobQueue, payload: Payload, **limits: int) -> Problem:
    """Why a job fails, with other limits."""
    job = queue.submit(new_job(payload)).id
    settings = queue.settings.model_copy(update=limits)
    Runner(JobQueue(queue.store, settings), "runner").run(job)
    record = queue.store.jobs.get(job)
    assert record is not None
    assert record.state is JobState.FAILED
    assert record.error is not None
    return record.error


def test_no_shape_is_blamed_for_maps_that_cannot_be_found(queue: JobQueue) -> None:
    # Without `dense`, no surfaces are registered to one another.
    payload = ConsistentMapsPayload(shapes=uploaded(queue, family(2, 1)), parameters=FAST)
    problem = failure(queue, payload)
    assert problem.slug == "no-solution"
    assert problem.errors == ()
    assert "could not be registered" in problem.detail


def test_a_shape_that_leaves_no_pair_is_blamed(queue: JobQueue) -> None:
    shapes = (*uploaded(queue, family(1, 1)), "deleted")
    payload = ConsistentMapsPayload(shapes=shapes, parameters=FAST)
    assert failure(queue, payload, job_timeout=0).slug == "shape-deleted"


@pytest.mark.parametrize("kind", [ConsistentMapsPayload, RegistrationPayload])
def test_without_time_for_any_part_a_job_took_too_long(queue: JobQueue, kind: type) -> None:
    shapes = uploaded(queue, family(3, 1))
    payload: Payload = ConsistentMapsPayload(shapes=shapes, parameters=FAST)
    if kind is RegistrationPayload:
        payload = RegistrationPayload(
            template=shapes[0], shapes=shapes[1:], scale=True, parameters=FAST
        )
    problem = failure(queue, payload, job_timeout=0)
    assert problem.slug == "timed-out"
    assert "give fewer shapes" in problem.detail
