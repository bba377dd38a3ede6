"""Answers of the service: values, problem documents, and anything else."""

from typing import Final, TypeVar

import httpx2
from pydantic import BaseModel, TypeAdapter, ValidationError

from isomatch._errors import ProblemError, UnexpectedResponse, problem_error
from isomatch._http.operation import Call, Operation
from isomatch._http.retries import retry_after
from isomatch._problem import Problem

ModelT = TypeVar("ModelT", bound=BaseModel)

_FOREIGN: Final = (404, 405)
"""Statuses without a problem document that show another service at the address."""


def send(call: Call) -> Operation[httpx2.Response]:
    """Send a call and return its successful answer.

    Raises
    ------
    ConnectionFailed
        No answer came.
    ProblemError
        The service refused.
    UnexpectedResponse
        The answer does not belong to the isomatch API.
    """
    response = yield call
    assert response is not None
    return checked(response)


def fetch(kind: type[ModelT], path: str) -> Operation[ModelT]:
    """Request the resource at a path as a model.

    Raises
    ------
    ConnectionFailed, ProblemError, UnexpectedResponse
        As for :func:`send` and :func:`parsed`.
    """
    return parsed(kind, (yield from send(Call("GET", path))))


def fetch_bytes(path: str) -> Operation[bytes]:
    """Request the file at a path; errors are those of :func:`send`."""
    return (yield from send(Call("GET", path))).content


def delete(path: str) -> Operation[None]:
    """Delete the resource at a path.

    Raises
    ------
    ConnectionFailed, ProblemError, UnexpectedResponse
        As for :func:`send`.
    """
    yield from send(Call("DELETE", path, deletes=True))


def checked(response: httpx2.Response) -> httpx2.Response:
    """Return a successful response, or raise the problem that it states.

    Raises
    ------
    ProblemError
        It is a problem document, or a refusal of a proxy before the service.
    UnexpectedResponse
        It is something else, such as a redirection, or of another service.
    """
    if response.is_success:
        return response
    if response.headers.get("content-type", "").startswith("application/problem+json"):
        try:
            problem = Problem.model_validate_json(response.content)
        except ValidationError as error:
            raise UnexpectedResponse(_message(response, "a broken problem document")) from error
        raise problem_error(problem, retry_after(response))
    if (target := response.headers.get("location")) is not None and response.is_redirect:
        there = response.request.url.join(target)
        raise UnexpectedResponse(_message(response, f"{response.status_code}, moved to {there}"))
    if not response.is_error or response.status_code in _FOREIGN:
        raise UnexpectedResponse(_message(response, f"{response.status_code} without a reason"))
    raise _refusal(response)


def _refusal(response: httpx2.Response) -> ProblemError:
    """Return the error of a refusal without a problem document, by its status."""
    status, request = response.status_code, response.request
    title = response.reason_phrase or f"Status {status}"
    detail = f"{status} {response.reason_phrase}".rstrip()
    problem = Problem(
        title=title,
        status=status,
        detail=f"{request.method} {request.url} was refused, perhaps by a proxy: {detail}",
    )
    return problem_error(problem, retry_after(response))


def checked_stream(response: httpx2.Response) -> httpx2.Response:
    """Return an answer that is a stream of events, or raise as :func:`checked` does.

    Raises
    ------
    ProblemError, UnexpectedResponse
        It is something else.
    """
    kind = checked(response).headers.get("content-type", "without a type")
    if not kind.startswith("text/event-stream"):
        raise UnexpectedResponse(_message(response, f"no stream of events, but {kind}"))
    return response


def parsed(kind: type[ModelT], response: httpx2.Response) -> ModelT:
    """Read the answer's JSON as a model.

    Raises
    ------
    UnexpectedResponse
        The JSON does not fit the model.
    """
    try:
        return TypeAdapter(kind).validate_json(response.content)
    except ValidationError as error:
        raise unexpected(response, error) from error


def unexpected(response: httpx2.Response, error: ValidationError) -> UnexpectedResponse:
    """Return the error that names the first field of an answer that does not fit its model."""
    first = error.errors(include_url=False)[0]
    where = ".".join(map(str, first["loc"])) or "body"
    return UnexpectedResponse(_message(response, f"{where}: {first['msg']}"))


def undecodable(error: httpx2.DecodingError) -> UnexpectedResponse:
    """Return the error of an answer whose bytes are not what its ``Content-Encoding`` says."""
    return UnexpectedResponse(_of_no_service(error.request, str(error)))


def _message(response: httpx2.Response, problem: str) -> str:
    return _of_no_service(response.request, problem)


def _of_no_service(request: httpx2.Request, problem: str) -> str:
    return (
        f"{request.method} {request.url} did not answer as the isomatch API, version 1: {problem}"
    )
