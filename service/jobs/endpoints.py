"""``/v1/jobs``."""

from typing import Annotated, Final, Literal, TypeAlias

from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from broker.contracts import JobKind, JobRecord, JobState
from service.dependencies import Admitted, Service, ServiceOf
from service.http import (
    Cursor,
    InvalidRequest,
    JobExpired,
    JobNotFound,
    Limit,
    body_wanted,
    page_of,
    responses,
)
from service.jobs.events import EVENT, RETRY_MS, events, present_event
from service.jobs.followed import FollowedOf
from service.jobs.lookup import JobId, missing
from service.jobs.schemas import Job, JobPage
from service.names import ID_PATTERN

LONGEST_WAIT: Final = 60.0
"""Seconds."""
CANCEL_WAIT: Final = 2.0
"""Seconds an answer waits for a cancelled job to stop; most stop at once."""

ListedKind: TypeAlias = Literal[
    "match",
    "batch",
    "dissimilarities",
    "prototype",
    "transfer",
    "registration",
    "consistent_maps",
]
"""Kinds of jobs that are listed: those that users request."""

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

Wait = Annotated[
    float,
    Query(
        ge=0,
        le=LONGEST_WAIT,
        allow_inf_nan=False,
        description="Seconds to hold the answer back until the job has ended.",
    ),
]
_EVENTS: Final = {
    "text/event-stream": {
        # One event, whose data is a job as JSON text.
        "schema": {
            "type": "object",
            "properties": {
                "event": {"const": EVENT},
                "data": {
                    "type": "string",
                    "contentMediaType": "application/json",
                    "contentSchema": {"$ref": "#/components/schemas/Job"},
                },
                "id": {"type": "string"},
                "retry": {"type": "integer"},
            },
        },
        "example": {
            "event": EVENT,
            "data": '{"id":"5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f","state":"succeeded"}',
            "id": "9d1f0c8a7b6e5d4c",
            "retry": RETRY_MS,
        },
    }
}


@router.get("", responses=responses(InvalidRequest), operation_id="list_jobs")
def list_jobs(
    service: ServiceOf,
    limit: Limit = 50,
    cursor: Cursor = None,
    state: Annotated[
        list[JobState] | None,
        Query(
            max_length=len(JobState),
            description="Only jobs in this state, or in one of several: the parameter may be"
            " repeated.",
        ),
    ] = None,
    kind: Annotated[ListedKind | None, Query(description="Only jobs of this kind.")] = None,
    shape: Annotated[
        str | None,
        Query(
            pattern=ID_PATTERN,
            description="Only jobs of the shape or prototype with this id.",
        ),
    ] = None,
) -> JobPage:
    """List the jobs, the newest first.

    With a filter, a page may have fewer than `limit` jobs and still a cursor of the next page.
    """
    only = None if kind is None else JobKind(kind)
    page = page_of(lambda: service.store.jobs.page(limit, cursor, state or (), only, shape))
    return JobPage(
        items=Job.several(page.items, service.queue),
        next_cursor=page.next_cursor,
    )


@router.get(
    "/{job_id}",
    responses=responses(JobNotFound, JobExpired, InvalidRequest),
    operation_id="get_job",
)
async def get_job(job_id: JobId, service: ServiceOf, request: Request, wait: Wait = 0.0) -> Job:
    """Show a job, as soon as it has ended or at the latest after `wait` seconds."""
    record = await service.wait_for(job_id, wait, request)
    return await run_in_threadpool(_shown, service, record, job_id)


@router.get(
    "/{job_id}/events",
    response_class=StreamingResponse,
    responses={
        200: {"description": "Events named `job`, whose data is the job", "content": _EVENTS},
        204: {"description": "The client knows how the job ended; it need not reconnect"},
        **responses(JobNotFound, JobExpired, InvalidRequest),
    },
    operation_id="follow_job",
)
async def follow_job(
    job_id: JobId,
    service: ServiceOf,
    followed: FollowedOf,
    request: Request,
    admitted: Admitted,
    last_event_id: Annotated[
        str | None,
        Header(
            alias="Last-Event-ID",
            description="Id of the last event received; it is not sent again.",
        ),
    ] = None,
) -> Response:
    """Follow a job by server-sent events: its present state, and each change until it has ended.

    A stream ends with the job, or after a few minutes; clients such as `EventSource` in browsers
    then reconnect by themselves.
    """
    event = await run_in_threadpool(present_event, service, job_id)
    if event is None:
        raise await run_in_threadpool(missing, service, job_id)
    if event.last and event.id == last_event_id:
        return Response(status_code=204)
    # Proxies pass each event on as it comes.
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    if not body_wanted(request):
        return StreamingResponse(iter(()), media_type="text/event-stream", headers=headers)
    name = service.store.keys.tenant, job_id
    stream = events(service, followed, name, event, last_event_id, admitted)
    return StreamingResponse(stream, media_type="text/event-stream", headers=headers)


@router.delete(
    "/{job_id}",
    responses=responses(JobNotFound, JobExpired, InvalidRequest),
    operation_id="cancel_job",
)
async def cancel_job(job_id: JobId, service: ServiceOf, request: Request) -> Job:
    """Cancel a queued or running job; a job that has ended does not change.

    A running job stops at the next opportunity; its state may be `running` for a moment. The
    matches of a batch are cancelled with it.
    """
    await run_in_threadpool(service.queue.cancel, job_id)
    record = await service.wait_for(job_id, CANCEL_WAIT, request)
    return await run_in_threadpool(_shown, service, record, job_id)


def _shown(service: Service, record: JobRecord | None, job_id: str) -> Job:
    if record is None:
        raise missing(service, job_id)
    return Job.of(record, service.queue)
