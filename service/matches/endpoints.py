"""``/v1/matches``."""

from fastapi import APIRouter, Response

from broker.contracts import JobRecord, MatchPayload, RequestOrigin, is_prototype
from service.dependencies import Service, ServiceOf
from service.http import UnknownPrototype
from service.jobs import Job, JobOrder, answers, requested_job
from service.matches.prototypes import REFUSED, prototype_match
from service.matches.schemas import MatchRequest
from service.shapes import check_shapes, use_shapes

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
    """Match two shapes: find the correspondence of minimum distortion between samples of them.

    Or match a prototype and a shape: find the most likely correspondence of the prototype's points.
    Then `metric`, `descriptor`, `normalise`, `eigenpairs` and `geodesic_method` are those of the
    prototype, and `refine`, `dense`, `landmarks` and the objective "linf" are not supported.
    """

    def submit(order: RequestOrigin) -> JobRecord:
        named = {"source_name": asked.source_name, "target_name": asked.target_name}
        payload = _payload(asked, service).model_copy(update=named)
        return service.queue.submit_with_spectra(payload, order)

    return requested_job(service, asked, order, response, submit)


def _payload(asked: MatchRequest, service: Service) -> MatchPayload:
    if is_prototype(asked.source):
        return prototype_match(asked, service)
    shapes = use_shapes(service, {"body.source": asked.source, "body.target": asked.target})
    check_shapes(asked, shapes, REFUSED)
    return MatchPayload(source=asked.source, target=asked.target, parameters=asked.parameters())
