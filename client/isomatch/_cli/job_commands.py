"""``isomatch jobs``: jobs of the service, whoever asked for them."""

from typing import Annotated, Final, cast

import typer

from isomatch._cli import render
from isomatch._cli.options import AsJson, Output, Picture, Quiet, Url, WhichPicture, id_given
from isomatch._cli.shell import (
    EXIT_CODES,
    NO_RESULT,
    connected,
    echo_models,
    finish,
    job_left_alone,
)
from isomatch._http import DEFAULT_URL
from isomatch._models import JobState

JobId = Annotated[str, typer.Argument(help="Id of the job.")]
JobIds = Annotated[list[str], typer.Argument(help="Ids of jobs.")]

_LEFT: Final[dict[JobState, str]] = {
    "queued": "is queued",
    "running": "ends as soon as it can",
    "cancelled": "is cancelled",
    "succeeded": "has succeeded already",
    "failed": "has failed already",
}

jobs = typer.Typer(
    name="jobs",
    help="List, show, follow and cancel jobs, and fetch their results.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
)


@jobs.command("list")
def list_jobs(
    state: Annotated[
        str | None, typer.Option(help="queued, running, succeeded, failed or cancelled.")
    ] = None,
    kind: Annotated[str | None, typer.Option(help="match, dissimilarities or prototype.")] = None,
    of: Annotated[
        str | None,
        typer.Option(callback=id_given, help="Id of a shape or a prototype: only jobs of it."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    url: Url = DEFAULT_URL,
) -> None:
    """List the jobs, newest first."""
    with connected(url, as_json) as client:
        found = client.jobs(cast(JobState | None, state), kind=kind, of=of)
        if as_json:
            echo_models(job.record.model_dump_json() for job in found)
        elif quiet:
            for job in found:
                typer.echo(job.id)
        else:
            render.print_jobs(found, render.standard_output())


@jobs.command()
def show(job_id: JobId, as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """Show what is known of a job."""
    with connected(url, as_json) as client:
        record = client.job(job_id).record
        if as_json:
            typer.echo(record.model_dump_json())
        else:
            render.print_job(record, render.standard_output())


@jobs.command()
def follow(job_id: JobId, as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """Print a line each time a job changes, until it has ended; Ctrl-C leaves the job alone.

    With --json every line is a JSON document.
    """
    with connected(url, as_json) as client:
        job = client.job(job_id)
        with job_left_alone(job):
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
    url: Url = DEFAULT_URL,
) -> None:
    """Print the result of a job, waiting for it if need be; Ctrl-C leaves the job alone."""
    if alternative is not None and picture is None:
        raise typer.BadParameter("it says what --picture FILE draws", param_hint="--alternative")
    with connected(url, as_json) as client:
        job = client.job(job_id)
        with job_left_alone(job):
            finish(job, as_json, output, picture, alternative=alternative)


@jobs.command()
def cancel(job_ids: JobIds, as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """Cancel jobs, whether queued or running; what has ended stays as it is."""
    with connected(url, as_json) as client:
        records = []
        for job_id in job_ids:
            job = client.job(job_id).cancel()
            records.append(job.record.model_dump_json())
            if not as_json:
                typer.echo(f"job {job.id} {_LEFT[job.state]}", err=True)
        if as_json:
            echo_models(records)
