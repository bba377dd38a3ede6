"""Errors of the client.

::

    IsomatchError
    ├── ConnectionFailed            nothing answers at the address, or the connection broke
    ├── UnexpectedResponse          the answer does not belong to this version of the API
    ├── ProblemError                the service, or a proxy before it, refused
    │   ├── BadRequest              400  the request cannot be understood
    │   ├── Unauthorized            401  the API key is missing or wrong
    │   ├── Forbidden               403  a proxy, or the service, does not permit the request
    │   ├── NotFound                404  there is no such shape, prototype or job
    │   ├── Conflict                409  not possible in this state, such as an early result
    │   ├── Gone                    410  it has expired
    │   ├── TooLarge                413  the upload exceeds the service's limit
    │   ├── UnsupportedFormat       415  the service does not read this format
    │   ├── Unprocessable           422  the request is well-formed but impossible
    │   │   ├── InvalidRequest           a parameter is invalid; `errors` names it
    │   │   ├── UnknownShape             a shape does not exist
    │   │   ├── UnknownPrototype         a prototype does not exist
    │   │   ├── UnknownAttributes        an attribute file does not exist
    │   │   ├── UnprocessableShape       the file is not a usable mesh; `detail` gives the reason
    │   │   ├── UnprocessableAttributes  the file has no usable attributes; `detail` says why
    │   │   └── UnprocessablePrototype   the file is not a prototype; `detail` gives the reason
    │   ├── TooManyRequests         429  a limit is exceeded; try again later
    │   └── ServiceError            5xx  the service failed
    │       └── ServiceUnavailable  503  the service is starting, stopping or overloaded
    ├── ClientClosed                the client was closed before (also a RuntimeError)
    ├── InvalidSignature            a webhook has no valid signature (also a ValueError)
    ├── WrongCoordinates            landmarks do not fit their mesh (also a ValueError)
    ├── JobFailed                   the job failed; carries the problem document
    ├── JobCancelled                the job was cancelled
    ├── MissingExtra                an optional dependency is missing (also an ImportError)
    └── WaitTimeout                 a wait exceeded its timeout (also a TimeoutError)

Arguments that cannot be sent (a path that does not exist, arrays of the wrong shape) raise Python's
own errors: `OSError`, `TypeError`, `ValueError`.
"""

from collections.abc import Callable
from typing import Any

from isomatch._problem import FieldProblem, Problem


class IsomatchError(Exception):
    """Base of the errors of this package; the message is one line for users.

    Attributes
    ----------
    job_id
        The job that was waited for; None if there is none.
    """

    job_id: str | None = None

    def extend(self, hint: str) -> None:
        """Add to the message."""
        self.args = (f"{str(self).rstrip('.')}{hint}",)

    def __reduce__(self) -> tuple[Callable[..., "IsomatchError"], tuple[Any, ...], dict[str, Any]]:
        # Python's own way calls the class with the message, but constructors take other arguments:
        # pools of processes would hang or break at such an error.
        return _rebuilt, (type(self), *self.args), self.__dict__


def _rebuilt(kind: type[IsomatchError], *args: object) -> IsomatchError:
    """Return an error with this message, without the attributes that its constructor sets."""
    error = kind.__new__(kind, *args)
    super(IsomatchError, error).__init__(*args)
    return error


class ConnectionFailed(IsomatchError):
    """Nothing answers at the service's address, or the connection broke.

    Attributes
    ----------
    sent
        Whether the service may have received the request.
    """

    sent: bool = True


class UnexpectedResponse(IsomatchError):
    """The answer does not belong to this version of the isomatch API."""


class ProblemError(IsomatchError):
    """The service refused a request; base of the classes for single statuses.

    Parameters
    ----------
    problem
        Problem document (RFC 9457) of the answer; of a proxy that sent none, made of its status.
    retry_after
        Seconds of the answer's ``Retry-After``; None without one.
    """

    def __init__(self, problem: Problem, retry_after: float | None = None) -> None:
        super().__init__(problem.summary)
        self.problem = problem
        self.retry_after = retry_after

    def extend(self, hint: str) -> None:
        """Add to the message, and to the detail of the problem document."""
        detail = f"{(self.detail or self.title).rstrip('.')}{hint}"
        self.problem = self.problem.model_copy(update={"detail": detail})
        self.args = (self.problem.summary,)

    @property
    def status(self) -> int:
        """HTTP status."""
        return self.problem.status

    @property
    def type(self) -> str:
        """URI of the kind of problem."""
        return self.problem.type

    @property
    def title(self) -> str:
        """Name of the kind of problem."""
        return self.problem.title

    @property
    def detail(self) -> str | None:
        """Description of this occurrence."""
        return self.problem.detail

    @property
    def errors(self) -> tuple[FieldProblem, ...]:
        """Invalid fields of the request, if any."""
        return self.problem.errors


class BadRequest(ProblemError):
    """400: the request is malformed."""


class Unauthorized(ProblemError):
    """401: the API key is missing or wrong."""


class Forbidden(ProblemError):
    """403: a proxy, or the service, does not permit the request."""


class NotFound(ProblemError):
    """404: there is no shape, prototype or job with this id."""


class Conflict(ProblemError):
    """409: not possible in this state, such as the result of an unfinished job."""


class Gone(ProblemError):
    """410: the resource has expired."""


class TooLarge(ProblemError):
    """413: the upload exceeds the service's limit."""


class UnsupportedFormat(ProblemError):
    """415: the service does not read this mesh format."""


class Unprocessable(ProblemError):
    """422: the request is well-formed but impossible."""


class InvalidRequest(Unprocessable):
    """422: a parameter is invalid; `errors` names it and its valid values."""


class UnknownShape(Unprocessable):
    """422: a shape does not exist or was deleted; `errors` names it."""


class UnknownPrototype(Unprocessable):
    """422: a prototype does not exist or was deleted."""


class UnknownAttributes(Unprocessable):
    """422: an attribute file does not exist or was deleted."""


class UnprocessableAttributes(Unprocessable):
    """422: the file is not a usable file of attributes; `detail` gives the reason."""


class UnprocessableShape(Unprocessable):
    """422: the file is not a usable mesh; `detail` gives the reason and the remedy."""


class UnprocessablePrototype(Unprocessable):
    """422: the file is not the archive of a prototype; `detail` gives the reason."""


class TooManyRequests(ProblemError):
    """429: a limit is exceeded; try again later."""


class ServiceError(ProblemError):
    """5xx: the service failed."""


class ServiceUnavailable(ServiceError):
    """503: the service is starting, stopping or overloaded."""


class ClientClosed(IsomatchError, RuntimeError):
    """The client was closed, by :meth:`~isomatch.Client.close` or at the end of its block."""


class InvalidSignature(IsomatchError, ValueError):
    """A webhook is not signed with the secret, or too long ago."""


class WrongCoordinates(IsomatchError, ValueError):
    """Landmarks are in another coordinate system (LPS or RAS) than the mesh of their template."""


class MissingExtra(IsomatchError, ImportError):
    """An optional dependency is not installed; the message names the command to install it."""

    def __init__(self, extra: str, needed: str) -> None:
        super().__init__(f"{needed} is not installed: pip install 'isomatch[{extra}]'")


class JobFailed(IsomatchError):
    """The job failed.

    Parameters
    ----------
    job_id
        The job.
    problem
        Reason of the failure; None if the service has none.
    """

    def __init__(self, job_id: str, problem: Problem | None) -> None:
        reason = problem.summary if problem else "the service gives no reason"
        super().__init__(f"job {job_id} failed: {reason}")
        self.job_id = job_id
        self.problem = problem


class JobCancelled(IsomatchError):
    """The job was cancelled."""

    def __init__(self, job_id: str) -> None:
        super().__init__(f"job {job_id} was cancelled")
        self.job_id = job_id


class WaitTimeout(IsomatchError, TimeoutError):
    """A job or an upload did not end within the timeout; it continues on the service."""

    def __init__(self, subject: str, timeout: float, job_id: str | None = None) -> None:
        super().__init__(f"{subject} did not end within {timeout:g} s; it continues")
        self.job_id = job_id


_BY_STATUS: dict[int, type[ProblemError]] = {
    400: BadRequest,
    401: Unauthorized,
    403: Forbidden,
    404: NotFound,
    409: Conflict,
    410: Gone,
    413: TooLarge,
    415: UnsupportedFormat,
    422: Unprocessable,
    429: TooManyRequests,
    503: ServiceUnavailable,
}

_BY_TYPE: dict[str, type[ProblemError]] = {
    "urn:isomatch:problem:invalid-request": InvalidRequest,
    "urn:isomatch:problem:unknown-shape": UnknownShape,
    "urn:isomatch:problem:unknown-prototype": UnknownPrototype,
    "urn:isomatch:problem:unknown-attributes": UnknownAttributes,
    "urn:isomatch:problem:unusable-attributes": UnprocessableAttributes,
    "urn:isomatch:problem:unusable-mesh": UnprocessableShape,
    "urn:isomatch:problem:unusable-prototype": UnprocessablePrototype,
}
"""Kinds of problems that share a status."""


def problem_error(problem: Problem, retry_after: float | None = None) -> ProblemError:
    """Return the exception for a problem document, by its type and status.

    Unknown kinds of newer services give the base class.
    """
    general = ServiceError if problem.status >= 500 else ProblemError
    kind = _BY_TYPE.get(problem.type) or _BY_STATUS.get(problem.status, general)
    return kind(problem, retry_after)
