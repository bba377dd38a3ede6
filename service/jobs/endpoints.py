"""``/v1/jobs``."""

import gzip
from typing import Annotated, Final

from fastapi import APIRouter, Header, Path, Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from service.jobs.events import event_id, events, present_job
from service.jobs.schemas import Job, JobPage
from service.paging import Cursor, Limit, page_of
from service.problems import (
    ApiProblem,
    InvalidRequest,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    PictureNotReady,
    Reported,
    ResultExpired,
    ResultNotReady,
    ShapeDeleted,
    responses,
)
from service.state import Caller, RequestId, Service, ServiceOf
from worker.contracts import JobKind, JobRecord, JobState, MatchResult, Order, PicturePayload
from worker.queue import new_job

LONGEST_WAIT: Final = 60.0
CANCEL_WAIT: Final = 2.0
"""Seconds an answer waits for a cancelled job to leave, which most do at once."""

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

JobId = Annotated[str, Path(description="Id of the job.", pattern=r"^[0-9a-zA-Z_-]{1,64}$")]
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
        "schema": {"type": "string"},
        "example": 'event: job\ndata: {"id": "5f0c…", "state": "succeeded", …}\nid: 9d1f…\n\n',
    }
}
_RESULT_ERRORS: Final = responses(
    JobNotFound, JobExpired, ResultNotReady, JobWithoutResult, ResultExpired, InvalidRequest
)


@router.get("", responses=responses(InvalidRequest), operation_id="list_jobs")
def list_jobs(
    service: ServiceOf,
    limit: Limit = 50,
    cursor: Cursor = None,
    state: Annotated[JobState | None, Query(description="Only jobs in this state.")] = None,
) -> JobPage:
    """List the jobs that were asked for, the newest first."""
    page = page_of(lambda: service.store.jobs.page(limit, cursor, state))
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
        raise await run_in_threadpool(_missing, service, job_id)
    if job.state.ended and event_id(job) == last_event_id:
        return Response(status_code=204)
    # Proxies pass each event on as it comes.
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    stream = events(service, job, last_event_id)
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
        await run_in_threadpool(service.queue.withdraw, job_id)
    record = await service.wait_for(job_id, CANCEL_WAIT, request)
    return await run_in_threadpool(_shown, service, record, job_id)


@router.get(
    "/{job_id}/result",
    response_model=MatchResult,
    responses=_RESULT_ERRORS,
    operation_id="get_result",
)
def get_result(
    job_id: JobId,
    service: ServiceOf,
    accept_encoding: Annotated[str, Header(include_in_schema=False)] = "",
) -> Response:
    """Return the result of a match."""
    packed = _packed_result(service, job_id)
    headers = {"Vary": "Accept-Encoding"}
    if "gzip" in accept_encoding.lower():
        headers["Content-Encoding"] = "gzip"
        return Response(packed, media_type="application/json", headers=headers)
    return Response(gzip.decompress(packed), media_type="application/json", headers=headers)


@router.get(
    "/{job_id}/result.png",
    response_class=Response,
    responses={
        200: {
            "description": "The picture",
            "content": {"image/png": {"schema": {"type": "string", "format": "binary"}}},
        },
        **_RESULT_ERRORS,
        **responses(ResultExpired, JobExpired, ShapeDeleted, PictureNotReady),
    },
    operation_id="get_picture",
)
async def get_picture(
    job_id: JobId, service: ServiceOf, request_id: RequestId, caller: Caller, request: Request
) -> Response:
    """Draw the result of a match: both shapes, with corresponding points in the same colour."""
    picture = await run_in_threadpool(service.store.jobs.picture, job_id)
    if picture is None:
        await run_in_threadpool(_packed_result, service, job_id)
        order = Order(request_id, caller)
        drawing = await run_in_threadpool(_submit_picture, service, job_id, order)
        record = await service.wait_for(drawing, service.settings.picture_wait, request)
        picture = await run_in_threadpool(service.store.jobs.picture, job_id)
        if picture is None:
            if record is not None and record.error is not None:
                raise Reported(record.error)
            raise PictureNotReady("The picture takes long to draw; ask again.")
    return Response(picture, media_type="image/png")


def _submit_picture(service: Service, match_id: str, order: Order) -> str:
    job = new_job(PicturePayload(job=match_id), order)
    holder = service.store.jobs.picture_job(match_id, job.id)
    if holder == job.id:
        service.queue.submit(job)
    return holder


def _packed_result(service: Service, job_id: str) -> bytes:
    record = service.store.jobs.get(job_id)
    if record is None:
        raise _missing(service, job_id)
    if record.kind is not JobKind.MATCH:
        raise JobWithoutResult(f"A {record.kind.value} makes no result.")
    if not record.state.ended:
        raise ResultNotReady(f"The job is {record.state.value}; ask again when it has ended.")
    if record.state is not JobState.SUCCEEDED:
        reason = f": {record.error.detail}" if record.error else ""
        raise JobWithoutResult(
            f"The job was {record.state.value}{reason}"
            if record.state is JobState.CANCELLED
            else f"The job failed{reason}"
        )
    packed = service.store.jobs.result(job_id)
    if packed is None:
        raise ResultExpired("The result is no longer kept; match the shapes again.")
    return packed


def _shown(service: Service, record: JobRecord | None, job_id: str) -> Job:
    if record is None:
        raise _missing(service, job_id)
    return Job.of(record, service.queue)


def _missing(service: Service, job_id: str) -> ApiProblem:
    if service.store.jobs.expired(job_id):
        return JobExpired("The job ended long ago and is no longer kept.")
    return JobNotFound(f"There is no job {job_id}.")
