"""Connection to the service, and the exit codes and messages of its errors."""

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Final, NoReturn
from urllib.parse import urlsplit

import typer

from isomatch._cli.usage_errors import running_options
from isomatch._clients import Client
from isomatch._errors import (
    ConnectionFailed,
    InvalidRequest,
    IsomatchError,
    JobCancelled,
    JobFailed,
    NotFound,
    ProblemError,
    ServiceError,
    Unauthorized,
    UnexpectedResponse,
)

REFUSED: Final = 1
WRONG_USAGE: Final = 2
NO_SERVICE: Final = 3
NO_RESULT: Final = 4
INTERRUPTED: Final = 130

EXIT_CODES: Final = (
    "Exit codes: 0 done, 1 refused or not possible, 2 wrong usage or value of an option, "
    "3 no service answers, 4 the job ended without a result, 130 interrupted. With --json the "
    "standard output is JSON and nothing else, and an error is a problem document (RFC 9457) on "
    "the standard error."
)


@contextmanager
def connected(url: str, as_json: bool = False) -> Iterator[Client]:
    """Open a client; report errors in one line or as JSON, and exit with their code."""
    try:
        with Client(url) as client:
            yield client
    except BrokenPipeError:
        raise  # the reader of the output has closed it; typer exits quietly
    except (IsomatchError, OSError, ValueError) as error:
        leave(error, as_json, url=url)
    except KeyboardInterrupt as interrupt:
        _report_interrupt(str(interrupt), as_json)
        raise typer.Exit(INTERRUPTED) from None


def _report_interrupt(consequence: str, as_json: bool) -> None:
    """Report that Ctrl-C ended the command, and what became of its job, if it had one."""
    document = {
        "type": "urn:isomatch:client:interrupted",
        "title": "Interrupted",
        "detail": consequence or "interrupted",
    }
    report(document, "\n".join([*filter(None, [consequence]), "interrupted"]), as_json)


def report(document: Mapping[str, object], text: str, as_json: bool) -> None:
    """Print an error on the standard error, as a problem document or as text."""
    typer.echo(json.dumps(document) if as_json else text, err=True)


class Left(typer.Exit):
    """An exit after an error was reported.

    Parameters
    ----------
    code
        Exit code.
    reason
        The message, without the file it concerns.
    """

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(code)
        self.reason = reason


def leave(
    error: Exception, as_json: bool = False, file: str | None = None, url: str = ""
) -> NoReturn:
    """Report an error, with the file it concerns and advice on the address, and exit."""
    message = _reason(error) if file is None else f"{file}: {_reason(error, file)}"
    if isinstance(error, InvalidRequest) and not as_json:
        message = by_options(error)
    ended = isinstance(error, JobFailed | JobCancelled)
    if isinstance(error, IsomatchError) and error.job_id is not None and not ended:
        message += f"; get its result with `isomatch jobs result {error.job_id}`"
    if isinstance(error, ConnectionFailed):
        message += " (start a service with `isomatch serve`, or give its address with --url)"
    if isinstance(error, Unauthorized):
        message += " (set the environment variable ISOMATCH_API_KEY)"
    if (path := urlsplit(url).path.strip("/")) and _is_elsewhere(error):
        message += f" (is /{path} part of the address? --url is that of the service alone)"
    named = {} if file is None else {"file": file}
    text = f"isomatch: {' '.join(message.split())}"
    report(problem_document(error, message) | named, text, as_json)
    code = REFUSED
    if no_service(error):
        code = NO_SERVICE
    elif isinstance(error, JobFailed | JobCancelled):
        code = NO_RESULT
    elif refuses_option(error):
        code = WRONG_USAGE
    raise Left(code, _reason(error, file)) from None


def no_service(error: Exception) -> bool:
    """Return whether no service answers, or none that is behind the proxy at the address."""
    behind = isinstance(error, ServiceError) and error.status in (502, 504)
    return behind or isinstance(error, ConnectionFailed | UnexpectedResponse)


def _is_elsewhere(error: Exception) -> bool:
    """Return whether there is no API at the address."""
    absent = isinstance(error, NotFound) and error.type == "urn:isomatch:problem:not-found"
    return absent or isinstance(error, UnexpectedResponse)


def _reason(error: Exception, file: str | None = None) -> str:
    """Say what is wrong, without the number of an error of the system, and with its file once."""
    if not isinstance(error, OSError) or error.strerror is None:
        return str(error)
    named = error.filename is not None and str(error.filename) != file
    return f"{error.filename}: {error.strerror}" if named else error.strerror


@dataclass(frozen=True)
class Failures:
    """What of a collection has failed, while the others go on.

    Attributes
    ----------
    as_json
        Report errors as JSON.
    reasons
        Why, by their names as they were given.
    """

    as_json: bool
    reasons: dict[str, str] = field(default_factory=dict)

    @contextmanager
    def named(self, name: str) -> Iterator[None]:
        """Report what fails, with its name.

        Without a service, or with a wrong option, nothing can succeed.
        """
        try:
            try:
                yield
            except (Unauthorized, BrokenPipeError):
                raise
            except (IsomatchError, OSError, ValueError) as error:
                if no_service(error) or refuses_option(error):
                    raise
                leave(error, self.as_json, name)
        except Left as left:
            self.reasons[name] = left.reason

    def check(self) -> None:
        """Exit if anything has failed."""
        if self.reasons:
            raise Left(REFUSED, "; ".join(self.reasons.values()))


def refuses_option(error: Exception) -> bool:
    """Return whether the service refuses values of options, and nothing else."""
    return (
        isinstance(error, InvalidRequest)
        and bool(error.errors)
        and all(_option(one.field) != one.field for one in error.errors)
    )


def by_options(error: InvalidRequest) -> str:
    """Return the message of a refused request, with the options of the command for its fields."""
    named = tuple(one.model_copy(update={"field": _option(one.field)}) for one in error.errors)
    return error.problem.model_copy(update={"errors": named}).summary


def _option(field: str) -> str:
    """Return the option for a field of a request, as ``--landmark (0.1)``; else the field."""
    name, _, rest = field.removeprefix("body.").removeprefix("query.").partition(".")
    flag = "--" + name.replace("_", "-")
    # Options of lists may be given once for each entry.
    for known in running_options() & {flag, flag.removesuffix("s")}:
        return f"{known} ({rest})" if rest else known
    return field


def problem_document(error: Exception, message: str) -> dict[str, Any]:
    """Return an error as a problem document; that of the service if it has one."""
    if isinstance(error, ProblemError | JobFailed) and error.problem is not None:
        return error.problem.model_dump(mode="json", exclude_none=True)
    # "OSError" is "OS error".
    first, *others = re.findall(r"[A-Z]+(?![a-z])|[A-Z][a-z]+", type(error).__name__)
    return {
        "type": "urn:isomatch:client:" + "-".join((first, *others)).lower(),
        "title": " ".join((first, *map(str.lower, others))),
        "detail": message,
    }
