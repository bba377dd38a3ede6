"""``isomatch maps``: consistent maps between all meshes of a collection."""

from pathlib import Path
from typing import Annotated

import typer

from isomatch._cli.exit_codes import connected
from isomatch._cli.job_runs import run
from isomatch._cli.options import AsJson, Meshes, Url, Wait, output_option
from isomatch._cli.output_files import check_outputs
from isomatch._cli.uploads import uploaded
from isomatch._http import DEFAULT_URL


def maps(
    meshes: Meshes,
    largest_component: Annotated[
        bool, typer.Option("--largest-component", help="Take the largest of several components.")
    ] = False,
    output: Annotated[Path | None, output_option("npz")] = None,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Map 2 to 16 meshes to one another, consistently, and print the pairs.

    All pairs are matched at all vertices; pairs in doubt are mapped by way of other meshes. The
    output has the result as JSON, or all maps as NPZ. What does not fit is named.
    """
    check_outputs(meshes, wait, output)
    with connected(url, as_json) as client:
        shapes = uploaded(client, meshes, as_json)
        run(
            lambda: client.consistent_maps(shapes, largest_component=largest_component),
            as_json,
            output,
            None,
            wait=wait,
            page=client.base_url,
        )
