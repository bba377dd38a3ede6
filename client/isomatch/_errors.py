"""What the client raises.

::

    IsomatchError
    ├── ConnectionFailed            nothing at that address answers, or the connection broke
    ├── UnexpectedResponse          something answers, but not as the isomatch API of this version
    ├── ProblemError                the service refused, and says why in a problem document
    │   ├── BadRequest              400  the request cannot be understood
    │   ├── Unauthorized            401  the service asks for an API key, or for another one
    │   ├── NotFound                404  no such shape or job
    │   ├── Conflict                409  not in this state, e.g. the result of an unfinished job
    │   ├── Gone                    410  it was there and has expired
    │   ├── TooLarge                413  the upload is over the service's limit
    │   ├── UnsupportedFormat       415  not a mesh format the service reads
    │   ├── Unprocessable           422  understood, but impossible
    │   │   ├── InvalidRequest           a parameter has no meaning; `errors` says which
    │   │   ├── UnknownShape             a match names a shape that is not there
    │   │   ├── UnknownPrototype         a match names a prototype that is not there
    │   │   ├── UnprocessableShape       the file is not a usable mesh; `detail` says why
    │   │   └── UnprocessablePrototype   the file is not a prototype; `detail` says why
    │   ├── TooManyRequests         429  over a limit; try again later
    │   └── ServiceError            5xx  the service failed
    │       └── ServiceUnavailable  503  the service is starting, stopping or overloaded
    ├── InvalidSignature            a webhook is not signed with the secret (also a ValueError)
    ├── JobFailed                   the job ended without a result; carries the problem document
    ├── JobCancelled                the job was cancelled before it ended
    ├── MissingExtra                an optional part is not installed (also an ImportError)
    └── WaitTimeout                 it did not end in time and goes on (also a TimeoutError)

Arguments that no request can be made of (a path that does not exist, arrays of the wrong shape)
raise Python's own errors: `OSError`, `TypeError`, `ValueError`.
"""

from isomatch._problem import FieldProblem, Problem


class IsomatchError(Exception):
    """Root of the errors raised by this package; the message is one line fit for a user."""


class ConnectionFailed(IsomatchError):  # noqa: N818 - said of an event
    """Nothing at the service's address answers, or the connection broke."""


class UnexpectedResponse(IsomatchError):  # noqa: N818 - said of an event
    """Something answers at the service's address, but not as the isomatch API of this version."""


class ProblemError(IsomatchError):
    """The service refused a request; the base of one class for each status.

    Parameters
    ----------
    problem
        The problem document (RFC 9457) the service answered with.
    retry_after
        Seconds after which it says to ask again; None if it does not say.
    """

    def __init__(self, problem: Problem, retry_after: float | None = None) -> None:
        super().__init__(problem.summary)
        self.problem = problem
        self.retry_after = retry_after

    @property
    def status(self) -> int:
        """The HTTP status."""
        return self.problem.status

    @property
    def type(self) -> str:
        """The URI that names the kind of problem."""
        return self.problem.type

    @property
    def title(self) -> str:
        """The kind of problem in words."""
        return self.problem.title

    @property
    def detail(self) -> str | None:
        """What happened this time, in words."""
        return self.problem.detail

    @property
    def errors(self) -> tuple[FieldProblem, ...]:
        """What is wrong with which field, where fields are to blame."""
        return self.problem.errors


class BadRequest(ProblemError):  # noqa: N818 - named as HTTP names it
    """400: the request cannot be understood."""


class Unauthorized(ProblemError):  # noqa: N818 - named as HTTP names it
    """401: the service asks for an API key, or for another one than was sent."""


class NotFound(ProblemError):  # noqa: N818 - named as HTTP names it
    """404: there is no shape or job with this id."""


class Conflict(ProblemError):  # noqa: N818 - named as HTTP names it
    """409: not possible in the present state, such as the result of an unfinished job."""


class Gone(ProblemError):  # noqa: N818 - named as HTTP names it
    """410: it was there and has expired."""


class TooLarge(ProblemError):  # noqa: N818 - named as HTTP names it
    """413: the upload is over the service's limit."""


class UnsupportedFormat(ProblemError):  # noqa: N818 - named as HTTP names it
    """415: not a mesh format the service reads."""


class Unprocessable(ProblemError):  # noqa: N818 - named as HTTP names it
    """422: understood, but impossible."""


class InvalidRequest(Unprocessable):
    """422: a parameter has no meaning; `errors` says which and what would be right."""


class UnknownShape(Unprocessable):
    """422: a match names a shape that is not there, or no longer; `errors` says which."""


class UnknownPrototype(Unprocessable):
    """422: a match names a prototype that is not there, or no longer."""


class UnprocessableShape(Unprocessable):
    """422: the file is not a usable mesh; `detail` says why and what to do."""


class UnprocessablePrototype(Unprocessable):
    """422: the file is not the archive of a prototype; `detail` says why."""


class TooManyRequests(ProblemError):  # noqa: N818 - named as HTTP names it
    """429: over a limit; try again later."""


class ServiceError(ProblemError):
    """5xx: the service failed."""


class ServiceUnavailable(ServiceError):  # noqa: N818 - named as HTTP names it
    """503: the service is starting, stopping or overloaded."""


class InvalidSignature(IsomatchError, ValueError):  # noqa: N818 - said of the signature
    """A webhook is not signed with the secret, or not lately."""


class MissingExtra(IsomatchError, ImportError):  # noqa: N818 - said of what is not installed
    """An optional part of this package is not installed; the message says how to get it."""

    def __init__(self, extra: str, needed: str) -> None:
        super().__init__(f"this needs {needed}: pip install 'isomatch[{extra}]'")


class JobFailed(IsomatchError):  # noqa: N818 - said of an event
    """The job ended without a result.

    Parameters
    ----------
    job_id
        The job.
    problem
        Why, as the service records it.
    """

    def __init__(self, job_id: str, problem: Problem | None) -> None:
        reason = problem.summary if problem else "the service gives no reason"
        super().__init__(f"job {job_id} failed: {reason}")
        self.job_id = job_id
        self.problem = problem


class JobCancelled(IsomatchError):  # noqa: N818 - said of an event
    """The job was cancelled before it ended."""

    def __init__(self, job_id: str) -> None:
        super().__init__(f"job {job_id} was cancelled")
        self.job_id = job_id


class WaitTimeout(IsomatchError, TimeoutError):  # noqa: N818 - said of an event
    """A job or an upload did not end within the time given; it goes on, and can be waited for."""

    def __init__(self, subject: str, timeout: float) -> None:
        super().__init__(f"{subject} did not end within {timeout:g} s; it goes on")


_BY_STATUS: dict[int, type[ProblemError]] = {
    400: BadRequest,
    401: Unauthorized,
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
    "urn:isomatch:problem:unusable-mesh": UnprocessableShape,
    "urn:isomatch:problem:unusable-prototype": UnprocessablePrototype,
}
"""Where one status means several things."""


def problem_error(problem: Problem, retry_after: float | None = None) -> ProblemError:
    """Return the exception of a problem document, by its type and status.

    What has no class of its own gives the base class, so that a service newer than this client is
    still understood.
    """
    general = ServiceError if problem.status >= 500 else ProblemError
    kind = _BY_TYPE.get(problem.type) or _BY_STATUS.get(problem.status, general)
    return kind(problem, retry_after)
