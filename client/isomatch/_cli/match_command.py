"""``isomatch match``: a source matched with one target, or several."""

from pathlib import Path

import typer

from isomatch._cli.batch_run import MatchFolder, run_batch
from isomatch._cli.exit_codes import Failures, connected
from isomatch._cli.job_runs import run
from isomatch._cli.options import (
    AsJson,
    FileFormat,
    MatchOutput,
    Picture,
    SeenFrom,
    Source,
    Targets,
    Url,
    Wait,
    names_prototype,
)
from isomatch._cli.output_files import check_outputs, names_folder, output_given
from isomatch._cli.parameter_options import MATCH
from isomatch._cli.parameter_table import takes
from isomatch._cli.uploads import uploaded, usable
from isomatch._http import DEFAULT_URL
from isomatch._models import MatchParameters, Shape
from isomatch._operations.result_files import MATCH_FORMATS, shows_dense_map


@takes(MATCH)
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
