"""``/v1/jobs/{id}/map.csv``: maps of all vertices as tables."""

from typing import Annotated, Final

from fastapi import APIRouter, Query, Response
from starlette.concurrency import run_in_threadpool

from broker.contracts import (
    MOST_MAPPED_SHAPES,
    ConsistentMapsPayload,
    FieldProblem,
    JobRecord,
    PicturePayload,
    maps_vertices,
)
from service.dependencies import CallContextOf, Service
from service.http import (
    INVALID,
    InvalidRequest,
    JobWithoutResult,
    attachment,
    binary_file,
)
from service.jobs.download_names import map_stem
from service.jobs.lookup import JobId, job_with_result
from service.jobs.pictures import NEEDED, presented
from service.jobs.results import ERRORS

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

_CSV: Final = "text/csv"
_PLACE: Final = Query(
    ge=0,
    le=MOST_MAPPED_SHAPES - 1,
    description="Place of the shape: 0 for the source of a match and 1 for its target, or that"
    " among the `shapes` of consistent maps.",
)


@router.get(
    "/{job_id}/map.csv",
    response_class=Response,
    responses={200: binary_file("The table", _CSV), **ERRORS, **NEEDED},
    operation_id="get_map",
)
async def get_map(
    job_id: JobId,
    context: CallContextOf,
    source: Annotated[int, _PLACE] = 0,
    target: Annotated[int, _PLACE] = 1,
) -> Response:
    """Return the map of all vertices of one shape to another, of a dense match or consistent maps.

    The table has the columns `source` and `target`: a vertex of the file of the first shape, in
    ascending order, and the vertex of the file of the second that is nearest to its image. Vertices
    that are not mapped are left out. Of a match, `source=1&target=0` is the inverse map.
    """
    await run_in_threadpool(_check_places, context.service, job_id, source, target)
    stem = await run_in_threadpool(map_stem, context.service, job_id, source, target)
    payload = PicturePayload(job=job_id, format="csv", pair=(source, target))
    return await presented(context, payload, _CSV, attachment(stem, "csv"))


def _check_places(service: Service, job_id: str, source: int, target: int) -> None:
    """Refuse places of no shape. What the result has is checked before the table is made."""
    count = _shape_count(job_with_result(service, job_id))
    for name, place in (("source", source), ("target", target)):
        if place >= count:
            _refuse(name, f"there are {count} shapes, counted from 0")
    if source == target:
        _refuse("target", "it is that of `source`; give another shape")


def _shape_count(record: JobRecord) -> int:
    payload = record.payload
    if not maps_vertices(payload):
        raise JobWithoutResult(
            "It has no map of all vertices; ask a match of two shapes for `dense`, or a collection"
            " for consistent maps."
        )
    return len(payload.shapes) if isinstance(payload, ConsistentMapsPayload) else 2


def _refuse(name: str, message: str) -> None:
    raise InvalidRequest(INVALID, (FieldProblem(field=f"query.{name}", message=message),))
