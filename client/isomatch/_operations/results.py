"""Operations that request results of jobs, their pictures and their figures."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from pydantic import ValidationError

from isomatch._errors import JobCancelled, JobFailed, UnexpectedResponse
from isomatch._http import LONGEST_OUTAGE, Call, Operation, send, unexpected
from isomatch._models import JobRecord, is_prototype_id
from isomatch._operations.outages import job_named
from isomatch._operations.prototypes import get_prototype_points
from isomatch._operations.request_parts import HELD, path_to
from isomatch._operations.result_files import check_folder
from isomatch._operations.shapes import get_geometry
from isomatch._results import (
    ArrayResult,
    Batch,
    ConsistentMaps,
    Dissimilarities,
    Drawable,
    LearnedPrototype,
    Match,
    Registration,
    Result,
    Transfer,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


View: TypeAlias = Literal["front", "back", "left", "right", "top", "bottom"]
"""Side from which shapes are drawn."""

ENDINGS: Final = ("json", "npz", "csv", "ply", "obj", "glb", "zip", "png")
"""Formats of results."""

_RESULTS: Final[Mapping[str, type[Result]]] = {
    "match": Match,
    "batch": Batch,
    "dissimilarities": Dissimilarities,
    "prototype": LearnedPrototype,
    "transfer": Transfer,
    "registration": Registration,
    "consistent_maps": ConsistentMaps,
}


def get_result(record: JobRecord) -> Operation[Result]:
    """Request the result of a job that has ended, with its arrays if it has any.

    Raises
    ------
    JobFailed, JobCancelled, UnexpectedResponse
        As for :func:`get_document`.
    """
    found = yield from get_document(record)
    if isinstance(found, ArrayResult):
        with job_named(record.id, "has succeeded"):
            found._archive = yield from get_file(record.id, "result.npz", outage=LONGEST_OUTAGE)
    return found


def get_document(record: JobRecord) -> Operation[Result]:
    """Request the result of a job that has ended, without its arrays.

    Raises
    ------
    JobFailed, JobCancelled
        It ended without a result.
    UnexpectedResponse
        Results of its kind are unknown.
    """
    check_succeeded(record)
    call = Call("GET", path_to("jobs", record.id, "result"), outage=LONGEST_OUTAGE)
    with job_named(record.id, "has succeeded"):
        response = yield from send(call)
    kind = _RESULTS.get(record.kind)
    if kind is None:
        raise UnexpectedResponse(
            f"job {record.id} is of the kind {record.kind!r}, which this version of the package"
            " isomatch does not know; install a newer one"
        )
    try:
        return kind.from_json(response.content)
    except ValidationError as error:
        raise unexpected(response, error) from error


def check_succeeded(record: JobRecord) -> None:
    """Refuse a job that has ended without a result.

    Raises
    ------
    JobFailed, JobCancelled
        It failed, or was cancelled.
    """
    if record.state == "failed":
        raise JobFailed(record.id, record.error)
    if record.state == "cancelled":
        raise JobCancelled(record.id)


def get_file(
    job_id: str,
    name: str,
    query: Mapping[str, str | int | None] | None = None,
    outage: float = 0.0,
) -> Operation[bytes]:
    """Request a file of a job's result, which the service may make first.

    The service may be away for `outage` seconds.
    """
    path = path_to("jobs", job_id, name)
    call = Call("GET", path, query=query or {}, patience=HELD, outage=outage)
    return (yield from send(call)).content


def get_picture(
    job_id: str, alternative: int | None = None, view: View | None = None
) -> Operation[bytes]:
    """Request the picture of a job's result, or of one of its alternatives."""
    query = {"alternative": alternative, "view": view}
    return (yield from get_file(job_id, "result.png", query))


def save_picture(
    job_id: str,
    path: str | os.PathLike[str],
    alternative: int | None = None,
    view: View | None = None,
) -> Operation[None]:
    """Request the picture of a job's result, and write it to a file."""
    _ending_of(path, ("png",))
    check_folder(path)
    Path(path).write_bytes((yield from get_picture(job_id, alternative, view)))


def save_arrays(job_id: str, path: str | os.PathLike[str]) -> Operation[None]:
    """Request a job's result as arrays, and write them to a file."""
    _ending_of(path, ("npz",))
    check_folder(path)
    Path(path).write_bytes((yield from get_file(job_id, "result.npz")))


def save(record: JobRecord, path: str | os.PathLike[str]) -> Operation[None]:
    """Request a job's result in the format that a file's name ends in, and write it to the file."""
    ending = _ending_of(path, ENDINGS)
    check_folder(path)
    check_succeeded(record)
    if ending == "json":
        content = (yield from get_document(record)).to_json()
    else:
        content = yield from get_file(record.id, f"result.{ending}")
    Path(path).write_bytes(content)


def _ending_of(path: str | os.PathLike[str], endings: Sequence[str]) -> str:
    """The ending of a file's name; the first of several if it has none."""
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in ("", *endings):
        raise ValueError(f"{ending!r} is none of {', '.join(endings)}")
    return ending or endings[0]


def get_drawable(drawn_id: str) -> Operation[Drawable]:
    """Request the surface of a shape, or the points of a prototype."""
    if is_prototype_id(drawn_id):
        return (yield from get_prototype_points(drawn_id))
    return (yield from get_geometry(drawn_id))


def plot_result(record: JobRecord, alternative: int | None) -> Operation["Figure"]:
    """Request the result of a job that has ended and the shapes it names, and draw them."""
    result = yield from get_result(record)
    drawn = []
    for drawn_id in result.drawn_ids():
        drawn.append((yield from get_drawable(drawn_id)))  # noqa: PERF401 - yields in no list
    return result.plot(*drawn, alternative=alternative)
