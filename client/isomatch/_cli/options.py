"""Arguments and options that commands share, and their checks."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar

import typer

from isomatch._cli.output_files import file_named, of_formats, picture_given, writable
from isomatch._http import URL_VARIABLE, url_or_default
from isomatch._models import StructureChoice, is_prototype_id, is_shape_id, structure_choice
from isomatch._operations.results import ENDINGS, View

WEIGHT_TOLERANCE: Final = 1e-3
"""Greatest error of a sum of weights, as in the service."""


GivenT = TypeVar("GivenT", str, list[str])


def shapes_given(given: GivenT) -> GivenT:
    """Return names of shapes, which are files or ids.

    Raises
    ------
    typer.BadParameter
        One is neither a file nor an id.
    """
    for one in [given] if isinstance(given, str) else given:
        if not Path(one).is_file() and not is_shape_id(one):
            if names_prototype(one):
                raise typer.BadParameter(
                    f"{one!r} is a prototype: only the source of a match can be one"
                )
            raise typer.BadParameter(f"{one!r} is neither a file nor the id of a shape")
    return given


def source_given(given: str) -> str:
    """Return the source of a match: the id of a prototype, or see :func:`shapes_given`."""
    return given if names_prototype(given) else shapes_given(given)


def id_given(given: str | None) -> str | None:
    """Return the id of a shape or a prototype; refuse anything else."""
    if given is None or is_shape_id(given) or is_prototype_id(given):
        return given
    raise typer.BadParameter(
        f"{given!r} is not an id; `isomatch shapes` and `isomatch prototype list` list them"
    )


def names_shape(given: str) -> bool:
    """Return whether a text is the id of a shape, not the name of a file."""
    return is_shape_id(given) and not Path(given).is_file()


def names_prototype(given: str) -> bool:
    """Return whether a text is the id of a prototype, not the name of a file."""
    return is_prototype_id(given) and not Path(given).is_file()


OUTPUT: Final = "Output and service"
"""Heading of the options that all commands have in common."""


def _url_given(given: str) -> str:
    try:
        return url_or_default(given)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


Url = Annotated[
    str,
    typer.Option(
        "--url",
        envvar=URL_VARIABLE,
        callback=_url_given,
        help="Address of the service.",
        rich_help_panel=OUTPUT,
    ),
]
AsJson = Annotated[
    bool,
    typer.Option("--json", help="Print JSON and nothing else.", rich_help_panel=OUTPUT),
]
FORMATS: Final = (
    "OFF, OBJ, PLY, STL, GLB, GLTF, ZIP with textures; points: PLY, LAS, LAZ, XYZ, TXT, CSV"
)
Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", help="Print ids and nothing else.", rich_help_panel=OUTPUT),
]
Limit = Annotated[
    int | None,
    typer.Option("--limit", min=1, metavar="N", help="Print N at most, the newest."),
]
Mesh = Annotated[
    str,
    typer.Argument(callback=shapes_given, help=f"A file ({FORMATS}) or a shape's id."),
]
Source = Annotated[
    str,
    typer.Argument(
        callback=source_given,
        help=f"A file ({FORMATS}), a shape's id or that of a prototype.",
    ),
]
Meshes = Annotated[
    list[str],
    typer.Argument(callback=shapes_given, help=f"Files ({FORMATS}) or shapes' ids."),
]


Targets = Annotated[
    list[str],
    typer.Argument(
        metavar="TARGET...",
        callback=shapes_given,
        help=f"A file ({FORMATS}) or a shape's id, or several: each is matched with the source.",
    ),
]


def output_option(*formats: str) -> Any:
    """Return the option of a file for a result that is written in these formats besides JSON."""

    def checked(given: Path | None) -> Path | None:
        return of_formats(writable(given), formats)

    by_ending = f", or {_either(formats)} by its ending" if formats else ""
    return typer.Option(
        "--output",
        "-o",
        parser=file_named,
        metavar="FILE",
        callback=checked,
        help=f"Write the result to this file: JSON{by_ending}.",
        rich_help_panel=OUTPUT,
    )


def _either(formats: Sequence[str]) -> str:
    return " or ".join(", ".join(formats).upper().rsplit(", ", 1))


Output = Annotated[Path | None, output_option(*ENDINGS[1:])]
MatchOutput = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        metavar="PATH",
        help="Write the result to this file: JSON, or NPZ, CSV, PLY, OBJ or GLB by its ending. CSV"
        " has the matched points alone; JSON and NPZ have the map of all vertices of --dense, too."
        " Of several targets, or if PATH is a folder or ends with /, write a file for each to this"
        " folder, made if missing.",
        rich_help_panel=OUTPUT,
    ),
]
FileFormat = Annotated[
    str | None,
    typer.Option(
        "--format",
        help="Format of the files in the folder: json (default), npz, csv, ply, obj, glb or png.",
        rich_help_panel=OUTPUT,
    ),
]
WhichPicture = Annotated[
    int | None,
    typer.Option(
        "--alternative",
        min=0,
        help="Which answer of a match --picture draws: 0 for the match itself, 1 for the first of"
        " its alternatives.",
        rich_help_panel=OUTPUT,
    ),
]
SeenFrom = Annotated[
    View | None,
    typer.Option(
        "--view",
        help="Side from which --picture shows a match.",
        rich_help_panel=OUTPUT,
    ),
]
Picture = Annotated[
    Path | None,
    typer.Option(
        "--picture",
        callback=picture_given,
        help="Write a picture of the result to this PNG file.",
        rich_help_panel=OUTPUT,
    ),
]
Wait = Annotated[
    bool,
    typer.Option(
        "--wait/--no-wait",
        help="Wait for the result, or print the job's id and leave it to run.",
        rich_help_panel=OUTPUT,
    ),
]


def structure_choices(given: list[str] | None) -> list[StructureChoice]:
    """Return the structures that options name.

    Raises
    ------
    typer.BadParameter
        A parameter has no value.
    """
    try:
        return [structure_choice(text) for text in given or ()]
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def landmark_points(given: list[str] | None) -> list[int | dict[str, Sequence[float]]]:
    """Return the landmarks that ``--point`` names, as in ``17`` or ``4:0.2,9:0.3,7:0.5``.

    Raises
    ------
    typer.BadParameter
        One is neither a vertex nor three with weights of sum 1.
    """
    return [_landmark_point(text) for text in given or ()]


def _landmark_point(text: str) -> int | dict[str, Sequence[float]]:
    try:
        corners = [corner.split(":") for corner in text.split(",")] if ":" in text else []
        vertices = [int(vertex) for vertex, _ in corners] if corners else [int(text)]
        weights = [float(weight) for _, weight in corners]
        # Python reads 1_0 as 10.
        if "_" in text or min(vertices) < 0 or len(weights) not in (0, 3):
            raise ValueError
    except ValueError:
        form = "a landmark is a vertex, as in 17, or three with weights, as in 4:0.2,9:0.3,7:0.5"
        raise typer.BadParameter(f"{form}, not {text}", param_hint="--point") from None
    if not corners:
        return vertices[0]
    if not (min(weights) >= 0.0 and abs(sum(weights) - 1.0) <= WEIGHT_TOLERANCE):
        message = f"the weights of {text} must not be negative, and have the sum 1"
        raise typer.BadParameter(message, param_hint="--point")
    return {"vertices": vertices, "weights": weights}


def landmarks(given: list[str] | None) -> list[tuple[int, int]]:
    """Return the landmarks that options name, as in ``17:203``.

    Raises
    ------
    typer.BadParameter
        One is not a pair of numbers.
    """
    try:
        pairs = [tuple(map(int, text.split(":"))) for text in given or ()]
    except ValueError as error:
        raise typer.BadParameter("a landmark is two vertex numbers, as in 17:203") from error
    if any(len(pair) != 2 for pair in pairs) or "_" in "".join(given or ()):
        raise typer.BadParameter("a landmark is two vertex numbers, as in 17:203")
    return [(pair[0], pair[1]) for pair in pairs]
