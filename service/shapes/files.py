"""``/v1/shapes/{id}/mesh`` and ``/geometry``: what there is of a shape besides its record."""

from typing import Annotated, Final

from fastapi import APIRouter, Header, Response

from service.http import (
    AcceptEncoding,
    GeometryNotKept,
    InvalidRequest,
    ShapeExpired,
    ShapeNotFound,
    names,
    responses,
    unpacked_if_need_be,
)
from service.shapes.lookup import ShapeId, missing_shape
from service.state import ServiceOf

router = APIRouter(prefix="/v1/shapes", tags=["shapes"])

GEOMETRY: Final = """\
Little end first: 8 bytes `isogeom1`; three uint32, V vertices, F triangles, and 1 if there are
colours; 4 bytes of zeros; four float64, the origin (x, y, z) and the scale, in the file's unit of
length; 3 V float32, the vertices' positions from the origin in units of the scale; 3 F uint32, the
triangles' corners, as numbers of positions; V uint32, the user's own number of each vertex, its
0-based index in the file; with colours, 3 V uint8 of red, green and blue."""


@router.get(
    "/{shape}/mesh",
    response_class=Response,
    responses={
        200: {
            "description": "The file",
            "content": {
                "application/octet-stream": {"schema": {"type": "string", "format": "binary"}}
            },
        },
        **responses(ShapeNotFound, ShapeExpired, InvalidRequest),
    },
    operation_id="get_mesh",
)
def get_mesh(shape: ShapeId, service: ServiceOf) -> Response:
    """Return the mesh file as it was uploaded."""
    record = service.store.shapes.get(shape)
    data = service.store.shapes.upload(shape)
    if record is None or data is None:
        raise missing_shape(service, shape)
    headers = {"Content-Disposition": f'attachment; filename="{shape}.{record.file_type}"'}
    return Response(data, media_type="application/octet-stream", headers=headers)


@router.get(
    "/{shape}/geometry",
    response_class=Response,
    responses={
        200: {
            "description": GEOMETRY,
            "content": {
                "application/octet-stream": {"schema": {"type": "string", "format": "binary"}}
            },
            "headers": {"ETag": {"description": "Of this geometry.", "schema": {"type": "string"}}},
        },
        304: {"description": "It is still what `If-None-Match` names"},
        **responses(ShapeNotFound, ShapeExpired, GeometryNotKept, InvalidRequest),
    },
    operation_id="get_geometry",
)
def get_geometry(
    shape: ShapeId,
    service: ServiceOf,
    accept_encoding: AcceptEncoding = "",
    if_none_match: Annotated[
        str | None, Header(alias="If-None-Match", description="ETags of geometries the client has.")
    ] = None,
) -> Response:
    """Return the repaired mesh in a form that can be drawn as it is, whatever the file's format."""
    record = service.store.shapes.get(shape)
    if record is None:
        raise missing_shape(service, shape)
    etag = f'"{shape}-{int(1e6 * record.created.timestamp()):x}"'
    headers = {"ETag": etag, "Cache-Control": "private, no-cache", "Vary": "Accept-Encoding"}
    if names(if_none_match or "", etag):
        return Response(status_code=304, headers=headers)
    packed = service.store.shapes.geometry(shape)
    if packed is None and service.store.shapes.get(shape) is None:
        raise missing_shape(service, shape)  # it was deleted just now
    if packed is None:
        raise GeometryNotKept(
            "The shape was stored by an earlier version, which kept nothing to look at; delete it"
            " and upload it again."
        )
    return unpacked_if_need_be(packed, "application/octet-stream", accept_encoding, headers)
