"""Errors of a service that stays away while a job is waited for: they name the job."""

from collections.abc import Iterator
from contextlib import contextmanager

from isomatch._errors import (
    ConnectionFailed,
    ServiceUnavailable,
    TooManyRequests,
    UnexpectedResponse,
)


@contextmanager
def job_named(job_id: str, state: str = "continues") -> Iterator[None]:
    """Add a job, and the command that waits for it, to the message of an outage.

    The job continues when the service is back, but its id may have been told nowhere.
    """
    hint = f"job {job_id} {state}; get its result with `isomatch jobs result {job_id}`"
    try:
        yield
    except (ConnectionFailed, UnexpectedResponse) as error:
        raise type(error)(f"{error}; {hint}") from error
    except (ServiceUnavailable, TooManyRequests) as error:
        detail = f"{error.detail or error.title}; {hint}"
        problem = error.problem.model_copy(update={"detail": detail})
        raise type(error)(problem, error.retry_after) from error
