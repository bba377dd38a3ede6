"""``/v1/matches``."""

from fastapi import APIRouter, Response

from broker.contracts import MatchPayload, is_prototype
from service.http import UnknownPrototype
from service.job_schema import Job
from service.matches.prototypes import CANNOT_BE_MATCHED, prototype_match
from service.matches.schemas import MatchRequest
from service.orders import JobOrder, accepted, answers, told_to, use_shapes
from service.state import Service, ServiceOf
from service.suitability import check_shapes

router = APIRouter(prefix="/v1/matches", tags=["matches"])


@router.post(
    "",
    status_code=202,
    responses=answers(UnknownPrototype),
    operation_id="create_match",
)
def create_match(
    asked: MatchRequest, service: ServiceOf, order: JobOrder, response: Response
) -> Job:
    """Match two shapes: find the correspondence of least distortion between samples of them.

    Or a prototype and a shape: find the most likely one of the prototype's points. Then `metric`,
    `descriptor`, `normalise`, `eigenpairs` and `geodesic_method` are the prototype's, and `refine`,
    `dense`, `landmarks` and the objective "linf" have no meaning.
    """
    record = service.queue.earlier_job(order)
    if record is None:
        order = told_to(service, asked, order)
        record = service.queue.submit_with_spectra(_payload(asked, service), order)
    return accepted(record, service, response)


def _payload(asked: MatchRequest, service: Service) -> MatchPayload:
    if is_prototype(asked.source):
        return prototype_match(asked, service)
    shapes = use_shapes(service, {"body.source": asked.source, "body.target": asked.target})
    check_shapes(asked, shapes, CANNOT_BE_MATCHED)
    return MatchPayload(source=asked.source, target=asked.target, parameters=asked.parameters())
