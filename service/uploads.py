"""Uploads: answered when a job has read them, or before that if it takes long."""

from collections.abc import Callable
from typing import Any, Final, TypeVar

from fastapi import Depends, Request, Response
from starlette.concurrency import run_in_threadpool

from broker.contracts import FieldProblem, IdempotencyRecord, JobRecord, JobState, UploadPayload
from service.http import InvalidRequest, Reported, UploadCancelled
from service.job_schema import Job
from service.state import Service

RecordT = TypeVar("RecordT")

VALIDATING: Final[dict[str, Any]] = {
    "model": Job,
    "description": "Still being read: the job that does it. Ask for what it makes again.",
}
"""The OpenAPI entry of the answer to an upload that takes long to read."""


async def _each_part_once(request: Request) -> None:
    form = await request.form()
    twice = sorted({name for name in form if len(form.getlist(name)) > 1})
    if twice:
        message = "the form has several such parts, of which one would be used; send one"
        raise InvalidRequest(
            "The request is not valid; `errors` says where.",
            tuple(FieldProblem(field=f"body.{name}", message=message) for name in twice[:20]),
        )


EachPartOnce: Final = Depends(_each_part_once)
"""Refuses an upload whose form has a part twice: nobody was told which of two files was taken."""


def bind(
    service: Service, payload: UploadPayload, caller: str | None, path: str, key: str | None
) -> None:
    """Remember an upload by the idempotency key it came with.

    Raises
    ------
    KeyReused
        The key came with another request.
    """
    if key is None:
        return
    # The body itself is never the same twice: its parts have a boundary made up for each.
    content = (b"POST", path.encode(), payload.model_dump_json().encode())
    service.store.admission.bind(
        IdempotencyRecord.of(caller, key, content, service.settings.idempotency_ttl)
    )


async def read(
    service: Service,
    payload: UploadPayload,
    job_id: str,
    request: Request,
    stored: Callable[[str], RecordT | None],
) -> RecordT | JobRecord | None:
    """Wait for what becomes of an upload.

    Parameters
    ----------
    service
        Where it is read.
    payload
        What is known of it.
    job_id
        The job that reads it.
    request
        Who waits.
    stored
        Returns what it has become, by its id, once it has.

    Returns
    -------
    What it has become; or the job that still reads it; or None if it was deleted at once.

    Raises
    ------
    Reported
        It is not usable.
    UploadCancelled
        The job was cancelled.
    """
    record = await service.wait_for(job_id, service.settings.validation_wait, request)
    if record is not None and record.state is JobState.FAILED and record.error is not None:
        raise Reported(record.error)
    found = await run_in_threadpool(stored, payload.upload)
    if found is not None:
        return found
    if record is not None and record.state is JobState.SUCCEEDED:
        return None
    if record is None or record.state.ended:
        raise UploadCancelled("The upload was cancelled before it was read; send it again.")
    await run_in_threadpool(service.store.uploads.defer, payload.upload, job_id)
    return record


def reader(service: Service, deferred: str | None) -> JobRecord | None:
    """Return the job that still reads an upload whose sender was told to ask again.

    Parameters
    ----------
    service
        Where it is read.
    deferred
        The job that was to read it, if there was one.

    Raises
    ------
    Reported
        The upload was refused since: the sender is owed the reason.
    """
    job = None if deferred is None else service.store.jobs.get(deferred)
    if job is not None and not job.state.ended:
        return job
    if job is not None and job.error is not None:
        raise Reported(job.error)
    return None


def still_reading(service: Service, record: JobRecord, location: str) -> Response:
    """Return the answer that an upload is still being read, and where to ask again."""
    return Response(
        Job.of(record, service.queue).model_dump_json(),
        status_code=202,
        media_type="application/json",
        headers={"Location": location, "Retry-After": "1"},
    )
