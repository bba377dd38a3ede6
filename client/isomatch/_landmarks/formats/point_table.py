"""Tables of points, ``.csv``: a landmark in each row, as label, x, y, z.

The first line names the columns, or is missing. Columns are delimited by commas, semicolons or tab
stops; decimals may follow a comma. Control points that 3D Slicer exports have columns l, p, s or
r, a, s, which name the coordinate system, and `defined`. A column `specimen`, as in the table of
``isomatch landmarks``, gives a set for each specimen.
"""

import csv
import io
from collections.abc import Mapping
from typing import Final

from isomatch._landmarks.formats.reading import (
    CoordinateSystem,
    FormatError,
    check_named_once,
    is_number,
    position,
    table,
)
from isomatch._landmarks.landmark_set import LandmarkSet

_AXES: Final[tuple[tuple[tuple[str, str, str], CoordinateSystem | None], ...]] = (
    (("x", "y", "z"), None),
    (("l", "p", "s"), "LPS"),
    (("r", "a", "s"), "RAS"),
)
_DIRECTIONS: Final = tuple(axis for axes, _ in _AXES for axis in axes)
_LABELS: Final = ("label", "name", "landmark", "id")
_SPECIMEN: Final = "specimen"


def names_axes(first: list[str]) -> bool:
    """Return whether the first row of a table names columns of coordinates."""
    names = {name.lower() for name in first}
    return any(set(axes) <= names for axes, _ in _AXES)


def read(text: str, coordinates: CoordinateSystem) -> tuple[LandmarkSet, ...]:
    """Read a file; landmarks whose coordinates are empty or NA are missing.

    Parameters
    ----------
    text
        Of the file. Columns x, y, z have the coordinates of the mesh.
    coordinates
        Coordinate system of the mesh, to which columns l, p, s or r, a, s are converted.

    Raises
    ------
    FormatError
        It is no such file; with the line.
    """
    rows = table(text)
    if not rows:
        return ()
    width = len(rows[0][1])
    columns: Mapping[str, int] = {"label": 0, "x": 1, "y": 2, "z": 3}
    if names_axes(rows[0][1]):
        names = [name.lower() for name in rows[0][1]]
        check_named_once(names, (*_LABELS, *_DIRECTIONS, _SPECIMEN), rows[0][0])
        columns = {name: names.index(name) for name in names}
        rows = rows[1:]
    elif len(rows[0][1]) == 3:
        columns = {"x": 0, "y": 1, "z": 2}
    axes, system = next(found for found in _AXES if set(found[0]) <= set(columns))
    named = _column_of_labels(columns, rows)
    specimens: dict[str, list[tuple[str, tuple[float, ...] | None]]] = {}
    for line, entries in rows:
        if len(entries) < width or any(entries[width:]):
            hint = "; with decimal commas delimit columns by semicolons"
            raise FormatError(
                f"{len(entries)} entries, but {width} columns{hint * (len(entries) > width)}", line
            )
        place = position([entries[columns[axis]] for axis in axes], line)
        if "defined" in columns and entries[columns["defined"]] == "0":
            place = None
        label = "" if named is None else entries[named]
        specimen = entries[columns[_SPECIMEN]] if _SPECIMEN in columns else ""
        points = specimens.setdefault(specimen, [])
        points.append((label or str(len(points) + 1), place))
    found = [LandmarkSet.of(points, name) for name, points in specimens.items()]
    return tuple(one if system in (None, coordinates) else one.flipped() for one in found)


def write(landmarks: LandmarkSet) -> str:
    """Return landmarks as a file; the coordinates of those that are missing are empty.

    A number takes the place of a blank label: readers skip a row without any entry.
    """
    out = io.StringIO()
    # The writer does not quote a carriage return alone, and the reader would end the line there.
    broken = any("\r" in label for label in landmarks.labels)
    rows = csv.writer(
        out, lineterminator="\n", quoting=csv.QUOTE_ALL if broken else csv.QUOTE_MINIMAL
    )
    rows.writerow(("label", "x", "y", "z"))
    places = zip(landmarks.labels, landmarks.positions.tolist(), landmarks.present, strict=True)
    for number, (label, place, there) in enumerate(places, start=1):
        named = label if label.strip() else number
        rows.writerow((named, *(place if there else ("", "", ""))))
    return out.getvalue()


def _column_of_labels(columns: Mapping[str, int], rows: list[tuple[int, list[str]]]) -> int | None:
    """Return the column of the labels; None if the landmarks are numbered."""
    named = next((columns[name] for name in _LABELS if name in columns), None)
    unnamed = columns.get("")
    if named is not None or unnamed is None:
        return named
    # R and pandas write names of rows without a heading, and number rows that have none.
    entries = [row[unnamed] for _, row in rows if unnamed < len(row)]
    return None if all(map(is_number, entries)) else unnamed
