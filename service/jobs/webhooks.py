"""The webhook that notifies of the end of a job, for the OpenAPI document."""

from typing import Annotated

from fastapi import APIRouter, Header

from broker.contracts import WebhookEvent

router = APIRouter()


@router.post(
    "job-ended",
    status_code=204,
    responses={204: {"description": "Received; any status from 200 to 299 says so"}},
    operation_id="job_ended",
)
def job_ended(
    event: WebhookEvent,
    signature: Annotated[
        str | None,
        Header(
            alias="Isomatch-Signature",
            description="`t=TIME,v1=HEX`: HMAC-SHA256 of `TIME.BODY` with the secret, if one was"
            " given. Refuse a wrong signature, and one that is older than a few minutes.",
        ),
    ] = None,
    delivery: Annotated[
        str | None,
        Header(
            alias="Isomatch-Delivery",
            description="Id of the job, the same at each attempt, so that repeated deliveries can"
            " be recognised.",
        ),
    ] = None,
    attempt: Annotated[
        int | None, Header(alias="Isomatch-Attempt", description="Number of the attempt, from 1.")
    ] = None,
) -> None:
    """Notify the `webhook` of a job that the job has ended."""
