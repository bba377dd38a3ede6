"""``/v1/attributes``: files of attributes of the vertices and faces of shapes."""

from typing import Annotated, Final

from fastapi import APIRouter, File, Path, Response, UploadFile

from broker.contracts import (
    ATTRIBUTE_FORMATS,
    AttributesRecord,
    AttributesValidationPayload,
    FieldProblem,
    attribute_format_of,
    attributes_id,
)
from broker.store import Keys
from service.dependencies import Service, ServiceOf
from service.http import (
    AttributesDeleted,
    AttributesExpired,
    AttributesNotFound,
    InvalidRequest,
    UnknownAttributes,
    UnsupportedFormat,
    UnusableAttributes,
    responses,
)
from service.names import ID_PATTERN, LONGEST, base_name
from service.transfers.schemas import Attributes
from service.uploads import KnownPartsOnce, UploadContextOf, UploadKind, UploadName

PATH: Final = "/v1/attributes"

router = APIRouter(prefix=PATH, tags=["transfers"])

_UPLOADS: Final = UploadKind[AttributesRecord](
    "attribute file", PATH, PATH, lambda store: store.attributes, Keys.attributes, AttributesDeleted
)
AttributesId = Annotated[str, Path(description="Id of the attribute file.", pattern=ID_PATTERN)]


@router.post(
    "",
    status_code=201,
    response_model=Attributes,
    responses=_UPLOADS.answers(
        Attributes, "The same bytes were uploaded before", UnusableAttributes, UnsupportedFormat
    ),
    operation_id="upload_attributes",
    dependencies=[KnownPartsOnce],
)
async def upload_attributes(
    context: UploadContextOf,
    file: Annotated[
        UploadFile,
        File(
            description="Attributes of the vertices or faces of a shape, row i of vertex or face i"
            f" of its file; the name ends in one of {', '.join(ATTRIBUTE_FORMATS)}."
        ),
    ],
    name: UploadName = None,
) -> Response:
    """Upload attributes of the vertices or faces of a shape: scalars, colours, labels, weights.

    The file is read before the answer is given; one that cannot be used is refused with the reason
    and leaves nothing behind. The same bytes are the same file.
    """
    filename = base_name(file.filename or "")
    file_type = attribute_format_of(filename)
    if file_type is None:
        raise UnsupportedFormat(
            f"The file name {filename[:100]!r} ends in no supported format; use one of"
            f" {', '.join('.' + ending for ending in ATTRIBUTE_FORMATS)}."
        )

    def describe(data: bytes) -> AttributesValidationPayload:
        called = (name or "").strip() or filename[:LONGEST]
        return AttributesValidationPayload(
            attributes=attributes_id(data), name=called, file_type=file_type
        )

    return await _UPLOADS.receive(context, file, describe)


@router.get(
    "/{attributes}",
    response_model=Attributes,
    responses={
        202: _UPLOADS.validating,
        **responses(AttributesNotFound, AttributesExpired, UnusableAttributes, InvalidRequest),
    },
    operation_id="get_attributes",
)
def get_attributes(attributes: AttributesId, service: ServiceOf) -> Response:
    """Show what an attribute file has."""
    found = _UPLOADS.find(service, attributes)
    if found is not None:
        return found
    if service.store.attributes.expired(attributes):
        raise AttributesExpired(
            "The attribute file was not used for long and is no longer kept; upload it again."
        )
    raise AttributesNotFound(f"There is no attribute file {attributes}.")


@router.delete(
    "/{attributes}",
    status_code=204,
    responses=responses(AttributesNotFound, InvalidRequest),
    operation_id="delete_attributes",
)
def delete_attributes(attributes: AttributesId, service: ServiceOf) -> None:
    """Delete an attribute file; queued transfers of it will fail with `attributes-deleted`."""
    if not service.store.attributes.delete(attributes):
        raise AttributesNotFound(f"There is no attribute file {attributes}.")


def use_attributes(service: Service, attributes: str) -> AttributesRecord:
    """Return the attribute file that a request names, and prolong its life until the job begins.

    Raises
    ------
    UnknownAttributes
        There is no such file, or it has expired.
    """
    record = service.store.attributes.use(attributes)
    if record is not None:
        return record
    message = f"there is no attribute file {attributes}"
    if service.store.attributes.expired(attributes):
        message = f"attribute file {attributes} is no longer kept; upload it again"
    fields = (FieldProblem(field="body.attributes", message=message),)
    raise UnknownAttributes("Upload the attribute file first.", fields)
