"""Jobs run by real forked processes: results, failures, cancellation, lost processes."""

import os
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from broker.contracts import (
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    Payload,
    PicturePayload,
    ShapeRecord,
    SpectrumPayload,
    ValidationPayload,
    shape_id,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS
from solver.mesh import read_mesh
from tests.worker.figures import blob, blob_file, off, two_blobs_file
from tests.workers import Upload, another_horse, ended, horse_of, nothing_is_left, validation
from worker.jobs import mesh_from_bytes
from worker.jobs.match_results import result_from_blob

Run = Callable[[Payload], JobRecord]

linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")

QUICK = MatchParameters(points=8, eigenpairs=30, orientation=False)


def matching(source: str, target: str, parameters: MatchParameters = QUICK) -> MatchPayload:
    return MatchPayload(source=source, target=target, parameters=parameters)


def test_validation_makes_a_shape(served: JobQueue, upload: Upload) -> None:
    data = blob_file(2)
    shape = upload(data)
    record = served.store.shapes.get(shape)
    assert isinstance(record, ShapeRecord)
    mesh = read_mesh(data, "off")
    assert (record.vertices, record.faces) == (mesh.n_vertices, mesh.n_faces) == (162, 320)
    assert record.area == pytest.approx(mesh.area)
    assert (record.components, record.closed, record.has_colors) == (1, True, False)
    assert served.store.shapes.upload(shape) == data
    stored = served.store.shapes.mesh(shape)
    assert stored is not None
    assert (mesh_from_bytes(stored).vertices == mesh.vertices).all()
    assert (mesh_from_bytes(stored).faces == mesh.faces).all()
    assert (mesh_from_bytes(stored).vertex_ids == mesh.vertex_ids).all()


def test_an_upload_that_is_not_a_mesh_is_refused_and_deleted(served: JobQueue) -> None:
    data = b"this is not a mesh"
    shape = shape_id(data)
    record = ended(served, validation(served, data))
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == "unusable-mesh"
    assert record.error.status == 422
    nothing_is_left(served.store, shape)


def test_a_match_is_stored(served: JobQueue, run: Run, upload: Upload) -> None:
    source, target = upload(blob_file()), upload(blob_file(seed=1))
    record = run(matching(source, target))
    assert record.state is JobState.SUCCEEDED, record.error
    packed = served.store.results.document(record.id)
    assert packed is not None
    result = result_from_blob(packed)
    assert (result.source, result.target, result.parameters) == (source, target, QUICK)
    assert len(result.correspondences) == 8
    assert result.timings["total"] > 0


def test_a_second_match_computes_no_spectrum(served: JobQueue, run: Run, upload: Upload) -> None:
    spectra = served.store.spectra
    source, target = upload(blob_file(seed=2)), upload(blob_file(seed=3))
    before = spectra.counts()
    run(matching(source, target))
    first = spectra.counts()
    assert first.computed == before.computed + 2
    run(matching(source, target, QUICK.model_copy(update={"points": 12})))
    run(matching(target, source))
    second = spectra.counts()
    assert second.computed == first.computed
    assert second.hits == first.hits + 4
    run(matching(source, target, QUICK.model_copy(update={"eigenpairs": 101})))
    assert spectra.counts().computed == first.computed + 2
    fewer, many = (QUICK.model_copy(update={"simplify": count}) for count in (200, 642))
    for parameters in (fewer, fewer, many):
        record = ended(served, served.submit(matching(source, target, parameters)).id)
        assert record.state is JobState.SUCCEEDED, record.error
    # A shape that has no more vertices is not simplified.
    assert spectra.counts().computed == first.computed + 4


def test_a_spectrum_is_computed_by_one_while_others_wait(served: JobQueue, upload: Upload) -> None:
    shape = upload(blob_file(4, seed=107))  # of no other test, whose spectra are kept
    before = served.store.spectra.counts()
    payload = SpectrumPayload(shape=shape, eigenpairs=100, largest_component=False, file_type="off")
    jobs = [served.submit(payload) for _ in range(2)]
    parameters = MatchParameters(points=8)
    jobs += [served.submit(matching(shape, shape, parameters)) for _ in range(2)]
    for job in jobs:
        assert ended(served, job.id).state is JobState.SUCCEEDED
    assert served.store.spectra.counts().computed == before.computed + 1


def test_a_match_without_spectral_structures_computes_no_spectrum(
    served: JobQueue, run: Run, upload: Upload
) -> None:
    before = served.store.spectra.counts()
    shape = upload(blob_file(2, seed=4))
    parameters = MatchParameters(points=8, metric="geodesic", descriptor="none", orientation=False)
    record = ended(served, served.submit(matching(shape, shape, parameters)).id)
    assert record.state is JobState.SUCCEEDED, record.error
    assert served.store.spectra.counts() == before


def test_several_components(served: JobQueue, run: Run, upload: Upload) -> None:
    shape = upload(two_blobs_file())
    whole = ended(served, served.submit(matching(shape, shape)).id)
    assert whole.state is JobState.SUCCEEDED, whole.error
    largest = QUICK.model_copy(update={"largest_component": True})
    record = ended(served, served.submit(matching(shape, shape, largest)).id)
    assert record.state is JobState.SUCCEEDED, record.error


def test_a_match_of_a_deleted_shape_fails_with_the_reason(
    served: JobQueue, run: Run, upload: Upload
) -> None:
    source, target = upload(blob_file(seed=5)), upload(blob_file(seed=6))
    served.store.shapes.delete(target)
    record = run(matching(source, target))
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == "shape-deleted"
    assert target in record.error.detail


@pytest.mark.parametrize("name", ["test", r"$100_a$ $\frac{x}{$", "貓" * 50, "\\"], ids=str.__len__)
def test_a_picture(served: JobQueue, run: Run, name: str) -> None:
    data = blob_file(2, seed=7) + name.encode("unicode_escape").join((b"#", b"\n"))
    shape = shape_id(data)
    payload = ValidationPayload(shape=shape, name=name, file_type="off")
    ended(served, served.submit_validation(payload, data))
    match = run(matching(shape, shape))
    assert run(PicturePayload(job=match.id)).state is JobState.SUCCEEDED
    picture = served.store.results.picture(PicturePayload(job=match.id))
    assert picture is not None
    assert picture.startswith(b"\x89PNG")
    assert served.store.client.ttl(DEFAULT_KEYS.job_picture(match.id)) > 0


def test_a_mesh_too_large_for_the_memory_fails_alone(served: JobQueue, upload: Upload) -> None:
    # Four thousand million faces that the file only claims to have must not be believed either.
    data = b"OFF\n4 4000000000 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n"
    record = ended(served, validation(served, data))
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.status == 422
    upload(blob_file(2, seed=8))


def slow(shape: str) -> MatchPayload:
    """A match that takes some seconds."""
    parameters = MatchParameters(points=256, alternatives=32, coarse_points=10)
    return matching(shape, shape, parameters)


def test_a_running_job_is_cancelled(served: JobQueue, upload: Upload) -> None:
    job = served.submit(slow(upload(blob_file(4))))
    horse = horse_of(served, job.id)
    assert served.store.jobs.cancel(job.id) is JobState.RUNNING
    record = ended(served, job.id)
    assert record.state is JobState.CANCELLED
    assert record.error is None
    assert served.store.results.document(job.id) is None
    assert horse > 0


@linux
def test_a_job_whose_process_is_killed_is_repeated_once_then_fails(
    served: JobQueue, upload: Upload
) -> None:
    job = served.submit(slow(upload(blob_file(4))))
    first = horse_of(served, job.id)
    os.kill(first, signal.SIGKILL)
    os.kill(another_horse(served, job.id, first), signal.SIGKILL)
    record = ended(served, job.id)
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == "worker-lost"
    assert "signal 9" in record.error.detail


@linux
def test_a_job_succeeds_after_its_process_was_killed_once(
    served: JobQueue, run: Run, upload: Upload
) -> None:
    shape = upload(blob_file(4))
    job = served.submit(matching(shape, shape, MatchParameters(points=256)))
    os.kill(horse_of(served, job.id), signal.SIGKILL)
    record = ended(served, job.id)
    assert record.state is JobState.SUCCEEDED, record.error


def test_vertices_are_numbered_as_in_the_file(served: JobQueue, upload: Upload) -> None:
    vertices, faces = blob(2, seed=10)
    # A vertex of no face comes first; it is dropped, and the others keep their numbers.
    shape = upload(off(np.concatenate([[[9.0, 9.0, 9.0]], vertices]), faces + 1))
    record, stored = served.store.shapes.get(shape), served.store.shapes.mesh(shape)
    assert record is not None
    assert stored is not None
    mesh = mesh_from_bytes(stored)
    np.testing.assert_array_equal(mesh.vertex_ids, np.arange(1, len(vertices) + 1))
    assert mesh.warnings == record.warnings != ()
