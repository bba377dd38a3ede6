"""Jobs that commands start: waiting, interruption and the output of results."""

import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from types import FrameType
from typing import Any, Final, TypeVar

import typer
from rich.console import Console

from isomatch._cli import render
from isomatch._cli.maps_rendering import print_maps
from isomatch._cli.prototype_rendering import print_learned
from isomatch._cli.registration_rendering import print_registration
from isomatch._clients import Client, Job
from isomatch._errors import IsomatchError, NotFound
from isomatch._models import JobRecord, Shape, begins_job_id
from isomatch._operations.results import View
from isomatch._progress import ID_SHOWN
from isomatch._results import (
    Batch,
    ConsistentMaps,
    Dissimilarities,
    LearnedPrototype,
    Match,
    Prototype,
    Registration,
    Result,
    Transfer,
)

RecordT = TypeVar("RecordT", JobRecord, Shape, Prototype)


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Defer a first Ctrl-C until the id of the job is known, so that it can be cancelled."""
    interrupted = False

    def defer(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        if interrupted:
            raise KeyboardInterrupt
        interrupted = True

    before = signal.signal(signal.SIGINT, defer)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if interrupted:
        raise KeyboardInterrupt


@contextmanager
def cancelled_by_interrupt(
    start: Callable[[], Job], page: str | None, as_json: bool
) -> Iterator[Job]:
    """Start a job, cancel it on Ctrl-C, and print in the end where it is on the page.

    Parameters
    ----------
    start
        Function that starts the job.
    page
        Address of the service; None to print no link.
    as_json
        Keep the standard error free of messages.

    Raises
    ------
    KeyboardInterrupt
        It was interrupted; the message says what became of the job.
    """
    job: Job | None = None
    try:
        with interrupts_deferred():
            job = start()
        yield job
        if page is not None:
            echo_link(page, job.id, as_json)
    except KeyboardInterrupt:
        if job is not None:
            state = job.cancel().state
            ended = f"has {state} already" if state in ("succeeded", "failed") else "cancelled"
            raise KeyboardInterrupt(f"job {job.id} {ended}") from None
        raise


def echo_link(page: str, job_id: str, as_json: bool) -> None:
    """Print where a job is on the page, unless the standard error is kept free of messages."""
    if not as_json:
        typer.echo(f"in a browser: {page.rstrip('/')}/#job={job_id}", err=True)


def run(
    start: Callable[[], Job],
    as_json: bool,
    output: Path | None,
    picture: Path | None,
    wait: bool = True,
    page: str | None = None,
    view: View | None = None,
) -> None:
    """Start a job and print its result; cancel the job on Ctrl-C.

    Parameters
    ----------
    start
        Function that starts the job.
    as_json, output, picture
        Output of the result: as JSON, to a file, as a picture.
    wait
        Wait for the result; if False, print the job's id, or its record as JSON.
    page
        Address of the service, for a link to the job on its page.
    view
        Side from which the picture shows a match.
    """
    with cancelled_by_interrupt(start, page, as_json) as job:
        if wait:
            finish(job, as_json, output, picture, view=view)
        else:
            typer.echo(job.record.model_dump_json() if as_json else job.id)


def job_given(client: Client, given: str) -> Job:
    """Return a job by its id, or by the beginning of its id, as progress shows it.

    A match of a batch is named by the beginning of the batch's id and its own number.

    Raises
    ------
    NotFound
        There is no such job.
    ValueError
        Several ids begin like this.
    """
    try:
        return client.job(given)
    except NotFound as error:
        if not begins_job_id(given):
            raise
        beginning, dash, number = given.partition("-")
        known = client.jobs() if len(beginning) >= ID_SHOWN else ()
        found = [job for job in known if job.id.startswith(beginning)]
        if not found:
            error.extend(f", of which commands take the first {ID_SHOWN} or more")
            raise
        if len(found) > 1:
            ids = ", ".join(job.id for job in found)
            raise ValueError(f"several jobs begin with {beginning!r}: {ids}") from None
        return client.job(f"{found[0].id}{dash}{number}") if dash else found[0]


@contextmanager
def result_stays(job: Job, as_json: bool) -> Iterator[None]:
    """Print where the result of a job that has succeeded is, if it cannot be written."""
    try:
        yield
    except (IsomatchError, OSError, ValueError):
        # With --json the standard error has the problem document alone.
        if job.state == "succeeded" and not as_json:
            typer.echo(
                f"job {job.id} has succeeded; `isomatch jobs result {job.id}` has its result",
                err=True,
            )
        raise


@contextmanager
def job_continues(job: Job) -> Iterator[None]:
    """Say on Ctrl-C that the job continues, and the command that cancels it."""
    try:
        yield
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"job {job.id} continues; cancel it with `isomatch jobs cancel {job.id}`"
        ) from None


def finish(
    job: Job,
    as_json: bool,
    output: Path | None,
    picture: Path | None,
    alternative: int | None = None,
    view: View | None = None,
) -> None:
    """Wait for a job and print its result."""
    # With --json the standard error holds problem documents, without progress between them.
    result = job.result(progress=not as_json or sys.stderr.isatty())
    with result_stays(job, as_json):
        if output is not None:
            held = result.held(output.suffix.lower().removeprefix(".") or "json")
            if held is None:
                job.save(output)
            else:
                output.write_bytes(held)
        if picture is not None:
            job.save_picture(picture, alternative=alternative, view=view)
    if as_json:
        typer.echo(result.to_json())
    else:
        _PRINTED[type(result)](result, render.standard_output())


_PRINTED: Final[Mapping[type[Result], Callable[[Any, Console], None]]] = {
    Match: render.print_match,
    Batch: render.print_batch,
    Dissimilarities: render.print_dissimilarities,
    Transfer: render.print_transfer,
    Registration: print_registration,
    ConsistentMaps: print_maps,
    LearnedPrototype: print_learned,
}


def echo_models(documents: Iterable[str]) -> None:
    """Print JSON documents as a list."""
    typer.echo("[" + ",\n".join(documents) + "]")


def print_listing(
    found: Iterable[RecordT],
    as_json: bool,
    quiet: bool,
    table: Callable[[Iterable[RecordT], Console], None],
    limit: int | None,
) -> None:
    """Print records, at most `limit` of them, as JSON, as ids, or as a table."""
    found = islice(found, limit)
    if as_json:
        echo_models(one.model_dump_json() for one in found)
    elif quiet:
        for one in found:
            typer.echo(one.id)
    else:
        table(found, render.standard_output())
