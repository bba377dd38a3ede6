"""``/v1/prototype-archives``; ``/v1/prototypes/{id}/archive`` and ``/geometry``."""

from typing import Annotated

from fastapi import APIRouter, File, Response, UploadFile

from broker.contracts import (
    ARCHIVE_TYPE,
    PrototypeGeometry,
    PrototypeValidationPayload,
    prototype_id_of,
)
from service.dependencies import ServiceOf
from service.http import (
    AcceptEncoding,
    ContentLost,
    GeometryNotKept,
    InvalidRequest,
    PrototypeExpired,
    PrototypeNotFound,
    UnusablePrototype,
    attachment,
    binary_file,
    file_response,
    gzip_response,
    responses,
)
from service.names import LONGEST, base_name
from service.prototypes.lookup import LOCATION, PATH, PROTOTYPES, PrototypeId
from service.prototypes.schemas import DEFAULT_NAME, Prototype
from service.uploads import KnownPartsOnce, UploadContextOf, UploadName

router = APIRouter(tags=["prototypes"])


@router.post(
    PATH,
    status_code=201,
    response_model=Prototype,
    responses=PROTOTYPES.answers(
        Prototype,
        "The same archive was uploaded before; its name and version stay",
        UnusablePrototype,
    ),
    operation_id="upload_prototype",
    dependencies=[KnownPartsOnce],
)
async def upload_prototype(
    context: UploadContextOf,
    file: Annotated[
        UploadFile, File(description="A prototype, as `GET /v1/prototypes/{id}/archive` gives it.")
    ],
    name: UploadName = None,
) -> Response:
    """Upload a prototype.

    It is validated before the answer is given; a file that cannot be used is refused with the
    reason and leaves nothing behind. The same bytes are the same prototype. A different prototype
    with a name that exists becomes the next version of that name.
    """
    stem = base_name(file.filename or "").removesuffix(f".{ARCHIVE_TYPE}")[:LONGEST]

    def describe(digest: str) -> PrototypeValidationPayload:
        called = (name or "").strip() or stem or DEFAULT_NAME
        return PrototypeValidationPayload(prototype=prototype_id_of(digest), name=called)

    return await PROTOTYPES.receive(context, file, describe)


@router.get(
    f"{LOCATION}/{{prototype}}/archive",
    response_class=Response,
    responses={
        200: binary_file("The archive"),
        **responses(PrototypeNotFound, PrototypeExpired, ContentLost, InvalidRequest),
    },
    operation_id="get_archive",
)
def get_archive(prototype: PrototypeId, service: ServiceOf) -> Response:
    """Return a prototype as an archive of NumPy arrays (npz), which is read without pickle.

    Uploaded again, here or elsewhere, it is the same prototype with the same id.
    """
    file = service.store.prototypes.open_archive(prototype)
    if file is None:
        raise PROTOTYPES.missing(service, prototype)
    return file_response(file, "application/octet-stream", attachment(prototype, "npz"))


@router.get(
    f"{LOCATION}/{{prototype}}/geometry",
    response_model=PrototypeGeometry,
    responses=responses(
        PrototypeNotFound, PrototypeExpired, GeometryNotKept, ContentLost, InvalidRequest
    ),
    operation_id="get_prototype_geometry",
)
def get_prototype_geometry(
    prototype: PrototypeId, service: ServiceOf, accept_encoding: AcceptEncoding = ""
) -> Response:
    """Return where the points of a prototype lie, with a surface to draw them on."""
    packed = service.store.prototypes.open_geometry(prototype)
    if packed is not None:
        return gzip_response(packed, "application/json", accept_encoding)
    if service.store.prototypes.get(prototype) is None:
        raise PROTOTYPES.missing(service, prototype)
    raise GeometryNotKept(
        "The prototype was stored by an earlier version, which kept no geometry; download its"
        " archive, delete the prototype and upload the archive again."
    )
