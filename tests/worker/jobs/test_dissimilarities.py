"""Collections compared by real forked processes: results and failures."""

import gzip
import io
from collections.abc import Callable
from itertools import combinations, permutations

import numpy as np
import pytest
from scipy.spatial.distance import squareform

from broker.contracts import (
    DissimilaritiesPayload,
    DissimilarityParameters,
    DissimilarityResult,
    JobRecord,
    JobState,
    Payload,
    PicturePayload,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS
from solver.arrays import FloatArray
from solver.mesh import read_mesh
from solver.shape import Shape
from solver.similarity import (
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    pairs_between,
    signature,
)
from tests.solver.shapes import tetrahedron
from tests.waiting import until
from tests.worker.collections import class_files, imagined
from tests.worker.figures import blob_file, off, two_blobs_file
from tests.workers import Upload, ended
from worker.jobs import result_of as document_of
from worker.jobs.options import options_of

Run = Callable[[Payload], JobRecord]

QUICK = DissimilarityParameters(eigenpairs=40)


def asked(
    shapes: list[str],
    parameters: DissimilarityParameters = QUICK,
    labels: list[str] | None = None,
) -> DissimilaritiesPayload:
    given = None if labels is None else tuple(labels)
    return DissimilaritiesPayload(shapes=tuple(shapes), labels=given, parameters=parameters)


def result_of(queue: JobQueue, job: JobRecord) -> DissimilarityResult:
    assert job.state is JobState.SUCCEEDED, job.error
    packed = queue.store.results.document(job.id)
    assert packed is not None
    return DissimilarityResult.model_validate_json(gzip.decompress(packed))


def until_forgotten(queue: JobQueue, job: JobRecord) -> None:
    """Wait until the chunks of a job are deleted, as they are soon after its end."""
    chunks = DEFAULT_KEYS.job_chunks(job.id) + "*"
    until(lambda: not queue.store.client.keys(chunks), pause=0.01)


@pytest.mark.parametrize(
    "parameters",
    [QUICK, QUICK.model_copy(update={"objective": "linf", "points": 8, "metric": "geodesic"})],
    ids=["l2", "linf"],
)
def test_a_matrix_equals_the_solvers(
    served: JobQueue, run: Run, upload: Upload, parameters: DissimilarityParameters
) -> None:
    files = class_files()
    labels = [name for name, _ in files]
    job = run(asked([upload(data) for _, data in files], parameters, labels))
    found = result_of(served, job)
    options = options_of(SimilarityOptions, parameters)
    signatures = [
        signature(Shape(read_mesh(data, "off"), eigenpairs=40), options) for _, data in files
    ]
    both = SignatureCollection.of(signatures, options.points)
    expected = squareform(dissimilarities(both, pairs_between(6, 0, 15), options).costs)
    stored = served.store.results.arrays(job.id)
    assert stored is not None
    with np.load(io.BytesIO(stored), allow_pickle=False) as arrays:
        assert arrays["matrix"] == pytest.approx(expected, rel=1e-6, abs=1e-9)
        assert arrays["labels"].tolist() == labels
        assert (arrays["lower_bounds"] <= arrays["matrix"][np.triu_indices(6, 1)]).all()
    matrix = np.array(found.matrix)
    assert matrix == pytest.approx(expected, rel=1e-6, abs=1e-9)
    assert (matrix == matrix.T).all()
    assert np.array(found.lower_bounds) == pytest.approx(matrix[np.triu_indices(6, 1)])
    assert (found.mean_average_precision, found.precision_at_1) == (1.0, 1.0)
    assert found.average_precisions == (1.0,) * 6
    # Two of each class, side by side.
    assert [row[0] for row in found.nearest] == [1, 0, 3, 2, 5, 4]
    assert set(found.timings) == {"structures", "pairs", "total"}
    until_forgotten(served, job)


@pytest.mark.parametrize("objective", ["l2", "linf"])
def test_a_certified_dissimilarity_is_the_least_of_all_bijections(
    served: JobQueue, run: Run, upload: Upload, objective: str
) -> None:
    parameters = QUICK.model_copy(
        update={"objective": objective, "points": 5, "first_order_weight": 0.0}
    )
    files = [data for _, data in class_files(1)]
    found = result_of(served, run(asked([upload(data) for data in files], parameters)))
    options = options_of(SimilarityOptions, parameters)
    metrics = [
        signature(Shape(read_mesh(data, "off"), eigenpairs=40), options).first(5).distances
        for data in files
    ]

    def distortion(a: FloatArray, b: FloatArray) -> float:
        if objective == "linf":
            return float(np.abs(a - b).max())
        return float(((a - b) ** 2).sum() / (0.5 * ((a**2).sum() + (b**2).sum())))

    least = [
        min(
            distortion(a, b[np.ix_(order, order)])
            for a, b in zip(metrics[i], metrics[j], strict=True)
            for order in permutations(range(5))
        )
        for i, j in combinations(range(len(files)), 2)
    ]
    assert found.certified
    assert np.array(found.matrix)[np.triu_indices(len(files), 1)] == pytest.approx(least, rel=1e-6)


def test_cached_signatures_are_not_computed_again(
    served: JobQueue, run: Run, upload: Upload
) -> None:
    shapes = [upload(data) for _, data in class_files()]
    first = result_of(served, run(asked(shapes)))
    before = served.store.spectra.counts()
    other = result_of(served, run(asked(shapes[::-1], QUICK.model_copy(update={"points": 8}))))
    assert served.store.spectra.counts() == before
    assert other.timings["structures"] == 0.0
    assert first.mean_average_precision is None
    again = result_of(served, run(asked(shapes)))
    assert again.matrix == first.matrix


def test_a_heat_map(served: JobQueue, run: Run, upload: Upload) -> None:
    files = class_files()
    shapes, labels = [upload(data) for _, data in files], ["$a_b$", "貓", "", "a", "貓", "b" * 50]
    for given in (labels, None):
        job = run(asked(shapes, labels=given))
        assert run(PicturePayload(job=job.id)).state is JobState.SUCCEEDED
        picture = served.store.results.picture(PicturePayload(job=job.id))
        assert picture is not None
        assert picture.startswith(b"\x89PNG")
    job = run(imagined(served.store, 60, QUICK, seed=1))
    assert run(PicturePayload(job=job.id)).state is JobState.SUCCEEDED


def test_an_unusable_shape_is_named(served: JobQueue, run: Run, upload: Upload) -> None:
    sound, several = upload(blob_file(2)), upload(two_blobs_file())
    corners = upload(off(tetrahedron().vertices, tetrahedron().faces))
    job = run(asked([corners, sound]))
    assert job.state is JobState.FAILED
    assert job.error is not None
    assert (job.error.slug, job.error.status) == ("unusable-mesh", 422)
    assert [error.field for error in job.error.errors] == ["body.shapes.0"]
    assert "vertices" in job.error.detail
    until_forgotten(served, job)
    # Of several components, all are compared, or the largest alone.
    assert result_of(served, run(asked([sound, several]))).matrix[0][1] > 1e-3
    largest = QUICK.model_copy(update={"largest_component": True})
    # It is the same as the sound one.
    assert result_of(served, run(asked([sound, several], largest))).matrix[0][1] < 1e-9


def test_a_comparison_of_a_deleted_shape_fails_with_the_reason(
    served: JobQueue, run: Run, upload: Upload
) -> None:
    shapes = [upload(blob_file(2, seed=seed)) for seed in (31, 32)]
    served.store.shapes.delete(shapes[1])
    job = run(asked(shapes))
    assert job.state is JobState.FAILED
    assert job.error is not None
    assert job.error.slug == "shape-deleted"
    assert shapes[1] in job.error.detail


def test_the_work_is_shared(served: JobQueue) -> None:
    hard = DissimilarityParameters(points=10)
    payload = imagined(served.store, 40, hard, seed=2)
    job = served.submit(payload)
    time_slices: set[str] = set()
    while not (record := served.store.jobs.get(job.id)) or not record.state.ended:
        time_slices |= set(served.store.chunks.time_slices(job.id))
    assert len(result_of(served, ended(served, job.id)).matrix) == 40
    assert len(time_slices) >= 2


def test_extreme_values_are_finite_numbers_in_the_document() -> None:
    values = np.array([0.0, 5e-324, 2.5e-300, 1.23456789012e-7, 1.23456789012, 1e300])
    payload = DissimilaritiesPayload(
        shapes=("a", "b", "c", "d"), labels=None, parameters=DissimilarityParameters()
    )
    document = document_of(payload, values, {})
    np.testing.assert_allclose(document.lower_bounds, values, rtol=1e-8, atol=1e-299)
    assert DissimilarityResult.model_validate_json(document.model_dump_json()) == document


@pytest.mark.parametrize(
    ("labels", "warned"), [(None, False), (("a", "b", "b"), False), (("a", "b", "c"), True)]
)
def test_labels_that_are_all_different_are_said_to_give_no_scores(
    labels: tuple[str, ...] | None, warned: bool
) -> None:
    payload = DissimilaritiesPayload(
        shapes=("a", "b", "c"), labels=labels, parameters=DissimilarityParameters()
    )
    warnings = document_of(payload, np.array([1.0, 2.0, 3.0]), {}).warnings
    assert ["no two shapes have the same label" in said for said in warnings] == [True] * warned
