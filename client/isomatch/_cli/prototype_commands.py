"""``isomatch prototype``: prototypes of classes of shapes."""

from pathlib import Path
from typing import Annotated
from zipfile import ZipFile, is_zipfile

import typer

from isomatch._cli.examples import LEARN_EXAMPLES
from isomatch._cli.exit_codes import EXIT_CODES, Failures, connected
from isomatch._cli.job_runs import print_listing, run
from isomatch._cli.options import AsJson, Limit, Meshes, Quiet, Url, Wait, output_option
from isomatch._cli.output_files import check_outputs, file_named, writable
from isomatch._cli.parameter_options import LEARN
from isomatch._cli.parameter_table import takes
from isomatch._cli.prototype_rendering import print_prototype, print_prototypes
from isomatch._cli.render import standard_error, standard_output
from isomatch._cli.uploads import named_upload, uploaded
from isomatch._cli.usage_errors import Commands
from isomatch._http import DEFAULT_URL
from isomatch._models import PrototypeParameters

PrototypeId = Annotated[str, typer.Argument(help="Id of the prototype.")]
Name = Annotated[str | None, typer.Option(help="Name. An existing name gets its next version.")]

prototypes = typer.Typer(
    name="prototype",
    cls=Commands,
    help="Learn, list, show, exchange and delete prototypes of classes of shapes.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
)


@prototypes.command(epilog=LEARN_EXAMPLES)
@takes(LEARN, without=["correspondence"])
def learn(
    meshes: Meshes,
    parameters: PrototypeParameters,
    name: Name = None,
    shared_connectivity: Annotated[
        bool,
        typer.Option(
            "--shared-connectivity",
            help="Vertex i of every mesh corresponds; by default the meshes are matched.",
        ),
    ] = False,
    output: Annotated[Path | None, output_option()] = None,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Learn a prototype from meshes of one class; points are sampled on the first mesh."""
    check_outputs(meshes, wait, output)
    if shared_connectivity:
        parameters["correspondence"] = "shared_connectivity"
    with connected(url, as_json) as client:
        shapes = uploaded(client, meshes, as_json)
        run(
            lambda: client.learn_prototype(shapes, name=name, **parameters),
            as_json,
            output,
            None,
            wait=wait,
            page=client.base_url,
        )


@prototypes.command("list")
def list_prototypes(
    name: Annotated[str | None, typer.Option(help="Only the versions of this name.")] = None,
    limit: Limit = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    url: Url = DEFAULT_URL,
) -> None:
    """List the prototypes, all versions of all names, newest first."""
    with connected(url, as_json) as client:
        print_listing(client.prototypes(name), as_json, quiet, print_prototypes, limit)


@prototypes.command()
def show(prototype_id: PrototypeId, as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """Show the record of a prototype."""
    with connected(url, as_json) as client:
        prototype = client.prototype(prototype_id)
        if as_json:
            typer.echo(prototype.model_dump_json())
        else:
            print_prototype(prototype, standard_output())


@prototypes.command()
def download(
    prototype_id: PrototypeId,
    path: Annotated[
        Path,
        typer.Argument(
            parser=file_named,
            metavar="FILE",
            callback=writable,
            help="The NumPy file (.npz) to write.",
        ),
    ],
    url: Url = DEFAULT_URL,
) -> None:
    """Write a prototype to a file, which can be uploaded to any isomatch service."""
    with connected(url) as client:
        client.download_prototype(prototype_id, path)


def _archive(given: Path) -> Path:
    """Refuse arrays of something else, such as maps, and name what they lack."""
    if is_zipfile(given):
        with ZipFile(given) as archive:
            if "about.npy" not in archive.namelist():
                raise typer.BadParameter(
                    f"{str(given)!r} is no prototype: it has no array 'about'; give a file that"
                    " `isomatch prototype download` has written"
                )
    return given


@prototypes.command()
def upload(
    archive: Annotated[
        Path,
        typer.Argument(
            exists=True,
            dir_okay=False,
            readable=True,
            callback=_archive,
            help="A prototype, .npz.",
        ),
    ],
    name: Name = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    url: Url = DEFAULT_URL,
) -> None:
    """Upload a prototype; the same file again gives the same prototype."""
    with connected(url, as_json) as client:
        with named_upload(str(archive), as_json):
            prototype = client.upload_prototype(archive, name)
        if as_json:
            typer.echo(prototype.model_dump_json())
        elif quiet:
            typer.echo(prototype.id)
        else:
            print_prototypes([prototype], standard_output())


@prototypes.command()
def delete(
    prototype_ids: Annotated[list[str], typer.Argument(help="Ids of prototypes.")],
    url: Url = DEFAULT_URL,
) -> None:
    """Delete prototypes; their queued matches will fail."""
    with connected(url) as client:
        failures = Failures(as_json=False)
        for prototype_id in prototype_ids:
            with failures.named(prototype_id):
                client.delete_prototype(prototype_id)
                standard_error().print(f"prototype {prototype_id} is deleted")
        failures.check()
