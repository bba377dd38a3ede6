"""Steps of operations: the vocabulary between the API's logic and its I/O.

An :data:`Operation` is a generator: it yields a :class:`Call` or a :class:`Pause`, is sent the
response of each call, and returns a value. A :data:`Stream` also yields :class:`Item` values as
they arrive. A transport runs them, blocking (:mod:`isomatch._http.blocking_transport`) or
asynchronously (:mod:`isomatch._http.async_transport`), so that one body serves both clients.
"""

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import BinaryIO, Generic, TypeAlias, TypeVar

import httpx2

Json: TypeAlias = str | int | float | bool | Sequence[object] | Mapping[str, object] | None

ResultT = TypeVar("ResultT")
ItemT = TypeVar("ItemT")


@dataclass(frozen=True)
class UploadFile:
    """A file to upload; the extension of its name is its format."""

    name: str
    content: bytes | BinaryIO


@dataclass(frozen=True)
class Call:
    """A request to the service.

    Attributes
    ----------
    method, path
        HTTP method, and path of the resource.
    query
        Query parameters; those that are None are left out.
    body
        JSON body; scalars and arrays of numpy become JSON.
    file
        File to upload, with the form fields `form`.
    headers
        Headers besides those of every request.
    patience
        Seconds the service may hold the answer back, on top of the client's timeout.
    outage
        Seconds for which the call is repeated while no service answers, however few retries these
        take; not where retries are switched off.
    deadline
        Time of `time.monotonic` from which no answer is waited for, and the call is not repeated.
    deletes
        Whether it deletes its resource, so that a repetition may find it gone.
    """

    method: str
    path: str
    query: Mapping[str, str | int | float | None] = field(default_factory=dict)
    body: Mapping[str, object] | None = None
    file: UploadFile | None = None
    form: Mapping[str, str] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    patience: float = 0.0
    outage: float = 0.0
    deadline: float = math.inf
    deletes: bool = False


@dataclass(frozen=True)
class Pause:
    """A wait, in seconds, before the operation continues."""

    seconds: float


@dataclass(frozen=True)
class Listen:
    """A call whose answer is a stream of lines; answered with the response before they arrive."""

    call: Call


@dataclass(frozen=True)
class NextLine:
    """Request for the next line of the stream; answered with None at its end."""


@dataclass(frozen=True)
class Item(Generic[ItemT]):
    """A value for the consumer of a stream."""

    value: ItemT


Operation: TypeAlias = Generator[Call | Pause, httpx2.Response | None, ResultT]
"""Yields calls and pauses, and returns a value."""

Stream: TypeAlias = Generator[
    Call | Listen | NextLine | Pause | Item[ItemT], httpx2.Response | str | None, None
]
"""Calls, listens, pauses, and yields items."""
