"""``/v1/prototypes``."""

from collections.abc import Mapping
from typing import Annotated, Final

from fastapi import APIRouter, Path, Query, Response

from broker.contracts import FieldProblem, PrototypePayload, ShapeRecord
from service.http import (
    ApiProblem,
    Cursor,
    InvalidRequest,
    Limit,
    PrototypeExpired,
    PrototypeNotFound,
    UnusablePrototype,
    page_of,
    responses,
)
from service.job_schema import Job
from service.names import LONGEST
from service.orders import JobOrder, accepted, answers, told_to, use_shapes
from service.prototypes.archives import PROTOTYPES, VALIDATING_PROTOTYPE, still_validating
from service.prototypes.schemas import DEFAULT_NAME, Prototype, PrototypePage, PrototypeRequest
from service.state import Service, ServiceOf
from service.suitability import check_shapes, named, refuse, repeated, too_few_vertices
from service.uploads import reader

router = APIRouter(prefix=PROTOTYPES, tags=["prototypes"])

PrototypeId = Annotated[
    str, Path(description="Id of the prototype.", pattern=r"^[0-9a-zA-Z_-]{1,64}$")
]

_REFUSED: Final = "No prototype can be learned from this; `errors` says why."


@router.post(
    "",
    status_code=202,
    responses=answers(),
    operation_id="create_prototype",
)
def create_prototype(
    asked: PrototypeRequest, service: ServiceOf, order: JobOrder, response: Response
) -> Job:
    """Learn a prototype: how far points of a class of shapes are from one another, and what near.

    The job's result names it. The spectra of the examples are computed by all workers.
    """
    record = service.queue.earlier_job(order)
    if record is None:
        order = told_to(service, asked, order)
        record = service.queue.submit_with_spectra(_payload(asked, service), order)
    return accepted(record, service, response)


@router.get("", responses=responses(InvalidRequest), operation_id="list_prototypes")
def list_prototypes(
    service: ServiceOf,
    limit: Limit = 50,
    cursor: Cursor = None,
    name: Annotated[
        str | None,
        Query(min_length=1, max_length=LONGEST, description="Only the versions of this name."),
    ] = None,
) -> PrototypePage:
    """List the prototypes, all versions of all names, the newest first."""
    page = page_of(lambda: service.store.prototypes.page(limit, cursor, name))
    items = tuple(Prototype.model_construct(**dict(record)) for record in page.items)
    return PrototypePage(items=items, next_cursor=page.next_cursor)


@router.get(
    "/{prototype}",
    response_model=Prototype,
    responses={
        202: VALIDATING_PROTOTYPE,
        **responses(PrototypeNotFound, PrototypeExpired, UnusablePrototype, InvalidRequest),
    },
    operation_id="get_prototype",
)
def get_prototype(prototype: PrototypeId, service: ServiceOf) -> Response:
    """Show a prototype."""
    record = service.store.prototypes.get(prototype)
    if record is not None:
        return Response(record.model_dump_json(), media_type="application/json")
    job = reader(service, service.store.uploads.deferred(prototype))
    if job is not None:
        return still_validating(service, job)
    raise _missing(service, prototype)


@router.delete(
    "/{prototype}",
    status_code=204,
    responses=responses(PrototypeNotFound, InvalidRequest),
    operation_id="delete_prototype",
)
def delete_prototype(prototype: PrototypeId, service: ServiceOf) -> None:
    """Delete a prototype; matches with it that have not begun will fail and say so.

    Other versions of its name stay as they are, and its number is not given again.
    """
    if not service.store.prototypes.delete(prototype):
        raise PrototypeNotFound(f"There is no prototype {prototype}.")
    service.store.spectra.drop(prototype)


@router.get(
    "/{prototype}/archive",
    response_class=Response,
    responses={
        200: {
            "description": "The archive",
            "content": {
                "application/octet-stream": {"schema": {"type": "string", "format": "binary"}}
            },
        },
        **responses(PrototypeNotFound, PrototypeExpired, InvalidRequest),
    },
    operation_id="get_archive",
)
def get_archive(prototype: PrototypeId, service: ServiceOf) -> Response:
    """Return a prototype as a file of NumPy arrays, which needs no pickle to be read.

    Uploaded again, here or elsewhere, it is the same prototype with the same id.
    """
    data = service.store.prototypes.archive(prototype)
    if data is None:
        raise _missing(service, prototype)
    headers = {"Content-Disposition": f'attachment; filename="{prototype}.npz"'}
    return Response(data, media_type="application/octet-stream", headers=headers)


def _missing(service: Service, prototype: str) -> ApiProblem:
    if service.store.prototypes.expired(prototype):
        return PrototypeExpired(
            "The prototype was not used for long and is no longer kept; learn it or upload it"
            " again."
        )
    return PrototypeNotFound(f"There is no prototype {prototype}.")


def _payload(asked: PrototypeRequest, service: Service) -> PrototypePayload:
    refuse(repeated(asked.shapes), _REFUSED)
    refuse(_impossible(asked), _REFUSED)
    shapes = use_shapes(service, named(asked.shapes))
    few = [] if asked.correspondences else too_few_vertices(shapes, asked.points, "are taken")
    check_shapes(asked, shapes, _REFUSED, few + _not_alike(asked, shapes))
    return PrototypePayload(
        shapes=asked.shapes,
        reference=0 if asked.reference is None else asked.shapes.index(asked.reference),
        correspondences=asked.correspondences,
        name=asked.name.strip() or DEFAULT_NAME,
        parameters=asked.parameters(),
    )


def _impossible(asked: PrototypeRequest) -> list[FieldProblem]:
    several = isinstance(asked.descriptor, tuple)
    wrong = [
        FieldProblem(
            field=f"body.descriptor.{place}" if several else "body.descriptor",
            message="eigenfunctions of several shapes have no common signs; choose another one",
        )
        for place, choice in enumerate(asked.descriptors)
        if choice.name == "eigenfunctions"
    ]
    if asked.simplify is not None and (
        asked.correspondences or asked.correspondence == "shared_connectivity"
    ):
        message = "simplified shapes have other vertices; leave it out, or have them matched"
        wrong.append(FieldProblem(field="body.simplify", message=message))
    given = len(asked.correspondences[0]) if asked.correspondences else None
    if given is not None and "points" in asked.model_fields_set and asked.points > given:
        message = f"it is at most the number of `correspondences` of a shape, which is {given}"
        wrong.append(FieldProblem(field="body.points", message=message))
    return wrong


def _not_alike(asked: PrototypeRequest, shapes: Mapping[str, ShapeRecord]) -> list[FieldProblem]:
    """Shapes that cannot have the connectivity of the reference, if all are to have it."""
    if asked.correspondences or asked.correspondence != "shared_connectivity":
        return []
    place = asked.shapes.index(asked.reference or asked.shapes[0])
    reference = shapes[f"body.shapes.{place}"]
    return [
        FieldProblem(
            field=field,
            message=f"it has {shape.vertices} vertices and {shape.faces} faces, and shapes.{place}"
            f" {reference.vertices} and {reference.faces}: they share no connectivity",
        )
        for field, shape in shapes.items()
        if (shape.vertices, shape.faces) != (reference.vertices, reference.faces)
    ]
