"""Meshes that commands take: uploads of files, and shapes named by their ids."""

import re
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import typer

from isomatch._cli import render
from isomatch._cli.exit_codes import Failures, leave
from isomatch._clients import Client
from isomatch._errors import (
    TooLarge,
    UnprocessableAttributes,
    UnprocessablePrototype,
    UnprocessableShape,
)
from isomatch._models import Shape

_OF_FILES: Final = (
    UnprocessableAttributes,
    UnprocessablePrototype,
    UnprocessableShape,
    TooLarge,
)
"""Refusals of an uploaded file."""

SLOW_UPLOAD: Final = 8.0
"""Seconds after which a message says that an upload is waiting."""


def uploaded(
    client: Client, sources: list[str], as_json: bool, repairs: bool = True
) -> list[Shape]:
    """Upload files, look up ids, and print the repairs of the shapes.

    Parameters
    ----------
    client
        Of the service.
    sources
        Files and ids.
    as_json
        Print nothing: JSON results contain the repairs.
    repairs
        Print the repairs; False if a result that contains them is printed.

    Raises
    ------
    typer.Exit
        Some cannot be used; all of them are named.
    """
    failures = Failures(as_json)
    found = usable(client, sources, failures, repairs)
    failures.check()
    return [shape for _, shape in found]


def usable(
    client: Client, sources: Sequence[str], failures: Failures, repairs: bool = True
) -> list[tuple[str, Shape]]:
    """Upload files and look up ids as :func:`uploaded` does; return those that can be used.

    Parameters
    ----------
    client, sources, repairs
        As there.
    failures
        Takes the others.

    Raises
    ------
    typer.Exit
        None can be used.
    """
    found = []
    for source in sources:
        with failures.named(source):
            _check_ending(source)
            with named_upload(source, failures.as_json):
                shape = client.upload(source) if Path(source).is_file() else client.shape(source)
            warnings = [f"{shape_name(source, shape)}: {text}" for text in shape.warnings]
            if repairs and not failures.as_json:
                render.print_warnings(warnings, render.standard_error())
            found.append((source, shape))
    if not found:
        failures.check()
    return found


def _check_ending(source: str) -> None:
    if Path(source).is_file() and not Path(source).suffix:
        raise ValueError(
            "the name does not tell the format: upload it with `isomatch upload --file-type off`,"
            " and give its id"
        )


@contextmanager
def named_upload(source: str, as_json: bool, after: float = SLOW_UPLOAD) -> Iterator[None]:
    """Name the file if it is refused, and report an upload that waits, as it does without workers.

    Parameters
    ----------
    source
        Name of the file.
    as_json
        Keep the standard error free of messages besides problem documents.
    after
        Seconds before the report.
    """
    text = (
        f"{source} is not read yet: it is still being sent, or all workers are busy, or none is"
        " running; see /health/ready of the service"
    )
    timer = threading.Timer(after, typer.echo, (text,), {"err": True})
    timer.daemon = True
    if not as_json:
        timer.start()
    try:
        yield
    except _OF_FILES as error:
        leave(error, as_json, "the standard input" if source == "-" else source)
    finally:
        timer.cancel()


def shape_name(source: str, shape: Shape) -> str:
    """Return the name of the given file, or else the name of the shape."""
    return Path(source).name if Path(source).is_file() else shape.name


def class_of(name: str) -> str:
    """Return the class of a shape, as the page does: see ``classOf`` of its ``tasks.js``.

    It is the name up to the first digit, without a separator there, or, without a digit, up to the
    first ``-``, ``_`` or blank.
    """
    stem = Path(name).stem
    end = r"[\s_.-]*[0-9]" if re.search("[0-9]", stem) else r"[\s_-]"
    return re.split(end, stem, maxsplit=1)[0] or stem
