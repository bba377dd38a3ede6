"""What the commands have in common: their options, and how they end.

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
from typing import Annotated, Any, Final, NoReturn, TypeVar

import typer

from isomatch import _render as render
from isomatch._address import URL_VARIABLE
from isomatch._client import Client
from isomatch._dissimilarities import Dissimilarities
from isomatch._errors import (
    ConnectionFailed,
    IsomatchError,
    JobCancelled,
    JobFailed,
    ProblemError,
    UnexpectedResponse,
)
from isomatch._job import Job
from isomatch._match import Match
from isomatch._models import Shape
from isomatch._parameters import StructureChoice, structure_choice
from isomatch._prototype_rendering import print_learned
from isomatch._prototypes import LearnedPrototype

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

_SHAPE_ID = re.compile(r"[0-9a-f]{32}")
_PROTOTYPE_ID = re.compile(r"p-[0-9a-f]{32}")


GivenT = TypeVar("GivenT", str, list[str])


def shapes_given(given: GivenT) -> GivenT:
    """Return what names shapes, files or ids, if it does.

    Raises
    ------
    typer.BadParameter
        One is neither.
    """
    for one in [given] if isinstance(given, str) else given:
        if not Path(one).is_file() and not _SHAPE_ID.fullmatch(one):
            if names_prototype(one):
                raise typer.BadParameter(
                    f"{one!r} is a prototype: only the source of a match can be one"
                )
            raise typer.BadParameter(f"{one!r} is neither a file nor the id of a shape")
    return given


def source_given(given: str) -> str:
    """Return what names the source of a match: as :func:`shapes_given`, or a prototype's id."""
    return given if names_prototype(given) else shapes_given(given)


def names_prototype(given: str) -> bool:
    """Whether something is the id of a prototype, and no file."""
    return _PROTOTYPE_ID.fullmatch(given) is not None and not Path(given).is_file()


def writable(given: Path | None) -> Path | None:
    """Return the name of a file to write, if one can be there: better known before the work."""
    if given is not None and not given.parent.is_dir():
        raise typer.BadParameter(f"there is no folder {str(given.parent)!r}")
    if given is not None and given.is_dir():
        raise typer.BadParameter(f"{str(given)!r} is a folder")
    return given


def picture_given(given: Path | None) -> Path | None:
    """Return the name of a picture to write, as :func:`writable`, if it says what will be in it."""
    if given is not None and given.suffix.lower() != ".png":
        raise typer.BadParameter(f"pictures are PNG files: {given.stem}.png")
    return writable(given)


Url = Annotated[str, typer.Option("--url", envvar=URL_VARIABLE, help="Address of the service.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
FORMATS: Final = "OFF, OBJ, PLY, STL, GLB, GLTF, ZIP with textures"
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print ids and nothing else.")]
Mesh = Annotated[
    str,
    typer.Argument(callback=shapes_given, help=f"A file ({FORMATS}) or a shape's id."),
]
Source = Annotated[
    str,
    typer.Argument(
        callback=source_given,
        help=f"A file ({FORMATS}), a shape's id or that of a prototype.",
    ),
]
Meshes = Annotated[
    list[str],
    typer.Argument(callback=shapes_given, help=f"Files ({FORMATS}) or shapes' ids."),
]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", callback=writable, help="Write the result to this JSON file."),
]
Picture = Annotated[
    Path | None,
    typer.Option(
        "--picture",
        callback=picture_given,
        help="Write a picture of the result to this PNG file.",
    ),
]
Wait = Annotated[
    bool,
    typer.Option(
        "--wait/--no-wait", help="Wait for the result, or print the job's id and leave it to run."
    ),
]


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


def leave(error: Exception, as_json: bool = False) -> NoReturn:
    """Say what went wrong and end the command."""
    message = str(error)
    if isinstance(error, ConnectionFailed):
        message += " (start one with `isomatch serve`, or say where it is with --url)"
    if as_json:
        typer.echo(json.dumps(problem_document(error, message)), err=True)
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


def structure_choices(given: list[str] | None) -> list[StructureChoice]:
    """Return the structures that options name."""
    try:
        return [structure_choice(text) for text in given or ()]
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def landmarks(given: list[str] | None) -> list[tuple[int, int]]:
    try:
        pairs = [tuple(map(int, text.split(":"))) for text in given or ()]
    except ValueError as error:
        raise typer.BadParameter("a landmark is two vertex numbers, as in 17:203") from error
    if any(len(pair) != 2 for pair in pairs):
        raise typer.BadParameter("a landmark is two vertex numbers, as in 17:203")
    return [(pair[0], pair[1]) for pair in pairs]


def run(
    start: Callable[[], Job],
    as_json: bool,
    output: Path | None,
    picture: Path | None,
    names: Mapping[str, str] = MappingProxyType({}),
    wait: bool = True,
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
    """
    job: Job | None = None
    try:
        with interrupts_deferred():
            job = start()
        if wait:
            finish(job, as_json, output, picture, names)
        else:
            typer.echo(job.record.model_dump_json() if as_json else job.id)
    except KeyboardInterrupt:
        if job is not None:
            job.cancel()
            typer.echo(f"job {job.id} cancelled", err=True)
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
) -> None:
    """Wait for a job and print its result."""
    # Who reads JSON reads errors as JSON too: a log of the progress would be in between.
    result = job.result(progress=not as_json or sys.stderr.isatty())
    if output is not None:
        result.save(output)
    if picture is not None:
        job.save_picture(picture)
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
        with slowness_told(source, as_json):
            shape = client.upload(source) if Path(source).is_file() else client.shape(source)
        warnings = [f"{shape_name(source, shape)}: {text}" for text in shape.warnings]
        if not as_json:
            render.print_warnings(warnings, render.standard_error())
        shapes.append(shape)
    return shapes


@contextmanager
def slowness_told(source: str, as_json: bool, after: float = SLOW) -> Iterator[None]:
    """Say after some seconds what an upload waits for: where no worker is, that is for ever.

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
