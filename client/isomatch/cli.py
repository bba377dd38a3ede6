"""The command line: ``isomatch match a.off b.obj`` and what goes with it."""

import sys
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Final

import typer

from isomatch._cli import (
    COMPARE_EXAMPLES,
    EXIT_CODES,
    FORMATS,
    LANDMARKS_EXAMPLES,
    MATCH_EXAMPLES,
    REGISTER_EXAMPLES,
    TRANSFER_EXAMPLES,
    AsJson,
    Mesh,
    Meshes,
    Output,
    Picture,
    Quiet,
    SeenFrom,
    Source,
    Url,
    Wait,
    class_of,
    connected,
    echo_models,
    jobs,
    landmarks,
    leave,
    named_upload,
    names_prototype,
    parameter_options,
    prototypes,
    register,
    render,
    run,
    shape_name,
    takes,
    transfer,
    uploaded,
)
from isomatch._cli import serve as start_service
from isomatch._http import DEFAULT_URL
from isomatch._models import DissimilarityParameters, MatchParameters

_SURFACES: Final = (".ply", ".obj", ".glb")

app = typer.Typer(
    name="isomatch",
    help="Minimum-distortion correspondence of non-rigid shapes, computed by an isomatch service.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"isomatch {version('isomatch')}")
        raise typer.Exit


@app.callback()
def _common(
    shown: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    del shown


app.add_typer(jobs)
app.add_typer(prototypes)


@app.command(epilog=MATCH_EXAMPLES)
@takes(parameter_options.MATCH)
def match(
    source: Source,
    target: Mesh,
    parameters: MatchParameters,
    picture: Picture = None,
    view: SeenFrom = None,
    output: Output = None,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Match two meshes, or a prototype and a mesh, and print the correspondences.

    Parameters that are left out take the service's defaults.
    """
    if view is not None and picture is None:
        raise typer.BadParameter("it needs --picture FILE", param_hint="--view")
    if output is not None and output.suffix.lower() in _SURFACES and not parameters.get("dense"):
        message = f"{output.suffix} shows a map of all vertices; add --dense"
        raise typer.BadParameter(message, param_hint="--output")
    with connected(url, as_json) as client:
        first = source if names_prototype(source) else uploaded(client, [source], as_json)[0]
        (second,) = uploaded(client, [target], as_json)
        run(
            lambda: client.match(first, second, **parameters),
            as_json,
            output,
            picture,
            wait=wait,
            page=client.base_url,
            view=view,
        )


@app.command(epilog=COMPARE_EXAMPLES)
@takes(parameter_options.COMPARE)
def compare(
    meshes: Meshes,
    parameters: DissimilarityParameters,
    labels_from_names: Annotated[
        bool,
        typer.Option(
            "--labels-from-names", help="A mesh's class is its file's name up to the first digit."
        ),
    ] = False,
    labels: Annotated[
        str | None,
        typer.Option(help="Class of each mesh, as in cat,cat,dog: retrieval is scored by them."),
    ] = None,
    picture: Picture = None,
    output: Output = None,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Compare meshes, all with all, and print how dissimilar they are."""
    classes = None if labels is None else labels.split(",")
    with connected(url, as_json) as client:
        shapes = uploaded(client, meshes, as_json)
        called = [shape_name(mesh, shape) for mesh, shape in zip(meshes, shapes, strict=True)]
        if labels_from_names:
            classes = [class_of(name) for name in called]
        names = {shape.id: Path(name).stem for shape, name in zip(shapes, called, strict=True)}
        run(
            lambda: client.dissimilarities(shapes, classes, **parameters),
            as_json,
            output,
            picture,
            names,
            wait,
            client.base_url,
        )


app.command(epilog=TRANSFER_EXAMPLES)(transfer)
app.command(epilog=LANDMARKS_EXAMPLES)(landmarks)
app.command(epilog=REGISTER_EXAMPLES)(register)


@app.command()
def upload(
    meshes: Annotated[
        list[str],
        typer.Argument(help=f"Files ({FORMATS}); - is the standard input."),
    ],
    file_type: Annotated[
        str | None, typer.Option(help="Format, where the file's name does not tell: off, ply, ...")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name, instead of the file's.")] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    url: Url = DEFAULT_URL,
) -> None:
    """Upload meshes; the same file again costs nothing."""
    with connected(url, as_json) as client:
        shapes = []
        for mesh in meshes:
            with named_upload(mesh, as_json):
                data = sys.stdin.buffer.read() if mesh == "-" else mesh
                shapes.append(client.upload(data, name, file_type=file_type))
        if as_json:
            echo_models(shape.model_dump_json() for shape in shapes)
        elif quiet:
            typer.echo("\n".join(shape.id for shape in shapes))
        else:
            render.print_shapes(shapes, render.standard_output())
            for shape in shapes:
                warnings = [f"{shape.name}: {text}" for text in shape.warnings]
                render.print_warnings(warnings, render.standard_error())


@app.command()
def structures(as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """List the metrics and descriptors that can be chosen."""
    with connected(url, as_json) as client:
        found = client.structures()
        if as_json:
            typer.echo(found.model_dump_json())
        else:
            render.print_structures(found, render.standard_output())


@app.command()
def shapes(as_json: AsJson = False, quiet: Quiet = False, url: Url = DEFAULT_URL) -> None:
    """List the uploaded shapes, newest first."""
    with connected(url, as_json) as client:
        if as_json:
            echo_models(shape.model_dump_json() for shape in client.shapes())
        elif quiet:
            for shape in client.shapes():
                typer.echo(shape.id)
        else:
            render.print_shapes(client.shapes(), render.standard_output())


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on [127.0.0.1].")] = None,
    port: Annotated[
        int | None, typer.Option(help="Port to listen on, 0 for a free one [8000].")
    ] = None,
) -> None:
    """Run the whole service on this machine until interrupted, where it is installed.

    Settings are environment variables, ISOMATCH_WORKERS, ISOMATCH_DATA_DIR, and so on.
    """
    try:
        code = start_service(host, port)
    except FileNotFoundError as error:
        leave(error)
    raise typer.Exit(code)


if __name__ == "__main__":
    app()
