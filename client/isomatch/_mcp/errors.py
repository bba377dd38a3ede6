"""Errors of the SDK as errors of tools, which say what to do."""

from collections.abc import Iterator
from contextlib import contextmanager

from mcp.server.mcpserver.exceptions import ToolError

from isomatch._errors import (
    ConnectionFailed,
    Gone,
    IsomatchError,
    JobFailed,
    NotFound,
    ProblemError,
    TooManyRequests,
    Unauthorized,
    UnexpectedResponse,
    UnknownShape,
)


@contextmanager
def tool_errors() -> Iterator[None]:
    """Raise errors of the SDK, and of files, as :class:`ToolError`; others are faults of ours."""
    try:
        yield
    except (IsomatchError, OSError, ValueError, TypeError) as error:
        raise ToolError(message(error)) from error


def message(error: Exception) -> str:
    """Return the message of an error: what is wrong, the paths of the fields, and what to do."""
    lines = [str(error)]
    if isinstance(error, ProblemError):
        # Below it are the fields that the document's `errors` names.
        lines[0] = (error.detail or error.title).partition("; `errors` says")[0]
    if isinstance(error, ProblemError | JobFailed) and error.problem is not None:
        lines += [f"{wrong.field}: {wrong.message}" for wrong in error.problem.errors]
    advice = _advice(error)
    return "\n".join([*lines, *([advice] if advice else [])])


def _advice(error: Exception) -> str | None:
    if isinstance(error, ConnectionFailed | UnexpectedResponse):
        return (
            "No isomatch service answers there. The user can start one with `isomatch serve`, or"
            " give its address as ISOMATCH_URL or `isomatch mcp --url`."
        )
    if isinstance(error, Unauthorized):
        return "The user has to set ISOMATCH_API_KEY in the environment of `isomatch mcp`."
    if isinstance(error, TooManyRequests):
        seconds = 30.0 if error.retry_after is None else error.retry_after
        return f"Try again in {seconds:.0f} s."
    if isinstance(error, UnknownShape | NotFound | Gone):
        return "Upload the files again, or start the job again; ids expire."
    return None
