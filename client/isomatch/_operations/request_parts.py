"""Paths of resources, and ids and parameters as they are sent."""

import os
from collections.abc import Iterable, Mapping
from typing import Final, Protocol, TypeVar

from pydantic import BaseModel

from isomatch._http import Json
from isomatch._models import Shape, may_be_id
from isomatch._results import Result

HELD: Final = 60.0
"""Seconds for which the service may hold back the answer to an upload, or one that it makes first:
pictures and files."""

_WANTED: Final = "give what client.upload returns, a prototype or a job, or its id"

EntryT = TypeVar("EntryT")


class Identified(Protocol):
    """A shape, a prototype or a job."""

    @property
    def id(self) -> str:
        """Its id."""


def id_of(given: Identified | str) -> str:
    """Return the id of a shape, a prototype or a job, which may be given as its id.

    Of a result see :func:`job_id_of`.

    Raises
    ------
    ValueError
        A text is no id, but perhaps the name of a file.
    TypeError
        A result is given, or something else that has no id.
    """
    if isinstance(given, str | os.PathLike) and not may_be_id(str(given)):
        raise ValueError(f"{str(given)!r} is no id: {_WANTED}")
    if isinstance(given, Result):
        raise TypeError(f"a {type(given).__name__} is a result: {_WANTED}")
    if isinstance(given, str):
        return given
    if not isinstance(getattr(given, "id", None), str):
        raise TypeError(f"{type(given).__name__} has no id: {_WANTED}")
    return given.id


def job_id_of(given: Identified | Result | str) -> str:
    """Return the id of a job, which may be given as its result.

    Raises
    ------
    ValueError
        As for :func:`id_of`, or the result is of an earlier version, which does not name its job.
    TypeError
        As for :func:`id_of`.
    """
    if not isinstance(given, Result):
        return id_of(given)
    if given.job is None:
        raise ValueError("a result of an earlier version does not name its job: give its id")
    return given.job


def listed(given: Iterable[EntryT], entries: str) -> list[EntryT]:
    """Return the entries of a list that a user gave.

    Parameters
    ----------
    given
        The list, or any other iterable.
    entries
        What it has, for the message.

    Raises
    ------
    TypeError
        A single entry is given: a text has letters, and a shape fields, when it is iterated over.
    """
    if isinstance(given, str | bytes | Mapping | BaseModel) or not isinstance(given, Iterable):
        raise TypeError(f"give a list of {entries}, not {type(given).__name__}")
    return list(given)


def named(**shapes: Identified | str) -> dict[str, Json]:
    """Return the names of shapes by the fields for them, without those given as ids.

    The same bytes under two names are one shape; each upload keeps its name.
    """
    return {field: one.name for field, one in shapes.items() if isinstance(one, Shape)}


def names_of(shapes: Iterable[Identified | str]) -> list[Json]:
    """Return the names of shapes, None for those given as ids."""
    return [one.name if isinstance(one, Shape) else None for one in shapes]


def path_to(collection: str, given: Identified | str, *rest: str) -> str:
    """Return the path of a resource of a collection, or of a part of it; see :func:`id_of`."""
    return "/".join(["/v1", collection, id_of(given), *rest])
