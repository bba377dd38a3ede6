"""``isomatch jobs``: all jobs of the service."""

from pathlib import Path
from typing import Annotated, Final, Literal, TypeAlias

import typer

from isomatch._cli import render
from isomatch._cli.exit_codes import EXIT_CODES, NO_RESULT, Failures, connected
from isomatch._cli.job_runs import echo_models, finish, job_continues, job_given, print_listing
from isomatch._cli.options import (
    OUTPUT,
    AsJson,
    Limit,
    Output,
    Picture,
    Quiet,
    SeenFrom,
    Url,
    WhichPicture,
    id_given,
)
from isomatch._cli.output_files import registered_given
from isomatch._cli.usage_errors import Commands
from isomatch._http import DEFAULT_URL
from isomatch._models import JobState

JobId = Annotated[
    str, typer.Argument(help="Id of the job, or its beginning, of eight digits or more.")
]
JobIds = Annotated[list[str], typer.Argument(help="Ids of jobs, or their beginnings.")]

Registered = Annotated[
    Path | None,
    typer.Option(
        "--registered",
        callback=registered_given,
        help="Write the source of a dense match on its target, or the template of a registration on"
        " a specimen, to this PLY, OBJ or GLB file.",
        rich_help_panel=OUTPUT,
    ),
]
Specimen = Annotated[
    int | None,
    typer.Option(
        "--specimen",
        min=0,
        help="Specimen of a registration that --registered writes, counted from 0.",
        rich_help_panel=OUTPUT,
    ),
]

JobKind: TypeAlias = Literal[
    "match",
    "batch",
    "dissimilarities",
    "prototype",
    "transfer",
    "registration",
    "consistent_maps",
]

_AFTER_CANCEL: Final[dict[JobState, str]] = {
    "queued": "is queued",
    "running": "is being cancelled",
    "cancelled": "is cancelled",
    "succeeded": "has succeeded already",
    "failed": "has failed already",
}

jobs = typer.Typer(
    name="jobs",
    cls=Commands,
    help="List, show, follow and cancel jobs, and fetch or delete their results.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
)


@jobs.command("list")
def list_jobs(
    state: Annotated[
        JobState | None,
        typer.Option(
            "--state",
            metavar="STATE",
            help="Only jobs in this state: queued, running, succeeded, failed or cancelled.",
        ),
    ] = None,
    kind: Annotated[
        JobKind | None,
        typer.Option(
            "--kind",
            metavar="KIND",
            help="Only jobs of this kind: match, batch, dissimilarities, prototype, transfer,"
            " registration or consistent_maps.",
        ),
    ] = None,
    of: Annotated[
        str | None,
        typer.Option(callback=id_given, help="Only jobs of the shape or prototype with this id."),
    ] = None,
    limit: Limit = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    url: Url = DEFAULT_URL,
) -> None:
    """List the jobs, newest first."""
    with connected(url, as_json) as client:
        found = (job.record for job in client.jobs(state, kind=kind, of=of))
        print_listing(found, as_json, quiet, render.print_jobs, limit)


@jobs.command()
def show(job_id: JobId, as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """Show the record of a job."""
    with connected(url, as_json) as client:
        record = job_given(client, job_id).record
        if as_json:
            typer.echo(record.model_dump_json())
        else:
            render.print_job(record, render.standard_output())


@jobs.command()
def follow(job_id: JobId, as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """Print a line at each change of a job, until it has ended; Ctrl-C does not cancel the job.

    With --json every line is a JSON document.
    """
    with connected(url, as_json) as client:
        job = job_given(client, job_id)
        with job_continues(job):
            for record in job.events():
                typer.echo(record.model_dump_json() if as_json else render.event_line(record))
        if job.state != "succeeded":
            raise typer.Exit(NO_RESULT)


@jobs.command()
def result(
    job_id: JobId,
    as_json: AsJson = False,
    output: Output = None,
    picture: Picture = None,
    alternative: WhichPicture = None,
    view: SeenFrom = None,
    registered: Registered = None,
    specimen: Specimen = None,
    url: Url = DEFAULT_URL,
) -> None:
    """Print the result of a job when it has ended; Ctrl-C does not cancel the job."""
    needed = (
        ("--alternative", alternative, "--picture", picture),
        ("--view", view, "--picture", picture),
        ("--specimen", specimen, "--registered", registered),
    )
    for option, given, other, file in needed:
        if given is not None and file is None:
            raise typer.BadParameter(f"it needs {other} FILE", param_hint=option)
    with connected(url, as_json) as client:
        job = job_given(client, job_id)
        with job_continues(job):
            finish(job, as_json, output, picture, alternative=alternative, view=view)
            if registered is not None:
                job.save_registered(registered, specimen or 0)


@jobs.command()
def cancel(job_ids: JobIds, as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """Cancel queued and running jobs; jobs that have ended stay as they are."""
    with connected(url, as_json) as client:
        records, failures = [], Failures(as_json)
        for job_id in job_ids:
            with failures.named(job_id):
                job = job_given(client, job_id).cancel()
                records.append(job.record.model_dump_json())
                if not as_json:
                    typer.echo(f"job {job.id} {_AFTER_CANCEL.get(job.state, job.state)}", err=True)
        if as_json:
            echo_models(records)
        failures.check()


@jobs.command()
def delete(job_ids: JobIds, url: Url = DEFAULT_URL) -> None:
    """Delete the results of jobs that have ended; the records of the jobs stay."""
    with connected(url) as client:
        failures = Failures(as_json=False)
        for job_id in job_ids:
            with failures.named(job_id):
                job = job_given(client, job_id)
                job.delete_result()
                typer.echo(f"the result of job {job.id} is deleted", err=True)
        failures.check()
