"""``isomatch shapes``: the uploaded shapes."""

from typing import Annotated

import typer

from isomatch._cli.exit_codes import EXIT_CODES, Failures, connected
from isomatch._cli.job_runs import print_listing
from isomatch._cli.options import AsJson, Limit, Quiet, Url
from isomatch._cli.render import print_shapes, standard_error
from isomatch._cli.usage_errors import Commands
from isomatch._http import DEFAULT_URL

shapes = typer.Typer(name="shapes", cls=Commands, epilog=EXIT_CODES, invoke_without_command=True)


@shapes.callback()
def shapes_or_command(
    context: typer.Context,
    limit: Limit = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    url: Url = DEFAULT_URL,
) -> None:
    """List the uploaded shapes, newest first, or delete some."""
    if context.invoked_subcommand is None:
        list_them(limit, as_json, quiet, url)


@shapes.command("list")
def list_them(
    limit: Limit = None, as_json: AsJson = False, quiet: Quiet = False, url: Url = DEFAULT_URL
) -> None:
    """List the uploaded shapes, newest first, as `isomatch shapes` does."""
    with connected(url, as_json) as client:
        print_listing(client.shapes(), as_json, quiet, print_shapes, limit)


@shapes.command()
def delete(
    shape_ids: Annotated[list[str], typer.Argument(help="Ids of shapes.")],
    url: Url = DEFAULT_URL,
) -> None:
    """Delete shapes; their queued jobs will fail, results stay."""
    with connected(url) as client:
        failures = Failures(as_json=False)
        for shape_id in shape_ids:
            with failures.named(shape_id):
                client.delete_shape(shape_id)
                standard_error().print(f"shape {shape_id} is deleted")
        failures.check()
