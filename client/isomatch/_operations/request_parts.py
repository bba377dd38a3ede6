"""Paths of resources, and ids and parameters as they are sent."""

import os
import re
from collections.abc import Iterable
from typing import Final, Protocol
from urllib.parse import quote

from isomatch._http import Json
from isomatch._models import Shape
from isomatch._results import Result

HELD: Final = 60.0
"""Seconds for which the service may hold back the answer to an upload, or one that it makes first:
pictures and files."""

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
        A result is given instead of its job, or something else that has no id.
    """
    if isinstance(given, str | os.PathLike) and not _ID.fullmatch(str(given)):
        raise ValueError(f"{str(given)!r} is no id: give what client.upload returns of the file")
    if isinstance(given, Result):
        raise TypeError("a result does not know its job: give the job itself, or its id")
    if isinstance(given, str):
        return given
    if not isinstance(getattr(given, "id", None), str):
        raise TypeError(
            f"a {type(given).__name__} has no id: give what client.upload returns, a prototype or a"
            " job, or its id"
        )
    return given.id


def named(**shapes: Identified | str) -> dict[str, Json]:
    """Return the names of shapes by the fields for them, without those given as ids.

    The same bytes under two names are one shape; each upload keeps its name.
    """
    return {field: one.name for field, one in shapes.items() if isinstance(one, Shape)}


def names_of(shapes: Iterable[Identified | str]) -> list[Json]:
    """Return the names of shapes, None for those given as ids."""
    return [one.name if isinstance(one, Shape) else None for one in shapes]


def path_to(*parts: str) -> str:
    """Return the path of a resource."""
    return "/v1/" + "/".join(quote(part, safe="") for part in parts)
