"""What a transfer needs: a match with a map of all vertices, its shapes, and what fits them."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final, NoReturn

from broker.contracts import (
    ATTRIBUTE_FORMATS,
    LANDMARKS,
    TEXTURE,
    UV,
    AttributesRecord,
    FieldProblem,
    MatchPayload,
    ShapeRecord,
)
from service.dependencies import Service
from service.http import (
    MOST_FIELDS,
    ApiProblem,
    InvalidRequest,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    ResultExpired,
    ResultNotReady,
    UnknownShape,
)
from service.jobs import check_kept, job_with_result
from service.shapes import counted, refuse, use_shapes, vertices_out_of_range
from service.transfers.attributes import use_attributes
from service.transfers.schemas import TransferRequest

_REFUSED: Final = "This cannot be transferred along this match; `errors` says why."

_MATCH: Final = "body.match"


def usable_match(service: Service, job_id: str) -> MatchPayload:
    """Return a match that has ended with a map of all vertices.

    Raises
    ------
    InvalidRequest
        There is no such match.
    JobWithoutResult, ResultNotReady, ResultExpired
        It has no result (yet, or any more).
    """
    with _of_match():
        record = job_with_result(service, job_id)
        check_kept(service, record)
    match = record.payload
    if not isinstance(match, MatchPayload):
        _refuse_match("it is the job of no match; give that of a match with `dense`")
    if not match.parameters.dense:
        _refuse_match("it has no map of all vertices; match again with `dense`")
    return match


def use_ends(service: Service, source: str, target: str) -> tuple[ShapeRecord, ShapeRecord]:
    """Return the shapes of a match that values are carried from, and to; see :func:`use_shapes`.

    Raises
    ------
    UnknownShape
        One was deleted, or has expired.
    """
    try:
        shapes = use_shapes(service, {"source": source, "target": target})
    except UnknownShape as error:
        # The request names the match alone.
        messages = dict.fromkeys(problem.message for problem in error.errors)
        fields = tuple(map(_problem, messages))
        raise UnknownShape("A shape of the match is gone; `errors` names it.", fields) from error
    return shapes["source"], shapes["target"]


def check_carried(
    service: Service, asked: TransferRequest, carried: ShapeRecord, onto: ShapeRecord, name: str
) -> None:
    """Refuse what the records of the shapes and of the attribute file show not to fit.

    Whether a file has values of the kind that is asked for is known to the job alone.

    Parameters
    ----------
    service
        The service that keeps them.
    asked
        The request.
    carried, onto
        The shapes that values are carried from, and to.
    name
        Name of `carried` in the messages.

    Raises
    ------
    UnknownAttributes
        There is no such file.
    InvalidRequest
        A landmark is at no vertex, values of faces are for a shape without faces, or attributes
        are not there or do not fit.
    """
    wrong = _of_shapes(asked, carried, onto)
    if asked.attributes is not None:
        record = use_attributes(service, asked.attributes)
        wrong += _unknown_names(asked, record) + _misfit(record, carried, name)
    elif asked.what not in (LANDMARKS, TEXTURE, UV):
        wrong += _without_own(asked, carried)
    refuse(wrong, _REFUSED)


def _of_shapes(
    asked: TransferRequest, carried: ShapeRecord, onto: ShapeRecord
) -> list[FieldProblem]:
    name = "the match's " + asked.direction.partition("_")[0]
    numbers = (
        (f"body.points.{place}", max(point.vertices))
        for place, point in enumerate(asked.surface_points)
    )
    wrong = vertices_out_of_range(numbers, carried, name)
    if asked.on == "faces" and onto.kind == "points":
        message = 'a point cloud has no faces that could take values; give "vertices"'
        wrong.append(FieldProblem(field="body.on", message=message))
    return wrong


def _without_own(asked: TransferRequest, carried: ShapeRecord) -> list[FieldProblem]:
    """Problem of a shape whose own file has no attributes of a kind."""
    if asked.what == "colors":
        missing = "" if carried.has_colors else "the shape has no colours"
    else:
        # Archives may have any file.
        readable = (*ATTRIBUTE_FORMATS, "zip")
        missing = "" if carried.file_type in readable else f"{carried.file_type} files have none"
    message = f"{missing}; upload a file of attributes"
    return [FieldProblem(field="body.attributes", message=message)] if missing else []


def _unknown_names(asked: TransferRequest, record: AttributesRecord) -> list[FieldProblem]:
    known = {one.name for one in record.attributes}
    # Joints are columns of skinning weights.
    joints = {column for one in record.attributes for column in one.columns}
    there = ", ".join(sorted(known)[:MOST_FIELDS])
    return [
        FieldProblem(
            field=f"body.names.{place}",
            message=f"{name[:40]!r} is not in the file, which has {there}",
        )
        for place, name in enumerate(asked.names)
        if name not in known | joints
    ]


def _misfit(record: AttributesRecord, shape: ShapeRecord, name: str) -> list[FieldProblem]:
    """Problem of a file none of whose attributes has a row for every vertex, or every face."""
    if shape.file_vertices is None or shape.file_faces is None:
        return []
    given = _rows(record)
    if given & {shape.file_vertices, shape.file_faces}:
        return []
    message = (
        f"it has {counted(record.rows, 'row')}, but {name} has"
        f" {counted(shape.file_vertices, 'vertex', 'vertices')} and"
        f" {counted(shape.file_faces, 'face')}; give a row for each vertex, or for each face"
    )
    if record.file_type == "csv" and given & {shape.file_vertices - 1, shape.file_faces - 1}:
        first = ", ".join(one.name for one in record.attributes)
        message += f"; the first line, {first[:40]!r}, was taken for the names of the columns"
    return [FieldProblem(field="body.attributes", message=message)]


def _rows(attributes: AttributesRecord) -> set[int]:
    return {attributes.rows, *(one.rows or 0 for one in attributes.attributes)}


@contextmanager
def _of_match() -> Iterator[None]:
    """Name the field of the match in problems of its job."""
    try:
        yield
    except (JobNotFound, JobExpired) as error:
        _refuse_match(error.detail, error)
    except (JobWithoutResult, ResultNotReady, ResultExpired) as error:
        raise type(error)(error.detail, (_problem(error.detail),)) from error


def _refuse_match(message: str, cause: ApiProblem | None = None) -> NoReturn:
    raise InvalidRequest(_REFUSED, (_problem(message),)) from cause


def _problem(message: str) -> FieldProblem:
    return FieldProblem(field=_MATCH, message=message)
