"""``/v1/registrations``."""

from typing import Final

from fastapi import APIRouter

from broker.contracts import (
    MOST_REGISTERED,
    FieldProblem,
    MatchParameters,
    RegistrationPayload,
)
from service.dependencies import Service
from service.jobs import Job, JobOrderOf, answers
from service.registrations.schemas import RegistrationRequest
from service.shapes import refuse, repeated_shapes, shape_fields, use_shapes

_REFUSED: Final = "This template cannot be registered to these shapes; `errors` says why."

router = APIRouter(prefix="/v1/registrations", tags=["registrations"])


@router.post("", status_code=202, responses=answers(), operation_id="create_registration")
def create_registration(asked: RegistrationRequest, order: JobOrderOf) -> Job:
    """Register a template to specimens, and compute the statistics of their shapes.

    The template is matched with each specimen, and its vertices and triangles are put on the
    specimen's surface, so that all specimens have common vertices: `registered.ply` of the job. Of
    these the mean shape (`result.ply`) and the principal components follow (`result.npz`,
    `result.png`). A specimen that cannot be matched is named in the result, with the reason.
    """
    return order.job(asked, _payload)


def _payload(asked: RegistrationRequest, service: Service) -> RegistrationPayload:
    refuse(repeated_shapes(asked.shapes, asked.names), _REFUSED)
    named = {"body.template": asked.template, **shape_fields(asked.shapes)}
    template = use_shapes(service, named)["body.template"]
    parameters = MatchParameters.of_whole_surfaces(asked.largest_component)
    wrong = []
    if template.vertices * len(asked.shapes) > MOST_REGISTERED:
        message = (
            f"it has {template.vertices} vertices, so that at most"
            f" {MOST_REGISTERED // template.vertices} specimens are registered at a time"
        )
        wrong.append(FieldProblem(field="body.template", message=message))
    refuse(wrong, _REFUSED)
    return RegistrationPayload(
        template=asked.template,
        template_name=asked.template_name,
        shapes=asked.shapes,
        names=asked.names,
        scale=asked.scale,
        parameters=parameters,
    )
