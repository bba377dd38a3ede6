"""``/v1/jobs/{id}/result``: results as JSON, as pictures and as arrays."""

import gzip
import json
from typing import Annotated, Final

from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from broker.contracts import (
    DissimilarityResult,
    FieldProblem,
    JobKind,
    MatchPayload,
    MatchResult,
    PicturePayload,
    PrototypeResult,
    RequestOrigin,
    is_prototype,
    no_alternative,
)
from broker.queue import new_job
from service.dependencies import Caller, RequestId, Service, ServiceOf
from service.http import (
    INVALID,
    AcceptEncoding,
    InvalidRequest,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    PictureNotReady,
    PrototypeDeleted,
    Reported,
    ResultExpired,
    ResultNotReady,
    ShapeDeleted,
    binary_file,
    body_wanted,
    responses,
)
from service.jobs.lookup import JobId, job_with_result, json_answer, packed_result, result_expired

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

_ERRORS: Final = responses(
    JobNotFound, JobExpired, ResultNotReady, JobWithoutResult, ResultExpired, InvalidRequest
)


Alternative = Annotated[
    int | None,
    Query(
        ge=0,
        le=32,
        description="The answer of a match to draw: 0 for the match itself, j for the j-th of its"
        " `alternatives`; a refinement or dense map is drawn only if it belongs to that answer.",
    ),
]

_BYTES: Final = "application/octet-stream"
_PICTURE: Final = "image/png"


@router.get(
    "/{job_id}/result",
    response_model=MatchResult | DissimilarityResult | PrototypeResult,
    responses=_ERRORS,
    operation_id="get_result",
)
def get_result(job_id: JobId, service: ServiceOf, accept_encoding: AcceptEncoding = "") -> Response:
    """Return the result of a job: a match, the dissimilarities of a collection, or a prototype."""
    return json_answer(packed_result(service, job_id), accept_encoding)


@router.get(
    "/{job_id}/result.npz",
    response_class=Response,
    responses={200: binary_file("The arrays"), **_ERRORS},
    operation_id="get_arrays",
)
def get_arrays(job_id: JobId, service: ServiceOf) -> Response:
    """Return a result as NumPy arrays in full precision, in an archive (npz) read without pickle.

    For dissimilarities: `shapes` and `labels`; `matrix` (K, K); `lower_bounds` and `certified` of
    the pairs (0, 1), (0, 2), ..., (1, 2), ...; `nearest`, the indices of each shape's nearest
    neighbours. For a match: `source`, `target` and `costs` of the pairs; `unmatched`; and, if
    requested, `dense_source`, `dense_target`, `dense_faces` and `dense_barycentric`, the last to
    four decimals, the other direction as `inverse_target`, `inverse_source`, `inverse_faces` and
    `inverse_barycentric`, `refined_vertices` and `refined_weights`.
    """
    record = job_with_result(service, job_id)
    if not record.kind.has_arrays:
        raise JobWithoutResult(
            f"A job of kind {record.kind.value!r} has no arrays; ask for its result."
        )
    packed_result(service, job_id)
    arrays = service.store.results.arrays(job_id)
    if arrays is None:
        raise result_expired()
    headers = {"Content-Disposition": f'attachment; filename="{job_id}.npz"'}
    return Response(arrays, media_type=_BYTES, headers=headers)


@router.get(
    "/{job_id}/result.png",
    response_class=Response,
    responses={
        200: binary_file("The picture", _PICTURE, _BYTES),
        **_ERRORS,
        **responses(ResultExpired, JobExpired, ShapeDeleted, PrototypeDeleted, PictureNotReady),
    },
    operation_id="get_picture",
)
async def get_picture(
    job_id: JobId,
    service: ServiceOf,
    request_id: RequestId,
    caller: Caller,
    request: Request,
    alternative: Alternative = None,
    accept: Annotated[str, Header(include_in_schema=False)] = "",
) -> Response:
    """Draw the result of a job as PNG.

    For a match or one of its alternatives: both shapes, with corresponding points in the same
    colour. For dissimilarities: a heat map, in the order of the labels. Clients that accept only
    `application/octet-stream` get the same file with that type.
    """
    plain = accept.partition(";")[0].strip() == _BYTES
    media_type, headers = _BYTES if plain else _PICTURE, {"Vary": "Accept"}
    picture = await run_in_threadpool(service.store.results.picture, job_id, alternative)
    if picture is None:
        await run_in_threadpool(_drawable, service, job_id, alternative)
        if not body_wanted(request):
            return StreamingResponse(iter(()), media_type=media_type, headers=headers)
        payload = PicturePayload(job=job_id, alternative=alternative)
        order = RequestOrigin(request_id, caller)
        drawing = await run_in_threadpool(_submit_picture, service, payload, order)
        record = await service.wait_for(drawing, service.settings.picture_wait, request)
        picture = await run_in_threadpool(service.store.results.picture, job_id, alternative)
        if picture is None:
            if record is not None and record.error is not None:
                raise Reported(record.error)
            raise PictureNotReady("The picture is still being drawn; ask again.")
    return Response(picture, media_type=media_type, headers=headers)


def _drawable(service: Service, job_id: str, alternative: int | None) -> None:
    record = job_with_result(service, job_id)
    if alternative is not None and record.kind is not JobKind.MATCH:
        message = "`alternative` is only supported for matches; leave it out"
        field = FieldProblem(field="query.alternative", message=message)
        raise InvalidRequest(INVALID, (field,))
    if not record.kind.has_picture:
        raise JobWithoutResult(
            f"A job of kind {record.kind.value!r} has no picture; ask for its result."
        )
    packed = packed_result(service, job_id)
    if isinstance(record.payload, MatchPayload):
        _check_alternative(packed, alternative)
        _check_match(service, record.payload)


def _check_alternative(packed: bytes, alternative: int | None) -> None:
    if not alternative:
        return
    count = len(json.loads(gzip.decompress(packed))["alternatives"])
    if alternative > count:
        detail, field = no_alternative(alternative, count)
        raise InvalidRequest(detail, (field,))


def _check_match(service: Service, match: MatchPayload) -> None:
    shapes = [match.source, match.target]
    if is_prototype(match.source):
        shapes = [match.target]
        if service.store.prototypes.get(match.source) is None:
            raise PrototypeDeleted(_gone(f"Prototype {match.source}"))
    for shape in shapes:
        if service.store.shapes.get(shape) is None:
            raise ShapeDeleted(_gone(f"Shape {shape}"))


def _gone(what: str) -> str:
    return f"{what}, which the picture shows, was deleted or has expired."


def _submit_picture(service: Service, payload: PicturePayload, order: RequestOrigin) -> str:
    job = new_job(payload, order)
    holder = service.store.results.picture_job(payload.job, payload.alternative, job.id)
    if holder == job.id:
        service.queue.submit(job)
    return holder
