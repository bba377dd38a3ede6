"""``/v1/shapes``."""

from typing import Annotated, Any, Final

from fastapi import APIRouter, File, Form, Request, Response, UploadFile
from pydantic import AfterValidator
from starlette.concurrency import run_in_threadpool

from service.jobs.schemas import Job
from service.orders import IdempotencyKey
from service.paging import Cursor, Limit, page_of
from service.problems import (
    BadRequest,
    BodyStalled,
    IdempotencyKeyReused,
    InvalidRequest,
    Reported,
    ShapeDeleted,
    ShapeExpired,
    ShapeNotFound,
    UnsupportedFormat,
    UnusableMesh,
    UploadCancelled,
    UploadTooLarge,
    responses,
)
from service.shapes.lookup import ShapeId, missing_shape
from service.shapes.names import LONGEST, base_name, showable
from service.shapes.schemas import Shape, ShapePage
from service.state import Caller, RequestId, Service, ServiceOf
from worker.contracts import (
    MESH_FORMATS,
    JobRecord,
    JobState,
    Once,
    Order,
    ShapeRecord,
    ValidationPayload,
    file_type_of,
    shape_id,
)

PATH: Final = "/v1/shapes"

router = APIRouter(prefix=PATH, tags=["shapes"])


_LOCATION: Final = {"Location": {"description": "The shape.", "schema": {"type": "string"}}}
_VALIDATING: Final[dict[str, Any]] = {
    "model": Job,
    "description": "Still being read: the job that does it. Ask for the shape again.",
    "headers": _LOCATION,
}


@router.post(
    "",
    status_code=201,
    response_model=Shape,
    responses={
        200: {"model": Shape, "description": "The shape is known already", "headers": _LOCATION},
        201: {"description": "A new shape", "headers": _LOCATION},
        202: _VALIDATING,
        **responses(
            UnusableMesh,
            InvalidRequest,
            UploadTooLarge,
            UnsupportedFormat,
            BadRequest,
            BodyStalled,
            IdempotencyKeyReused,
            UploadCancelled,
            ShapeDeleted,
        ),
    },
    operation_id="upload_shape",
)
async def upload_shape(
    service: ServiceOf,
    request: Request,
    request_id: RequestId,
    caller: Caller,
    file: Annotated[
        UploadFile,
        File(description=f"A mesh; its name ends in one of {', '.join(MESH_FORMATS)}."),
    ],
    name: Annotated[
        Annotated[str, AfterValidator(showable)] | None,
        Form(min_length=1, max_length=LONGEST, description="A name; default: that of the file."),
    ] = None,
    key: IdempotencyKey = None,
) -> Response:
    """Upload a mesh.

    It is read and checked before the answer is given; what cannot be used is refused with the
    reason and leaves nothing behind. The same bytes are the same shape, so an upload can be sent
    again even without an `Idempotency-Key`.
    """
    filename = base_name(file.filename or "")
    file_type = file_type_of(filename)
    if file_type is None:
        raise UnsupportedFormat(
            f"The name {filename[:100]!r} has no ending that is read; use one of"
            f" {', '.join('.' + ending for ending in MESH_FORMATS)}."
        )
    if file.size is not None and file.size > service.settings.max_upload_bytes:
        raise UploadTooLarge(f"The limit is {service.settings.max_upload_bytes} bytes.")
    data = await file.read()
    payload = ValidationPayload(
        shape=await run_in_threadpool(shape_id, data),
        name=(name or "").strip() or filename[:LONGEST],
        file_type=file_type,
    )
    if key is not None:
        await run_in_threadpool(_bind, service, payload, caller, key)
    known, job_id = await run_in_threadpool(
        _take_in, service, data, payload, Order(request_id, caller)
    )
    if known is not None:
        return _shape(known, 200)
    return await _validated(service, payload, job_id, request)


def _bind(service: Service, payload: ValidationPayload, caller: str | None, key: str) -> None:
    # The body itself is never the same twice: its parts have a boundary made up for each.
    content = (b"POST", PATH.encode(), payload.model_dump_json().encode())
    service.store.orders.bind(Once.of(caller, key, content, service.settings.idempotency_ttl))


def _take_in(
    service: Service, data: bytes, payload: ValidationPayload, order: Order
) -> tuple[ShapeRecord | None, str]:
    known = service.store.shapes.use(payload.shape)
    if known is not None:
        return known, ""
    return None, service.queue.submit_validation(payload, data, order)


async def _validated(
    service: Service, payload: ValidationPayload, job_id: str, request: Request
) -> Response:
    record = await service.wait_for(job_id, service.settings.validation_wait, request)
    if record is not None and record.state is JobState.FAILED and record.error is not None:
        raise Reported(record.error)
    shape = await run_in_threadpool(service.store.shapes.get, payload.shape)
    if shape is not None:
        return _shape(shape, 201)
    if record is not None and record.state is JobState.SUCCEEDED:
        raise ShapeDeleted("Somebody deleted the shape as soon as it was read; send it again.")
    if record is None or record.state.ended:
        raise UploadCancelled("The upload was cancelled before it was read; send it again.")
    await run_in_threadpool(service.store.shapes.defer, payload.shape, job_id)
    return await run_in_threadpool(_still_validating, service, record)


@router.get("", responses=responses(InvalidRequest), operation_id="list_shapes")
def list_shapes(service: ServiceOf, limit: Limit = 50, cursor: Cursor = None) -> ShapePage:
    """List the shapes, the newest first."""
    page = page_of(lambda: service.store.shapes.page(limit, cursor))
    items = tuple(Shape.model_construct(**dict(record)) for record in page.items)
    return ShapePage(items=items, next_cursor=page.next_cursor)


@router.get(
    "/{shape}",
    response_model=Shape,
    responses={
        202: _VALIDATING,
        **responses(ShapeNotFound, ShapeExpired, UnusableMesh, InvalidRequest),
    },
    operation_id="get_shape",
)
def get_shape(shape: ShapeId, service: ServiceOf) -> Response:
    """Show a shape."""
    record = service.store.shapes.get(shape)
    if record is not None:
        return _shape(record, 200)
    # Somebody who was told to ask again is owed the reason if the upload was refused since.
    job_id = service.store.shapes.deferred(shape)
    job = None if job_id is None else service.store.jobs.get(job_id)
    if job is not None and not job.state.ended:
        return _still_validating(service, job)
    if job is not None and job.error is not None:
        raise Reported(job.error)
    raise missing_shape(service, shape)


@router.delete(
    "/{shape}",
    status_code=204,
    responses=responses(ShapeNotFound, InvalidRequest),
    operation_id="delete_shape",
)
def delete_shape(shape: ShapeId, service: ServiceOf) -> None:
    """Delete a shape; matches of it that have not begun will fail and say so."""
    if not service.store.shapes.delete(shape):
        raise ShapeNotFound(f"There is no shape {shape}.")
    service.store.spectra.forget(shape)


def _shape(record: ShapeRecord, status: int) -> Response:
    return Response(
        record.model_dump_json(),
        status_code=status,
        media_type="application/json",
        headers={"Location": f"{PATH}/{record.id}"},
    )


def _still_validating(service: Service, record: JobRecord) -> Response:
    assert isinstance(record.payload, ValidationPayload)
    return Response(
        Job.of(record, service.queue).model_dump_json(),
        status_code=202,
        media_type="application/json",
        headers={"Location": f"{PATH}/{record.payload.shape}", "Retry-After": "1"},
    )
