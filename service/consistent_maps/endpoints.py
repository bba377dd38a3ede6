"""``/v1/consistent-maps``."""

from typing import Final

from fastapi import APIRouter

from broker.contracts import (
    MOST_MAPPED_VERTICES,
    ConsistentMapsPayload,
    FieldProblem,
    MatchParameters,
)
from service.consistent_maps.schemas import ConsistentMapsRequest
from service.dependencies import Service
from service.jobs import Job, JobOrderOf, answers
from service.shapes import refuse, repeated_shapes, shape_fields, use_shapes

_REFUSED: Final = "These shapes cannot be mapped to one another; `errors` says why."

router = APIRouter(prefix="/v1/consistent-maps", tags=["consistent maps"])


@router.post("", status_code=202, responses=answers(), operation_id="create_consistent_maps")
def create_consistent_maps(asked: ConsistentMapsRequest, order: JobOrderOf) -> Job:
    """Map all shapes of a collection to one another, consistently.

    All pairs are matched at all vertices. Pairs in doubt are mapped anew by way of other shapes
    where that is more probable, so that the maps agree: the map from X to Z is that from X to Y,
    followed by that from Y to Z. The result has the confidence and the cycle error of each pair
    before and after, and names the shapes and pairs that do not fit; `result.npz` has the maps.
    One worker matches the pairs one after another. Pairs that have not begun after 70 % of the
    time that a job may take are left out, and named.
    """
    return order.job(asked, _payload)


def _payload(asked: ConsistentMapsRequest, service: Service) -> ConsistentMapsPayload:
    refuse(repeated_shapes(asked.shapes, asked.names), _REFUSED)
    shapes = use_shapes(service, shape_fields(asked.shapes))
    mapped = sum(shape.vertices for shape in shapes.values()) * (len(shapes) - 1)
    if mapped > MOST_MAPPED_VERTICES:
        message = (
            f"all maps would have {mapped} vertices, which are limited to {MOST_MAPPED_VERTICES};"
            " give fewer shapes, or simplify them"
        )
        refuse([FieldProblem(field="body.shapes", message=message)], _REFUSED)
    parameters = MatchParameters.of_whole_surfaces(asked.largest_component)
    return ConsistentMapsPayload(shapes=asked.shapes, names=asked.names, parameters=parameters)
