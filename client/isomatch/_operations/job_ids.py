"""Ids of jobs, of which progress shows the beginning."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from isomatch._errors import NotFound
from isomatch._progress import ID_SHOWN

_DIGITS: Final = 32


def is_beginning(given: str) -> bool:
    """Return whether a text may be the beginning of an id."""
    return re.fullmatch(rf"[0-9a-f]{{1,{_DIGITS - 1}}}", given) is not None


@contextmanager
def beginning_explained(given: str) -> Iterator[None]:
    """Say how long ids are if a job is not found by the beginning of one."""
    try:
        yield
    except NotFound as error:
        if not is_beginning(given):
            raise
        detail = (
            f"{(error.detail or error.title).rstrip('.')}; ids of jobs have {_DIGITS} digits, of"
            f" which commands take the first {ID_SHOWN} or more"
        )
        problem = error.problem.model_copy(update={"detail": detail})
        raise NotFound(problem, error.retry_after) from error
