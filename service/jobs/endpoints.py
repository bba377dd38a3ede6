"""``/v1/jobs``."""

from typing import Annotated, Final, Literal, TypeAlias

from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from broker.contracts import JobKind, JobRecord, JobState
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
from service.job_schema import Job, JobPage
from service.jobs.events import EVENT, RETRY_MS, event_id, events, present_job
from service.jobs.lookup import JobId, missing
from service.state import Service, ServiceOf

LONGEST_WAIT: Final = 60.0
CANCEL_WAIT: Final = 2.0
"""Seconds an answer waits for a cancelled job to leave, which most do at once."""

ListedKind: TypeAlias = Literal["match", "dissimilarities", "prototype"]
"""Kinds of jobs that requests ask for."""

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
        # One event; what it carries as text is a job.
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
    state: Annotated[JobState | None, Query(description="Only jobs in this state.")] = None,
    kind: Annotated[ListedKind | None, Query(description="Only jobs of this kind.")] = None,
    shape: Annotated[
        str | None,
        Query(
            pattern=r"^[0-9a-zA-Z_-]{1,64}$",
            description="Only jobs of this shape, or of this prototype: those that name its id.",
        ),
    ] = None,
) -> JobPage:
    """List the jobs that were asked for, the newest first.

    Where most jobs are not of the kind or in the state that is asked for, a page may have fewer
    than `limit`, and still a cursor of the next.
    """
    only = None if kind is None else JobKind(kind)
    page = page_of(lambda: service.store.jobs.page(limit, cursor, state, only, shape))
    return JobPage(
        items=tuple(Job.of(record, service.queue) for record in page.items),
        next_cursor=page.next_cursor,
    )


@router.get(
    "/{job_id}",
    responses=responses(JobNotFound, JobExpired, InvalidRequest),
    operation_id="get_job",
)
async def get_job(job_id: JobId, service: ServiceOf, request: Request, wait: Wait = 0.0) -> Job:
    """Show a job, at once or as soon as it has ended but at most `wait` seconds later."""
    record = await service.wait_for(job_id, wait, request)
    return await run_in_threadpool(_shown, service, record, job_id)


@router.get(
    "/{job_id}/events",
    response_class=StreamingResponse,
    responses={
        200: {"description": "Events named `job`, whose data is the job", "content": _EVENTS},
        204: {"description": "The client has been told how the job ended; it need not come back"},
        **responses(JobNotFound, JobExpired, InvalidRequest),
    },
    operation_id="follow_job",
)
async def follow_job(
    job_id: JobId,
    service: ServiceOf,
    request: Request,
    last_event_id: Annotated[
        str | None,
        Header(
            alias="Last-Event-ID",
            description="Id of the last event that came in; what it told is not told again.",
        ),
    ] = None,
) -> Response:
    """Follow a job by server-sent events: as it is now, and at each change until it has ended.

    A stream ends with the job, or after some minutes; clients such as the browsers' `EventSource`
    then come back by themselves.
    """
    job = await run_in_threadpool(present_job, service, job_id)
    if job is None:
        raise await run_in_threadpool(missing, service, job_id)
    if job.state.ended and event_id(job) == last_event_id:
        return Response(status_code=204)
    # Proxies pass each event on as it comes.
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    stream = events(service, job, last_event_id) if body_wanted(request) else iter(())
    return StreamingResponse(stream, media_type="text/event-stream", headers=headers)


@router.delete(
    "/{job_id}",
    responses=responses(JobNotFound, JobExpired, InvalidRequest),
    operation_id="cancel_job",
)
async def cancel_job(job_id: JobId, service: ServiceOf, request: Request) -> Job:
    """Cancel a job, queued or running; one that has ended stays as it is.

    A running job leaves at the next opportunity: it may be shown as running for a moment.
    """
    before = await run_in_threadpool(service.store.jobs.state, job_id)
    after = await run_in_threadpool(service.store.jobs.cancel, job_id)
    if before is JobState.QUEUED and after is JobState.CANCELLED:
        await run_in_threadpool(service.queue.rq.withdraw, job_id)
    record = await service.wait_for(job_id, CANCEL_WAIT, request)
    return await run_in_threadpool(_shown, service, record, job_id)


def _shown(service: Service, record: JobRecord | None, job_id: str) -> Job:
    if record is None:
        raise missing(service, job_id)
    return Job.of(record, service.queue)
