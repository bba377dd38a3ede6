"""Errors of a service that stays away while a job is waited for: they name the job."""

from collections.abc import Iterator
from contextlib import contextmanager

from isomatch._errors import (
    ConnectionFailed,
    ServiceError,
    TooManyRequests,
    UnexpectedResponse,
)


@contextmanager
def job_named(job_id: str, state: str = "continues") -> Iterator[None]:
    """Add a job to an outage: it continues, but its id may have been told nowhere."""
    try:
        yield
    except (ConnectionFailed, UnexpectedResponse, ServiceError, TooManyRequests) as error:
        error.job_id = job_id
        error.extend(f"; job {job_id} {state}")
        raise
