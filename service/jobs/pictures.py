"""``/v1/jobs/{id}/result.png`` and other formats, which a worker makes when they are asked for."""

import gzip
import json
from typing import Annotated, Any, BinaryIO, Final, Literal, TypeAlias

from fastapi import APIRouter, Header, Path, Query, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from broker.blobs import BlobLost
from broker.contracts import (
    MOST_SPECIMENS,
    TEXTURE,
    UV,
    ConsistentMapsPayload,
    FieldProblem,
    JobKind,
    JobRecord,
    MatchPayload,
    PicturePayload,
    RegistrationPayload,
    TransferPayload,
    View,
    export_refusal,
    exports_of,
    is_prototype,
)
from broker.telemetry import logger
from service.dependencies import CallContext, CallContextOf, Service
from service.http import (
    INVALID,
    ContentLost,
    InvalidRequest,
    JobExpired,
    JobWithoutResult,
    PictureNotReady,
    PrototypeDeleted,
    QuotaUsedUp,
    Reported,
    ResultExpired,
    ShapeDeleted,
    StorageFull,
    attachment,
    binary_file,
    body_wanted,
    file_response,
    responses,
)
from service.jobs.download_names import registered_stem, result_stem
from service.jobs.lookup import JobId, check_kept, job_with_result, open_result
from service.jobs.results import BYTES, ERRORS

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])
log = logger("isomatch.api")

NEEDED: Final = responses(
    ResultExpired,
    ContentLost,
    JobExpired,
    ShapeDeleted,
    PrototypeDeleted,
    PictureNotReady,
    StorageFull,
    QuotaUsedUp,
)

Alternative = Annotated[
    int | None,
    Query(
        ge=0,
        le=32,
        description="The answer of a match to draw: 0 for the match itself, j for the j-th of its"
        " `alternatives`; a refinement or dense map is drawn only if it belongs to that answer.",
    ),
]

SeenFrom = Annotated[
    View, Query(description="Side of a match's source from which both shapes are seen.")
]
Export: TypeAlias = Literal["csv", "ply", "obj", "glb", "zip"]

SurfaceFormat: TypeAlias = Literal["ply", "obj", "glb"]
Specimen = Annotated[
    int,
    Query(
        ge=0,
        le=MOST_SPECIMENS - 1,
        description="Place of the specimen among the `shapes` of a registration; 0 for a match.",
    ),
]

_PICTURE: Final = "image/png"
_MEDIA_TYPES: Final[dict[Export, str]] = {
    "csv": "text/csv",
    "ply": "model/ply",
    "obj": "model/obj",
    "glb": "model/gltf-binary",
    "zip": "application/zip",
}
_SURFACE_TYPES: Final[dict[SurfaceFormat, str]] = {
    "ply": _MEDIA_TYPES["ply"],
    "obj": _MEDIA_TYPES["obj"],
    "glb": _MEDIA_TYPES["glb"],
}


@router.get(
    "/{job_id}/result.png",
    response_class=Response,
    responses={
        200: binary_file("The picture", _PICTURE, BYTES),
        **ERRORS,
        **NEEDED,
    },
    operation_id="get_picture",
)
async def get_picture(
    job_id: JobId,
    context: CallContextOf,
    alternative: Alternative = None,
    view: SeenFrom = "front",
    accept: Annotated[str, Header(include_in_schema=False)] = "",
) -> Response:
    """Draw the result of a job as PNG.

    For a match or one of its alternatives: both shapes, with corresponding points in the same
    colour. For dissimilarities: a heat map, in the order of the labels. For a registration: the
    mean shape, and it moved along its first three components. Clients that accept
    only `application/octet-stream` get the same file with that type.
    """
    payload = PicturePayload(job=job_id, alternative=alternative, view=view)
    media_type, headers = BYTES if _only_bytes(accept) else _PICTURE, {"Vary": "Accept"}
    return await presented(context, payload, media_type, headers)


@router.get(
    "/{job_id}/result.{format}",
    response_class=Response,
    responses={200: binary_file("The file", *_MEDIA_TYPES.values()), **ERRORS, **NEEDED},
    operation_id="get_export",
)
async def get_export(
    job_id: JobId,
    # The name in the path is that of a built-in.
    format: Annotated[Export, Path(description="Format of the file.")],  # noqa: A002
    context: CallContextOf,
) -> Response:
    """Return the result of a job in another format.

    Of a match, `csv` has the pairs; `ply` and `obj` have the target in the colours of the source,
    and `glb` both surfaces, if it is `dense`. Of dissimilarities, `csv` has the matrix. Of a
    transfer, `csv` has the values, and `ply`, `obj` and `glb` the shape with them. Row i is vertex
    i of the shape's file. Of a registration, `ply`, `obj` and `glb` have the mean shape.
    """
    headers = attachment(await run_in_threadpool(result_stem, context.service, job_id), format)
    payload = PicturePayload(job=job_id, format=format)
    return await presented(context, payload, _MEDIA_TYPES[format], headers)


@router.get(
    "/{job_id}/registered.{format}",
    response_class=Response,
    responses={200: binary_file("The file", *_SURFACE_TYPES.values(), BYTES), **ERRORS, **NEEDED},
    operation_id="get_registered_template",
)
async def get_registered_template(
    job_id: JobId,
    # The name in the path is that of a built-in.
    format: Annotated[SurfaceFormat, Path(description="Format of the file.")],  # noqa: A002
    context: CallContextOf,
    specimen: Specimen = 0,
    accept: Annotated[str, Header(include_in_schema=False)] = "",
) -> Response:
    """Return a registered template: the source's vertices and triangles on the target's surface.

    Of a match, it is the source on the target, if it is `dense`; of a registration, the template on
    one of the specimens, in the coordinates of that specimen. Vertex i is vertex i of the source's
    or the template's file. Clients that accept only `application/octet-stream` get the same file
    with that type.
    """
    stem = await run_in_threadpool(registered_stem, context.service, job_id, specimen)
    headers = {**attachment(stem, format), "Vary": "Accept"}
    media_type = BYTES if _only_bytes(accept) else _SURFACE_TYPES[format]
    payload = PicturePayload(job=job_id, format=format, specimen=specimen)
    return await presented(context, payload, media_type, headers)


def _only_bytes(accept: str) -> bool:
    return accept.partition(";")[0].strip() == BYTES


async def presented(
    context: CallContext, payload: PicturePayload, media_type: str, headers: dict[str, str]
) -> Response:
    """Return the stored picture or file of a result, or have a worker make it.

    Parameters
    ----------
    context
        The request.
    payload
        What is asked for.
    media_type, headers
        Of the answer.

    Raises
    ------
    JobNotFound, JobExpired, JobWithoutResult, ResultNotReady, ResultExpired
        There is no such result, or nothing of it to make.
    PictureNotReady
        It takes longer than a request waits.
    Reported
        The worker could not make it.
    """
    service, request = context.service, context.request
    picture = await run_in_threadpool(_made, service, payload)
    if picture is None:
        await run_in_threadpool(_check, service, payload)
        # Whether there is such an alternative, the worker finds.
        if not (body_wanted(request) or payload.alternative):
            return StreamingResponse(iter(()), media_type=media_type, headers=headers)
        submit = service.queue.submit_picture
        drawing = await run_in_threadpool(submit, payload, context.origin)
        record = await service.wait_for(drawing, service.settings.picture_wait, request)
        picture = await run_in_threadpool(service.store.results.open_picture, payload)
        if picture is None:
            await run_in_threadpool(_check_kept, service, payload)
            if record is not None and record.error is not None:
                raise Reported(record.error)
            raise PictureNotReady("It is still being made; ask again.")
    return file_response(picture, media_type, headers)


def _made(service: Service, payload: PicturePayload) -> BinaryIO | None:
    """Return the file that was made before; one that is lost can be made again."""
    try:
        return service.store.results.open_picture(payload)
    except BlobLost as error:
        log.warning("a picture is made again", error=str(error))
        return None


def _check_kept(service: Service, payload: PicturePayload) -> None:
    """Refuse what is of a result that was deleted or has expired, maybe while it was made."""
    check_kept(service, job_with_result(service, payload.job))


def _check(service: Service, payload: PicturePayload) -> None:
    """Refuse what cannot be made, before a worker is asked; matches, which may be large, unread."""
    if service.queue.is_drawn(payload):
        return  # it was checked before
    record = job_with_result(service, payload.job)
    if payload.format == "npz":
        _check_carried(record)
    elif payload.pair is None:
        if record.kind is not JobKind.MATCH:
            _refuse_options_of_matches(payload)
        has_picture = ("png",) * record.kind.has_picture
        if payload.format not in (has_picture if payload.format == "png" else record.kind.exports):
            raise JobWithoutResult(_without(record, payload.format))
    check_kept(service, record)
    if payload.format == "npz":
        return
    if payload.pair is not None:
        _check_mapped(service, record, payload.pair)
        return
    if payload.specimen is not None:
        _check_registered(service, record, payload.specimen)
    elif payload.format != "png" and (refusal := export_refusal(record.payload, payload.format)):
        raise JobWithoutResult(f"{refusal}.")
    # A table of vertices names shapes, and shows none.
    if isinstance(record.payload, MatchPayload) and payload.format != "csv":
        _check_match(service, record.payload)


def _check_mapped(service: Service, record: JobRecord, pair: tuple[int, int]) -> None:
    """Refuse the map of two shapes of a collection that do not fit."""
    if not isinstance(record.payload, ConsistentMapsPayload):
        return
    count, (first, second) = len(record.payload.shapes), sorted(pair)
    # The pairs (0, 1), (0, 2), ..., (1, 2), ...
    place = first * (2 * count - first - 1) // 2 + second - first - 1
    found = _document(service, record)["pairs"][place]
    if not found["mapped"]:
        raise JobWithoutResult(f"These shapes were not mapped: {found['reason']}.")


def _document(service: Service, record: JobRecord) -> Any:
    with open_result(service, record.id) as packed:
        return json.loads(gzip.decompress(packed.read()))


def _without(record: JobRecord, file_type: str) -> str:
    """Say that a job has no file of a type, and which it has."""
    kind = record.kind
    what = "picture" if file_type == "png" else f"{file_type.upper()} file"
    others = [*exports_of(record.payload), *["npz"] * kind.has_arrays, *["png"] * kind.has_picture]
    there = "".join(f", result.{one}" for one in others)
    return f"A job of kind {kind.value!r} has no {what}; it has `result`, which is JSON{there}."


def _check_carried(record: JobRecord) -> None:
    """Refuse the source's values of what is no transfer of values or landmarks."""
    if not isinstance(record.payload, TransferPayload):
        raise JobWithoutResult(f"A job of kind {record.kind.value!r} carries no values.")
    if record.payload.what in (TEXTURE, UV):
        raise JobWithoutResult(f"The source's own file has its {record.payload.what}.")


def _refuse_options_of_matches(payload: PicturePayload) -> None:
    default = PicturePayload(job=payload.job)
    # 0 is no alternative, and draws what is drawn without it.
    given = {"alternative": payload.alternative or None, "view": payload.view}
    for name, value in given.items():
        if value != getattr(default, name):
            message = f"`{name}` is only supported for matches; leave it out"
            field = FieldProblem(field=f"query.{name}", message=message)
            raise InvalidRequest(INVALID, (field,))


def _check_registered(service: Service, record: JobRecord, specimen: int) -> None:
    """Refuse a registered template that there is not."""
    asked = record.payload
    count = len(asked.shapes) if isinstance(asked, RegistrationPayload) else 1
    if specimen >= count:
        message = f"specimens are counted from 0 to {count - 1}; ask for one of them"
        raise InvalidRequest(INVALID, (FieldProblem(field="query.specimen", message=message),))
    if isinstance(asked, MatchPayload):
        if not asked.parameters.dense or is_prototype(asked.source):
            message = "It has no map of all vertices between two shapes; match again with `dense`."
            raise JobWithoutResult(message)
    elif isinstance(asked, RegistrationPayload):
        report = _document(service, record)["specimens"][specimen]
        if not report["registered"]:
            raise JobWithoutResult(f"Specimen {specimen} was not registered: {report['reason']}")
    else:
        raise JobWithoutResult(f"A job of kind {record.kind.value!r} registers no template.")


def _check_match(service: Service, match: MatchPayload) -> None:
    shapes = [match.source, match.target]
    if is_prototype(match.source):
        shapes = [match.target]
        if service.store.prototypes.get(match.source) is None:
            raise PrototypeDeleted(_gone(f"Prototype {match.source}"))
    for shape in shapes:
        if service.store.shapes.get(shape) is None:
            raise ShapeDeleted(_gone(f"Shape {shape}"))


def _gone(what: str) -> str:
    return f"{what}, which it shows, was deleted or has expired."
