"""Requests and answers without any I/O, so that one body serves a sync and an async client.

An :data:`Operation` is a generator: it yields what it wants done, a :class:`Call` or a
:class:`Pause`, and is sent the response; connection errors are thrown into it. A :data:`Stream` is
one that also hands out what comes in. Whoever runs them (:mod:`isomatch._http.transport`,
:mod:`isomatch._http.async_transport`) does the waiting, in whatever way it waits.
"""

import random
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Final, Generic, TypeAlias, TypeVar

import httpx2
from pydantic import BaseModel, TypeAdapter, ValidationError

from isomatch._errors import ConnectionFailed, UnexpectedResponse, problem_error
from isomatch._problem import Problem
from isomatch._upload import MeshFile

Json: TypeAlias = str | int | float | bool | Sequence[object] | Mapping[str, object] | None

ResultT = TypeVar("ResultT")
HeardT = TypeVar("HeardT")
ModelT = TypeVar("ModelT", bound=BaseModel)


@dataclass(frozen=True)
class Call:
    """A request to the service.

    Attributes
    ----------
    method, path
        What to ask of which resource.
    query
        Query parameters; those that are None are left out.
    body
        JSON body.
    file
        Mesh to send as a form, with the fields of `form`.
    repeatable
        Whether a second request after a broken connection does no harm.
    headers
        Headers besides those of every request.
    patience
        Seconds the service may take on purpose, on top of the client's timeout.
    """

    method: str
    path: str
    query: Mapping[str, str | int | float | None] = field(default_factory=dict)
    body: Mapping[str, Json] | None = None
    file: MeshFile | None = None
    form: Mapping[str, str] = field(default_factory=dict)
    repeatable: bool = True
    headers: Mapping[str, str] = field(default_factory=dict)
    patience: float = 0.0


@dataclass(frozen=True)
class Pause:
    """A wait before the operation goes on."""

    seconds: float


@dataclass(frozen=True)
class Listen:
    """A call whose answer is a stream of lines; it is answered before they come."""

    call: Call


@dataclass(frozen=True)
class NextLine:
    """Wants the next line of what is listened to; None at its end."""


@dataclass(frozen=True)
class Heard(Generic[HeardT]):
    """Something for whoever asked, before the operation goes on."""

    what: HeardT


Operation: TypeAlias = Generator[Call | Pause, httpx2.Response | None, ResultT]
"""Asks, pauses, and returns."""

Stream: TypeAlias = Generator[
    Listen | NextLine | Pause | Heard[HeardT], httpx2.Response | str | None, None
]
"""Listens, pauses, and tells of what it has heard."""

FIRST_PAUSE: Final = 0.1
"""Seconds before the second attempt; each later pause is three times as long as the one before."""

LONGEST_PAUSE: Final = 30.0
"""A service that asks for more patience than this is believed: it cannot serve now."""

_NEVER_SENT: Final = (httpx2.ConnectError, httpx2.ConnectTimeout, httpx2.PoolTimeout)
_BUSY: Final = (429, 503)


def send(call: Call) -> Operation[httpx2.Response]:
    """Send a call and return its successful answer.

    Raises
    ------
    ConnectionFailed
        No answer came.
    ProblemError
        The service refused.
    UnexpectedResponse
        The answer is none of the isomatch API's.
    """
    response = yield call
    assert response is not None
    return checked(response)


def persistently(operation: Operation[ResultT], retries: int) -> Operation[ResultT]:
    """Run an operation so that each of its calls is made again where that helps and does no harm.

    That is when the connection fails, and when the service says that it is busy (429, 503), after
    as long as it says (``Retry-After``), or else after pauses that grow.

    Parameters
    ----------
    operation
        Who calls. :class:`ConnectionFailed` is thrown into it if no answer comes.
    retries
        How often a call is repeated at most.
    """
    try:
        step = next(operation)
        while True:
            if isinstance(step, Pause):
                yield step
                step = operation.send(None)
                continue
            try:
                response = yield from _attempts(step, retries)
            except ConnectionFailed as error:
                step = operation.throw(error)
            else:
                step = operation.send(response)
    except StopIteration as end:
        result: ResultT = end.value
        return result
    finally:
        operation.close()


def _attempts(call: Call, retries: int) -> Operation[httpx2.Response]:
    for attempt in range(retries + 1):
        last = attempt == retries
        try:
            response = yield call
        except httpx2.TransportError as error:
            if last or not (call.repeatable or isinstance(error, _NEVER_SENT)):
                raise ConnectionFailed(describe(error, call)) from error
            yield Pause(back_off(attempt))
        else:
            assert response is not None
            asked = retry_after(response) or 0.0
            if last or response.status_code not in _BUSY or asked > LONGEST_PAUSE:
                return response
            yield Pause(max(asked, back_off(attempt)))
    raise AssertionError("the last attempt returns or raises")


def back_off(attempt: int) -> float:
    """Return the seconds to wait after a failed attempt, the first being 0.

    They vary a little, so that clients that failed together do not come back together.
    """
    return min(FIRST_PAUSE * 3.0**attempt, LONGEST_PAUSE) * random.uniform(0.8, 1.2)


def retry_after(response: httpx2.Response) -> float | None:
    """Return the seconds after which an answer says to ask again; None if it does not say."""
    stated = response.headers.get("retry-after", "").strip()
    if stated.isdecimal():
        return float(stated)
    try:
        when = parsedate_to_datetime(stated)
    except ValueError:
        return None
    if when.tzinfo is None:
        return None
    return max((when - datetime.now(UTC)).total_seconds(), 0.0)


def describe(error: httpx2.TransportError, call: Call) -> str:
    """Return in one line why no answer to a call came."""
    reason = str(error) or type(error).__name__
    url = error.request.url
    service = f"the isomatch service at {url.scheme}://{url.netloc.decode()}"
    if isinstance(error, _NEVER_SENT):
        return f"{service} cannot be reached: {reason}"
    if isinstance(error, httpx2.TimeoutException):
        return f"{service} did not answer {call.method} {call.path} in time"
    return f"the connection to {service} broke: {reason}"


def checked(response: httpx2.Response) -> httpx2.Response:
    """Return a successful response; raise what any other one says.

    Raises
    ------
    ProblemError
        It is a problem document.
    UnexpectedResponse
        It is neither a success nor a problem document.
    """
    if response.is_success:
        return response
    if response.headers.get("content-type", "").startswith("application/problem+json"):
        try:
            problem = Problem.model_validate_json(response.content)
        except ValidationError as error:
            raise UnexpectedResponse(_not_ours(response, "a broken problem document")) from error
        raise problem_error(problem, retry_after(response))
    raise UnexpectedResponse(_not_ours(response, f"{response.status_code} without a reason"))


def parsed(kind: type[ModelT], response: httpx2.Response) -> ModelT:
    """Read the answer's JSON as a model.

    Raises
    ------
    UnexpectedResponse
        It is no such JSON.
    """
    try:
        return TypeAdapter(kind).validate_json(response.content)
    except ValidationError as error:
        raise unexpected(response, error) from error


def unexpected(response: httpx2.Response, error: ValidationError) -> UnexpectedResponse:
    """Return the error that says in what an answer differs from what is expected."""
    first = error.errors(include_url=False)[0]
    where = ".".join(map(str, first["loc"])) or "body"
    return UnexpectedResponse(_not_ours(response, f"{where}: {first['msg']}"))


def _not_ours(response: httpx2.Response, what: str) -> str:
    request = response.request
    return f"{request.method} {request.url} did not answer as the isomatch API, version 1: {what}"
