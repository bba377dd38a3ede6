"""``/v1/shapes``."""

from typing import Annotated, Any, Final

from fastapi import APIRouter, File, Form, Request, Response, UploadFile
from pydantic import AfterValidator
from starlette.concurrency import run_in_threadpool

from broker.contracts import (
    MESH_FORMATS,
    JobRecord,
    RequestContext,
    ShapeRecord,
    ValidationPayload,
    file_type_of,
    shape_id,
)
from service.http import (
    BadRequest,
    BodyStalled,
    Cursor,
    EncodedBody,
    IdempotencyKeyReused,
    InvalidRequest,
    Limit,
    ShapeDeleted,
    ShapeExpired,
    ShapeNotFound,
    UnsupportedFormat,
    UnusableMesh,
    UploadCancelled,
    UploadTooLarge,
    page_of,
    responses,
)
from service.names import LONGEST, base_name, showable
from service.orders import IdempotencyKey
from service.shapes.lookup import ShapeId, missing_shape
from service.shapes.schemas import Shape, ShapePage
from service.state import Caller, RequestId, Service, ServiceOf
from service.uploads import VALIDATING, EachPartOnce, bind, read, reader, still_reading

PATH: Final = "/v1/shapes"

router = APIRouter(prefix=PATH, tags=["shapes"])


_LOCATION: Final = {"Location": {"description": "The shape.", "schema": {"type": "string"}}}
_VALIDATING: Final[dict[str, Any]] = {
    **VALIDATING,
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
            EncodedBody,
            IdempotencyKeyReused,
            UploadCancelled,
            ShapeDeleted,
        ),
    },
    operation_id="upload_shape",
    dependencies=[EachPartOnce],
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
    async with service.uploading:
        data = await file.read()
        payload = ValidationPayload(
            shape=await run_in_threadpool(shape_id, data),
            name=(name or "").strip() or filename[:LONGEST],
            file_type=file_type,
        )
        await run_in_threadpool(bind, service, payload, caller, PATH, key)
        known, job_id = await run_in_threadpool(
            _take_in, service, data, payload, RequestContext(request_id, caller)
        )
        del data  # not to be kept while it is read
    if known is not None:
        return _shape(known, 200)
    found = await read(service, payload, job_id, request, service.store.shapes.get)
    if found is None:
        raise ShapeDeleted("Somebody deleted the shape as soon as it was read; send it again.")
    if isinstance(found, JobRecord):
        return await run_in_threadpool(_still_validating, service, found)
    return _shape(found, 201)


def _take_in(
    service: Service, data: bytes, payload: ValidationPayload, order: RequestContext
) -> tuple[ShapeRecord | None, str]:
    known = service.store.shapes.use(payload.shape)
    if known is not None:
        return known, ""
    return None, service.queue.submit_validation(payload, data, order)


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
    job = reader(service, service.store.uploads.deferred(shape))
    if job is not None:
        return _still_validating(service, job)
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
    service.store.spectra.drop(shape)


def _shape(record: ShapeRecord, status: int) -> Response:
    return Response(
        record.model_dump_json(),
        status_code=status,
        media_type="application/json",
        headers={"Location": f"{PATH}/{record.id}"},
    )


def _still_validating(service: Service, record: JobRecord) -> Response:
    assert isinstance(record.payload, ValidationPayload)
    return still_reading(service, record, f"{PATH}/{record.payload.shape}")
