"""Operations that ask for what came of a job; see :mod:`isomatch._http.exchange`."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from isomatch._errors import JobCancelled, JobFailed
from isomatch._http import Call, Operation, parsed, send, unexpected
from isomatch._models import JobRecord
from isomatch._operations.resources import path_to
from isomatch._results import (
    Dissimilarities,
    LearnedPrototype,
    Match,
    PartialDissimilarities,
    Result,
)


def get_partial(job_id: str) -> Operation[PartialDissimilarities]:
    """Ask for the dissimilarities that are known so far."""
    return parsed(
        PartialDissimilarities, (yield from send(Call("GET", path_to("dissimilarities", job_id))))
    )


_RESULTS: Final[Mapping[str, type[Result]]] = {
    "match": Match,
    "dissimilarities": Dissimilarities,
    "prototype": LearnedPrototype,
}


def get_result(record: JobRecord) -> Operation[Result]:
    """Ask for the result of a job that has ended.

    Raises
    ------
    JobFailed, JobCancelled
        It has none.
    """
    if record.state == "failed":
        raise JobFailed(record.id, record.error)
    if record.state == "cancelled":
        raise JobCancelled(record.id)
    response = yield from send(Call("GET", path_to("jobs", record.id, "result")))
    try:
        return _RESULTS.get(record.kind, Match).from_json(response.content)
    except ValidationError as error:
        raise unexpected(response, error) from error


def get_picture(job_id: str, alternative: int | None) -> Operation[bytes]:
    """Ask for the picture of a job's result, or of one of its alternatives."""
    query = {"alternative": alternative}
    response = yield from send(Call("GET", path_to("jobs", job_id, "result.png"), query=query))
    return response.content


def save_picture(
    job_id: str, path: str | os.PathLike[str], alternative: int | None
) -> Operation[None]:
    """Ask for the picture of a job's result, and write it to a file."""
    Path(path).write_bytes((yield from get_picture(job_id, alternative)))


def save_arrays(job_id: str, path: str | os.PathLike[str]) -> Operation[None]:
    """Ask for a job's result as arrays, and write them to a file."""
    response = yield from send(Call("GET", path_to("jobs", job_id, "result.npz")))
    Path(path).write_bytes(response.content)
