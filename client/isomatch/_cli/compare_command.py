"""``isomatch compare``: the dissimilarities of a collection."""

from pathlib import Path
from typing import Annotated

import typer

from isomatch._cli.exit_codes import connected
from isomatch._cli.job_runs import run
from isomatch._cli.options import AsJson, Meshes, Picture, Url, Wait, output_option
from isomatch._cli.output_files import check_outputs
from isomatch._cli.parameter_options import COMPARE
from isomatch._cli.parameter_table import takes
from isomatch._cli.uploads import class_of, uploaded
from isomatch._http import DEFAULT_URL
from isomatch._models import DissimilarityParameters
from isomatch._operations.result_files import COMPARE_FORMATS


@takes(COMPARE)
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
