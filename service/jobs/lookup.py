"""Jobs as requests name them, and their stored results."""

from typing import Annotated, BinaryIO

from fastapi import Path, Response

from broker.contracts import JobRecord, JobState
from service.dependencies import Service
from service.http import (
    ApiProblem,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    ResultExpired,
    ResultNotReady,
    gzip_response,
)
from service.names import ID_PATTERN

JobId = Annotated[str, Path(description="Id of the job.", pattern=ID_PATTERN)]


def missing(service: Service, job_id: str) -> ApiProblem:
    """Return the problem that a job is not there."""
    if service.queue.expired(job_id):
        return JobExpired("The job ended long ago and is no longer kept.")
    return JobNotFound(f"There is no job {job_id}.")


def stored_job(service: Service, job_id: str) -> JobRecord:
    """Return a job.

    Raises
    ------
    JobNotFound, JobExpired
        There is no such job, or none any more.
    """
    record = service.queue.job(job_id)
    if record is None:
        raise missing(service, job_id)
    return record


def job_with_result(service: Service, job_id: str) -> JobRecord:
    """Return a job of a kind that has a result and that neither failed nor was cancelled.

    Raises
    ------
    JobNotFound, JobExpired, JobWithoutResult
        There is no such job.
    """
    record = stored_job(service, job_id)
    if not record.kind.has_result:
        raise JobWithoutResult(f"A job of kind {record.kind.value!r} has no result.")
    if record.state in (JobState.FAILED, JobState.CANCELLED):
        reason = f": {record.error.detail}" if record.error else ""
        if record.state is JobState.CANCELLED:
            raise JobWithoutResult(f"The job was cancelled{reason.rstrip('.')}; request it again.")
        raise JobWithoutResult(f"The job failed{reason}")
    return record


def check_ended(record: JobRecord) -> None:
    """Refuse the result of a job that is queued or running.

    Raises
    ------
    ResultNotReady
        The job has not ended.
    """
    if not record.state.ended:
        raise ResultNotReady(f"The job is {record.state.value}; ask again when it has ended.")


def check_kept(service: Service, record: JobRecord) -> None:
    """Refuse the result of a job that has not ended, or whose result is not there, unread.

    Raises
    ------
    ResultNotReady, ResultExpired, BlobLost
        There is no such result.
    """
    check_ended(record)
    if not service.store.results.is_whole(record.id):
        raise result_expired()


def open_result(service: Service, job_id: str) -> BinaryIO:
    """Return the result of a job that has ended, JSON in gzip, as a file.

    Raises
    ------
    JobNotFound, JobExpired, JobWithoutResult, ResultNotReady, ResultExpired
        There is no such result.
    """
    check_ended(job_with_result(service, job_id))
    packed = service.store.results.open_document(job_id)
    if packed is None:
        raise result_expired()
    return packed


def result_expired() -> ResultExpired:
    """Return the problem that a result is no longer kept."""
    return ResultExpired("The result is no longer kept; request the same job again.")


def json_answer(packed: BinaryIO, accept_encoding: str) -> Response:
    """Return an answer of JSON in gzip, decompressed for clients that do not accept gzip."""
    return gzip_response(packed, "application/json", accept_encoding)
