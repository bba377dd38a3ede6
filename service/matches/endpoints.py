"""``/v1/matches``."""

from fastapi import APIRouter, Response

from service.jobs.schemas import Job
from service.matches.schemas import MatchRequest
from service.problems import (
    BadRequest,
    BodyStalled,
    InvalidRequest,
    UnknownShape,
    UploadTooLarge,
    responses,
)
from service.state import RequestId, ServiceOf
from worker.contracts import FieldProblem, MatchPayload

router = APIRouter(prefix="/v1/matches", tags=["matches"])


@router.post(
    "",
    status_code=202,
    responses={
        202: {
            "description": "The job that matches them",
            "headers": {"Location": {"description": "The job.", "schema": {"type": "string"}}},
        },
        **responses(InvalidRequest, UnknownShape, BadRequest, UploadTooLarge, BodyStalled),
    },
    operation_id="create_match",
)
def create_match(
    asked: MatchRequest, service: ServiceOf, request_id: RequestId, response: Response
) -> Job:
    """Match two shapes: find the correspondence of least distortion between samples of them."""
    unknown = tuple(
        FieldProblem(field=f"body.{field}", message=f"there is no shape {shape}")
        for field, shape in (("source", asked.source), ("target", asked.target))
        if service.store.shapes.get(shape) is None
    )
    if unknown:
        raise UnknownShape("Upload the shapes first; `errors` says which is unknown.", unknown)
    payload = MatchPayload(source=asked.source, target=asked.target, parameters=asked.parameters())
    record = service.queue.submit_match(payload, request_id)
    job = Job.of(record, service.queue)
    response.headers["Location"] = job.links.self
    return job
