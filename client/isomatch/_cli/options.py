"""Arguments and options that commands share, and their checks."""

import os
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import Annotated, Any, Final, TypeVar

import typer

from isomatch._http import URL_VARIABLE, url_or_default
from isomatch._models import StructureChoice, is_prototype_id, is_shape_id, structure_choice
from isomatch._operations.result_files import check_format
from isomatch._operations.results import ENDINGS, View

WEIGHT_TOLERANCE: Final = 1e-3
"""Greatest error of a sum of weights, as in the service."""

_SEPARATORS: Final = ("/", os.sep)
"""Ends of the names of folders."""

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


def file_named(given: str) -> Path:
    """Return the path of a file; refuse the name of a folder, and "-"."""
    if given.endswith(_SEPARATORS):
        raise typer.BadParameter(f"{given!r} is a folder; name a file")
    return Path(given)


def names_folder(given: str) -> bool:
    """Return whether a path ends like a folder's, or is one that exists."""
    return given.endswith(_SEPARATORS) or Path(given).is_dir()


def writable(given: Path | None) -> Path | None:
    """Return the name of a file to write, if its folder exists: checked before the work."""
    if given is not None:
        _refuse_dash(given)
    if given is not None and not given.parent.is_dir():
        raise typer.BadParameter(f"there is no folder {str(given.parent)!r}")
    if given is not None and given.is_dir():
        raise typer.BadParameter(f"{str(given)!r} is a folder")
    return None if given is None else _permitted(given)


def _refuse_dash(given: Path) -> None:
    if str(given) == "-":
        raise typer.BadParameter(
            "the standard output takes no files: use --json for a result as JSON there, or name a"
            " file"
        )


def _permitted(given: Path) -> Path:
    """Refuse a file or a folder that cannot be written, or made."""
    found = given.resolve()
    try:
        # Permissions do not tell: root has all, and /proc takes no files.
        if found.is_dir():
            with TemporaryFile(dir=found):
                pass
        elif found.is_file():
            with found.open("ab"):
                pass
        elif not found.exists():
            found.touch(exist_ok=False)
            found.unlink()
    except OSError as error:
        raise typer.BadParameter(f"{str(given)!r} cannot be written: {error.strerror}") from error
    return given


def output_given(given: Path | None, formats: Sequence[str] = ENDINGS) -> Path | None:
    """Return the file of ``--output``, which is a file only with some arguments."""
    with _of_option("--output"):
        return _of_formats(writable(given), formats)


@contextmanager
def _of_option(name: str) -> Iterator[None]:
    try:
        yield
    except typer.BadParameter as error:
        error.param_hint = name
        raise


def picture_given(given: Path | None) -> Path | None:
    """Return the name of a PNG file to write; see :func:`writable`."""
    if given is not None and given.suffix.lower() != ".png":
        raise typer.BadParameter(f"pictures are PNG files: {given.stem}.png")
    return writable(given)


def registered_given(given: Path | None) -> Path | None:
    """Return the name of a file of a registered surface; see :func:`writable`."""
    if given is not None and given.suffix.lower() not in (".ply", ".obj", ".glb"):
        raise typer.BadParameter(f"registered surfaces are PLY, OBJ or GLB files: {given.stem}.ply")
    return writable(given)


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


def folder_given(given: Path) -> Path:
    """Refuse a file, a folder that cannot be written, and one in a folder that does not exist."""
    _refuse_dash(given)
    if given.exists() and not given.is_dir():
        raise typer.BadParameter(f"{str(given)!r} is not a folder")
    if not given.parent.is_dir():
        raise typer.BadParameter(f"there is no folder {str(given.parent)!r}")
    return _permitted(given)


def output_folder_given(given: Path) -> Path:
    """Return the folder of ``--output``, which is a folder only with some arguments."""
    with _of_option("--output"):
        return folder_given(given)


def files_given(folder: Path, names: Iterable[str], inputs: Collection[str | Path]) -> None:
    """Refuse names of files of a folder, which may be missing, that cannot or must not be written.

    Parameters
    ----------
    folder
        Where they are written.
    names
        Their names.
    inputs
        Files that the command reads, among others: they must not be overwritten.
    """
    if folder.is_dir():
        with _of_option("--output"):
            for name in names:
                writable(folder / name)
                _no_input(folder / name, inputs)


def _no_input(file: Path, inputs: Collection[str | Path]) -> None:
    """Refuse to write a file that the command reads, whichever name or link leads to it."""
    if file.exists() and any(Path(one).is_file() and file.samefile(one) for one in inputs):
        raise typer.BadParameter(
            f"{str(file)!r} is read by this command, and would be overwritten; choose another name"
            " or folder"
        )


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
        return _of_formats(writable(given), formats)

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


def _of_formats(file: Path | None, formats: Sequence[str]) -> Path | None:
    """Refuse an ending that this result is not written with; without one it is JSON."""
    try:
        if file is not None:
            check_format(file, formats)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    return file


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


def check_outputs(
    inputs: Collection[str | Path], wait: bool, output: Path | None, picture: Path | None = None
) -> None:
    """Refuse files of a result that is not awaited, and those that are read.

    Raises
    ------
    typer.BadParameter
        There is one; the message says what to do.
    """
    for name, file in (("--output", output), ("--picture", picture)):
        if file is not None and not wait:
            raise typer.BadParameter(
                "with --no-wait there is no result to write; leave it out, and use `isomatch jobs"
                f" result ID {name} {file.name}` later (of several targets, with ID-1, ID-2, ...)",
                param_hint=name,
            )
        if file is not None:
            with _of_option(name):
                _no_input(file, inputs)


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
