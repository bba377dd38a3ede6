"""``/v1/transfers``."""

from fastapi import APIRouter, Response

from broker.contracts import PicturePayload, TransferPayload
from service.dependencies import CallContextOf, Service
from service.http import (
    AttributesDeleted,
    JobWithoutResult,
    ResultExpired,
    ResultNotReady,
    UnknownAttributes,
    attachment,
    binary_file,
    responses,
)
from service.jobs import (
    BYTES,
    ERRORS,
    NEEDED,
    Job,
    JobId,
    JobOrderOf,
    answers,
    presented,
)
from service.transfers.requirements import (
    check_carried,
    usable_match,
    use_ends,
)
from service.transfers.schemas import TransferRequest

router = APIRouter(prefix="/v1/transfers", tags=["transfers"])


@router.post(
    "",
    status_code=202,
    responses=answers(UnknownAttributes, JobWithoutResult, ResultNotReady, ResultExpired),
    operation_id="create_transfer",
)
def create_transfer(asked: TransferRequest, order: JobOrderOf) -> Job:
    """Transfer attributes of vertices or faces, or landmarks, between the two shapes of a match.

    The match is one with `dense`. A vertex takes the value at the point of the other shape that it
    corresponds to, and a face what most of its area corresponds to, or the mean; those without a
    partner have none. The values are `result.npz` of the job, and `result.csv`, `.ply`, `.obj` and
    `.glb`. Landmarks are in the result itself, each with a confidence.
    """
    return order.job(asked, _payload)


@router.get(
    "/{job_id}/source.npz",
    response_class=Response,
    responses={
        200: binary_file("The arrays"),
        **ERRORS,
        **NEEDED,
        **responses(AttributesDeleted),
    },
    operation_id="get_source_arrays",
)
async def get_source_arrays(job_id: JobId, context: CallContextOf) -> Response:
    """Return the values of a transfer on the shape that they come from.

    Names and columns are those of `result.npz`, and row i is vertex i, or face i, of the file of
    that shape. Not of `texture` and `uv`, which the shape's own file has.
    """
    payload = PicturePayload(job=job_id, format="npz")
    return await presented(context, payload, BYTES, attachment(f"{job_id}-source", "npz"))


def _payload(asked: TransferRequest, service: Service) -> TransferPayload:
    match = usable_match(service, asked.match)
    forward = asked.direction == "source_to_target"
    ends = (match.source, match.target) if forward else (match.target, match.source)
    carried, onto = use_ends(service, *ends)
    name = match.source_name if carried.id == match.source else match.target_name
    check_carried(service, asked, carried, onto, name or carried.name)
    return TransferPayload(
        match=asked.match,
        source=carried.id,
        target=onto.id,
        attributes=asked.attributes,
        what=asked.what,
        direction=asked.direction,
        on=asked.on,
        names=asked.names,
        influences=asked.influences,
        points=None if asked.landmarks else asked.surface_points,
        landmarks=asked.landmarks,
    )
