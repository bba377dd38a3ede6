"""Requests and answers without any I/O, so that one body serves a sync and an async client.

An :data:`Operation` is a generator: it yields what it wants done, a :class:`Call` or a
:class:`Pause`, and is sent the response; connection errors are thrown into it. Whoever runs it
(:mod:`isomatch._transport`) does the waiting, in whatever way it waits.
"""

from collections.abc import Generator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias, TypeVar

import httpx2
from pydantic import BaseModel, TypeAdapter, ValidationError

from isomatch._errors import ConnectionFailed, UnexpectedResponse, problem_error
from isomatch._meshes import MeshFile
from isomatch._problem import Problem

Json: TypeAlias = str | int | float | bool | list[str] | Mapping[str, object] | None

ResultT = TypeVar("ResultT")
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


Operation: TypeAlias = Generator[Call | Pause, httpx2.Response | None, ResultT]

RETRY_PAUSES: Final = (0.1, 0.3, 0.9)
"""Seconds before the second and later attempts; long enough for a service that is restarted."""

_NEVER_SENT: Final = (httpx2.ConnectError, httpx2.ConnectTimeout, httpx2.PoolTimeout)


def send(call: Call) -> Operation[httpx2.Response]:
    """Send a call, again if the connection fails and that does no harm, and check the answer.

    Raises
    ------
    ConnectionFailed
        No answer came.
    ProblemError
        The service refused.
    UnexpectedResponse
        The answer is none of the isomatch API's.
    """
    for pause in (*RETRY_PAUSES, None):
        try:
            response = yield call
        except httpx2.TransportError as error:
            may_repeat = call.repeatable or isinstance(error, _NEVER_SENT)
            if pause is None or not may_repeat:
                raise ConnectionFailed(describe(error, call)) from error
            yield Pause(pause)
        else:
            assert response is not None
            return checked(response)
    raise AssertionError("the last attempt returns or raises")


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
        raise problem_error(problem)
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
