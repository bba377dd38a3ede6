"""Ids of jobs, of which the beginning may be given."""

from collections.abc import Iterator
from contextlib import contextmanager

from isomatch._errors import NotFound
from isomatch._models import ID_DIGITS, begins_job_id


@contextmanager
def beginning_explained(given: str) -> Iterator[None]:
    """Say how long ids are if a job is not found by the beginning of one."""
    try:
        yield
    except NotFound as error:
        if begins_job_id(given):
            error.extend(f"; ids of jobs have {ID_DIGITS} digits")
        raise
