"""Jobs of several shapes of which parts, or no part, of the result are found."""

import gzip
import io
import json
import zipfile

import pytest
from numpy.lib.format import write_array_header_1_0

from broker.contracts import (
    ConsistentMapsPayload,
    JobState,
    MatchParameters,
    Payload,
    Problem,
    RegistrationPayload,
    shape_id,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS
from tests.worker.families import family, member
from tests.worker.figures import off
from tests.workers import validation
from worker.jobs.runner import Runner

FAST = MatchParameters(points=12, coarse_points=6)


def uploaded(queue: JobQueue, files: list[bytes]) -> tuple[str, ...]:
    for data in files:
        Runner(queue, "runner").run(validation(queue, data))
    return tuple(map(shape_id, files))


def failure(queue: JobQueue, payload: Payload, **limits: int) -> Problem:
    """Why a job fails, with other limits."""
    job = queue.submit(payload).id
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


def greedy_mesh() -> bytes:
    """A mesh whose vertices claim more memory than there is."""
    header, archive = io.BytesIO(), io.BytesIO()
    claimed = {"descr": "<f8", "fortran_order": False, "shape": (2**50, 3)}
    write_array_header_1_0(header, claimed)
    with zipfile.ZipFile(archive, "w") as files:
        files.writestr("vertices.npy", header.getvalue())
    return archive.getvalue()


@pytest.mark.parametrize("kind", [ConsistentMapsPayload, RegistrationPayload])
def test_shapes_that_cannot_be_loaded_are_named(queue: JobQueue, kind: type) -> None:
    blobs, keys = queue.store.blobs, DEFAULT_KEYS
    first, second, lost, greedy = uploaded(queue, family(4, 1))
    reference = blobs.reference(keys.shape_mesh(lost))
    assert reference is not None
    blobs.store.delete(reference.path(keys.shape_mesh(lost)))
    blobs.save(keys.shape_mesh(greedy), greedy_mesh(), 1000)
    parameters = FAST.model_copy(update={"dense": True})
    payload: Payload = ConsistentMapsPayload(
        shapes=(first, second, lost, greedy), parameters=parameters
    )
    if kind is RegistrationPayload:
        payload = RegistrationPayload(
            template=first, shapes=(second, lost, greedy), scale=True, parameters=parameters
        )
    job = queue.submit(payload).id
    Runner(queue, "runner").run(job)
    packed = queue.store.results.document(job)
    assert packed is not None, queue.store.jobs.get(job)
    document = json.loads(gzip.decompress(packed))
    reports = document["specimens" if kind is RegistrationPayload else "shapes"]
    reasons = {one["shape"]: one["reason"] for one in reports}
    assert reasons[second] is None
    assert f"shape {lost} is missing" in reasons[lost]
    assert "more memory" in reasons[greedy]


@pytest.mark.parametrize("kind", [ConsistentMapsPayload, RegistrationPayload])
def test_warnings_of_single_matches_are_kept_with_the_names(queue: JobQueue, kind: type) -> None:
    vertices, faces = member(7)
    mirrored = off(vertices * [-1.0, 1.0, 1.0], faces[:, ::-1])
    shapes = uploaded(queue, [*family(1, first=6), mirrored])
    parameters = MatchParameters.of_whole_surfaces(False)
    payload: Payload = ConsistentMapsPayload(
        shapes=shapes, names=("left", "right"), parameters=parameters
    )
    if kind is RegistrationPayload:
        payload = RegistrationPayload(
            template=shapes[0],
            shapes=shapes[1:],
            names=("right",),
            scale=True,
            parameters=parameters,
        )
    job = queue.submit(payload).id
    Runner(queue, "runner").run(job)
    packed = queue.store.results.document(job)
    assert packed is not None, queue.store.jobs.get(job)
    (said,) = [one for one in json.loads(gzip.decompress(packed))["warnings"] if "mirror" in one]
    named = "right: " if kind is RegistrationPayload else "left with right: "
    assert said.startswith(f"{named}the source fits the target only as its mirror image")
