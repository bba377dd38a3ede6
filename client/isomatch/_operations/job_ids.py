"""Ids of jobs, of which progress shows the beginning."""

from collections.abc import Iterator
from contextlib import contextmanager

from isomatch._errors import NotFound
from isomatch._models import ID_DIGITS, begins_job_id
from isomatch._progress import ID_SHOWN


@contextmanager
def beginning_explained(given: str) -> Iterator[None]:
    """Say how long ids are if a job is not found by the beginning of one."""
    try:
        yield
    except NotFound as error:
        if not begins_job_id(given):
            raise
        detail = (
            f"{(error.detail or error.title).rstrip('.')}; ids of jobs have {ID_DIGITS} digits, of"
            f" which commands take the first {ID_SHOWN} or more"
        )
        problem = error.problem.model_copy(update={"detail": detail})
        raise NotFound(problem, error.retry_after) from error
