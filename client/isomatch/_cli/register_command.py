"""``isomatch register``: a template registered to specimens."""

import json
from pathlib import Path
from typing import Annotated

import typer

from isomatch._cli import render
from isomatch._cli.exit_codes import REFUSED, Failures, connected
from isomatch._cli.job_runs import cancelled_by_interrupt, result_stays
from isomatch._cli.options import AsJson, Mesh, Meshes, Url, Wait
from isomatch._cli.output_files import files_given, output_folder_given
from isomatch._cli.registration_rendering import print_registration
from isomatch._cli.uploads import shape_name, uploaded, usable
from isomatch._clients import Job
from isomatch._http import DEFAULT_URL
from isomatch._results import Registration

PICTURE = "components.png"
ARRAYS = "components.npz"
SCORES = "scores.csv"


def register(
    template: Mesh,
    specimens: Meshes,
    folder: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder of the files, made if missing; required unless with --no-wait.",
        ),
    ] = None,
    scale: Annotated[
        bool, typer.Option("--scale", help="Scale the specimens to a common size for the mean.")
    ] = False,
    largest_component: Annotated[
        bool, typer.Option("--largest-component", help="Take the largest of several components.")
    ] = False,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Register a template to specimens: its vertices and triangles on the surface of each.

    The folder gets a PLY file for each specimen, in its own coordinates, mean.ply, components.npz,
    scores.csv and a picture of the components. A specimen that cannot be registered is named.
    """
    inputs = [template, *specimens]
    files = [Path(one).stem for one in specimens if Path(one).is_file()]
    if folder is None and wait:
        raise typer.BadParameter("name a folder, or use --no-wait", param_hint="--output")
    if folder is not None and not wait:
        raise typer.BadParameter(
            "with --no-wait there is no result to write; leave it out, and use `isomatch jobs"
            " result ID --output components.npz --registered NAME.ply --specimen N` later",
            param_hint="--output",
        )
    if folder is not None:
        files_given(output_folder_given(folder), _files(files), inputs)
    with connected(url, as_json) as client:
        (source,) = uploaded(client, [template], as_json)
        failures = Failures(as_json)
        given = usable(client, specimens, failures)
        shapes = [shape for _, shape in given]
        names = [Path(shape_name(*one)).stem for one in given]
        if folder is not None:
            _check_names(names)
            # Names of shapes that were given by their ids are known by now.
            files_given(folder, _files(names), inputs)

        def start() -> Job[Registration]:
            return client.register(source, shapes, scale=scale, largest_component=largest_component)

        found: Registration | None = None
        with cancelled_by_interrupt(start, client.base_url, as_json) as job:
            if folder is None:
                typer.echo(job.record.model_dump_json() if as_json else job.id)
            else:
                found = _finish(job, folder, names, failures)
        failures.check()
        if found is not None and not all(one.registered for one in found.specimens):
            raise typer.Exit(REFUSED)


def _finish(
    job: Job[Registration], folder: Path, names: list[str], failures: Failures
) -> Registration:
    """Wait for a registration, write its files, and print it with the uploads that failed."""
    found = job.result(progress=not failures.as_json)
    with result_stays(job, failures.as_json):
        found.save_meshes(folder, names)
        job.save_picture(folder / PICTURE)
    if not failures.as_json:
        print_registration(found, render.standard_output(), failures.reasons)
    elif failures.reasons:
        failed = [{"file": name, "detail": why} for name, why in failures.reasons.items()]
        typer.echo(json.dumps(json.loads(found.to_json()) | {"failures": failed}))
    else:
        typer.echo(found.to_json())
    return found


def _files(names: list[str]) -> list[str]:
    """Names of the files that are written for specimens with these names."""
    return [PICTURE, ARRAYS, SCORES, *(f"{name}.ply" for name in ("mean", *names))]


def _check_names(names: list[str]) -> None:
    taken = ["mean", *names]
    if len(set(taken)) < len(taken):
        twice = next(name for name in taken if taken.count(name) > 1)
        raise typer.BadParameter(f"two files would be called {twice!r}", param_hint="SPECIMENS")
