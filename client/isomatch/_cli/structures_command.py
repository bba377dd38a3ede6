"""``isomatch structures``: the metrics and descriptors of the service."""

import typer

from isomatch._cli.exit_codes import connected
from isomatch._cli.options import AsJson, Url
from isomatch._cli.render import print_structures, standard_output
from isomatch._http import DEFAULT_URL


def structures(as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """List the metrics and descriptors that can be chosen."""
    with connected(url, as_json) as client:
        found = client.structures()
        if as_json:
            typer.echo(found.model_dump_json())
        else:
            print_structures(found, standard_output())
