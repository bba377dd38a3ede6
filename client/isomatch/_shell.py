"""What the commands have in common: their options, and how they end."""

import re
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, MappingProxyType
from typing import Annotated

import typer

from isomatch import _render as render
from isomatch._address import URL_VARIABLE
from isomatch._client import Client
from isomatch._dissimilarities import Dissimilarities
from isomatch._errors import ConnectionFailed, IsomatchError
from isomatch._job import Job
from isomatch._match import Match
from isomatch._models import Shape
from isomatch._parameters import StructureChoice, structure_choice

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""

Url = Annotated[str, typer.Option("--url", envvar=URL_VARIABLE, help="Address of the service.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Mesh = Annotated[
    Path,
    typer.Argument(exists=True, dir_okay=False, readable=True, help="OFF, OBJ, PLY, STL or GLB."),
]
Meshes = Annotated[
    list[Path],
    typer.Argument(exists=True, dir_okay=False, readable=True, help="OFF, OBJ, PLY, STL or GLB."),
]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="Write the result to this JSON file.")
]
Picture = Annotated[
    Path | None, typer.Option("--picture", help="Write a picture of the result to this PNG file.")
]


@contextmanager
def connected(url: str) -> Iterator[Client]:
    """Open a client; say in one line what goes wrong, and leave with exit code 1."""
    try:
        with Client(url) as client:
            yield client
    except ConnectionFailed as error:
        leave(f"{error} (start one with `make serve`, or say where it is with --url)")
    except (IsomatchError, OSError, ValueError) as error:
        leave(str(error))
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


def leave(message: str) -> None:
    typer.echo(f"isomatch: {' '.join(message.split())}", err=True)
    raise typer.Exit(1) from None


def structure_choices(given: list[str] | None) -> list[StructureChoice]:
    try:
        return [structure_choice(text) for text in given or ()]
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def run(
    start: Callable[[], Job],
    as_json: bool,
    output: Path | None,
    picture: Path | None,
    names: Mapping[str, str] = MappingProxyType({}),
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
    """
    job: Job | None = None
    try:
        with interrupts_deferred():
            job = start()
        finish(job, as_json, output, picture, names)
    except KeyboardInterrupt:
        if job is not None:
            job.cancel()
            typer.echo(f"job {job.id} cancelled", err=True)
        raise


def finish(
    job: Job,
    as_json: bool,
    output: Path | None,
    picture: Path | None,
    names: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Wait for a job and print its result."""
    result = job.result(progress=True)
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


def uploaded(client: Client, paths: list[Path]) -> list[Shape]:
    """Upload meshes and say what was repaired of them."""
    shapes = []
    for path in paths:
        shape = client.upload(path)
        warnings = [f"{path.name}: {text}" for text in shape.warnings]
        render.print_warnings(warnings, render.standard_error())
        shapes.append(shape)
    return shapes


def class_of(mesh: Path) -> str:
    """Class of a mesh: its file's name up to the first digit."""
    return re.split(r"\d", mesh.stem, maxsplit=1)[0] or mesh.stem
