"""``isomatch transfer``: attributes and landmarks carried along a match."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final, cast

import typer

from isomatch._cli.exit_codes import connected
from isomatch._cli.job_runs import cancelled_by_interrupt, run
from isomatch._cli.options import (
    AsJson,
    Url,
    Wait,
    files_awaited,
    landmark_points,
    output_given,
    output_option,
    shapes_given,
)
from isomatch._cli.uploads import uploaded
from isomatch._clients import Client
from isomatch._http import DEFAULT_URL
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
    typer.Option("--back", help="Carry values of the target to the source, not of the source."),
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
Written = Annotated[Path | None, output_option("npz", "csv", "ply", "obj", "glb", "zip")]

_FORMATS: Final[Mapping[str, tuple[str, ...]]] = {
    "landmarks": ("npz", "csv"),
    "texture": ("npz", "csv", "ply", "obj", "glb", "zip"),
    "uv": ("npz", "csv", "obj", "glb", "zip"),
}
"""Formats of what is carried, where they are not those of `_OF_VALUES`."""

_OF_VALUES: Final = ("npz", "csv", "ply", "obj", "glb")


def transfer(
    along: Along,
    what: What,
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
    """Carry values of the vertices or faces of one shape of a match to the other, along its map."""
    if what not in KINDS:
        raise typer.BadParameter(f"one of {', '.join(KINDS)}", param_hint="--what")
    output_given(output, _FORMATS.get(what, _OF_VALUES))
    files_awaited(wait, output)
    direction: Direction = "target_to_source" if back else "source_to_target"
    points = landmark_points(point)
    with connected(url, as_json) as client:
        match, values = _match_and_values(client, along, as_json)
        run(
            lambda: client.transfer(
                match,
                values,
                what=cast(TransferKind, what),
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


def _match_and_values(client: Client, along: list[str], as_json: bool) -> tuple[str, str | None]:
    """Return the id of the match, which is made of two meshes first, and the file of values."""
    first, *rest = along
    if len(along) > 3:
        raise typer.BadParameter("give a match or two meshes, and at most one file of values")
    if not Path(first).is_file() and len(along) < 3:
        return first, _values(rest[0]) if rest else None
    meshes = shapes_given(along[:2])
    if len(meshes) < 2:
        raise typer.BadParameter("give the id of a match, or two meshes")
    values = _values(along[2]) if len(along) > 2 else None
    source, target = uploaded(client, meshes, as_json)
    with cancelled_by_interrupt(
        lambda: client.match(source, target, dense=True), None, as_json
    ) as job:
        job.result(progress=not as_json)
    return job.id, values


def _values(given: str) -> str:
    if not Path(given).is_file():
        raise typer.BadParameter(f"there is no file {given!r}")
    return given
