"""``/v1/prototype-archives``: prototypes that were learned elsewhere, or at another time."""

from typing import Annotated, Any, Final

from fastapi import APIRouter, File, Form, Request, Response, UploadFile
from pydantic import AfterValidator
from starlette.concurrency import run_in_threadpool

from broker.contracts import (
    ARCHIVE_TYPE,
    JobRecord,
    PrototypeRecord,
    PrototypeValidationPayload,
    RequestContext,
    prototype_id,
)
from service.http import (
    BadRequest,
    BodyStalled,
    EncodedBody,
    IdempotencyKeyReused,
    InvalidRequest,
    PrototypeDeleted,
    UnusablePrototype,
    UploadCancelled,
    UploadTooLarge,
    responses,
)
from service.names import LONGEST, base_name, showable
from service.orders import IdempotencyKey
from service.prototypes.schemas import DEFAULT_NAME, Prototype
from service.state import Caller, RequestId, Service, ServiceOf
from service.uploads import VALIDATING, EachPartOnce, bind, read, still_reading

PROTOTYPES: Final = "/v1/prototypes"
PATH: Final = "/v1/prototype-archives"

router = APIRouter(prefix=PATH, tags=["prototypes"])

_LOCATION: Final = {"Location": {"description": "The prototype.", "schema": {"type": "string"}}}
VALIDATING_PROTOTYPE: Final[dict[str, Any]] = {
    **VALIDATING,
    "description": "Still being read: the job that does it. Ask for the prototype again.",
    "headers": _LOCATION,
}


@router.post(
    "",
    status_code=201,
    response_model=Prototype,
    responses={
        200: {
            "model": Prototype,
            "description": "The prototype is known already, under the name it has",
            "headers": _LOCATION,
        },
        201: {"description": "A new prototype", "headers": _LOCATION},
        202: VALIDATING_PROTOTYPE,
        **responses(
            UnusablePrototype,
            InvalidRequest,
            UploadTooLarge,
            BadRequest,
            BodyStalled,
            EncodedBody,
            IdempotencyKeyReused,
            UploadCancelled,
            PrototypeDeleted,
        ),
    },
    operation_id="upload_prototype",
    dependencies=[EachPartOnce],
)
async def upload_prototype(
    service: ServiceOf,
    request: Request,
    request_id: RequestId,
    caller: Caller,
    file: Annotated[
        UploadFile, File(description="A prototype, as `GET /v1/prototypes/{id}/archive` gives it.")
    ],
    name: Annotated[
        Annotated[str, AfterValidator(showable)] | None,
        Form(min_length=1, max_length=LONGEST, description="A name; default: that of the file."),
    ] = None,
    key: IdempotencyKey = None,
) -> Response:
    """Upload a prototype.

    It is read and checked before the answer is given; what cannot be used is refused with the
    reason and leaves nothing behind. The same bytes are the same prototype. Another one of a name
    that there is becomes the next version of that name.
    """
    if file.size is not None and file.size > service.settings.max_upload_bytes:
        raise UploadTooLarge(f"The limit is {service.settings.max_upload_bytes} bytes.")
    stem = base_name(file.filename or "").removesuffix(f".{ARCHIVE_TYPE}")[:LONGEST]
    async with service.uploading:
        data = await file.read()
        payload = PrototypeValidationPayload(
            prototype=await run_in_threadpool(prototype_id, data),
            name=(name or "").strip() or stem or DEFAULT_NAME,
        )
        await run_in_threadpool(bind, service, payload, caller, PATH, key)
        known, job_id = await run_in_threadpool(
            _take_in, service, data, payload, RequestContext(request_id, caller)
        )
        del data  # not to be kept while it is read
    if known is not None:
        return _prototype(known, 200)
    found = await read(service, payload, job_id, request, service.store.prototypes.get)
    if found is None:
        raise PrototypeDeleted("Somebody deleted it as soon as it was read; send it again.")
    if isinstance(found, JobRecord):
        return await run_in_threadpool(still_validating, service, found)
    return _prototype(found, 201)


def still_validating(service: Service, record: JobRecord) -> Response:
    """Return the answer that an archive is still being read."""
    assert isinstance(record.payload, PrototypeValidationPayload)
    return still_reading(service, record, f"{PROTOTYPES}/{record.payload.prototype}")


def _take_in(
    service: Service, data: bytes, payload: PrototypeValidationPayload, order: RequestContext
) -> tuple[PrototypeRecord | None, str]:
    known = service.store.prototypes.use(payload.prototype)
    if known is not None:
        return known, ""
    return None, service.queue.submit_validation(payload, data, order)


def _prototype(record: PrototypeRecord, status: int) -> Response:
    return Response(
        record.model_dump_json(),
        status_code=status,
        media_type="application/json",
        headers={"Location": f"{PROTOTYPES}/{record.id}"},
    )
