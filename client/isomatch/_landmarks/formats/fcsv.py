"""Fiducial lists of 3D Slicer up to version 5, ``.fcsv``.

Comment lines give version, coordinate system and columns. Slicer 4.10 and earlier wrote 0 for RAS
and 1 for LPS. From version 4.13 on rows may end with the status of the position, 2 for defined.
"""

import csv
import io
from typing import Final

from isomatch._landmarks.formats.reading import (
    CoordinateSystem,
    FormatError,
    check_named_once,
    coordinate_system,
    lines_of,
    one_line,
    position,
)
from isomatch._landmarks.landmark_set import LandmarkSet

_COLUMNS: Final = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID"
_DEFINED: Final = "2"
_MISSING: Final = "3"
"""Status of a position that is set, and of a landmark that the specimen lacks."""


def read(text: str, coordinates: CoordinateSystem) -> tuple[LandmarkSet, ...]:
    """Read a file; points whose status is not "defined" are missing.

    Parameters
    ----------
    text
        Of the file. Without a line on the coordinate system it is RAS, as in the first versions.
    coordinates
        Coordinate system of the mesh; positions are converted to it.

    Raises
    ------
    FormatError
        It is no such file; with the line.
    """
    names = _COLUMNS.split(",")
    system: CoordinateSystem = "RAS"
    rows: list[tuple[str, tuple[float, ...] | None]] = []
    remarks: list[str] = []
    for line, content in enumerate(lines_of(text), start=1):
        if content.startswith("#"):
            key, _, value = content[1:].partition("=")
            if key.strip() == "CoordinateSystem":
                system = coordinate_system(value, line)
            elif key.strip() == "columns":
                names = _names(value, line)
        elif content.strip():
            label, place, remark = _point(content, names, line)
            rows.append((label or str(len(rows) + 1), place))
            remarks.append(remark)
    found = LandmarkSet.of(rows, descriptions=tuple(remarks))
    return (found if system == coordinates else found.flipped(),)


def write(landmarks: LandmarkSet, coordinates: CoordinateSystem) -> str:
    """Return landmarks as a file; those that are missing have nan as coordinates.

    Parameters
    ----------
    landmarks
        The landmarks.
    coordinates
        Coordinate system of their positions.
    """
    out = io.StringIO()
    out.write("# Markups fiducial file version = 4.13\n")
    out.write(f"# CoordinateSystem = {coordinates}\n# columns = {_COLUMNS}\n")
    rows = csv.writer(out, lineterminator="\n")
    remarks = landmarks.descriptions or ("",) * len(landmarks)
    for index, (place, label) in enumerate(zip(landmarks.positions, landmarks.labels, strict=True)):
        status = _DEFINED if landmarks.present[index] else _MISSING
        named = one_line(label), one_line(remarks[index]), ""
        rows.writerow((index + 1, *place.tolist(), 0, 0, 0, 1, 1, 1, 0, *named, status, 0))
    return out.getvalue()


def _names(value: str, line: int) -> list[str]:
    names = [name.strip() for name in value.split(",")]
    if not {"x", "y", "z"} <= set(names):
        raise FormatError("there are no columns x, y, z", line)
    check_named_once(names, ("x", "y", "z", "label"), line)
    return names


def _point(content: str, names: list[str], line: int) -> tuple[str, tuple[float, ...] | None, str]:
    """Label, position and description of a row."""
    try:
        (entries,) = csv.reader([content], strict=True)
    except (csv.Error, ValueError) as error:
        raise FormatError(f"not a row of comma-separated values: {error}", line) from error
    if len(entries) < len(names) - 3:
        raise FormatError(f"{len(entries)} entries, but there are {len(names)} columns", line)
    row = dict(zip(names, entries, strict=False))
    status = entries[len(names)].strip() if len(entries) > len(names) else _DEFINED
    place = None
    if status == _DEFINED or not status:
        place = position([row.get(axis, "") for axis in "xyz"], line)
    return row.get("label", "").strip(), place, row.get("desc", "").strip()
