"""``/v1/attributes``: files of attributes of the vertices and faces of shapes."""

from typing import Annotated, Final

from fastapi import APIRouter, File, Path, Response, UploadFile

from broker.contracts import (
    ATTRIBUTE_FORMATS,
    AttributesRecord,
    AttributesValidationPayload,
    attribute_format_of,
    attributes_id_of,
)
from service.dependencies import Service, ServiceOf
from service.http import (
    AttributesDeleted,
    AttributesExpired,
    AttributesNotFound,
    InvalidRequest,
    UnknownAttributes,
    UnusableAttributes,
    responses,
)
from service.names import ID_PATTERN
from service.transfers.schemas import Attributes
from service.uploads import (
    KnownPartsOnce,
    UploadContextOf,
    UploadKind,
    UploadName,
    name_and_type,
)

PATH: Final = "/v1/attributes"

router = APIRouter(prefix=PATH, tags=["transfers"])

_FILES: Final = UploadKind[AttributesRecord](
    "attribute file",
    lambda store: store.attributes,
    "upload it again",
    AttributesNotFound,
    AttributesExpired,
    AttributesDeleted,
    path=PATH,
    location=PATH,
)
AttributesId = Annotated[str, Path(description="Id of the attribute file.", pattern=ID_PATTERN)]


@router.post(
    "",
    status_code=201,
    response_model=Attributes,
    responses=_FILES.answers(Attributes, "The same bytes were uploaded before", UnusableAttributes),
    operation_id="upload_attributes",
    dependencies=[KnownPartsOnce],
)
async def upload_attributes(
    context: UploadContextOf,
    file: Annotated[
        UploadFile,
        File(
            description="Attributes of the vertices or faces of a shape, row i of vertex or face i"
            " of its file. Its name, or else `name`, ends in one of"
            f" {', '.join(ATTRIBUTE_FORMATS)}; or else its `Content-Type` is that of the format, as"
            " text/csv is."
        ),
    ],
    name: UploadName = None,
) -> Response:
    """Upload attributes of the vertices or faces of a shape: scalars, colours, labels, weights.

    The file is read before the answer is given; one that cannot be used is refused with the reason
    and leaves nothing behind. The same bytes are the same file.
    """
    called, file_type = name_and_type(file, name, attribute_format_of, ATTRIBUTE_FORMATS)

    def describe(digest: str) -> AttributesValidationPayload:
        return AttributesValidationPayload(
            attributes=attributes_id_of(digest), name=called, file_type=file_type
        )

    return await _FILES.receive(context, file, describe)


@router.get(
    "/{attributes}",
    response_model=Attributes,
    responses={
        202: _FILES.validating,
        **responses(AttributesNotFound, AttributesExpired, UnusableAttributes, InvalidRequest),
    },
    operation_id="get_attributes",
)
def get_attributes(attributes: AttributesId, service: ServiceOf) -> Response:
    """Show what an attribute file has."""
    return _FILES.find(service, attributes)


@router.delete(
    "/{attributes}",
    status_code=204,
    response_class=Response,
    responses=responses(AttributesNotFound, InvalidRequest),
    operation_id="delete_attributes",
)
def delete_attributes(attributes: AttributesId, service: ServiceOf) -> None:
    """Delete an attribute file; queued transfers of it will fail with `attributes-deleted`."""
    _FILES.delete(service, attributes)


def use_attributes(service: Service, attributes: str) -> AttributesRecord:
    """Return the attribute file that a request names, and prolong its life until the job begins.

    Raises
    ------
    UnknownAttributes
        There is no such file, or it has expired.
    """
    record = service.store.attributes.use(attributes)
    if record is None:
        wrong = _FILES.unknown(service, "body.attributes", attributes)
        raise UnknownAttributes("Upload the attribute file first.", (wrong,))
    return record
