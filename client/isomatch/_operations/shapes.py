"""Surfaces of shapes."""

from dataclasses import replace

import numpy as np

from isomatch._errors import UnexpectedResponse
from isomatch._http import Call, Operation, fetch, send
from isomatch._models import Shape
from isomatch._operations.request_parts import path_to
from isomatch._results import Geometry


def get_geometry(shape: Shape | str) -> Operation[Geometry]:
    """Request the surface of a shape as arrays, with its view."""
    path = path_to("shapes", shape)
    known = shape if isinstance(shape, Shape) else (yield from fetch(Shape, path))
    response = yield from send(Call("GET", f"{path}/geometry"))
    try:
        return replace(Geometry.from_bytes(response.content), view=np.array(known.view))
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error
