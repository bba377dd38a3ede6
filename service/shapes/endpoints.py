"""``/v1/shapes``."""

from typing import Annotated

from fastapi import APIRouter, File, Response, UploadFile

from broker.contracts import (
    MESH_FORMATS,
    ValidationPayload,
    file_type_of,
    shape_id_of,
)
from broker.upkeep import evict_deleted
from service.dependencies import ServiceOf
from service.http import (
    Cursor,
    InvalidRequest,
    Limit,
    ShapeExpired,
    ShapeNotFound,
    UnusableMesh,
    page_of,
    responses,
)
from service.shapes.lookup import PATH, SHAPES, ShapeId
from service.shapes.schemas import Shape, ShapePage
from service.uploads import (
    KnownPartsOnce,
    UploadContextOf,
    UploadName,
    name_and_type,
)

router = APIRouter(prefix=PATH, tags=["shapes"])


@router.post(
    "",
    status_code=201,
    response_model=Shape,
    responses=SHAPES.answers(Shape, "The same bytes were uploaded before", UnusableMesh),
    operation_id="upload_shape",
    dependencies=[KnownPartsOnce],
)
async def upload_shape(
    context: UploadContextOf,
    file: Annotated[
        UploadFile,
        File(
            description="A mesh or a point cloud. Its name, or else `name`, ends in one of"
            f" {', '.join(MESH_FORMATS)}; or else its `Content-Type` is that of the format, such as"
            " model/obj."
        ),
    ],
    name: UploadName = None,
) -> Response:
    """Upload a mesh or a point cloud.

    It is validated before the answer is given; a file that cannot be used is refused with the
    reason and leaves nothing behind. The same bytes are the same shape, so an upload can be sent
    again even without an `Idempotency-Key`.
    """
    called, file_type = name_and_type(file, name, file_type_of, MESH_FORMATS)

    def describe(digest: str) -> ValidationPayload:
        return ValidationPayload(shape=shape_id_of(digest), name=called, file_type=file_type)

    return await SHAPES.receive(context, file, describe)


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
        202: SHAPES.validating,
        **responses(ShapeNotFound, ShapeExpired, UnusableMesh, InvalidRequest),
    },
    operation_id="get_shape",
)
def get_shape(shape: ShapeId, service: ServiceOf) -> Response:
    """Show a shape."""
    return SHAPES.find(service, shape)


@router.delete(
    "/{shape}",
    status_code=204,
    response_class=Response,
    responses=responses(ShapeNotFound, InvalidRequest),
    operation_id="delete_shape",
)
def delete_shape(shape: ShapeId, service: ServiceOf) -> None:
    """Delete a shape; queued matches of it will fail with `shape-deleted`."""
    SHAPES.delete(service, shape)
    evict_deleted(service.store, [shape])
