"""``/v1/matches``."""

from fastapi import APIRouter, Response

from service.jobs.schemas import Job
from service.matches.prototypes import prototype_match
from service.matches.schemas import MatchRequest
from service.orders import ACCEPTED, JobOrder, accepted, told_to, use_shapes
from service.problems import (
    BadRequest,
    BodyStalled,
    IdempotencyKeyReused,
    InvalidRequest,
    TooManyJobs,
    UnknownPrototype,
    UnknownShape,
    UploadTooLarge,
    responses,
)
from service.state import Service, ServiceOf
from service.structures.colors import check_colors
from worker.contracts import MatchPayload, is_prototype

router = APIRouter(prefix="/v1/matches", tags=["matches"])


@router.post(
    "",
    status_code=202,
    responses={
        202: ACCEPTED,
        **responses(
            InvalidRequest,
            UnknownShape,
            UnknownPrototype,
            BadRequest,
            UploadTooLarge,
            BodyStalled,
            IdempotencyKeyReused,
            TooManyJobs,
        ),
    },
    operation_id="create_match",
)
def create_match(
    asked: MatchRequest, service: ServiceOf, order: JobOrder, response: Response
) -> Job:
    """Match two shapes: find the correspondence of least distortion between samples of them.

    Or a prototype and a shape: find the most likely one of the prototype's points. Then `metric`,
    `descriptor`, `normalise`, `eigenpairs` and `geodesic_method` are the prototype's, and `refine`,
    `orientation`, `dense`, `landmarks` and the objective "linf" have no meaning.
    """
    record = service.queue.asked_before(order)
    if record is None:
        order = told_to(service, asked, order)
        record = service.queue.submit_match(_payload(asked, service), order)
    return accepted(record, service, response)


def _payload(asked: MatchRequest, service: Service) -> MatchPayload:
    if is_prototype(asked.source):
        return prototype_match(asked, service)
    shapes = use_shapes(service, {"body.source": asked.source, "body.target": asked.target})
    check_colors(asked, shapes)
    return MatchPayload(source=asked.source, target=asked.target, parameters=asked.parameters())
