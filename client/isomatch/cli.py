"""The command line: ``isomatch match a.off b.obj`` and what goes with it."""

from importlib.metadata import version
from typing import Annotated

import typer

from isomatch._cli import examples
from isomatch._cli.compare_command import compare
from isomatch._cli.exit_codes import EXIT_CODES
from isomatch._cli.job_commands import jobs
from isomatch._cli.landmark_command import landmarks
from isomatch._cli.maps_command import maps
from isomatch._cli.match_command import match
from isomatch._cli.mcp_command import mcp
from isomatch._cli.prototype_commands import prototypes
from isomatch._cli.register_command import register
from isomatch._cli.serve_command import serve
from isomatch._cli.shape_commands import shapes
from isomatch._cli.structures_command import structures
from isomatch._cli.transfer_command import transfer
from isomatch._cli.upload_command import upload
from isomatch._cli.usage_errors import Commands

app = typer.Typer(
    name="isomatch",
    cls=Commands,
    help="Minimum-distortion correspondence of non-rigid shapes, computed by an isomatch service."
    " ISOMATCH_URL names its address, ISOMATCH_API_KEY holds the API key, if it needs one.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
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
app.command(epilog=examples.MATCH_EXAMPLES)(match)
app.command(epilog=examples.COMPARE_EXAMPLES)(compare)
app.command(epilog=examples.TRANSFER_EXAMPLES)(transfer)
app.command(epilog=examples.LANDMARKS_EXAMPLES)(landmarks)
app.command(epilog=examples.REGISTER_EXAMPLES)(register)
app.command(epilog=examples.MAPS_EXAMPLES)(maps)
for command in (mcp, upload, structures, serve):
    app.command()(command)
