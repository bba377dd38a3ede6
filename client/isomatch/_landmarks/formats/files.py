"""Reading and writing of files of landmarks, by the ending of their names."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal, TypeAlias, get_args

from isomatch._landmarks.formats import fcsv, markups_json, morphoj, point_table, tps
from isomatch._landmarks.formats.reading import CoordinateSystem, FormatError, table
from isomatch._landmarks.landmark_set import LandmarkSet

LandmarkFormat: TypeAlias = Literal["mrk.json", "fcsv", "csv", "tps", "txt"]
"""Slicer markups, Slicer fiducials, table of points, TPS, MorphoJ; the ending of the name."""

FORMATS: Final[tuple[LandmarkFormat, ...]] = get_args(LandmarkFormat)

PER_SPECIMEN: Final[frozenset[LandmarkFormat]] = frozenset({"mrk.json", "fcsv", "csv"})
"""Formats of which a file is written for one specimen."""

MOST_BYTES: Final = 32 << 20
"""Size above which a file is refused unread."""


def read_landmarks(
    path: str | os.PathLike[str], coordinates: CoordinateSystem = "LPS"
) -> tuple[LandmarkSet, ...]:
    """Read landmarks from a file, in the coordinates of the mesh.

    Parameters
    ----------
    path
        A file ``.mrk.json`` or ``.json``, ``.fcsv``, ``.csv``, ``.tps``, or ``.txt`` (MorphoJ).
    coordinates
        Coordinate system of the mesh files. 3D Slicer stores models in LPS. Positions of Slicer
        markups, which name theirs, are converted to it; all others are taken as they are.

    Returns
    -------
    The landmarks of each specimen in the file: of a table of points, one for each entry of its
    column ``specimen``, if there is one. Formats without labels number landmarks from 1.

    Raises
    ------
    ValueError
        The file is of none of these formats, has no landmarks, or is damaged; the message names
        file and line.
    OSError
        It cannot be read.

    Examples
    --------
    >>> (template,) = isomatch.read_landmarks("template.mrk.json")
    """
    file = Path(path)
    kind = _format_of(file)
    with file.open("rb") as opened:
        content = opened.read(MOST_BYTES + 1)
    try:
        if len(content) > MOST_BYTES:
            raise FormatError(f"larger than {MOST_BYTES >> 20} MiB")
        found = _read(content.decode("utf-8-sig"), kind, coordinates)
        if not any(len(one) for one in found):
            raise FormatError("there are no landmarks in it")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(f"{file}: line {line}: the text is not UTF-8") from error
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error
    return found


def write_landmarks(
    path: str | os.PathLike[str],
    specimens: Sequence[LandmarkSet],
    coordinates: CoordinateSystem = "LPS",
) -> None:
    """Write landmarks to a file, in the coordinates of the mesh.

    Parameters
    ----------
    path
        The file; its ending is the format, as for :func:`read_landmarks`.
    specimens
        One specimen for ``.mrk.json``, ``.fcsv`` and ``.csv``; any number for the others, which
        have no labels.
    coordinates
        Coordinate system of the mesh files, named in files of Slicer markups.

    Raises
    ------
    ValueError
        The name has another ending, or the format has no place for the specimens.
    OSError
        The file cannot be written.
    """
    file = Path(path)
    kind = _format_of(file)
    if kind in PER_SPECIMEN and len(specimens) != 1:
        raise ValueError(f"a file .{kind} has one specimen, not {len(specimens)}")
    if kind == "mrk.json":
        text = markups_json.write(specimens[0], coordinates)
    elif kind == "fcsv":
        text = fcsv.write(specimens[0], coordinates)
    elif kind == "csv":
        text = point_table.write(specimens[0])
    else:
        text = tps.write(specimens) if kind == "tps" else morphoj.write(specimens)
    file.write_text(text, encoding="utf-8", newline="\n")


def append_landmarks(path: str | os.PathLike[str], specimen: LandmarkSet) -> None:
    """Append a specimen to a file ``.tps`` or ``.txt`` (MorphoJ).

    Parameters
    ----------
    path
        A file of specimens, which have as many landmarks.
    specimen
        The landmarks, in the coordinates of its mesh.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    file = Path(path)
    text = tps.write([specimen]) if _format_of(file) == "tps" else morphoj.row_of(specimen)
    with file.open("a", encoding="utf-8", newline="\n") as opened:
        opened.write(text)


def stem_of(path: str | os.PathLike[str]) -> str:
    """Return the name of a file without its folder and ending, ``.mrk.json`` included."""
    return Path(path).name.removesuffix(".mrk.json").rsplit(".", 1)[0]


def _format_of(file: Path) -> LandmarkFormat:
    ending = file.name.lower().rsplit(".", 1)[-1]
    if ending == "json":
        return "mrk.json"
    for known in FORMATS:
        if ending == known:
            return known
    raise ValueError(f"{file}: the name of a file of landmarks ends with .{', .'.join(FORMATS)}")


def _read(
    text: str, kind: LandmarkFormat, coordinates: CoordinateSystem
) -> tuple[LandmarkSet, ...]:
    if kind == "mrk.json":
        return markups_json.read(text, coordinates)
    if kind == "fcsv":
        return fcsv.read(text, coordinates)
    if kind == "tps":
        return tps.read(text)
    # MorphoJ's files may be called .csv, and a table of points .txt.
    rows = table(text)
    if rows and _is_point_table(rows[0][1]):
        return point_table.read(text, coordinates)
    return morphoj.read(text)


def _is_point_table(first: list[str]) -> bool:
    """Return whether a first row is of a table of points; MorphoJ has as many columns of one."""
    if point_table.names_axes(first):
        return True
    return len(first) in (3, 4) and not morphoj.names_landmarks(first)
