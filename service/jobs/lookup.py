"""Jobs as requests name them: found, or missed, and what is kept of their results."""

from typing import Annotated

from fastapi import Path, Response

from broker.contracts import JobRecord, JobState
from service.http import (
    ApiProblem,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    ResultExpired,
    ResultNotReady,
    unpacked_if_need_be,
)
from service.state import Service

JobId = Annotated[str, Path(description="Id of the job.", pattern=r"^[0-9a-zA-Z_-]{1,64}$")]


def missing(service: Service, job_id: str) -> ApiProblem:
    """Return what is said of a job that is not there."""
    if service.store.jobs.expired(job_id):
        return JobExpired("The job ended long ago and is no longer kept.")
    return JobNotFound(f"There is no job {job_id}.")


def job_with_result(service: Service, job_id: str) -> JobRecord:
    """Return a job of a kind that has a result and that neither failed nor was cancelled.

    Raises
    ------
    JobNotFound, JobExpired, JobWithoutResult
        There is none.
    """
    record = service.store.jobs.get(job_id)
    if record is None:
        raise missing(service, job_id)
    if not record.kind.has_result:
        raise JobWithoutResult(f"A {record.kind.value} makes no result.")
    if record.state in (JobState.FAILED, JobState.CANCELLED):
        reason = f": {record.error.detail}" if record.error else ""
        raise JobWithoutResult(
            f"The job was {record.state.value}{reason}"
            if record.state is JobState.CANCELLED
            else f"The job failed{reason}"
        )
    return record


def packed_result(service: Service, job_id: str) -> bytes:
    """Return the result of a job that has ended, JSON in gzip.

    Raises
    ------
    JobNotFound, JobExpired, JobWithoutResult, ResultNotReady, ResultExpired
        There is none.
    """
    record = job_with_result(service, job_id)
    if not record.state.ended:
        raise ResultNotReady(f"The job is {record.state.value}; ask again when it has ended.")
    packed = service.store.results.document(job_id)
    if packed is None:
        raise result_expired()
    return packed


def result_expired() -> ResultExpired:
    """Return what is said of a result that is not kept any more."""
    return ResultExpired("The result is no longer kept; ask for the same once more.")


def json_answer(packed: bytes, accept_encoding: str) -> Response:
    """Return the answer that is JSON in gzip, unpacked for those who do not take that."""
    return unpacked_if_need_be(packed, "application/json", accept_encoding)
