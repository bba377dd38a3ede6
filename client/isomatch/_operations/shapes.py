"""Operations on shapes, and the list of structures that can be compared."""

import time
from typing import Final

import httpx2

from isomatch._errors import UnexpectedResponse, WaitTimeout
from isomatch._http import Call, Operation, Pause, parsed, send
from isomatch._models import Page, Shape, Structures
from isomatch._operations.request_parts import id_of, path_to
from isomatch._results import Geometry
from isomatch._upload import MeshSource, mesh_file

VALIDATION_POLL: Final = 0.5
"""Seconds between requests for the state of an upload that is being read."""


def upload_shape(
    source: MeshSource, name: str | None, file_type: str | None, timeout: float | None
) -> Operation[Shape]:
    """Upload a mesh, and wait until the service has read it.

    Raises
    ------
    WaitTimeout
        It was not read within `timeout` seconds.
    """
    with mesh_file(source, file_type) as file:
        form = {} if name is None else {"name": name}
        response = yield from send(Call("POST", "/v1/shapes", file=file, form=form))
    return parsed(Shape, (yield from read_upload(response, name or file.name, timeout)))


def read_upload(
    response: httpx2.Response, name: str, timeout: float | None
) -> Operation[httpx2.Response]:
    """Wait until the service has read an upload.

    Parameters
    ----------
    response
        Answer to the upload.
    name
        Name of the file.
    timeout
        Seconds to wait; None for no limit.

    Raises
    ------
    WaitTimeout
        It was not read within `timeout` seconds.
    """
    sent = time.monotonic()
    while response.status_code == 202:
        if timeout is not None and time.monotonic() - sent >= timeout:
            raise WaitTimeout(f"reading {name}", timeout)
        yield Pause(VALIDATION_POLL)
        location = response.headers.get("location")
        if location is None:
            raise UnexpectedResponse("the service accepted the upload without naming its location")
        response = yield from send(Call("GET", location))
    return response


def get_shape(shape_id: str) -> Operation[Shape]:
    """Request a shape."""
    return parsed(Shape, (yield from send(Call("GET", path_to("shapes", shape_id)))))


def list_shapes(cursor: str | None) -> Operation[Page[Shape]]:
    """Request one page of the shapes."""
    call = Call("GET", "/v1/shapes", query={"cursor": cursor})
    return parsed(Page[Shape], (yield from send(call)))


def delete_shape(shape: Shape | str) -> Operation[None]:
    """Delete a shape."""
    yield from send(Call("DELETE", path_to("shapes", id_of(shape))))


def get_mesh(shape: Shape | str) -> Operation[bytes]:
    """Request the file of a shape."""
    return (yield from send(Call("GET", path_to("shapes", id_of(shape), "mesh")))).content


def get_geometry(shape: Shape | str) -> Operation[Geometry]:
    """Request the surface of a shape as arrays."""
    response = yield from send(Call("GET", path_to("shapes", id_of(shape), "geometry")))
    try:
        return Geometry.from_bytes(response.content)
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error


def list_structures() -> Operation[Structures]:
    """Request the metrics and descriptors of the service."""
    return parsed(Structures, (yield from send(Call("GET", "/v1/structures"))))
