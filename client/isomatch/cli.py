"""The command line: ``isomatch match a.off b.obj`` and what goes with it."""

import sys
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from isomatch._cli import (
    COMPARE_EXAMPLES,
    EXIT_CODES,
    FORMATS,
    LANDMARKS_EXAMPLES,
    MAPS_EXAMPLES,
    MATCH_EXAMPLES,
    REGISTER_EXAMPLES,
    TRANSFER_EXAMPLES,
    AsJson,
    Commands,
    Failures,
    FileFormat,
    MatchFolder,
    MatchOutput,
    Meshes,
    Picture,
    Quiet,
    SeenFrom,
    Source,
    Targets,
    Url,
    Wait,
    check_outputs,
    class_of,
    connected,
    echo_models,
    jobs,
    landmarks,
    leave,
    maps,
    mcp,
    named_upload,
    names_folder,
    names_prototype,
    output_given,
    output_option,
    parameter_options,
    prototypes,
    register,
    render,
    run,
    run_batch,
    shapes,
    takes,
    transfer,
    uploaded,
    usable,
)
from isomatch._cli import serve as start_service
from isomatch._http import DEFAULT_URL
from isomatch._models import DissimilarityParameters, MatchParameters, Shape
from isomatch._operations.result_files import COMPARE_FORMATS, MATCH_FORMATS, shows_dense_map

app = typer.Typer(
    name="isomatch",
    cls=Commands,
    help="Minimum-distortion correspondence of non-rigid shapes, computed by an isomatch service."
    " ISOMATCH_URL names its address, ISOMATCH_API_KEY holds the API key, if it needs one.",
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
app.add_typer(shapes)


@app.command(epilog=MATCH_EXAMPLES)
@takes(parameter_options.MATCH)
def match(
    source: Source,
    targets: Targets,
    parameters: MatchParameters,
    picture: Picture = None,
    view: SeenFrom = None,
    output: MatchOutput = None,
    file_format: FileFormat = None,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Match two meshes, or a prototype and a mesh, and print the correspondences.

    With several targets, or a folder as --output, the source is matched with each of them, as one
    job, and a summary is printed. Parameters that are left out take the service's defaults.
    """
    dense = bool(parameters.get("dense"))
    if view is not None and picture is None:
        raise typer.BadParameter("it needs --picture FILE", param_hint="--view")
    file = None if output is None else Path(output)
    check_outputs([source, *targets], wait, file, picture)
    folder = None
    in_folder = output is not None and names_folder(output)
    if len(targets) > 1 or file_format is not None or in_folder:
        if picture is not None:
            message = "in a folder there are pictures by --output FOLDER --format png"
            raise typer.BadParameter(message, param_hint="--picture")
        folder = MatchFolder.checked(output, source, targets, file_format, dense)
    elif file is not None:
        output_given(file, MATCH_FORMATS)
        if shows_dense_map(file) and not dense:
            message = f"{file.suffix} shows a map of all vertices; add --dense"
            raise typer.BadParameter(message, param_hint="--output")
    with connected(url, as_json) as client:
        # The result of a single match, which is waited for, has the repairs.
        repairs = folder is not None or not wait
        first: Shape | str = source
        if not names_prototype(source):
            (first,) = uploaded(client, [source], as_json, repairs)
        failures = Failures(as_json)
        given = usable(client, targets, failures, repairs)
        if folder is not None:
            run_batch(client, first, given, parameters, folder, as_json, wait)
            failures.check()
            return
        ((_, second),) = given
        run(
            lambda: client.match(first, second, **parameters),
            as_json,
            file,
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
            "--labels-from-names",
            help="A mesh's class is its file's name up to the first digit, or, without a digit, up"
            " to the first -, _ or blank.",
        ),
    ] = False,
    labels: Annotated[
        str | None,
        typer.Option(help="Class of each mesh, as in cat,cat,dog: retrieval is scored by them."),
    ] = None,
    picture: Picture = None,
    output: Annotated[Path | None, output_option(*COMPARE_FORMATS)] = None,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Compare meshes, all with all, and print how dissimilar they are."""
    check_outputs(meshes, wait, output, picture)
    if labels_from_names and labels is not None:
        raise typer.BadParameter("give --labels or --labels-from-names, not both")
    classes = None if labels is None else labels.split(",")
    with connected(url, as_json) as client:
        shapes = uploaded(client, meshes, as_json)
        if labels_from_names:
            classes = [class_of(shape.name) for shape in shapes]
            if len(set(classes)) == 1 and not as_json:
                typer.echo(
                    f"warning: all names are of one class, {classes[0]!r}: retrieval always finds"
                    " a shape of the same class, so its scores say nothing",
                    err=True,
                )
        run(
            lambda: client.dissimilarities(shapes, classes, **parameters),
            as_json,
            output,
            picture,
            wait,
            client.base_url,
        )


app.command(epilog=TRANSFER_EXAMPLES)(transfer)
app.command(epilog=LANDMARKS_EXAMPLES)(landmarks)
app.command(epilog=REGISTER_EXAMPLES)(register)
app.command(epilog=MAPS_EXAMPLES)(maps)
app.command()(mcp)


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
    """Upload meshes; the same file again costs nothing. One that cannot be read is named."""
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
