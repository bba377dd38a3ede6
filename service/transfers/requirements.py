"""What a transfer needs: a match with a map of all vertices, its shapes, and what fits them."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final, NoReturn

from broker.contracts import AttributesRecord, FieldProblem, MatchPayload, ShapeRecord
from service.dependencies import Service
from service.http import (
    ApiProblem,
    InvalidRequest,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    ResultExpired,
    ResultNotReady,
    UnknownShape,
)
from service.jobs import packed_result, stored_job
from service.shapes import counted, refuse, use_shapes, vertices_out_of_range
from service.transfers.attributes import use_attributes
from service.transfers.schemas import TransferRequest

_REFUSED: Final = "This cannot be transferred along this match; `errors` says why."

_MATCH: Final = "body.match"


def check_fields(asked: TransferRequest) -> None:
    """Refuse fields that contradict one another.

    Raises
    ------
    InvalidRequest
        Some do.
    """
    wrong = asked.contradictions.items()
    refuse([FieldProblem(field=f"body.{name}", message=text) for name, text in wrong], _REFUSED)


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
        packed_result(service, job_id)
        match = stored_job(service, job_id).payload
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


def check_shapes_of(asked: TransferRequest, carried: ShapeRecord, onto: ShapeRecord) -> None:
    """Refuse landmarks at no vertex, and values of faces for a shape without faces.

    Raises
    ------
    InvalidRequest
        There are such.
    """
    name = "the match's " + asked.direction.partition("_")[0]
    numbers = (
        (f"body.points.{place}", max(point.vertices)) for place, point in enumerate(asked.points)
    )
    refuse(vertices_out_of_range(numbers, carried, name), _REFUSED)
    if asked.on == "faces" and onto.kind == "points":
        message = 'a point cloud has no faces that could take values; give "vertices"'
        refuse([FieldProblem(field="body.on", message=message)], _REFUSED)


def check_attributes(service: Service, attributes: str, shape: ShapeRecord, name: str) -> None:
    """Refuse a file none of whose attributes has a row for every vertex, or every face.

    Raises
    ------
    UnknownAttributes
        There is no such file.
    InvalidRequest
        It does not fit.
    """
    record = use_attributes(service, attributes)
    if shape.file_vertices is None or shape.file_faces is None:
        return
    given = _rows(record)
    if given & {shape.file_vertices, shape.file_faces}:
        return
    message = (
        f"it has {counted(record.rows, 'row')}, but {name} has"
        f" {counted(shape.file_vertices, 'vertex', 'vertices')} and"
        f" {counted(shape.file_faces, 'face')}; give a row for each vertex, or for each face"
    )
    if record.file_type == "csv" and given & {shape.file_vertices - 1, shape.file_faces - 1}:
        first = ", ".join(one.name for one in record.attributes)
        message += f"; the first line, {first[:40]!r}, was taken for the names of the columns"
    refuse([FieldProblem(field="body.attributes", message=message)], _REFUSED)


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
