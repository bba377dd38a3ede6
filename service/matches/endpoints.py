"""``/v1/matches``."""

from collections.abc import Mapping

from fastapi import APIRouter

from broker.contracts import (
    MatchParameters,
    MatchPayload,
    is_prototype,
)
from service.dependencies import Service
from service.http import UnknownPrototype
from service.jobs import Job, JobOrderOf, answers
from service.matches.landmarks import landmarks_out_of_range
from service.matches.prototypes import REFUSED, prototype_parameters
from service.matches.schemas import MatchRequest, SourceRequest
from service.shapes import check_shapes, use_shapes

router = APIRouter(prefix="/v1/matches", tags=["matches"])


@router.post(
    "",
    status_code=202,
    responses=answers(UnknownPrototype),
    operation_id="create_match",
)
def create_match(asked: MatchRequest, order: JobOrderOf) -> Job:
    """Match two shapes: find the correspondence of minimum distortion between samples of them.

    Or match a prototype and a shape: find the most likely correspondence of the prototype's points.
    Then `metric`, `descriptor`, `normalise`, `eigenpairs` and `geodesic_method` are those of the
    prototype, and `refine`, `dense`, `landmarks` and the objective "linf" are not supported.
    """
    return order.job(asked, _payload)


def _payload(asked: MatchRequest, service: Service) -> MatchPayload:
    return MatchPayload(
        source=asked.source,
        target=asked.target,
        source_name=asked.source_name,
        target_name=asked.target_name,
        parameters=checked_parameters(asked, {"body.target": asked.target}, service),
    )


def checked_parameters(
    asked: SourceRequest, targets: Mapping[str, str], service: Service
) -> MatchParameters:
    """Return the parameters in force of the match of a source with one or several targets.

    Parameters
    ----------
    asked
        The request.
    targets
        Ids of the targets by the fields that name them, such as ``body.target``.
    service
        The service that keeps the shapes.

    Raises
    ------
    UnknownPrototype, UnknownShape, InvalidRequest
        Source and targets do not exist, or cannot be matched with these parameters.
    """
    if is_prototype(asked.source):
        return prototype_parameters(asked, targets, service)
    shapes = use_shapes(service, {"body.source": asked.source, **targets})
    check_shapes(asked, shapes, REFUSED, landmarks_out_of_range(asked, shapes))
    return asked.parameters(MatchParameters)
