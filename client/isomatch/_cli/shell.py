"""What the commands have in common: how they ask, wait and end.

Exit codes: 0 done, 1 refused or not possible, 2 wrong usage, 3 no service answers, 4 the job ended
without a result, 130 interrupted.
"""

import json
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, MappingProxyType
from typing import Any, Final, NoReturn

import typer

from isomatch._cli import render
from isomatch._cli.prototype_rendering import print_learned
from isomatch._clients import Client, Job
from isomatch._errors import (
    ConnectionFailed,
    IsomatchError,
    JobCancelled,
    JobFailed,
    ProblemError,
    TooLarge,
    Unauthorized,
    UnexpectedResponse,
    UnprocessableShape,
)
from isomatch._models import Shape
from isomatch._results import Dissimilarities, LearnedPrototype, Match

REFUSED: Final = 1
NO_SERVICE: Final = 3
NO_RESULT: Final = 4
INTERRUPTED: Final = 130

SLOW: Final = 8.0
"""Seconds after which an upload that waits is spoken of."""

EXIT_CODES: Final = (
    "Exit codes: 0 done, 1 refused or not possible, 2 wrong usage, 3 no service answers, "
    "4 the job ended without a result, 130 interrupted. With --json the standard output is JSON "
    "and nothing else, and an error is a problem document (RFC 9457) on the standard error."
)


@contextmanager
def connected(url: str, as_json: bool = False) -> Iterator[Client]:
    """Open a client; say what goes wrong, in one line or as JSON, and leave with its exit code."""
    try:
        with Client(url) as client:
            yield client
    except BrokenPipeError:
        raise  # whoever read the output has enough; typer ends it quietly
    except (IsomatchError, OSError, ValueError) as error:
        leave(error, as_json)
    except KeyboardInterrupt:
        typer.echo("interrupted", err=True)
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Hold a first Ctrl-C back until the end: a job whose id is not known cannot be cancelled."""
    interrupted = False

    def hold_back(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        if interrupted:
            raise KeyboardInterrupt
        interrupted = True

    before = signal.signal(signal.SIGINT, hold_back)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if interrupted:
        raise KeyboardInterrupt


def leave(error: Exception, as_json: bool = False, file: str | None = None) -> NoReturn:
    """Say what went wrong, and of which file, and end the command."""
    message = str(error) if file is None else f"{file}: {error}"
    if isinstance(error, ConnectionFailed):
        message += " (start one with `isomatch serve`, or say where it is with --url)"
    if isinstance(error, Unauthorized):
        message += " (commands take it from the environment, ISOMATCH_API_KEY)"
    if as_json:
        document = problem_document(error, message)
        named = {} if file is None else {"file": file}
        typer.echo(json.dumps(document | named), err=True)
    else:
        typer.echo(f"isomatch: {' '.join(message.split())}", err=True)
    code = REFUSED
    if isinstance(error, ConnectionFailed | UnexpectedResponse):
        code = NO_SERVICE
    elif isinstance(error, JobFailed | JobCancelled):
        code = NO_RESULT
    raise typer.Exit(code) from None


def problem_document(error: Exception, message: str) -> dict[str, Any]:
    """Return an error as a problem document: the service's own, if it is one of the service."""
    if isinstance(error, ProblemError | JobFailed) and error.problem is not None:
        return error.problem.model_dump(mode="json", exclude_none=True)
    words = re.findall(r"[A-Z]+[a-z]*", type(error).__name__)
    return {
        "type": "urn:isomatch:client:" + "-".join(words).lower(),
        "title": " ".join(words).capitalize(),
        "detail": message,
    }


def run(
    start: Callable[[], Job],
    as_json: bool,
    output: Path | None,
    picture: Path | None,
    names: Mapping[str, str] = MappingProxyType({}),
    wait: bool = True,
    page: str | None = None,
) -> None:
    """Start a job and print its result; cancel it if the user interrupts.

    Parameters
    ----------
    start
        Asks for the job.
    as_json, output, picture
        In which form the result is wanted.
    names
        What the shapes are called, by their ids.
    wait
        Whether to wait for the result at all; otherwise the job's id is printed, or its record.
    page
        Address of the service, whose page shows the job: readers are told of it.
    """
    job: Job | None = None
    try:
        with interrupts_deferred():
            job = start()
        if wait:
            finish(job, as_json, output, picture, names)
        else:
            typer.echo(job.record.model_dump_json() if as_json else job.id)
        if page is not None and not as_json:
            typer.echo(f"in a browser: {page.rstrip('/')}/#job={job.id}", err=True)
    except KeyboardInterrupt:
        if job is not None:
            state = job.cancel().state
            ended = state in ("succeeded", "failed")
            typer.echo(f"job {job.id} {f'has {state} already' if ended else 'cancelled'}", err=True)
        raise


@contextmanager
def job_left_alone(job: Job) -> Iterator[None]:
    """Say on Ctrl-C that the job goes on without this command."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"job {job.id} goes on; `isomatch jobs cancel {job.id}` cancels it", err=True)
        raise


def finish(
    job: Job,
    as_json: bool,
    output: Path | None,
    picture: Path | None,
    names: Mapping[str, str] = MappingProxyType({}),
    alternative: int | None = None,
) -> None:
    """Wait for a job and print its result."""
    # Who reads JSON reads errors as JSON too: a log of the progress would be in between.
    result = job.result(progress=not as_json or sys.stderr.isatty())
    if output is not None:
        result.save(output)
    if picture is not None:
        job.save_picture(picture, alternative=alternative)
    if as_json:
        typer.echo(result.to_json())
    elif isinstance(result, Match):
        render.print_match(result, render.standard_output())
    elif isinstance(result, Dissimilarities):
        render.print_dissimilarities(result, names, render.standard_output())
    elif isinstance(result, LearnedPrototype):
        print_learned(result, render.standard_output())


def uploaded(client: Client, sources: list[str], as_json: bool) -> list[Shape]:
    """Upload what are files, look up what are ids, and say what was repaired of them.

    Results say it too, so that those who read JSON are told once.
    """
    shapes = []
    for source in sources:
        with named_upload(source, as_json):
            shape = client.upload(source) if Path(source).is_file() else client.shape(source)
        warnings = [f"{shape_name(source, shape)}: {text}" for text in shape.warnings]
        if not as_json:
            render.print_warnings(warnings, render.standard_error())
        shapes.append(shape)
    return shapes


@contextmanager
def named_upload(source: str, as_json: bool, after: float = SLOW) -> Iterator[None]:
    """Say which file of several is refused, and after some seconds what an upload waits for.

    Where no worker is, it waits for ever.

    Parameters
    ----------
    source
        What is uploaded.
    as_json
        Whether nothing may be on the standard error but problems.
    after
        Seconds.
    """
    text = (
        f"{source} waits to be read: the service's workers are busy, or there are none;"
        " its /health/ready says which"
    )
    timer = threading.Timer(after, typer.echo, (text,), {"err": True})
    timer.daemon = True
    if not as_json:
        timer.start()
    try:
        yield
    except (UnprocessableShape, TooLarge) as error:
        leave(error, as_json, "the standard input" if source == "-" else source)
    finally:
        timer.cancel()


def shape_name(source: str, shape: Shape) -> str:
    """Return what a user calls a shape: the name of the file that was given, or else its own."""
    return Path(source).name if Path(source).is_file() else shape.name


def class_of(name: str) -> str:
    """Class of a shape: its name up to the first digit."""
    stem = Path(name).stem
    return re.split(r"\d", stem, maxsplit=1)[0] or stem


def echo_models(documents: Iterable[str]) -> None:
    """Print JSON documents as a list."""
    typer.echo("[" + ",\n".join(documents) + "]")
