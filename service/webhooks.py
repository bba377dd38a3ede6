"""What receivers of webhooks are sent, for the OpenAPI document."""

from typing import Annotated

from fastapi import APIRouter, Header

from broker.contracts import WebhookEvent

router = APIRouter()


@router.post(
    "job-ended",
    status_code=204,
    responses={204: {"description": "Taken: any status from 200 to 299 says so"}},
    operation_id="job_ended",
)
def job_ended(
    event: WebhookEvent,
    signature: Annotated[
        str | None,
        Header(
            alias="Isomatch-Signature",
            description="`t=TIME,v1=HEX`: HMAC-SHA256 of `TIME.BODY` with the secret, where"
            " there is one. Refuse what is signed otherwise, and what is older than some minutes.",
        ),
    ] = None,
    delivery: Annotated[
        str | None,
        Header(
            alias="Isomatch-Delivery",
            description="Id of the job: the same at each try, so that the second can be told"
            " from something new.",
        ),
    ] = None,
    attempt: Annotated[
        int | None, Header(alias="Isomatch-Attempt", description="Which try this is.")
    ] = None,
) -> None:
    """Tell that a job has ended, to the `webhook` it was asked for with."""
