"""``/v1/dissimilarities``."""

from collections.abc import Iterator, Mapping
from typing import BinaryIO, Final

from fastapi import APIRouter, Response
from starlette.concurrency import run_in_threadpool

from broker.contracts import (
    PAIRS,
    RESULT,
    DissimilaritiesPayload,
    DissimilarityParameters,
    JobRecord,
    JobState,
)
from service.dependencies import Service, ServiceOf
from service.dissimilarities.partial import (
    known_pairs,
    number_of_pairs,
    packed_document,
    stored_matrix,
    written_matrix,
)
from service.dissimilarities.schemas import DissimilaritiesRequest, PartialDissimilarities
from service.http import (
    AcceptEncoding,
    InvalidRequest,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    ResultExpired,
    responses,
)
from service.jobs import (
    Job,
    JobId,
    JobOrderOf,
    answers,
    job_with_result,
    json_answer,
    open_result,
)
from service.shapes import (
    check_shapes,
    few_vertices,
    refuse,
    repeated_shapes,
    shape_fields,
    use_shapes,
)

_REFUSED: Final = "These shapes cannot be compared; `errors` says why."

router = APIRouter(prefix="/v1/dissimilarities", tags=["dissimilarities"])


@router.post(
    "",
    status_code=202,
    responses=answers(),
    operation_id="create_dissimilarities",
)
def create_dissimilarities(asked: DissimilaritiesRequest, order: JobOrderOf) -> Job:
    """Compare all pairs of a collection of shapes.

    The dissimilarity of two shapes is the minimum distortion of a match of a few points, solved to
    proven optimality. Workers share the pairs, and run other jobs in between; `partial` links to
    the dissimilarities known so far.
    """
    return order.job(asked, _payload)


@router.get(
    "/{job_id}",
    response_model=PartialDissimilarities,
    responses=responses(JobNotFound, JobExpired, JobWithoutResult, ResultExpired, InvalidRequest),
    operation_id="get_dissimilarities",
)
async def get_dissimilarities(
    job_id: JobId, service: ServiceOf, accept_encoding: AcceptEncoding = ""
) -> Response:
    """Return the dissimilarities known so far of a job that compares shapes."""
    async with service.preparing:
        document = await run_in_threadpool(_document, service, job_id)
    return json_answer(document, accept_encoding)


def _document(service: Service, job_id: str) -> BinaryIO:
    record = job_with_result(service, job_id)
    payload = record.payload
    if not isinstance(payload, DissimilaritiesPayload):
        raise JobWithoutResult(f"A {record.kind.value} has no dissimilarities; ask for its result.")
    count = len(payload.shapes)
    matrix, done = known_so_far(service, record, count)
    fields = {
        "job": record.id,
        "state": record.state.value,
        "shapes": payload.shapes,
        "names": payload.names,
        "labels": payload.labels,
        "pairs": number_of_pairs(count),
        "pairs_done": done,
    }
    return packed_document(fields, matrix)


def known_so_far(service: Service, record: JobRecord, count: int) -> tuple[Iterator[bytes], int]:
    """Return the dissimilarities of a job known so far, and the number of pairs known.

    The former are a matrix as JSON, in pieces, null for what is not known.

    Parameters
    ----------
    service
        The service that runs the job.
    record
        The job as it was a moment ago.
    count
        Number of its shapes.

    Raises
    ------
    JobExpired, JobWithoutResult, ResultExpired
        It has ended meanwhile, without a result or with one that has expired.
    """
    parts = service.store.chunks
    if record.state is JobState.RUNNING:
        counts = parts.counts(record.id)
        found = parts.results(record.id, PAIRS) if counts.stage in (PAIRS, RESULT) else {}
        size = _size(counts.size, counts.stage, found, count)
        forgotten = counts.stage == RESULT or (counts.done > 0 and counts.stage == PAIRS)
        if found or (counts.stage and not forgotten):
            values = known_pairs(count, size, found)
            return written_matrix(count, values), sum(map(len, found.values())) // values.itemsize
        # It has ended a moment ago, or no part of it has begun.
        record = job_with_result(service, record.id)
    if record.state is JobState.SUCCEEDED:
        return stored_matrix(open_result(service, record.id)), number_of_pairs(count)
    return written_matrix(count, known_pairs(count, 1, {})), 0


def _size(size: int, stage: str, found: Mapping[int, bytes], count: int) -> int:
    # All parts but the last are of this size; while the result is made, all are there.
    return size if stage == PAIRS else max(len(found.get(0, b"")) // 8, 1)


def _payload(asked: DissimilaritiesRequest, service: Service) -> DissimilaritiesPayload:
    refuse(repeated_shapes(asked.shapes, asked.names), _REFUSED)
    shapes = use_shapes(service, shape_fields(asked.shapes))
    check_shapes(asked, shapes, _REFUSED, few_vertices(shapes, asked.points))
    return DissimilaritiesPayload(
        shapes=asked.shapes,
        names=asked.names,
        labels=asked.labels,
        parameters=asked.parameters(DissimilarityParameters),
    )
