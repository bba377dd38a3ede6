"""Operations on shapes, and the list of structures that can be compared."""

from dataclasses import replace

import numpy as np

from isomatch._errors import UnexpectedResponse
from isomatch._http import Call, Operation, delete, parsed, send
from isomatch._models import Page, Shape, Structures
from isomatch._operations.request_parts import path_to
from isomatch._operations.uploads import upload
from isomatch._results import Geometry
from isomatch._upload import MeshSource, mesh_file


def upload_shape(
    source: MeshSource, name: str | None, file_type: str | None, timeout: float | None
) -> Operation[Shape]:
    """Upload a mesh, and wait until the service has read it.

    Raises
    ------
    WaitTimeout
        It was not read within `timeout` seconds.
    """
    answer = yield from upload("/v1/shapes", mesh_file(source, file_type), name, timeout)
    return parsed(Shape, answer)


def get_shape(shape_id: str) -> Operation[Shape]:
    """Request a shape."""
    return parsed(Shape, (yield from send(Call("GET", path_to("shapes", shape_id)))))


def list_shapes(cursor: str | None) -> Operation[Page[Shape]]:
    """Request one page of the shapes."""
    call = Call("GET", "/v1/shapes", query={"cursor": cursor})
    return parsed(Page[Shape], (yield from send(call)))


def delete_shape(shape: Shape | str) -> Operation[None]:
    """Delete a shape."""
    yield from delete(path_to("shapes", shape))


def get_mesh(shape: Shape | str) -> Operation[bytes]:
    """Request the file of a shape."""
    return (yield from send(Call("GET", path_to("shapes", shape, "mesh")))).content


def get_geometry(shape: Shape | str) -> Operation[Geometry]:
    """Request the surface of a shape as arrays, with its view."""
    known = shape if isinstance(shape, Shape) else (yield from get_shape(shape))
    response = yield from send(Call("GET", path_to("shapes", shape, "geometry")))
    try:
        return replace(Geometry.from_bytes(response.content), view=np.array(known.view))
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error


def list_structures() -> Operation[Structures]:
    """Request the metrics and descriptors of the service."""
    return parsed(Structures, (yield from send(Call("GET", "/v1/structures"))))
