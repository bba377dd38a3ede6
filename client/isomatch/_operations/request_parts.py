"""Paths of resources, and ids and parameters as they are sent."""

import os
import re
from typing import Final, Protocol
from urllib.parse import quote

import numpy as np

from isomatch._http import Json
from isomatch._results import Result

_ID: Final = re.compile(r"[0-9a-zA-Z_-]{1,64}")


class Identified(Protocol):
    """A shape, a prototype or a job."""

    @property
    def id(self) -> str:
        """Its id."""


def id_of(given: Identified | str) -> str:
    """Return the id of a shape, a prototype or a job, which may be given as its id.

    Raises
    ------
    ValueError
        A text is no id, but the name of a file.
    TypeError
        A result is given instead of its job.
    """
    if isinstance(given, str | os.PathLike) and not _ID.fullmatch(str(given)):
        raise ValueError(f"{str(given)!r} is no id: give what client.upload returns of the file")
    if isinstance(given, Result):
        raise TypeError("a result does not know its job: give the job itself, or its id")
    return given if isinstance(given, str) else given.id


def path_to(*parts: str) -> str:
    """Return the path of a resource."""
    return "/v1/" + "/".join(quote(part, safe="") for part in parts)


def json_value(value: object) -> Json:
    """Return the value of a parameter as JSON; scalars of numpy become numbers of Python."""
    # Callers give JSON or scalars of numpy, which `object` does not say.
    sent: Json = value.item() if isinstance(value, np.generic) else value  # type: ignore[assignment]
    return sent
