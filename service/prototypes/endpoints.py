"""``/v1/prototypes``."""

from collections.abc import Mapping
from typing import Annotated, Final

from fastapi import APIRouter, Query, Response

from broker.contracts import (
    FieldProblem,
    PrototypeParameters,
    PrototypePayload,
    ShapeRecord,
)
from broker.upkeep import evict_deleted
from service.dependencies import Service, ServiceOf
from service.http import (
    Cursor,
    InvalidRequest,
    Limit,
    PrototypeExpired,
    PrototypeNotFound,
    UnusablePrototype,
    page_of,
    responses,
)
from service.jobs import Job, JobOrderOf, answers
from service.names import LONGEST
from service.prototypes.lookup import LOCATION, PROTOTYPES, PrototypeId
from service.prototypes.schemas import DEFAULT_NAME, Prototype, PrototypePage, PrototypeRequest
from service.shapes import (
    check_shapes,
    counted,
    descriptor_problems,
    few_vertices,
    refuse,
    repeated_shapes,
    shape_fields,
    use_shapes,
    vertices_out_of_range,
)

router = APIRouter(prefix=LOCATION, tags=["prototypes"])

_REFUSED: Final = "A prototype cannot be learned from this request; `errors` says why."


@router.post(
    "",
    status_code=202,
    responses=answers(),
    operation_id="create_prototype",
)
def create_prototype(asked: PrototypeRequest, order: JobOrderOf) -> Job:
    """Learn a prototype from examples of a class of shapes.

    It describes the class by distributions of the distances between points and of the descriptors
    at them. The job's result names it. The spectra of the examples are computed by all workers.
    """
    return order.job(asked, _payload)


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
        202: PROTOTYPES.validating,
        **responses(PrototypeNotFound, PrototypeExpired, UnusablePrototype, InvalidRequest),
    },
    operation_id="get_prototype",
)
def get_prototype(prototype: PrototypeId, service: ServiceOf) -> Response:
    """Show a prototype."""
    return PROTOTYPES.find(service, prototype)


@router.delete(
    "/{prototype}",
    status_code=204,
    response_class=Response,
    responses=responses(PrototypeNotFound, InvalidRequest),
    operation_id="delete_prototype",
)
def delete_prototype(prototype: PrototypeId, service: ServiceOf) -> None:
    """Delete a prototype; queued matches with it will fail with `prototype-deleted`.

    Other versions of its name stay as they are, and its number is not given again.
    """
    PROTOTYPES.delete(service, prototype)
    evict_deleted(service.store, [prototype])


def _payload(asked: PrototypeRequest, service: Service) -> PrototypePayload:
    refuse(repeated_shapes(asked.shapes) + _contradictions(asked), _REFUSED)
    shapes = use_shapes(service, shape_fields(asked.shapes))
    few = [] if asked.correspondences else few_vertices(shapes, asked.points)
    wrong = few + _different_connectivity(asked, shapes) + _out_of_range(asked, shapes)
    check_shapes(asked, shapes, _REFUSED, wrong)
    parameters = asked.parameters(PrototypeParameters)
    if asked.correspondences and "points" not in asked.model_fields_set:
        parameters = parameters.model_copy(update={"points": len(asked.correspondences[0])})
    return PrototypePayload(
        shapes=asked.shapes,
        reference=0 if asked.reference is None else asked.shapes.index(asked.reference),
        correspondences=asked.correspondences,
        name=asked.name.strip() or DEFAULT_NAME,
        parameters=parameters,
    )


def _contradictions(asked: PrototypeRequest) -> list[FieldProblem]:
    message = "is not supported, as the signs of eigenfunctions differ between shapes"
    wrong = descriptor_problems(asked, ["eigenfunctions"], message)
    if asked.simplify is not None and (
        asked.correspondences or asked.correspondence == "shared_connectivity"
    ):
        message = (
            "simplification changes the vertices that correspond; leave it out, or set"
            ' `correspondence` to "matches"'
        )
        wrong.append(FieldProblem(field="body.simplify", message=message))
    given = len(asked.correspondences[0]) if asked.correspondences else None
    if given is not None and "points" in asked.model_fields_set and asked.points > given:
        message = f"`correspondences` has {given} points of each shape; take at most as many"
        wrong.append(FieldProblem(field="body.points", message=message))
    return wrong


def _different_connectivity(
    asked: PrototypeRequest, shapes: Mapping[str, ShapeRecord]
) -> list[FieldProblem]:
    """Problems of shapes whose counts differ from the reference's, if all share connectivity."""
    if asked.correspondences or asked.correspondence != "shared_connectivity":
        return []
    place = asked.shapes.index(asked.reference or asked.shapes[0])
    reference = shapes[f"body.shapes.{place}"]
    return [
        FieldProblem(
            field=field,
            message=f"it has {counted(shape.vertices, 'vertex', 'vertices')} and"
            f" {counted(shape.faces, 'face')}, but shapes.{place} has {reference.vertices:,} and"
            f" {reference.faces:,}; they share no connectivity",
        )
        for field, shape in shapes.items()
        if (shape.vertices, shape.faces) != (reference.vertices, reference.faces)
    ]


def _out_of_range(asked: PrototypeRequest, shapes: Mapping[str, ShapeRecord]) -> list[FieldProblem]:
    wrong: list[FieldProblem] = []
    for place, (vertices, shape) in enumerate(
        zip(asked.correspondences or (), shapes.values(), strict=False)
    ):
        numbers = ((f"body.correspondences.{place}.{i}", one) for i, one in enumerate(vertices))
        wrong += vertices_out_of_range(numbers, shape, f"shapes.{place}")
    return wrong
