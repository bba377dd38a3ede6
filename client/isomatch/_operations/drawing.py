"""Operations that ask for what is drawn; see :mod:`isomatch._http.exchange`."""

import os
from typing import TYPE_CHECKING

from isomatch._errors import UnexpectedResponse
from isomatch._http import Call, Operation, send
from isomatch._models import JobRecord, Shape
from isomatch._operations.resources import id_of, path_to
from isomatch._operations.result import get_result
from isomatch._results import Drawable, Geometry, Prototype, PrototypePoints, is_prototype

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def get_geometry(shape: Shape | str) -> Operation[Geometry]:
    """Ask for the surface of a shape."""
    response = yield from send(Call("GET", path_to("shapes", id_of(shape), "geometry")))
    try:
        return Geometry.from_bytes(response.content)
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url} answered what {error}") from error


def get_points(prototype: Prototype | str) -> Operation[PrototypePoints]:
    """Ask for the archive of a prototype, and read what it knows of its points."""
    response = yield from send(Call("GET", path_to("prototypes", id_of(prototype), "archive")))
    try:
        return PrototypePoints.from_bytes(response.content)
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error


def get_drawable(wanted: str) -> Operation[Drawable]:
    """Ask for what is drawn of a shape or of a prototype."""
    if is_prototype(wanted):
        return (yield from get_points(wanted))
    return (yield from get_geometry(wanted))


def plot_result(
    record: JobRecord, path: str | os.PathLike[str] | None, alternative: int | None
) -> Operation["Figure"]:
    """Ask for the result of a job that has ended, and for what it is about, and draw it."""
    result = yield from get_result(record)
    drawn = []
    for wanted in result.drawn_ids():
        drawn.append((yield from get_drawable(wanted)))  # noqa: PERF401 - yields cannot be in a list
    return result.plot(*drawn, path=path, alternative=alternative)
