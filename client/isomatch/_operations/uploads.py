"""Uploads of files: of shapes, prototypes and attributes."""

import time
from contextlib import AbstractContextManager
from typing import Final, TypeVar

from pydantic import BaseModel

from isomatch._errors import UnexpectedResponse, WaitTimeout
from isomatch._http import Call, Operation, Pause, UploadFile, parsed, send, wait_given
from isomatch._operations.request_parts import HELD

ModelT = TypeVar("ModelT", bound=BaseModel)

UPLOAD_TIMEOUT: Final = 600.0
"""Seconds an upload may take, until the service has read it, unless told otherwise."""

VALIDATION_POLL: Final = 0.5
"""Seconds between requests for the state of an upload that is being read."""


def upload(
    kind: type[ModelT],
    path: str,
    source: AbstractContextManager[UploadFile],
    name: str | None = None,
    timeout: float | None = UPLOAD_TIMEOUT,
) -> Operation[ModelT]:
    """Upload a file, and wait until the service has read it.

    Parameters
    ----------
    kind
        Type of what the service makes of it.
    path
        Path of the collection that it joins.
    source
        The file.
    name
        Name of what it describes; that of the file if None.
    timeout
        Seconds to wait; None for no limit.

    Raises
    ------
    WaitTimeout
        It was not read within `timeout` seconds.
    TypeError, ValueError
        `timeout` is no number, or negative.
    """
    limit = wait_given(timeout)
    started = time.monotonic()
    with source as file:
        form = {} if name is None else {"name": name}
        called = name or file.name
        response = yield from send(Call("POST", path, file=file, form=form, patience=HELD))
    while response.status_code == 202:
        if limit is not None and time.monotonic() - started >= limit:
            raise WaitTimeout(f"reading {called}", limit)
        yield Pause(VALIDATION_POLL)
        location = response.headers.get("location")
        if location is None:
            raise UnexpectedResponse("the service accepted the upload without naming its location")
        response = yield from send(Call("GET", location))
    return parsed(kind, response)
