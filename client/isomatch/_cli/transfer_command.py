"""``isomatch transfer``: attributes and landmarks carried along a match."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Final, cast

import typer

from isomatch._cli.exit_codes import connected
from isomatch._cli.job_runs import cancelled_by_interrupt, job_given, run
from isomatch._cli.options import (
    OUTPUT,
    AsJson,
    Url,
    Wait,
    landmark_points,
    names_shape,
    shapes_given,
)
from isomatch._cli.output_files import check_outputs, file_named, output_given
from isomatch._cli.parameter_options import MATCH
from isomatch._cli.parameter_table import takes
from isomatch._cli.transfer_checks import READ, Carried
from isomatch._cli.uploads import named_upload, uploaded
from isomatch._clients import Client
from isomatch._errors import JobFailed, ProblemError
from isomatch._http import DEFAULT_URL
from isomatch._models import Attributes, MatchParameters
from isomatch._operations.result_files import TRANSFER_FORMATS
from isomatch._results import KINDS, Direction, Element, TransferKind

Along = Annotated[
    list[str],
    typer.Argument(
        metavar="MATCH|SOURCE TARGET [VALUES]",
        help="The id of a match with --dense, or two meshes that are matched first; then a file of"
        " attributes (NPZ, CSV, PLY, OBJ, GLB, or one label a line: SEG, TXT), row i of vertex or"
        " face i, unless the mesh has them.",
    ),
]
What = Annotated[str, typer.Option("--what", help=f"Kind of the values: {', '.join(KINDS)}.")]
Back = Annotated[
    bool,
    typer.Option("--back", help="Transfer from target to source."),
]
On = Annotated[
    Element | None,
    typer.Option(
        "--on",
        help="Whether vertices or faces of the other shape take the values; by default what the"
        " values are of.",
    ),
]
Names = Annotated[
    list[str] | None,
    typer.Option("--name", help="Only this attribute, or joint; may be repeated."),
]
Influences = Annotated[
    int | None, typer.Option(min=1, help="Joints that each vertex keeps, of skinning weights.")
]
Points = Annotated[
    list[str] | None,
    typer.Option(
        "--point",
        help="A landmark: a vertex, as in 17, or a point between three, as in 4:0.2,9:0.3,7:0.5;"
        " may be repeated.",
    ),
]
Written = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        parser=file_named,
        metavar="FILE",
        help="Write the result to this file: JSON, or, as the kind of values allows, NPZ, CSV, PLY,"
        " OBJ, GLB or ZIP by its ending.",
        rich_help_panel=OUTPUT,
    ),
]

_OF_VALUES: Final = ("--name", "--on")

TAKEN: Final[Mapping[TransferKind, tuple[str, ...]]] = {
    "scalars": _OF_VALUES,
    "vectors": _OF_VALUES,
    "colors": _OF_VALUES,
    "labels": _OF_VALUES,
    "skinning": (*_OF_VALUES, "--influences"),
    "landmarks": ("--point",),
}
"""Options that a kind takes; what is not here takes none of them."""

MATCHING: Final = tuple(
    one for one in MATCH if one.name in ("partial", "landmarks", "largest_component")
)
"""Parameters of the match of two meshes."""


@takes(MATCHING)
def transfer(
    along: Along,
    what: What,
    parameters: MatchParameters,
    back: Back = False,
    on: On = None,
    name: Names = None,
    influences: Influences = None,
    point: Points = None,
    output: Written = None,
    as_json: AsJson = False,
    wait: Wait = True,
    url: Url = DEFAULT_URL,
) -> None:
    """Transfer values of vertices or faces from one shape of a match to the other."""
    if what not in KINDS:
        raise typer.BadParameter(f"one of {', '.join(KINDS)}", param_hint="--what")
    kind = cast(TransferKind, what)
    output_given(output, TRANSFER_FORMATS[kind])
    check_outputs(along, wait, output)
    meshes, file = _along(along)
    values: Attributes | str | None = None if file is None else _values_given(file, kind)
    direction: Direction = "target_to_source" if back else "source_to_target"
    _check_options(kind, {"--point": point, "--name": name, "--on": on, "--influences": influences})
    points = landmark_points(point)
    if parameters and len(meshes) < 2:
        named = next(one.flag for one in MATCHING if one.name in parameters)
        raise typer.BadParameter("the match is made already; leave it out", param_hint=named)
    with connected(url, as_json) as client:
        if len(meshes) > 1:
            carried = Carried(kind, back, file, on, name or (), points)
            match, values = _matched(client, meshes, parameters, as_json, carried)
        else:
            match = job_given(client, meshes[0]).id
        with _match_kept(match, quiet=as_json or len(meshes) < 2):
            run(
                lambda: client.transfer(
                    match,
                    values,
                    what=kind,
                    direction=direction,
                    on=on,
                    names=name or (),
                    influences=influences,
                    points=points,
                ),
                as_json,
                output,
                None,
                wait=wait,
                page=client.base_url,
            )


@contextmanager
def _match_kept(match: str, quiet: bool) -> Iterator[None]:
    """Print, unless `quiet`, that the shapes need not be matched again if the transfer fails."""
    try:
        yield
    except (ProblemError, JobFailed):
        if not quiet:
            typer.echo(f"the match is kept: `isomatch transfer {match} ...` uses it", err=True)
        raise


def _along(given: list[str]) -> tuple[list[str], str | None]:
    """Return the id of a match, or two meshes, and the file of values."""
    first, *rest = given
    if len(given) > 3:
        raise typer.BadParameter("give a match or two meshes, and at most one file of values")
    # After an id, another id is that of a mesh, and a file has values.
    if not Path(first).is_file() and (not rest or (len(rest) < 2 and not names_shape(rest[0]))):
        return [first], rest[0] if rest else None
    if not rest:
        raise typer.BadParameter("give the id of a match, or two meshes")
    return shapes_given(given[:2]), given[2] if len(given) > 2 else None


def _values_given(file: str, kind: TransferKind) -> str:
    """Refuse a file of values that is not there, or that has none of this kind."""
    if not Path(file).is_file():
        raise typer.BadParameter(f"there is no file {file!r}")
    if kind not in READ:
        raise typer.BadParameter(
            f"{kind} is transferred without a file of values; leave out {file!r}"
        )
    if Path(file).suffix.lower().removeprefix(".") not in READ[kind]:
        formats = ", ".join(f".{one}" for one in READ[kind])
        raise typer.BadParameter(f"{file!r}: files with {kind} are {formats}")
    return file


def _check_options(kind: TransferKind, given: Mapping[str, object]) -> None:
    """Refuse options that the service would refuse once the shapes are matched."""
    if kind == "landmarks" and not given["--point"]:
        raise typer.BadParameter("give the landmarks, as in --point 17", param_hint="--point")
    for option, value in given.items():
        if value and option not in TAKEN.get(kind, ()):
            message = f"{kind} has no such option: leave it out, or change --what"
            raise typer.BadParameter(message, param_hint=option)
    if kind == "skinning" and given["--on"] == "faces":
        raise typer.BadParameter("skinning weights are of vertices", param_hint="--on")


def _matched(
    client: Client,
    meshes: list[str],
    parameters: MatchParameters,
    as_json: bool,
    carried: Carried,
) -> tuple[str, Attributes | None]:
    """Match two meshes if the values fit; return the id of the job, and the uploaded values."""
    source, target = uploaded(client, meshes, as_json)
    carried.check_shapes(source, target)
    values = None
    if carried.file is not None:
        with named_upload(carried.file, as_json):
            values = client.upload_attributes(carried.file)
        carried.check_values(values, source, target)
    parameters["dense"] = True
    with cancelled_by_interrupt(
        lambda: client.match(source, target, **parameters), None, as_json
    ) as job:
        job.result(progress=not as_json)
    return job.id, values
