"""Collections over HTTP: compared, looked at on the way, fetched in three forms, refused."""

import gzip
import io
import json
import math
import struct
from array import array

import httpx2
import numpy as np
import pytest

from broker.contracts import (
    PAIRS,
    STRUCTURES,
    DissimilaritiesPayload,
    DissimilarityParameters,
    DissimilarityResult,
    JobState,
)
from broker.store import DEFAULT_KEYS
from service.dissimilarities.endpoints import known_so_far
from service.dissimilarities.partial import (
    known_pairs,
    number_of_pairs,
    packed_document,
    stored_matrix,
    written_matrix,
)
from service.dissimilarities.schemas import PartialDissimilarities
from service.http import JobExpired
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, Upload, idle_api, problem, service_over
from tests.solver.shapes import tetrahedron
from tests.worker.collections import class_files, imagined
from tests.worker.figures import blob_file, off

QUICK = {"eigenpairs": 40}

COUNT = 200
"""Shapes whose comparison lasts much longer than it is looked at."""


@pytest.fixture(scope="module")
def collection(upload: Upload) -> tuple[list[str], list[str]]:
    """Six shapes, two of each class, and their labels."""
    files = class_files()
    return [upload(data)["id"] for _, data in files], [name for name, _ in files]


def compared(http: httpx2.Client, body: Json) -> Json:
    asked = http.post("/v1/dissimilarities", json=body)
    assert asked.status_code == 202, asked.text
    assert asked.headers["location"] == asked.json()["links"]["self"]
    job: Json = http.get(asked.json()["links"]["self"], params={"wait": 60}).json()
    assert job["state"] == "succeeded", job["error"]
    return job


def test_a_collection_is_compared(
    http: httpx2.Client, collection: tuple[list[str], list[str]]
) -> None:
    shapes, labels = collection
    job = compared(http, {"shapes": shapes, "labels": labels, **QUICK})
    assert job["kind"] == "dissimilarities"
    answer = http.get(job["links"]["result"])
    result = DissimilarityResult.model_validate_json(answer.content)
    assert (list(result.shapes), list(result.labels or ())) == (shapes, labels)
    assert (result.mean_average_precision, result.precision_at_1) == (1.0, 1.0)
    matrix = np.array(result.matrix)
    assert (matrix == matrix.T).all()
    packed = http.get(job["links"]["arrays"])
    assert packed.headers["content-type"] == "application/octet-stream"
    assert f'"{job["id"]}.npz"' in packed.headers["content-disposition"]
    with np.load(io.BytesIO(packed.content), allow_pickle=False) as arrays:
        assert arrays["matrix"] == pytest.approx(matrix)
        assert arrays["shapes"].tolist() == shapes
    picture = http.get(job["links"]["picture"])
    assert picture.headers["content-type"] == "image/png"
    assert picture.content.startswith(b"\x89PNG")
    other = http.get(job["links"]["picture"], params={"alternative": 1})
    problem(other, 422, "invalid-request")
    whole = PartialDissimilarities.model_validate_json(http.get(job["links"]["partial"]).content)
    assert whole.pairs_done == whole.pairs == 15
    assert np.array(whole.matrix) == pytest.approx(matrix)
    listed = http.get("/v1/jobs").json()["items"]
    assert [item["kind"] for item in listed if item["id"].startswith(job["id"])] == [
        "dissimilarities"
    ]


def test_partial_dissimilarities_while_running_and_none_when_cancelled(
    http: httpx2.Client, api: Api
) -> None:
    payload = imagined(api.store, COUNT, DissimilarityParameters(points=10), seed=3)
    body = {"shapes": payload.shapes, "points": 10}
    job = http.post("/v1/dissimilarities", json=body).json()
    seen: list[PartialDissimilarities] = []
    while not seen or seen[-1].pairs_done == 0:
        answer = http.get(job["links"]["partial"])
        assert answer.status_code == 200, answer.text
        seen.append(PartialDissimilarities.model_validate_json(answer.content))
    assert seen[-1].state == "running"
    assert seen[-1].pairs_done < seen[-1].pairs == COUNT * (COUNT - 1) // 2
    known = sum(value is not None for row in seen[-1].matrix for value in row)
    assert known == COUNT + 2 * seen[-1].pairs_done
    problem(http.get(job["links"]["result"]), 409, "result-not-ready")
    problem(http.get(job["links"]["arrays"]), 409, "result-not-ready")
    cancelled = http.delete(job["links"]["self"]).json()
    assert cancelled["state"] == JobState.CANCELLED
    problem(http.get(job["links"]["partial"]), 409, "job-without-result")
    problem(http.get(job["links"]["arrays"]), 409, "job-without-result")


def test_a_match_is_no_collection(http: httpx2.Client, shapes: tuple[str, str]) -> None:
    body = {"source": shapes[0], "target": shapes[1], "points": 8, "eigenpairs": 30}
    job = http.post("/v1/matches", json=body).json()
    assert job["links"]["partial"] is None
    problem(http.get(f"/v1/dissimilarities/{job['id']}"), 409, "job-without-result")
    for unknown in ("/v1/dissimilarities/nobody", "/v1/jobs/nobody/result.npz"):
        problem(http.get(unknown), 404, "job-not-found")
    http.get(job["links"]["self"], params={"wait": 60})


@pytest.mark.parametrize(
    ("change", "field", "word"),
    [
        ({"shapes": []}, "body.shapes", "at least 2"),
        ({"shapes": ["a"] * 2001}, "body.shapes", "at most 2000"),
        ({"shapes": "ab"}, "body.shapes", "list"),
        ({"shapes": [0, 1]}, "body.shapes.0", "string"),
        ({"labels": ["a"]}, "body.labels", "label for each shape"),
        ({"labels": ["a", ""]}, "body.labels.1", "at least 1"),
        ({"labels": ["a", "b\n"]}, "body.labels.1", "one line"),
        ({"labels": ["a", 1]}, "body.labels.1", "string"),
        ({"names": ["a"]}, "body.names", "name for each shape"),
        ({"names": ["a", ""]}, "body.names.1", "at least 1"),
        ({"names": [None, "b\n"]}, "body.names.1", "one line"),
        ({"points": 11}, "body.points", "10"),
        ({"metric": "euclid"}, "body.metric", "geodesic"),
        ({"metric": ["geodesic"]}, "body.metric", "geodesic"),
        ({"descriptor": {"name": "hks", "times": []}}, "body.descriptor.times", "at least 1"),
        ({"objective": "linf", "first_order_weight": 1}, "body.objective", "first_order_weight"),
        ({"descriptor": "photometric", "first_order_weight": 0.1}, "body.descriptor", "colours"),
        ({"colour": "red"}, "body.colour", "no such field"),
    ],
)
def test_a_wrong_request_is_told_what_is_wrong(
    http: httpx2.Client, shapes: tuple[str, str], change: Json, field: str, word: str
) -> None:
    answer = http.post("/v1/dissimilarities", json={"shapes": shapes, **change})
    document = problem(answer, 422, "invalid-request")
    assert document["errors"][0]["field"] == field
    assert word in document["errors"][0]["message"]


def test_shapes_that_cannot_be_compared_are_named(
    http: httpx2.Client, upload: Upload, shapes: tuple[str, str]
) -> None:
    corners = upload(off(tetrahedron().vertices, tetrahedron().faces))["id"]
    gone = upload(blob_file(2, seed=40))["id"]
    http.delete(f"/v1/shapes/{gone}")

    def refused(given: list[str], slug: str = "invalid-request") -> dict[str, str]:
        document = problem(http.post("/v1/dissimilarities", json={"shapes": given}), 422, slug)
        return {error["field"]: error["message"] for error in document["errors"]}

    one, other = shapes
    assert refused([one, gone, "nobody"], "unknown-shape").keys() == {
        "body.shapes.1",
        "body.shapes.2",
    }
    twice = refused([one, other, one])
    assert "shapes.0" in twice["body.shapes.2"]
    found = refused([corners, one])
    assert "4 vertices" in found["body.shapes.0"]
    assert len(refused([one] * 500)) == 20


def test_parts_make_a_matrix() -> None:
    for count, size in ((2, 1), (5, 3), (9, 4), (6, 100)):
        expected = np.zeros((count, count))
        upper = np.triu_indices(count, 1)
        values = np.arange(1.0, number_of_pairs(count) + 1.0)
        parts = {
            number: values[first : first + size].astype("<f8").tobytes()
            for number, first in enumerate(range(0, len(values), size))
        }
        for left_out in (None, 0, len(parts) - 1):
            kept = {number: part for number, part in parts.items() if number != left_out}
            expected[upper] = np.where(np.arange(len(values)) // size == left_out, np.nan, values)
            written = b"".join(written_matrix(count, known_pairs(count, size, kept)))
            found = np.array(json.loads(written), dtype=np.float64)
            np.testing.assert_array_equal(found, expected + expected.T)


class InPieces(io.BytesIO):
    """A file of which few bytes are read at a time."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Return some bytes."""
        assert size is not None
        assert 0 <= size <= 256 * 1024
        return super().read(size)


def document_of(pieces: list[bytes]) -> Json:
    """A document with a matrix that comes in pieces."""
    with packed_document({"job": "a", "pairs": 1}, pieces) as packed:
        document: Json = json.loads(gzip.decompress(packed.read()))
    return document


def test_a_matrix_is_written_row_by_row() -> None:
    count = 500
    values = array("d", np.random.default_rng(0).random(number_of_pairs(count)))
    values[0] = math.nan
    pieces = list(written_matrix(count, values))
    document = document_of(pieces)
    assert document.keys() == {"job", "pairs", "matrix"}
    assert document["matrix"][0][:2] == [0.0, None]
    assert document["matrix"][7][3] == document["matrix"][3][7] == values[3 * count - 6 + 3]
    assert max(map(len, pieces)) < sum(map(len, pieces)) / 400


def test_the_matrix_of_a_result_is_copied_in_pieces() -> None:
    matrix = np.random.default_rng(0).random((500, 500)).tolist()
    for labels in (['"matrix":[[1]]'], [" " * (1024**2 // 4 - 40 + place) for place in range(24)]):
        result = {"labels": labels, "matrix": matrix, "nearest": [[1], [0]]}
        text = json.dumps(result, separators=(",", ":")).encode()
        packed = InPieces(gzip.compress(text, 1))
        pieces = list(stored_matrix(packed))
        assert packed.closed
        assert max(map(len, pieces)) <= 2 * 256 * 1024
        assert document_of(pieces) == {"job": "a", "pairs": 1, "matrix": matrix}


def test_partial_dissimilarities_when_the_job_ends_meanwhile(server: EmbeddedServer) -> None:
    with idle_api(server) as api:
        store, service = api.store, service_over(api.store)
        payload = DissimilaritiesPayload(
            shapes=("a", "b"), labels=None, parameters=DissimilarityParameters()
        )
        job = service.queue.submit(payload).id
        assert store.jobs.claim(job, job)
        results = {STRUCTURES: b"signature", PAIRS: struct.pack("<d", 2.0)}
        for before, stage in (("", STRUCTURES), (STRUCTURES, PAIRS)):
            assert store.chunks.open_stage(job, before, stage, 1, 0.5)
            taken = store.chunks.claim(job, "turn", "runner")
            assert store.chunks.complete(job, taken, results[stage], 0.1)
        running = store.jobs.get(job)
        assert running is not None

        def known() -> tuple[object, int]:
            matrix, done = known_so_far(service, running, 2)
            return json.loads(b"".join(matrix)), done

        everything = [[0.0, 2.0], [2.0, 0.0]], 1
        assert known() == everything
        assert store.jobs.succeed(job, job, b'{"matrix":[[0.0,2.0],[2.0,0.0]]}')
        store.client.delete(DEFAULT_KEYS.chunk_results(job, PAIRS))
        assert known() == everything
        store.chunks.delete(job)
        assert known() == everything
        store.client.delete(DEFAULT_KEYS.job(job))
        with pytest.raises(JobExpired):
            known()
