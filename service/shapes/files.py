"""``/v1/shapes/{id}/mesh`` and ``/geometry``: the uploaded file, and the geometry to draw."""

from typing import Any, Final

from fastapi import APIRouter, Response

from service.dependencies import ServiceOf
from service.http import (
    AcceptEncoding,
    ContentLost,
    GeometryNotKept,
    IfNoneMatch,
    InvalidRequest,
    ShapeExpired,
    ShapeNotFound,
    attachment,
    binary_file,
    etag_matches,
    file_response,
    gzip_response,
    responses,
    strong_etag,
    weak_etag,
)
from service.names import without_ending
from service.shapes.lookup import SHAPES, ShapeId

router = APIRouter(prefix="/v1/shapes", tags=["shapes"])

GEOMETRY: Final = """\
Little-endian: 8 bytes `isogeom1`; four uint32, V vertices, F triangles, 1 if there are colours,
and 1 for a point cloud, whose triangles were made of its points; four float64, the origin (x, y, z)
and the scale, in the file's unit of length; 3 V float32, the positions of the vertices relative to
the origin, in units of the scale; 3 F uint32, the corners of the triangles, as indices of
positions; V uint32, the 0-based index of each vertex in the file; with colours, 3 V uint8 of red,
green and blue."""
ETAG: Final = {"description": "Version of this content.", "schema": {"type": "string"}}
UNCHANGED: Final[dict[int | str, dict[str, Any]]] = {
    304: {"description": "It has not changed: `If-None-Match` lists its ETag"}
}


@router.get(
    "/{shape}/mesh",
    response_class=Response,
    responses={
        200: binary_file("The file", headers={"ETag": ETAG}),
        **UNCHANGED,
        **responses(ShapeNotFound, ShapeExpired, ContentLost, InvalidRequest),
    },
    operation_id="get_mesh",
)
def get_mesh(shape: ShapeId, service: ServiceOf, if_none_match: IfNoneMatch = None) -> Response:
    """Return the mesh file as it was uploaded, under the name it is stored under."""
    record = service.store.shapes.get(shape)
    # A shape is its bytes.
    etag = strong_etag(shape)
    headers = {"ETag": etag, "Cache-Control": "private, no-cache"}
    if record is not None and etag_matches(if_none_match, etag):
        service.store.shapes.use(shape)
        return Response(status_code=304, headers=headers)
    file = None if record is None else service.store.shapes.open_upload(shape)
    if record is None or file is None:
        raise SHAPES.missing(service, shape)
    headers |= attachment(without_ending(record.name), record.file_type)
    return file_response(file, "application/octet-stream", headers)


@router.get(
    "/{shape}/geometry",
    response_class=Response,
    responses={
        200: binary_file(GEOMETRY, headers={"ETag": ETAG}),
        **UNCHANGED,
        **responses(ShapeNotFound, ShapeExpired, GeometryNotKept, ContentLost, InvalidRequest),
    },
    operation_id="get_geometry",
)
def get_geometry(
    shape: ShapeId,
    service: ServiceOf,
    accept_encoding: AcceptEncoding = "",
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Return the repaired mesh in a binary form for drawing, independent of the file's format."""
    record = service.store.shapes.get(shape)
    if record is None:
        raise SHAPES.missing(service, shape)
    etag = weak_etag(f"{shape}-{int(1e6 * record.created.timestamp()):x}")
    headers = {"ETag": etag, "Cache-Control": "private, no-cache", "Vary": "Accept-Encoding"}
    if etag_matches(if_none_match, etag):
        service.store.shapes.use(shape)
        return Response(status_code=304, headers=headers)
    packed = service.store.shapes.open_geometry(shape)
    if packed is None and service.store.shapes.get(shape) is None:
        raise SHAPES.missing(service, shape)  # deleted in the meantime
    if packed is None:
        raise GeometryNotKept(
            "The shape was stored by an earlier version, which kept no geometry; delete the shape"
            " and upload it again."
        )
    return gzip_response(packed, "application/octet-stream", accept_encoding, headers)
