"""``/v1/transfers``."""

from typing import Final

from fastapi import APIRouter, Response

from broker.contracts import (
    AttributesRecord,
    FieldProblem,
    JobRecord,
    MatchPayload,
    RequestOrigin,
    ShapeRecord,
    TransferPayload,
)
from broker.queue import new_job
from service.dependencies import Service, ServiceOf
from service.http import (
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    ResultExpired,
    ResultNotReady,
    UnknownAttributes,
)
from service.jobs import Job, JobOrder, answers, packed_result, requested_job
from service.shapes import refuse, use_shapes, vertices_out_of_range
from service.transfers.attributes import use_attributes
from service.transfers.schemas import TransferRequest

_REFUSED: Final = "This cannot be carried along this match; `errors` says why."

router = APIRouter(prefix="/v1/transfers", tags=["transfers"])


@router.post(
    "",
    status_code=202,
    responses=answers(
        UnknownAttributes, JobNotFound, JobExpired, JobWithoutResult, ResultNotReady, ResultExpired
    ),
    operation_id="create_transfer",
)
def create_transfer(
    asked: TransferRequest, service: ServiceOf, order: JobOrder, response: Response
) -> Job:
    """Carry attributes of the vertices or faces of one shape of a match to the other, or landmarks.

    The match is one with `dense`. Every vertex takes the value at the point of the other shape that
    it corresponds to, so none is left without; faces take what most of their area corresponds to,
    or its mean. The values are `result.npz` of the job, and
    `result.csv`, `.ply`, `.obj` and `.glb`.
    """

    def submit(order: RequestOrigin) -> JobRecord:
        return service.queue.submit(new_job(_payload(asked, service), order), order.idempotency)

    return requested_job(service, asked, order, response, submit)


def _payload(asked: TransferRequest, service: Service) -> TransferPayload:
    wrong = [
        FieldProblem(field=f"body.{name}", message=message)
        for name, message in asked.contradictions.items()
    ]
    refuse(wrong, _REFUSED)
    packed_result(service, asked.match)
    record = service.store.jobs.get(asked.match)
    match = None if record is None else record.payload
    if not isinstance(match, MatchPayload):
        message = "it is the job of no match; give that of a match with `dense`"
        refuse([FieldProblem(field="body.match", message=message)], _REFUSED)
    assert isinstance(match, MatchPayload)
    if not match.parameters.dense:
        message = "it has no map of all vertices; match again with `dense`"
        refuse([FieldProblem(field="body.match", message=message)], _REFUSED)
    ends = match.source, match.target
    source, target = ends if asked.direction == "source_to_target" else ends[::-1]
    shapes = use_shapes(service, {"body.match": source, "body.match.target": target})
    refuse(_points_out_of_range(asked, shapes["body.match"]), _REFUSED)
    refuse(_faces_of_points(asked, shapes["body.match.target"]), _REFUSED)
    if asked.attributes is not None:
        shape = shapes["body.match"]
        name = match.source_name if source == match.source else match.target_name
        _check_rows(use_attributes(service, asked.attributes), shape, name or shape.name)
    return TransferPayload(
        match=asked.match,
        source=source,
        target=target,
        attributes=asked.attributes,
        what=asked.what,
        direction=asked.direction,
        on=asked.on,
        names=asked.names,
        influences=asked.influences,
        points=asked.points,
    )


def _points_out_of_range(asked: TransferRequest, shape: ShapeRecord) -> list[FieldProblem]:
    name = "the match's " + asked.direction.partition("_")[0]
    numbers = (
        (f"body.points.{place}", max(point.vertices)) for place, point in enumerate(asked.points)
    )
    return vertices_out_of_range(numbers, shape, name)


def _faces_of_points(asked: TransferRequest, onto: ShapeRecord) -> list[FieldProblem]:
    if asked.on != "faces" or onto.kind != "points":
        return []
    message = 'a point cloud has no faces that could take values; give "vertices"'
    return [FieldProblem(field="body.on", message=message)]


def _check_rows(attributes: AttributesRecord, shape: ShapeRecord, name: str) -> None:
    """Refuse a file none of whose attributes has a row for every vertex, or every face."""
    if shape.file_vertices is None or shape.file_faces is None:
        return
    given = {attributes.rows, *(one.rows or 0 for one in attributes.attributes)}
    if any(shape.vertices <= rows <= shape.file_vertices for rows in given):
        return
    if shape.file_faces in given:
        return
    message = (
        f"it has {attributes.rows:,} rows, but {name} has {shape.file_vertices:,} vertices and"
        f" {shape.file_faces:,} faces; give a row for each vertex, or for each face"
    )
    if attributes.file_type == "csv" and given & {shape.file_vertices - 1, shape.file_faces - 1}:
        first = ", ".join(one.name for one in attributes.attributes)
        message += f"; the first line, {first[:40]!r}, was taken for the names of the columns"
    refuse([FieldProblem(field="body.attributes", message=message)], _REFUSED)
