"""Operations on shapes, and what can be compared of them; see :mod:`isomatch._http.exchange`."""

import time
from typing import Final

import httpx2

from isomatch._errors import UnexpectedResponse, WaitTimeout
from isomatch._http import Call, Operation, Pause, parsed, send
from isomatch._models import Page, Shape, Structures
from isomatch._operations.request_parts import id_of, path_to
from isomatch._results import Geometry
from isomatch._upload import MeshSource, mesh_file

VALIDATION_PAUSE: Final = 0.5


def upload(
    source: MeshSource, name: str | None, file_type: str | None, timeout: float | None
) -> Operation[Shape]:
    """Upload a mesh, and wait until the service has read it.

    Raises
    ------
    WaitTimeout
        It was not read within `timeout` seconds of being sent.
    """
    with mesh_file(source, file_type) as file:
        form = {} if name is None else {"name": name}
        response = yield from send(Call("POST", "/v1/shapes", file=file, form=form))
    return parsed(Shape, (yield from until_read(response, name or file.name, timeout)))


def until_read(
    response: httpx2.Response, what: str, timeout: float | None
) -> Operation[httpx2.Response]:
    """Wait until the service has read an upload.

    Parameters
    ----------
    response
        What it answered at first.
    what
        What was uploaded.
    timeout
        Seconds it may take; None for no limit.

    Raises
    ------
    WaitTimeout
        It took longer.
    """
    sent = time.monotonic()
    while response.status_code == 202:
        if timeout is not None and time.monotonic() - sent >= timeout:
            raise WaitTimeout(f"reading {what}", timeout)
        yield Pause(VALIDATION_PAUSE)
        location = response.headers.get("location")
        if location is None:
            raise UnexpectedResponse("the service accepted the upload and does not say as what")
        response = yield from send(Call("GET", location))
    return response


def get_shape(shape_id: str) -> Operation[Shape]:
    """Ask for one shape."""
    return parsed(Shape, (yield from send(Call("GET", path_to("shapes", shape_id)))))


def list_shapes(cursor: str | None) -> Operation[Page[Shape]]:
    """Ask for one page of the shapes."""
    call = Call("GET", "/v1/shapes", query={"cursor": cursor})
    return parsed(Page[Shape], (yield from send(call)))


def delete_shape(shape: Shape | str) -> Operation[None]:
    """Delete a shape."""
    yield from send(Call("DELETE", path_to("shapes", id_of(shape))))


def get_mesh(shape: Shape | str) -> Operation[bytes]:
    """Ask for the file of a shape."""
    response = yield from send(Call("GET", path_to("shapes", id_of(shape), "mesh")))
    return response.content


def get_geometry(shape: Shape | str) -> Operation[Geometry]:
    """Request the surface of a shape as arrays."""
    response = yield from send(Call("GET", path_to("shapes", id_of(shape), "geometry")))
    try:
        return Geometry.from_bytes(response.content)
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error


def list_structures() -> Operation[Structures]:
    """Ask what can be compared of shapes."""
    return parsed(Structures, (yield from send(Call("GET", "/v1/structures"))))
