"""``isomatch upload``: meshes sent to the service."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from isomatch._cli import render
from isomatch._cli.exit_codes import Failures, connected
from isomatch._cli.job_runs import echo_models
from isomatch._cli.options import FORMATS, AsJson, Quiet, Url
from isomatch._cli.uploads import named_upload
from isomatch._http import DEFAULT_URL


def upload(
    meshes: Annotated[
        list[str],
        typer.Argument(help=f"Files ({FORMATS}); - is the standard input."),
    ],
    file_type: Annotated[
        str | None, typer.Option(help="Format, where the file's name does not tell: off, ply, ...")
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Name of a single file, instead of its own.")
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    url: Url = DEFAULT_URL,
) -> None:
    """Upload meshes; the same file again costs nothing. One that cannot be read is named."""
    if name is not None and len(meshes) > 1:
        raise typer.BadParameter("several files would have one name", param_hint="--name")
    there = [mesh for mesh in meshes if mesh == "-" or Path(mesh).is_file()]
    nameless = [mesh for mesh in there if not Path(mesh).suffix]
    if file_type is None and nameless:
        message = "the name does not tell the format; give it, as in --file-type off"
        raise typer.BadParameter(f"{', '.join(nameless)}: {message}", param_hint="MESHES")
    with connected(url, as_json) as client:
        shapes, failures = [], Failures(as_json)
        for mesh in meshes:
            with failures.named(mesh), named_upload(mesh, as_json):
                data = sys.stdin.buffer.read() if mesh == "-" else mesh
                shapes.append(client.upload(data, name, file_type=file_type))
        if as_json:
            echo_models(shape.model_dump_json() for shape in shapes)
        elif quiet:
            for shape in shapes:
                typer.echo(shape.id)
        elif shapes:
            render.print_shapes(shapes, render.standard_output())
            for shape in shapes:
                warnings = [f"{shape.name}: {text}" for text in shape.warnings]
                render.print_warnings(warnings, render.standard_error())
        failures.check()
